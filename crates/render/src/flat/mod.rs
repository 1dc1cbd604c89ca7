//! Flat BTFs on the surfaces of a scene, with parallax (section 3.5 of Hadim et al. 2009).
//!
//! The surfaces of a scene are macro surfaces: each is the reference plane of the meso-geometry, bent. Directions are
//! in its local frame: tangent, bitangent and normal. A light below its horizon contributes nothing. One material
//! covers all parts of a scene; their bump maps and mirrors are ignored.
//!
//! Values of flat BTFs are relative to a white diffuser that faces the light: a point light of radiant intensity I at
//! distance d gives the radiance `value I / (π d²)`. The value includes the cosine.

mod material;
mod reference;
mod thumbnails;

pub use material::FlatMaterial;
pub use reference::reference_plane;
pub use thumbnails::{FlatRendering, FlatRenderings, flat_renderings};

use super::footprint::{footprint, sample_level};
use super::sample_means::sample_means;
use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::trace;
use super::vector::subtract;
use brdfc_formats::direction::{Vector, dot};
use brdfc_metrics::image::LinearImage;
use std::f64::consts::PI;

/// Draws a scene whose parts all use one flat BTF, in the same steps as `flat_scene.wgsl`.
pub fn draw_on_cpu(scene: &Scene, frame: Frame, material: &FlatMaterial) -> LinearImage {
    let hits = trace(scene, frame).0;
    let size = material.decoder().parts().reflectance.header().size as usize;
    sample_means(scene, frame, |pixel, sample| {
        let hit = hits[pixel * frame.samples_per_pixel() + sample].as_ref()?;
        let point = ShadingPoint::without_bump(&scene.parts[hit.part as usize], hit, scene.camera.eye);
        let steps = footprint(scene, frame, hit, frame.sample_position(pixel, sample));
        let level = sample_level(steps, material.repeat(), size, frame.samples);
        Some(reflected(scene, &point, material, level))
    })
}

/// Radiance towards the viewer of texels of a mipmap level.
fn reflected(scene: &Scene, point: &ShadingPoint, material: &FlatMaterial, level: f32) -> Vector {
    let mut radiance = [0.0; 3];
    for light in &scene.lights {
        let to_light = subtract(light.position, point.position);
        let squared = dot(to_light, to_light);
        let incoming = point.local(to_light.map(|c| c / squared.sqrt()));
        if incoming[2] <= 0.0 || incoming[2].is_nan() {
            continue;
        }
        let value = material.value(point.uv, level, point.outgoing, incoming);
        (0..3).for_each(|k| radiance[k] += f64::from(value[k]) * light.intensity[k] / (PI * squared));
    }
    radiance
}
