//! Learned terms: "better approximation functions" than polynomials (section 3 of the paper). Principal components of all
//! texels, as colours under all lights, are interpolated between the lights and stored as a [`LightMap`].

use crate::components::Components;
use crate::kriging::{Interpolation, paraboloid};
use brdfc_formats::pwt::{LightMap, MAP_SIDES};
use nalgebra::{DMatrix, DMatrixView, DVector, Matrix3, Matrix3xX};
use std::f64::consts::PI;

/// Texels of the map per mean distance of two lights.
const TEXELS_PER_LIGHT: f64 = 3.0;
/// Width of the correction at a light, in mean distances of two lights.
const CORRECTION: f64 = 0.35;
/// Share by which corrections fall short, so that those of neighbouring lights do not overshoot between them.
const SHORT: f64 = 0.005;

/// Regularisation of coefficients that one light determines alone.
const ALONE: f64 = 1e-6;

/// Terms that are learned from photographs.
pub struct Learned {
    /// The terms. Term 0 is the mean.
    pub map: LightMap,
    /// For each component, its factor of each light and channel, `3 light + channel`.
    pub factors: Vec<Vec<f32>>,
    /// For each component, what is added.
    pub offsets: Vec<f32>,
    /// Weight of green under each light in the fit.
    pub weights: Vec<f32>,
}

/// Components and the mean as values at the lights: a row for each light, columns `3 term + channel`.
fn at_lights(components: &Components) -> DMatrix<f64> {
    let (entries, terms) = (components.axes.nrows(), components.axes.ncols() + 1);
    let axes = components.unweighted();
    DMatrix::from_iterator(entries / 3, 3 * terms, components.mean.iter().chain(axes.iter()).copied())
}

/// Predictions of each light of `known` from the others, and the share of each term's prediction that is used between the lights:
/// the slope of the regression of its values on the predictions, 0 to 1. Shadows and highlights of weak terms move from light to
/// light; with their share, terms that others do not predict are seen at their lights only, and more terms do little harm elsewhere.
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

/// Colours under each light as predicted from the photographs of the others: the light is left out of the interpolation and of the
/// coefficients, but not of the components.
pub struct LeftOut<'a> {
    components: &'a Components,
    /// Mean and axes as predictions from the other lights.
    predicted: Components,
}

impl<'a> LeftOut<'a> {
    /// `None` if no light can be left out.
    pub fn new(components: &'a Components, interpolation: &Interpolation) -> Option<Self> {
        let (mut predicted, shares) = predicted(&at_lights(components), interpolation.left_out.as_ref()?);
        scale_terms(&mut predicted, &shares);
        let (entries, terms) = (components.axes.nrows(), components.axes.ncols());
        let (mean, axes) = predicted.as_slice().split_at(entries);
        let (mean, axes) = (DVector::from_column_slice(mean), DMatrix::from_column_slice(entries, terms, axes));
        let weights = DVector::from_element(entries, 1.0);
        Some(Self { components, predicted: Components { mean, axes, weights } })
    }

    /// Colours of texels under a light. `coefficients` are those of the first components, from all of `values`.
    ///
    /// Without the rows `A` of the axes and the weighted values `v` of this light, least squares gives the coefficients
    /// `(1 - A^T A)^-1 (c - A^T v)`, which by Woodbury's identity are `c + A^T ((1 - A A^T)^-1 (A c - A A^T v) - v)`.
    pub fn colours(&self, light: usize, coefficients: &DMatrixView<'_, f64>, values: &DMatrix<f64>) -> Matrix3xX<f64> {
        let terms = coefficients.nrows();
        let Components { mean, weights, .. } = self.components;
        let axes = self.components.rows(light, terms);
        let lights = mean.len() / 3;
        let [mean, weights] = [mean, weights].map(|entries| Components::of_light(entries, light));
        let values = Matrix3xX::from_fn(values.ncols(), |channel, texel| {
            weights[channel] * (values[(channel * lights + light, texel)] - mean[channel])
        });
        let own = &axes * axes.transpose();
        // A light that determines a coefficient alone predicts nothing.
        let inverse = (Matrix3::identity() * (1.0 + ALONE) - own).try_inverse().unwrap_or_else(Matrix3::identity);
        let change = inverse * (&axes * coefficients - own * &values) - values;
        let predicted = self.predicted.rows(light, terms) * axes.transpose();
        self.predicted.colours(light, coefficients) + predicted * change
    }
}

/// Multiplies each term, three columns, by its share.
fn scale_terms(values: &mut DMatrix<f64>, shares: &[f64]) {
    for (term, share) in shares.iter().enumerate() {
        values.columns_mut(3 * term, 3).scale_mut(*share);
    }
}

/// Approximate distance of two neighbouring lights in paraboloid coordinates.
///
/// The distance of lights spread over the hemisphere; less where they fill only a cap or an arc, but not below the one that they have.
fn spacing(lights: &[[f32; 3]]) -> f64 {
    let points: Vec<[f64; 2]> = lights.iter().map(|light| paraboloid(*light)).collect();
    let count = points.len().max(1) as f64;
    let hemisphere = 0.9 * (PI / count).sqrt();
    let mean = [0, 1].map(|axis| points.iter().map(|point| point[axis]).sum::<f64>() / count);
    let moment = |a: usize, b: usize| points.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>() / count;
    // The share of the radius that an evenly filled ellipse with these moments has; domes fill more than half.
    let radius = 2.0 * (moment(0, 0) * moment(1, 1) - moment(0, 1).powi(2)).max(0.0).powf(0.25);
    let nearest = |(k, a): (usize, &[f64; 2])| {
        let others = points.iter().enumerate().filter(|(other, _)| *other != k);
        others.map(|(_, b)| (a[0] - b[0]).hypot(a[1] - b[1])).fold(f64::INFINITY, f64::min)
    };
    let mut distances: Vec<f64> = points.iter().enumerate().map(nearest).collect();
    distances.sort_by(f64::total_cmp);
    let median = distances.get(distances.len() / 2).copied().unwrap_or(hemisphere);
    (hemisphere * (2.0 * radius)).max(median).clamp(0.25 * hemisphere, hemisphere)
}

/// Texels per side of the map for some lights.
pub fn map_side(lights: &[[f32; 3]]) -> u32 {
    let texels = 2.0 * TEXELS_PER_LIGHT / spacing(lights);
    (texels.min(f64::from(*MAP_SIDES.end())) as u32).next_multiple_of(8).clamp(16, *MAP_SIDES.end())
}

impl Learned {
    /// Interpolates components between the lights. Entries of components are `channel lights + light`.
    pub fn new(components: &Components, interpolation: &Interpolation, lights: &[[f32; 3]]) -> Self {
        let side = map_side(lights);
        let known = at_lights(components);
        let directions = LightMap::directions(side);
        let mut map = interpolation.predictions(lights, &directions) * &known;
        if let Some(errors) = &interpolation.left_out {
            scale_terms(&mut map, &predicted(&known, errors).1);
        }
        limit(&mut map, &known);
        correct(&mut map, &known, lights, side);
        // Corrections of neighbouring lights can overshoot.
        limit(&mut map, &known);
        let texels: Vec<[f32; 3]> = (0..known.ncols() / 3)
            .flat_map(|term| (0..map.nrows()).map(move |texel| (term, texel)))
            .map(|(term, texel)| [0, 1, 2].map(|channel| map[(texel, 3 * term + channel)] as f32))
            .collect();
        let map = LightMap::new(side, &texels).expect("a side in range, and clamped values");
        let (factors, offsets) = projection(&map, lights, &components.weights);
        let weights = (0..lights.len()).map(|light| Components::of_light(&components.weights, light)[1] as f32);
        Self { map, factors, offsets, weights: weights.collect() }
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
    let width = CORRECTION * spacing(lights);
    let at = |k: u32| (f64::from(k) + 0.5) * 2.0 / f64::from(side) - 1.0;
    let bumps = DMatrix::from_fn(map.nrows(), lights.len(), |texel, light| {
        let [x, y] = paraboloid(lights[light]);
        let squared = (at(texel as u32 % side) - x).powi(2) + (at(texel as u32 / side) - y).powi(2);
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

/// Weighted least-squares projection of values at the lights on the terms of a map: factors and offsets of each component. `weights`
/// are those of [`Components`].
fn projection(map: &LightMap, lights: &[[f32; 3]], weights: &DVector<f64>) -> (Vec<Vec<f32>>, Vec<f32>) {
    let weight = |entry: usize| weights[entry % 3 * lights.len() + entry / 3];
    let terms = DMatrix::from_fn(3 * lights.len(), map.terms(), |entry, term| {
        weight(entry) * f64::from(map.value(term, lights[entry / 3])[entry % 3])
    });
    let axes = terms.columns(1, map.terms() - 1);
    let mut normal = axes.transpose() * axes;
    let floor = 1e-9 * normal.diagonal().amax();
    for k in 0..normal.nrows() {
        normal[(k, k)] += floor;
    }
    let mut factors = normal.cholesky().map_or_else(|| axes.transpose(), |factor| factor.solve(&axes.transpose()));
    let offsets = -(&factors * terms.column(0));
    factors.column_iter_mut().enumerate().for_each(|(entry, mut column)| column *= weight(entry));
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
        let components = Components::new(&entries, DVector::from_fn(150, |k, _| 1.0 + 0.5 * (k as f64).sin()), 24);
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
        let components = Components::new(&entries, DVector::from_element(120, 1.0), 2);
        let known = at_lights(&components);
        let (seen, shares) = predicted(&known, interpolation.left_out.as_ref().unwrap());
        assert!(shares[0] == 1.0 && shares[1] > 0.95 && shares[2] < 0.3, "{shares:?}");
        // Whole, the prediction of the second is further from its values than 0 is.
        let (seen, known) = (seen.columns(6, 3), known.columns(6, 3));
        let off = |share: f64| (seen * share - known).norm() / known.norm();
        assert!(off(shares[2]) <= 1.0 && off(1.0) > 1.05, "{} {}", off(shares[2]), off(1.0));
    }

    /// Coefficients without a light are those of least squares without its rows; with them is the negative control.
    #[test]
    fn coefficients_do_not_see_the_light_that_is_left_out() {
        let lights = spread_lights(12);
        let values: Vec<Vec<f32>> = lights.iter().map(|light| colours(*light)).collect();
        let matrix = rows(&values);
        let interpolation = Shortlist::new(&lights, &matrix).combined(&matrix).unwrap();
        let entries = DMatrix::from_column_slice(36, 60, matrix.as_slice());
        let components = Components::new(&entries, DVector::from_fn(36, |k, _| 1.0 + 0.5 * (k as f64).sin()), 5);
        let coefficients = components.coefficients(&entries);
        let left_out = LeftOut::new(&components, &interpolation).unwrap();
        for light in [0, 7, 11] {
            let rest: Vec<usize> = (0..36).filter(|entry| entry % 12 != light).collect();
            let mut centred = entries.select_rows(&rest);
            for mut column in centred.column_iter_mut() {
                column -= components.mean.select_rows(&rest);
                column.component_mul_assign(&components.weights.select_rows(&rest));
            }
            let solved = components.axes.select_rows(&rest).pseudo_inverse(1e-12).unwrap() * centred;
            let expected = left_out.predicted.colours(light, &solved.rows(0, 5));
            let found = left_out.colours(light, &coefficients.rows(0, 5), &entries);
            let seen = left_out.predicted.colours(light, &coefficients.rows(0, 5));
            let [off, changed] = [&expected, &seen].map(|other| (&found - other).amax());
            assert!(off < 1e-6 && changed > 1e-5, "{off} {changed}");
        }
    }

    /// Values of linear photographs near the largest half float, and twin lights with other values, whose corrections overshoot.
    #[test]
    fn maps_stay_in_range() {
        let twin = |light: [f32; 3]| {
            let [x, y, z] = light;
            [[x, y, z], [x + 0.003, y, (1.0 - (x + 0.003).powi(2) - y * y).max(1e-4).sqrt()]]
        };
        let lights: Vec<[f32; 3]> = spread_lights(30).into_iter().flat_map(twin).collect();
        let matrix = DMatrix::from_fn(60, 90, |k, i| if k % 3 == 0 { 60_000.0 - i as f64 } else { 100.0 * i as f64 });
        let interpolation = Shortlist::new(&lights, &matrix).combined(&matrix).unwrap_or_default();
        let entries = DMatrix::from_column_slice(180, 30, matrix.as_slice());
        let components = Components::new(&entries, DVector::from_element(180, 1.0), 20);
        let map = Learned::new(&components, &interpolation, &lights).map;
        let known = at_lights(&components);
        for term in 0..map.terms() {
            for channel in 0..3 {
                let known = known.column(3 * term + channel);
                let (low, high) = (known.min(), known.max());
                let spare = 1e-3 * (high - low) + 40.0 * f64::from(term == 0);
                for light in spread_lights(200) {
                    let value = f64::from(map.value(term, light)[channel]);
                    let range = 2.0 * low - high - spare..=2.0 * high - low + spare;
                    assert!(range.contains(&value), "{term}: {value} {low} {high}");
                }
            }
        }
    }

    #[test]
    fn maps_follow_the_lights() {
        let sides = [1, 3, 20, 49, 72, 200, 512, 4096].map(|count| map_side(&spread_lights(count)));
        assert!(sides.is_sorted() && sides[0] == 16 && sides[4] == 32 && sides[7] == 64, "{sides:?}");
        // Lights on an arc, and in a cap, are nearer to each other.
        let arc: Vec<[f32; 3]> = (0..24).map(|k| (0.1 * k as f32 - 1.2).sin_cos()).map(|(s, c)| [s, 0.0, c]).collect();
        let cap: Vec<[f32; 3]> = spread_lights(400).into_iter().filter(|light| light[2] > 0.93).collect();
        assert!(
            map_side(&arc) >= 56 && map_side(&cap) >= 56 && cap.len() < 60,
            "{} {}",
            map_side(&arc),
            map_side(&cap)
        );
        assert_eq!(map_side(&[[0.0, 0.0, 1.0]; 7]), 40);
    }
}
