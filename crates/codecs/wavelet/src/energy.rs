//! Levels of detail that preserve energy: each has a tree of its own, of logarithms of means of reflectances. The paper has
//! one tree, whose coarser levels are means of logarithms and darker.

use super::table::{Grid, Table};
use brdfc_formats::wavelet::Header;
use ndarray::Array3;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Coefficients that a tree keeps at least, if it and the finest tree have that many: levels of up to 4 x 4 cells are then
/// complete, and have the energy of the table even if the finest level has lost some of it.
const FEWEST: usize = 16;

/// The table at a level of detail: means over squares of `2^(N-l) x 2^(N-l)` inner cells, weighted by `∫ cos θ_o dω`, so
/// that each outer cell keeps its directional albedo.
pub fn means(table: &Table, level: u32) -> Table {
    let (n, side) = (table.grid.n(), 1usize << level);
    let (block, weights) = (n / side, cosine_weights(n));
    let (channels, rows, _) = table.values.dim();
    let mean = |values: &[f32], at: usize| {
        let (top, left) = (at / side * block, at % side * block);
        let cells = (0..block * block).map(|k| (top + k / block) * n + left + k % block);
        let [sum, whole] = cells.fold([0.0; 2], |[sum, whole], cell| {
            [sum + weights[cell] * f64::from(values[cell]), whole + weights[cell]]
        });
        (sum / whole) as f32
    };
    let values: Vec<f32> = (0..channels * rows)
        .into_par_iter()
        .flat_map_iter(|row| {
            let values = table.row(row / rows, row % rows);
            (0..side * side).map(move |at| (values, at)).map(|(values, at)| mean(values, at)).collect::<Vec<_>>()
        })
        .collect();
    let values = Array3::from_shape_vec((channels, rows, side * side), values).expect("a value for each cell");
    Table { grid: Grid { levels: level, ..table.grid }, fold: table.fold.clone(), values }
}

/// Coefficients of the finest tree of a pack whose levels end at that of `coarse`, the coefficients of this level.
pub fn padded(coarse: &Table, grid: Grid) -> Table {
    let (channels, rows, cells) = coarse.values.dim();
    let scale = (grid.n() / coarse.grid.n()) as f32;
    let value = |(channel, row, k): (usize, usize, usize)| {
        if k < cells { scale * coarse.values[(channel, row, k)] } else { 0.0 }
    };
    let values = Array3::from_shape_fn((channels, rows, grid.cells()), value);
    Table { grid, fold: coarse.fold.clone(), values }
}

/// Number of coefficients of the tree of each level, the coarsest first, that look-ups within the range read, without the
/// finest tree. Those of the finest tree are `needed`.
pub fn needed_in_trees(header: &Header, needed: &[bool]) -> Vec<usize> {
    let of_level = |level: u32| needed[..1 << (2 * level)].iter().filter(|needed| **needed).count();
    (0..header.trees()).map(of_level).collect()
}

/// Number of slices of a tree with `needed` coefficients, if the finest tree keeps `retained` of `of` coefficients: the same
/// share, but not too few.
pub fn slices_of_tree(needed: usize, [retained, of]: [usize; 2]) -> usize {
    (needed * retained).div_ceil(of).clamp(needed.min(retained).min(FEWEST), needed)
}

/// Number of slices of a pack: the zero slice, `finest` of the finest tree, and the share of the others, see
/// [`slices_of_tree`] and [`needed_in_trees`].
pub fn slices_of_pack(finest: usize, needed: &[usize], share: [usize; 2]) -> usize {
    1 + finest + needed.iter().map(|needed| slices_of_tree(*needed, share)).sum::<usize>()
}

/// `∫ cos θ_o dω = ∫ sin² φ dφ ∫ sin θ dθ` over each cell of the outgoing hemisphere.
fn cosine_weights(n: usize) -> Vec<f64> {
    let angle = |k: usize| PI * k as f64 / n as f64;
    let row = |r: usize| 0.5 * (angle(r + 1) - angle(r)) - 0.25 * ((2.0 * angle(r + 1)).sin() - (2.0 * angle(r)).sin());
    let column = |c: usize| angle(c).cos() - angle(c + 1).cos();
    (0..n * n).map(|cell| row(cell / n) * column(cell % n)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::resample::resample;
    use brdfc_core::analytic::Ggx;
    use brdfc_formats::direction::Parameterisation;

    const GRID: Grid = Grid { parameterisation: Parameterisation::TangentPole, levels: 3 };

    fn albedos(table: &Table) -> Vec<f64> {
        let weights = cosine_weights(table.grid.n());
        let albedo = |row| table.row(0, row).iter().zip(&weights).map(|(f, w)| f64::from(*f) * w).sum();
        (0..table.fold.rows().len()).map(albedo).collect()
    }

    #[test]
    fn all_levels_have_the_albedo_of_the_table() {
        let source = Ggx { kd: [0.1; 3], f0: [0.5; 3], alpha_x: 0.2, alpha_y: 0.4 };
        let table = resample(&source, GRID).0;
        let expected = albedos(&table);
        for level in 0..=3 {
            for (found, expected) in albedos(&means(&table, level)).iter().zip(&expected) {
                assert!((found / expected - 1.0).abs() < 1e-6, "{level}: {found} {expected}");
            }
        }
        // Control: means of logarithms are darker.
        let mut logarithms = table.clone();
        logarithms.values.mapv_inplace(f32::ln);
        let mut darker = means(&logarithms, 0);
        darker.values.mapv_inplace(f32::exp);
        assert!(albedos(&darker).iter().zip(&expected).all(|(found, expected)| *found < 0.9 * expected));
    }

    /// `∫ cos θ_o dω` over the hemisphere is π.
    #[test]
    fn weights_cover_the_hemisphere() {
        for n in [2, 8, 64] {
            assert!((cosine_weights(n).iter().sum::<f64>() - PI).abs() < 1e-12);
        }
    }

    #[test]
    fn trees_keep_the_share_of_the_finest() {
        let header = Header {
            parameterisation: Parameterisation::TangentPole,
            levels: 5,
            stored_levels: 5,
            channels: 1,
            bits: 8,
            mean: 1.0,
            bias: 0.01,
            energy_preserving: true,
        };
        let trees = needed_in_trees(&header, &[true; 1024]);
        assert_eq!(trees, [1, 4, 16, 64, 256]);
        let of = |retained| trees.iter().map(|needed| slices_of_tree(*needed, [retained, 1024])).collect::<Vec<_>>();
        assert_eq!(of(256), [1, 4, 16, 16, 64]);
        assert_eq!(of(1024), [1, 4, 16, 64, 256]);
        assert_eq!(of(8), [1, 4, 8, 8, 8]);
        assert_eq!(of(1), [1; 5]);
        assert_eq!(slices_of_pack(256, &trees, [256, 1024]), 1 + 256 + 101);
        // Without the coefficients that no look-up reads.
        assert_eq!(slices_of_tree(32, [72, 72]), 32);
        assert_eq!(slices_of_tree(32, [36, 72]), 16);
        assert!(needed_in_trees(&Header { energy_preserving: false, ..header }, &[true; 1024]).is_empty());
    }
}
