//! [`Brdf`] for table packs.

use super::descriptor::DESCRIPTOR;
use super::{Angles, TableDecoder, TablePack};
use crate::bindings::Bindings;
use crate::crop::DirectionRange;
use crate::direction::DirectionPair;
use crate::symmetry::Symmetry;
use crate::wavelet::Filter;
use crate::{Brdf, BrdfDecoder, ErrorSummary, RenderingSummary};

impl Brdf for TablePack {
    fn variant(&self) -> &'static str {
        if self.curve().is_some() { "factored" } else { DESCRIPTOR.name }
    }

    fn channels(&self) -> u32 {
        self.header().channels
    }

    fn mean(&self) -> f32 {
        self.header().mean
    }

    fn gpu_bytes(&self) -> u64 {
        self.gpu_bytes()
    }

    fn directions(&self) -> DirectionRange {
        self.directions()
    }

    fn levels(&self) -> u32 {
        self.levels()
    }

    fn fetches_at(&self, _: u32, _: Filter) -> u32 {
        self.fetches()
    }

    fn off_grid(&self) -> ErrorSummary {
        self.off_grid
    }

    fn rendering(&self) -> Option<RenderingSummary> {
        Some(self.rendering)
    }

    fn bindings(&self) -> Bindings<'_> {
        self.bindings()
    }

    fn to_bytes(&self, supercompress: bool) -> Vec<u8> {
        self.to_bytes(supercompress)
    }

    fn decoder(&self) -> Box<dyn BrdfDecoder> {
        Box::new(TableDecoder::new(self))
    }
}

impl BrdfDecoder for TableDecoder {
    fn levels(&self) -> u32 {
        self.levels()
    }

    fn is_grey(&self) -> bool {
        self.header().channels == 1
    }

    fn symmetry(&self) -> Symmetry {
        let header = self.header();
        let folds = header.symmetry;
        let mirror = if header.isotropic() { folds.mirror } else { folds.half_turn && folds.reflected };
        Symmetry { isotropic: header.isotropic(), mirror, reciprocal: folds.reciprocal }
    }

    fn eval(&self, pair: DirectionPair, level: f32, _: Filter) -> [f32; 3] {
        self.eval_at(pair, level)
    }

    fn eval_block<'a>(
        &self,
        pairs: &[DirectionPair],
        angles: &dyn Fn() -> &'a [Angles],
        level: f32,
        values: &mut [[f64; 3]],
    ) {
        for ((value, pair), angles) in values.iter_mut().zip(pairs).zip(angles()) {
            let found = if pair.is_above_horizon() { self.eval_angles(*angles, level) } else { [0.0; 3] };
            *value = found.map(f64::from);
        }
    }
}
