//! Learned terms: "better approximation functions" than polynomials (section 3 of the paper). Principal components of all
//! texels, as colours under all lights, are interpolated between the lights and stored as a [`LightMap`].

use crate::components::Components;
use crate::kriging::Interpolation;
use brdfc_formats::pwt::{LightMap, MAP_SIDES};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Texels of the map per mean distance of two lights.
const TEXELS_PER_LIGHT: f64 = 3.0;
/// Width of the correction at a light, in mean distances of two lights.
const CORRECTION: f64 = 0.35;
/// Share by which corrections fall short, so that those of near lights do not overshoot between them.
const SHORT: f64 = 0.005;

/// Terms that are learned from photographs.
pub struct Learned {
    /// The terms. Term 0 is the mean.
    pub map: LightMap,
    /// For each component, its factor of each light and channel, `3 light + channel`.
    pub factors: Vec<Vec<f32>>,
    /// For each component, what is added.
    pub offsets: Vec<f32>,
}

/// Components and the mean as values at the lights: a row for each light, columns `3 term + channel`.
fn at_lights(components: &Components) -> DMatrix<f64> {
    let (entries, terms) = (components.axes.nrows(), components.axes.ncols() + 1);
    let numbers = components.mean.iter().chain(components.axes.iter()).copied();
    DMatrix::from_iterator(entries / 3, 3 * terms, numbers)
}

/// Predictions of each light of `known` from the others, and the share of each term's prediction that is used between the lights:
/// the slope of the regression of its values on the predictions, 0 to 1. Shadows and highlights of weak terms move from light to
/// light; with their share, terms that others do not predict are seen at their lights only, and more terms do no harm elsewhere.
fn predicted(known: &DMatrix<f64>, errors: &DMatrix<f64>) -> (DMatrix<f64>, Vec<f64>) {
    let predicted = known - errors * known;
    let share = |term: usize| {
        let (of_term, known) = (predicted.columns(3 * term, 3), known.columns(3 * term, 3));
        let slope = of_term.dot(&known) / of_term.norm_squared();
        // The mean is no deviation from anything.
        if term == 0 || slope.is_nan() { 1.0 } else { slope.clamp(0.0, 1.0) }
    };
    let shares = (0..known.ncols() / 3).map(share).collect();
    (predicted, shares)
}

/// Mean and components as they are seen under each light if it is left out of the interpolation; `None` if none can be.
pub fn left_out(components: &Components, interpolation: &Interpolation) -> Option<Components> {
    let (mut seen, shares) = predicted(&at_lights(components), interpolation.left_out.as_ref()?);
    scale_terms(&mut seen, &shares);
    let (entries, terms) = (components.axes.nrows(), components.axes.ncols());
    let (mean, axes) = seen.as_slice().split_at(entries);
    Some(Components { mean: DVector::from_column_slice(mean), axes: DMatrix::from_column_slice(entries, terms, axes) })
}

/// Multiplies each term, three columns, by its share.
fn scale_terms(values: &mut DMatrix<f64>, shares: &[f64]) {
    for (term, share) in shares.iter().enumerate() {
        values.columns_mut(3 * term, 3).scale_mut(*share);
    }
}

/// Mean distance of two neighbouring lights in paraboloid coordinates, if they are evenly spread.
fn spacing(lights: usize) -> f64 {
    0.9 * (PI / lights.max(1) as f64).sqrt()
}

/// Texels per side of the map for a number of lights.
pub fn map_side(lights: usize) -> u32 {
    let texels = 2.0 * TEXELS_PER_LIGHT / spacing(lights);
    (texels.min(f64::from(*MAP_SIDES.end())) as u32).next_multiple_of(8).clamp(16, *MAP_SIDES.end())
}

impl Learned {
    /// Interpolates components between the lights. Entries of components are `channel lights + light`.
    pub fn new(components: &Components, interpolation: &Interpolation, lights: &[[f32; 3]]) -> Self {
        let side = map_side(lights.len());
        let known = at_lights(components);
        let directions = LightMap::directions(side);
        let mut map = interpolation.predictions(lights, &directions) * &known;
        if let Some(errors) = &interpolation.left_out {
            scale_terms(&mut map, &predicted(&known, errors).1);
        }
        limit(&mut map, &known);
        correct(&mut map, &known, lights, side);
        // Corrections of near lights can overshoot.
        limit(&mut map, &known);
        let texels: Vec<[f32; 3]> = (0..known.ncols() / 3)
            .flat_map(|term| (0..map.nrows()).map(move |texel| (term, texel)))
            .map(|(term, texel)| [0, 1, 2].map(|channel| map[(texel, 3 * term + channel)] as f32))
            .collect();
        let map = LightMap::new(side, &texels).expect("a side in range, and clamped values");
        let (factors, offsets) = projection(&map, lights);
        Self { map, factors, offsets }
    }
}

/// Limits a map to twice the range of the known values, and to half floats: far from all lights a trend is no knowledge.
fn limit(map: &mut DMatrix<f64>, known: &DMatrix<f64>) {
    let largest = f64::from(LightMap::LARGEST);
    for (mut texels, known) in map.column_iter_mut().zip(known.column_iter()) {
        let (low, high) = (known.min(), known.max());
        let (least, most) = ((2.0 * low - high).max(-largest), (2.0 * high - low).min(largest));
        texels.iter_mut().for_each(|texel| *texel = texel.max(least).min(most));
    }
}

/// Corrects a map so that its filtered values at the lights are nearly the known ones: adds a narrow bump at each light. Between
/// the lights it stays the interpolation.
fn correct(map: &mut DMatrix<f64>, known: &DMatrix<f64>, lights: &[[f32; 3]], side: u32) {
    let width = CORRECTION * spacing(lights.len());
    let at = |k: u32| (f64::from(k) + 0.5) * 2.0 / f64::from(side) - 1.0;
    let bumps = DMatrix::from_fn(map.nrows(), lights.len(), |texel, light| {
        let [x, y, z] = lights[light].map(f64::from);
        let (u, v) = (at(texel as u32 % side), at(texel as u32 / side));
        let squared = (u - x / (1.0 + z)).powi(2) + (v - y / (1.0 + z)).powi(2);
        (-0.5 * squared / (width * width)).exp()
    });
    let seen = |texels: &DMatrix<f64>| {
        let mut values = DMatrix::zeros(lights.len(), texels.ncols());
        for (mut row, light) in values.row_iter_mut().zip(lights) {
            LightMap::taps(side, *light).iter().for_each(|(at, weight)| row += texels.row(*at) * f64::from(*weight));
        }
        values
    };
    let mut system = seen(&bumps);
    for k in 0..lights.len() {
        system[(k, k)] += SHORT;
    }
    if let Some(amounts) = system.lu().solve(&(known - seen(map))) {
        *map += bumps * amounts;
    }
}

/// Least-squares projection of values at the lights on the terms of a map: factors and offsets of each component.
fn projection(map: &LightMap, lights: &[[f32; 3]]) -> (Vec<Vec<f32>>, Vec<f32>) {
    let terms = DMatrix::from_fn(3 * lights.len(), map.terms(), |entry, term| {
        f64::from(map.value(term, lights[entry / 3])[entry % 3])
    });
    let axes = terms.columns(1, map.terms() - 1);
    let mut normal = axes.transpose() * axes;
    let floor = 1e-9 * normal.diagonal().amax();
    for k in 0..normal.nrows() {
        normal[(k, k)] += floor;
    }
    let factors = normal.cholesky().map_or_else(|| axes.transpose(), |factor| factor.solve(&axes.transpose()));
    let offsets = -(&factors * terms.column(0));
    let rows = factors.row_iter().map(|row| row.iter().map(|number| *number as f32).collect()).collect();
    (rows, offsets.iter().map(|number| *number as f32).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kriging::{Shortlist, rows};
    use crate::ptm::spread_lights;

    /// Colours of some texels under a light, with a highlight that no polynomial of low degree has.
    fn colours(light: [f32; 3]) -> Vec<f32> {
        let texel = |k: usize| {
            let (c, s) = ((k as f32 * 0.9).cos(), (k as f32 * 0.9).sin());
            let cosine = 0.3 * (c * light[0] + s * light[1]) + 0.95 * light[2];
            let gloss = cosine.max(0.0).powi(12);
            [0.5 * cosine + gloss, 0.4 * cosine + gloss, 0.2 * cosine + 0.8 * gloss]
        };
        (0..60).flat_map(texel).collect()
    }

    /// Known answer: with all components, projected texels are right at the lights; and between them they are near.
    #[test]
    fn texels_are_recovered() {
        let lights = spread_lights(50);
        let values: Vec<Vec<f32>> = lights.iter().map(|light| colours(*light)).collect();
        let matrix = rows(&values);
        let interpolation = Shortlist::new(&lights, &matrix).combined(&matrix).unwrap();
        let entries = DMatrix::from_column_slice(150, 60, matrix.as_slice());
        let components = Components::new(&entries, 24);
        let learned = Learned::new(&components, &interpolation, &lights);
        assert_eq!((learned.map.side(), learned.map.terms()), (32, components.axes.ncols() + 1));
        let worst = |direction: [f32; 3]| {
            let expected = colours(direction);
            let mut worst = 0.0f32;
            for texel in 0..60 {
                let mut sum = learned.map.value(0, direction);
                for (k, factors) in learned.factors.iter().enumerate() {
                    let entry = |e: usize| factors[e] * values[e / 3][3 * texel + e % 3];
                    let amount = learned.offsets[k] + (0..150).map(entry).sum::<f32>();
                    let term = learned.map.value(k + 1, direction);
                    (0..3).for_each(|c| sum[c] += amount * term[c]);
                }
                (0..3).for_each(|c| worst = worst.max((sum[c] - expected[3 * texel + c]).abs()));
            }
            worst
        };
        let at = lights.iter().map(|light| worst(*light)).fold(0.0, f32::max);
        let between = spread_lights(23).into_iter().filter(|light| light[2] > 0.4).map(worst).fold(0.0, f32::max);
        assert!(at < 4e-3 && between < 0.05, "{at} {between}");
    }

    /// A term that other lights predict keeps its share; one that changes sign from light to light is seen at its lights only, because
    /// predictions of it are worse than none.
    #[test]
    fn terms_that_are_not_predicted_do_no_harm() {
        let lights = spread_lights(40);
        let smooth = |k: usize| f64::from(lights[k][0]);
        let rough = |k: usize| if k.is_multiple_of(2) { 0.02 } else { -0.02 };
        let texel = |k: usize, i: usize| 1.0 + smooth(k) * (i as f64).sin() + rough(k) * (1.7 * i as f64).cos();
        let matrix = DMatrix::from_fn(40, 90, |k, i| texel(k, i / 3));
        let interpolation = Shortlist::new(&lights, &matrix).combined(&matrix).unwrap();
        let entries = DMatrix::from_column_slice(120, 30, matrix.as_slice());
        let components = Components::new(&entries, 2);
        let known = at_lights(&components);
        let (seen, shares) = predicted(&known, interpolation.left_out.as_ref().unwrap());
        assert!(shares[0] == 1.0 && shares[1] > 0.95 && shares[2] < 0.3, "{shares:?}");
        // Whole, the prediction of the second is further from its values than 0 is.
        let (seen, known) = (seen.columns(6, 3), known.columns(6, 3));
        let off = |share: f64| (seen * share - known).norm() / known.norm();
        assert!(off(shares[2]) <= 1.0 && off(1.0) > 1.05, "{} {}", off(shares[2]), off(1.0));
    }

    /// Values of linear photographs near the largest half float, and lights so near to each other that corrections overshoot.
    #[test]
    fn maps_stay_in_range() {
        let on_arc = |k: usize| {
            let (s, c) = (0.3 + 0.02 * k as f32).sin_cos();
            [s, 0.0, c]
        };
        let lights: Vec<[f32; 3]> = (0..60).map(on_arc).collect();
        let matrix =
            DMatrix::from_fn(60, 90, |k, i| if (k * 7 + i * 3) % 5 == 0 { 60_000.0 } else { 100.0 * i as f64 });
        let interpolation = Shortlist::new(&lights, &matrix).combined(&matrix).unwrap_or_default();
        let entries = DMatrix::from_column_slice(180, 30, matrix.as_slice());
        let components = Components::new(&entries, 20);
        let learned = Learned::new(&components, &interpolation, &lights);
        let known = at_lights(&components);
        let (low, high) = (known.columns(0, 3).min(), known.columns(0, 3).max());
        for light in spread_lights(50) {
            let value = f64::from(learned.map.value(0, light)[0]);
            assert!((2.0 * low - high - 40.0..=2.0 * high - low + 40.0).contains(&value), "{value} {low} {high}");
        }
    }

    #[test]
    fn maps_follow_the_number_of_lights() {
        let sides = [1, 3, 20, 49, 72, 200, 512, 4096].map(map_side);
        assert!(sides.is_sorted() && sides[0] == 16 && sides[4] == 32 && sides[7] == 64, "{sides:?}");
    }
}
