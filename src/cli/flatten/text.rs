//! Summary of an asset.

use crate::output::printable;
use brdfc::flatten::words::{errors, facts};
use brdfc::flatten::{FlatAsset, ImageFacts};

/// Formats the summary of an asset.
pub(crate) fn text(asset: &FlatAsset, read: &[ImageFacts], seconds: Option<f64>) -> String {
    let mut rows = facts(asset);
    for (name, _, [mean, p95, max]) in errors(&asset.about) {
        rows.push((name, format!("{mean:.2} (95 %: {p95:.1}, largest: {max:.1})")));
    }
    rows.extend(read.iter().map(|facts| (facts.image, facts.conversions.join("; "))));
    rows.extend(seconds.map(|seconds| ("time", format!("{seconds:.1} s"))));
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let lines = rows.iter().map(|(name, value)| format!("{name:width$}  {}\n", printable(value)));
    format!("{}\n", asset.about.name) + &lines.collect::<String>()
}
