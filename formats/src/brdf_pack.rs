//! Packs of BRDFs: what engines draw materials from, whichever codec made them.

use crate::bindings::Bindings;
use crate::crop::DirectionRange;
use crate::direction::DirectionPair;
use crate::symmetry::Symmetry;
use crate::table::Angles;
use crate::wavelet::Filter;
use crate::{ErrorSummary, RenderingSummary};
use std::fmt::Debug;

/// A pack of a BRDF, whichever its codec.
pub trait Brdf: Debug + Send + Sync {
    /// The variant of its codec, as `--codec` takes it: the name of the codec where it has one variant alone.
    fn variant(&self) -> &'static str;

    /// Colour channels that are stored, 1 or 3.
    fn channels(&self) -> u32;

    /// `μ`, 1/sr.
    fn mean(&self) -> f32;

    /// Bytes on a GPU.
    fn gpu_bytes(&self) -> u64;

    /// Directions that it is for.
    fn directions(&self) -> DirectionRange;

    /// Levels of detail less one: level 0 is the coarsest, level `levels` the finest.
    fn levels(&self) -> u32;

    /// Texture fetches of one look-up at a level of detail, slices filtered by the sampler. `filter` is that of wavelet packs.
    fn fetches_at(&self, level: u32, filter: Filter) -> u32;

    /// Texture fetches of one look-up at the finest level of detail, with the filter that errors are measured with.
    fn fetches(&self) -> u32 {
        self.fetches_at(self.levels(), Filter::Bilinear)
    }

    /// Its error against the source at direction pairs that depend on no codec; zeros if it was not measured.
    fn off_grid(&self) -> ErrorSummary;

    /// Its colour differences from the source in renderings, where the pack says them.
    fn rendering(&self) -> Option<RenderingSummary> {
        None
    }

    /// The bindings of its shader.
    fn bindings(&self) -> Bindings<'_>;

    /// The bytes of the KTX2 file.
    fn to_bytes(&self, supercompress: bool) -> Vec<u8>;

    /// Unpacks it for random access.
    fn decoder(&self) -> Box<dyn BrdfDecoder>;
}

/// A pack of a BRDF, unpacked for random access.
pub trait BrdfDecoder: Debug + Send + Sync {
    /// Levels of detail less one: level 0 is the coarsest, level `levels` the finest.
    fn levels(&self) -> u32;

    /// Whether all three channels are equal everywhere.
    fn is_grey(&self) -> bool;

    /// The symmetries that decoded values obey exactly, up to rounding.
    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }

    /// `f_r` at a direction pair, linear RGB, 1/sr, not negative. `level` is a level of detail, 0 (the coarsest) to
    /// [`Self::levels`]. `filter` is that of wavelet packs; tables are filtered exactly.
    fn eval(&self, pair: DirectionPair, level: f32, filter: Filter) -> [f32; 3];

    /// [`Self::eval`] of many pairs with the filter that errors are measured with; `values` has as many as `pairs`. Decoders that
    /// look up angles first take them from `angles`, which finds them once for all packs.
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
