//! Views of a BTF.

use brdfc_formats::FormatError;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;

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

    /// Some of the views, in this order.
    ///
    /// # Errors
    /// Returns the errors of [`Self::new`].
    ///
    /// # Panics
    /// Panics if a view does not exist.
    pub fn only(&self, chosen: &[usize]) -> Result<Self, FormatError> {
        let angles = chosen.iter().map(|view| self.set.angles[*view]).collect();
        Self::new(DirectionSet { name: self.set.name.clone(), angles })
    }

    /// Unit vector to the viewer of a view.
    pub fn direction(&self, view: usize) -> [f32; 3] {
        self.set.directions()[view].map(|c| c as f32)
    }
}
