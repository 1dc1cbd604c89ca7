//! From views to a factored flat BTF, in passes over the views.

use super::accumulate::{Sums, ViewWords};
use super::assemble;
use super::candidate::VIEWS_AT_ONCE;
use super::choose::Trials;
use super::local::{Texels, solve_texels};
use super::masks::Masks;
use super::measure::errors;
use super::recipe::FactoredRecipe;
use super::report::{FactorError, Factored, FactoredFacts};
use super::rounded::Rounded;
use super::sample::{Sample, choose};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::{FlatHeader, FlatView, VisibilityMask};
use brdfc_source::progress::{Progress, Stage};
use rayon::prelude::*;

/// Texels that candidates are fitted to before one is chosen.
const TRIAL_TEXELS: usize = 1000;
/// Texels that errors are measured at: a square number.
const HELD_OUT: usize = 484;
/// Bytes of views that are in memory at once, as far as one fits in.
const VIEW_BYTES: usize = 256 << 20;

/// Factors a flat BTF. `view` gives one view after the other, in as many passes as there are slabs, and one before.
///
/// With V views, L lights, T² texels, K components, N texels of the fit, n texels of a slab, p threads it takes about, bytes:
///
/// - `12 V L N` values of the fit, at most [`FactoredRecipe::training_bytes`], and `4 V L (N + 484)` words of the first pass;
/// - `4 V L K (K + 1)` products of the basis, two tables of them;
/// - `4 n L (K + 1)` sums of a slab, at most [`FactoredRecipe::slab_bytes`], and `4 T² (K + L)` results;
/// - `4 T² L` for each of the views in memory, 8 or as many as fit into 256 MiB;
/// - `32 L K (K + 1) p` of masks, and the parts themselves.
///
/// The asset is the same on any number of threads.
///
/// # Errors
/// Of `view`; views that do not belong together or to the mask; a target that nothing can meet; when the work is stopped.
pub fn factor<E: Send>(
    recipe: &FactoredRecipe,
    mask: &VisibilityMask,
    view: impl Fn(u32) -> Result<FlatView, E> + Sync,
    progress: &dyn Progress,
) -> Result<Factored, FactorError<E>> {
    let reader = Reader { mask, view };
    let size = mask.size() as usize;
    let first = reader.read(0..1, None)?;
    let directions = first[0].header().clone();
    let (views, lights) = (directions.views.len(), directions.lights.len());
    let most = recipe.training_bytes / (12 * views * lights).max(1);
    let [fitted, held_out] = choose(size * size, recipe.training_texels.min(most).max(1), HELD_OUT);
    let masks = |texels: &[usize]| Masks::new(mask, texels);
    let (mut fitted, mut held_out) =
        (Sample::new(fitted.clone(), masks(&fitted)), Sample::new(held_out.clone(), masks(&held_out)));
    drop(first);
    progress.stage(Stage::Read, views)?;
    for batch in reader.batches(&directions) {
        for view in reader.read(batch, Some(&directions))? {
            fitted.add_view(&view);
            held_out.add_view(&view);
            progress.step()?;
        }
    }
    let count = fitted.texels.len();
    let trial = fitted.values(count.min(TRIAL_TEXELS));
    let trials = Trials { values: &trial, held_out: &held_out, directions: &directions, progress };
    let (mut candidate, tried) = trials.choose(recipe.target)?;
    progress.stage(Stage::Fit, 1)?;
    drop(trial);
    let values = fitted.values(count);
    drop(fitted);
    candidate.refine(&values);
    drop(values);
    progress.step()?;

    let rounded = candidate.rounded(size as u32, &directions)?;
    let texels = reader.solve(recipe, &rounded, &directions, progress)?;
    progress.stage(Stage::Quantise, 1)?;
    let asset = assemble::asset(rounded.map, &texels)?;
    let place = |k: usize| [held_out.texels[k] % size, held_out.texels[k] / size].map(|c| c as u32);
    let errors = errors(&asset, &held_out, held_out.texels.len(), place);
    let asset = asset.with_errors(errors);
    let facts = FactoredFacts {
        components: asset.header().components() as u32,
        shadowed: asset.shadow().is_some(),
        gpu_bytes: asset.gpu_bytes(),
        errors,
        tried,
    };
    Ok(Factored { asset, facts })
}

/// Where views come from.
struct Reader<'a, F> {
    mask: &'a VisibilityMask,
    view: F,
}

impl<E: Send, F: Fn(u32) -> Result<FlatView, E> + Sync> Reader<'_, F> {
    /// The numbers of the views that are in memory together.
    fn batches(&self, directions: &FlatHeader) -> impl Iterator<Item = std::ops::Range<usize>> + use<E, F> {
        let views = directions.views.len();
        let bytes = 4 * (directions.size as usize).pow(2) * directions.lights.len();
        let at_once = (VIEW_BYTES / bytes.max(1)).clamp(1, VIEWS_AT_ONCE);
        (0..views).step_by(at_once).map(move |first| first..views.min(first + at_once))
    }

    /// Some views, checked against the mask and, once they are known, the directions of the first.
    fn read(
        &self,
        views: std::ops::Range<usize>,
        directions: Option<&FlatHeader>,
    ) -> Result<Vec<FlatView>, FactorError<E>> {
        let read: Vec<_> = views.into_par_iter().map(|view| (view, (self.view)(view as u32))).collect();
        let checked = |(number, view): (usize, Result<FlatView, E>)| {
            let view = view.map_err(FactorError::View)?;
            let header = view.header();
            let found = [header.size, header.view, header.views.len() as u32];
            let wanted = [self.mask.size(), number as u32, self.mask.views()];
            if found != wanted {
                let told = |[size, view, views]: [u32; 3]| format!("view {view} of {views}, {size} x {size} texels");
                return Err(
                    FormatError::whole("part flat", told(found), format!("{}, as the mask", told(wanted))).into()
                );
            }
            if directions.is_some_and(|first| (&first.views, &first.lights) != (&header.views, &header.lights)) {
                let field = format!("directions of view {number}");
                return Err(FormatError::whole(field, "other directions", "those of view 0").into());
            }
            Ok(view)
        };
        read.into_iter().map(checked).collect()
    }

    /// Weights and shadows of all texels, slab by slab.
    fn solve(
        &self,
        recipe: &FactoredRecipe,
        rounded: &Rounded,
        directions: &FlatHeader,
        progress: &dyn Progress,
    ) -> Result<Texels, FactorError<E>> {
        let count = (directions.size as usize).pow(2);
        let of_texel = 4 * rounded.basis.lights * (rounded.basis.components + 1);
        let slab = (recipe.slab_bytes / of_texel).clamp(1, count);
        let slabs: Vec<usize> = (0..count).step_by(slab).collect();
        let mut all = Texels { weights: Vec::new(), shadows: Vec::new() };
        progress.stage(Stage::Views, slabs.len() * directions.views.len())?;
        for first in slabs {
            let texels: Vec<usize> = (first..count.min(first + slab)).collect();
            let masks = Masks::new(self.mask, &texels);
            let mut sums = Sums::new(texels.len(), &rounded.basis);
            for batch in self.batches(directions) {
                let views = self.read(batch.clone(), Some(directions))?;
                let words: Vec<ViewWords<'_>> = batch
                    .zip(&views)
                    .map(|(view, pack)| ViewWords { view, words: pack.texels(), first, stride: count })
                    .collect();
                sums.add(&rounded.basis, &masks, &words);
                words.iter().try_for_each(|_| progress.step())?;
            }
            let solved = solve_texels(&sums, &masks, rounded);
            all.weights.extend(solved.weights);
            all.shadows.extend(solved.shadows);
        }
        Ok(all)
    }
}
