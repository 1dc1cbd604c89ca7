//! The rise of rows towards the mirror direction and back to the light: whether they determine highlight and retroreflection.

use super::coordinates::polar;
use brdfc_core::source::{MAX_PEAK, MAX_RISE, PeakAt, Rise};
use brdfc_formats::direction::{DirectionPair, Vector};
use std::collections::BTreeMap;

/// Width of the groups of incidences in which rows near the mirror direction are compared, degrees.
const STEP: f64 = 5.0;
/// Maximum polar angle of incidence of these groups, degrees. Rows that are evenly apart in azimuth are farther from the mirror direction
/// at higher incidences.
const MAX_INCIDENCE: f64 = 77.5;
/// Maximum polar angle of their viewers, degrees.
const MAX_VIEW: f64 = 85.0;
/// Maximum half angle of the rows that the nearest ones are compared with, degrees. Farther ones are gaps.
const MAX_NEXT: f64 = 35.0;
/// Minimum polar angle of incidence of groups near the light, degrees: the highlight is nearer to it at others.
const MIN_INCIDENCE_OF_RETRO: f64 = 15.0;
/// Maximum half angle between light and viewer of the rows nearest to the light, degrees. Farther rows, as of goniometers whose detector
/// would block the light, say nothing about a peak.
const MAX_NEAREST_OF_RETRO: f64 = 5.0;
/// Minimum number of rows of such a group.
const MIN_ROWS: usize = 8;

/// Compares the rows nearest to the mirror direction, and those nearest to the light, with the next ones at each polar angle of
/// incidence, in steps of [`STEP`] degrees. Returns the angle at which the rows determine the peak least.
pub(crate) fn rise_to_peaks(rows: impl Iterator<Item = (DirectionPair, f64)>) -> Option<Rise> {
    // Half angle in degrees from the peak, and reflected light, of the rows of each group.
    let mut groups: BTreeMap<(bool, i32), Vec<(f64, f64)>> = BTreeMap::new();
    for (pair, value) in rows {
        let half = [0, 1, 2].map(|k| pair.incoming[k] + pair.outgoing[k]);
        let across = [0, 1, 2].map(|k| pair.incoming[k] - pair.outgoing[k]);
        let length = |v: Vector| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [incidence, view, to_mirror] = [pair.incoming, pair.outgoing, half].map(|v| polar(v).to_degrees());
        let to_light = length(across).atan2(length(half)).to_degrees();
        if incidence <= MAX_INCIDENCE && view <= MAX_VIEW {
            let reflected = value * pair.incoming[2] * pair.outgoing[2];
            let group = (incidence / STEP).round() as i32;
            groups.entry((false, group)).or_default().push((to_mirror, reflected));
            if incidence >= MIN_INCIDENCE_OF_RETRO && to_light < to_mirror {
                groups.entry((true, group)).or_default().push((to_light, reflected));
            }
        }
    }
    let rises = groups.into_iter().filter_map(|((is_retro, group), rows)| {
        let peak_at = if is_retro { PeakAt::Viewer } else { PeakAt::Mirror };
        let found = rise(peak_at, f64::from(group) * STEP, rows)?;
        (!is_retro || found.nearest <= MAX_NEAREST_OF_RETRO).then_some(found)
    });
    // The larger of both excesses.
    let unknown = |rise: &Rise| (rise.peak / MAX_PEAK).max(rise.ratio / MAX_RISE);
    rises.max_by(|a, b| unknown(a).total_cmp(&unknown(b)))
}

/// Compares the rows of one incidence (half angle in degrees, reflected light) nearest to the peak with the next ones. Returns `None`
/// if there are few rows or no peak.
fn rise(peak_at: PeakAt, incidence: f64, mut rows: Vec<(f64, f64)>) -> Option<Rise> {
    if rows.len() < MIN_ROWS {
        return None;
    }
    let mut reflected: Vec<f64> = rows.iter().map(|row| row.1).collect();
    reflected.sort_by(f64::total_cmp);
    let diffuse = reflected[reflected.len() / 5];
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Root mean square half angle and mean reflected light, less the diffuse part, of the rows within a range.
    let mean = |first: f64, last: f64| {
        let within = rows.iter().filter(|(half, _)| (first..=last).contains(half));
        let (squares, sum, count) = within.fold((0.0, 0.0, 0usize), |(squares, sum, count), (half, value)| {
            (squares + half * half, sum + value, count + 1)
        });
        ((squares / count.max(1) as f64).sqrt(), sum / count.max(1) as f64 - diffuse)
    };
    let nearest = rows[0].0;
    let apart = (1.75 * nearest).max(nearest + 0.5);
    // Values times cosines fall towards the horizon, with or without a highlight.
    let first = rows.iter().position(|(half, _)| *half >= apart).filter(|first| rows[*first].0 <= MAX_NEXT)?;
    let (before, next) = (rows[first - 1].0, rows[first].0);
    let nearest_end = 1.25 * nearest;
    let (nearest, at_nearest) = mean(nearest, nearest_end);
    let (next, at_next) = mean(next, 1.4 * next);
    // The peak between the nearest rows and these is resolved.
    let at_before = if before <= nearest_end { at_nearest } else { mean(0.8 * before, before).1 };
    if at_nearest < 0.5 * diffuse || at_nearest <= 0.0 {
        return None;
    }
    let over_next = |value: f64| (value / at_next.max(1e-3 * at_nearest).max(0.02 * diffuse)).max(1.0);
    let ratio = over_next(at_nearest);
    // D(θ) ∝ 1 / (1 + x)² with x ∝ θ²: x at the nearest, from the ratio and that of the squared angles.
    let (steps, root) = ((next / nearest.max(1e-6)).powi(2), ratio.sqrt());
    let x = if root < steps { ((root - 1.0) / (steps - root)).min(9.0) } else { 9.0 };
    Some(Rise { peak_at, incidence, nearest, next, ratio: over_next(at_before), peak: (1.0 + x).powi(2) })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows of a lobe `1 / (1 + (θ / width)²)²` over a diffuse part, from a half angle on, in even steps.
    fn rows(width: f64, first: f64, step: f64) -> Vec<(f64, f64)> {
        let row = |k: u32| {
            let half = first + step * f64::from(k);
            (half, 0.1 + 10.0 / (1.0 + (half / width).powi(2)).powi(2))
        };
        (0..40).map(row).collect()
    }

    #[test]
    fn the_peak_of_a_lobe_is_estimated_from_its_nearest_rows() {
        let found = rise(PeakAt::Mirror, 30.0, rows(3.0, 3.0, 1.0)).unwrap();
        assert_eq!((found.incidence, found.nearest), (30.0, 3.0));
        assert!((found.peak - 4.0).abs() < 0.8, "{found:?}");
    }

    #[test]
    fn wide_lobes_are_determined_and_narrow_ones_are_not() {
        for (width, first, determined) in [(10.0, 2.0, true), (5.0, 0.0, true), (2.0, 4.0, false), (0.5, 0.0, false)] {
            let found = rise(PeakAt::Mirror, 30.0, rows(width, first, 3.0)).unwrap();
            assert_eq!(found.peak <= MAX_PEAK && found.ratio <= MAX_RISE, determined, "{width} {first}: {found:?}");
        }
    }

    /// A retroreflective lobe of 2 degrees on rows that are 5 degrees apart, and a wide one.
    #[test]
    fn narrow_retroreflection_is_not_determined() {
        let rows = |width: f64| {
            let steps = || (0..13).map(|k| 0.01 + 5f64.to_radians() * f64::from(k));
            let pairs = steps().flat_map(move |theta_i| {
                steps().flat_map(move |theta_o| {
                    (0..24).map(move |k| DirectionPair::from_angles(theta_i, 0.0, theta_o, 0.02 + 0.262 * f64::from(k)))
                })
            });
            pairs.map(move |pair| {
                let cosine: f64 = (0..3).map(|k| pair.incoming[k] * pair.outgoing[k]).sum();
                (pair, 0.05 + 20.0 * (-(cosine.clamp(-1.0, 1.0).acos().to_degrees() / width).powi(2)).exp())
            })
        };
        let found = rise_to_peaks(rows(2.0)).unwrap();
        assert!(found.peak_at == PeakAt::Viewer && (found.peak > MAX_PEAK || found.ratio > MAX_RISE), "{found:?}");
        let wide = rise_to_peaks(rows(30.0)).unwrap();
        assert!(wide.peak <= MAX_PEAK && wide.ratio <= MAX_RISE, "{wide:?}");
    }

    #[test]
    fn few_rows_and_matte_ones_say_nothing() {
        assert_eq!(rise(PeakAt::Mirror, 0.0, rows(3.0, 3.0, 1.0)[..7].to_vec()), None);
        assert_eq!(rise(PeakAt::Mirror, 0.0, (0..40).map(|k| (f64::from(k), 0.3)).collect()), None);
        assert_eq!(rise(PeakAt::Mirror, 0.0, vec![(0.0, 0.0); 9]), None);
    }
}
