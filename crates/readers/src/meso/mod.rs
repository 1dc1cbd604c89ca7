//! Triangle meshes for meso-geometry: Wavefront OBJ and PLY. Layouts: `crates/readers/src/meso/spec.md`.

pub mod obj;
pub mod ply;

use brdfc_formats::FormatError;

/// Largest magnitude of a coordinate, in the file's unit.
pub const MAX_COORDINATE: f64 = 1e12;
/// Maximum number of vertices of a mesh.
pub const MAX_VERTICES: usize = 1 << 23;
/// Maximum number of triangles of a mesh; a polygon counts as its number of corners minus two.
pub const MAX_TRIANGLES: usize = 1 << 23;

/// A mesh as stored in a file, before welding; lengths are in the file's own unit, z is up.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TriangleMesh {
    /// Positions of vertices; finite, up to [`MAX_COORDINATE`].
    pub positions: Vec<[f64; 3]>,
    /// Vertex indices of triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Names of materials, in the order of their first triangles; empty if the file names none.
    pub materials: Vec<String>,
    /// Index into `materials` of each triangle; empty without materials.
    pub triangle_materials: Vec<u32>,
    /// Linear RGB of each vertex, 0 to 1; empty if the file has no colours.
    pub colours: Vec<[f32; 3]>,
}

impl TriangleMesh {
    /// Checks the invariants of the fields.
    ///
    /// # Errors
    /// Returns an error for no triangles, lists of the wrong length, and indices and numbers out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        let vertices = self.positions.len();
        if self.triangles.is_empty() {
            return Err(FormatError::whole("triangles", "no triangles", "at least one").problem());
        }
        for (index, position) in self.positions.iter().enumerate() {
            if let Some(wrong) = position.iter().find(|c| !is_coordinate(**c)) {
                let allowed = format!("-{MAX_COORDINATE:e} to {MAX_COORDINATE:e}");
                return Err(FormatError::whole(format!("vertex {index}"), wrong.to_string(), allowed));
            }
        }
        for (index, triangle) in self.triangles.iter().enumerate() {
            if let Some(wrong) = triangle.iter().find(|v| **v as usize >= vertices) {
                let (field, allowed) = (format!("triangle {index}"), format!("vertices 0 to {}", vertices as i64 - 1));
                return Err(FormatError::whole(field, format!("vertex {wrong}"), allowed));
            }
        }
        check_length("materials of triangles", self.triangle_materials.len(), self.triangles.len())?;
        check_length("colours of vertices", self.colours.len(), vertices)?;
        if let Some(wrong) = self.triangle_materials.iter().find(|m| **m as usize >= self.materials.len()) {
            let allowed = format!("less than {}", self.materials.len());
            return Err(FormatError::whole("material of a triangle", wrong.to_string(), allowed));
        }
        match self.colours.iter().position(|colour| !colour.iter().all(|c| (0.0..=1.0).contains(c))) {
            Some(index) => {
                let found = format!("{:?}", self.colours[index]);
                Err(FormatError::whole(format!("colour of vertex {index}"), found, "0 to 1"))
            }
            None => Ok(()),
        }
    }
}

fn check_length(field: &'static str, found: usize, full: usize) -> Result<(), FormatError> {
    if found == 0 || found == full {
        return Ok(());
    }
    Err(FormatError::whole(field, found.to_string(), format!("0 or {full}")))
}

/// Returns true for finite values up to [`MAX_COORDINATE`].
fn is_coordinate(value: f64) -> bool {
    value.abs() <= MAX_COORDINATE
}

#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use proptest::prelude::*;

    /// Any valid mesh, without materials.
    pub fn meshes() -> impl Strategy<Value = TriangleMesh> {
        let vertices = prop::collection::vec(([-1e12..1e12, -2.0..2.0, -1e-9..1e-9], any::<[u8; 3]>()), 3..20);
        (vertices, prop::collection::vec(any::<[u32; 3]>(), 1..30), any::<bool>()).prop_map(
            |(vertices, faces, coloured)| {
                let count = vertices.len() as u32;
                TriangleMesh {
                    positions: vertices.iter().map(|v| v.0).collect(),
                    triangles: faces.into_iter().map(|face| face.map(|v| v % count)).collect(),
                    colours: if coloured {
                        vertices.iter().map(|v| v.1.map(|c| f32::from(c) / 255.0)).collect()
                    } else {
                        Vec::new()
                    },
                    ..TriangleMesh::default()
                }
            },
        )
    }

    /// Truncates, changes and repeats bytes: every reader must return a mesh that passes its check, or an error.
    pub fn mutate(bytes: &[u8], read: impl Fn(&[u8]) -> Result<TriangleMesh, FormatError>) {
        let check = |bytes: &[u8]| {
            if let Ok(mesh) = read(bytes) {
                mesh.check().unwrap();
                assert!(mesh.triangles.len() <= bytes.len() && mesh.positions.len() <= bytes.len());
                true
            } else {
                false
            }
        };
        assert!(check(bytes));
        let mut refused = 0;
        for at in 0..bytes.len() {
            refused += usize::from(!check(&bytes[..at]));
            let mut changed = bytes.to_vec();
            for pattern in [1, 2, 4, 8, 16, 32, 64, 128, 0xff] {
                changed[at] = bytes[at] ^ pattern;
                refused += usize::from(!check(&changed));
            }
            for digit in b"09-. \n" {
                changed[at] = *digit;
                refused += usize::from(!check(&changed));
            }
            changed[at] = bytes[at];
            changed.insert(at, b'9');
            refused += usize::from(!check(&changed));
        }
        assert!(refused > bytes.len(), "{refused}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_the_field() {
        let good = TriangleMesh {
            positions: vec![[0.0; 3]; 3],
            triangles: vec![[0, 1, 2]],
            materials: vec!["a".to_owned()],
            triangle_materials: vec![0],
            colours: vec![[0.5; 3]; 3],
        };
        assert_eq!(good.check(), Ok(()));
        let message = |change: fn(&mut TriangleMesh)| {
            let mut mesh = good.clone();
            change(&mut mesh);
            mesh.check().unwrap_err().to_string()
        };
        assert_eq!(message(|m| m.triangles.clear()), "triangles: no triangles; expected at least one");
        assert_eq!(message(|m| m.positions[1][2] = f64::NAN), "vertex 1: found NaN, expected -1e12 to 1e12");
        assert_eq!(message(|m| m.triangles[0][1] = 3), "triangle 0: found vertex 3, expected vertices 0 to 2");
        assert_eq!(message(|m| m.colours.truncate(2)), "colours of vertices: found 2, expected 0 or 3");
        assert_eq!(message(|m| m.triangle_materials.push(0)), "materials of triangles: found 2, expected 0 or 1");
        assert_eq!(message(|m| m.triangle_materials[0] = 1), "material of a triangle: found 1, expected less than 1");
        assert!(message(|m| m.colours[2][0] = 1.5).starts_with("colour of vertex 2: found [1.5, 0.5, 0.5]"));
    }
}
