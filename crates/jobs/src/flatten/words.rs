//! Summaries and notes about flat BTFs.

use super::asset::{AssetFile, FlatAsset, Settings};
use brdfc_core::words::{bytes, percent};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::probes::ColourErrors;
use brdfc_flat_btf::weld::WeldReport;

/// Texels per side, and views, below which steps are visible on a plane that fills a rendering.
const FEW_TEXELS: usize = 128;
const FEW_VIEWS: usize = 40;

/// Notes about an asset: repairs, texels that no view sees, and low resolutions.
pub fn remarks(asset: &AssetFile) -> Vec<String> {
    let mut lines = asset.report.repairs.as_ref().map(repairs_summary).unwrap_or_default();
    if asset.report.never_seen > 0 {
        lines.push(format!("no view sees {} of the texels", percent(asset.unseen())));
    }
    let Settings { flat_texels, texels, views, .. } = &asset.settings;
    if *flat_texels < FEW_TEXELS || (*texels as usize) < FEW_TEXELS || views.1 < FEW_VIEWS {
        lines.push(format!(
            "{texels} and {flat_texels} texels per side and {} views are enough for previews only: outlines and \
             highlights show steps; the defaults, 256 texels and 81 views, look smooth from nearby",
            views.1
        ));
    }
    lines
}

/// Message if the factors miss their target; `None` if they meet it.
pub fn missed(asset: &AssetFile) -> Option<String> {
    let (Some(FactoredTarget::Error(most)), Some(factored)) = (asset.settings.factored, &asset.report.factored) else {
        return None;
    };
    let found = f64::from(factored.errors.seen_mean);
    (found > most).then(|| {
        format!(
            "--max-delta-e: found a mean ΔE of {found:.3} with {} components, the best of {} that were tried, \
             expected at most {most}",
            factored.components,
            factored.tried.len()
        )
    })
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
    let (report, settings) = (&asset.report, &asset.settings);
    let (views, lights) = (&settings.views, &settings.lights);
    let stretch = &report.parameterisation.after;
    let mut facts = vec![
        ("source", asset.source.clone()),
        ("texels", format!("{0} x {0} flat, {1} x {1} on the plane", settings.flat_texels, settings.texels)),
        ("views x lights", format!("{} ({}) x {} ({})", views.1, views.0, lights.1, lights.0)),
        ("heights", format!("{} to {} tiles", height(report.heights[0]), height(report.heights[1]))),
        ("stretch", format!("{:.3} (1 is even), largest {:.2}", stretch.l2, stretch.largest)),
        ("texels seen by one view", format!("{}, mean over the views", percent(report.seen))),
        ("texels seen by any view", percent(1.0 - asset.unseen())),
    ];
    if let Some(factored) = &report.factored {
        let shadows = if factored.shadowed { ", a shadow per light" } else { "" };
        let (stored, whole) = (factored.gpu_bytes, asset.gpu_bytes_of_views());
        let share = whole as f64 / stored.max(1) as f64;
        let text = format!("{} components{shadows}: {} on a GPU", factored.components, bytes(stored));
        facts.push(("views", format!("{text}, {} unfactored ({share:.0}:1)", bytes(whole))));
    }
    facts.push(("size", format!("{}, {} on a GPU", bytes(*file), bytes(*gpu_bytes))));
    facts
}

/// Its measured errors with their names.
pub fn errors(asset: &AssetFile) -> Vec<(&'static str, ColourErrors)> {
    let errors = &asset.report.errors;
    let factored = asset.report.factored.as_ref().map(|facts| facts.errors);
    let pairs = asset.settings.views.1 * asset.settings.lights.1;
    let samples = factored.map_or(0, |errors| errors.texels as usize * pairs);
    let colour = |figures: [f32; 3]| {
        let [mean, p95, max] = figures.map(f64::from);
        ColourErrors { samples, mean, p95, max }
    };
    [
        ("ΔE at sampled directions", errors.at_samples),
        ("ΔE between sampled directions", errors.between_samples),
        ("ΔE of the light form", errors.light_form),
        (
            "ΔE of factors, where seen",
            factored.map(|errors| colour([errors.seen_mean, errors.seen_p95, errors.seen_max])),
        ),
    ]
    .into_iter()
    .filter_map(|(name, error)| Some((name, error?)))
    .collect()
}
