//! Header of a factored flat BTF, the value of the key `brdfc.flat-btf.factored` of its file.

use super::domain::ChromaRange;
use crate::FormatError;
use crate::container::entries::entry;
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::Cursor;
use crate::flat_btf::flat_view::{LIGHTS, MAX_DIRECTIONS, VIEWS, check_directions, direction_entry, read_directions};
use crate::flat_btf::layout::word;
use std::collections::BTreeMap;

/// Key of the header.
pub(crate) const FACTORED: &str = "brdfc.flat-btf.factored";
/// Maximum number of groups of four components.
pub const MAX_GROUPS: u32 = 16;
/// Components per group.
pub const GROUP: usize = 4;
/// Half angles of the base's table: entry `i` is at `|n - h|² / 2 = (i / 47)⁴`, with normal `n` and half vector `h`.
pub const HALF_ANGLES: usize = 48;
/// Difference angles of the base's table: entry `j` is at a cosine of `1 - j / 7`.
pub const DIFFERENCE_ANGLES: usize = 8;
/// Layers of the part `weights` for the base, before the layers of the components.
pub const BASE_LAYERS: u32 = 2;

/// Texels of the residual of shadows.
pub(in crate::flat_btf) const RESIDUAL_FORMAT: TexelFormat = TexelFormat::Rg8Unorm;
pub(super) const BASIS_PART: &str = "basis";
pub(super) const TABLES_PART: &str = "tables";
const VERSION: u32 = 5;
const KIND: &str = "a factored flat BTF";
/// Bytes before the steps.
const FIXED_BYTES: usize = 4 * (9 + 6 + 3 + 3 * MAX_MATERIALS as usize);
/// Maximum diffuse albedo of a material, and maximum colour of a base: above the largest value of a view.
pub const MAX_BASE: f32 = 65_536.0;
/// Maximum number of materials.
pub const MAX_MATERIALS: u32 = 2;

/// Colour differences (ΔE of 1976) from the values before factorisation, over texels that were held out of the fit and
/// all views and lights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct FactoredErrors {
    /// Number of held-out texels that the errors are over.
    pub texels: u32,
    /// Mean over texels visible in the view.
    pub seen_mean: f32,
    /// 95th percentile over the same.
    pub seen_p95: f32,
    /// Maximum over the same.
    pub seen_max: f32,
    /// Mean over all texels, including filled-in values of texels that are not visible in the view.
    pub all_mean: f32,
    /// 95th percentile over the same.
    pub all_p95: f32,
}

/// Header of a factored flat BTF.
#[derive(Debug, Clone, PartialEq)]
pub struct FactoredHeader {
    /// `T`, texels per side, 1 to 8192.
    pub size: u32,
    /// Number of mipmap levels of the weights.
    pub levels: u32,
    /// `G`, number of groups of four components, 0 to [`MAX_GROUPS`]. Without groups there are no views and lights.
    pub groups: u32,
    /// Number of groups for which the basis has 16 bits; the others have 8.
    pub wide_groups: u32,
    /// `R`, cells per side of the residual of shadows, 0 to [`FactoredHeader::size`]; 0 if there is none.
    pub residual: u32,
    /// Polar angle, 0 to π/2, and azimuth, [0, 2π), of all views, radians.
    pub views: Vec<[f32; 2]>,
    /// Same for all lights.
    pub lights: Vec<[f32; 2]>,
    /// Range of the colours of its texels.
    pub chroma: ChromaRange,
    /// Number of materials, 0 to [`MAX_MATERIALS`]: without, texels have diffuse and glossy albedos and share one table;
    /// with, they have a tint, and there are no groups.
    pub materials: u32,
    /// Axes of the tables, bit by bit: 1 is [`super::Axis::Mirror`].
    pub axes: u32,
    /// Number of mipmap levels with tables of their own, 1 to [`FactoredHeader::levels`]: 1 without materials.
    pub table_levels: u32,
    /// Diffuse albedos of the materials, linear RGB, 0 to [`MAX_BASE`]; 0 where there is none.
    pub albedos: [[f32; 3]; MAX_MATERIALS as usize],
    /// Step sizes of the basis: for each opponent colour, for all components.
    pub steps: [Vec<f32>; 3],
    /// Errors from factorisation, at held-out texels.
    pub errors: FactoredErrors,
}

fn rejected(field: &str, found: impl ToString, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("{FACTORED} {field}"), found.to_string(), allowed.into())
}

impl FactoredHeader {
    /// Number of tables of a level.
    pub fn tables(&self) -> u32 {
        self.materials.max(1)
    }

    /// `K`, number of components.
    pub fn components(&self) -> usize {
        self.groups as usize * GROUP
    }

    /// Words of the basis for one opponent colour of a pair of a view and a light: two per 16-bit group, otherwise one.
    pub fn words(&self) -> u32 {
        self.groups + self.wide_groups
    }

    /// Texels of four words for one opponent colour.
    pub fn texels_per_colour(&self) -> u32 {
        self.words().div_ceil(4)
    }

    /// Columns and rows of the basis: one row per view. Without components there is no basis.
    pub fn basis_extent(&self) -> [u32; 2] {
        [self.lights.len() as u32 * 3 * self.texels_per_colour(), self.views.len() as u32]
    }

    /// Difference angles, half angles of all tables of a level, and levels.
    pub fn tables_extent(&self) -> Extent {
        Extent::D3([DIFFERENCE_ANGLES as u32, HALF_ANGLES as u32 * self.tables(), self.table_levels])
    }

    /// Columns, rows and layers of the weights, including the layers of the base.
    pub fn weights_extent(&self) -> Extent {
        Extent::D2Array([self.size, self.size, BASE_LAYERS + self.groups])
    }

    /// Columns, rows and layers of the residual of shadows, if there is one.
    pub fn residual_extent(&self) -> Option<Extent> {
        (self.residual > 0).then_some(Extent::D2Array([self.residual, self.residual, self.lights.len() as u32]))
    }

    /// GPU memory of all parts including mipmaps, bytes.
    pub fn gpu_bytes(&self) -> u64 {
        let bytes = |texels: u64, format: TexelFormat| texels * format.texel_bytes() as u64;
        let residual = self.residual_extent().map_or(0, |extent| extent.texels_of_levels(extent.most_levels()));
        bytes(Extent::D2(self.basis_extent()).texels(), TexelFormat::Rgba32Uint)
            + bytes(self.tables_extent().texels(), TexelFormat::Rgba16Float)
            + bytes(self.weights_extent().texels_of_levels(self.levels), TexelFormat::Rgba8Unorm)
            + bytes(residual, RESIDUAL_FORMAT)
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let checked = |field, found, range| FormatError::check_range(format!("{FACTORED} {field}"), found, range);
        checked("size", self.size, 1..=MAX_EXTENT_2D)?;
        let most = Extent::D2([self.size; 2]).most_levels();
        checked("levels", self.levels, 1..=most)?;
        checked("groups", self.groups, 0..=MAX_GROUPS)?;
        if self.wide_groups > self.groups {
            let allowed = format!("0 to {}, the number of groups", self.groups);
            return Err(rejected("wide groups", self.wide_groups, allowed));
        }
        checked("materials", self.materials, 0..=MAX_MATERIALS)?;
        if self.materials > 0 && self.groups > 0 {
            let allowed = "no groups, because there are materials";
            return Err(rejected("groups", self.groups, allowed));
        }
        checked("axes", self.axes, 0..=(1 << self.tables()) - 1)?;
        let most = if self.materials > 0 { self.levels } else { 1 };
        checked("levels of tables", self.table_levels, 1..=most)?;
        for (k, albedo) in self.albedos.iter().enumerate() {
            let most = if k < self.materials as usize { MAX_BASE } else { 0.0 };
            if !albedo.iter().all(|c| (0.0..=most).contains(c)) {
                let allowed = format!("numbers of 0 to {most}");
                return Err(rejected(&format!("albedo of material {k}"), format!("{albedo:?}"), allowed));
            }
        }
        if self.groups > 0 {
            check_directions(&self.views, &self.lights)?;
        } else if !(self.views.is_empty() && self.lights.is_empty()) {
            let found = format!("{} views and {} lights", self.views.len(), self.lights.len());
            return Err(rejected("directions", found, "no views and lights, because there are no groups"));
        }
        checked("cells of the residual", self.residual, 0..=if self.groups > 0 { self.size } else { 0 })?;
        let [width, height] = self.basis_extent();
        if width > MAX_EXTENT_2D {
            let field = format!("size of the part {BASIS_PART}");
            let allowed = format!("at most {MAX_EXTENT_2D} on each side");
            return Err(FormatError::whole(field, Extent::D2([width, height]).to_string(), allowed));
        }
        let [a, b, c, d] = self.chroma.0;
        if a > b || c > d {
            let found = format!("{a} to {b} and {c} to {d}");
            return Err(rejected("range of colours", found, "two ranges with minimum <= maximum"));
        }
        for steps in &self.steps {
            if steps.len() != self.components() {
                let allowed = format!("{}, as groups requires", self.components());
                return Err(rejected("steps", format!("{} numbers", steps.len()), allowed));
            }
            if let Some(found) = steps.iter().find(|step| !(0.0..=f32::MAX).contains(*step)) {
                return Err(rejected("step", found, "a finite non-negative number"));
            }
        }
        let FactoredErrors { texels: _, seen_mean, seen_p95, seen_max, all_mean, all_p95 } = self.errors;
        let errors = [seen_mean, seen_p95, seen_max, all_mean, all_p95];
        match errors.into_iter().find(|error| !(0.0..=f32::MAX).contains(error)) {
            Some(found) => Err(rejected("error", found, "a finite non-negative number")),
            None => Ok(()),
        }
    }

    pub(in crate::flat_btf) fn entries(&self) -> BTreeMap<String, Vec<u8>> {
        let counts = [self.views.len() as u32, self.lights.len() as u32];
        let mut words = vec![VERSION, self.size, self.levels, self.groups, self.wide_groups, self.residual];
        words.extend(counts);
        words.push(self.errors.texels);
        let FactoredErrors { texels: _, seen_mean, seen_p95, seen_max, all_mean, all_p95 } = self.errors;
        words.extend([seen_mean, seen_p95, seen_max, all_mean, all_p95].map(f32::to_bits));
        words.extend([self.chroma.word(), self.materials, self.axes, self.table_levels]);
        words.extend(self.albedos.as_flattened().iter().map(|albedo| albedo.to_bits()));
        words.extend(self.steps.iter().flatten().map(|step| step.to_bits()));
        let mut entries = BTreeMap::new();
        if self.groups > 0 {
            entries.extend([direction_entry(VIEWS, &self.views), direction_entry(LIGHTS, &self.lights)]);
        }
        entries.insert(FACTORED.to_owned(), words.into_iter().flat_map(u32::to_le_bytes).collect());
        entries
    }

    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let bytes = entry(texture, FACTORED, KIND)?;
        if bytes.len() < FIXED_BYTES {
            return Err(rejected("length", format!("{} bytes", bytes.len()), format!("{FIXED_BYTES} bytes or more")));
        }
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, FACTORED, "version", VERSION..=VERSION)?;
        let (size, levels) = (cursor.u32("size")?, cursor.u32("levels")?);
        let groups = word(&mut cursor, FACTORED, "groups", 0..=MAX_GROUPS)?;
        let wide_groups = cursor.u32("wide groups")?;
        let residual = cursor.u32("cells of the residual")?;
        let views = word(&mut cursor, FACTORED, "views", 0..=MAX_DIRECTIONS)?;
        let lights = word(&mut cursor, FACTORED, "lights", 0..=MAX_DIRECTIONS)?;
        let errors = FactoredErrors {
            texels: cursor.u32("texels")?,
            seen_mean: cursor.f32("seen mean")?,
            seen_p95: cursor.f32("seen p95")?,
            seen_max: cursor.f32("seen max")?,
            all_mean: cursor.f32("all mean")?,
            all_p95: cursor.f32("all p95")?,
        };
        let chroma = ChromaRange::from_word(cursor.u32("range of colours")?);
        let (materials, axes) = (cursor.u32("materials")?, cursor.u32("axes")?);
        let table_levels = cursor.u32("levels of tables")?;
        let mut albedos = [[0.0; 3]; MAX_MATERIALS as usize];
        for albedo in albedos.as_flattened_mut() {
            *albedo = cursor.f32("albedo")?;
        }
        let components = groups as usize * GROUP;
        let expected = FIXED_BYTES + 3 * 4 * components;
        if bytes.len() != expected {
            let allowed = format!("{expected} bytes, as groups requires");
            return Err(rejected("length", format!("{} bytes", bytes.len()), allowed));
        }
        let mut steps = [(); 3].map(|()| vec![0.0; components]);
        for step in steps.iter_mut().flatten() {
            *step = cursor.f32("step")?;
        }
        let [views, lights] = match [views, lights] {
            [0, 0] => [Vec::new(), Vec::new()],
            [views, lights] => {
                [read_directions(texture, KIND, VIEWS, views)?, read_directions(texture, KIND, LIGHTS, lights)?]
            }
        };
        let header = Self {
            size,
            levels,
            groups,
            wide_groups,
            residual,
            views,
            lights,
            chroma,
            materials,
            axes,
            table_levels,
            albedos,
            steps,
            errors,
        };
        header.check()?;
        Ok(header)
    }
}
