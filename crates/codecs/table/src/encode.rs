//! The encoder: sequences the stages.

use super::choose::{choose, choose_warps, start};
use super::curve;
use super::fit::fit;
use super::lattice::{Lattice, Taps};
use super::recipe::{Size, TableRecipe};
use super::samples::Samples;
use super::symmetry::Asymmetry;
use super::targets::Targets;
use brdfc_formats::FormatError;
use brdfc_formats::table::shader::TableBrdfParameters;
use brdfc_formats::table::{TableHeader, TablePack, TableSymmetry};
use brdfc_metrics::compare::{Comparison, Reference};
use brdfc_metrics::sampling::PairSet;
use brdfc_source::progress::{Cancelled, Progress, Stage};
use brdfc_source::{Source, TableSource, Tally};

/// Samples that a table is fitted to, per node.
const SAMPLES: u64 = 16;
/// Fewest and most samples.
const FEWEST: u64 = 1 << 16;
const MOST: u64 = 1 << 18;
/// Texels of the largest table that a budget of bytes becomes: beyond, there are not as many samples as nodes.
pub const MOST_TEXELS: u64 = 1 << 18;

/// A pack with what was measured while making it.
#[derive(Debug, Clone)]
pub struct Encoded {
    /// The pack.
    pub pack: TablePack,
    /// The file.
    pub bytes: Vec<u8>,
    /// How far the source is from each symmetry.
    pub asymmetry: Asymmetry,
    /// Error against the source, at pairs and in pictures that depend on no codec.
    pub off_grid: Comparison,
    /// What had to be mended in the samples.
    pub tally: Tally,
}

/// Why there is no pack.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EncodeError {
    /// The byte budget does not hold the smallest table.
    #[error("byte budget: found {allowed} bytes; allowed at least {smallest}, which hold the smallest table")]
    TooFewBytes {
        /// The budget.
        allowed: u64,
        /// The smallest table.
        smallest: u64,
    },
    /// Sizes that no pack has.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The caller asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// Runs all stages.
///
/// # Errors
/// A budget that cannot be met, sizes out of range, cancellation.
pub fn encode(source: &dyn Source, recipe: &TableRecipe, progress: &dyn Progress) -> Result<Encoded, EncodeError> {
    let prepared = Prepared::new(source, recipe, samples_for(recipe.size, source.is_grey()), progress)?;
    let mut pack = prepared.pack(recipe.size, recipe.factored, progress)?;

    progress.stage(Stage::MeasureOffGrid, 1)?;
    let off_grid = match recipe.measure {
        true => Reference::new(source, PairSet::comparison()).compare(&TableSource::new(&pack)),
        false => Comparison::default(),
    };
    measured(&mut pack, &off_grid);

    progress.stage(Stage::Pack, 1)?;
    let bytes = pack.to_bytes(recipe.supercompress);
    Ok(Encoded { pack, bytes, asymmetry: prepared.asymmetry, off_grid, tally: prepared.samples.tally })
}

/// Notes the error of a pack in it.
pub fn measured(pack: &mut TablePack, off_grid: &Comparison) {
    pack.off_grid = off_grid.summary();
    pack.picture = off_grid.picture.summary();
}

/// How many samples a table of this size is fitted to.
pub fn samples_for(size: Size, grey: bool) -> usize {
    let nodes = match size {
        Size::Nodes(axes) => {
            [axes.half, axes.difference, axes.azimuth, axes.layers].into_iter().map(u64::from).product()
        }
        Size::Bytes(bytes) => bytes / texel_bytes(grey),
    };
    (SAMPLES.saturating_mul(nodes)).clamp(FEWEST, MOST) as usize
}

fn texel_bytes(grey: bool) -> u64 {
    if grey { 2 } else { 4 }
}

/// What tables of all sizes are made from: samples, and what they say of the material.
#[derive(Debug, Clone)]
pub struct Prepared {
    /// How far the source is from each symmetry.
    pub asymmetry: Asymmetry,
    /// What tables are fitted to.
    pub samples: Samples,
    symmetry: TableSymmetry,
    targets: Targets,
    isotropic: bool,
    grey: bool,
}

impl Prepared {
    /// Samples a source.
    ///
    /// # Errors
    /// Cancellation.
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
        let samples = Samples::draw(source, samples, recipe.reciprocal);
        let targets = Targets::new(&samples, recipe.bias as f32, grey);
        Ok(Self { asymmetry, samples, symmetry, targets, isotropic, grey })
    }

    /// A pack of a size, its errors not yet measured; `factored` with a curve.
    ///
    /// # Errors
    /// A budget that cannot be met, sizes out of range, cancellation.
    pub fn pack(&self, size: Size, factored: bool, progress: &dyn Progress) -> Result<TablePack, EncodeError> {
        progress.stage(Stage::Choose, 1)?;
        let texels = match size {
            Size::Nodes(axes) => {
                let header = start(&self.targets, self.symmetry, axes);
                header.check()?;
                header.texels()
            }
            Size::Bytes(allowed) => self.texels_within(allowed, factored)?,
        };
        let nodes_of_curve = if factored { curve::nodes_within(texels) } else { 0 };
        let (samples, symmetry) = (&self.samples, self.symmetry);
        let header = match size {
            Size::Nodes(axes) => choose_warps(samples, &self.targets, symmetry, axes),
            Size::Bytes(_) => choose(samples, &self.targets, symmetry, texels - nodes_of_curve, self.isotropic),
        };

        progress.stage(Stage::Fit, 1)?;
        let lattice = Lattice::new(&header);
        let taps: Vec<Taps> = samples.angles.iter().map(|angles| lattice.taps(&header.position_of(*angles))).collect();
        let nodes = fit(lattice, &taps, &self.targets);
        if !factored {
            progress.stage(Stage::Quantise, 1)?;
            return Ok(quantise(header, &nodes, &self.targets)?);
        }

        // The curve has what the table's columns are too coarse for; then the table is fitted to what the curve, as it is
        // stored, leaves. Doing both again changes nothing that can be seen.
        let left = |taps: &Taps, all: &[f32; 3]| {
            let found = lattice.value(taps, &nodes);
            std::array::from_fn(|c| all[c] - found[c])
        };
        let left: Vec<[f32; 3]> =
            taps.iter().zip(&self.targets.logarithms).map(|(taps, all)| left(taps, all)).collect();
        let curve = curve::fit(samples, &self.targets, &left, nodes_of_curve, header.texel_format())?;
        let rest = self.targets.without(curve::along(&curve, samples));
        let nodes = fit(lattice, &taps, &rest);

        progress.stage(Stage::Quantise, 1)?;
        Ok(quantise(header, &nodes, &rest)?.with_curve(curve)?)
    }

    /// Texels that a budget holds.
    fn texels_within(&self, allowed: u64, factored: bool) -> Result<usize, EncodeError> {
        let block = TableBrdfParameters::SIZE as u64;
        let layers = if self.isotropic { 1 } else { 2 };
        let table = 2 * 2 * if self.symmetry.mirror { 2 } else { 3 } * layers;
        let fewest = table + if factored { curve::nodes_within(table as usize) as u64 } else { 0 };
        let most = allowed.saturating_sub(block) / texel_bytes(self.grey);
        if most < fewest {
            return Err(EncodeError::TooFewBytes { allowed, smallest: block + texel_bytes(self.grey) * fewest });
        }
        Ok(most.min(MOST_TEXELS) as usize)
    }
}

/// The pack of fitted logarithms: each channel from its lowest to its highest. Nodes that hardly any sample touches stay in
/// the range of the samples.
fn quantise(mut header: TableHeader, nodes: &[[f32; 3]], targets: &Targets) -> Result<TablePack, FormatError> {
    let mut values = vec![[0.0f32; 3]; nodes.len()];
    for channel in 0..3 {
        let range = |values: &mut dyn Iterator<Item = f32>| {
            values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (least, most) = range(&mut targets.logarithms.iter().map(|v| v[channel]));
        let (low, high) = range(&mut nodes.iter().map(|v| v[channel].clamp(least, most)));
        let span = high - low;
        (header.low[channel], header.span[channel]) = (low, span);
        for (value, node) in values.iter_mut().zip(nodes) {
            let above = node[channel].clamp(least, most) - low;
            value[channel] = if span > 0.0 { above / span } else { 0.0 };
        }
    }
    TablePack::new(header, &values)
}
