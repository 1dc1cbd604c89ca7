//! Conversion of the flags of `brdfc flatten` to recipes, with checks of ranges and combinations.

use super::arguments::{Arguments, Relief, Shadows, TEXELS};
use crate::Error;
use crate::directions::{default_set, direction_set};
use crate::inputs::refuse_stdin_twice;
use crate::output::{check_folder, refuse_flags, refuse_overwriting, refuse_same_outputs};
use brdfc::Input;
use brdfc::flatten::{
    FactoredTarget, FillMethod, FlattenRecipe, MesoOptions, Reflectance, ReliefForm, VdimRecipe, is_device,
};
use brdfc::inspect::Kind;
use brdfc_terminal::words::format_number;
use std::ffi::{OsStr, OsString};
use std::path::Path;

/// Returns the asset's name: `--name`, or the name of the output folder.
pub(super) fn asset_name(arguments: &Arguments) -> Result<String, Error> {
    let folder = || {
        let whole = std::path::absolute(&arguments.out).ok()?;
        let path = whole.components().next_back()?;
        Some(path.as_os_str().to_string_lossy().into_owned())
    };
    let name = arguments.name.clone().or_else(folder).unwrap_or_default();
    let wrong = |text: &str| {
        Error::usage(match arguments.name {
            Some(_) => format!("--name: found {name:?}, {text}"),
            None => format!("--out: found {name:?}, which names the asset, {text}; or choose a --name"),
        })
    };
    let allowed = |c: char| c.is_alphanumeric() || matches!(c, '-' | '_' | '.' | ' ');
    if name.is_empty() || name.starts_with('.') || name.trim() != name || !name.chars().all(allowed) {
        return Err(wrong("expected letters, digits, -_., and spaces between them"));
    }
    if is_device(&name) {
        return Err(wrong("expected a name that Windows does not reserve for a device"));
    }
    Ok(name)
}

/// Checks all outputs before any work starts.
pub(super) fn check_outputs(arguments: &Arguments, name: &str) -> Result<(), Error> {
    check_folder(&arguments.out)?;
    let materials: Vec<Input> = arguments.material.iter().map(|text| named_material(text).1).collect();
    let optional = [&arguments.geometry, &arguments.views, &arguments.lights, &arguments.colour, &arguments.weights];
    let inputs = [&arguments.meso].into_iter().chain(&materials).chain(optional.into_iter().flatten());
    let inputs: Vec<&Path> = inputs.filter_map(Input::path).collect();
    refuse_overwriting("--out", &arguments.out.join(format!("{name}.ktx2")), &inputs)?;
    refuse_same_outputs(&[("MESO", arguments.meso.path()), ("--out", Some(&arguments.out))])?;
    if arguments.image_format.is_some() && arguments.write_images.is_none() {
        return Err(Error::usage("--image-format requires --write-images"));
    }
    let [images, flat] = [("--write-images", &arguments.write_images), ("--write-flat", &arguments.write_flat)]
        .map(|(flag, folder)| (flag, folder.as_deref()));
    refuse_same_outputs(&[("--out", Some(&arguments.out)), images, flat])?;
    let absolute = |path: Option<&Path>| path.and_then(|path| std::path::absolute(path).ok());
    if let (Some(images), Some(flat)) = (absolute(images.1), absolute(flat.1))
        && (flat.starts_with(&images) || images.starts_with(&flat))
    {
        return Err(Error::usage("--write-images and --write-flat: one is inside the other; choose separate folders"));
    }
    for (flag, folder) in [images, flat] {
        let Some(folder) = folder else { continue };
        check_folder(folder)?;
        refuse_overwriting(flag, folder, &inputs)?;
        if arguments.bounces > 0 {
            let text = format!("{flag} does not apply to --bounces: the images would lack the light of bounces");
            return Err(Error::usage(text));
        }
        if std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
            let text = format!("{flag}: {} is not empty; choose a new or empty folder", folder.display());
            return Err(Error::usage(text));
        }
    }
    Ok(())
}

/// Checks that at most one input is standard input.
pub(super) fn check_inputs(arguments: &Arguments) -> Result<(), Error> {
    let materials: Vec<Input> = arguments.material.iter().map(|text| named_material(text).1).collect();
    let mut inputs = vec![("MESO", Some(&arguments.meso))];
    inputs.extend(materials.iter().map(|input| ("--material", Some(input))));
    for (option, input) in [
        ("--geometry", &arguments.geometry),
        ("--views", &arguments.views),
        ("--lights", &arguments.lights),
        ("--colour", &arguments.colour),
        ("--weights", &arguments.weights),
    ] {
        inputs.push((option, input.as_ref()));
    }
    refuse_stdin_twice(&inputs)
}

/// Resolves the surface and its materials.
pub(super) fn meso_options(arguments: &Arguments, is_stack: bool) -> Result<MesoOptions, Error> {
    check_placement(arguments, is_stack)?;
    let geometry = if is_stack { arguments.geometry.clone() } else { Some(arguments.meso.clone()) };
    for (option, value) in [("height-scale", arguments.height_scale), ("height-offset", arguments.height_offset)] {
        if let Some(value) = value
            && !(-10.0..=10.0).contains(&value)
        {
            return Err(Error::usage(format!("--{option}: found {}, expected -10 to 10 tiles", format_number(value))));
        }
    }
    if let Some(tile) = arguments.tile
        && !(tile.is_finite() && tile > 0.0)
    {
        return Err(Error::usage(format!("--tile: found {}, expected a finite length above 0", format_number(tile))));
    }
    let kind = geometry.as_ref().map(Kind::of).transpose()?;
    // Files of other kinds are refused when they are opened.
    let known = matches!(kind, None | Some(Kind::Structure | Kind::Mesh | Kind::Image));
    let (no_mesh, no_map) = (known && kind != Some(Kind::Mesh), known && kind != Some(Kind::Image));
    let flags = [
        (no_mesh && arguments.tile.is_some(), "--tile", "meshes"),
        (no_map && arguments.height_scale.is_some(), "--height-scale", "height maps"),
        (no_map && arguments.height_offset.is_some(), "--height-offset", "height maps"),
    ];
    let what = match kind {
        None => "a plane",
        Some(Kind::Image) => "a height map",
        Some(kind) => kind.name(),
    };
    refuse_flags(what, &flags)?;
    let materials = arguments.material.iter().map(|text| named_material(text)).collect();
    Ok(MesoOptions {
        geometry,
        tile: arguments.tile.unwrap_or(1.0),
        height_scale: arguments.height_scale.unwrap_or(0.1),
        height_offset: arguments.height_offset.unwrap_or(0.0),
        materials,
        colour: arguments.colour.clone(),
        weights: arguments.weights.clone(),
    })
}

/// Rejects options that would have no effect.
fn check_placement(arguments: &Arguments, is_stack: bool) -> Result<(), Error> {
    if is_stack {
        let for_surfaces = [
            (!arguments.material.is_empty(), "--material"),
            (arguments.colour.is_some(), "--colour"),
            (arguments.weights.is_some(), "--weights"),
            (arguments.bounces > 0, "--bounces"),
            (arguments.write_images.is_some(), "--write-images"),
            (arguments.views.is_some(), "--views"),
            (arguments.lights.is_some(), "--lights"),
        ];
        let flags = for_surfaces.map(|(given, flag)| (given, flag, "surfaces"));
        refuse_flags("an ordinary BTF", &flags)?;
        let is_file = arguments.meso.path().is_some_and(Path::is_file);
        let given = is_file && arguments.reading.codes.is_some();
        refuse_flags("a .btf file", &[(given, "--photographs", "folders of images")])?;
    } else {
        let allowed = "ordinary BTFs (a folder of images or a .btf file)";
        let flags =
            [(arguments.geometry.is_some(), "--geometry"), (arguments.reading.codes.is_some(), "--photographs")];
        refuse_flags("surfaces", &flags.map(|(given, flag)| (given, flag, allowed)))?;
    }
    let brdf = arguments.reflectance == Reflectance::Brdf;
    let of_factors = [
        (arguments.fill.is_some() && arguments.write_flat.is_none(), "--fill"),
        (arguments.bounces > 0, "--bounces"),
        (arguments.max_bytes.is_some(), "--max-bytes"),
    ];
    let flags = of_factors.map(|(given, flag)| (brdf && given, flag, "--reflectance factors and pwt"));
    refuse_flags("--reflectance brdf", &flags)?;
    refuse_flags("an ordinary BTF", &[(is_stack && brdf, "--reflectance brdf", "surfaces with materials")])
}

/// Splits `NAME=INPUT`, or returns an input alone. An `=` inside an address does not separate a name.
fn named_material(text: &OsStr) -> (Option<String>, Input) {
    let input = Input::from(text.to_owned());
    match split_name(text) {
        Some((name, source)) if input.path().is_some_and(|path| !path.exists()) => (Some(name), source.into()),
        _ => (None, input),
    }
}

/// Splits the text at the first `=`.
#[cfg(unix)]
fn split_name(text: &OsStr) -> Option<(String, OsString)> {
    use std::os::unix::ffi::OsStrExt;
    let bytes = text.as_bytes();
    let (name, source) = bytes.split_at(bytes.iter().position(|byte| *byte == b'=')?);
    Some((str::from_utf8(name).ok()?.to_owned(), OsStr::from_bytes(&source[1..]).to_owned()))
}

/// Splits the text at the first `=`.
#[cfg(not(unix))]
fn split_name(text: &OsStr) -> Option<(String, OsString)> {
    let (name, source) = text.to_str()?.split_once('=')?;
    Some((name.to_owned(), source.into()))
}

/// Resolves the recipe.
pub(super) fn recipe(arguments: &Arguments) -> Result<FlattenRecipe, Error> {
    let flat_texels = arguments.flat_texels.unwrap_or(arguments.texels as usize);
    for (flag, texels) in [("--texels", arguments.texels as usize), ("--flat-texels", flat_texels)] {
        if !(4..=2048).contains(&texels) || !texels.is_power_of_two() {
            return Err(Error::wrong_usage(flag, texels, TEXELS));
        }
    }
    let views = direction_set("views", arguments.views.as_ref().unwrap_or(&default_set()))?;
    let lights = arguments.lights.as_ref().map_or(Ok(views.clone()), |lights| direction_set("lights", lights))?;
    Ok(FlattenRecipe {
        texels: arguments.texels,
        relief: relief(arguments)?,
        flat_texels,
        views,
        lights,
        fill: arguments.fill.unwrap_or(FillMethod::Poisson),
        bounces: arguments.bounces,
        reflectance: arguments.reflectance,
        target: target(arguments)?,
    })
}

/// Views of an indirection map: the paper's choice.
const INDIRECTION: [u32; 2] = [16, 16];
const LARGEST_ANGLE: f64 = 80.0;
const OVERSAMPLING: u32 = 2;

/// Resolves the form of the relief.
fn relief(arguments: &Arguments) -> Result<ReliefForm, Error> {
    let Arguments { indirection, largest_angle, oversampling, shadows, .. } = arguments;
    if arguments.relief == Relief::Layers {
        let of = "--relief vdim";
        let flags = [
            (indirection.is_some(), "--indirection", of),
            (largest_angle.is_some(), "--largest-angle", of),
            (oversampling.is_some(), "--oversampling", of),
            (arguments.compact, "--compact", of),
            (shadows.is_some(), "--shadows", of),
        ];
        refuse_flags("--relief layers", &flags)?;
        return Ok(ReliefForm::Layers);
    }
    let largest_angle = largest_angle.unwrap_or(LARGEST_ANGLE);
    if !(1.0..=90.0).contains(&largest_angle) {
        return Err(Error::wrong_usage("--largest-angle", format_number(largest_angle), "1 to 90 degrees"));
    }
    let [polar_angles, azimuth_rows] = indirection.unwrap_or(INDIRECTION);
    Ok(ReliefForm::Vdim(VdimRecipe {
        polar_angles,
        azimuth_rows,
        largest_angle,
        oversampling: oversampling.unwrap_or(OVERSAMPLING),
        shadows: shadows.unwrap_or(Shadows::Lights) == Shadows::Lights,
        compact: arguments.compact,
    }))
}

/// Default mean ΔE of the reflectance over visible texels: well below a visible difference side by side.
const MAX_DELTA_E: f64 = 0.7;

/// Resolves the target of the reflectance.
fn target(arguments: &Arguments) -> Result<FactoredTarget, Error> {
    if let Some(found) = arguments.max_delta_e.filter(|e| !(*e > 0.0 && *e <= 100.0)) {
        return Err(Error::wrong_usage("--max-delta-e", format_number(found), "above 0, up to 100"));
    }
    Ok(match arguments.max_bytes {
        Some(bytes) => FactoredTarget::Bytes(bytes),
        None => FactoredTarget::Error(arguments.max_delta_e.unwrap_or(MAX_DELTA_E)),
    })
}
