//! Views of a material in environments, with the radiance that it reflects.

use super::reflection::{Frame, Reflection, Resolution, Slopes};
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{Vector, cross, dot, normalize};
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_metrics::image::luminance;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Smallest cosine of a view.
const LEAST_COSINE: f64 = 0.02;
/// Quantile of the luminance that is exposed to white.
const WHITE: f64 = 0.97;

/// One outgoing direction in many frames.
pub struct View {
    /// Outgoing unit vector.
    pub outgoing: Vector,
    /// Share of a ball's rendering, relative to other views.
    pub area: f64,
    /// Reflected share of uniform light.
    pub albedo: [f64; 3],
    /// Reflected radiance in each frame.
    pub radiance: Vec<[f64; 3]>,
}

/// Views of a material.
pub struct Views<'a> {
    environments: &'a [EnvironmentDecoder],
    /// Number of the environment, and the frame in it.
    frames: Vec<(usize, Frame)>,
    /// Views in the order of their places.
    pub views: Vec<View>,
    /// Standard deviation of the lobe in the narrowest view, radians; `None` if the material is black.
    pub width: Option<f64>,
    /// Slopes of half vectors in the first view; `None` if the material is black.
    pub slopes: Option<Slopes>,
    /// Factor of radiance for a rendering, for each environment.
    exposures: Vec<f64>,
}

/// Outgoing unit vector at a position from the normal, 0, to the horizon, 1, and an azimuth, 0 to 1; see
/// [`brdfc_formats::lobes::view_position`] and [`brdfc_formats::lobes::view_azimuth`]. It stays above the horizon.
pub fn outgoing_at([position, azimuth]: [f64; 2]) -> Vector {
    let cosine = (1.0 - position * position).max(LEAST_COSINE);
    let sine = (1.0 - cosine * cosine).sqrt();
    let quarter = 4.0 * azimuth;
    let along = if quarter < 2.0 { 1.0 - quarter } else { quarter - 3.0 };
    let across = (1.0 - along.abs()).copysign(2.0 - quarter);
    let length = along.hypot(across);
    [sine * along / length, sine * across / length, cosine]
}

impl<'a> Views<'a> {
    /// Computes the radiance at these positions and azimuths, see [`outgoing_at`], in `frames` random frames of each
    /// environment.
    pub fn new(
        source: &dyn Source,
        environments: &'a [EnvironmentDecoder],
        places: &[[f64; 2]],
        frames: usize,
        resolution: Resolution,
        tally: &mut Tally,
    ) -> Self {
        let frames = random_frames(environments.len(), frames);
        let view = |place: &[f64; 2]| {
            let mut tally = Tally::default();
            let (outgoing, position) = (outgoing_at(*place), place[0]);
            let reflection = Reflection::new(source, outgoing, resolution, &mut tally);
            let radiance = frames.iter().map(|(at, frame)| reflection.radiance(&environments[*at], frame)).collect();
            // Of a ball, sin θ cos θ dθ, and cos θ = 1 - position².
            let area = (2.0 * position * (1.0 - position * position)).max(0.02);
            let view = View { outgoing, area, albedo: reflection.albedo(), radiance };
            let slopes = if *place == places[0] { reflection.slopes() } else { None };
            (view, reflection.width(), slopes, tally)
        };
        let computed: Vec<_> = places.par_iter().map(view).collect();
        let width = computed.iter().filter_map(|(_, width, ..)| *width).reduce(f64::min);
        let slopes = computed.first().and_then(|(_, _, slopes, _)| *slopes);
        let mut views = Vec::with_capacity(computed.len());
        for (view, _, _, part) in computed {
            *tally += part;
            views.push(view);
        }
        let exposure = |at: usize| {
            let of = |view: &'_ View| -> Vec<f64> {
                let inside = frames.iter().zip(&view.radiance).filter(|((environment, _), _)| *environment == at);
                inside.map(|(_, value)| luminance(value.map(|c| c as f32))).collect()
            };
            let mut all: Vec<f64> = views.iter().flat_map(of).collect();
            all.sort_by(f64::total_cmp);
            let white = all.get((all.len() as f64 * WHITE) as usize).copied().unwrap_or(0.0);
            if white > 0.0 { 1.0 / white } else { 1.0 }
        };
        let exposures = (0..environments.len()).map(exposure).collect();
        Self { environments, frames, views, width, slopes, exposures }
    }

    /// Environment, frame and exposure by the number of the frame.
    pub fn frame(&self, number: usize) -> (&'a EnvironmentDecoder, &Frame, f64) {
        let (environment, frame) = &self.frames[number];
        (&self.environments[*environment], frame, self.exposures[*environment])
    }
}

/// Random frames, `each` for every environment.
fn random_frames(environments: usize, each: usize) -> Vec<(usize, Frame)> {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut direction = || -> Vector {
        let (z, turn) = (2.0 * random.random::<f64>() - 1.0, std::f64::consts::TAU * random.random::<f64>());
        let r = (1.0f64 - z * z).sqrt();
        [r * turn.cos(), r * turn.sin(), z]
    };
    let mut all = Vec::with_capacity(environments * each);
    for environment in 0..environments {
        for _ in 0..each {
            let (normal, other) = (direction(), direction());
            let share = dot(normal, other);
            let tangent = normalize([0, 1, 2].map(|k| other[k] - share * normal[k]));
            all.push((environment, Frame::new([tangent, cross(normal, tangent), normal])));
        }
    }
    all
}
