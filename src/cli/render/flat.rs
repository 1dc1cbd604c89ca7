//! Renderings of flat BTFs.

use super::arguments::Arguments;
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::{self, note};
use crate::{Common, Error};
use brdfc::flatten::read_report;
use brdfc::inspect::{flat_btf_file, open_flat_btf};
use brdfc::render::{
    Builtin, FlatForm, FlatMaterial, Verification, Views, draw_flat_btf, draw_flat_btf_on_cpu, draw_surface, flat_view,
};
use brdfc::{FormatError, Input};

/// Why a plane has no rendering of the surface itself.
const NO_SURFACE: &str = "not compared with the surface itself, only shader with CPU: that takes an asset whose surface and materials are all synth: addresses, without --bounces, --colour and --weights";
/// Why other scenes have none.
const CURVED: &str = "not compared with the surface itself, only shader with CPU: that is done on --scene plane";

/// Whether an input is a flat BTF: its file, or the folder of one.
pub(super) fn is_flat(input: &Input) -> bool {
    input.path().is_some_and(|path| !matches!(flat_btf_file(path), Ok(None)))
}

/// Draws the asset by the shader and on the CPU; on a plane, beside the surface itself where that can be computed again.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
) -> Result<(Verification, Views), Error> {
    let setup = scene::setup(arguments, subject)?;
    let path = input.path().expect("flat BTFs are files");
    let file = open_flat_btf(path)?;
    // Other programs may write flat BTFs without a report.
    let asset = read_report(&file).ok();
    let gpu = gpu::open(arguments)?;
    let wrong = |error: FormatError| Error::input(format!("{input}: {error}"));
    let parts = file.decoder.parts();
    let has_views = parts.values.factored().is_some();
    let form = arguments.form.unwrap_or(if has_views { FlatForm::Full } else { FlatForm::Light });
    let (stored, bytes_on_gpu) = match form {
        FlatForm::Light => ("light form", file.decoder.bindings(false, None).gpu_bytes()),
        FlatForm::Full => {
            flat_view(&file, 0).map_err(wrong)?;
            ("full form, factored", parts.gpu_bytes())
        }
    };
    let repeat = arguments.repeat.unwrap_or(setup.builtin.tiles());
    let material = FlatMaterial::new(file.decoder, repeat).map_err(wrong)?;
    let shader = draw_flat_btf(&gpu, &setup.scene, setup.frame, &material, form)?;
    let pack = draw_flat_btf_on_cpu(&setup.scene, setup.frame, &material, form);
    drop(material);
    let source = match (setup.builtin, &asset) {
        (Builtin::Plane, Some(asset)) => draw_surface(&setup.scene, setup.frame, asset, repeat)?,
        _ => None,
    };
    if source.is_none() {
        note(common, input, if setup.builtin == Builtin::Plane { NO_SURFACE } else { CURVED });
    }
    let views = Views { shader, pack, table: None, source, left_out: 0.0 };
    let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let verification = setup.verification(&gpu, &views, |_| (format!("{name} ({stored})"), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Of BRDFs: there is nothing among the flags that only flat BTFs have.
pub(super) fn refuse_flags(arguments: &Arguments) -> Result<(), Error> {
    let given = [(arguments.form.is_some(), "--form"), (arguments.repeat.is_some(), "--repeat")];
    output::refuse_flags(&arguments.input, &given.map(|(given, flag)| (given, flag, "with a flat BTF")))
}
