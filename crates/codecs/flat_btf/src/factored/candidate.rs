//! Candidate bases: fitted to some texels, tested on others.

use super::accumulate::Sums;
use super::assemble::{self, Shape};
use super::base::{Rays, StoredBase};
use super::local::solve_texels;
use super::measure::errors;
use super::residual::Shares;
use super::rounded::Rounded;
use super::sample::{Sample, Values};
use super::train::Fit;
use super::words::ViewWords;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::{ChromaRange, FactoredErrors, GROUP};

/// Number of views added to sums at once.
pub(super) const VIEWS_AT_ONCE: usize = 8;
/// Rounds of a fit from a first guess, and of one that continues with more texels.
const FIRST_ROUNDS: usize = 3;
const MORE_ROUNDS: usize = 3;
/// Noise variance of a value, as a squared difference in opponent colours: regularises weights.
const NOISE_VARIANCE: f64 = 30.0;

/// A basis with the weights of the texels that it was fitted to.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub(super) shape: Shape,
    pub(super) fit: Fit,
}

impl Candidate {
    /// Fits a candidate to texels with these factors of cube roots, `texels x L`.
    pub(super) fn new(values: &Values, fit_roots: &[f32], shape: Shape) -> Self {
        let mut fit = Fit::guess(values, fit_roots, shape.groups as usize * GROUP);
        (0..FIRST_ROUNDS).for_each(|_| fit.improve(values, fit_roots));
        Self { shape, fit }
    }

    /// Continues the fit with other texels.
    pub(super) fn refine(&mut self, values: &Values, fit_roots: &[f32]) {
        (0..MORE_ROUNDS).for_each(|_| self.fit.improve(values, fit_roots));
    }

    /// Keeps the leading components, which is near-optimal.
    pub(super) fn truncated(&self, groups: u32) -> Self {
        let (all, k) = (self.fit.basis.components, groups as usize * GROUP);
        let weights = self.fit.weights.chunks_exact(all).flat_map(|row| row[..k].iter().copied()).collect();
        Self { shape: Shape { groups, ..self.shape }, fit: Fit { basis: self.fit.basis.truncated(k), weights } }
    }

    /// Quantised basis and products for solving the texels of an asset of a size, with a residual of some cells.
    pub(super) fn rounded(
        &self,
        (size, residual): (u32, u32),
        directions: &FlatHeader,
        base: &StoredBase,
        chroma: ChromaRange,
    ) -> Result<Rounded, FormatError> {
        let header = assemble::header(Shape { residual, ..self.shape }, size, directions, chroma);
        let (map, basis) = assemble::basis(header, &base.table, &self.fit.basis)?;
        let squares = basis.squares();
        Ok(Rounded { map, basis, squares, prior: self.fit.prior(NOISE_VARIANCE) })
    }

    /// Errors at texels outside the fit; `base` is the base of these texels, `shares` are theirs.
    pub(super) fn errors(
        &self,
        held_out: &Sample,
        directions: &FlatHeader,
        (base, shares): (&StoredBase, &Shares),
        chroma: ChromaRange,
    ) -> Result<FactoredErrors, FormatError> {
        let size = held_out.texels.len().isqrt();
        let count = size * size;
        if count == 0 {
            return Ok(FactoredErrors::default());
        }
        // Held-out texels form an arbitrary square, where cells and mipmaps are not used.
        let rounded = self.rounded((size as u32, 0), directions, base, chroma)?;
        let base = base.of(&(0..count).collect::<Vec<_>>());
        let rays = Rays::new(directions);
        let mut sums = Sums::new(count, &rounded.basis);
        let views: Vec<usize> = (0..held_out.views.len()).collect();
        for views in views.chunks(VIEWS_AT_ONCE) {
            let words = |view: &usize| ViewWords {
                view: *view,
                words: &held_out.views[*view],
                first: 0,
                stride: held_out.texels.len(),
            };
            sums.add(
                &rounded.basis,
                (&base, &rays, shares),
                &held_out.masks,
                &views.iter().map(words).collect::<Vec<_>>(),
            );
        }
        let masks = held_out.masks.first(count);
        let weights = solve_texels(&sums, &masks, &shares.fit_roots[..count * rounded.basis.lights], &rounded);
        let asset = assemble::asset(rounded.map, &base, &weights, &vec![1.0; count], None)?;
        Ok(errors(&asset, held_out, count, |k| [(k % size) as u32, (k / size) as u32], shares))
    }
}
