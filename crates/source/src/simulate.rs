//! Simulated measurements of a source, as a goniometer or a MERL rig would record them.

use brdfc_core::words::format_number;
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{DirectionPair, Vector, dot};
use brdfc_readers::merl::{self, Dimensions, pair_of_angles};
use brdfc_readers::scan::Row;
use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::{FRAC_PI_2, TAU};

/// Bytes of a MERL file of a source. Cells whose directions are below the horizon are invalid.
pub fn merl_file(source: &dyn Source, dimensions: Dimensions) -> Vec<u8> {
    let mut bytes = Vec::new();
    merl::write(&mut bytes, dimensions, |angles| {
        let pair = pair_of_angles(angles);
        pair.is_above_horizon().then(|| source.eval(pair, &mut Tally::default()).map(|f| f.max(0.0)))
    })
    .expect("writing to memory succeeds");
    bytes
}

/// Parameters of a simulated scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPlan {
    /// Number of rows, including repeated ones.
    pub rows: usize,
    /// Number of incoming polar angles, evenly between 10 and 80 degrees.
    pub incidences: usize,
    /// Number of incoming azimuths over the full turn; by default 1 for isotropic materials, 8 for others.
    pub azimuths: Option<usize>,
    /// Standard deviation of the multiplicative noise, a fraction.
    pub noise: f64,
    /// Fraction of the outgoing hemisphere that is hidden, for example by the detector.
    pub gaps: f64,
    /// Fraction of rows that repeat an earlier direction pair, with independent noise.
    pub duplicates: f64,
    /// Seed of the random generator.
    pub seed: u64,
}

impl ScanPlan {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Returns an error for the first field out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let wrong = |field: &'static str, found: String, allowed: &str| Err(FormatError::whole(field, found, allowed));
        for (field, count) in
            [("rows", self.rows), ("incidences", self.incidences), ("azimuths", self.azimuths.unwrap_or(1))]
        {
            if count == 0 {
                return wrong(field, "0".to_owned(), "1 or more");
            }
        }
        let fractions = [("noise", self.noise, 2.0), ("gaps", self.gaps, 0.9), ("duplicates", self.duplicates, 0.9)];
        for (field, found, most) in fractions {
            if !(0.0..=most).contains(&found) {
                return wrong(field, format_number(found), &format!("0 to {most}"));
            }
        }
        Ok(())
    }
}

/// Rows of a simulated scan.
pub fn scan(source: &dyn Source, plan: &ScanPlan) -> Vec<Row> {
    let azimuths = plan.azimuths.unwrap_or(if source.symmetry().isotropic { 1 } else { 8 });
    let mut generator = ChaCha8Rng::seed_from_u64(plan.seed);
    let hidden: Vec<Vector> = (0..4).map(|_| upper_direction(&mut generator)).collect();
    // Four caps of solid angle 2π (1 - c) hide the requested fraction of 2π, where they do not overlap.
    let cosine = 1.0 - plan.gaps / hidden.len() as f64;
    let repeated = (plan.duplicates * plan.rows as f64).round() as usize;
    let mut rows: Vec<Row> = Vec::with_capacity(plan.rows);
    let mut tally = Tally::default();
    while rows.len() < plan.rows {
        let fresh = plan.rows - repeated;
        let [theta_i, phi_i, theta_o, phi_o] = if rows.len() < fresh {
            let number = rows.len() % (plan.incidences * azimuths);
            let (incidence, azimuth) = (number % plan.incidences, number / plan.incidences);
            let span = (plan.incidences - 1).max(1) as f64;
            let theta_i = (10.0 + 70.0 * incidence as f64 / span).to_radians();
            let phi_i = TAU * azimuth as f64 / azimuths as f64;
            let outgoing = loop {
                let direction = upper_direction(&mut generator);
                if hidden.iter().all(|centre| dot(*centre, direction) < cosine) {
                    break direction;
                }
            };
            [theta_i, phi_i, outgoing[2].acos().min(FRAC_PI_2), outgoing[1].atan2(outgoing[0])]
        } else {
            let row = rows[generator.random_range(0..fresh)];
            [row.theta_i, row.phi_i, row.theta_o, row.phi_o]
        };
        let exact = source.eval(DirectionPair::from_angles(theta_i, phi_i, theta_o, phi_o), &mut tally);
        let factor = (plan.noise * normal(&mut generator)).exp();
        rows.push(Row { theta_i, phi_i, theta_o, phi_o, value: exact.map(|f| f * factor) });
    }
    rows
}

/// Uniform direction in the hemisphere down to 85 degrees from the normal, the reach of real rigs.
fn upper_direction(generator: &mut ChaCha8Rng) -> Vector {
    let lowest = 85f64.to_radians().cos();
    let z = lowest + (1.0 - lowest) * generator.random::<f64>();
    let r = (1.0 - z * z).sqrt();
    let phi = TAU * generator.random::<f64>();
    [r * phi.cos(), r * phi.sin(), z]
}

/// Standard normal deviate, by Box and Muller.
fn normal(generator: &mut ChaCha8Rng) -> f64 {
    let u: f64 = 1.0 - generator.random::<f64>();
    let v: f64 = generator.random();
    (-2.0 * u.ln()).sqrt() * (TAU * v).cos()
}
