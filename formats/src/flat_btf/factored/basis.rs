//! The part `basis`: components for each view and light, and the table of the base.

use super::base::{Axis, BaseMaterial, BaseTable, BaseTexel, MAX_BASE, blended_materials};
use super::header::{BASIS_PART, DIFFERENCE_ANGLES, FactoredErrors, FactoredHeader, GROUP, HALF_ANGLES};
use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture};
use crate::flat_btf::layout::{check_format, words, wrong_extent};

/// Components as integers: for each pair of a view and a light three opponent colours, for each of these all
/// components. The table of the base follows.
#[derive(Debug, Clone, PartialEq)]
pub struct BasisMap {
    header: FactoredHeader,
    base: BaseTable,
    materials: Vec<BaseMaterial>,
    words: Vec<u32>,
}

const ENTRIES: usize = HALF_ANGLES * DIFFERENCE_ANGLES;

impl BasisMap {
    /// Creates a basis from the words of its texels, row by row.
    ///
    /// # Errors
    /// Returns an error if the header or a table entry is out of range, or the number of words is wrong.
    pub fn new(header: FactoredHeader, words: Vec<u32>) -> Result<Self, FormatError> {
        header.check()?;
        let expected = 4 * Extent::D2(header.basis_extent()).texels();
        if words.len() as u64 != expected {
            let field = format!("words of the part {BASIS_PART}");
            return Err(FormatError::whole(field, words.len().to_string(), format!("{expected}, as the header says")));
        }
        let first = 4 * header.basis_extent()[0] as usize * header.views.len();
        let colours = words[first..].chunks_exact(4).map(|texel| [texel[0], texel[1], texel[2]].map(f32::from_bits));
        let colours: Vec<[f32; 3]> = colours.collect();
        let tables = header.tables() as usize;
        let axis = |k: usize| if header.axes >> k & 1 == 1 { Axis::Mirror } else { Axis::Half };
        let table = |k: usize| Ok(BaseTable::new(colours[k * ENTRIES..][..ENTRIES].to_vec())?.over(axis(k)));
        let base = table(0)?;
        let material = |k: usize| {
            let diffuse = colours[tables * ENTRIES + k];
            if !diffuse.iter().all(|c| (0.0..=MAX_BASE).contains(c)) {
                let field = format!("diffuse albedo of material {k}");
                return Err(FormatError::whole(field, format!("{diffuse:?}"), format!("numbers of 0 to {MAX_BASE}")));
            }
            Ok(BaseMaterial { diffuse, table: table(k)? })
        };
        let materials = (0..header.materials as usize).map(material).collect::<Result<_, FormatError>>()?;
        Ok(Self { header, base, materials, words })
    }

    /// Creates the basis of one or two materials. The header's number of materials and axes are replaced.
    ///
    /// # Errors
    /// Returns an error if the header is out of range or has groups, or for another number of materials.
    pub fn of_materials(header: FactoredHeader, materials: &[BaseMaterial]) -> Result<Self, FormatError> {
        let axis = |(k, material): (usize, &BaseMaterial)| (material.table.axis() as u32) << k;
        let axes = materials.iter().enumerate().map(axis).sum();
        let header = FactoredHeader { materials: materials.len() as u32, axes, ..header };
        header.check()?;
        let entries = materials.iter().flat_map(|material| material.table.entries());
        let colours = entries.copied().chain(materials.iter().map(|material| material.diffuse));
        let mut words: Vec<u32> = colours.flat_map(|[r, g, b]| [r.to_bits(), g.to_bits(), b.to_bits(), 0]).collect();
        words.resize(4 * Extent::D2(header.basis_extent()).texels() as usize, 0);
        Self::new(header, words)
    }

    /// Colour of a texel's base in a view under an unshadowed light, linear RGB relative to a white diffuser that faces
    /// the light, 0 to [`MAX_BASE`].
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
        let components = header.views.len() * lights * 3 * stride;
        let mut words = vec![0; 4 * Extent::D2(header.basis_extent()).texels() as usize];
        for (texel, entry) in words[components..].chunks_exact_mut(4).zip(base.entries()) {
            texel[..3].copy_from_slice(&entry.map(f32::to_bits));
        }
        for (at, line) in words[..components].chunks_exact_mut(stride.max(1)).enumerate() {
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
        Self::new(header, words)
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

    /// Words of the texels, row by row, including the table.
    pub fn words(&self) -> &[u32] {
        &self.words
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

    /// Reads and validates the image of a file with its header.
    pub(in crate::flat_btf) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let header = FactoredHeader::from_texture(texture)?;
        check_format(texture, BASIS_PART, TexelFormat::Rgba32Uint)?;
        let extent = Extent::D2(header.basis_extent());
        if texture.extent != extent {
            let allowed = format!("a 2D texture of {extent}, as its header says");
            return Err(wrong_extent(BASIS_PART, texture.extent, allowed));
        }
        Self::new(header, words(&texture.texels))
    }
}
