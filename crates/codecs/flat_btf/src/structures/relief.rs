//! Interface of all structures.

use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;
use brdfc_formats::direction::Vector;

/// A point of a surface, and its material.
pub(super) type Sample = (Vector, VertexMaterial);

/// A surface over the parameter plane. The point is near `(u, v, 0)`; z is not yet centred.
pub(super) trait Relief: Sync {
    /// Returns the line of the surface at `v`, as a function of `u`: values that are constant along it are computed
    /// once.
    fn line(&self, v: f64) -> Box<dyn Fn(f64) -> Sample + '_>;
}

/// A surface without shared values along a line.
pub(super) trait Pointwise: Sync {
    /// The surface at `(u, v)`.
    fn sample(&self, u: f64, v: f64) -> Sample;
}

impl<T: Pointwise> Relief for T {
    fn line(&self, v: f64) -> Box<dyn Fn(f64) -> Sample + '_> {
        Box::new(move |u| self.sample(u, v))
    }
}

/// A procedural structure: its name, parameters and materials.
#[derive(Debug, Clone, Copy)]
pub struct StructureInfo {
    /// The name in addresses.
    pub name: &'static str,
    /// Short description.
    pub meaning: &'static str,
    /// Its parameters, in the order of the canonical form; the first three are common to all structures.
    pub parameters: &'static [Parameter],
    /// Addresses of the materials that its weights blend, in order; tints multiply them.
    pub materials: &'static [&'static str],
    /// Builds the surface from one value per parameter, in order.
    pub(super) build: fn(&[f64]) -> Box<dyn Relief>,
}

impl PartialEq for StructureInfo {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

pub(super) const RESOLUTION: Parameter =
    Parameter::integer("resolution", [16.0, 1024.0], 192.0, "points of the mesh along either side of the tile");
pub(super) const HEIGHT: Parameter =
    Parameter::number("height", [0.0, 2.0], 1.0, "scale of the relief; 0: a flat plane");
pub(super) const SEED: Parameter = Parameter::integer("seed", [0.0, 999_999.0], 1.0, "seed of the random variation");
