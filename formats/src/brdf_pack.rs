//! Interface that all BRDF packs share, independent of the codec.

use crate::bindings::Bindings;
use crate::crop::DirectionRange;
use crate::direction::DirectionPair;
use crate::symmetry::Symmetry;
use crate::table::Angles;
use crate::wavelet::Filter;
use crate::{ErrorSummary, RenderingSummary};
use std::fmt::Debug;

/// Common interface of BRDF packs.
pub trait Brdf: Debug + Send + Sync {
    /// Codec variant, as `--codec` takes it; the name of the codec if it has only one variant.
    fn variant(&self) -> &'static str;

    /// Stored colour channels, 1 or 3.
    fn channels(&self) -> u32;

    /// `μ`, mean of all samples, 1/sr.
    fn mean(&self) -> f32;

    /// Size on a GPU, bytes.
    fn gpu_bytes(&self) -> u64;

    /// Directions that the pack covers.
    fn directions(&self) -> DirectionRange;

    /// Index of the finest level of detail; level 0 is the coarsest.
    fn levels(&self) -> u32;

    /// Texture fetches of one look-up at a level of detail, with slices filtered by the sampler. Table packs ignore
    /// `filter`.
    fn fetches_at(&self, level: u32, filter: Filter) -> u32;

    /// Texture fetches of one look-up at the finest level of detail, with the filter used for error measurements.
    fn fetches(&self) -> u32 {
        self.fetches_at(self.levels(), Filter::Bilinear)
    }

    /// Error against the source at independent test directions; zeros if it was not measured.
    fn off_grid(&self) -> ErrorSummary;

    /// Colour differences between renderings of the pack and of the source, if the pack stores them.
    fn rendering(&self) -> Option<RenderingSummary> {
        None
    }

    /// Bindings of the pack's shader.
    fn bindings(&self) -> Bindings<'_>;

    /// Contents of the KTX2 file.
    fn to_bytes(&self, supercompress: bool) -> Vec<u8>;

    /// Decompresses the pack for random access.
    fn decoder(&self) -> Box<dyn BrdfDecoder>;
}

/// A BRDF pack, decompressed for random access.
pub trait BrdfDecoder: Debug + Send + Sync {
    /// Index of the finest level of detail; level 0 is the coarsest.
    fn levels(&self) -> u32;

    /// Returns true if all three channels are equal everywhere.
    fn is_grey(&self) -> bool;

    /// Symmetries that decoded values have up to rounding.
    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    /// `f_r` of a direction pair: linear RGB, 1/sr, not negative. `level` is a level of detail from 0 (the coarsest) to
    /// [`Self::levels`]. Wavelet packs use `filter`; table packs are always filtered exactly.
    fn eval(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3];

    /// Evaluates [`Self::eval`] for many pairs with the filter used for error measurements. `values` and `pairs` have
    /// the same length. Decoders that need half-difference angles take them from `angles`, so that several packs can
    /// share one computation.
    fn eval_block<'a>(
        &self,
        pairs: &[DirectionPair],
        angles: &dyn Fn() -> &'a [Angles],
        level: f32,
        values: &mut [[f64; 3]],
    ) {
        let _ = angles;
        for (value, pair) in values.iter_mut().zip(pairs) {
            *value = self.eval(*pair, level, Filter::Bilinear).map(f64::from);
        }
    }
}
