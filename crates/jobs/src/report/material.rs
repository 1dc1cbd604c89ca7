//! The report of one encoded material.

use super::fit::{Reliability, fit_error};
use crate::encode::{AveragingCost, CodecReport, EncodedPack, Trial};
use crate::pack_files::entries;
use brdfc_codec::HIGHLIGHT;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_core::words::{bytes, percent};
use brdfc_core::{Darkest, StrayRows, Tally};
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::compare::Comparison;
use brdfc_metrics::fit_error::FitError;
use brdfc_source::open::Opened;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Report of one encoded material. The same input, options and version give the same report: times are in separate
/// [`StageTime`]s.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct MaterialReport {
    /// Measured samples in the input; 0 for analytic models.
    pub samples_in: u64,
    /// Values of the source from which the pack was made; symmetry gives the others.
    pub evaluated: u64,
    /// Colour channels, 1 or 3.
    pub channels: u32,
    /// Report of its codec.
    pub codec: CodecReport,
    /// Texture fetches of a look-up.
    pub fetches: u32,
    /// Bytes of the pack's file.
    pub bytes_on_disk: u64,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Directions that it covers; errors are over these.
    pub directions: DirectionRange,
    /// Bytes on a GPU that it saves compared with a pack for all directions.
    pub cropped_bytes: u64,
    /// Bytes on a GPU of a pack that meets the same limits over all directions, if a search within a range found one.
    #[serde(default)]
    pub of_all_directions: Option<u64>,
    /// `μ` of the pack, 1/sr: the mean of the samples that the encoder used.
    pub mean: f64,
    /// Filtered pack against source, at independent test directions.
    pub off_grid: Comparison,
    /// Error of the fit to samples; absent for sources that are not fitted.
    #[serde(default)]
    pub fit: Option<FitError>,
    /// Rows of the input with a negative channel, which was raised to 0.
    pub rows_raised: u64,
    /// Samples of the input with the smallest value of each channel; absent for models, and if all samples have the same value above 0.
    #[serde(default)]
    pub darkest: Option<Darkest>,
    /// Rows of a scan whose azimuth of incidence differs from the others, if any.
    pub stray_rows: Option<StrayRows>,
    /// First and last wavelength, nm, of spectra that lack a part of the visible range which colours depend on.
    pub partial_spectrum: Option<[f64; 2]>,
    /// Counts of repairs while the pack was made.
    #[serde(rename = "repaired")]
    pub repairs: Tally,
    /// Cost of symmetrising values, if requested.
    pub averaging: Option<AveragingCost>,
    /// Packs that were tried, from coarse to fine; empty if the options determine the pack.
    pub tried: Vec<Trial>,
    /// Limits that no pack that was tried meets; the pack is then the best of them.
    pub missed: Option<String>,
    /// The pack's key/value data `brdfc.*` in Base64, for loaders that drop it. Layouts: formats/src/*/spec.md.
    #[serde(default)]
    pub entries: BTreeMap<String, String>,
}

impl MaterialReport {
    /// Reports a pack and its source.
    ///
    /// # Errors
    /// Returns an error if cancelled.
    pub fn new(encoded: &EncodedPack, opened: &Opened, progress: &dyn Progress) -> Result<Self, Cancelled> {
        let (source, input) = (opened.source.as_ref(), &opened.facts);
        let directions = encoded.pack.directions();
        Ok(Self {
            samples_in: input.samples(),
            fit: fit_error(source, directions, progress)?,
            rows_raised: input.rows_raised(),
            darkest: input.darkest(),
            stray_rows: input.stray_rows(),
            partial_spectrum: input.partial_spectrum(),
            evaluated: encoded.evaluated,
            channels: encoded.pack.channels(),
            codec: encoded.codec.clone(),
            fetches: encoded.pack.fetches(),
            bytes_on_disk: encoded.bytes.len() as u64,
            bytes_on_gpu: encoded.pack.gpu_bytes(),
            directions,
            cropped_bytes: encoded.cropped_bytes,
            of_all_directions: encoded.of_all_directions,
            mean: encoded.pack.mean().into(),
            off_grid: encoded.off_grid.clone(),
            repairs: encoded.tally,
            averaging: encoded.averaging,
            tried: encoded.tried.clone(),
            missed: encoded.missed.clone(),
            entries: entries(&encoded.bytes),
        })
    }
}

/// Wall-clock time of one stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct StageTime {
    /// Name of the stage, such as `fit`.
    pub stage: String,
    /// Wall-clock time in seconds.
    pub seconds: f64,
}

/// Difference of albedos above which it is reported.
const ALBEDO: f64 = 0.05;

/// Albedo of a source above which it is reported as not energy-conserving. Measurements at grazing angles exceed 1 slightly.
const ENERGY: f64 = 1.1;
/// Albedos outside this range suggest values in another unit. The blackest coatings reflect a few ten-thousandths.
const USUAL_ALBEDO: [f64; 2] = [1e-4, 10.0];

/// Share of the darkest samples above which they are reported.
const MANY_DARKEST: f64 = 0.05;

/// Hint for albedos outside the usual range.
const UNITS: &str = "; check the unit of its values, which is 1/sr";

/// Note on many samples with the smallest value.
fn darkest_summary(darkest: Darkest, all: u64) -> Option<String> {
    let Darkest { value, samples } = darkest;
    let share = samples as f64 / all.max(1) as f64;
    let meaning = match value == [0.0; 3] {
        true => "are 0 in all channels, which counts as measured; leave out samples that were not".to_owned(),
        false => {
            let [r, g, b] = value;
            format!(
                "have the smallest value, {r:.3} {g:.3} {b:.3}: if it is the detector's limit, the material is darker there"
            )
        }
    };
    (share > MANY_DARKEST).then(|| format!("{samples} of {all} samples ({:.1} %) {meaning}", 100.0 * share))
}

/// Notes on a material, one per line; empty for a clean source.
pub fn remarks(report: &MaterialReport) -> Vec<String> {
    let mut lines = Vec::new();
    if report.rows_raised > 0 {
        let share = 100.0 * report.rows_raised as f64 / report.samples_in.max(1) as f64;
        let (raised, all) = (report.rows_raised, report.samples_in);
        lines.push(format!("{raised} of {all} rows ({share:.1} %) had a negative channel, which was raised to 0"));
    }
    lines.extend(report.darkest.and_then(|darkest| darkest_summary(darkest, report.samples_in)));
    lines.extend(report.stray_rows.map(|strays| strays.summary()));
    lines.extend(report.partial_spectrum.map(|[first, last]| {
        format!(
            "spectra cover {first} to {last} nm: their values at the ends are used for the rest of the visible range"
        )
    }));
    lines.extend(repairs_summary(&report.repairs));
    let source = Reliability::of(report.fit, &report.off_grid);
    lines.extend(source.remarks(report.off_grid.rendering.delta_e.mean));
    if source.black {
        return lines;
    }
    if let Some(AveragingCost { delta_e, relative_error }) = report.averaging
        && (delta_e >= 0.005 || relative_error >= 5e-5)
    {
        let relative_error = percent(relative_error);
        lines.push(format!("symmetrising alone causes a ΔE of {delta_e:.2} and ε_r of {relative_error}"));
    }
    if let Some(highlight) = report.off_grid.highlight.filter(|highlight| highlight.retained() < HIGHLIGHT) {
        lines.push(format!("the highlight keeps {}", highlight.summary()));
    }
    let largest = report.off_grid.albedo.iter().flat_map(|point| point.reference).fold(0.0, f64::max);
    let [least, most] = USUAL_ALBEDO;
    if largest > ENERGY {
        let times = if largest < 1000.0 { format!("{largest:.2}") } else { format!("{largest:.1e}") };
        let units = if largest > most { UNITS } else { "" };
        let what = "not energy-conserving: the source reflects up to";
        lines.push(format!("{what} {times} times the light that reaches it{units}"));
    } else if largest < least && report.directions.is_all() {
        let share = percent(largest);
        lines.push(format!("the source reflects at most {share} of the light that reaches it{UNITS}"));
    }
    let whole = largest.max(1.0);
    // Relative to the albedo of sources that are not energy-conserving.
    if report.off_grid.albedo_max_difference > ALBEDO * whole {
        let most = report.off_grid.albedo_max_difference;
        lines.push(format!(
            "the albedo error is up to {}; the ΔE of a ball does not show errors of narrow or grazing light",
            if most < 1000.0 { format!("{most:.3}") } else { format!("{most:.1e}") }
        ));
    }
    if let Some(all) = report.of_all_directions.filter(|all| *all < report.bytes_on_gpu) {
        lines.push(format!(
            "the limits over the directions of the uses are harder to meet than over all directions: the pack has {} \
             instead of {}",
            bytes(report.bytes_on_gpu),
            bytes(all)
        ));
    }
    let on_grid = report.codec.on_grid().map(|norms| (norms, "on the grid"));
    for (norms, place) in on_grid.into_iter().chain([(&report.off_grid.norms, "at independent test directions")]) {
        if 2 * norms.below_floor > norms.samples {
            let share = 100.0 * norms.below_floor as f64 / norms.samples as f64;
            lines.push(format!("{share:.1} % of the samples {place} are below 0.1 % of the mean; ε_r excludes them"));
        }
    }
    lines
}

/// Messages about repairs, one per kind; empty for a clean source.
pub fn repairs_summary(tally: &Tally) -> Vec<String> {
    let share = |count: u64| format!("{:.1} %", 100.0 * count as f64 / tally.evaluations.max(1) as f64);
    [
        (tally.partly_invalid, "interpolations left out invalid cells"),
        (tally.nearest_valid, "interpolations had no valid cell and took the nearest"),
        (tally.fell_to_linear, "local fits fell back to linear degree"),
        (tally.fell_to_constant, "local fits fell back to a weighted mean"),
        (tally.clamped_to_neighbours, "local fits were clamped to the range of their neighbours"),
        (tally.negative_raised, "values were negative or NaN and were raised to 0"),
        (tally.largest_lowered, "values were lowered to the largest that a pack can store"),
    ]
    .into_iter()
    .filter(|(count, _)| *count > 0)
    .map(|(count, what)| format!("{count} of {} ({}) {what}", tally.evaluations, share(count)))
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{PackRecipe, encode};
    use brdfc_formats::crop::Elevations;
    use brdfc_source::open::open;

    fn range(light: [f32; 2], view: [f32; 2]) -> DirectionRange {
        let [light, view] = [light, view].map(|[from, to]| Elevations { from, to });
        DirectionRange { light, view }
    }

    /// A scan of which the range leaves little but the highlight took 126.7 KiB within the range, and 1.9 KiB over all directions.
    #[test]
    fn a_harder_range_is_reported() {
        let Some(path) = brdfc_testing::shared_data("rgl/vch_golden_yellow_rgb.bsdf") else { return };
        let opened = open(&path, None).expect("a source");
        let source = opened.source.as_ref();
        let encoded = |directions: DirectionRange| {
            let mut recipe = PackRecipe::default();
            recipe.limit_directions(directions);
            let made = encode(source, &recipe, &()).expect("a pack");
            let lines = remarks(&MaterialReport::new(&made, &opened, &()).expect("it is not cancelled"));
            (made.pack.gpu_bytes(), lines.iter().any(|line| line.contains("harder to meet than over all")))
        };
        let (bytes, harder) = encoded(range([85.0, 90.0], [0.0, 90.0]));
        assert!(bytes < 40 << 10 && harder, "{bytes}");
        let (bytes, harder) = encoded(range([20.0, 90.0], [35.0, 90.0]));
        assert!(bytes <= 2 << 10 && !harder, "{bytes}");
        assert!(!encoded(DirectionRange::ALL).1);
    }
}
