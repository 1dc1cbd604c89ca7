//! Analytic models as measured files, structures as meshes: `brdfc synth`.
//!
//! Start with [`file()`], which writes a file of a model or a structure. [`MODELS`] and [`STRUCTURES`] list their
//! names and parameters.

pub use brdfc_core::address::{SYNTH_PREFIX, describe_models, split_query};
pub use brdfc_core::analytic::MODELS;
pub use brdfc_flat_btf::structures::{STRUCTURES, describe_structures};
pub use brdfc_readers::merl::Dimensions;
pub use brdfc_source::simulate::ScanPlan;

use crate::Error;
use brdfc_core::address::{AddressError, canonical, parse_model};
use brdfc_flat_btf::structures::Structure;
use brdfc_readers::meso::{obj, ply};
use brdfc_readers::{scan, scan_csv};
use brdfc_source::simulate::{merl_file, scan as simulate};

/// Format of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// A MERL table of a model (.binary).
    Merl(Dimensions),
    /// A scan of a model with a spectrum of 31 bands (.brdf).
    Scan(ScanPlan),
    /// A scan of a model as a list (.csv).
    Csv(ScanPlan),
    /// One tile of a structure (.obj).
    Obj,
    /// One tile of a structure (.ply).
    Ply,
}

/// Writes a file of `MODEL?param=value&...` or `STRUCTURE?param=value&...`, with or without `synth:`, and returns its bytes.
///
/// # Errors
/// Returns an error for an unknown model or structure, and for parameters, dimensions or plans out of range.
pub fn file(address: &str, target: Target) -> Result<Vec<u8>, Error> {
    let text = address.strip_prefix(SYNTH_PREFIX).unwrap_or(address);
    let wrong = |error: AddressError| Error::input(format!("{address}: {error}"));
    let model = || parse_model(text).map_err(wrong);
    let mesh = || Ok::<_, Error>(Structure::parse(text).map_err(wrong)?.mesh().to_triangle_mesh());
    let checked = match target {
        Target::Merl(dimensions) => dimensions.check_for_writing(),
        Target::Csv(plan) | Target::Scan(plan) => plan.check(),
        Target::Obj | Target::Ply => Ok(()),
    };
    checked.map_err(|error| Error::usage(error.to_string()))?;
    let mut bytes = Vec::new();
    let written = match target {
        Target::Merl(dimensions) => return Ok(merl_file(model()?.as_ref(), dimensions)),
        Target::Csv(plan) => scan_csv::write(&mut bytes, &simulate(model()?.as_ref(), &plan)),
        Target::Scan(plan) => {
            let model = model()?;
            let ScanPlan { noise, gaps, duplicates, seed, .. } = plan;
            let comment = format!(
                "simulated scan of {}\nnoise {noise}, gaps {gaps}, duplicates {duplicates}, seed {seed}",
                canonical(model.as_ref())
            );
            scan::write(&mut bytes, &comment, &simulate(model.as_ref(), &plan))
        }
        Target::Obj => obj::write(&mut bytes, &mesh()?),
        Target::Ply => ply::write(&mut bytes, &mesh()?),
    };
    written.expect("memory can be written to");
    Ok(bytes)
}
