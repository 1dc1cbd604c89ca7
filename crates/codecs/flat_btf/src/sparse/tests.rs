use super::elimination::{Elimination, Graph};
use super::*;
use crate::testing::Patience;
use brdfc_core::progress::Cancelled;
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use std::sync::Arc;

/// A symmetric matrix as the caller provides it.
#[derive(Debug, Clone)]
struct Matrix {
    rows: usize,
    places: Vec<[u32; 2]>,
    values: Vec<f64>,
}

impl Matrix {
    fn empty(rows: usize) -> Self {
        Self { rows, places: Vec::new(), values: Vec::new() }
    }

    fn add(&mut self, row: usize, column: usize, value: f64) {
        self.places.push([row as u32, column as u32]);
        self.values.push(value);
    }

    /// A weighted graph's Laplacian plus `rest` on the diagonal.
    fn laplacian(rows: usize, edges: &[(usize, usize, f64)], rest: f64) -> Self {
        let mut matrix = Self::empty(rows);
        for (a, b, weight) in edges {
            matrix.add(*a, *b, -weight);
            matrix.add(*a, *a, *weight);
            matrix.add(*b, *b, *weight);
        }
        (0..rows).for_each(|row| matrix.add(row, row, rest));
        matrix
    }

    /// Laplacian of a periodic grid of `n` x `n` points with diagonals.
    fn torus(n: usize) -> Self {
        let mut edges = Vec::new();
        for (x, y) in (0..n * n).map(|at| (at % n, at / n)) {
            for (dx, dy) in [(1, 0), (0, 1), (1, 1)] {
                let other = (y + dy) % n * n + (x + dx) % n;
                edges.push((y * n + x, other, 1.0 + ((x * 31 + y * 17 + dx) % 7) as f64));
            }
        }
        Self::laplacian(n * n, &edges, 1e-3)
    }

    fn dense(&self) -> DMatrix<f64> {
        let mut dense = DMatrix::zeros(self.rows, self.rows);
        for ([a, b], value) in self.places.iter().zip(&self.values) {
            let [a, b] = [*a as usize, *b as usize];
            dense[(a, b)] += value;
            if a != b {
                dense[(b, a)] += value;
            }
        }
        dense
    }

    fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.rows];
        for ([a, b], value) in self.places.iter().zip(&self.values) {
            let [a, b] = [*a as usize, *b as usize];
            out[a] += value * x[b];
            if a != b {
                out[b] += value * x[a];
            }
        }
        out
    }

    fn symbolic(&self) -> Arc<Symbolic> {
        Arc::new(Symbolic::new(self.rows, &self.places).unwrap())
    }

    fn factor(&self) -> Result<Cholesky, FactorError> {
        Cholesky::new(&self.symbolic(), &self.values, &())
    }

    /// Largest difference of `A x` and `right`, relative to the largest row sum of `|A|` times the largest `|x|`.
    fn error(&self, x: &[f64], right: &[f64]) -> f64 {
        let largest = |v: &[f64]| v.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        let sizes = Self { values: self.values.iter().map(|v| v.abs()).collect(), ..self.clone() };
        let off: Vec<f64> = self.times(x).iter().zip(right).map(|(a, b)| a - b).collect();
        assert!(off.iter().all(|v| v.is_finite()));
        largest(&off) / (largest(&sizes.times(&vec![1.0; self.rows])) * largest(x)).max(f64::MIN_POSITIVE)
    }
}

fn rough(n: usize) -> Vec<f64> {
    (0..n).map(|i| ((i * 7919 + 13) % 997) as f64 / 997.0 - 0.5).collect()
}

fn solved(matrix: &Matrix, right: &[f64]) -> Vec<f64> {
    let mut x: Vec<[f64; 1]> = right.iter().map(|v| [*v]).collect();
    matrix.factor().unwrap().solve(&mut x);
    x.into_iter().flatten().collect()
}

/// Edges between every two vertices of `of`.
fn clique(of: std::ops::Range<usize>) -> impl Iterator<Item = (usize, usize, f64)> {
    of.clone().flat_map(move |a| (of.start..a).map(move |b| (a, b, 1.0)))
}

#[test]
fn the_identity_changes_nothing() {
    for rows in [0, 1, 4, 9] {
        let mut matrix = Matrix::empty(rows);
        (0..rows).for_each(|row| matrix.add(row, row, 1.0));
        let mut x: Vec<[f64; 2]> = (0..rows).map(|row| [row as f64, -0.3]).collect();
        let before = x.clone();
        matrix.factor().unwrap().solve(&mut x);
        assert_eq!(x, before);
    }
}

#[test]
fn a_small_system_by_hand() {
    // [4 2; 2 5] x = [8; 8] has x = [1.5; 1]. Entries in the same place, from either half, are added.
    let matrix =
        Matrix { rows: 2, places: vec![[0, 0], [1, 0], [1, 1], [0, 1], [1, 1]], values: vec![4.0, 0.5, 2.0, 1.5, 3.0] };
    assert_eq!(solved(&matrix, &[8.0, 8.0]), [1.5, 1.0]);
}

#[test]
fn it_agrees_with_a_dense_solution() {
    for n in [2, 3, 5, 11] {
        let matrix = Matrix::torus(n);
        let right = rough(n * n);
        let expected = matrix.dense().cholesky().unwrap().solve(&DVector::from_column_slice(&right));
        let scale = expected.amax();
        for (found, expected) in solved(&matrix, &right).iter().zip(expected.iter()) {
            assert!((found - expected).abs() < 1e-11 * scale, "{n}: {found} {expected}");
        }
    }
}

#[test]
fn right_sides_do_not_touch_each_other() {
    let matrix = Matrix::torus(9);
    let factor = matrix.factor().unwrap();
    let sides: Vec<[f64; 3]> = rough(81).into_iter().map(|v| [v, 1.0, v * v]).collect();
    let mut together = sides.clone();
    factor.solve(&mut together);
    for k in 0..3 {
        let mut alone: Vec<[f64; 1]> = sides.iter().map(|side| [side[k]]).collect();
        factor.solve(&mut alone);
        assert!(alone.iter().zip(&together).all(|(a, b)| a[0].to_bits() == b[k].to_bits()));
    }
}

#[test]
fn permuting_the_rows_changes_nothing() {
    let matrix = Matrix::torus(12);
    let rename = |row: u32| (row * 35 + 11) % 144;
    let mut renamed = matrix.clone();
    renamed.places.iter_mut().for_each(|place| *place = place.map(rename));
    let right = rough(144);
    let mut moved = right.clone();
    (0..144).for_each(|row| moved[rename(row) as usize] = right[row as usize]);
    let (x, y) = (solved(&matrix, &right), solved(&renamed, &moved));
    assert!((0..144).all(|row| (x[row as usize] - y[rename(row) as usize]).abs() < 1e-9));
}

#[test]
fn indefinite_matrices_are_refused() {
    let two = |values: [f64; 3]| Matrix { rows: 2, places: vec![[0, 0], [1, 0], [1, 1]], values: values.to_vec() };
    for values in [
        [1.0, 1.0, 1.0],
        [1.0, 2.0, 1.0],
        [-1.0, 0.0, 1.0],
        [0.0, 0.0, 1.0],
        [f64::NAN, 0.0, 1.0],
        [1.0, f64::NAN, 1.0],
        [1.0, f64::INFINITY, 1.0],
        [f64::INFINITY, 0.0, 1.0],
    ] {
        let error = two(values).factor().unwrap_err();
        assert!(matches!(error, FactorError::NotPositiveDefinite { row: 0 | 1 }), "{values:?}: {error}");
    }
    assert!(two([1.0, 1.0, 1.0 + 1e-9]).factor().is_ok());
    // A row of a larger matrix without entries, and one with an entry below 0: the error names the row.
    let mut matrix = Matrix::torus(8);
    matrix.rows += 1;
    let error = matrix.factor().unwrap_err();
    assert_eq!(error.to_string(), "the matrix is not positive definite (row 64)");
    let mut matrix = Matrix::torus(8);
    matrix.add(21, 21, -1e3);
    assert!(matrix.factor().is_err());
}

#[test]
fn large_matrices_are_refused_before_any_work() {
    let error = Symbolic::new(1 << 29, &[]).unwrap_err();
    assert_eq!(error.to_string(), "the factor of a matrix of 536870912 rows is too large");
    // A clique fills its triangle.
    let matrix = Matrix::laplacian(20, &clique(0..20).collect::<Vec<_>>(), 1.0);
    let graph = Graph::new(20, &matrix.places).unwrap();
    let within = |most| Elimination::in_order(&graph, (0..20).collect(), most).map(drop);
    assert_eq!((within(210), within(209)), (Ok(()), Err(FactorError::TooLarge { rows: 20 })));
}

#[test]
fn large_fronts_and_long_trees() {
    let pairs = |rows, edges: Vec<(usize, usize, f64)>| Matrix::laplacian(rows, &edges, 0.01);
    // Two cliques connected to a third: they have many columns, with others below them.
    let connected = (0..600).flat_map(|a| (600..650).map(move |b| (a, b, 0.5)));
    let cliques = clique(0..300).chain(clique(300..600)).chain(connected).collect();
    let chain = (1..100_000).map(|at| (at - 1, at, 1.0 + (at % 3) as f64)).collect();
    let star = (1..20_000).map(|at| (0, at, 1.0)).collect();
    // Disconnected components.
    let apart = clique(0..40).chain(clique(40..77)).collect();
    for matrix in [pairs(650, cliques), pairs(100_000, chain), pairs(20_000, star), pairs(90, apart)] {
        let right = rough(matrix.rows);
        let error = matrix.error(&solved(&matrix, &right), &right);
        assert!(error < 1e-13, "{}: {error:e}", matrix.rows);
    }
}

#[test]
fn little_is_filled_in() {
    let matrix = Matrix::torus(48);
    let graph = Graph::new(matrix.rows, &matrix.places).unwrap();
    let natural = Elimination::in_order(&graph, (0..matrix.rows as u32).collect(), u64::MAX).unwrap();
    let natural = Symbolic::of(&graph, natural, &matrix.places).factor_entries();
    let found = matrix.symbolic().factor_entries();
    // In natural order, a band of about two grid rows fills in.
    assert!(natural > 48 * 48 * 80, "{natural}");
    assert!(found < natural / 2 && found < 48 * 48 * 45, "{found} of {natural}");
}

#[test]
fn one_analysis_serves_many_factors() {
    let mut matrix = Matrix::torus(10);
    let symbolic = matrix.symbolic();
    let right = rough(100);
    for scale in [1.0, 7.0] {
        matrix.values.iter_mut().for_each(|value| *value *= scale);
        let mut x: Vec<[f64; 1]> = right.iter().map(|v| [*v]).collect();
        Cholesky::new(&symbolic, &matrix.values, &()).unwrap().solve(&mut x);
        assert!(matrix.error(x.as_flattened(), &right) < 1e-14);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let matrix = Matrix::torus(90);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solved(&matrix, &rough(8100)).into_iter().map(f64::to_bits).collect::<Vec<_>>())
    };
    let alone = on(1);
    assert!([2, 3, 8].iter().all(|threads| on(*threads) == alone));
    // The first of several errors does not depend on threads either.
    let mut bad = matrix;
    (0..8100).step_by(7).for_each(|row| bad.add(row, row, -1e3));
    let first = bad.factor().unwrap_err();
    assert!((0..20).all(|_| bad.factor().unwrap_err() == first), "{first}");
}

#[test]
fn it_can_be_cancelled() {
    let matrix = Matrix::torus(40);
    let symbolic = matrix.symbolic();
    let up_to = |most: usize| {
        let patience = Patience::new(most);
        (Cholesky::new(&symbolic, &matrix.values, &patience).map(drop), patience.steps())
    };
    let (finished, all) = up_to(usize::MAX);
    assert_eq!(finished, Ok(()));
    assert!((3..=4).contains(&all), "{all}");
    for most in 1..=all {
        assert_eq!(up_to(most), (Err(FactorError::Cancelled(Cancelled)), most));
    }
}

/// Number of entries of the factor by its definition: elimination connects all neighbours of a row.
fn fill(graph: &Graph, order: &[u32]) -> Vec<u32> {
    let n = graph.len();
    let mut connected = vec![vec![false; n]; n];
    for (now, row) in order.iter().enumerate() {
        for neighbour in graph.neighbours(*row) {
            connected[now][order.iter().position(|row| row == neighbour).unwrap()] = true;
        }
    }
    for now in 0..n {
        let later: Vec<usize> = (now + 1..n).filter(|at| connected[now][*at]).collect();
        for a in &later {
            later.iter().filter(|b| *b != a).for_each(|b| connected[*a][*b] = true);
        }
    }
    (0..n).map(|now| 1 + connected[now][now + 1..].iter().filter(|connected| **connected).count() as u32).collect()
}

proptest! {
    #[test]
    fn solutions_solve(
        rows in 1usize..120,
        edges in prop::collection::vec((0usize..120, 0usize..120, -3.0f64..3.0), 0..400),
        rest in 1e-3f64..2.0,
    ) {
        // Weights of either sign; diagonally dominant nevertheless.
        let mut matrix = Matrix::empty(rows);
        for (a, b, weight) in edges.into_iter().map(|(a, b, weight)| (a % rows, b % rows, weight)).filter(|(a, b, _)| a != b) {
            matrix.add(a, b, weight);
            matrix.add(a, a, weight.abs());
            matrix.add(b, b, weight.abs());
        }
        (0..rows).for_each(|row| matrix.add(row, row, rest));
        let right = rough(rows);
        let x = solved(&matrix, &right);
        let error = matrix.error(&x, &right);
        prop_assert!(error < 1e-14, "{error:e}");
        // The negative control: the solution of another system fails the check.
        matrix.add(rows / 2, rows / 2, 1e-6);
        let other = solved(&matrix, &right);
        matrix.places.pop();
        matrix.values.pop();
        let size = other.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        if other[rows / 2].abs() > 1e-2 * size {
            prop_assert!(matrix.error(&other, &right) > 1e-12);
        }
    }

    #[test]
    fn the_pattern_is_that_of_elimination(
        rows in 1usize..40,
        places in prop::collection::vec((0u32..40, 0u32..40), 0..120),
        seed in 0u32..1000,
    ) {
        let places: Vec<[u32; 2]> = places.into_iter().map(|(a, b)| [a % rows as u32, b % rows as u32]).collect();
        let graph = Graph::new(rows, &places).unwrap();
        let mut order: Vec<u32> = (0..rows as u32).collect();
        order.sort_by_key(|row| (row * 7919 + seed * 104_729) % 1009);
        for elimination in [Elimination::in_order(&graph, order, u64::MAX), Elimination::new(&graph)] {
            let elimination = elimination.unwrap();
            let mut sorted = elimination.order.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..rows as u32).collect::<Vec<_>>());
            prop_assert_eq!(&elimination.counts, &fill(&graph, &elimination.order));
            let exact: u64 = elimination.counts.iter().map(|count| u64::from(*count)).sum();
            prop_assert!(Symbolic::of(&graph, elimination, &places).factor_entries() >= exact);
        }
    }
}
