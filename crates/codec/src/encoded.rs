//! Packs with the measurements of their encoding.

use super::{AveragingCost, Trial};
use brdfc_core::Tally;
use brdfc_formats::BrdfPack;
use brdfc_metrics::compare::Comparison;
use brdfc_metrics::norms::Norms;

/// Report of a codec about a pack.
pub trait BrdfReport {
    /// The variant of the codec, as `--codec` takes it: the name of the codec if it has a single variant.
    fn variant(&self) -> &'static str;

    /// Size of the pack in the codec's own units: `13x6x6`.
    fn size(&self) -> String;

    /// Error against the samples that the pack was made from, for codecs with a grid of them.
    fn on_grid(&self) -> Option<&Norms> {
        None
    }
}

/// A pack with the measurements of its encoding; `R` is the report of its codec.
#[derive(Debug, Clone)]
pub struct Encoded<R> {
    /// The pack in memory, for decoding on the CPU.
    pub pack: BrdfPack,
    /// Bytes on a GPU that cropping saves, compared with a pack for all directions.
    pub cropped_bytes: u64,
    /// Contents of the pack's KTX2 file.
    pub bytes: Vec<u8>,
    /// Report of the codec.
    pub codec: R,
    /// Error against the source, at direction pairs and in renderings that depend on no codec.
    pub off_grid: Comparison,
    /// Number of evaluations of the source.
    pub evaluated: u64,
    /// Repairs of these values.
    pub tally: Tally,
    /// Error that symmetrising adds, where reciprocal values were requested.
    pub averaging: Option<AveragingCost>,
    /// Packs that a search tried, from coarse to fine.
    pub tried: Vec<Trial>,
    /// Limits that no pack of a search meets; this pack is the closest.
    pub missed: Option<String>,
    /// Bytes on a GPU of the pack that meets the same limits over all directions. Present only after a search within a
    /// range of directions that looked for such a pack and found one.
    pub of_all_directions: Option<u64>,
}

impl<R> Encoded<R> {
    /// Wraps a pack that no search made.
    pub fn new(pack: BrdfPack, bytes: Vec<u8>, codec: R, off_grid: Comparison, tally: Tally) -> Self {
        Self {
            pack,
            cropped_bytes: 0,
            bytes,
            codec,
            off_grid,
            evaluated: tally.evaluations,
            tally,
            averaging: None,
            tried: Vec::new(),
            missed: None,
            of_all_directions: None,
        }
    }

    /// Converts the report of the codec to another type; everything else stays unchanged.
    pub fn map<S>(self, report: impl FnOnce(R) -> S) -> Encoded<S> {
        Encoded {
            pack: self.pack,
            cropped_bytes: self.cropped_bytes,
            bytes: self.bytes,
            codec: report(self.codec),
            off_grid: self.off_grid,
            evaluated: self.evaluated,
            tally: self.tally,
            averaging: self.averaging,
            tried: self.tried,
            missed: self.missed,
            of_all_directions: self.of_all_directions,
        }
    }

    /// Summary of the pack as a trial of a search, with the report of its codec.
    pub fn trial(&self, report: &dyn BrdfReport, meets: bool) -> Trial {
        let rendering = &self.off_grid.rendering.delta_e;
        Trial {
            codec: report.variant().to_owned(),
            size: report.size(),
            bytes_on_gpu: self.pack.gpu_bytes(),
            fetches: self.pack.fetches(),
            delta_e: rendering.mean,
            delta_e_p95: rendering.p95,
            relative_error: self.off_grid.norms.relative_mean,
            highlight: self.off_grid.highlight.map(|highlight| highlight.retained()),
            meets,
        }
    }
}
