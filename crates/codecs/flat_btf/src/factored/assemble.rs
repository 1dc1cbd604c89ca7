//! Assembles parts from the solution.

use super::base::StoredBase;
use super::basis::Basis;
use super::mipmaps::with_mipmaps;
use super::quantise::{integer, rounded, steps, weight_byte, weight_ranges, wide_groups};
use brdfc_formats::FormatError;
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::factored::{
    BaseTable, BasisMap, ChromaRange, FactoredErrors, FactoredFlatBtf, FactoredHeader, GROUP, MAX_MATERIALS,
    ResidualMap, WeightMap,
};
use brdfc_formats::flat_btf::{FlatHeader, VisibilityMask};

/// Parameters of an asset that determine its bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shape {
    /// Groups of four components.
    pub(super) groups: u32,
    /// Cells per side of the residual of shadows, 0 without one.
    pub(super) residual: u32,
}

/// Header of an asset of `size` texels per side, with all mipmap levels.
pub(super) fn header(shape: Shape, size: u32, directions: &FlatHeader, chroma: ChromaRange) -> FactoredHeader {
    FactoredHeader {
        size,
        levels: Extent::D2([size; 2]).most_levels(),
        groups: shape.groups,
        wide_groups: wide_groups(shape.groups),
        residual: shape.residual,
        views: directions.views.clone(),
        lights: directions.lights.clone(),
        chroma,
        materials: 0,
        axes: 0,
        table_levels: 1,
        albedos: [[0.0; 3]; MAX_MATERIALS as usize],
        steps: [(); 3].map(|()| vec![0.0; shape.groups as usize * GROUP]),
        errors: FactoredErrors::default(),
    }
}

/// The part `basis`, and the basis as a decoder reconstructs it.
pub(super) fn basis(header: FactoredHeader, base: &BaseTable, basis: &Basis) -> Result<(BasisMap, Basis), FormatError> {
    let header = FactoredHeader { steps: steps(basis, header.wide_groups), ..header };
    let all = header.steps.clone();
    let step = |view: usize, light: usize, colour: usize, component: usize| {
        integer(basis.pair(view, light)[colour * basis.components + component], all[colour][component])
    };
    Ok((BasisMap::from_steps(header, base, step)?, rounded(basis, &all)))
}

/// Mipmap weight of a texel that no view sees, relative to one that all views see: such texels only matter where there
/// are no others.
pub(super) const MIN_COUNT: f32 = 1e-3;

/// Mipmap weight of each texel: the share of views that see it.
pub(super) fn counts(mask: &VisibilityMask) -> Vec<f32> {
    let (size, views) = (mask.size(), mask.views());
    let seen = |at: u32| (0..views).filter(|view| mask.is_seen(*view, [at % size, at / size])).count();
    (0..size * size).map(|at| MIN_COUNT.max(seen(at) as f32 / views as f32)).collect()
}

/// Assembles an asset from the weights of texels, `texels x K`, and their bases, row by row; mipmaps weight texels by
/// [`counts`].
pub(super) fn asset(
    basis: BasisMap,
    base: &StoredBase,
    weights: &[f32],
    counts: &[f32],
    residual: Option<ResidualMap>,
) -> Result<FactoredFlatBtf, FormatError> {
    let header = basis.header();
    let (size, levels, k) = (header.size as usize, header.levels, header.components());
    let count = size * size;
    let ranges = if k == 0 { Vec::new() } else { weight_ranges(weights, k) };
    let mut bytes = vec![0; count * k];
    for (texel, weights) in weights.chunks_exact(k.max(1)).enumerate() {
        for (component, weight) in weights.iter().enumerate() {
            let at = (component / GROUP * count + texel) * GROUP + component % GROUP;
            bytes[at] = weight_byte(*weight, ranges[component]);
        }
    }
    let albedos = with_mipmaps(base.albedos().as_flattened(), counts, GROUP, levels);
    let slopes = with_mipmaps(base.slopes().as_flattened(), counts, 2, levels);
    let slopes: Vec<u8> = slopes.into_iter().flat_map(u16::to_be_bytes).collect();
    let components = with_mipmaps(&bytes, counts, GROUP, levels);
    // Level by level, in each the layers of the base first.
    let mut all = Vec::with_capacity(albedos.len() + slopes.len() + components.len());
    let (mut of_base, mut of_components) = (0, 0);
    for level in 0..levels {
        let length = GROUP * (size >> level).max(1).pow(2);
        all.extend_from_slice(&albedos[of_base..][..length]);
        all.extend_from_slice(&slopes[of_base..][..length]);
        all.extend_from_slice(&components[of_components..][..length * k / GROUP]);
        (of_base, of_components) = (of_base + length, of_components + length * k / GROUP);
    }
    let weights = WeightMap::new(header.size, levels, [base.ranges(), ranges].concat(), all)?;
    FactoredFlatBtf::new(basis, weights, residual)
}
