//! Procedural meso-geometry for validation: the cases of Figure 1 of Hadim et al. 2009.
//!
//! Each structure is a periodic function from parameters `(u, v)` to points and materials: `(u + 1, v)` and `(u, v +
//! 1)` give the same point, one tile further. `docs/synth.md` has the formulas. Addresses have the grammar of
//! [`address`](brdfc_core::address).

mod button;
mod folds;
mod knit;
pub mod noise;
mod relief;
mod sponge;
#[cfg(test)]
mod tests;

pub use relief::StructureInfo;

use super::mesh::PeriodicMesh;
use super::surface::Appearance;
use brdfc_core::address::{
    AddressError, canonical_address, describe, find_named, parse_parameters, parse_synth, split_query,
};
use brdfc_formats::direction::subtract;
use rayon::prelude::*;
use relief::Sample;

/// All structures.
pub const STRUCTURES: [&StructureInfo; 4] = [&button::INFO, &folds::INFO, &knit::INFO, &sponge::INFO];

/// A structure with values for its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    info: &'static StructureInfo,
    values: Vec<f64>,
}

impl Structure {
    /// Parses an address without its prefix `synth:`, such as `button?resolution=160&seed=3`.
    ///
    /// # Errors
    ///
    /// Returns an error if the structure or a parameter is unknown, or if a value is missing, repeated, not a number,
    /// or out of range.
    pub fn parse(text: &str) -> Result<Self, AddressError> {
        let (name, query) = split_query(text);
        let info = find_named("structure", name, &STRUCTURES, |info| info.name)?;
        let values = parse_parameters(info.name, info.parameters, &[], query)?;
        Ok(Self { info, values: values.into_iter().map(|[value, ..]| value).collect() })
    }

    /// Name, parameters and materials.
    pub fn info(&self) -> &'static StructureInfo {
        self.info
    }

    /// The address with every parameter, in the structure's order, each number in its shortest exact form.
    pub fn canonical(&self) -> String {
        let values: Vec<_> = self.values.iter().map(|value| [*value; 3]).collect();
        canonical_address(self.info.name, self.info.parameters, &values)
    }

    /// Addresses of the materials that [`VertexMaterial::weights`](super::mesh::VertexMaterial::weights) of the mesh
    /// refer to. Each has an albedo below 1.
    pub fn default_materials(&self) -> &'static [&'static str] {
        self.info.materials
    }

    /// Appearance by the default materials.
    ///
    /// # Panics
    /// Panics if an address of ours is wrong; a test evaluates all of them.
    pub fn appearance(&self) -> Appearance {
        let source = |address: &&str| parse_synth(address).expect("an address of ours");
        Appearance { sources: self.default_materials().iter().map(source).collect(), ..Appearance::default() }
    }

    /// Returns the surface as a mesh of `resolution` x `resolution` points. Its mean height is `z = 0`: the volumes
    /// above and below the plane are equal.
    pub fn mesh(&self) -> PeriodicMesh {
        let (resolution, height) = (self.values[0] as usize, self.values[1]);
        let surface = (self.info.build)(&self.values);
        let coordinate = |k: usize| k as f64 / resolution as f64;
        // Overhangs shrink with the relief: a flat plane has none.
        let reach = height.min(1.0);
        let sample = |line: &dyn Fn(f64) -> Sample, u: f64, v: f64| {
            let ([x, y, z], material) = line(u);
            ([u + reach * (x - u), v + reach * (y - v), height * z], material)
        };
        let rows: Vec<Vec<Sample>> = (0..resolution)
            .into_par_iter()
            .map(|row| {
                let v = coordinate(row);
                let line = surface.line(v);
                (0..resolution).map(|column| sample(&line, coordinate(column), v)).collect()
            })
            .collect();
        let (points, materials) = rows.into_iter().flatten().unzip();
        let mut mesh = PeriodicMesh::from_grid(resolution, resolution, points, materials);
        let mean = mean_height(&mesh);
        mesh.positions.iter_mut().for_each(|point| point[2] -= mean);
        mesh
    }
}

/// Mean height over the tile: the integral of z over the projected area, which is negative where a triangle faces down.
fn mean_height(mesh: &PeriodicMesh) -> f64 {
    let volume = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let (p, q) = (subtract(b, a), subtract(c, a));
        0.5 * (p[0] * q[1] - p[1] * q[0]) * (a[2] + b[2] + c[2]) / 3.0
    };
    (0..mesh.triangles.len()).map(volume).sum()
}

/// Lists all structures with their parameters, ranges and defaults, for help texts.
pub fn describe_structures() -> String {
    STRUCTURES.iter().map(|info| describe(info.name, info.meaning, info.parameters, &[])).collect()
}
