//! The part `directions`: meshes that interpolate sampled views and lights, in the form that shaders read.

use super::factored::FactoredFlatBtf;
use super::layout::{self, check_format, wrong_extent};
use super::relief::FlatBtfParts;
use super::view_weights::{BlendedDirection, ViewWeights};
use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture};
use crate::direction_mesh::DirectionMesh;
use crate::direction_set::DirectionSet;

const PART: &str = "directions";
/// Texels per row.
const WIDTH: usize = 256;
/// First row of the views' mesh. The row before it has the first row of the lights' mesh and the height of the lowest
/// light.
const FIRST_ROW: usize = 1;
/// More rows than two meshes of the maximum size need.
const MAX_ROWS: u32 = 4096;

/// Meshes that interpolate sampled views and lights, with three samples of each per look-up.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledDirections {
    /// Mesh of the views.
    pub views: DirectionMesh,
    /// Mesh of the lights.
    pub lights: DirectionMesh,
    /// Cosine of the largest polar angle of a sampled light, above 0.
    pub lowest_light: f32,
}

impl SampledDirections {
    /// Creates meshes from polar angles and azimuths, radians.
    ///
    /// # Errors
    /// Returns an error if directions cannot be interpolated, as [`DirectionMesh::new`].
    pub fn new(views: &[[f32; 2]], lights: &[[f32; 2]]) -> Result<Self, FormatError> {
        let mesh = |name: &str, angles: &[[f32; 2]]| {
            let angles = angles.iter().map(|angles| angles.map(|angle| f64::from(angle).to_degrees()));
            DirectionMesh::new(&DirectionSet::new(name, angles.collect())?)
        };
        let largest = lights.iter().map(|[polar, _]| *polar).fold(0.0, f32::max);
        let lowest_light = f64::from(largest).cos() as f32;
        Ok(Self { views: mesh("views", views)?, lights: mesh("lights", lights)?, lowest_light })
    }

    /// Meshes of an asset; `None` if it has neither components nor sampled shadows, as for trees, which have a mesh of their
    /// own. With shadows alone, the mesh of the views is that of the lights.
    ///
    /// # Errors
    /// Returns an error if directions cannot be interpolated, as [`DirectionMesh::new`].
    pub fn of(asset: &FlatBtfParts) -> Result<Option<Self>, FormatError> {
        let header = asset.reflectance.factors().map(FactoredFlatBtf::header);
        match (header, asset.relief.shadows()) {
            (Some(header), _) if header.groups > 0 => Self::new(&header.views, &header.lights).map(Some),
            (Some(_), Some(shadows)) => Self::new(shadows.lights(), shadows.lights()).map(Some),
            _ => Ok(None),
        }
    }

    /// Sampled directions that approximate a view and a light; without meshes, none.
    pub(super) fn blended(meshes: Option<&Self>, view: [f32; 3], light: [f32; 3]) -> [BlendedDirection; 2] {
        let blended = |mesh: Option<&DirectionMesh>, direction| {
            let (indices, weights) = mesh.map_or(([0; 3], [0.0; 3]), |mesh| mesh.weights(direction));
            BlendedDirection { direction, samples: ViewWeights { indices, weights } }
        };
        [blended(meshes.map(|some| &some.views), view), blended(meshes.map(|some| &some.lights), light)]
    }

    /// Columns and rows of the texture.
    pub fn extent(&self) -> [u32; 2] {
        let rows = |mesh: &DirectionMesh| mesh.words().len().div_ceil(WIDTH);
        let lights = if self.lights == self.views { 0 } else { rows(&self.lights) };
        [WIDTH as u32, (FIRST_ROW + rows(&self.views) + lights) as u32]
    }

    /// Words of the texture, row by row. The first row has the first row of the lights' mesh and the bits of the
    /// cosine; the views' mesh starts in the second row. The lights' mesh starts in a row of its own, unless it equals
    /// the views' mesh.
    pub fn texels(&self) -> Vec<u32> {
        let mut words = vec![FIRST_ROW as u32, self.lowest_light.to_bits()];
        let mut add = |mesh: &DirectionMesh| {
            words.resize(words.len().next_multiple_of(WIDTH), 0);
            let row = words.len() / WIDTH;
            words.extend(mesh.words());
            row as u32
        };
        add(&self.views);
        let lights = if self.lights == self.views { FIRST_ROW as u32 } else { add(&self.lights) };
        words[0] = lights;
        words.resize(words.len().next_multiple_of(WIDTH), 0);
        words
    }

    /// Reads and validates the image of a file.
    pub(super) fn from_texture(texture: &Texture) -> Result<Self, FormatError> {
        check_format(texture, PART, TexelFormat::R32Uint)?;
        let rows = match texture.extent {
            Extent::D2([width, rows]) if width == WIDTH as u32 && (2..=MAX_ROWS).contains(&rows) => rows as usize,
            other => return Err(wrong_extent(PART, other, format!("{WIDTH} columns, 2 to {MAX_ROWS} rows"))),
        };
        let words = layout::words(&texture.texels);
        let (lights, lowest_light) = (words[0] as usize, f32::from_bits(words[1]));
        if !(FIRST_ROW..rows).contains(&lights) {
            return Err(FormatError::whole(
                format!("{PART}, row of the lights"),
                lights.to_string(),
                format!("{FIRST_ROW} to {}", rows - 1),
            ));
        }
        if !(lowest_light > 0.0 && lowest_light <= 1.0) {
            let field = format!("{PART}, cosine of the lowest light");
            return Err(FormatError::whole(field, lowest_light.to_string(), "above 0, at most 1"));
        }
        let mesh = |row: usize| DirectionMesh::from_words(&words[row * WIDTH..]);
        let read = Self { views: mesh(FIRST_ROW)?, lights: mesh(lights)?, lowest_light };
        // Meshes must be where a writer puts them, with nothing after them.
        if read.texels() != words {
            return Err(FormatError::whole(
                PART,
                "meshes at other positions",
                "the mesh of the views, then the mesh of the lights unless both are equal",
            )
            .problem());
        }
        Ok(read)
    }
}
