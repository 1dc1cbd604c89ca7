//! The encoder of tables, as a sequence of stages.

use super::choose::{Trial, choose, choose_warps, scaled, start};
use super::crop::{self, window};
use super::fit::{Solution, fit};
use super::lattice::{Lattice, Taps};
use super::quantise::quantise;
use super::recipe::{Size, TableRecipe};
use super::samples::{MIN_SAMPLES, Samples};
use super::symmetry::Asymmetry;
use super::targets::Targets;
use super::{curve, levels};
use brdfc_codec::EncodeError;
use brdfc_core::progress::{Cancelled, Progress, Stage};
use brdfc_core::{PackSource, Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::crop::{Crop, DirectionRange};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::table::shader::TableBrdfParameters;
use brdfc_formats::table::{Angles, Folded, TableHeader, TablePack, TableSymmetry};
use brdfc_metrics::compare::{Comparison, Reference};
use brdfc_metrics::sampling::PairSet;

/// Number of samples per node.
const SAMPLES: u64 = 16;
/// Maximum number of samples.
const MAX_SAMPLES: u64 = 1 << 18;
/// Texels of the largest table for a limit of bytes: larger tables would have fewer than two samples per node.
pub const MAX_TEXELS: u64 = 1 << 17;
/// Maximum logarithm of a material; larger values are overshoots of a fit next to a spike.
const MAX_LOGARITHM: f64 = 80.0;

/// A pack with the measurements of its encoding.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// The pack in memory.
    pub pack: TablePack,
    /// Contents of the pack's KTX2 file.
    pub bytes: Vec<u8>,
    /// Deviation of the source from each symmetry.
    pub asymmetry: Asymmetry,
    /// Error against the source, at pairs and in renderings that depend on no codec.
    pub off_grid: Comparison,
    /// Repairs in the samples.
    pub tally: Tally,
}

/// Runs all stages.
///
/// # Errors
/// Returns an error if the budget cannot be met, if a size is out of range, or if the work is cancelled.
pub fn encode(source: &dyn Source, recipe: &TableRecipe, progress: &dyn Progress) -> Result<Encoded, EncodeError> {
    let prepared = Prepared::new(source, recipe, samples_for(recipe.size, source.is_grey()), progress)?;
    let mut pack = prepared.pack(recipe, progress)?;

    progress.stage(Stage::MeasureOffGrid, 1)?;
    let off_grid = match recipe.measure {
        true => Reference::new(source, PairSet::within(recipe.directions)).compare(&PackSource::new(&pack, None)),
        false => Comparison::default(),
    };
    measured(&mut pack, &off_grid);

    progress.stage(Stage::Pack, 1)?;
    let bytes = pack.to_bytes(recipe.supercompress);
    Ok(Encoded { pack, bytes, asymmetry: prepared.asymmetry, off_grid, tally: prepared.samples.tally })
}

/// Stores the error of a pack in it.
pub fn measured(pack: &mut TablePack, off_grid: &Comparison) {
    pack.off_grid = off_grid.summary();
    pack.rendering = off_grid.rendering.summary();
}

/// Number of samples for a table of this size.
pub fn samples_for(size: Size, grey: bool) -> usize {
    let nodes = match size {
        Size::Nodes(axes) => {
            [axes.half, axes.difference, axes.azimuth, axes.layers].into_iter().map(u64::from).product()
        }
        Size::Bytes(bytes) => bytes / texel_bytes(grey),
    };
    (SAMPLES.saturating_mul(nodes)).clamp(MIN_SAMPLES as u64, MAX_SAMPLES) as usize
}

fn texel_bytes(grey: bool) -> u64 {
    if grey { 2 } else { 4 }
}

/// A table before rounding.
struct Fitted {
    header: TableHeader,
    lattice: Lattice,
    taps: Vec<Taps>,
    solution: Solution,
}

/// Common input of tables of all sizes: samples and their symmetries.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// Deviation of the source from each symmetry.
    pub asymmetry: Asymmetry,
    /// Samples to fit.
    pub samples: Samples,
    symmetry: TableSymmetry,
    /// Angles of the samples, folded by the symmetry.
    folded: Vec<Folded>,
    targets: Targets,
    isotropic: bool,
    grey: bool,
}

impl Prepared {
    /// Samples a source.
    ///
    /// # Errors
    /// Returns an error if the work is cancelled.
    pub fn new(
        source: &dyn Source,
        recipe: &TableRecipe,
        samples: usize,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        progress.stage(Stage::Symmetry, 1)?;
        let (grey, isotropic) = (source.is_grey(), source.symmetry().isotropic);
        let asymmetry = Asymmetry::of(source);
        let mut symmetry = asymmetry.folds(isotropic);
        symmetry.reciprocal |= recipe.reciprocal;
        progress.stage(Stage::Resample, 1)?;
        // Coarser levels of detail average over all directions.
        let directions = if recipe.levels == 0 { recipe.directions } else { DirectionRange::ALL };
        let samples = Samples::within(source, samples, recipe.reciprocal, directions);
        let targets = Targets::with_aim(&samples, recipe.bias as f32, grey, recipe.aim);
        let folded = samples.angles.iter().map(|angles| Folded::new(*angles, symmetry)).collect();
        Ok(Self { asymmetry, samples, symmetry, folded, targets, isotropic, grey })
    }

    /// Encodes the pack of a recipe, without measuring its errors.
    ///
    /// # Errors
    /// Returns an error if the budget cannot be met, if a size is out of range, or if the work is cancelled.
    pub fn pack(&self, recipe: &TableRecipe, progress: &dyn Progress) -> Result<TablePack, EncodeError> {
        if recipe.levels > levels::MAX_LEVELS {
            let allowed = format!("0 to {}", levels::MAX_LEVELS);
            return Err(FormatError::whole("levels", recipe.levels.to_string(), allowed).into());
        }
        let texels = self.texels(recipe)?;
        let nodes_of_curve = curve::nodes_within(texels);
        let of_curve = if recipe.has_curve() { self.texels_of_curve(nodes_of_curve, recipe) } else { 0 };
        let Fitted { header, lattice, taps, solution } =
            self.fit(recipe.size, recipe.directions, texels.saturating_sub(of_curve), progress)?;
        if !recipe.has_curve() {
            progress.stage(Stage::Quantise, 1)?;
            return Ok(cropped(quantise(header, &solution, &self.targets)?, recipe.directions)?);
        }

        // The curve takes the common part of the columns, so that the table's steps become finer, and details that are
        // too narrow for the columns. Then the table is fitted to the remainder of the stored curve.
        let nodes = without_column_means(solution.nodes, header.axes.half as usize);
        let left = |taps: &Taps, all: &[f32; 3]| {
            let found = lattice.value(taps, &nodes);
            std::array::from_fn(|c| all[c] - found[c])
        };
        let left: Vec<[f32; 3]> =
            taps.iter().zip(&self.targets.logarithms).map(|(taps, all)| left(taps, all)).collect();
        let finest = curve::fit(&self.samples, &self.targets, &left, nodes_of_curve);
        let value = |pair: DirectionPair| {
            let angles = Angles::of(pair);
            let table = lattice.value(&lattice.taps(&header.position_of(angles)), &nodes);
            let curve = curve::at(&finest, angles.theta_half);
            let logarithm = |c: usize| (f64::from(table[c]) + curve[c]).min(MAX_LOGARITHM);
            std::array::from_fn(|c| f64::from(header.mean) * logarithm(c).exp())
        };
        let mut rows = levels::rows(value, recipe.levels, nodes_of_curve);
        let add = |sum: &mut [f64; 3], more: &[f64; 3]| (0..3).for_each(|c| sum[c] += more[c]);
        rows.iter_mut().for_each(|row| row.iter_mut().zip(&finest).for_each(|(sum, finest)| add(sum, finest)));
        let curve = curve::stored(&rows, header.channels)?;
        let rest = self.targets.without(curve::along(&curve, &self.samples));
        let solution = fit(lattice, &taps, &rest);

        progress.stage(Stage::Quantise, 1)?;
        Ok(cropped(quantise(header, &solution, &rest)?.with_curve(curve)?, recipe.directions)?)
    }

    /// Nodes of a table before rounding: their header, whose `low` and `span` are 0, and their logarithms,
    /// `[layer][slice][row][column]` without the repeated slice.
    ///
    /// # Errors
    /// Returns an error if the budget cannot be met, if the size is out of range, or if the work is cancelled.
    pub fn nodes(&self, size: Size, progress: &dyn Progress) -> Result<(TableHeader, Vec<[f32; 3]>), EncodeError> {
        let recipe = TableRecipe { size, ..TableRecipe::default() };
        let fitted = self.fit(size, DirectionRange::ALL, self.texels(&recipe)?, progress)?;
        Ok((fitted.header, fitted.solution.nodes))
    }

    fn fit(
        &self,
        size: Size,
        directions: DirectionRange,
        texels: usize,
        progress: &dyn Progress,
    ) -> Result<Fitted, EncodeError> {
        progress.stage(Stage::Choose, 1)?;
        let trial = Trial { samples: &self.samples, folded: &self.folded, targets: &self.targets };
        let header = match size {
            Size::Nodes(axes) => choose_warps(&trial, self.symmetry, axes),
            Size::Bytes(_) => filling(choose(&trial, self.symmetry, texels, self.isotropic), directions, texels),
        };
        progress.stage(Stage::Fit, 1)?;
        let lattice = Lattice::new(&header);
        let taps: Vec<Taps> = self.folded.iter().map(|folded| lattice.taps(&header.place(*folded))).collect();
        let solution = fit(lattice, &taps, &self.targets);
        Ok(Fitted { header, lattice, taps, solution })
    }

    /// Number of texels of a pack of this size, including a curve.
    fn texels(&self, recipe: &TableRecipe) -> Result<usize, EncodeError> {
        match recipe.size {
            Size::Nodes(axes) => {
                let header = start(&self.targets, self.symmetry, axes);
                header.check()?;
                Ok(header.texels())
            }
            Size::Bytes(allowed) => self.texels_within(allowed, recipe),
        }
    }

    /// Number of texels of a table with as many bytes as a curve.
    fn texels_of_curve(&self, nodes: usize, recipe: &TableRecipe) -> usize {
        // Coloured curves have 8 bytes per node, coloured tables 4 bytes per texel.
        nodes * (recipe.levels as usize + 1) * if self.grey { 1 } else { 2 }
    }

    /// Number of texels within a budget.
    fn texels_within(&self, allowed: u64, recipe: &TableRecipe) -> Result<usize, EncodeError> {
        let block = TableBrdfParameters::SIZE as u64;
        let layers = if self.isotropic { 1 } else { 2 };
        let table = 2 * 2 * if self.symmetry.mirror { 2 } else { 3 } * layers;
        let curve = if recipe.has_curve() { self.texels_of_curve(curve::MIN_NODES, recipe) } else { 0 };
        let fewest = table + curve as u64;
        let most = allowed.saturating_sub(block) / texel_bytes(self.grey);
        if most < fewest {
            return Err(EncodeError::TooFewBytes { allowed, smallest: block + texel_bytes(self.grey) * fewest });
        }
        Ok(most.min(MAX_TEXELS) as usize)
    }
}

/// Grows a table to fill a budget. The budget counts written bytes: cropped directions leave room for more nodes.
fn filling(header: TableHeader, directions: DirectionRange, texels: usize) -> TableHeader {
    if directions.is_all() {
        return header;
    }
    let share = |header: &TableHeader| crop::texels(header, directions) as f64 / header.texels() as f64;
    let mut whole = (texels as f64 / share(&header)).min(MAX_TEXELS as f64);
    while whole > texels as f64 {
        let larger = scaled(header, whole as usize);
        if crop::texels(&larger, directions) <= texels {
            return larger;
        }
        whole *= 0.95;
    }
    header
}

/// Crops the pack to the texels that look-ups within a range of directions read.
fn cropped(pack: TablePack, directions: DirectionRange) -> Result<TablePack, FormatError> {
    let window = window(pack.header(), directions);
    if directions.is_all() { Ok(pack) } else { pack.cropped(Crop { directions, window }) }
}

/// Subtracts the mean of each column from its nodes.
fn without_column_means(mut nodes: Vec<[f32; 3]>, columns: usize) -> Vec<[f32; 3]> {
    let rows = (nodes.len() / columns) as f32;
    for column in 0..columns {
        let mut sum = [0.0; 3];
        nodes.iter().skip(column).step_by(columns).for_each(|node| (0..3).for_each(|c| sum[c] += node[c]));
        let subtract = |node: &mut [f32; 3]| (0..3).for_each(|c| node[c] -= sum[c] / rows);
        nodes.iter_mut().skip(column).step_by(columns).for_each(subtract);
    }
    nodes
}
