//! Probabilities of half vectors.

use super::half_vector::{jacobian, reflected};
use super::recipe::ImportanceRecipe;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, dot};
use brdfc_formats::importance::ImportanceHeader;
use std::f64::consts::FRAC_1_PI;

/// Upper bound of values, which keeps sums finite.
const MAX_VALUE: f64 = 1e30;
/// Part of the defensive share that is uniform over all half vectors, including half vectors that no direction of the
/// row has.
const UNIFORM: f64 = 0.1;

/// Probability of each cell of the grid, ring by ring, for the outgoing direction in the middle of `row`; all are
/// positive and sum to 1.
///
/// Incoming directions are sampled in proportion to the luminance of `f_r cos θi`. Reflection of `wo` about `h` maps
/// one steradian of half vectors to `jacobian` steradians of incoming directions, so the density of half vectors is
/// proportional to `f_r cos θi 4 (wo · h)`. Most of the defensive share is the same with a constant for `f_r`, the
/// largest over the outgoing directions of the row; a tenth of it is uniform. This covers all half vectors that any
/// outgoing direction can have.
pub fn cell_probabilities(
    source: &dyn Source,
    header: &ImportanceHeader,
    row: u32,
    recipe: &ImportanceRecipe,
    tally: &mut Tally,
) -> Vec<f64> {
    let grid = recipe.grid;
    let outgoing = header.outgoing(row, 0.0);
    let others = [header.outgoing(row, -0.5), header.outgoing(row, 0.5)];
    let folded = header.isotropic() && source.symmetry().mirror;
    let mut lobe = vec![0.0; grid.cells()];
    let mut cosine = vec![0.0; grid.cells()];
    for ring in 0..grid.polar {
        let solid_angle = grid.solid_angle(ring);
        for cell in 0..grid.azimuths {
            let at = ring * grid.azimuths + cell;
            let image = grid.azimuths - 1 - cell;
            if folded && image < cell {
                lobe[at] = lobe[at - cell + image];
                cosine[at] = cosine[at - cell + image];
                continue;
            }
            let half = grid.centre(ring, cell);
            let (incoming, mut largest) = density(outgoing, half);
            if largest > 0.0 {
                lobe[at] = luminance(source, DirectionPair::new(incoming, outgoing), tally) * largest * solid_angle;
            }
            for other in others {
                largest = largest.max(density(other, half).1);
            }
            cosine[at] = largest * FRAC_1_PI * solid_angle;
        }
    }
    let (lobe_sum, cosine_sum) = (lobe.iter().sum::<f64>(), cosine.iter().sum::<f64>());
    // A black material has no lobe to follow.
    let defensive = if lobe_sum > 0.0 { recipe.defensive } else { 1.0 };
    let lobe_scale = if lobe_sum > 0.0 { (1.0 - defensive) / lobe_sum } else { 0.0 };
    let uniform = if cosine_sum > 0.0 { UNIFORM } else { 1.0 };
    let cosine_scale = if cosine_sum > 0.0 { defensive * (1.0 - uniform) / cosine_sum } else { 0.0 };
    let hemisphere = grid.border(grid.polar) * std::f64::consts::TAU;
    for (at, (value, cosine)) in lobe.iter_mut().zip(&cosine).enumerate() {
        let even = grid.solid_angle(at / grid.azimuths) / hemisphere;
        *value = lobe_scale * *value + cosine_scale * cosine + defensive * uniform * even;
    }
    lobe
}

/// The incoming direction of a half vector, and the unnormalised density of half vectors per `f_r`: `cos θi 4 (wo ·
/// h)`; 0 if the light or the viewer is below the horizon.
fn density(outgoing: Vector, half: Vector) -> (Vector, f64) {
    let projection = dot(outgoing, half);
    let incoming = reflected(outgoing, half, projection);
    (incoming, incoming[2].max(0.0) * jacobian(projection.max(0.0)))
}

fn luminance(source: &dyn Source, pair: DirectionPair, tally: &mut Tally) -> f64 {
    let value = source.eval(pair, tally);
    // NaN becomes 0 as well.
    brdfc_core::luminance(value.map(|channel| channel.max(0.0))).min(MAX_VALUE)
}
