//! Summaries and notes about flat BTFs.

use super::asset::{AssetFile, FlatAsset, Settings};
use crate::exposure::ExposureFacts;
use crate::report::fit::{Found, Reliability, check};
use crate::report::gate::GateResult;
use brdfc_codec::{ErrorLimits, FitLimits};
use brdfc_core::words::{bytes, counted, percent};
use brdfc_flat_btf::encode::{AssetErrors, AssetReport, Reflectance, ReliefForm, VdimRecipe};
use brdfc_flat_btf::factored::{FactoredFacts, FactoredTarget};
use brdfc_flat_btf::probes::ColourErrors;
use brdfc_flat_btf::weld::WeldReport;
use brdfc_pwt::PwtFacts;

/// Texels per side below which outlines are soft on a plane that fills a rendering.
const FEW_TEXELS: usize = 128;
/// Views below which highlights of factors and trees show steps.
const FEW_VIEWS: usize = 40;
/// Facts about trees in a summary.
const OF_TREES: [&str; 5] = ["light", "domain", "textures", "fetches", "errors"];
/// Share of the lines, in millionths, below which simplified layers are not worth a note.
const FEW_LINES: u32 = 1000;

/// Notes about an asset: repairs, texels that no view sees, and low resolutions.
pub fn remarks(asset: &AssetFile) -> Vec<String> {
    let mut lines = asset.report.repairs.as_ref().map(repairs_summary).unwrap_or_default();
    if let Some(unseen) = asset.unseen().filter(|unseen| *unseen > 0.0) {
        lines.push(format!("no view sees {} of the texels", percent(unseen)));
    }
    lines.extend(asset.exposure.iter().flat_map(ExposureFacts::notes));
    let layers = asset.report.layers.unwrap_or_default();
    let share = |lines: u32| percent(f64::from(lines) * 1e-6);
    if layers.simplified >= FEW_LINES {
        lines.push(format!(
            "{} of the vertical lines cross the surface more than three times: layers omit their thinnest parts",
            share(layers.simplified)
        ));
    }
    if layers.open >= FEW_LINES {
        lines.push(format!(
            "the surface passes through itself or is open at {} of the vertical lines: layers keep its highest side",
            share(layers.open)
        ));
    }
    let Settings { flat_texels, texels, views, .. } = &asset.settings;
    if *flat_texels < FEW_TEXELS || (*texels as usize) < FEW_TEXELS {
        lines.push(format!(
            "{texels} and {flat_texels} texels per side are enough for previews only: outlines are soft or ragged; the default, \
             256 texels, looks sharp from nearby"
        ));
    }
    if matches!(asset.report.reflectance, Reflectance::Factors | Reflectance::Pwt) && views.1 < FEW_VIEWS {
        lines.push(format!(
            "highlights show steps with {}, which is for previews only; the default is 81 views",
            counted(views.1, "view")
        ));
    }
    lines
}

/// Mean ΔE of the reflectance against the materials or images; `None` where it is not approximated.
pub fn delta_e(asset: &AssetFile) -> Option<f64> {
    let of_trees = asset.trees.as_ref().map(|trees| f64::from(trees.errors.delta_e));
    of_trees.or_else(|| Some(f64::from(asset.report.factored.as_ref()?.errors.seen_mean)))
}

/// Message if the reflectance misses its target; `None` if it meets it.
pub fn missed(asset: &AssetFile) -> Option<String> {
    let FactoredTarget::Error(most) = asset.settings.target else { return None };
    // NaN misses it.
    let found = delta_e(asset).filter(|found| !found.is_finite() || *found > most)?;
    let form = match (&asset.trees, &asset.report.factored) {
        (None, Some(factored)) => {
            let form = match factored.components {
                0 => "brdf".to_owned(),
                components => format!("{components} components"),
            };
            format!("{form} after {}", counted(factored.tried.len(), "trial"))
        }
        _ => "trees of all terms".to_owned(),
    };
    Some(format!("found a mean ΔE of {found:.3} with {form}, expected at most {most}"))
}

/// Checks of what an asset was made from, if limits are set: the same as those of packs. The error of a mixture is that of
/// each material. The surface with all its images and materials has to reflect light.
pub fn check_sources(
    asset: &AssetFile,
    materials: &[Reliability],
    limits: FitLimits,
    errors: ErrorLimits,
) -> Vec<(String, GateResult)> {
    let AssetErrors { from_surface, from_images } = asset.report.errors;
    let black = match from_images.or(from_surface) {
        Some(errors) => errors.show_nothing(),
        None => materials.iter().all(|one| one.black),
    };
    let found = Found { delta_e: delta_e(asset), relative: None, all_lights: true };
    if black {
        // Black materials say so; images may be black or saturated.
        let by_images = materials.is_empty() || materials.iter().any(|one| !one.black);
        let results = check(limits, errors, &Reliability { fit: None, black }, found).into_iter().map(|result| {
            let found = if by_images { "no error: all values are black or white".to_owned() } else { result.found };
            (asset.name.clone(), GateResult { found, ..result })
        });
        return results.collect();
    }
    let fits = asset.materials.iter().zip(materials).flat_map(|(name, one)| {
        let results = check(limits, errors, &Reliability { black: false, ..*one }, found);
        results.into_iter().map(|result| (name.clone(), result))
    });
    fits.collect()
}

/// Messages about repairs of a mesh, one per kind; empty if nothing was repaired.
pub fn repairs_summary(repairs: &WeldReport) -> Vec<String> {
    [
        (repairs.unreferenced_vertices, "unreferenced vertices were left out"),
        (repairs.degenerate_triangles, "degenerate triangles were left out"),
        (repairs.duplicate_triangles, "duplicate triangles were left out"),
        (repairs.turned_triangles, "triangles were turned over, so that they face up"),
        (repairs.exchanged_edges, "triangles without area were repaired"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect()
}

/// Formats a height with four decimals, without negative zero.
pub fn height(value: f64) -> String {
    format!("{:.4}", (value * 1e4).round() / 1e4 + 0.0)
}

/// Names and values of an asset's properties, without its errors.
pub fn facts(FlatAsset { about: asset, bytes: file, gpu_bytes, .. }: &FlatAsset) -> Vec<(&'static str, String)> {
    let (report, settings, trees) = (&asset.report, &asset.settings, &asset.trees);
    let (views, lights) = (&settings.views, &settings.lights);
    let stretch = &report.parameterisation.after;
    let mut facts = vec![
        ("source", asset.source.clone()),
        ("texels", format!("{0} x {0} flat, {1} x {1} on the plane", settings.flat_texels, settings.texels)),
        relief(settings, report),
        ("heights", format!("{} to {} tiles", height(report.heights[0]), height(report.heights[1]))),
        ("stretch", format!("{:.3} (1 is even), largest {:.2}", stretch.l2, stretch.largest)),
    ];
    let reflectance = match (&report.factored, trees) {
        (Some(factored), _) if report.reflectance == Reflectance::Brdf => {
            format!("brdf: {} on a GPU", bytes(factored.gpu_bytes))
        }
        (Some(factored), _) => {
            let residual = match factored.residual {
                0 => String::new(),
                cells => format!(", a residual of shadows of {cells} x {cells} cells per light"),
            };
            format!("factors: {} components{residual}, {} on a GPU", factored.components, bytes(factored.gpu_bytes))
        }
        (None, Some(trees)) => format!("pwt: {} on a GPU", bytes(trees.gpu_bytes)),
        (None, None) => "unknown".to_owned(),
    };
    facts.push(("reflectance", reflectance));
    let of_trees = trees.as_ref().map_or(Vec::new(), PwtFacts::summary).into_iter();
    facts.extend(of_trees.filter(|(name, _)| OF_TREES.contains(name)));
    if report.reflectance != Reflectance::Brdf {
        facts.push(("views x lights", format!("{} ({}) x {} ({})", views.1, views.0, lights.1, lights.0)));
    }
    if let (Some(seen), Some(unseen)) = (report.seen, asset.unseen()) {
        facts.push(("texels seen by one view", format!("{}, mean over the views", percent(seen))));
        facts.push(("texels seen by any view", percent(1.0 - unseen)));
    }
    facts.push(("size", format!("{}, {} on a GPU", bytes(*file), bytes(*gpu_bytes))));
    facts
}

/// Name and summary of the relief.
fn relief(settings: &Settings, report: &AssetReport) -> (&'static str, String) {
    let ReliefForm::Vdim(vdim) = &settings.relief else {
        let one = report.layers.is_some_and(|layers| layers.sheets == 1);
        return ("layers", if one { "1 sheet" } else { "3 sheets: base, top and underside" }.to_owned());
    };
    let VdimRecipe { polar_angles, azimuth_rows, largest_angle, compact, .. } = vdim;
    let form = if *compact { "compact " } else { "" };
    let shadows = if vdim.shadows {
        format!("shadows of {}", counted(settings.lights.1, "light"))
    } else {
        "no shadows".to_owned()
    };
    ("indirection map", format!("{polar_angles} x {azimuth_rows} {form}views up to {largest_angle}°, {shadows}"))
}

/// Its measured errors with their names: number of samples; mean, 95th percentile and maximum.
pub fn errors(asset: &AssetFile) -> Vec<(&'static str, usize, [f64; 3])> {
    let errors = &asset.report.errors;
    let of_reflectance = asset.report.factored.as_ref().map(|FactoredFacts { errors, .. }| {
        (errors.texels as usize, [errors.seen_mean, errors.seen_p95, errors.seen_max].map(f64::from))
    });
    let figures = |errors: ColourErrors| (errors.samples, [errors.mean, errors.p95, errors.max]);
    [
        ("ΔE from the surface", errors.from_surface.map(figures)),
        ("ΔE from the images", errors.from_images.map(figures)),
        ("ΔE of the reflectance, at texels", of_reflectance),
    ]
    .into_iter()
    .filter_map(|(name, error)| error.map(|(samples, figures)| (name, samples, figures)))
    .collect()
}
