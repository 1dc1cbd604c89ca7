//! What every structure is.

use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;
use brdfc_formats::direction::Vector;

/// A point of a surface, and what the surface is made of there.
pub(super) type Sample = (Vector, VertexMaterial);

/// A surface over the parameter plane. The point is near `(u, v, 0)`; z is not yet centred.
pub(super) trait Relief: Sync {
    /// The line of the surface at `v`, as a function of `u`: what is the same along it is found once.
    fn line(&self, v: f64) -> Box<dyn Fn(f64) -> Sample + '_>;
}

/// A surface of which nothing is the same along a line.
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
    /// What it is, in few words.
    pub meaning: &'static str,
    /// Its parameters, in the order of the canonical form; the first three are those of every structure.
    pub parameters: &'static [Parameter],
    /// Addresses of the materials that its weights blend, in their order; tints come on top.
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
pub(super) const SEED: Parameter = Parameter::integer("seed", [0.0, 999_999.0], 1.0, "of what is random");
