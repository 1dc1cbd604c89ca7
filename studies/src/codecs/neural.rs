//! Neural BRDFs: "Neural BRDF Representation and Importance Sampling", Sztrajman, Rainer, Ritschel and Weyrich 2021.

use brdfc_core::half_difference::half_difference_angles;
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use std::fmt::Write;

/// Half and difference vector.
const INPUTS: usize = 6;
/// Neurons of each hidden layer.
const HIDDEN: usize = 21;
const CHANNELS: usize = 3;
/// Number of weights: matrices and biases of three dense layers.
pub const NETWORK_WEIGHTS: usize = (INPUTS + 1 + HIDDEN + 1 + CHANNELS) * HIDDEN + CHANNELS;

/// A network of two hidden layers from the half and difference vector to `ln(f + 1)`.
#[derive(Debug, Clone)]
pub struct NeuralBrdf {
    layers: [Layer; 3],
}

/// A dense layer.
#[derive(Debug, Clone)]
struct Layer {
    /// Weights of each output.
    rows: Vec<Vec<f32>>,
    /// Biases, one for each output.
    biases: Vec<f32>,
}

impl Layer {
    /// Takes the weights of a layer off the front of `weights`.
    fn take(weights: &mut &[f32], inputs: usize, outputs: usize) -> Self {
        let (matrix, rest) = weights.split_at(inputs * outputs);
        let (biases, rest) = rest.split_at(outputs);
        *weights = rest;
        let row = |output: usize| (0..inputs).map(|input| matrix[input * outputs + output]).collect();
        Self { rows: (0..outputs).map(row).collect(), biases: biases.to_vec() }
    }

    fn outputs(&self, inputs: &[f32]) -> Vec<f32> {
        let output = |(row, bias): (&Vec<f32>, &f32)| bias + row.iter().zip(inputs).map(|(w, v)| w * v).sum::<f32>();
        self.rows.iter().zip(&self.biases).map(output).collect()
    }
}

impl NeuralBrdf {
    /// Makes a network from its weights: for each layer its matrix, a row for each input, then its biases. `None` if their
    /// number is not [`NETWORK_WEIGHTS`], or if one is not finite.
    pub fn new(mut weights: &[f32]) -> Option<Self> {
        let is_network = weights.len() == NETWORK_WEIGHTS && weights.iter().all(|weight| weight.is_finite());
        is_network.then(|| Self {
            layers: [[INPUTS, HIDDEN], [HIDDEN, HIDDEN], [HIDDEN, CHANNELS]]
                .map(|[inputs, outputs]| Layer::take(&mut weights, inputs, outputs)),
        })
    }

    /// Bytes of the weights.
    pub(super) fn bytes() -> u64 {
        4 * NETWORK_WEIGHTS as u64
    }

    /// Layers, for the setting of a row.
    pub(super) fn setting() -> String {
        format!("{INPUTS}-{HIDDEN}-{HIDDEN}-{CHANNELS}")
    }

    /// The model as WGSL: products of 4 x 4 matrices, as an engine would write it.
    pub(super) fn shader(&self) -> String {
        let mut body = String::new();
        for (number, layer) in self.layers.iter().enumerate() {
            let blocks = layer.rows.first().map_or(0, |row| row.len().div_ceil(4));
            let weight = |row: usize, column: usize| {
                layer.rows.get(row).and_then(|row| row.get(column)).copied().unwrap_or_default()
            };
            let vector = |values: [f32; 4]| {
                let [a, b, c, d] = values;
                format!("vec4<f32>({a:?}, {b:?}, {c:?}, {d:?})")
            };
            for rows in 0..layer.rows.len().div_ceil(4) {
                let biases = [0, 1, 2, 3].map(|k| layer.biases.get(4 * rows + k).copied().unwrap_or_default());
                let mut sum = vector(biases);
                for block in 0..blocks {
                    let columns = [0, 1, 2, 3]
                        .map(|k| vector([0, 1, 2, 3].map(|row| weight(4 * rows + row, 4 * block + k))))
                        .join(", ");
                    let _ = write!(sum, "\n        + mat4x4<f32>({columns}) * v{number}_{block}");
                }
                let sum = if number < 2 { format!("max({sum}, vec4<f32>(0.0))") } else { sum };
                let _ = writeln!(body, "    let v{}_{rows} = {sum};", number + 1);
            }
        }
        include_str!("neural.wgsl").replace("    // LAYERS\n", &body)
    }
}

impl Source for NeuralBrdf {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if !pair.is_above_horizon() {
            return [0.0; 3];
        }
        let [theta_h, theta_d, phi_d] = half_difference_angles(pair);
        let half = [theta_h.sin(), 0.0, theta_h.cos()];
        let difference = [theta_d.sin() * phi_d.cos(), theta_d.sin() * phi_d.sin(), theta_d.cos()];
        let mut values: Vec<f32> = half.into_iter().chain(difference).map(|v| v as f32).collect();
        for (number, layer) in self.layers.iter().enumerate() {
            values = layer.outputs(&values);
            if number < 2 {
                values.iter_mut().for_each(|v| *v = v.max(0.0));
            }
        }
        std::array::from_fn(|c| f64::from(values[c].exp_m1().max(0.0)))
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry { isotropic: true, ..Symmetry::NONE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::from_polar;

    /// A network whose output is `ln(1 + 0.5 cos θ_h)` in red and constants in green and blue.
    fn network() -> Vec<f32> {
        let mut weights = vec![0.0; NETWORK_WEIGHTS];
        // cos θ_h is the third input, and passes both hidden layers in their first neuron.
        weights[2 * HIDDEN] = 1.0;
        let second = (INPUTS + 1) * HIDDEN;
        weights[second] = 1.0;
        let third = second + (HIDDEN + 1) * HIDDEN;
        weights[third] = 0.5;
        let [.., red, green, blue] = &mut weights[..] else { unreachable!() };
        [*red, *green, *blue] = [0.0, 2f32.ln(), -1.0];
        weights
    }

    #[test]
    fn layers_are_read_in_order() {
        let found = NeuralBrdf::new(&network()).unwrap();
        let pair = DirectionPair::new(from_polar(0.5, 0.0), from_polar(0.5, std::f64::consts::PI));
        let [red, green, blue] = found.eval(pair, &mut Tally::default());
        assert!((red - 0.5f64.exp_m1()).abs() < 1e-6 && (green - 1.0).abs() < 1e-6, "{red} {green}");
        assert_eq!(blue, 0.0);
        let below = DirectionPair::new(from_polar(0.5, 0.0), from_polar(2.0, 0.0));
        assert_eq!(found.eval(below, &mut Tally::default()), [0.0; 3]);
        assert!(NeuralBrdf::new(&network()[1..]).is_none());
    }
}
