//! Bandwidth of BRDF lobes over the outgoing direction, in cycles per radian (section 2.4 of Bagher et al. 2012).
//!
//! Incoming and outgoing directions are on a grid of 16 x 16 cells around the normal: cell `(i, j)` has the azimuth `2π
//! (i + ½) / 16` and the polar angle `(j + ½) 90° / 16`. Each lobe `f_r(wi, .)`, without a cosine, is transformed as an
//! image in the frame of its plane of incidence: the azimuthal equidistant map `(u, v) = ½ + θ (cos φ, sin φ) / π`. Its
//! Jacobian per radian on the sphere is `1/π` along the radius and `θ / (π sin θ)` around the normal, which is the
//! larger one: at most `1/2`, at the horizon.
//!
//! Beyond the horizon the image is extended by point reflection, `f(½π + δ) = 2 f(½π) - f(½π - δ)`, with `f(½π)`
//! extrapolated from two samples: value and slope are continuous there.

use super::local::{Border, frequencies};
use super::resolution::RESOLUTIONS;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, from_polar};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Upper bound of values, which keeps coefficients finite.
const MAX_VALUE: f64 = 1e30;

/// Cells per axis of the grids of directions.
pub const CELLS: usize = 16;
/// Number of pixels of a Gaussian that are at least half as bright as its centre if its bandwidth is a quarter of a
/// cycle per pixel.
const HIGHLIGHT: usize = 16;
/// Values per axis of a map.
pub const SIDE: usize = CELLS * CELLS;

/// Values per outgoing cell `[l][k]`.
type Cells = [[f32; CELLS]; CELLS];

/// A map of all lobes.
#[derive(Debug, Clone, PartialEq)]
pub struct LobeBandwidth {
    /// `SIDE x SIDE` values in cycles per radian, row by row: incoming cell `(i, j)` has the block of 16 x 16 values at
    /// column `16 i` and row `16 j`, in which outgoing cell `(k, l)` is at column k and row l.
    pub values: Vec<f32>,
    /// Repairs during evaluation.
    pub tally: Tally,
    /// True if the highlight of some lobe is too narrow for the image: fewer than 16 pixels are at least half as bright
    /// as the brightest one, and its bandwidth is a quarter of a cycle per pixel or more. Noise and weak detail on a
    /// bright lobe do not count.
    pub narrow: bool,
}

/// Computes the map of a material, with lobes transformed at `resolution` pixels per side: the maximum over the
/// channels.
///
/// Symmetries of the source save lobes: isotropic sources require one azimuth of incidence, mirror-symmetric ones a
/// quarter of them.
///
/// # Panics
/// Panics if the resolution is no power of two within [`RESOLUTIONS`].
pub fn lobe_bandwidth(source: &dyn Source, resolution: usize, epsilon: f64) -> LobeBandwidth {
    assert!(resolution.is_power_of_two(), "the resolution is a power of two");
    assert!((RESOLUTIONS[0]..=RESOLUTIONS[1]).contains(&resolution), "the resolution is in its range");
    let symmetry = source.symmetry();
    let azimuths = match (symmetry.isotropic, symmetry.mirror) {
        (true, _) => 1,
        (false, true) => CELLS / 4,
        (false, false) => CELLS,
    };
    let image = LobeImage::new(resolution);
    let computed: Vec<_> = (0..azimuths * CELLS)
        .into_par_iter()
        .map(|number| {
            let (i, j) = (number % azimuths, number / azimuths);
            let mut tally = Tally::default();
            let (cells, narrow) = image.cells(source, [i, j], epsilon, &mut tally);
            (i, j, cells, narrow, tally)
        })
        .collect();
    let mut map = LobeBandwidth { values: vec![0.0; SIDE * SIDE], tally: Tally::default(), narrow: false };
    for (i, j, cells, narrow, tally) in computed {
        map.tally += tally;
        map.narrow |= narrow;
        let mut put = |incoming: usize, outgoing: &dyn Fn(usize) -> usize| {
            for (l, row) in cells.iter().enumerate() {
                for (k, value) in row.iter().enumerate() {
                    map.values[(j * CELLS + l) * SIDE + incoming * CELLS + outgoing(k) % CELLS] = *value;
                }
            }
        };
        if symmetry.isotropic {
            for turn in 0..CELLS {
                put(turn, &|k| k + turn);
            }
        } else {
            put(i, &|k| k);
            if symmetry.mirror {
                // φ to π - φ, to -φ, and both.
                put(CELLS / 2 - 1 - i, &|k| CELLS + CELLS / 2 - 1 - k);
                put(CELLS - 1 - i, &|k| CELLS - 1 - k);
                put(CELLS / 2 + i, &|k| k + CELLS / 2);
            }
        }
    }
    map
}

/// Centre of incoming cell `[i, j]`.
fn incoming([i, j]: [usize; 2]) -> Vector {
    from_polar((j as f64 + 0.5) * FRAC_PI_2 / CELLS as f64, (i as f64 + 0.5) * TAU / CELLS as f64)
}

/// `σ_max(J)`: largest stretch of the map, in images per radian, at an angle to the normal.
fn jacobian_norm(theta: f64) -> f64 {
    if theta < 1e-6 { 1.0 / PI } else { theta / (PI * theta.sin()) }
}

/// Layout of the image of a lobe, relative to the plane of incidence.
struct LobeImage {
    side: usize,
    /// Directions of the pixels; beyond the horizon, directions of their reflections.
    directions: Vec<Vector>,
    /// For pixels beyond the horizon, the index of the horizon sample at their azimuth.
    beyond: Vec<Option<usize>>,
    /// Pairs of directions from which the horizon is extrapolated.
    horizon: Vec<[Vector; 2]>,
    /// Polar angle of each pixel.
    theta: Vec<f64>,
    /// Pixels of each cell `[l][k]`, k counted from the plane of incidence: the pixels inside it and the pixel nearest
    /// to its centre.
    members: Vec<Vec<usize>>,
}

impl LobeImage {
    fn new(side: usize) -> Self {
        let step = PI / side as f64;
        let around = 4 * side;
        let mut image = Self {
            side,
            directions: Vec::with_capacity(side * side),
            beyond: Vec::with_capacity(side * side),
            horizon: Vec::with_capacity(around),
            theta: Vec::with_capacity(side * side),
            members: vec![Vec::new(); CELLS * CELLS],
        };
        let cell = TAU / CELLS as f64;
        for number in 0..side * side {
            let at = [number % side, number / side].map(|c| (c as f64 + 0.5) * step - FRAC_PI_2);
            let (theta, phi) = (at[0].hypot(at[1]), at[1].atan2(at[0]));
            let inside = theta < FRAC_PI_2;
            image.directions.push(from_polar(if inside { theta } else { PI - theta }, phi));
            let sample = || (phi / TAU * around as f64 - 0.5).round().rem_euclid(around as f64) as usize % around;
            image.beyond.push((!inside).then(sample));
            image.theta.push(theta);
            if inside {
                let k = (phi / cell).round().rem_euclid(CELLS as f64) as usize % CELLS;
                let l = ((theta / FRAC_PI_2 * CELLS as f64) as usize).min(CELLS - 1);
                image.members[l * CELLS + k].push(number);
            }
        }
        // Near the normal, cells are smaller than pixels.
        for (number, members) in image.members.iter_mut().enumerate() {
            let theta = ((number / CELLS) as f64 + 0.5) * FRAC_PI_2 / CELLS as f64;
            let (sine, cosine) = ((number % CELLS) as f64 * cell).sin_cos();
            let [column, row] = [cosine, sine].map(|c| ((theta * c + FRAC_PI_2) / step) as usize);
            if !members.contains(&(row * side + column)) {
                members.push(row * side + column);
            }
        }
        for sample in 0..around {
            let phi = (sample as f64 + 0.5) * TAU / around as f64;
            image.horizon.push([0.5, 1.5].map(|steps| from_polar(FRAC_PI_2 - steps * step, phi)));
        }
        image
    }

    /// Bandwidth of the lobe of an incoming cell, per outgoing cell `[l][k]`, and true if the lobe is too narrow for
    /// the image. k is counted from azimuth 0 of the material, or from the plane of incidence for isotropic materials.
    fn cells(&self, source: &dyn Source, cell: [usize; 2], epsilon: f64, tally: &mut Tally) -> (Cells, bool) {
        self.cells_by(source, cell, epsilon, tally, |values| values.iter().copied().fold(0.0, f32::max))
    }

    /// Variant of [`Self::cells`] with a given function for merging the values of a cell's pixels.
    fn cells_by(
        &self,
        source: &dyn Source,
        cell: [usize; 2],
        epsilon: f64,
        tally: &mut Tally,
        reduce: impl Fn(&[f32]) -> f32,
    ) -> (Cells, bool) {
        let symmetry = source.symmetry();
        let halves = symmetry.isotropic && symmetry.mirror;
        let channels = self.lobe(source, incoming(cell), halves, tally);
        let mut cells = [[0.0f32; CELLS]; CELLS];
        let turn = if symmetry.isotropic { 0 } else { cell[0] };
        let mut inside = Vec::new();
        let mut narrow = false;
        for channel in channels {
            let values = self.bandwidth(&channel, epsilon);
            narrow |= self.is_narrow(&channel, &values);
            for (number, members) in self.members.iter().enumerate() {
                inside.clear();
                inside.extend(members.iter().map(|pixel| values[*pixel]));
                let value = &mut cells[number / CELLS][(number + turn) % CELLS];
                *value = value.max(reduce(&inside));
            }
        }
        if halves {
            // The wavelets are not symmetric, but the lobe is.
            for row in &mut cells {
                let found = *row;
                for (k, value) in row.iter_mut().enumerate() {
                    *value = found[k].max(found[(CELLS - k) % CELLS]);
                }
            }
        }
        (cells, narrow)
    }

    /// See [`LobeBandwidth::narrow`].
    fn is_narrow(&self, lobe: &[f32], bandwidth: &[f32]) -> bool {
        let inside = || (0..lobe.len()).filter(|number| self.beyond[*number].is_none());
        let Some(peak) = inside().reduce(|best, next| if lobe[next] > lobe[best] { next } else { best }) else {
            return false;
        };
        let bright = inside().filter(|number| lobe[*number] >= 0.5 * lobe[peak]).count();
        bright < HIGHLIGHT && f64::from(bandwidth[peak]) >= 0.25 * self.side as f64 * jacobian_norm(self.theta[peak])
    }

    /// Images of a lobe, one per channel. With `halves`, the side below the plane of incidence mirrors the other side.
    fn lobe(&self, source: &dyn Source, incoming: Vector, halves: bool, tally: &mut Tally) -> Vec<Vec<f32>> {
        let count = if source.is_grey() { 1 } else { 3 };
        let sine = incoming[0].hypot(incoming[1]);
        let (c, s) = (incoming[0] / sine, incoming[1] / sine);
        let mut eval = |d: Vector| {
            let outgoing = [c * d[0] - s * d[1], s * d[0] + c * d[1], d[2]];
            let value = source.eval(DirectionPair::new(incoming, outgoing), tally);
            value.map(|v| if v.is_finite() { v } else { 0.0 })
        };
        let (around, side) = (self.horizon.len(), self.side);
        let mut horizon = vec![[0.0; 3]; around];
        for sample in 0..if halves { around / 2 } else { around } {
            let [near, far] = self.horizon[sample].map(&mut eval);
            horizon[sample] = [0, 1, 2].map(|k| 1.5 * near[k] - 0.5 * far[k]);
            if halves {
                horizon[around - 1 - sample] = horizon[sample];
            }
        }
        let mut channels = vec![vec![0.0f32; side * side]; count];
        for row in if halves { side / 2..side } else { 0..side } {
            for number in row * side..(row + 1) * side {
                let mut value = eval(self.directions[number]);
                if let Some(sample) = self.beyond[number] {
                    value = [0, 1, 2].map(|k| 2.0 * horizon[sample][k] - value[k]);
                }
                for (k, channel) in channels.iter_mut().enumerate() {
                    let value = value[k].clamp(-MAX_VALUE, MAX_VALUE) as f32;
                    channel[number] = value;
                    if halves {
                        channel[(side - 1 - row) * side + number % side] = value;
                    }
                }
            }
        }
        channels
    }

    /// Bandwidth per pixel.
    fn bandwidth(&self, lobe: &[f32], epsilon: f64) -> Vec<f32> {
        let found = frequencies(lobe, [self.side; 2], self.side, Border::Bounded, epsilon);
        let at = |number: usize| (number / self.side / 2) * found.width + number % self.side / 2;
        let cycles = |number: usize| found.u[at(number)].hypot(found.v[at(number)]) * self.side as f32;
        (0..lobe.len()).map(|number| cycles(number) * jacobian_norm(self.theta[number].min(FRAC_PI_2)) as f32).collect()
    }
}

#[cfg(test)]
mod tests;
