//! Sampling distributions, for callers that need any number of samples, or densities.

use super::half_vector::{jacobian, reflected};
use super::{Distribution, ImportanceRecipe, cell_probabilities};
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, dot, normalize};
use brdfc_formats::importance::ImportanceHeader;
use rayon::prelude::*;

/// Distributions of incoming directions proportional to a lobe, for every outgoing direction.
#[derive(Debug, Clone)]
pub struct LobeDistributions {
    header: ImportanceHeader,
    rows: Vec<Distribution>,
}

impl LobeDistributions {
    /// Tabulates the lobe of every row of the header for the recipe.
    ///
    /// # Errors
    /// Returns an error if a number of the recipe is out of range.
    pub fn new(source: &dyn Source, recipe: &ImportanceRecipe) -> Result<Self, FormatError> {
        let header = recipe.check(source.symmetry().isotropic)?;
        let row = |row: u32| {
            let probabilities = cell_probabilities(source, &header, row, recipe, &mut Tally::default());
            Distribution::new(recipe.grid, &probabilities)
        };
        Ok(Self { header, rows: (0..header.rows()).into_par_iter().map(row).collect() })
    }

    /// Maps a point of the unit square to an incoming direction and its inverse density, sr; the inverse density is 0
    /// below the horizon.
    pub fn sample(&self, outgoing: Vector, point: [f64; 2]) -> (Vector, f64) {
        let [x, y, z, density] = self.row(outgoing).sample(point).map(f64::from);
        let half = self.turned(outgoing, [x, y, z], 1.0);
        let projection = dot(outgoing, half);
        let incoming = reflected(outgoing, half, projection);
        let above = incoming[2] > 0.0 && outgoing[2] > 0.0;
        (incoming, if above { jacobian(projection) / density } else { 0.0 })
    }

    /// Density per steradian of incoming directions.
    pub fn density(&self, outgoing: Vector, incoming: Vector) -> f64 {
        if incoming[2] <= 0.0 || outgoing[2] <= 0.0 {
            return 0.0;
        }
        let half = normalize([0, 1, 2].map(|k| incoming[k] + outgoing[k]));
        let stored = self.turned(outgoing, half, -1.0);
        self.row(outgoing).density_at(stored) / jacobian(dot(outgoing, half))
    }

    fn row(&self, outgoing: Vector) -> &Distribution {
        &self.rows[self.header.row(outgoing.map(|c| c as f32)) as usize]
    }

    /// Rotates by the azimuth of the outgoing direction, or back. Rows of isotropic materials store outgoing directions
    /// over the tangent.
    fn turned(&self, outgoing: Vector, half: Vector, sense: f64) -> Vector {
        let length = outgoing[0].hypot(outgoing[1]);
        if !self.header.isotropic() || length == 0.0 {
            return half;
        }
        let (cosine, sine) = (outgoing[0] / length, sense * outgoing[1] / length);
        [cosine * half[0] - sine * half[1], sine * half[0] + cosine * half[1], half[2]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sequence_point;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::from_polar;

    #[test]
    fn samples_have_the_density_of_their_direction() {
        for address in ["synth:ggx?alpha=0.2", "synth:ward?ax=0.2&ay=0.5"] {
            let source = parse_synth(address).unwrap();
            let lobes = LobeDistributions::new(source.as_ref(), &ImportanceRecipe::default()).unwrap();
            let mut compared = 0;
            for outgoing in [from_polar(0.3, 1.0), from_polar(1.1, 4.0), [0.0, 0.0, 1.0]] {
                for index in 0..500 {
                    let (incoming, inverse) = lobes.sample(outgoing, sequence_point(index));
                    if inverse > 0.0 {
                        let density = lobes.density(outgoing, incoming);
                        // Rounding may place the borders of cells on either side.
                        compared += usize::from((density * inverse - 1.0).abs() < 1e-3);
                    }
                }
            }
            assert!(compared > 1300, "{address}: {compared}");
        }
    }

    #[test]
    fn densities_integrate_to_the_share_above_the_horizon() {
        let source = parse_synth("synth:ggx?alpha=0.3").unwrap();
        let lobes = LobeDistributions::new(source.as_ref(), &ImportanceRecipe::default()).unwrap();
        let outgoing = from_polar(0.7, 2.0);
        let above = (0..4096).filter(|k| lobes.sample(outgoing, sequence_point(*k)).1 > 0.0).count() as f64 / 4096.0;
        let (rings, turns) = (512, 512);
        let mut sum = 0.0;
        for ring in 0..rings {
            let z = (f64::from(ring) + 0.5) / f64::from(rings);
            for turn in 0..turns {
                let phi = (f64::from(turn) + 0.5) / f64::from(turns) * std::f64::consts::TAU;
                sum += lobes.density(outgoing, from_polar(z.acos(), phi));
            }
        }
        let integral = sum * std::f64::consts::TAU / f64::from(rings * turns);
        assert!((integral - above).abs() < 0.01, "{integral} {above}");
    }
}
