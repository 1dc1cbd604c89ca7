//! Packs of materials, with the measurements made during encoding.

use crate::{Error, ErrorKind, FitLimits, MaterialReport, Progress};
use brdfc_formats::BrdfPack;
use brdfc_jobs::encode::{EncodedPack, ErrorLimits, Message};
use brdfc_jobs::outputs::write_file;
use brdfc_jobs::report::fit::check_report;
use brdfc_jobs::report::gate::GateResult;
use brdfc_source::open::Opened;
use std::path::Path;

/// A pack in memory, with its report.
#[derive(Debug, Clone)]
pub struct Pack {
    encoded: EncodedPack,
    report: MaterialReport,
    gates: Vec<GateResult>,
    missed: Option<Message>,
}

/// Errors of a pack compared with its source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Mean ΔE (CIE76) between renderings of the pack and of its source: a ball under three distant lights, as in
    /// `docs/accuracy.md`.
    pub delta_e: f64,
    /// 95th percentile of ΔE over the pixels of these renderings.
    pub delta_e_p95: f64,
    /// Mean relative error `ε_r` at independent test directions, a fraction.
    pub relative: f64,
}

impl Pack {
    pub(crate) fn new(
        encoded: EncodedPack,
        opened: &Opened,
        fit: FitLimits,
        errors: ErrorLimits,
        progress: &dyn Progress,
    ) -> Result<Self, Error> {
        let report = MaterialReport::new(&encoded, opened, progress)?;
        let gates = check_report(fit, errors, report.fit, &report.off_grid);
        let closed = gates.iter().filter(|gate| !gate.passed);
        let limits = report.missed.as_deref().map(Message::from);
        let missed = limits.into_iter().chain(closed.map(GateResult::message));
        let missed = missed.reduce(|all, next| all.with_text("; ").with_message(&next));
        Ok(Self { encoded, report, gates, missed })
    }

    /// Results of the checks of the source: the fit to a scan, and light. Empty if none were requested.
    pub fn gates(&self) -> &[GateResult] {
        &self.gates
    }

    /// Main measured errors; [`Self::report`] has all.
    pub fn errors(&self) -> Errors {
        let rendering = &self.encoded.off_grid.rendering.delta_e;
        let relative = self.encoded.off_grid.norms.relative_mean;
        Errors { delta_e: rendering.mean, delta_e_p95: rendering.p95, relative }
    }

    /// Describes the limits that no candidate meets, and problems of the fit to a scan; `None` if the pack meets the request.
    pub fn missed(&self) -> Option<&str> {
        self.missed.as_ref().map(Message::as_str)
    }

    /// The missed limits as an error, whose options [`Error::name_options`] can name.
    #[doc(hidden)]
    pub fn missed_error(&self) -> Option<Error> {
        self.missed.clone().map(|missed| Error::with_keys(ErrorKind::Check, missed))
    }

    /// Report of measurements and candidates, as `brdfc encode --json` prints it.
    pub fn report(&self) -> &MaterialReport {
        &self.report
    }

    /// Contents of the KTX2 file.
    pub fn bytes(&self) -> &[u8] {
        &self.encoded.bytes
    }

    /// Bytes of the pack's textures and uniform blocks on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        self.encoded.pack.gpu_bytes()
    }

    /// Texture fetches per look-up.
    pub fn fetches(&self) -> u32 {
        self.encoded.pack.fetches()
    }

    /// The pack, for decoding on the CPU.
    pub fn decoded(&self) -> &BrdfPack {
        &self.encoded.pack
    }

    /// Writes the file, either completely or not at all.
    ///
    /// # Errors
    /// Returns an error if the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        write_file(path.as_ref(), self.bytes())
    }
}
