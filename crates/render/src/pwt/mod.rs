//! Renderings of polynomial wavelet trees on the surfaces of a scene, under any light.
//!
//! Each surface is the image plane of the photographs, bent. Their right is the tangent, their top the bitangent. A
//! texel is evaluated for the directions to the viewer and to the scene's light in that frame; a pack of one view ignores the
//! former. One material covers all
//! parts of a scene; their bump maps and mirrors are ignored.
//!
//! Values are relative to white in the photographs and include the cosine: a point light of radiant intensity I at
//! distance d gives the radiance `value I / (π d²)`.

mod photograph;
mod scene;

pub use photograph::Photograph;
pub use scene::{distant_light, image_scene};

use super::footprint::{footprint, from_behind, mipmap_level};
use super::sample_means::sample_means;
use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::trace;
use super::vector::subtract;
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, dot};
use brdfc_formats::pwt::PwtDecoder;
use brdfc_metrics::image::LinearImage;
use std::f64::consts::PI;

/// A pack as a material of surfaces.
#[derive(Debug, Clone)]
pub struct PwtMaterial {
    decoder: PwtDecoder,
    repeat: u32,
}

impl PwtMaterial {
    /// A material that repeats `repeat` times per unit of a mesh's uv.
    ///
    /// # Errors
    /// Returns an error if `repeat` is 0, or more than 1 for an image that is no tile.
    pub fn new(decoder: PwtDecoder, repeat: u32) -> Result<Self, FormatError> {
        let wrong = |allowed| Err(FormatError::whole("repeat", repeat.to_string(), allowed));
        match (repeat, decoder.pack().header().repeats) {
            (0, _) => wrong("1 or more per unit of uv"),
            (2.., false) => wrong("1, since the image is no tile"),
            _ => Ok(Self { decoder, repeat }),
        }
    }

    /// The decoder.
    pub fn decoder(&self) -> &PwtDecoder {
        &self.decoder
    }

    /// Repetitions per unit of a mesh's uv.
    pub fn repeat(&self) -> u32 {
        self.repeat
    }
}

/// Draws a scene whose parts all use one pack, with exact filters, in the same steps as `pwt_scene.wgsl`.
pub fn draw_on_cpu(scene: &Scene, frame: Frame, material: &PwtMaterial) -> LinearImage {
    let decoder = &material.decoder;
    let size = decoder.pack().header().size.map(|side| side as usize);
    draw(scene, frame, material.repeat, size, |_, uv, level, view, light| {
        decoder.value(uv, level, view.map(|c| c as f32), light.map(|c| c as f32))
    })
}

/// Draws a scene with photographs, one for each light of the scene, independent of its direction.
///
/// # Panics
/// If the number of photographs differs from the number of lights.
pub fn draw_photographs(scene: &Scene, frame: Frame, photographs: &[Photograph], repeat: u32) -> LinearImage {
    assert_eq!(photographs.len(), scene.lights.len(), "a photograph for each light");
    let size = photographs.first().map_or([1; 2], Photograph::size);
    draw(scene, frame, repeat, size, |light, uv, level, _, _| photographs[light].value(uv, level))
}

/// Draws with `value`, which is relative to white, for a light's number, a position in the image, a mipmap level, and
/// directions to the viewer and to the light.
fn draw(
    scene: &Scene,
    frame: Frame,
    repeat: u32,
    size: [usize; 2],
    value: impl Fn(usize, [f32; 2], f32, Vector, Vector) -> [f32; 3] + Sync,
) -> LinearImage {
    let hits = trace(scene, frame).0;
    sample_means(scene, frame, |pixel, sample| {
        let hit = hits[pixel * frame.samples_per_pixel() + sample].as_ref()?;
        let part = &scene.parts[hit.part as usize];
        let point = ShadingPoint::without_bump(part, hit, scene.camera.eye);
        let steps = footprint(scene, frame, hit, frame.sample_position(pixel, sample));
        let level = mipmap_level(steps, repeat, size);
        let from_behind = from_behind(&part.mesh, hit.triangle, point.to_viewer);
        let uv = image_coordinates(point.uv, from_behind, repeat);
        let outgoing = point.local(point.to_viewer);
        let mut radiance = [0.0; 3];
        for (number, light) in scene.lights.iter().enumerate() {
            let to_light = subtract(light.position, point.position);
            let squared = dot(to_light, to_light);
            let incoming = point.local(to_light.map(|c| c / squared.sqrt()));
            if incoming[2] <= 0.0 || incoming[2].is_nan() {
                continue;
            }
            let value = value(number, uv, level, outgoing, incoming);
            (0..3).for_each(|k| radiance[k] += f64::from(value[k]) * light.intensity[k] / (PI * squared));
        }
        Some(radiance)
    })
}

/// Position of a point in the image: v runs down in it, and along the bitangent on the surface.
fn image_coordinates([u, v]: [f64; 2], from_behind: bool, repeat: u32) -> [f32; 2] {
    // On back faces the point's v is negated, and the bitangent has the opposite direction.
    let down = if from_behind { -v } else { 1.0 - v };
    [u, down].map(|c| (c * f64::from(repeat)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::PointLight;

    const FRAME: Frame = Frame { width: 40, height: 20, samples: 1 };
    const SIZE: [usize; 2] = [40, 20];

    /// A photograph with red at the top left and blue at the bottom right.
    fn photograph() -> Photograph {
        let pixel = |at: usize| [1.0 - (at % 40) as f32 / 80.0, 0.25, (at / 40) as f32 / 40.0];
        Photograph::new(SIZE, (0..800).map(pixel).collect(), false)
    }

    fn scene() -> Scene {
        image_scene(SIZE, [FRAME.width, FRAME.height])
    }

    /// Known answer: seen from above, the rendering is the photograph, upright.
    #[test]
    fn from_above_the_rendering_is_the_photograph() {
        let scene = scene();
        let rendering = draw_photographs(&scene, FRAME, &[photograph()], 1);
        let at = |x: usize, y: usize| rendering.pixels[y * 40 + x];
        for (x, y) in [(3, 2), (36, 2), (3, 17), (36, 17)] {
            let [red, green, blue] = at(x, y);
            // Light falls off a little across the plane; colours do not.
            let expected = [(1.0 - x as f32 / 80.0) / 0.25, y as f32 / 40.0 / 0.25];
            assert!((red / green - expected[0]).abs() < 0.1 && (blue / green - expected[1]).abs() < 0.1, "{x} {y}");
        }
        assert!(at(3, 17)[2] > 3.0 * at(3, 2)[2]);
    }

    /// The light of a photograph: its top is up in the image.
    #[test]
    fn directions_are_those_of_the_photograph() {
        let mut scene = scene();
        let towards = |position| PointLight { position, intensity: [PI * 1e6; 3] };
        scene.lights = vec![towards([1e3, 0.1, 0.0]), towards([0.0, 0.1, -1e3]), towards([0.0, 1e3, 0.0])];
        let found = std::sync::Mutex::new(vec![[0.0; 3]; 3]);
        draw(&scene, Frame { width: 1, height: 1, samples: 1 }, 1, SIZE, |light, _, _, _, direction| {
            found.lock().unwrap()[light] = direction;
            [0.0; 3]
        });
        let found = found.into_inner().unwrap();
        for (axis, direction) in found.iter().enumerate() {
            assert!(direction[axis] > 0.999, "{direction:?}");
        }
    }
}
