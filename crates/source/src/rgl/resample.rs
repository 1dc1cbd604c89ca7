//! Resampling of any material as one of the RGL database: its values at positions where the visible normals of a
//! similar distribution are uniform, after Dupuy and Jakob 2018, sections 3 and 4. The measurement finds that
//! distribution by power iterations; here it is the retro-reflection of the material.

use super::warp::VisibleNormals;
use brdfc_core::luminance;
use brdfc_formats::FormatError;
use brdfc_formats::direction::{DirectionPair, Vector, dot, from_polar};
use brdfc_readers::rgl::{Azimuths, Colour, Map, Rgl};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Largest polar angle of incidence, degrees.
const STEEPEST_DEGREES: f64 = 89.0;
/// Height of the lowest directions of retro-reflection.
const LOWEST: f64 = 1e-3;
/// Smallest density of normals, relative to the density of a rough surface, so that all directions have values.
const LEAST_DENSITY: f64 = 0.02;

/// Sizes of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RglGrid {
    /// Azimuths of incidence: 1 for isotropic materials, otherwise at least 3 over a full turn, including both ends.
    pub azimuths: usize,
    /// Polar angles of incidence.
    pub polar: usize,
    /// Nodes of the distributions of normals, along polar angle and azimuth.
    pub normals: [usize; 2],
    /// Nodes of the values along each axis.
    pub values: usize,
}

impl RglGrid {
    /// Default grid of isotropic or anisotropic materials.
    pub fn of(isotropic: bool) -> Self {
        if isotropic {
            return Self { azimuths: 1, polar: 24, normals: [128, 64], values: 64 };
        }
        Self { azimuths: 17, polar: 12, normals: [64, 64], values: 32 }
    }

    fn phi_i(&self) -> Vec<f64> {
        let last = (self.azimuths - 1).max(1) as f64;
        (0..self.azimuths).map(|k| if self.azimuths == 1 { 0.0 } else { TAU * k as f64 / last - PI }).collect()
    }

    fn theta_i(&self) -> Vec<f64> {
        let most = STEEPEST_DEGREES.to_radians();
        (0..self.polar).map(|k| most * k as f64 / (self.polar - 1).max(1) as f64).collect()
    }

    /// The normal of a node `[u, v]` of the unit square.
    fn normal([u, v]: [f64; 2], phi_i: f64) -> Vector {
        from_polar(FRAC_PI_2 * u * u, TAU * v - PI + phi_i)
    }

    /// Directions whose retro-reflection gives the distribution of normals: `u` fastest.
    pub fn retro_pairs(&self) -> Vec<DirectionPair> {
        let [columns, rows] = self.normals;
        let at = |k: usize| [(k % columns) as f64 / (columns - 1) as f64, (k / columns) as f64 / (rows - 1) as f64];
        let pair = |k: usize| {
            let [x, y, z] = Self::normal(at(k), 0.0);
            // Above the horizon.
            let z = z.max(LOWEST);
            let length = (x * x + y * y + z * z).sqrt();
            let normal = [x, y, z].map(|c| c / length);
            DirectionPair::new(normal, normal)
        };
        (0..columns * rows).map(pair).collect()
    }

    /// Computes the distributions from the values at [`Self::retro_pairs`].
    ///
    /// # Errors
    /// Returns an error if there is not enough memory.
    pub fn distributions(self, retro: &[[f64; 3]]) -> Result<Distributions, FormatError> {
        let [columns, rows] = self.normals;
        let normal = |k: usize| {
            let v = if self.azimuths == 1 { 0.5 } else { (k / columns) as f64 / (rows - 1) as f64 };
            [(k % columns) as f64 / (columns - 1) as f64, v]
        };
        // A microfacet reflects D / (4 cos²) back; the minimum over a direction is the diffuse part.
        let bright: Vec<f64> = (0..columns * rows)
            .map(|k| {
                let row = if self.azimuths == 1 { 0 } else { k / columns };
                let cosine = Self::normal(normal(k), 0.0)[2].max(0.0);
                luminance(retro[row * columns + k % columns]).max(0.0) * 4.0 * cosine * cosine
            })
            .collect();
        let mean = bright.iter().sum::<f64>() / bright.len() as f64;
        let least = LEAST_DENSITY * if mean > 0.0 { mean } else { 1.0 };
        let ndf: Vec<f64> = bright.into_iter().map(|density| density + least).collect();
        let (phi_i, theta_i) = (self.phi_i(), self.theta_i());
        // Visible microfacets, in the unit square.
        let seen = |wi: Vector, turn: f64, k: usize| {
            let [u, v] = [(k % columns) as f64 / (columns - 1) as f64, (k / columns) as f64 / (rows - 1) as f64];
            let facing = dot(wi, Self::normal([u, v], turn)).max(0.0);
            ndf[k] * facing * u * (FRAC_PI_2 * u * u).sin()
        };
        let mut vndf = Vec::new();
        for phi in &phi_i {
            // Azimuths of isotropic materials are relative to the azimuth of incidence.
            let turn = if self.azimuths == 1 { *phi } else { 0.0 };
            for theta in &theta_i {
                let wi = from_polar(*theta, *phi);
                vndf.extend((0..columns * rows).map(|k| seen(wi, turn, k) as f32));
            }
        }
        let visible = VisibleNormals::new(&vndf, rows, columns)?;
        let sigma = self.projected_area(&ndf);
        Ok(Distributions { grid: self, phi_i, theta_i, ndf, sigma, vndf, visible })
    }

    /// Projected area of the microfacets by polar angle and azimuth of incidence.
    fn projected_area(&self, ndf: &[f64]) -> Vec<f64> {
        let [columns, rows] = self.normals;
        let area = |k: usize| {
            let at = [(k % columns) as f64 / (columns - 1) as f64, (k / columns) as f64 / (rows - 1) as f64];
            let wi = Self::normal(at, 0.0);
            let mut sum = 0.0;
            for (j, density) in ndf.iter().enumerate() {
                let [u, v] = [(j % columns) as f64 / (columns - 1) as f64, (j / columns) as f64 / (rows - 1) as f64];
                // The first and the last row are equal.
                let ends = if j / columns == 0 || j / columns == rows - 1 { 0.5 } else { 1.0 };
                let facing = dot(wi, Self::normal([u, v], 0.0)).max(0.0);
                // dω = sin θ dθ dφ, θ = π/2 u².
                sum += ends * density * facing * (FRAC_PI_2 * u * u).sin() * PI * u;
            }
            sum * TAU / ((columns - 1) * (rows - 1)) as f64
        };
        (0..columns * rows).map(area).collect()
    }
}

/// Distributions of normals, and the positions of values.
#[derive(Debug, Clone)]
pub struct Distributions {
    grid: RglGrid,
    phi_i: Vec<f64>,
    theta_i: Vec<f64>,
    ndf: Vec<f64>,
    sigma: Vec<f64>,
    vndf: Vec<f32>,
    visible: VisibleNormals,
}

impl Distributions {
    /// Direction pairs of the values: azimuths, polar angles, rows and columns, the last fastest. `None` below the
    /// horizon.
    pub fn pairs(&self) -> Vec<DirectionPair> {
        let n = self.grid.values;
        let mut pairs = Vec::new();
        for (p, phi) in self.phi_i.iter().enumerate() {
            let turn = if self.grid.azimuths == 1 { *phi } else { 0.0 };
            for (t, theta) in self.theta_i.iter().enumerate() {
                let (slice, wi) = (p * self.theta_i.len() + t, from_polar(*theta, *phi));
                for k in 0..n * n {
                    let warped = [(k % n) as f64 / (n - 1) as f64, (k / n) as f64 / (n - 1) as f64];
                    let normal = RglGrid::normal(self.visible.sample(slice, warped), turn);
                    let twice = 2.0 * dot(wi, normal);
                    pairs.push(DirectionPair::new(wi, [0, 1, 2].map(|c| twice * normal[c] - wi[c])));
                }
            }
        }
        pairs
    }

    /// Assembles the file's tables from the values at [`Self::pairs`].
    pub fn finish(self, values: &[[f64; 3]], description: String) -> Rgl {
        let pairs = self.pairs();
        let [columns, rows] = self.grid.normals;
        let map = |values: &[f64]| Map { rows, columns, values: values.iter().map(|v| *v as f32).collect() };
        let (ndf, sigma) = (map(&self.ndf), map(&self.sigma));
        let n = self.grid.values;
        let mut colours = Vec::with_capacity(3 * values.len());
        for (block, (pairs, values)) in pairs.chunks(n * n).zip(values.chunks(n * n)).enumerate() {
            let (phi, theta) = (self.phi_i[block / self.theta_i.len()], self.theta_i[block % self.theta_i.len()]);
            let stored: Vec<[f64; 3]> = pairs
                .iter()
                .zip(values)
                .map(|(pair, value)| {
                    let scale = pair.outgoing[2].max(0.0)
                        / super::jacobian(&ndf, &sigma, *pair, [theta, phi], self.grid.azimuths == 1);
                    value.map(|f| if scale.is_finite() { f.max(0.0) * scale } else { 0.0 })
                })
                .collect();
            for channel in 0..3 {
                colours.extend(stored.iter().map(|value| value[channel] as f32));
            }
        }
        let azimuths = if self.grid.azimuths == 1 { Azimuths::Isotropic } else { Azimuths::Full };
        Rgl {
            description,
            phi_i: self.phi_i,
            theta_i: self.theta_i,
            azimuths,
            ndf,
            sigma,
            vndf_rows: rows,
            vndf_columns: columns,
            vndf: self.vndf,
            colour_rows: n,
            colour_columns: n,
            colour: Colour::Rgb(colours),
            jacobian: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rgl::RglSource;
    use brdfc_core::address::parse_synth;
    use brdfc_core::{Source, Tally};

    /// Resamples as `brdfc convert` does, without threads.
    fn resampled(source: &dyn Source, grid: RglGrid) -> Rgl {
        let mut tally = Tally::default();
        let mut values = |pairs: &[DirectionPair]| -> Vec<[f64; 3]> {
            pairs.iter().map(|pair| source.eval(*pair, &mut tally)).collect()
        };
        let distributions = grid.distributions(&values(&grid.retro_pairs())).unwrap();
        let pairs = distributions.pairs();
        let values = values(&pairs);
        distributions.finish(&values, String::new())
    }

    #[test]
    fn points_round_trip_through_the_warped_square() {
        let source = parse_synth("synth:ggx?alpha=0.2").unwrap();
        let grid = RglGrid { azimuths: 1, polar: 3, normals: [24, 12], values: 8 };
        let retro: Vec<[f64; 3]> =
            grid.retro_pairs().iter().map(|pair| source.eval(*pair, &mut Tally::default())).collect();
        let visible = grid.distributions(&retro).unwrap().visible;
        for slice in 0..3 {
            let incidence = super::super::warp::Incidence::new(&[0.0], 0.0, &[0.0, 1.0, 2.0], slice as f64);
            for k in 1..400 {
                let warped = [f64::from(k % 20) / 20.0 + 0.02, f64::from(k / 20) / 20.0 + 0.02];
                let [u, v] = visible.sample(slice, warped);
                let back = visible.invert(&incidence, u, v);
                let apart = (back[0] - warped[0]).abs().max((back[1] - warped[1]).abs());
                assert!(apart < 2e-4, "{slice}: {warped:?} is {back:?}");
            }
        }
    }

    #[test]
    fn materials_are_recovered() {
        for (address, limit) in
            [("synth:lambert?kd=0.5", 2e-3), ("synth:ggx?kd=0.2&alpha=0.3", 0.03), ("synth:ward?ax=0.3&ay=0.5", 0.05)]
        {
            let source = parse_synth(address).unwrap();
            let isotropic = source.symmetry().isotropic;
            let rgl = resampled(source.as_ref(), RglGrid::of(isotropic));
            let found = RglSource::new(rgl, |_| unreachable!("the material is RGB")).unwrap();
            let (mut sum, mut count) = (0.0, 0.0);
            for k in 0..2000u32 {
                let share = |prime: f64| (f64::from(k) * prime).fract();
                let pair = DirectionPair::from_angles(
                    1.3 * share(0.754_877_666),
                    TAU * share(0.569_840_291),
                    1.3 * share(0.362_437),
                    TAU * share(0.819_172_5),
                );
                let mut tally = Tally::default();
                let [a, b] = [source.eval(pair, &mut tally)[1], found.eval(pair, &mut tally)[1]];
                sum += (a - b).abs() / a.max(1e-3);
                count += 1.0;
            }
            assert!(sum / count < limit, "{address}: {}", sum / count);
        }
    }
}
