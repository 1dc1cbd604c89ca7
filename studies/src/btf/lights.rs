//! The fitted lights, and interpolation to the held-out lights.

use brdfc_formats::FormatError;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;

/// Lights, fitted and held out.
pub(super) struct Lights {
    /// Unit vectors to all of them.
    pub(super) directions: Vec<[f32; 3]>,
    /// Indices of the fitted lights, ascending.
    pub(super) fitted: Vec<usize>,
    /// Indices of the held-out lights, ascending.
    pub(super) held_out: Vec<usize>,
    /// For each held-out light, the surrounding fitted lights, by their index in `fitted`, and their weights.
    pub(super) blends: Vec<([u32; 3], [f32; 3])>,
}

impl Lights {
    /// The lights of a set, some of them held out.
    ///
    /// # Errors
    /// Returns an error for lights that cannot be blended.
    pub(super) fn new(set: &DirectionSet, held_out: &[usize]) -> Result<Self, FormatError> {
        let directions: Vec<[f32; 3]> = set.directions().iter().map(|light| light.map(|c| c as f32)).collect();
        let (held_out, fitted): (Vec<usize>, Vec<usize>) =
            (0..directions.len()).partition(|light| held_out.contains(light));
        let angles = fitted.iter().map(|light| set.angles[*light]).collect();
        let mesh = DirectionMesh::new(&DirectionSet::new("fitted lights", angles)?)?;
        let blends = held_out.iter().map(|light| mesh.weights(directions[*light])).collect();
        Ok(Self { directions, fitted, held_out, blends })
    }

    /// Unit vectors to the fitted lights.
    pub(super) fn fitted_directions(&self) -> Vec<[f32; 3]> {
        self.fitted.iter().map(|light| self.directions[*light]).collect()
    }

    /// Renderings under all lights from those under the fitted ones. Held-out lights are blended from three neighbours,
    /// as in a renderer.
    pub(super) fn completed(&self, fitted: Vec<Vec<[f32; 3]>>) -> Vec<Vec<[f32; 3]>> {
        let blended = |(indices, weights): &([u32; 3], [f32; 3])| -> Vec<[f32; 3]> {
            let [a, b, c] = indices.map(|light| &fitted[light as usize]);
            let mixed =
                |k: usize| [0, 1, 2].map(|i| weights[0] * a[k][i] + weights[1] * b[k][i] + weights[2] * c[k][i]);
            (0..a.len()).map(mixed).collect()
        };
        let held_out: Vec<Vec<[f32; 3]>> = self.blends.iter().map(blended).collect();
        let mut all = vec![Vec::new(); self.directions.len()];
        self.fitted.iter().zip(fitted).for_each(|(light, rendering)| all[*light] = rendering);
        self.held_out.iter().zip(held_out).for_each(|(light, rendering)| all[*light] = rendering);
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn held_out_lights_are_blended_from_their_neighbours() {
        let set = DirectionSet::grid(4, 8, 75.0).unwrap();
        let lights = Lights::new(&set, &[9, 3]).unwrap();
        assert_eq!((lights.fitted.len(), &lights.held_out), (23, &vec![3, 9]));
        // Functions that are linear in paraboloid coordinates are reproduced inside the hull.
        let value = |[x, _, z]: [f32; 3]| 0.5 + 0.3 * x / (1.0 + z);
        let renderings = lights.fitted_directions().into_iter().map(|light| vec![[value(light); 3]; 2]).collect();
        let all = lights.completed(renderings);
        for (light, direction) in lights.directions.iter().enumerate() {
            assert!((all[light][1][2] - value(*direction)).abs() < 1e-5, "{light}");
        }
    }
}
