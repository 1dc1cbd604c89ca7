//! Small surfaces for tests.

use super::mesh::{PeriodicMesh, VertexMaterial};
use brdfc_core::progress::{Cancelled, Progress};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A height field of `n` x `n` vertices at `(column / n, row / n)`.
pub(crate) fn height_field(n: usize, height: impl Fn(f64, f64) -> f64) -> PeriodicMesh {
    let at = |i: usize| ((i % n) as f64 / n as f64, (i / n) as f64 / n as f64);
    let points = (0..n * n).map(|i| {
        let (x, y) = at(i);
        [x, y, height(x, y)]
    });
    PeriodicMesh::from_grid(n, n, points.collect(), vec![VertexMaterial::default(); n * n])
}

/// Smooth bumps, `height` from top to bottom.
pub(crate) fn bumps(n: usize, height: f64) -> PeriodicMesh {
    let tau = std::f64::consts::TAU;
    height_field(n, |x, y| 0.25 * height * ((tau * x).sin() + (tau * (y + x)).cos()))
}

/// A sheet with an overhang that hides parts of itself from above.
pub(crate) fn overhang(n: usize) -> PeriodicMesh {
    let tau = std::f64::consts::TAU;
    let points = (0..n * n).map(|i| {
        let (u, v) = ((i % n) as f64 / n as f64, (i / n) as f64 / n as f64);
        [u + 0.22 * (tau * u).sin(), v, 0.12 * (tau * u).cos() + 0.02 * (tau * v).sin()]
    });
    PeriodicMesh::from_grid(n, n, points.collect(), vec![VertexMaterial::default(); n * n])
}

/// Cancels the work at its `most`th step, and counts steps.
pub(crate) struct Patience {
    most: usize,
    steps: AtomicUsize,
}

impl Patience {
    pub(crate) fn new(most: usize) -> Self {
        Self { most, steps: AtomicUsize::new(0) }
    }

    pub(crate) fn steps(&self) -> usize {
        self.steps.load(Ordering::Relaxed)
    }
}

impl Progress for Patience {
    fn step(&self) -> Result<(), Cancelled> {
        if 1 + self.steps.fetch_add(1, Ordering::Relaxed) < self.most { Ok(()) } else { Err(Cancelled) }
    }

    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(())
    }
}
