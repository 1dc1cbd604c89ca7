//! A pack with what was measured while making it.

use super::{AveragingCost, Trial};
use brdfc_core::Tally;
use brdfc_formats::BrdfPack;
use brdfc_metrics::compare::Comparison;
use brdfc_metrics::norms::Norms;

/// What a codec reports of a pack.
pub trait BrdfReport {
    /// The variant of the codec, as `--codec` takes it: the name of the codec where it has one variant alone.
    fn variant(&self) -> &'static str;

    /// How large the pack is, in the codec's own units: `13x6x6`.
    fn size(&self) -> String;

    /// Error against the samples that the pack was made from, of codecs that have a grid of them.
    fn on_grid(&self) -> Option<&Norms> {
        None
    }
}

/// A pack with what was measured while making it; `R` is the report of its codec.
#[derive(Debug, Clone)]
pub struct Encoded<R> {
    /// The pack.
    pub pack: BrdfPack,
    /// Bytes on a GPU that it has less than one for all directions.
    pub cropped_bytes: u64,
    /// The file.
    pub bytes: Vec<u8>,
    /// What its codec reports.
    pub codec: R,
    /// Error against the source, at direction pairs and in renderings that depend on no codec.
    pub off_grid: Comparison,
    /// Values of the source that it was made from.
    pub evaluated: u64,
    /// Repairs of those values.
    pub tally: Tally,
    /// What it costs that values are reciprocal, where that was asked for.
    pub averaging: Option<AveragingCost>,
    /// The packs that a search tried, from coarse to fine.
    pub tried: Vec<Trial>,
    /// The limits that no pack of a search meets; this is the best of them.
    pub missed: Option<String>,
    /// Of a search within a range of directions: bytes on a GPU of the pack that meets the same limits over all directions, if
    /// that was looked for and found.
    pub of_all_directions: Option<u64>,
}

impl<R> Encoded<R> {
    /// A pack that no search made.
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

    /// The same with another report.
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

    /// The pack as one that a search tried, with the report of its codec.
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
            highlight: self.off_grid.highlight.map(|highlight| highlight.kept()),
            meets,
        }
    }
}
