//! Recipes: everything besides the source that decides the bytes of a pack.

use super::{BrdfReport, EncodeError, EncodeOptions, Encoded, ErrorLimits, GridCache, OptionError, Variant};
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_formats::crop::DirectionRange;
use serde::{Deserialize, Serialize};

/// Recipe of a BRDF pack, as scenes and plans see it.
pub trait BrdfRecipe {
    /// Variant of the codec, as `--codec` takes it. A search that chooses the variant has its own name.
    fn variant(&self) -> &'static str;

    /// Short summary of the limits of size or error for a plan: `ΔE at most 0.5`.
    fn target(&self) -> String;

    /// Directions that the pack covers.
    fn directions(&self) -> DirectionRange;

    /// Limits the pack to the data of look-ups within a range of directions.
    fn limit_directions(&mut self, directions: DirectionRange);

    /// Returns true if cropped directions make the pack smaller. Otherwise they leave room for finer values.
    fn has_fixed_size(&self) -> bool;

    /// Returns true if several packs are tried.
    fn is_search(&self) -> bool {
        false
    }

    /// Returns true if an error limit decides the size of the pack.
    fn limits_error(&self) -> bool;

    /// Error limits that the user set, without the limits of the default budget.
    fn asked_errors(&self) -> ErrorLimits;

    /// Skips measuring the error against the source, unless the error decides something.
    fn skip_measuring(&mut self);

    /// Sets whether texels are compressed in the file.
    fn set_supercompress(&mut self, supercompress: bool);

    /// Stored and total number of levels of detail, where finer levels can be omitted.
    fn stored_levels(&self) -> Option<[u32; 2]> {
        None
    }

    /// Omits levels of detail finer than `finest`, a function of the number of levels.
    fn limit_levels(&mut self, finest: &dyn Fn(u32) -> u32) {
        let _ = finest;
    }

    /// Number of levels of detail coarser than the finest, where coarser levels can be omitted.
    fn coarser_levels(&self) -> u32 {
        0
    }

    /// Omits all but this many coarser levels of detail.
    fn limit_coarser_levels(&mut self, most: u32) {
        let _ = most;
    }

    /// Upper bound of the memory of an encoding without the source, bytes.
    fn memory(&self) -> u64;

    /// Size of the pack before it is encoded.
    fn predict(&self) -> Predicted;
}

/// A recipe that an encoder follows.
pub trait Encode: BrdfRecipe + Sized {
    /// Report of a pack.
    type Report: BrdfReport;

    /// Variants that users may choose.
    const VARIANTS: &'static [Variant];

    /// Creates the recipe of a variant from its options. `options.codec` is the codec that the user named; it is absent
    /// where other options chose the codec.
    ///
    /// # Errors
    /// Returns an error for options that are out of range or conflict. The budget has been checked.
    fn from_options(variant: &str, options: &EncodeOptions) -> Result<Self, OptionError>;

    /// Encodes a source. Samples come from the cache where it has them.
    ///
    /// # Errors
    /// Returns an error for limits that no pack of the codec meets, sizes out of range, or cancellation.
    fn encode(
        &self,
        source: &dyn Source,
        cache: &dyn GridCache,
        progress: &dyn Progress,
    ) -> Result<Encoded<Self::Report>, EncodeError>;

    /// Bytes on a GPU of the levels of detail that [`BrdfRecipe::limit_levels`] omitted, where the report has them.
    fn bytes_of_left_out_levels(&self, report: &Self::Report, channels: u32) -> Option<u64> {
        let _ = (report, channels);
        None
    }
}

/// Predicted range of bytes on a GPU: grey and coloured packs differ, and a search ends at the first pack within its
/// limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Predicted {
    /// Minimum bytes on a GPU.
    pub least: u64,
    /// Maximum bytes on a GPU.
    pub most: u64,
}

impl Predicted {
    /// Prediction for an existing pack.
    pub fn exactly(bytes: u64) -> Self {
        Self { least: bytes, most: bytes }
    }
}
