//! Renderings of flat BTFs.

use super::arguments::Arguments;
use super::asset::name_of;
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::{self, note};
use crate::{Common, Error};
use brdfc::flatten::read_report;
use brdfc::inspect::open_flat_btf;
use brdfc::render::{FlatMaterial, Verification, Views, draw_flat_btf, draw_flat_btf_on_cpu, draw_surface};
use brdfc::{FormatError, Input};

/// Note without a rendering of the surface itself.
const NO_SURFACE: &str = "compared the shader with the CPU only: a comparison with the surface itself requires synth: \
    addresses for the surface and its materials, without --bounces, --colour and --weights";

/// Draws the asset with the shader and on the CPU; also the surface itself, if it can be computed again.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
) -> Result<(Verification, Views), Error> {
    let setup = scene::setup(arguments, subject)?;
    let file = open_flat_btf(input)?;
    // Flat BTFs of other programs may have no report.
    let asset = read_report(&file).ok();
    let gpu = gpu::open(arguments)?;
    let wrong = |error: FormatError| Error::input(format!("{input}: {error}"));
    let stored = file.decoder.parts().reflectance.name();
    let bytes_on_gpu = file.gpu_bytes();
    let repeat = arguments.repeat.unwrap_or(setup.builtin.tiles());
    let material = FlatMaterial::new(file.decoder, repeat).map_err(wrong)?;
    let shader = draw_flat_btf(&gpu, &setup.scene, setup.frame, &material)?;
    let pack = draw_flat_btf_on_cpu(&setup.scene, setup.frame, &material);
    drop(material);
    let surface = |asset| draw_surface(&setup.scene, setup.frame, asset, repeat);
    let source = asset.as_ref().map(surface).transpose()?.flatten();
    if source.is_none() {
        note(common, input, NO_SURFACE);
    }
    let views = Views { shader, pack, table: None, source, source_with_noise: None, left_out: 0.0 };
    let name = format!("{} ({stored})", name_of(input));
    let verification = setup.verification(&gpu, &views, |_| (name.clone(), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Rejects flags that apply only to flat BTFs.
pub(super) fn refuse_flags(arguments: &Arguments) -> Result<(), Error> {
    output::refuse_flags(&arguments.input, &[(arguments.repeat.is_some(), "--repeat", "flat BTFs")])
}
