//! Visible difference between two materials on a ball, computed per direction pair without a renderer.

use super::image::{Spread, colour_difference, shown_colour, spread};
use super::sampling::{from_polar_cosine, points};
use super::values::values_of_list;
use brdfc_core::pair_list::PairList;
use brdfc_core::{Source, Tally};
use brdfc_formats::RenderingSummary;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot};
use palette::Lab;
use palette::white_point::D65;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Diameter of the ball, pixels.
const DIAMETER: usize = 160;
/// Directions to the distant lights of the three renderings: from the side, from the viewer, and grazing.
const LIGHTS: [Vector; 3] = [[-0.5, 0.6, 0.62], [0.2, 0.2, 0.96], [-0.9, 0.3, -0.1]];
/// Pixels are ignored if their cosine to the light or to the viewer is not above this.
const LEAST_COSINE: f64 = 0.02;
/// One pixel in this many is drawn for estimates of a mean difference.
const COARSE: usize = 8;
/// Share of pixels whose largest channel is not brighter than white.
const WHITE: f64 = 0.98;

/// Colour differences between renderings of two materials: a ball of 160 pixels under each of three distant lights,
/// with a distant viewer. White is the 98th percentile of the largest channel of the reference's three renderings.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct RenderingError {
    /// Number of compared pixels.
    pub pixels: usize,
    /// Factor from radiance to display values; 1 if all pixels are black.
    pub exposure: f64,
    /// ΔE (CIE76) over the pixels of the three renderings.
    pub delta_e: Spread,
    /// Colour difference CIEDE2000 over the same pixels.
    pub delta_e_2000: Spread,
}

impl RenderingError {
    /// The errors as a pack stores them.
    pub fn summary(&self) -> RenderingSummary {
        let [mean, p95, max] = [self.delta_e.mean, self.delta_e.p95, self.delta_e.max].map(|v| v as f32);
        RenderingSummary { mean, p95, max }
    }
}

/// The direction pairs of the pixels of all three renderings. The tangent points along the ball's latitude.
pub fn rendering_pairs() -> Arc<PairList> {
    static PAIRS: OnceLock<Arc<PairList>> = OnceLock::new();
    PairList::cached(&PAIRS, || LIGHTS.into_par_iter().flat_map_iter(lit_by).collect())
}

/// The direction pairs of the pixels within a range of directions.
fn pairs_of(directions: DirectionRange) -> Arc<PairList> {
    if directions.is_all() { rendering_pairs() } else { Arc::new(PairList::new(pairs_within(directions))) }
}

/// Every eighth pair, for estimates.
pub(super) fn coarse_rendering_pairs(directions: DirectionRange) -> Arc<PairList> {
    Arc::new(PairList::new(pairs_of(directions).iter().copied().step_by(COARSE).collect()))
}

/// Direction pairs of pixels within a range of directions: viewers by projected area, as on a distant ball, and lights
/// from everywhere, by solid angle.
fn pairs_within(directions: DirectionRange) -> Vec<DirectionPair> {
    let ([light_low, light_high], [view_low, view_high]) = (directions.light.sines(), directions.view.sines());
    let direction = |z: f64, turn: f64| from_polar_cosine(z, TAU * turn);
    let pair = |[a, b, c, d]: [f64; 4]| {
        let view = (view_low.powi(2) + (view_high.powi(2) - view_low.powi(2)) * c).sqrt();
        DirectionPair::new(direction(light_low + (light_high - light_low) * a, b), direction(view, d))
    };
    // For a range along the horizon half is enough.
    let [light_least, view_least] = [light_high, view_high].map(|highest| LEAST_COSINE.min(highest / 2.0));
    let shown = |pair: &DirectionPair| pair.incoming[2] > light_least && pair.outgoing[2] > view_least;
    points(1).take(rendering_pairs().len()).map(pair).filter(shown).collect()
}

/// The direction pairs of the pixels of a rendering.
fn lit_by(light: Vector) -> Vec<DirectionPair> {
    let mut pairs = Vec::new();
    let light = scaled(light, 1.0 / dot(light, light).sqrt());
    for pixel in 0..DIAMETER * DIAMETER {
        let place = |k: usize| 2.0 * (k as f64 + 0.5) / DIAMETER as f64 - 1.0;
        let [x, y] = [place(pixel % DIAMETER), -place(pixel / DIAMETER)];
        let square = x * x + y * y;
        if square >= 1.0 {
            continue;
        }
        let normal = [x, y, (1.0 - square).sqrt()];
        let along = cross([0.0, 1.0, 0.0], normal);
        let tangent = scaled(along, 1.0 / dot(along, along).sqrt());
        let local = |v: Vector| [dot(v, tangent), dot(v, cross(normal, tangent)), dot(v, normal)];
        let pair = DirectionPair::new(local(light), local([0.0, 0.0, 1.0]));
        if pair.incoming[2] > LEAST_COSINE && pair.outgoing[2] > LEAST_COSINE {
            pairs.push(pair);
        }
    }
    pairs
}

/// Renderings of a reference source.
pub struct ReferenceRendering {
    pairs: Arc<PairList>,
    pixels: Vec<[f32; 3]>,
    colours: Vec<Lab<D65, f64>>,
    exposure: f64,
}

impl ReferenceRendering {
    /// Renders a source. The tally counts its repairs. For a range of directions the pixels do not form a ball,
    /// which might show little of the range, but as many pixels spread over the range: viewers by projected area,
    /// lights by solid angle.
    pub fn new(source: &dyn Source, directions: DirectionRange) -> (Self, Tally) {
        Self::of_pairs(source, pairs_of(directions))
    }

    /// Renders pixels with these direction pairs.
    pub(super) fn of_pairs(source: &dyn Source, pairs: Arc<PairList>) -> (Self, Tally) {
        let (pixels, tally) = pixels(source, &pairs);
        let exposure = exposure(&pixels);
        let colours = pixels.par_iter().map(|pixel| shown_colour(*pixel, exposure)).collect();
        (Self { pairs, pixels, colours, exposure }, tally)
    }

    /// Factor from radiance to display values.
    pub fn exposure(&self) -> f64 {
        self.exposure
    }

    /// Compares renderings of an approximation with the reference. Pixels that are not finite in either rendering are
    /// ignored.
    pub fn compare(&self, approximation: &dyn Source) -> RenderingError {
        let (found, _) = pixels(approximation, &self.pairs);
        let difference = |(k, found): (usize, &[f32; 3])| {
            let expected = &self.pixels[k];
            if found.iter().chain(expected).any(|c| !c.is_finite()) {
                return None;
            }
            if found == expected {
                return Some((0.0, 0.0));
            }
            Some(colour_difference(shown_colour(*found, self.exposure), self.colours[k]))
        };
        let differences: Vec<Option<(f64, f64)>> = found.par_iter().enumerate().map(difference).collect();
        let (delta_e, delta_e_2000) = differences.into_iter().flatten().unzip();
        RenderingError {
            pixels: found.len(),
            exposure: self.exposure,
            delta_e: spread(delta_e),
            delta_e_2000: spread(delta_e_2000),
        }
    }
}

/// Radiance of all pixels under lights of 1.
fn pixels(source: &dyn Source, pairs: &PairList) -> (Vec<[f32; 3]>, Tally) {
    let (values, tally) = values_of_list(source, pairs);
    let shown = |(f, pair): (&[f64; 3], &DirectionPair)| f.map(|f| (f.max(0.0) * pair.incoming[2]) as f32);
    (values.iter().zip(pairs.iter()).map(shown).collect(), tally)
}

fn exposure(pixels: &[[f32; 3]]) -> f64 {
    let mut largest: Vec<f32> = pixels.iter().map(|[r, g, b]| r.max(*g).max(*b)).collect();
    let at = ((largest.len() - 1) as f64 * WHITE).round() as usize;
    let white = *largest.select_nth_unstable_by(at, f32::total_cmp).1;
    if white > 0.0 && white.is_finite() { 1.0 / f64::from(white) } else { 1.0 }
}

fn scaled(v: Vector, factor: f64) -> Vector {
    v.map(|c| c * factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::crop::Elevations;

    fn on_a_ball(reference: &dyn Source, approximation: &dyn Source) -> RenderingError {
        ReferenceRendering::new(reference, DirectionRange::ALL).0.compare(approximation)
    }

    fn error(reference: &str, approximation: &str) -> RenderingError {
        let [a, b] = [reference, approximation].map(|address| parse_synth(address).expect("an address"));
        on_a_ball(a.as_ref(), b.as_ref())
    }

    #[test]
    fn the_same_material_looks_the_same() {
        let same = error("synth:ggx?alpha=0.2", "synth:ggx?alpha=0.2");
        assert_eq!((same.delta_e.mean, same.delta_e.max, same.delta_e_2000.max), (0.0, 0.0, 0.0));
        assert!(same.pixels > 40_000, "{}", same.pixels);
    }

    /// A matte ball shows `f cos θ` under white at the 98th percentile, so L* of its mean is known.
    #[test]
    fn a_darker_grey_has_a_known_difference() {
        let half = error("synth:lambert?kd=0.8", "synth:lambert?kd=0.4");
        // L* of c and of c / 2 differ by (116 (1 - 0.5^(1/3))) c^(1/3), 23.93 where c is 1, the largest.
        let largest = 116.0 * (1.0 - 0.5f64.cbrt());
        assert!((half.delta_e.max - largest).abs() < 0.05, "{half:?}");
        assert!(half.delta_e.mean > 0.6 * largest && half.delta_e.mean < largest, "{half:?}");
        // The exposure normalises brightness: the brightness of the two does not matter.
        let darker = error("synth:lambert?kd=0.08", "synth:lambert?kd=0.04");
        assert!((darker.delta_e.mean - half.delta_e.mean).abs() < 1e-3);
    }

    /// Over the full range the difference is as on a ball, although that has three lights only. A narrow range has as
    /// many pixels.
    #[test]
    fn a_range_of_directions_is_as_a_ball_where_it_is_wide() {
        let [a, b] = ["synth:ggx?alpha=0.3", "synth:ggx?alpha=0.34"].map(|address| parse_synth(address).unwrap());
        let within = |from: f32, to: f32| {
            let range = Elevations { from, to };
            let directions = DirectionRange { light: range, view: range };
            ReferenceRendering::new(a.as_ref(), directions).0.compare(b.as_ref())
        };
        let (ball, nearly_all) = (on_a_ball(a.as_ref(), b.as_ref()), within(0.0, 89.9));
        let ratio = nearly_all.delta_e.mean / ball.delta_e.mean;
        assert!((0.5..2.0).contains(&ratio), "{nearly_all:?} {ball:?}");
        let steep = within(85.0, 90.0);
        assert!(steep.pixels == ball.pixels && steep.delta_e.mean > 0.0, "{steep:?}");
        let grazing = within(0.0, 0.5);
        assert!(grazing.pixels > ball.pixels / 8, "{grazing:?}");
    }

    #[test]
    fn black_materials_have_no_difference() {
        let black = error("synth:lambert?kd=0", "synth:lambert?kd=0");
        assert_eq!((black.exposure, black.delta_e.max), (1.0, 0.0));
        assert!(error("synth:lambert?kd=0", "synth:lambert?kd=1").delta_e.mean > 10.0);
    }
}
