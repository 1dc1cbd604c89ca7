//! Text tables.

pub use brdfc_core::words::{apart, bytes, percent};

use brdfc_formats::crop::DirectionRange;
use brdfc_jobs::encode::Trial;
use brdfc_jobs::report::material::MaterialReport;
use brdfc_metrics::compare::Comparison;
use brdfc_metrics::norms::Norms;
use unicode_width::UnicodeWidthStr as _;

/// Formats rows with a header, aligned to the right, without a frame.
pub fn plain(header: &[&str], rows: impl IntoIterator<Item: AsRef<[String]>>) -> String {
    aligned(header, rows, |column| column > 0)
}

/// Formats rows with a header, aligned to the left.
pub fn words(header: &[&str], rows: impl IntoIterator<Item: AsRef<[String]>>) -> String {
    aligned(header, rows, |_| false)
}

/// Makes columns as wide as their widest cell, two spaces apart.
fn aligned(header: &[&str], rows: impl IntoIterator<Item: AsRef<[String]>>, right: impl Fn(usize) -> bool) -> String {
    let header: Vec<String> = header.iter().map(|name| (*name).to_owned()).collect();
    let rows: Vec<_> = rows.into_iter().collect();
    let all = || std::iter::once(&header[..]).chain(rows.iter().map(AsRef::as_ref));
    let widths: Vec<usize> =
        (0..header.len()).map(|column| all().map(|row| row[column].width()).max().unwrap_or(0)).collect();
    let line = |row: &[String]| {
        let mut line = String::new();
        for (column, (cell, width)) in row.iter().zip(&widths).enumerate() {
            let room = " ".repeat(width - cell.width());
            line += &if right(column) { format!("{room}{cell}  ") } else { format!("{cell}{room}  ") };
        }
        line.trim_end().to_owned() + "\n"
    };
    all().map(line).collect()
}

/// Formats a row of the build table, without the material's name.
pub fn material_row(report: &MaterialReport, seconds: Option<f64>) -> Vec<String> {
    let rendering = &report.off_grid.rendering.delta_e;
    vec![
        if report.samples_in == 0 { "-".to_owned() } else { report.samples_in.to_string() },
        report.codec.variant().to_owned(),
        report.codec.size(),
        report.fetches.to_string(),
        bytes(report.bytes_on_disk),
        bytes(report.bytes_on_gpu),
        relative(&report.off_grid.norms),
        format!("{:.2}", rendering.mean),
        format!("{:.2}", rendering.p95),
        report.off_grid.highlight.map_or("-".to_owned(), |highlight| share(highlight.retained())),
        report.fit.map_or("-".to_owned(), |fit| {
            fit.error().map_or(if fit.completed { "none" } else { "-" }.to_owned(), share)
        }),
        report.fit.map_or("-".to_owned(), |fit| {
            let gaps = fit.largest_gaps();
            format!("{:.0}°, {:.0} %", gaps.farthest, 100.0 * gaps.uncovered)
        }),
        seconds.map_or("cached".to_owned(), |s| format!("{s:.2} s")),
    ]
}

/// Header of the build table.
pub const MATERIAL_HEADER: [&str; 14] = [
    "material",
    "samples in",
    "codec",
    "size",
    "fetches",
    "on disk",
    "on GPU",
    "ε_r",
    "ΔE",
    "ΔE 95 %",
    "highlight",
    "fit ε_r",
    "gaps",
    "time",
];

/// Formats the candidates of a pack, one per line; `seconds` are the durations of the trials.
pub fn trials(tried: &[Trial], seconds: &[f64]) -> String {
    let row = |(k, trial): (usize, &Trial)| {
        [
            trial.codec.clone(),
            trial.size.clone(),
            trial.fetches.to_string(),
            bytes(trial.bytes_on_gpu),
            percent(trial.relative_error),
            format!("{:.2}", trial.delta_e),
            format!("{:.2}", trial.delta_e_p95),
            trial.highlight.map_or("-".to_owned(), share),
            seconds.get(k).map_or("-".to_owned(), |s| format!("{s:.2} s")),
            if trial.meets { "yes" } else { "no" }.to_owned(),
        ]
    };
    let header =
        ["tried", "size", "fetches", "on GPU", "ε_r", "ΔE", "ΔE 95 %", "highlight", "time", "meets the limits"];
    plain(&header, tried.iter().enumerate().map(row))
}

/// Formats all norms of a comparison within a range of directions, one per line.
pub fn comparison(comparison: &Comparison, directions: DirectionRange) -> String {
    // Few pixels of a ball may be within the range, so pixels are distributed over the range instead.
    let of = if directions.is_all() { "of a ball" } else { "within the directions" };
    let Comparison { norms, rendering, .. } = comparison;
    let rows = [
        ("samples", norms.samples.to_string()),
        ("below 0.1 % of the mean, excluded from ratios", norms.below_floor.to_string()),
        ("ε, RMS difference (1/sr)", format!("{:.4e}", norms.rms)),
        ("ε_r, mean relative difference", relative(norms)),
        ("standard error of ε_r", percent(norms.relative_standard_error)),
        ("relative difference, 95th percentile", percent(norms.relative_p95)),
        ("relative difference, 99th percentile", percent(norms.relative_p99)),
        ("relative difference, maximum", percent(norms.relative_max)),
        ("RMS of log difference", format!("{:.4e}", norms.log_rms)),
        ("RMS of ln(1 + f cos θi) difference", format!("{:.4e}", norms.cosine_log_rms)),
        (&format!("ΔE {of}, mean"), format!("{:.3}", rendering.delta_e.mean)),
        (&format!("ΔE {of}, 95th percentile"), format!("{:.3}", rendering.delta_e.p95)),
        (&format!("ΔE {of}, maximum"), format!("{:.3}", rendering.delta_e.max)),
        (&format!("ΔE2000 {of}, mean"), format!("{:.3}", rendering.delta_e_2000.mean)),
        ("highlight, smallest retained fraction", highlight_text(comparison)),
        ("largest albedo difference", format!("{:.3e}", comparison.albedo_max_difference)),
        ("reciprocity error of B", percent(comparison.reciprocity)),
    ];
    let table = plain(&["norm", "value"], rows.map(|(name, value)| [name.to_owned(), value]));
    if directions.is_all() { table } else { format!("directions: {directions}\n{table}") }
}

/// Formats a fraction as a percentage with one decimal, rounded down so that it never reaches a limit.
fn share(share: f64) -> String {
    format!("{:.1} %", (1000.0 * share).floor() / 10.0)
}

fn highlight_text(comparison: &Comparison) -> String {
    comparison.highlight.map_or("none".to_owned(), |highlight| highlight.summary())
}

/// Formats `ε_r`, or a dash if no sample is above the floor.
fn relative(norms: &Norms) -> String {
    if norms.counted() == 0 { "-".to_owned() } else { percent(norms.relative_mean) }
}

/// Formats a value with three or four significant digits.
pub fn significant(value: f64) -> String {
    match value.abs() {
        0.0 => "0".to_owned(),
        a if !(1e-3..1e5).contains(&a) => format!("{value:.3e}"),
        a => format!("{value:.*}", (3 - a.log10().floor() as i32).max(0) as usize),
    }
}

/// Header of [`image_row`].
#[cfg(feature = "render")]
pub const IMAGE_HEADER: [&str; 6] = ["mean", "σ", "95 %", "max", "mean ΔE2000", "PSNR"];

/// Formats a comparison of images.
#[cfg(feature = "render")]
pub fn image_row(difference: &brdfc_metrics::image::ImageDifference) -> Vec<String> {
    let d = &difference.delta_e;
    let mut row: Vec<String> = [d.mean, d.standard_deviation, d.p95, d.max, difference.delta_e_2000.mean]
        .map(|value| format!("{value:.3}"))
        .into();
    row.push(difference.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.1} dB")));
    row
}
