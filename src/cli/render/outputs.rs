//! Image files and text of a verification.

use super::arguments::Arguments;
use crate::output::{
    refuse_missing_folder, refuse_other_extension, refuse_overwriting, refuse_same_outputs, write_file,
};
use crate::{Error, table};
use brdfc::Input;
use brdfc::render::{
    LinearImage, MaterialVerification, Verification, Views, difference_panel, rgb_png, sheet, to_exr, to_panel, to_png,
};
use std::path::{Path, PathBuf};

fn extension(path: &Path) -> String {
    path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase()
}

/// Flags of image files, with their values and allowed extensions.
fn files(arguments: &Arguments) -> [(&'static str, &Option<PathBuf>, &'static [&'static str]); 7] {
    [
        ("--output", &arguments.output, &["png", "exr"]),
        ("--reference", &arguments.reference, &["png", "exr"]),
        ("--difference", &arguments.difference, &["png"]),
        ("--sheet", &arguments.sheet, &["png"]),
        ("--contact", &arguments.contact, &["png"]),
        ("--maps", &arguments.adaptive.maps, &["png"]),
        ("--rates", &arguments.adaptive.rates, &["png"]),
    ]
}

/// Rejects outputs that would overwrite an image that a manifest names.
pub(super) fn check_not_over(arguments: &Arguments, input: &Path) -> Result<(), Error> {
    let given = files(arguments).into_iter().filter_map(|(flag, path, _)| Some((flag, path.as_deref()?)));
    given.into_iter().try_for_each(|(flag, path)| refuse_overwriting(flag, path, &[input]))
}

/// Checks all outputs before any work starts.
pub(super) fn check(arguments: &Arguments) -> Result<(), Error> {
    let files = files(arguments);
    refuse_same_outputs(&files.each_ref().map(|(flag, path, _)| (*flag, path.as_deref())))?;
    for (flag, path, allowed) in files {
        let Some(path) = path else { continue };
        refuse_other_extension(flag, path, allowed)?;
        refuse_missing_folder(path)?;
        let adaptive = &arguments.adaptive;
        let lighting = [adaptive.environment.as_ref(), adaptive.texture.as_ref()];
        let given = [Some(&arguments.input), arguments.source.as_ref()].into_iter().chain(lighting);
        let inputs: Vec<&Path> = given.flatten().filter_map(Input::path).collect();
        refuse_overwriting(flag, path, &inputs)?;
    }
    Ok(())
}

/// Writes the requested images.
pub(super) fn write(arguments: &Arguments, views: &Views, exposure: f64) -> Result<(), Error> {
    write_images(arguments, &views.shader, views.reference(), exposure)
}

/// Writes the requested images of a rendering and its reference.
pub(super) fn write_images(
    arguments: &Arguments,
    shader: &LinearImage,
    reference: &LinearImage,
    exposure: f64,
) -> Result<(), Error> {
    let image = |path: &Path, image: &LinearImage| {
        write_file(path, &if extension(path) == "exr" { to_exr(image) } else { to_png(image, exposure) })
    };
    if let Some(path) = &arguments.output {
        image(path, shader)?;
    }
    if let Some(path) = &arguments.reference {
        image(path, reference)?;
    }
    if arguments.difference.is_none() && arguments.sheet.is_none() {
        return Ok(());
    }
    let difference = difference_panel(shader, reference, exposure);
    if let Some(path) = &arguments.sheet {
        let panels = [to_panel(shader, exposure), to_panel(reference, exposure), difference.clone()];
        write_file(path, &rgb_png(&sheet(&panels)))?;
    }
    if let Some(path) = &arguments.difference {
        write_file(path, &rgb_png(&difference))?;
    }
    Ok(())
}

/// Formats the verification of a rendering.
pub(super) fn text(verification: &Verification) -> String {
    let v = verification;
    let mut text = head(v, &format!(", exposure {}", table::significant(v.exposure)));
    for part in &v.parts {
        text += &format!("{}: {}, {}\n", part.part, part.material, table::bytes(part.bytes_on_gpu));
    }
    if let Some(bytes) = v.environment_bytes_on_gpu {
        text += &format!("environment: {}\n", table::bytes(bytes));
    }
    text.push('\n');
    let rows = v.rows().into_iter().map(|(name, difference)| {
        let mut row = vec![name.to_owned()];
        row.extend(table::image_row(difference));
        row
    });
    let mut header = vec!["ΔE of CIE L*a*b* over surfaces"];
    header.extend(table::IMAGE_HEADER);
    text + &table::plain(&header, rows)
}

/// Formats scene, size and adapter; `more` follows the number of samples.
fn head(v: &Verification, more: &str) -> String {
    let Verification { scene, width, height, samples, adapter, .. } = v;
    let software = if adapter.software { ", a software driver" } else { "" };
    format!("{scene}, {width} x {height} pixels, {samples} samples each{more}\ndrawn by {}{software}\n", adapter.name)
}

/// Formats the verifications of several materials.
pub(super) fn contact_text(materials: &[MaterialVerification]) -> String {
    let rows = materials.iter().map(|material| {
        let v = &material.verification;
        let total = v.total.as_ref().map(|total| &total.delta_e);
        let figures = [total.map(|e| e.mean), total.map(|e| e.p95), total.map(|e| e.max)];
        let parts = [v.codec.as_ref().map(|codec| codec.delta_e.mean), Some(v.shading.delta_e.mean)];
        let mut row = vec![material.material.clone(), table::bytes(material.bytes_on_gpu)];
        row.extend(figures.into_iter().chain(parts).map(|e| e.map_or("-".to_owned(), |e| format!("{e:.3}"))));
        row
    });
    let header = ["material", "on GPU", "ΔE", "95 %", "max", "of the codec", "of the shader"];
    let head = materials.first().map_or_else(String::new, |first| head(&first.verification, ""));
    format!("{head}\n{}", table::plain(&header, rows))
}
