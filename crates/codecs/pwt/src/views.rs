//! Views of a BTF, whose images are stacked.

use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::pixels::Pixels;
use std::ops::Range;

/// Directions of two or more views, and the mesh that blends them.
#[derive(Debug, Clone, PartialEq)]
pub struct Views {
    set: DirectionSet,
    mesh: DirectionMesh,
}

impl Views {
    /// Triangulates directions to the viewer.
    ///
    /// # Errors
    /// Returns an error for fewer than two directions, and as [`DirectionMesh::new`].
    pub fn new(set: DirectionSet) -> Result<Self, FormatError> {
        if set.len() < 2 {
            return Err(FormatError::whole("views", set.len().to_string(), "2 or more"));
        }
        Ok(Self { mesh: DirectionMesh::new(&set)?, set })
    }

    /// Number of views.
    pub fn len(&self) -> usize {
        self.set.len()
    }

    /// Returns false: there are two or more views.
    pub fn is_empty(&self) -> bool {
        self.set.is_empty()
    }

    /// Mesh that blends the views.
    pub fn mesh(&self) -> &DirectionMesh {
        &self.mesh
    }

    /// Unit vector to the viewer of a view.
    pub fn direction(&self, view: usize) -> [f32; 3] {
        self.set.directions()[view].map(|c| c as f32)
    }
}

impl LightSamples {
    /// Number of views, 1 or more.
    pub fn view_count(&self) -> usize {
        self.views.as_ref().map_or(1, Views::len)
    }

    /// Columns and rows of a view.
    pub fn view_size(&self) -> [usize; 2] {
        [self.size[0], self.size[1] / self.view_count()]
    }

    /// Pixels of a view in the image of a light.
    pub fn pixels_of_view(&self, view: usize) -> Range<usize> {
        let [width, height] = self.view_size();
        view * width * height..(view + 1) * width * height
    }

    /// The images of some of several views, in this order.
    ///
    /// # Errors
    /// Returns an error for fewer than two views, and as [`DirectionMesh::new`].
    ///
    /// # Panics
    /// Panics if a view does not exist.
    pub fn only_views(&self, chosen: &[usize]) -> Result<Self, FormatError> {
        let set = self.views.as_ref().map(|views| {
            let angles = chosen.iter().map(|view| views.set.angles[*view]).collect();
            DirectionSet { name: views.set.name.clone(), angles }
        });
        let views = Views::new(set.unwrap_or_else(|| DirectionSet { name: String::new(), angles: Vec::new() }))?;
        let [width, height] = self.view_size();
        let parts = |image: &Pixels| image.parts(chosen.iter().map(|view| self.pixels_of_view(*view)));
        let texels = |mask: &Vec<bool>| {
            chosen.iter().flat_map(|view| &mask[self.pixels_of_view(*view)]).copied().collect::<Vec<_>>()
        };
        Ok(Self {
            size: [width, height * chosen.len()],
            lights: self.lights.clone(),
            images: self.images.iter().map(parts).collect(),
            near: None,
            repeats: self.repeats,
            views: Some(views),
            defined: self.defined.as_ref().map(texels),
        })
    }

    /// Checks the number of views.
    pub(crate) fn check_views(&self) -> Result<(), FormatError> {
        let Some(views) = &self.views else { return Ok(()) };
        FormatError::check_range("views", views.len(), 2..=brdfc_formats::pwt::MAX_VIEWS as usize)?;
        let height = self.size[1];
        if !height.is_multiple_of(views.len()) {
            let allowed = format!("a multiple of {}, the number of views", views.len());
            return Err(FormatError::whole("rows of all views", height.to_string(), allowed));
        }
        if self.repeats && self.near.is_none() {
            return Ok(());
        }
        Err(FormatError::whole("images of several views", "no tiles", "tiles under distant lights").problem())
    }
}
