//! Recipes: everything that decides the bytes of a pack besides the source.

use super::{BrdfReport, EncodeError, EncodeOptions, Encoded, ErrorLimits, GridCache, OptionError, Variant};
use brdfc_core::Source;
use brdfc_core::progress::Progress;
use brdfc_formats::crop::DirectionRange;
use serde::{Deserialize, Serialize};

/// A recipe of a pack of a BRDF, as scenes and plans see it.
pub trait BrdfRecipe {
    /// The variant of the codec that is made, as `--codec` takes it; one that stands for several where a search chooses.
    fn variant(&self) -> &'static str;

    /// What limits the pack's size or error, in a few words for a plan: `ΔE at most 0.5`.
    fn target(&self) -> String;

    /// Directions that the pack is for.
    fn directions(&self) -> DirectionRange;

    /// Limits the pack to what look-ups within a range of directions touch.
    fn limit_directions(&mut self, directions: DirectionRange);

    /// Whether cropped directions make the pack smaller. Otherwise they leave room for finer values.
    fn has_fixed_size(&self) -> bool;

    /// Whether several packs are tried.
    fn is_search(&self) -> bool {
        false
    }

    /// Whether a limit of error decides how large the pack becomes.
    fn limits_error(&self) -> bool;

    /// The limits of error that were asked for, unlike those of the default budget.
    fn asked_errors(&self) -> ErrorLimits;

    /// Skips measuring the error against the source, unless the error decides something.
    fn skip_measuring(&mut self);

    /// Sets whether texels are compressed in the file.
    fn set_supercompress(&mut self, supercompress: bool);

    /// Levels of detail that are stored, and that there are in all, where finer ones can be left out.
    fn stored_levels(&self) -> Option<[u32; 2]> {
        None
    }

    /// Leaves out levels of detail that are finer than `finest` of the number of levels.
    fn limit_levels(&mut self, finest: &dyn Fn(u32) -> u32) {
        let _ = finest;
    }

    /// Levels of detail that are coarser than the finest, where coarser ones can be left out.
    fn coarser_levels(&self) -> u32 {
        0
    }

    /// Leaves out all but this many coarser levels of detail.
    fn limit_coarser_levels(&mut self, most: u32) {
        let _ = most;
    }

    /// Memory that the encoding takes at most, without the source, bytes.
    fn memory(&self) -> u64;

    /// The size of the pack before it is made.
    fn predict(&self) -> Predicted;
}

/// A recipe that one encoder follows.
pub trait Encode: BrdfRecipe + Sized {
    /// What is reported of a pack.
    type Report: BrdfReport;

    /// What users may ask for.
    const VARIANTS: &'static [Variant];

    /// The recipe of a variant, from options that it has. `options.codec` is the codec that users named; it is absent where other
    /// options chose the codec.
    ///
    /// # Errors
    /// Options that are out of range or do not go together. The budget has been checked.
    fn from_options(variant: &str, options: &EncodeOptions) -> Result<Self, OptionError>;

    /// Encodes a source, evaluated on a grid of the cache where it is there.
    ///
    /// # Errors
    /// Limits that no pack of the codec meets, sizes out of range, cancellation.
    fn encode(
        &self,
        source: &dyn Source,
        cache: &dyn GridCache,
        progress: &dyn Progress,
    ) -> Result<Encoded<Self::Report>, EncodeError>;

    /// Bytes on a GPU of the levels of detail that [`BrdfRecipe::limit_levels`] left out, where the report tells.
    fn bytes_of_left_out_levels(&self, report: &Self::Report, channels: u32) -> Option<u64> {
        let _ = (report, channels);
        None
    }
}

/// Bytes on a GPU that a pack will have: grey and coloured ones differ, and a search ends where its budget is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Predicted {
    /// At least.
    pub least: u64,
    /// At most.
    pub most: u64,
}

impl Predicted {
    /// Of a pack that is there.
    pub fn exactly(bytes: u64) -> Self {
        Self { least: bytes, most: bytes }
    }
}
