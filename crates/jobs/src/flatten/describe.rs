//! Describes inputs of flattening.

use super::input::structure;
use crate::error::Error;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::weld::{MesoError, WeldReport, weld};
use brdfc_readers::meso::TriangleMesh;
use brdfc_source::btf_stack::survey;
use brdfc_source::meso::{HeightMap, MesoInput, open_meso};
use brdfc_source::photograph::Common;
use brdfc_source::ubo_btf::UboBtfFile;
use brdfc_source::{Input, InputError, Kind};
use serde::Serialize;
use std::path::Path;

/// Kind and properties of an input.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum SurfaceFacts {
    /// A procedural structure, given as an address.
    Structure {
        /// The address with all parameters.
        address: String,
        /// Vertices of one tile.
        vertices: usize,
        /// Triangles of one tile.
        triangles: usize,
        /// Lowest and highest point, in tiles.
        heights: [f64; 2],
        /// Addresses of the materials that it blends.
        materials: Vec<String>,
    },
    /// A mesh in a file, OBJ or PLY.
    Mesh(MeshFacts),
    /// A height map in an image file, PNG or EXR.
    HeightMap {
        /// Pixels per row, and rows.
        size: [usize; 2],
        /// Lowest and highest value: 0 to 1 from PNG, as stored from EXR.
        values: [f64; 2],
        /// Statements of the file about its pixels, such as windows, and what was done.
        conversions: Vec<String>,
    },
    /// A BTF of the Bonn database of 2014 in one file.
    UboBtf {
        /// Directions to the viewer.
        views: usize,
        /// Directions to the light.
        lights: usize,
        /// Texels per row, and rows.
        size: [usize; 2],
        /// Code of the colour model: 0 is RGB, 11 is the logarithm of Y with U and V as ratios to Y.
        colour_model: i32,
        /// Columns of the matrices of each of the three channels.
        components: Vec<usize>,
        /// True if values include the cosine of the light's polar angle.
        has_cosine: bool,
        /// Names of the measurement setup, the image sensor and the light source, as far as the file has them.
        devices: Vec<String>,
        /// Bytes of its matrices in memory.
        memory_bytes: u64,
    },
    /// Images of an ordinary BTF.
    ImageStack {
        /// Distinct directions to the viewer.
        views: usize,
        /// Distinct directions to the light.
        lights: usize,
        /// Number of images that exist.
        images: usize,
        /// Number of pairs of view and light without an image. Flattening requires 0.
        missing: usize,
        /// Pixels per row, and rows.
        size: [usize; 2],
        /// Colour of the code values of the images, and how they are converted.
        colour: String,
        /// Differences in colour, and other statements of the images that are applied.
        notes: Vec<String>,
        /// Extensions of the images in lower case, without duplicates.
        extensions: Vec<String>,
    },
}

/// Properties of a mesh, and of its repetition.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct MeshFacts {
    /// Vertices in the file.
    pub vertices: usize,
    /// Triangles in the file.
    pub triangles: usize,
    /// Names of its materials.
    pub materials: Vec<String>,
    /// True if vertices have colours.
    pub colours: bool,
    /// Lowest and highest coordinates along x, y and z, in the file's unit.
    pub bounds: [[f64; 2]; 3],
    /// The period with which it closes, if found: 1, or the side of a square bounding box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tile: Option<f64>,
    /// Repairs with this period.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[serde(rename = "repaired")]
    pub repairs: Option<WeldReport>,
    /// Error message if it does not close.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

/// Describes a structure, a mesh, a height map, or an ordinary BTF.
///
/// # Errors
/// Returns an error if a file cannot be read or is invalid, if an address is invalid, and for inputs of other kinds. A mesh that does
/// not close is no error.
pub fn describe_surface(input: &Input) -> Result<SurfaceFacts, Error> {
    if let Some(structure) = structure(input)? {
        return Ok(describe_structure(&structure));
    }
    match (Kind::of(input)?, input.path()) {
        (Kind::Btf, Some(folder)) if folder.is_dir() => Ok(describe_images(folder)?),
        (Kind::Btf, Some(file)) => Ok(describe_ubo_btf(file)?),
        _ => Ok(match open_meso(input)? {
            MesoInput::Mesh(mesh) => SurfaceFacts::Mesh(describe_mesh(&mesh)),
            MesoInput::Heights(map) => describe_heights(&map),
        }),
    }
}

fn describe_structure(structure: &Structure) -> SurfaceFacts {
    let mesh = structure.mesh();
    SurfaceFacts::Structure {
        address: structure.canonical(),
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        heights: mesh.height_range(),
        materials: structure.default_materials().iter().map(|material| (*material).to_owned()).collect(),
    }
}

fn describe_mesh(mesh: &TriangleMesh) -> MeshFacts {
    let bounds = [0, 1, 2].map(|axis| range(mesh.positions.iter().map(|position| position[axis])));
    let closed = |tile: f64| weld(mesh, tile).map(|(_, report)| (tile, report));
    let outcome = closed(1.0).or_else(|error: MesoError| {
        let [width, height] = [0, 1].map(|axis: usize| bounds[axis][1] - bounds[axis][0]);
        let square = width > 0.0 && (width - height).abs() <= 1e-6 * width && (width - 1.0).abs() > 1e-6;
        // The side may be rounded, so the first error, which has the hint, is more useful.
        if square { closed(width).map_err(|_| error) } else { Err(error) }
    });
    let (tile, repairs, problem) = match outcome {
        Ok((tile, report)) => (Some(tile), Some(report), None),
        Err(error) => (None, None, Some(error.to_string())),
    };
    MeshFacts {
        vertices: mesh.positions.len(),
        triangles: mesh.triangles.len(),
        materials: mesh.materials.clone(),
        colours: !mesh.colours.is_empty(),
        bounds,
        tile,
        repairs,
        problem,
    }
}

fn describe_heights(map: &HeightMap) -> SurfaceFacts {
    let values = range(map.heights.iter().map(|height| f64::from(*height)));
    SurfaceFacts::HeightMap { size: [map.width, map.height], values, conversions: map.conversions.clone() }
}

fn describe_images(folder: &Path) -> Result<SurfaceFacts, InputError> {
    let (contents, Common { size, colour, notes, .. }) = survey(folder)?;
    let of_file = |file: &String| Path::new(file).extension().map(|e| e.to_string_lossy().to_lowercase());
    let extensions: std::collections::BTreeSet<String> = contents.files.iter().filter_map(of_file).collect();
    Ok(SurfaceFacts::ImageStack {
        views: contents.views.len(),
        lights: contents.lights.len(),
        images: contents.files.len(),
        missing: contents.missing,
        size,
        colour,
        notes,
        extensions: extensions.into_iter().collect(),
    })
}

fn describe_ubo_btf(path: &Path) -> Result<SurfaceFacts, InputError> {
    let file = UboBtfFile::open(path)?;
    let (btf, description) = (file.btf(), file.description());
    Ok(SurfaceFacts::UboBtf {
        views: description.views.len(),
        lights: description.lights.len(),
        size: description.size,
        colour_model: description.colour_model.code(),
        components: btf.channels().iter().map(|channel| channel.components()).collect(),
        has_cosine: description.has_cosine,
        devices: description.devices.iter().filter(|name| !name.is_empty()).cloned().collect(),
        memory_bytes: btf.memory_bytes(),
    })
}

/// Lowest and highest value; zeros if there are none.
fn range(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values
        .fold(None, |found: Option<[f64; 2]>, v| Some(found.map_or([v; 2], |[a, b]| [a.min(v), b.max(v)])))
        .unwrap_or_default()
}
