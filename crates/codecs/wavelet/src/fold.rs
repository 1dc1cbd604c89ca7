//! Symmetry of the grid: cells that are images of each other, so that each orbit is computed once.
//!
//! On the tangent-pole grid the mirror in `x = 0` flips columns and the mirror in `y = 0` flips rows, on both
//! hemispheres at once. An isotropic material without mirror symmetry still allows both flips together (half a turn).
//! The exchange of directions swaps the hemispheres (tangent-pole) or rotates the difference vector by half a turn
//! (half-difference). All three generate a group of 8.

use brdfc_core::Symmetry;
use brdfc_formats::direction::Parameterisation;

/// A flip of the columns, the rows, or both, of an `n` x `n` grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Flip {
    /// Longitude `θ` to `π - θ`: the mirror in `x = 0`.
    pub columns: bool,
    /// Colatitude `φ` to `π - φ`: the mirror in `y = 0`.
    pub rows: bool,
}

impl Flip {
    /// No flip.
    pub const NONE: Self = Self { columns: false, rows: false };
    /// Half a turn about the normal.
    pub const HALF_TURN: Self = Self { columns: true, rows: true };
    /// All four flips, in the order of [`Flip::number`].
    pub const ALL: [Self; 4] =
        [Self::NONE, Self { columns: true, rows: false }, Self { columns: false, rows: true }, Self::HALF_TURN];

    /// Number of the flip, 0 to 3.
    pub fn number(self) -> usize {
        usize::from(self.columns) + 2 * usize::from(self.rows)
    }

    /// Image of a cell, numbered row by row, on a grid of `n` x `n` cells, `n` a power of two: the mirror image of an
    /// index below a power of two has all its bits inverted.
    #[inline]
    pub fn cell(self, cell: usize, n: usize) -> usize {
        let columns = if self.columns { n - 1 } else { 0 };
        let rows = if self.rows { (n - 1) * n } else { 0 };
        cell ^ (columns | rows)
    }
}

impl Flip {
    /// The image of an `n` x `n` grid: `output[cell] = samples[flip(cell)]`.
    pub fn unfold(self, samples: &[f32], n: usize, output: &mut [f32]) {
        for (row, line) in output.chunks_exact_mut(n).enumerate() {
            let from = if self.rows { n - 1 - row } else { row };
            line.copy_from_slice(&samples[from * n..][..n]);
            if self.columns {
                line.reverse();
            }
        }
    }
}

/// Map of outer cells to the few rows that are computed.
#[derive(Debug, Clone)]
pub struct Fold {
    /// Cells per axis, a power of two.
    pub n: usize,
    parameterisation: Parameterisation,
    reciprocal: bool,
    mirror: bool,
    half_turn: bool,
    /// Outer cells of the fundamental domain, in ascending order: the table's rows.
    rows: Vec<u32>,
    /// Row and flip of every outer cell.
    located: Vec<(u32, Flip)>,
}

impl Fold {
    /// The fold that a symmetry allows on an `n` x `n` grid, `n` a power of two, at least 2.
    pub fn new(n: usize, parameterisation: Parameterisation, symmetry: Symmetry) -> Self {
        let mut fold = Self {
            n,
            parameterisation,
            reciprocal: symmetry.reciprocal,
            mirror: symmetry.mirror,
            half_turn: symmetry.mirror || symmetry.isotropic,
            rows: Vec::new(),
            located: Vec::with_capacity(n * n),
        };
        let mut row_of_cell = vec![u32::MAX; n * n];
        for cell in 0..n * n {
            if fold.flip_to_domain(cell) == Flip::NONE {
                row_of_cell[cell] = fold.rows.len() as u32;
                fold.rows.push(cell as u32);
            }
        }
        for cell in 0..n * n {
            let flip = fold.flip_to_domain(cell);
            fold.located.push((row_of_cell[flip.cell(cell, n)], flip));
        }
        fold
    }

    /// Outer cells that are computed.
    pub fn rows(&self) -> &[u32] {
        &self.rows
    }

    /// The flips that leave the table unchanged, [`Flip::NONE`] first.
    pub fn flips(&self) -> &'static [Flip] {
        const HALF_TURN: [Flip; 2] = [Flip::NONE, Flip::HALF_TURN];
        match (self.mirror, self.half_turn) {
            (true, _) => &Flip::ALL,
            (false, true) => &HALF_TURN,
            (false, false) => &HALF_TURN[..1],
        }
    }

    /// Size of the largest orbit: 1, 2, 4 or 8.
    pub fn order(&self) -> usize {
        self.flips().len() * if self.reciprocal { 2 } else { 1 }
    }

    /// The flip that takes an outer cell into the fundamental domain.
    fn flip_to_domain(&self, cell: usize) -> Flip {
        let (row, column) = (cell / self.n, cell % self.n);
        let (low, right) = (row >= self.n / 2, column >= self.n / 2);
        match (self.mirror, self.half_turn) {
            (true, _) => Flip { columns: right, rows: low },
            (false, true) if low => Flip::HALF_TURN,
            _ => Flip::NONE,
        }
    }

    /// The table row of an outer cell, and the corresponding flip of the inner cells: `f[cell][inner] =
    /// table[row][flip(inner)]`.
    #[inline]
    pub fn locate(&self, cell: usize) -> (usize, Flip) {
        let (row, flip) = self.located[cell];
        (row as usize, flip)
    }

    /// Row and inner cell of the same sample with exchanged light and viewer; `None` for a source that is not
    /// reciprocal.
    #[inline]
    pub fn exchanged(&self, row: usize, inner: usize) -> Option<(usize, usize)> {
        if !self.reciprocal {
            return None;
        }
        match self.parameterisation {
            Parameterisation::TangentPole => {
                let (other, flip) = self.locate(inner);
                Some((other, flip.cell(self.rows[row] as usize, self.n)))
            }
            Parameterisation::HalfDifference => Some((row, Flip::HALF_TURN.cell(inner, self.n))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::cell_centre;
    use proptest::prelude::*;

    const SYMMETRIES: [Symmetry; 6] = [
        Symmetry::NONE,
        Symmetry { isotropic: true, mirror: false, reciprocal: false },
        Symmetry { isotropic: true, mirror: false, reciprocal: true },
        Symmetry { isotropic: false, mirror: true, reciprocal: true },
        Symmetry { isotropic: false, mirror: false, reciprocal: true },
        Symmetry::FULL,
    ];

    #[test]
    fn orders() {
        let order = |s| Fold::new(8, Parameterisation::TangentPole, s).order();
        assert_eq!(SYMMETRIES.map(order), [1, 2, 4, 8, 2, 8]);
    }

    #[test]
    fn flips_are_the_mirrors_of_directions() {
        for cell in 0..64 {
            let d = cell_centre(cell % 8, cell / 8, 8);
            for flip in Flip::ALL {
                let image = flip.cell(cell, 8);
                let e = cell_centre(image % 8, image / 8, 8);
                let sign = |flipped: bool| if flipped { -1.0 } else { 1.0 };
                assert!((e[0] - sign(flip.columns) * d[0]).abs() < 1e-12);
                assert!((e[1] - sign(flip.rows) * d[1]).abs() < 1e-12);
            }
        }
    }

    proptest! {
        #[test]
        fn exchange_is_its_own_inverse_and_a_symmetry(
            which in 0usize..6, outer in 0usize..64, inner in 0usize..64, half in any::<bool>()
        ) {
            let p = if half { Parameterisation::HalfDifference } else { Parameterisation::TangentPole };
            let fold = Fold::new(8, p, SYMMETRIES[which]);
            let (row, flip) = fold.locate(outer);
            let inner = flip.cell(inner, 8);
            if let Some((row2, inner2)) = fold.exchanged(row, inner) {
                prop_assert_eq!(fold.exchanged(row2, inner2), Some((row, inner)));
                // Exchanged directions equal the directions of the partner, up to an allowed flip.
                let centre = |cell: usize| cell_centre(cell % 8, cell / 8, 8);
                let pair = |row: usize, inner: usize| p.from_axes(centre(fold.rows()[row] as usize), centre(inner));
                let (a, b) = (pair(row, inner).exchanged(), pair(row2, inner2));
                let matches = fold.flips().iter().any(|flip| {
                    let image = |v: [f64; 3]| {
                        [if flip.columns { -v[0] } else { v[0] }, if flip.rows { -v[1] } else { v[1] }, v[2]]
                    };
                    let close = |u: [f64; 3], v: [f64; 3]| (0..3).all(|k| (u[k] - v[k]).abs() < 1e-12);
                    close(image(a.incoming), b.incoming) && close(image(a.outgoing), b.outgoing)
                });
                prop_assert!(matches, "{:?} {:?}", a, b);
            }
        }
    }
}
