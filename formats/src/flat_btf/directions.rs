//! The part `directions`: what blends the sampled views and lights, ready for a shader.

use super::decoder::FlatValues;
use super::layout::{self, check_format, wrong_extent};
use crate::FormatError;
use crate::container::{Extent, TexelFormat, Texture};
use crate::direction_mesh::DirectionMesh;
use crate::direction_set::DirectionSet;

const PART: &str = "directions";
/// Texels in a row.
const WIDTH: usize = 256;
/// The row of the views' mesh. The one before says where that of the lights begins, and their lowest height.
const FIRST_ROW: usize = 1;
/// More rows than two meshes of as many directions as are allowed have.
const MAX_ROWS: u32 = 4096;

/// What blends sampled views and lights: three samples of each for any direction.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledDirections {
    /// Of views.
    pub views: DirectionMesh,
    /// Of lights.
    pub lights: DirectionMesh,
    /// Cosine of the largest polar angle of a sampled light, above 0.
    pub lowest_light: f32,
}

impl SampledDirections {
    /// Polar angles and azimuths of views and lights, radians.
    ///
    /// # Errors
    /// Directions that cannot be blended: what [`DirectionMesh::new`] refuses.
    pub fn new(views: &[[f32; 2]], lights: &[[f32; 2]]) -> Result<Self, FormatError> {
        let mesh = |name: &str, angles: &[[f32; 2]]| {
            let angles = angles.iter().map(|angles| angles.map(|angle| f64::from(angle).to_degrees()));
            DirectionMesh::new(&DirectionSet::new(name, angles.collect())?)
        };
        let largest = lights.iter().map(|[polar, _]| *polar).fold(0.0, f32::max);
        let lowest_light = f64::from(largest).cos() as f32;
        Ok(Self { views: mesh("views", views)?, lights: mesh("lights", lights)?, lowest_light })
    }

    /// Those of an asset; nothing of one that has no values of views.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(values: &FlatValues) -> Result<Option<Self>, FormatError> {
        values.directions().map(|[views, lights]| Self::new(views, lights)).transpose()
    }

    /// Columns and rows of the texture.
    pub fn extent(&self) -> [u32; 2] {
        let rows = |mesh: &DirectionMesh| mesh.words().len().div_ceil(WIDTH);
        let lights = if self.lights == self.views { 0 } else { rows(&self.lights) };
        [WIDTH as u32, (FIRST_ROW + rows(&self.views) + lights) as u32]
    }

    /// The texture's words, row by row: the row of the lights' mesh and the bits of the cosine; from the second row on the
    /// views' mesh, and from a row of its own that of the lights, where it is another one.
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

    /// Reads and checks the image of a file.
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
        // Nothing behind the meshes, and both where a writer puts them.
        if read.texels() != words {
            return Err(FormatError::whole(
                PART,
                "meshes in other places",
                "the views', then the lights' where it is another one",
            ));
        }
        Ok(read)
    }
}
