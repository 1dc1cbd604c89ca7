//! Factors views, in passes over them.

use super::accumulate::Sums;
use super::assemble;
use super::base::{AlbedoSums, Rays, StoredBase, stored_normals};
use super::candidate::VIEWS_AT_ONCE;
use super::choose::Trials;
use super::chroma::Chroma;
use super::gloss::fit_table;
use super::local::solve_texels;
use super::masks::Masks;
use super::measure::errors;
use super::recipe::FactoredRecipe;
use super::report::{FactorError, Factored, FactoredFacts};
use super::residual::{Arrival, Shares};
use super::rounded::Rounded;
use super::sample::{Sample, choose};
use super::words::ViewWords;
use brdfc_core::progress::{Progress, Stage};
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::Axis;
use brdfc_formats::flat_btf::{FlatHeader, FlatView, VisibilityMask};
use rayon::prelude::*;

/// Number of texels that candidates are fitted to before one is chosen.
const TRIAL_TEXELS: usize = 1000;
/// Number of texels that errors are measured at: a square number.
const HELD_OUT: usize = 484;
/// Maximum bytes of views in memory at once, but at least one view.
const VIEW_BYTES: usize = 256 << 20;

/// Factors a flat BTF. `lit` are the texels that each light reaches, if values depend on it; `view` returns views in order,
/// in an initial pass, one per slab, and a last one.
///
/// With V views, L lights, T² texels, K components, N texels of the fit, n texels of a slab, p threads it takes about
/// these bytes:
///
/// - `24 V L N` values of the fit, at most [`FactoredRecipe::training_bytes`], and `4 V L (N + 484)` words of the first pass;
/// - `4 V L K (K + 1)` products of the basis, two tables of them;
/// - `60 n L` sums of albedos of a slab, at most [`FactoredRecipe::slab_bytes`], then `4 T² (3 K + 5 L)` sums, shares and
///   results, and `80 L R²` of the largest residual;
/// - `4 T² L` for each of the views in memory, 8 or as many as fit into 256 MiB;
/// - `32 L K (K + 1) p` of masks, and the parts themselves.
///
/// The asset is the same on any number of threads.
///
/// # Errors
/// Returns errors of `view`, and an error if views do not match each other or the masks, if the target cannot be met, or
/// if the work is cancelled.
pub fn factor<E: Send>(
    recipe: &FactoredRecipe,
    normals: &[[f32; 3]],
    mask: &VisibilityMask,
    lit: Option<&VisibilityMask>,
    view: impl Fn(u32) -> Result<FlatView, E> + Sync,
    progress: &dyn Progress,
) -> Result<Factored, FactorError<E>> {
    let texels = (mask.size() as usize).pow(2);
    if normals.len() != texels {
        let allowed = format!("{texels}, the texels of the mask");
        return Err(FormatError::whole("normals", normals.len().to_string(), allowed).into());
    }
    let reader = Reader { mask, view };
    let size = mask.size() as usize;
    let first = reader.read(0..1, None)?;
    let directions = first[0].header().clone();
    let (views, lights) = (directions.views.len(), directions.lights.len());
    if let Some(lit) = lit.filter(|lit| (lit.size(), lit.views()) != (mask.size(), lights as u32)) {
        let text = |size: u32, lights: u32| format!("{lights} lights, {size} x {size} texels");
        let (found, expected) = (text(lit.size(), lit.views()), text(mask.size(), lights as u32));
        return Err(FormatError::whole("mask of lights", found, format!("{expected}, as the views have")).into());
    }
    let most = recipe.training_bytes / (24 * views * lights).max(1);
    let [fitted, held_out] = choose(size * size, recipe.training_texels.min(most).max(1), HELD_OUT);
    let masks = |texels: &[usize]| Masks::new(mask, texels);
    let (mut fitted, mut held_out) =
        (Sample::new(fitted.clone(), masks(&fitted)), Sample::new(held_out.clone(), masks(&held_out)));
    drop(first);
    recipe.target.check(&directions)?;
    let mut chroma = Chroma::none();
    progress.stage(Stage::Read, views)?;
    for batch in reader.batches(&directions) {
        for view in reader.read(batch, Some(&directions))? {
            fitted.add_view(&view);
            held_out.add_view(&view);
            chroma.add_view(&view, mask);
            progress.step()?;
        }
    }
    let rays = Rays::new(&directions);
    let mut arrival = Arrival::new(directions.size, lights, lit, recipe.blur);
    let base = reader.base(recipe, &fitted, normals, &mut arrival, &directions, progress)?;
    let (count, of_fitted, of_held_out) = (fitted.texels.len(), base.of(&fitted.texels), base.of(&held_out.texels));
    let chroma = chroma.range();
    let trials = Trials {
        fitted: &fitted,
        texels: count.min(TRIAL_TEXELS),
        held_out: &held_out,
        bases: [&of_fitted, &of_held_out],
        directions: &directions,
        chroma,
        arrival: &arrival,
        progress,
    };
    let (mut candidate, tried) = trials.choose(recipe.target)?;
    progress.stage(Stage::Fit, 1)?;
    let residual = arrival.residual(candidate.shape.residual)?;
    let Shares { fit_roots, shaded, .. } = arrival.shares(residual.as_ref(), &fitted.texels);
    let values = fitted.values(count, &of_fitted, &shaded, &rays);
    candidate.refine(&values, &fit_roots);
    drop((values, fitted));
    progress.step()?;

    let rounded = candidate.rounded((size as u32, candidate.shape.residual), &directions, &base, chroma)?;
    let shares = arrival.shares(residual.as_ref(), &(0..texels).collect::<Vec<_>>());
    let weights = reader.solve(&rounded, &base, &shares, &directions, progress)?;
    progress.stage(Stage::Quantise, 1)?;
    let shares = arrival.shares(residual.as_ref(), &held_out.texels);
    let asset = assemble::asset(rounded.map, &base, &weights, &assemble::counts(mask), residual)?;
    let place = |k: usize| [held_out.texels[k] % size, held_out.texels[k] / size].map(|c| c as u32);
    let errors = errors(&asset, &held_out, held_out.texels.len(), place, &shares);
    let asset = asset.with_errors(errors);
    let facts = FactoredFacts {
        components: asset.header().components() as u32,
        residual: asset.header().residual,
        gpu_bytes: asset.gpu_bytes(),
        errors,
        tried,
    };
    Ok(Factored { asset, facts })
}

/// Texels whose sums are in memory together.
struct Slabs {
    firsts: Vec<usize>,
    length: usize,
    /// Texels of the surface.
    texels: usize,
}

impl Slabs {
    fn new(recipe: &FactoredRecipe, directions: &FlatHeader, bytes_of_texel: usize) -> Self {
        let texels = (directions.size as usize).pow(2);
        let length = (recipe.slab_bytes / bytes_of_texel).clamp(1, texels);
        Self { firsts: (0..texels).step_by(length).collect(), length, texels }
    }

    /// Iterates over the slabs.
    fn each(&self) -> impl Iterator<Item = Vec<usize>> + use<'_> {
        self.firsts.iter().map(|first| (*first..self.texels.min(first + self.length)).collect())
    }
}

/// Reads views through a callback.
struct Reader<'a, F> {
    mask: &'a VisibilityMask,
    view: F,
}

impl<E: Send, F: Fn(u32) -> Result<FlatView, E> + Sync> Reader<'_, F> {
    /// Numbers of the views that are in memory together.
    fn batches(&self, directions: &FlatHeader) -> impl Iterator<Item = std::ops::Range<usize>> + use<E, F> {
        let views = directions.views.len();
        let bytes = 4 * (directions.size as usize).pow(2) * directions.lights.len();
        let at_once = (VIEW_BYTES / bytes.max(1)).clamp(1, VIEWS_AT_ONCE);
        (0..views).step_by(at_once).map(move |first| first..views.min(first + at_once))
    }

    /// Reads some views and checks them against the mask and, once known, the directions of the first view.
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
            let expected = [self.mask.size(), number as u32, self.mask.views()];
            if found != expected {
                let label = |[size, view, views]: [u32; 3]| format!("view {view} of {views}, {size} x {size} texels");
                return Err(FormatError::whole(
                    "part flat",
                    label(found),
                    format!("{}, as the mask has", label(expected)),
                )
                .into());
            }
            if directions.is_some_and(|first| (&first.views, &first.lights) != (&header.views, &header.lights)) {
                let field = format!("directions of view {number}");
                let error = FormatError::whole(field, "differ from view 0", "equal directions in all views");
                return Err(error.problem().into());
            }
            Ok(view)
        };
        read.into_iter().map(checked).collect()
    }

    /// Fits the base of all texels: its table to some, albedos slab by slab. Adds them to the sums of the residual.
    fn base(
        &self,
        recipe: &FactoredRecipe,
        fitted: &Sample,
        normals: &[[f32; 3]],
        arrival: &mut Arrival,
        directions: &FlatHeader,
        progress: &dyn Progress,
    ) -> Result<StoredBase, FactorError<E>> {
        let (rays, stored) = (Rays::new(directions), stored_normals(normals));
        let of_fitted: Vec<[f32; 3]> = fitted.texels.iter().map(|at| stored[*at]).collect();
        progress.stage(Stage::Fit, 1)?;
        let reaches = |texel: usize, light: usize| arrival.reaches(fitted.texels[texel], light);
        let (table, _) = fit_table(Axis::Half, fitted, &of_fitted, &rays, &reaches)?;
        progress.step()?;
        let mut albedos = Vec::new();
        let slabs = Slabs::new(recipe, directions, AlbedoSums::BYTES * rays.lights.len());
        progress.stage(Stage::Views, slabs.firsts.len() * directions.views.len())?;
        for texels in slabs.each() {
            let masks = Masks::new(self.mask, &texels);
            let mut sums = AlbedoSums::new(texels.len(), rays.lights.len());
            for batch in self.batches(directions) {
                let views = self.read(batch.clone(), Some(directions))?;
                let words = words(batch, &views, texels[0], slabs.texels);
                sums.add(&table, &rays, &stored[texels[0]..][..texels.len()], &masks, &words);
                words.iter().try_for_each(|_| progress.step())?;
            }
            let solved = sums.solve(&|texel, light| arrival.reaches(texels[texel], light));
            if arrival.is_known() {
                arrival.add(texels[0], &sums.products(&solved));
            }
            albedos.extend(solved);
        }
        Ok(StoredBase::new(table, &albedos, normals))
    }

    /// Solves the weights of all texels, `texels x K`, with their shares under each light.
    fn solve(
        &self,
        rounded: &Rounded,
        base: &StoredBase,
        shares: &Shares,
        directions: &FlatHeader,
        progress: &dyn Progress,
    ) -> Result<Vec<f32>, FactorError<E>> {
        let rays = Rays::new(directions);
        let texels: Vec<usize> = (0..(directions.size as usize).pow(2)).collect();
        let masks = Masks::new(self.mask, &texels);
        let mut sums = Sums::new(texels.len(), &rounded.basis);
        progress.stage(Stage::Views, directions.views.len())?;
        for batch in self.batches(directions) {
            let views = self.read(batch.clone(), Some(directions))?;
            let words = words(batch, &views, 0, texels.len());
            sums.add(&rounded.basis, (base, &rays, shares), &masks, &words);
            words.iter().try_for_each(|_| progress.step())?;
        }
        Ok(solve_texels(&sums, &masks, &shares.fit_roots, rounded))
    }
}

/// Words of some views for the texels from `first` on, of `texels` in all.
fn words(batch: std::ops::Range<usize>, views: &[FlatView], first: usize, texels: usize) -> Vec<ViewWords<'_>> {
    let words = |(view, pack)| ViewWords { view, words: FlatView::texels(pack), first, stride: texels };
    batch.zip(views).map(words).collect()
}
