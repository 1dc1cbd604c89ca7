//! Targets of factored flat BTFs, their validation, and memory estimates.

use super::assemble::{Shape, header};
use super::base::AlbedoSums;
use super::residual::max_cells;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::{ChromaRange, GROUP, MAX_GROUPS};

/// Numbers of component groups to try: 4, 8, 12, 20, 28, 44, 60 components.
const GROUPS: [u32; 7] = [1, 2, 3, 5, 7, 11, 15];

/// Target of a factored flat BTF.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FactoredTarget {
    /// Fewest bytes with a mean error, ΔE where texels are seen, of at most this.
    Error(f64),
    /// Least error with at most this many bytes on a GPU.
    Bytes(u64),
    /// Fixed number of components, rounded up to a multiple of four.
    Components {
        /// Number of components, 1 to 64.
        components: u32,
        /// Cells per side of the residual of shadows: 0, which is none, or a power of two up to [`super::max_cells`].
        residual: u32,
    },
}

impl FactoredTarget {
    /// Checks that an asset with these directions can meet the target, as far as that is known without the values: with a
    /// residual of one cell, which values before shadows do not have.
    ///
    /// # Errors
    /// Returns an error for numbers out of range, for fewer bytes than the smallest asset takes, and for more lights
    /// than its parts can hold.
    pub fn check(&self, directions: &FlatHeader) -> Result<(), FormatError> {
        match self {
            Self::Error(most) if !(*most >= 0.0 && most.is_finite()) => {
                Err(FormatError::whole("error of factors", most.to_string(), "0 or more"))
            }
            Self::Error(_) => shapes(directions, &[1]).map(drop),
            Self::Bytes(most) => {
                let least = shapes(directions, &[1])?.iter().map(|shape| gpu_bytes(*shape, directions)).min();
                match least {
                    Some(least) if *most < least => {
                        let allowed = format!("{least} or more, the bytes of the smallest asset");
                        Err(FormatError::whole("bytes of factors", most.to_string(), allowed))
                    }
                    _ => Ok(()),
                }
            }
            Self::Components { components, residual } => {
                let groups = components.div_ceil(GROUP as u32);
                if !(1..=MAX_GROUPS).contains(&groups) {
                    let allowed = format!("1 to {}", MAX_GROUPS * GROUP as u32);
                    return Err(FormatError::whole("components", components.to_string(), allowed));
                }
                let most = max_cells(directions.size);
                if *residual != 0 && !(residual.is_power_of_two() && *residual <= most) {
                    let allowed = format!("0 or a power of two up to {most}");
                    return Err(FormatError::whole("cells of the residual", residual.to_string(), allowed));
                }
                header(Shape { groups, residual: *residual }, directions.size, directions, ChromaRange::ALL).check()
            }
        }
    }
}

/// Shapes with residuals of these cells to try, the smallest first; at least one.
pub(super) fn shapes(directions: &FlatHeader, residuals: &[u32]) -> Result<Vec<Shape>, FormatError> {
    let with = |groups: u32| residuals.iter().map(move |residual| Shape { groups, residual: *residual });
    let mut shapes: Vec<Shape> = GROUPS.into_iter().flat_map(with).collect();
    header(shapes[0], directions.size, directions, ChromaRange::ALL).check()?;
    shapes.retain(|shape| header(*shape, directions.size, directions, ChromaRange::ALL).check().is_ok());
    shapes.sort_by_key(|shape| gpu_bytes(*shape, directions));
    Ok(shapes)
}

/// Bytes of a shape on a GPU.
pub(super) fn gpu_bytes(shape: Shape, directions: &FlatHeader) -> u64 {
    header(shape, directions.size, directions, ChromaRange::ALL).gpu_bytes()
}

/// Settings that determine the asset, in addition to the views.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FactoredRecipe {
    /// Target that decides the number of components.
    pub target: FactoredTarget,
    /// Number of texels that the basis is fitted to, as far as `training_bytes` allows.
    pub training_texels: usize,
    /// Maximum bytes of the values of the fit.
    pub training_bytes: usize,
    /// Weight of each of two neighbours, in both directions, by which values are blurred: 0.1 for texels that are looked up
    /// in images of about as many pixels.
    pub blur: f32,
    /// Maximum bytes of sums of albedos in memory; if all texels exceed it, the encoder makes several passes over the views.
    pub slab_bytes: usize,
}

impl FactoredRecipe {
    /// Default settings: 2500 texels, 384 MiB, 768 MiB.
    pub fn new(target: FactoredTarget) -> Self {
        Self { target, blur: 0.0, training_texels: 2500, training_bytes: 384 << 20, slab_bytes: 768 << 20 }
    }

    /// Estimated peak memory in bytes, on one thread: see [`super::factor`].
    pub fn memory(&self, directions: &FlatHeader) -> u64 {
        let [views, lights] = [&directions.views, &directions.lights].map(|angles| angles.len() as u64);
        let texels = u64::from(directions.size).pow(2);
        let most = u64::from(GROUPS[GROUPS.len() - 1]) * GROUP as u64;
        let training = (24 * views * lights * self.training_texels as u64).min(self.training_bytes as u64);
        let sums = (AlbedoSums::BYTES as u64 * texels * lights).min(self.slab_bytes as u64);
        let (products, masks) = (8 * views * lights * most * (most + 1), 32 * lights * most * (most + 1));
        let cells = 80 * lights * u64::from(max_cells(directions.size)).pow(2);
        training + training / 3 + sums + products + masks + cells + 4 * texels * (3 * most + 5 * lights)
    }
}
