//! Trees of a flat BTF: a pack of all its views over the parameters, and what the relief adds to them.

use crate::FormatError;
use crate::bindings::PackFile;
use crate::container::entries::{sized, value_of};
use crate::cursor::Cursor;
use crate::flat_btf::raised;
use crate::pwt::{PwtDecoder, PwtPack};

/// Name of the decoder and version of its bindings.
pub(crate) const DECODER: (&str, u32) = ("flat-btf-trees", 1);
/// Key of the header.
pub(crate) const TREES_ENTRY: &str = "brdfc.flat-btf.trees";
const VERSION: u32 = 1;
const BYTES: usize = 12;

/// Polynomial wavelet trees of the views of a flat BTF.
///
/// Texel `(column, row)` of the image of a view has the parameters `((column + ½) / T, (row + ½) / T)`. Views and lights are
/// in the frame of the reference plane.
#[derive(Debug, Clone)]
pub struct FlatTrees {
    decoder: PwtDecoder,
    has_shadows: bool,
    lowest_light: f32,
}

impl PartialEq for FlatTrees {
    fn eq(&self, other: &Self) -> bool {
        let parts = |trees: &Self| (trees.has_shadows, trees.lowest_light);
        self.pack() == other.pack() && parts(self) == parts(other)
    }
}

impl FlatTrees {
    /// Creates trees. `has_shadows` is true if values include the shadows of the relief; otherwise rays of light find
    /// them. `lowest_light` is the cosine of the largest polar angle of a fitted light.
    ///
    /// # Errors
    /// Returns an error unless the pack is a square tile and the cosine is above 0, up to 1.
    pub fn new(pack: PwtPack, has_shadows: bool, lowest_light: f32) -> Result<Self, FormatError> {
        let header = pack.header();
        let [width, height] = header.size;
        if !header.repeats || width != height {
            let kind = if header.repeats { "a tile" } else { "an image" };
            return Err(FormatError::whole(
                "trees of a flat BTF",
                format!("{kind} of {width} x {height}"),
                "a square tile",
            ));
        }
        if !(lowest_light > 0.0 && lowest_light <= 1.0) {
            let field = format!("{TREES_ENTRY} cosine of the lowest light");
            return Err(FormatError::whole(field, lowest_light.to_string(), "above 0, at most 1"));
        }
        Ok(Self { decoder: PwtDecoder::new(pack), has_shadows, lowest_light })
    }

    /// The pack of all views.
    pub fn pack(&self) -> &PwtPack {
        self.decoder.pack()
    }

    /// Returns true if values include the shadows of the relief.
    pub fn has_shadows(&self) -> bool {
        self.has_shadows
    }

    /// Cosine of the largest polar angle of a fitted light, above 0.
    pub fn lowest_light(&self) -> f32 {
        self.lowest_light
    }

    /// `T`, texels per side.
    pub fn size(&self) -> u32 {
        self.pack().header().size[0]
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        self.pack().header().levels + 1
    }

    /// Value at parameters of the flat BTF, before shadows that the trees do not include: radiance divided by that of a white
    /// diffuser that faces the light. `level_of_detail` is 0 at the finest level; `view` and `light` are unit vectors.
    pub fn value(&self, parameters: [f32; 2], level_of_detail: f32, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        if light[2] <= 0.0 {
            return [0.0; 3];
        }
        self.decoder.value(parameters, level_of_detail, view, raised(light, self.lowest_light))
    }

    /// Factor of the value under a light that is lower than all fitted ones: the ratio of cosines.
    pub(crate) fn dimmed(&self, light: [f32; 3]) -> f32 {
        (light[2] / self.lowest_light).min(1.0)
    }

    /// Keys and values of the headers.
    pub(crate) fn entries(&self) -> [(String, Vec<u8>); 2] {
        let words = [VERSION, u32::from(self.has_shadows), self.lowest_light.to_bits()];
        let header = words.into_iter().flat_map(u32::to_le_bytes).collect();
        [(TREES_ENTRY.to_owned(), header), self.pack().entry()]
    }

    /// Reads the trees of a file, and takes their images.
    ///
    /// # Errors
    /// Returns an error if headers or images violate the layout.
    pub(crate) fn take_from(file: &mut PackFile) -> Result<Self, FormatError> {
        let header = value_of(&file.entries, TREES_ENTRY, "a flat BTF of trees")?;
        let mut cursor = Cursor::new(sized(header, TREES_ENTRY, BYTES)?);
        let [version, shadows] = [cursor.u32("version")?, cursor.u32("shadows")?];
        FormatError::check_range(format!("{TREES_ENTRY} version"), version, VERSION..=VERSION)?;
        FormatError::check_range(format!("{TREES_ENTRY} shadows"), shadows, 0..=1)?;
        let lowest_light = cursor.f32("lowest light")?;
        Self::new(PwtPack::take_from(file)?, shadows == 1, lowest_light)
    }
}
