//! Packs of materials, with what was measured while they were made.

use crate::{Error, Facts, MaterialReport};
use brdfc_formats::BrdfPack;
use brdfc_jobs::encode::EncodedPack;
use brdfc_jobs::outputs::write_file;
use std::path::Path;

/// A pack in memory, with its report.
#[derive(Debug, Clone)]
pub struct Pack {
    encoded: EncodedPack,
    report: MaterialReport,
}

/// How far a pack is from its source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean ΔE*ab of pictures of a ball under lights from all sides.
    pub delta_e: f64,
    /// Its 95th percentile.
    pub delta_e_p95: f64,
    /// Mean relative error `ε_r`, a fraction.
    pub relative: f64,
}

impl Pack {
    pub(crate) fn new(encoded: EncodedPack, facts: &Facts) -> Self {
        let report = MaterialReport::new(&encoded, facts);
        Self { encoded, report }
    }

    /// The measured errors that are looked at first; [`Self::report`] has all.
    pub fn errors(&self) -> Errors {
        let picture = &self.encoded.off_grid.picture.delta_e;
        let relative = self.encoded.off_grid.norms.relative_mean;
        Errors { delta_e: picture.mean, delta_e_p95: picture.p95, relative }
    }

    /// What no pack that was tried meets; `None` if the pack is what was asked for.
    pub fn missed(&self) -> Option<&str> {
        self.encoded.missed.as_deref()
    }

    /// What was measured and tried, as `brdfc encode --json` prints it.
    pub fn report(&self) -> &MaterialReport {
        &self.report
    }

    /// The bytes of the KTX2 file.
    pub fn bytes(&self) -> &[u8] {
        &self.encoded.bytes
    }

    /// Bytes on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        self.encoded.pack.gpu_bytes()
    }

    /// Texture fetches of a look-up.
    pub fn fetches(&self) -> u32 {
        self.encoded.pack.fetches()
    }

    /// The pack, for decoding on the CPU.
    pub fn decoded(&self) -> &BrdfPack {
        &self.encoded.pack
    }

    /// Writes the file, whole or not at all.
    ///
    /// # Errors
    /// A place that cannot be written to.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        write_file(path.as_ref(), self.bytes())
    }
}
