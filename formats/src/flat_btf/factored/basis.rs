//! The parts `basis`, components for each view and light, and `tables`, those of the base.

use super::base::{Axis, BaseMaterial, BaseTable, BaseTexel, LevelTable, blended_materials};
use super::header::{BASIS_PART, DIFFERENCE_ANGLES, FactoredErrors, FactoredHeader, GROUP, HALF_ANGLES, TABLES_PART};
use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture, half};
use crate::flat_btf::layout::{check_format, words, wrong_extent};

/// Components as integers: for each pair of a view and a light three opponent colours, for each of these all
/// components; and the tables of the base.
#[derive(Debug, Clone, PartialEq)]
pub struct BasisMap {
    header: FactoredHeader,
    base: BaseTable,
    materials: Vec<BaseMaterial>,
    words: Vec<u32>,
    /// Texels of the tables: four halves each.
    tables: Vec<u8>,
}

/// Bytes of a table: four halves per entry.
const TABLE_BYTES: usize = 8 * HALF_ANGLES * DIFFERENCE_ANGLES;

/// Entries of a table as texels: `T` (three) and `A`.
fn texels<'a>(gloss: &'a BaseTable, diffuse: impl Iterator<Item = f32> + 'a) -> impl Iterator<Item = u8> + 'a {
    let entries = gloss.entries().iter().zip(diffuse);
    entries.flat_map(|([r, g, b], factor)| [*r, *g, *b, factor]).flat_map(|c| half::encode(c).to_le_bytes())
}

/// Table of texels.
fn table(texels: &[u8], axis: Axis) -> Result<LevelTable, FormatError> {
    let halves = texels.as_chunks::<2>().0.iter().map(|bytes| half::decode(u16::from_le_bytes(*bytes)));
    let halves: Vec<f32> = halves.collect();
    let entries = halves.as_chunks::<4>().0.iter();
    let gloss = BaseTable::new(entries.clone().map(|[r, g, b, _]| [*r, *g, *b]).collect())?.over(axis);
    LevelTable::new(gloss, entries.map(|[.., factor]| *factor).collect())
}

impl BasisMap {
    /// Creates a basis from the words of its texels, row by row, and the texels of its tables.
    ///
    /// # Errors
    /// Returns an error if the header or a table entry is out of range, or a number of words or texels is wrong.
    pub fn new(header: FactoredHeader, words: Vec<u32>, tables: Vec<u8>) -> Result<Self, FormatError> {
        header.check()?;
        let expected = 4 * Extent::D2(header.basis_extent()).texels();
        if words.len() as u64 != expected {
            let field = format!("words of the part {BASIS_PART}");
            return Err(FormatError::whole(field, words.len().to_string(), format!("{expected}, as the header says")));
        }
        let expected = header.tables_extent().texels() * TexelFormat::Rgba16Float.texel_bytes() as u64;
        if tables.len() as u64 != expected {
            let field = format!("bytes of the part {TABLES_PART}");
            return Err(FormatError::whole(field, tables.len().to_string(), format!("{expected}, as the header says")));
        }
        let axis = |k: usize| if header.axes >> k & 1 == 1 { Axis::Mirror } else { Axis::Half };
        let count = header.tables() as usize;
        let of_level =
            |level: usize, k: usize| table(&tables[(level * count + k) * TABLE_BYTES..][..TABLE_BYTES], axis(k));
        let base = of_level(0, 0)?.gloss;
        let material = |k: usize| {
            let levels = (0..header.table_levels as usize).map(|level| of_level(level, k));
            Ok(BaseMaterial { diffuse: header.albedos[k], tables: levels.collect::<Result<_, FormatError>>()? })
        };
        let materials = (0..header.materials as usize).map(material).collect::<Result<_, FormatError>>()?;
        Ok(Self { header, base, materials, words, tables })
    }

    /// Creates the basis of one or two materials, with equal numbers of tables. The header's numbers of materials and of
    /// levels of tables, its axes and its albedos are replaced.
    ///
    /// # Errors
    /// Returns an error if the header is out of range or has groups, or for another number of materials or tables.
    pub fn of_materials(header: FactoredHeader, materials: &[BaseMaterial]) -> Result<Self, FormatError> {
        let table_levels = materials.first().map_or(1, |material| material.tables.len());
        let uniform = |material: &BaseMaterial| {
            let tables = &material.tables;
            tables.len() == table_levels
                && !tables.is_empty()
                && tables.iter().all(|it| it.gloss.axis() == material.axis())
        };
        if let Some(k) = materials.iter().position(|material| !uniform(material)) {
            let (found, allowed) = (materials[k].tables.len(), format!("{} over one axis", table_levels.max(1)));
            return Err(FormatError::whole(format!("tables of material {k}"), found.to_string(), allowed));
        }
        let axis = |(k, material): (usize, &BaseMaterial)| (material.axis() as u32) << k;
        let axes = materials.iter().enumerate().map(axis).sum();
        let table_levels = table_levels as u32;
        let albedos = std::array::from_fn(|k| materials.get(k).map_or([0.0; 3], |material| material.diffuse));
        let header = FactoredHeader { materials: materials.len() as u32, axes, table_levels, albedos, ..header };
        let of_level = |level: usize| materials.iter().filter_map(move |material| material.tables.get(level));
        let tables = (0..table_levels as usize).flat_map(of_level);
        let tables = tables.flat_map(|table| texels(&table.gloss, table.diffuse.iter().copied())).collect();
        Self::new(header, Vec::new(), tables)
    }

    /// Colour of a texel's base in a view under an unshadowed light, linear RGB relative to a white diffuser that faces
    /// the light, 0 to [`super::MAX_BASE`].
    #[inline]
    pub fn colour(&self, texel: &BaseTexel, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        if self.materials.is_empty() {
            return self.base.colour(texel, view, light);
        }
        blended_materials(&self.materials, texel, view, light)
    }

    /// Materials, if there are any.
    pub fn materials(&self) -> &[BaseMaterial] {
        &self.materials
    }

    /// Creates a basis from a table and integers. `steps(view, light, colour, component)` is called in order; its
    /// results are clamped to -32767 to 32767 for 16-bit components and to -127 to 127 otherwise.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn from_steps(
        header: FactoredHeader,
        base: &BaseTable,
        mut steps: impl FnMut(usize, usize, usize, usize) -> i32,
    ) -> Result<Self, FormatError> {
        let header = FactoredHeader { axes: base.axis() as u32, ..header };
        header.check()?;
        let wide = header.wide_groups as usize * GROUP;
        let stride = 4 * header.texels_per_colour() as usize;
        let lights = header.lights.len();
        let mut words = vec![0; 4 * Extent::D2(header.basis_extent()).texels() as usize];
        for (at, line) in words.chunks_exact_mut(stride.max(1)).enumerate() {
            let (view, light, colour) = (at / 3 / lights, at / 3 % lights, at % 3);
            for component in 0..header.components() {
                let step = steps(view, light, colour, component);
                if component < wide {
                    line[component / 2] |= (step.clamp(-32767, 32767) as u32 & 0xffff) << (16 * (component % 2));
                } else {
                    let byte = component - wide;
                    let word = wide / 2 + byte / 4;
                    line[word] |= (step.clamp(-127, 127) as u32 & 0xff) << (8 * (byte % 4));
                }
            }
        }
        let tables = texels(base, std::iter::repeat(1.0)).collect();
        Self::new(header, words, tables)
    }

    /// Header of the asset.
    pub fn header(&self) -> &FactoredHeader {
        &self.header
    }

    /// Replaces the measured errors in the header.
    #[must_use]
    pub fn with_errors(mut self, errors: FactoredErrors) -> Self {
        self.header.errors = errors;
        self
    }

    /// Table of the base.
    pub fn base(&self) -> &BaseTable {
        &self.base
    }

    /// Words of the texels, row by row; none without components.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// Texels of the tables, four halves each.
    pub fn table_texels(&self) -> &[u8] {
        &self.tables
    }

    /// Integers of an opponent colour in a view under a light, for all components, before multiplication by
    /// [`FactoredHeader::steps`].
    ///
    /// # Panics
    /// Panics if there is no such view, light or colour.
    pub fn integers(&self, view: u32, light: u32, colour: usize) -> impl Iterator<Item = f32> {
        let header = &self.header;
        let stride = 4 * header.texels_per_colour() as usize;
        let pair = view as usize * header.lights.len() + light as usize;
        assert!((light as usize) < header.lights.len() && colour < 3, "light {light}, colour {colour}");
        let line = &self.words[(pair * 3 + colour) * stride..][..header.words() as usize];
        let (wide, narrow) = line.split_at(2 * header.wide_groups as usize);
        let half = |word: &u32| [(*word << 16) as i32 >> 16, *word as i32 >> 16];
        let byte = |word: &u32| [24, 16, 8, 0].map(|shift| (*word << shift) as i32 >> 24);
        wide.iter().flat_map(half).chain(narrow.iter().flat_map(byte)).map(|step| step as f32)
    }

    /// Reads and validates the images of a file with their header: tables, and a basis if there are components.
    pub(in crate::flat_btf) fn from_textures(tables: Texture, basis: Option<&Texture>) -> Result<Self, FormatError> {
        let header = FactoredHeader::from_texture(&tables)?;
        let checked = |texture: &Texture, part, format, extent: Extent| {
            check_format(texture, part, format)?;
            if texture.extent == extent {
                return Ok(());
            }
            Err(wrong_extent(part, texture.extent, format!("a texture of {extent}, as its header says")))
        };
        checked(&tables, TABLES_PART, TexelFormat::Rgba16Float, header.tables_extent())?;
        let all = match (basis, header.groups) {
            (None, 0) => Vec::new(),
            (Some(basis), 1..) => {
                checked(basis, BASIS_PART, TexelFormat::Rgba32Uint, Extent::D2(header.basis_extent()))?;
                words(&basis.texels)
            }
            (found, groups) => {
                let found = if found.is_some() { "a part" } else { "missing" };
                let allowed =
                    if groups > 0 { "a part, as groups requires" } else { "no part, because there are no groups" };
                return Err(FormatError::whole(format!("part {BASIS_PART}"), found, allowed).problem());
            }
        };
        Self::new(header, all, tables.texels)
    }
}
