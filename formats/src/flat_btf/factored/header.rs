//! What a factored flat BTF says of itself, in the entry `brdfc.flat-btf.factored` of its basis.

use super::domain::ChromaRange;
use crate::FormatError;
use crate::container::entries::entry;
use crate::container::{Extent, MAX_EXTENT_2D, TexelFormat, Texture};
use crate::cursor::Cursor;
use crate::flat_btf::flat_view::{MAX_DIRECTIONS, check_directions, direction_entries, read_directions};
use crate::flat_btf::layout::word;
use std::collections::BTreeMap;

/// The entry that makes a texture the basis of a factored flat BTF.
pub(crate) const FACTORED: &str = "brdfc.flat-btf.factored";
/// Most groups of four components.
pub const MAX_GROUPS: u32 = 16;
/// Components of a group.
pub const GROUP: usize = 4;
/// Half angles of the base's table: entry `i` is at `|n - h|² / 2 = (i / 47)⁴`, with normal `n` and half vector `h`.
pub const HALF_ANGLES: usize = 48;
/// Difference angles of the base's table: entry `j` is at a cosine of `1 - j / 7`.
pub const DIFFERENCE_ANGLES: usize = 8;
/// Layers of the part `weights` that the base takes, before those of the components.
pub const BASE_LAYERS: u32 = 2;

pub(super) const BASIS_PART: &str = "basis";
const VERSION: u32 = 2;
const KIND: &str = "the basis of a factored flat BTF";
/// Bytes before the steps.
const FIXED_BYTES: usize = 4 * (9 + 6);

/// How shadows are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum ShadowFormat {
    /// There are none: every texel is lit by every light.
    None = 0,
    /// 8 bits per texel and light.
    R8 = 1,
}

impl ShadowFormat {
    const ALL: [Self; 2] = [Self::None, Self::R8];

    /// The texels of the part `shadow`, where there is one.
    pub fn texel_format(self) -> Option<TexelFormat> {
        match self {
            Self::None => None,
            Self::R8 => Some(TexelFormat::R8Unorm),
        }
    }
}

/// Colour differences (ΔE of 1976) from the values that were factored, over texels that were left out of the fit and all
/// views and lights.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct FactoredErrors {
    /// Texels.
    pub texels: u32,
    /// Mean where a texel is seen in the view.
    pub seen_mean: f32,
    /// 95th percentile of the same.
    pub seen_p95: f32,
    /// Largest of the same.
    pub seen_max: f32,
    /// Mean over all views, with the values of texels that are not seen there, which were filled in.
    pub all_mean: f32,
    /// 95th percentile of the same.
    pub all_p95: f32,
}

/// What a factored flat BTF says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct FactoredHeader {
    /// `T`, texels per side, 1 to 8192.
    pub size: u32,
    /// Mipmap levels of shadows and weights.
    pub levels: u32,
    /// `G`, groups of four components, 1 to [`MAX_GROUPS`].
    pub groups: u32,
    /// Of how many of them the basis has 16 bits; the others have 8.
    pub wide_groups: u32,
    /// How shadows are stored.
    pub shadow: ShadowFormat,
    /// Polar angle, 0 to π/2, and azimuth, 0 up to 2π, of all views, radians.
    pub views: Vec<[f32; 2]>,
    /// The same of all lights.
    pub lights: Vec<[f32; 2]>,
    /// Colours that its texels have.
    pub chroma: ChromaRange,
    /// What a step of the basis means: of each opponent colour, for all components.
    pub steps: [Vec<f32>; 3],
    /// How wrong it is.
    pub errors: FactoredErrors,
}

fn refused(field: &str, found: impl ToString, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("{FACTORED} {field}"), found.to_string(), allowed.into())
}

impl FactoredHeader {
    /// `K`, components.
    pub fn components(&self) -> usize {
        self.groups as usize * GROUP
    }

    /// Words of the basis for one opponent colour of a pair of a view and a light: two for a group of 16 bits, else one.
    pub fn words(&self) -> u32 {
        self.groups + self.wide_groups
    }

    /// Texels of four words that hold them.
    pub fn texels_per_colour(&self) -> u32 {
        self.words().div_ceil(4)
    }

    /// Columns and rows of the basis: a row per view, and those of the base's table.
    pub fn basis_extent(&self) -> [u32; 2] {
        let width = self.lights.len() as u32 * 3 * self.texels_per_colour();
        let table = (HALF_ANGLES * DIFFERENCE_ANGLES) as u32;
        [width, self.views.len() as u32 + table.div_ceil(width.max(1))]
    }

    /// Columns, rows and layers of the weights, the layers of the base among them.
    pub fn weights_extent(&self) -> Extent {
        Extent::D2Array([self.size, self.size, BASE_LAYERS + self.groups])
    }

    /// Columns, rows and layers of the shadows, where there are some.
    pub fn shadow_extent(&self) -> Extent {
        Extent::D2Array([self.size, self.size, self.lights.len() as u32])
    }

    /// Bytes of all parts on a GPU, mipmaps included.
    pub fn gpu_bytes(&self) -> u64 {
        let bytes = |texels: u64, format: TexelFormat| texels * format.texel_bytes() as u64;
        let shadow = self.shadow.texel_format();
        bytes(Extent::D2(self.basis_extent()).texels(), TexelFormat::Rgba32Uint)
            + bytes(self.weights_extent().texels_of_levels(self.levels), TexelFormat::Rgba8Unorm)
            + shadow.map_or(0, |format| bytes(self.shadow_extent().texels_of_levels(self.levels), format))
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// Names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let checked = |field, found, range| FormatError::check_range(format!("{FACTORED} {field}"), found, range);
        checked("size", self.size, 1..=MAX_EXTENT_2D)?;
        let most = Extent::D2([self.size; 2]).most_levels();
        checked("levels", self.levels, 1..=most)?;
        checked("groups", self.groups, 1..=MAX_GROUPS)?;
        if self.wide_groups > self.groups {
            return Err(refused("wide groups", self.wide_groups, format!("0 to {}, the groups", self.groups)));
        }
        check_directions(&self.views, &self.lights)?;
        let [width, height] = self.basis_extent();
        if width > MAX_EXTENT_2D {
            let field = format!("size of the part {BASIS_PART}");
            let allowed = format!("at most {MAX_EXTENT_2D} on each side");
            return Err(FormatError::whole(field, Extent::D2([width, height]).to_string(), allowed));
        }
        let [a, b, c, d] = self.chroma.0;
        if a > b || c > d {
            let found = format!("{a} to {b} and {c} to {d}");
            return Err(refused("range of colours", found, "two ranges whose first number is not the larger"));
        }
        for steps in &self.steps {
            if steps.len() != self.components() {
                let allowed = format!("{}, as groups says", self.components());
                return Err(refused("steps", format!("{} numbers", steps.len()), allowed));
            }
            if let Some(found) = steps.iter().find(|step| !(0.0..=f32::MAX).contains(*step)) {
                return Err(refused("step", found, "a finite number that is not negative"));
            }
        }
        let FactoredErrors { texels: _, seen_mean, seen_p95, seen_max, all_mean, all_p95 } = self.errors;
        let errors = [seen_mean, seen_p95, seen_max, all_mean, all_p95];
        match errors.into_iter().find(|error| !(0.0..=f32::MAX).contains(error)) {
            Some(found) => Err(refused("error", found, "a finite number that is not negative")),
            None => Ok(()),
        }
    }

    pub(in crate::flat_btf) fn entries(&self) -> BTreeMap<String, Vec<u8>> {
        let counts = [self.views.len() as u32, self.lights.len() as u32];
        let mut words = vec![VERSION, self.size, self.levels, self.groups, self.wide_groups, self.shadow as u32];
        words.extend(counts);
        words.push(self.errors.texels);
        let FactoredErrors { texels: _, seen_mean, seen_p95, seen_max, all_mean, all_p95 } = self.errors;
        words.extend([seen_mean, seen_p95, seen_max, all_mean, all_p95].map(f32::to_bits));
        words.push(self.chroma.word());
        words.extend(self.steps.iter().flatten().map(|step| step.to_bits()));
        let mut entries = direction_entries(&self.views, &self.lights);
        entries.insert(FACTORED.to_owned(), words.into_iter().flat_map(u32::to_le_bytes).collect());
        entries
    }

    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        let bytes = entry(texture, FACTORED, KIND)?;
        if bytes.len() < FIXED_BYTES {
            return Err(refused("length", format!("{} bytes", bytes.len()), format!("{FIXED_BYTES} bytes or more")));
        }
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, FACTORED, "version", VERSION..=VERSION)?;
        let (size, levels) = (cursor.u32("size")?, cursor.u32("levels")?);
        let groups = word(&mut cursor, FACTORED, "groups", 1..=MAX_GROUPS)?;
        let wide_groups = cursor.u32("wide groups")?;
        let last = ShadowFormat::ALL.len() as u32 - 1;
        let shadow = ShadowFormat::ALL[word(&mut cursor, FACTORED, "shadow format", 0..=last)? as usize];
        let views = word(&mut cursor, FACTORED, "views", 1..=MAX_DIRECTIONS)?;
        let lights = word(&mut cursor, FACTORED, "lights", 1..=MAX_DIRECTIONS)?;
        let errors = FactoredErrors {
            texels: cursor.u32("texels")?,
            seen_mean: cursor.f32("seen mean")?,
            seen_p95: cursor.f32("seen p95")?,
            seen_max: cursor.f32("seen max")?,
            all_mean: cursor.f32("all mean")?,
            all_p95: cursor.f32("all p95")?,
        };
        let chroma = ChromaRange::from_word(cursor.u32("range of colours")?);
        let components = groups as usize * GROUP;
        let wanted = FIXED_BYTES + 3 * 4 * components;
        if bytes.len() != wanted {
            let allowed = format!("{wanted} bytes, as groups says");
            return Err(refused("length", format!("{} bytes", bytes.len()), allowed));
        }
        let mut steps = [(); 3].map(|()| vec![0.0; components]);
        for step in steps.iter_mut().flatten() {
            *step = cursor.f32("step")?;
        }
        let [views, lights] = read_directions(texture, KIND, [views, lights])?;
        let header = Self { size, levels, groups, wide_groups, shadow, views, lights, chroma, steps, errors };
        header.check()?;
        Ok(header)
    }
}
