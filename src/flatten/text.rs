//! What people read of an asset.

use crate::output::printable;
use crate::table::{bytes, percent};
use brdfc_flat_btf::probes::ColourErrors;
use brdfc_flat_btf::weld::WeldReport;
use brdfc_jobs::flatten::AssetFile;

/// What a user should know.
pub(super) fn remarks(asset: &AssetFile) -> Vec<String> {
    let mut lines = asset.report.repairs.as_ref().map(repairs_in_words).unwrap_or_default();
    if asset.report.never_seen > 0 {
        lines.push(format!("{} of the texels are seen by none of the views", percent(unseen(asset))));
    }
    lines
}

/// What was mended in a mesh; nothing where it was whole.
pub(crate) fn repairs_in_words(repairs: &WeldReport) -> Vec<String> {
    [
        (repairs.unreferenced_vertices, "vertices that no triangle has were left out"),
        (repairs.degenerate_triangles, "triangles with two equal corners were left out"),
        (repairs.duplicate_triangles, "triangles that were there twice were left out"),
        (repairs.turned_triangles, "triangles were turned over, so that outside is up"),
        (repairs.exchanged_edges, "triangles without area were mended"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} {what}"))
    .collect()
}

/// Share of the texels that no view sees.
fn unseen(asset: &AssetFile) -> f64 {
    asset.report.never_seen as f64 / (asset.settings.flat_texels as f64).powi(2)
}

/// Four decimals, and no negative zero.
pub(crate) fn height(value: f64) -> String {
    format!("{:.4}", (value * 1e4).round() / 1e4 + 0.0)
}

/// What people read of an asset.
pub(crate) fn text(asset: &AssetFile, seconds: Option<f64>) -> String {
    let (report, settings) = (&asset.report, &asset.settings);
    let (views, lights) = (&settings.views, &settings.lights);
    let stretch = &report.parameterisation.after;
    let mut rows = vec![
        ("source", asset.source.clone()),
        ("texels", format!("{0} x {0} flat, {1} x {1} on the plane", settings.flat_texels, settings.texels)),
        ("views x lights", format!("{} ({}) x {} ({})", views.1, views.0, lights.1, lights.0)),
        ("heights", format!("{} to {} tiles", height(report.heights[0]), height(report.heights[1]))),
        ("stretch", format!("{:.3} (1 is even), largest {:.2}", stretch.l2, stretch.largest)),
        ("texels seen by one view", format!("{}, mean over the views", percent(report.seen))),
        ("texels seen by any view", percent(1.0 - unseen(asset))),
        ("files", format!("{} in {}, {} on a GPU", bytes(asset.bytes()), asset.parts.len(), bytes(asset.gpu_bytes()))),
    ];
    for (name, error) in [
        ("ΔE at sampled directions", report.errors.at_samples),
        ("ΔE between them", report.errors.between_samples),
        ("ΔE of the light form", report.errors.light_form),
    ] {
        if let Some(ColourErrors { mean, p95, max, .. }) = error {
            rows.push((name, format!("{mean:.2} (95 %: {p95:.1}, largest: {max:.1})")));
        }
    }
    rows.extend(seconds.map(|seconds| ("time", format!("{seconds:.1} s"))));
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let lines = rows.iter().map(|(name, value)| format!("{name:width$}  {}\n", printable(value)));
    format!("{}\n", asset.name) + &lines.collect::<String>()
}
