//! Pictures of flat BTFs.

use super::arguments::{Arguments, FormName};
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::note;
use crate::{Common, Error};
use brdfc_core::address::is_synth;
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::Appearance;
use brdfc_gpu::draw_flat_btf;
use brdfc_gpu::verify::Views;
use brdfc_jobs::flatten::{AssetFile, MesoOptions, PLANE, open_appearance, open_geometry, read_report};
use brdfc_jobs::report::render::Verification;
use brdfc_render::flat::{FlatForm, FlatMaterial, draw_on_cpu, reference_plane};
use brdfc_render::scenes::Builtin;
use brdfc_source::Input;
use brdfc_source::flat_btf::{flat_btf_file, flat_view, open_flat_btf};

/// Why a plane has no picture of the surface itself.
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
    let wrong = |error: brdfc_formats::FormatError| Error::input(format!("{input}: {error}"));
    let parts = file.decoder.parts();
    let has_views = parts.values.factored().is_some();
    let form = match arguments.form {
        Some(FormName::Full) => FlatForm::Full,
        Some(FormName::Light) => FlatForm::Light,
        None if has_views => FlatForm::Full,
        None => FlatForm::Light,
    };
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
    let pack = draw_on_cpu(&setup.scene, setup.frame, &material, form);
    drop(material);
    let surface = match setup.builtin {
        Builtin::Plane => asset.as_ref().map(surface_again).transpose()?.flatten(),
        _ => None,
    };
    let source =
        surface.map(|(model, appearance)| reference_plane(&setup.scene, setup.frame, &model, &appearance, repeat));
    if source.is_none() {
        note(common, input, if setup.builtin == Builtin::Plane { NO_SURFACE } else { CURVED });
    }
    let views = Views { shader, pack, table: None, source, left_out: 0.0 };
    let name = path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let verification = setup.verification(&gpu, &views, |_| (format!("{name} ({stored})"), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// The surface and materials that an asset was made from, where all are addresses.
fn surface_again(asset: &AssetFile) -> Result<Option<(MesoModel, Appearance)>, Error> {
    let (source, materials) = (&asset.source, &asset.materials);
    let from_formula = is_synth(source) || source == PLANE;
    let from_files = !from_formula || materials.is_empty() || !materials.iter().all(|m| is_synth(m));
    if from_files || asset.settings.bounces > 0 || asset.images_over_the_tile {
        return Ok(None);
    }
    let options = MesoOptions {
        geometry: is_synth(source).then(|| source.into()),
        tile: 1.0,
        height_scale: 1.0,
        height_offset: 0.0,
        materials: Vec::new(),
        colour: None,
        weights: None,
    };
    let geometry = open_geometry(&options)?;
    let materials: Vec<Input> = materials.iter().map(Input::from).collect();
    let appearance = open_appearance(&options, &materials, &())?;
    let model = MesoModel::new(geometry.mesh, 0).map_err(|error| Error::input(format!("{source}: {error}")))?;
    Ok(Some((model, appearance)))
}

/// Of BRDFs: there is nothing among the flags that only flat BTFs have.
pub(super) fn refuse_flags(arguments: &Arguments) -> Result<(), Error> {
    let form = arguments.form.map(|_| "--form");
    let Some(flag) = form.or(arguments.repeat.map(|_| "--repeat")) else { return Ok(()) };
    let text = format!("{flag}: found with {}; allowed with a flat BTF", arguments.input);
    Err(Error::usage(text))
}
