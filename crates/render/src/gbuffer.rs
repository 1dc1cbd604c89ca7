//! G-buffers on the CPU: the visible surfaces of an image, before shading.

use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::{Hits, trace};
use super::vector::{cross, double};
use brdfc_formats::direction::{Vector, dot, normalize};
use rayon::prelude::*;

/// Part index of pixels that show no surface.
pub const BACKGROUND: u32 = u32::MAX;

/// Surface points of an image, one array for each value, row by row from the top. Values of the background are 0.
#[derive(Debug, Clone, PartialEq)]
pub struct GBuffer {
    /// Points per row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Positions in world space.
    pub position: Vec<[f32; 3]>,
    /// Unit shading normals, on the viewer's side.
    pub normal: Vec<[f32; 3]>,
    /// Unit tangents, at right angles to the normals.
    pub tangent: Vec<[f32; 3]>,
    /// Direction of the normal in the image, across and down, a unit vector; to the right if the normal points to the
    /// viewer.
    pub across: Vec<[f32; 2]>,
    /// Unit vectors to the viewer.
    pub to_viewer: Vec<[f32; 3]>,
    /// Texture coordinates, as in [`ShadingPoint`].
    pub uv: Vec<[f32; 2]>,
    /// Distance of the viewer.
    pub distance: Vec<f32>,
    /// Index of the part, or [`BACKGROUND`].
    pub part: Vec<u32>,
}

/// Tangent, bitangent and normal: orthonormal, up to rounding.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalFrame {
    /// Unit vector along x of the frame.
    pub tangent: [f32; 3],
    /// Unit vector along y of the frame.
    pub bitangent: [f32; 3],
    /// Unit vector along z of the frame.
    pub normal: [f32; 3],
}

impl LocalFrame {
    /// Converts from world space to the frame.
    pub fn local(&self, v: [f32; 3]) -> [f32; 3] {
        [self.tangent, self.bitangent, self.normal].map(|axis| v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2])
    }

    /// Converts from the frame to world space.
    pub fn world(&self, v: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| v[0] * self.tangent[k] + v[1] * self.bitangent[k] + v[2] * self.normal[k])
    }
}

/// Direction of the normal in the image.
fn across(point: &ShadingPoint, [right, up]: [Vector; 2]) -> [f32; 2] {
    let (x, y) = (dot(point.normal, right), -dot(point.normal, up));
    let length = x.hypot(y);
    if length > 1e-9 { [(x / length) as f32, (y / length) as f32] } else { [1.0, 0.0] }
}

impl GBuffer {
    /// Traces a frame. Each sample is a point of its own: a frame of `samples` per pixel and axis gives the same buffer
    /// as a frame of `samples` times the size with one sample.
    pub fn new(scene: &Scene, frame: Frame) -> Self {
        Self::of_hits(scene, frame, &trace(scene, frame))
    }

    /// Makes the buffer from the hits of the frame.
    ///
    /// # Panics
    /// If the hits belong to another frame.
    pub fn of_hits(scene: &Scene, frame: Frame, hits: &Hits) -> Self {
        let (samples, each) = (frame.samples, frame.samples_per_pixel());
        assert_eq!(hits.0.len(), frame.width * frame.height * each, "hits of this frame");
        let (width, height) = (frame.width * samples, frame.height * samples);
        let point = |index: usize| {
            let (x, y) = (index % width, index / width);
            let pixel = y / samples * frame.width + x / samples;
            let hit = hits.0[pixel * each + y % samples * samples + x % samples]?;
            Some((hit.part, ShadingPoint::new(&scene.parts[hit.part as usize], &hit, scene.camera.eye)))
        };
        let points: Vec<Option<(u32, ShadingPoint)>> = (0..width * height).into_par_iter().map(point).collect();
        let (right, up, _) = scene.camera.basis();
        let basis = [right, up];
        let vectors = |of: fn(&ShadingPoint) -> Vector| -> Vec<[f32; 3]> {
            points.iter().map(|point| point.map_or([0.0; 3], |(_, point)| of(&point).map(|c| c as f32))).collect()
        };
        Self {
            width,
            height,
            position: vectors(|point| point.position),
            normal: vectors(|point| point.normal),
            tangent: vectors(|point| point.tangent),
            across: points.iter().map(|point| point.map_or([1.0, 0.0], |(_, point)| across(&point, basis))).collect(),
            to_viewer: vectors(|point| point.to_viewer),
            uv: points.iter().map(|point| point.map_or([0.0; 2], |(_, point)| point.uv.map(|c| c as f32))).collect(),
            distance: points.iter().map(|point| point.map_or(0.0, |(_, point)| point.distance as f32)).collect(),
            part: points.iter().map(|point| point.map_or(BACKGROUND, |(part, _)| part)).collect(),
        }
    }

    /// The local frame at a pixel that shows a surface.
    pub fn frame(&self, pixel: usize) -> LocalFrame {
        let (normal, tangent) = (self.normal[pixel], self.tangent[pixel]);
        let [(a, b, c), (x, y, z)] = [normal, tangent].map(|[x, y, z]| (x, y, z));
        let bitangent = [b * z - c * y, c * x - a * z, a * y - b * x];
        LocalFrame { tangent, bitangent, normal }
    }

    /// Part that a pixel shows; `None` for the background.
    pub fn part_at(&self, pixel: usize) -> Option<usize> {
        let part = self.part[pixel];
        (part != BACKGROUND).then_some(part as usize)
    }

    /// Point that a pixel shows, in double precision with an orthonormal frame; `None` for the background.
    pub fn shading_point(&self, pixel: usize) -> Option<ShadingPoint> {
        self.part_at(pixel)?;
        let unit = |v: [f32; 3]| normalize(double(v));
        let (normal, to_viewer) = (unit(self.normal[pixel]), unit(self.to_viewer[pixel]));
        let bitangent = normalize(cross(normal, double(self.tangent[pixel])));
        let mut point = ShadingPoint {
            position: double(self.position[pixel]),
            tangent: cross(bitangent, normal),
            bitangent,
            normal,
            to_viewer,
            outgoing: [0.0; 3],
            distance: f64::from(self.distance[pixel]),
            uv: self.uv[pixel].map(f64::from),
        };
        point.outgoing = point.local(to_viewer);
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes::Builtin;

    const FRAME: Frame = Frame { width: 24, height: 16, samples: 1 };

    #[test]
    fn it_holds_the_surface_points_of_the_rays() {
        let scene = Builtin::Table.scene();
        let hits = trace(&scene, FRAME);
        let buffer = GBuffer::new(&scene, FRAME);
        assert_eq!((buffer.width, buffer.height), (24, 16));
        let mut parts = [0; 4];
        for (pixel, hit) in hits.0.iter().enumerate() {
            let Some(hit) = hit else {
                assert!(buffer.part[pixel] == BACKGROUND && buffer.shading_point(pixel).is_none());
                continue;
            };
            parts[buffer.part_at(pixel).unwrap()] += 1;
            let expected = ShadingPoint::new(&scene.parts[hit.part as usize], hit, scene.camera.eye);
            let found = buffer.shading_point(pixel).unwrap();
            let near = |a: Vector, b: Vector| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-6);
            assert!(near(found.position, expected.position) && near(found.normal, expected.normal));
            assert!(near(found.tangent, expected.tangent) && near(found.bitangent, expected.bitangent));
            assert!(near(found.to_viewer, expected.to_viewer) && near(found.outgoing, expected.outgoing));
            assert!((found.distance - expected.distance).abs() < 1e-5);
        }
        assert!(parts.iter().all(|count| *count > 0), "{parts:?}");
    }

    #[test]
    fn samples_are_points_of_a_larger_buffer() {
        let scene = Builtin::Sphere.scene();
        let fine = GBuffer::new(&scene, Frame { samples: 3, ..FRAME });
        assert_eq!(fine, GBuffer::new(&scene, Frame { width: 72, height: 48, samples: 1 }));
        // The control: a buffer of the same size from another view.
        let mut moved = scene.clone();
        moved.camera.eye[0] += 0.01;
        assert_ne!(fine, GBuffer::new(&moved, Frame { samples: 3, ..FRAME }));
    }
}
