//! Renderings of flat BTFs.

use super::arguments::Arguments;
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::{self, note};
use crate::{Common, Error};
use brdfc::flatten::read_report;
use brdfc::inspect::{flat_btf_file, open_flat_btf};
use brdfc::render::{FlatMaterial, Verification, Views, draw_flat_btf, draw_flat_btf_on_cpu, draw_surface};
use brdfc::{FormatError, Input};

/// Note without a rendering of the surface itself.
const NO_SURFACE: &str = "compared the shader with the CPU only: a comparison with the surface itself requires synth: \
    addresses for the surface and its materials, without --bounces, --colour and --weights";

/// Returns true if an input is a flat BTF: its file, or its folder.
pub(super) fn is_flat(input: &Input) -> bool {
    input.path().is_some_and(|path| !matches!(flat_btf_file(path), Ok(None)))
}

/// Draws the asset with the shader and on the CPU; also the surface itself, if it can be computed again.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
) -> Result<(Verification, Views), Error> {
    let setup = scene::setup(arguments, subject)?;
    let path = input.path().expect("flat BTFs are files");
    let file = open_flat_btf(path)?;
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
    let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let verification = setup.verification(&gpu, &views, |_| (format!("{name} ({stored})"), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Rejects flags that apply only to flat BTFs.
pub(super) fn refuse_flags(arguments: &Arguments) -> Result<(), Error> {
    output::refuse_flags(&arguments.input, &[(arguments.repeat.is_some(), "--repeat", "flat BTFs")])
}
