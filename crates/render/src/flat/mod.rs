//! Flat BTFs on the surfaces of a scene, with parallax (section 3.5 of Hadim et al. 2009).
//!
//! The surfaces of a scene are macro surfaces: each is the reference plane of the meso-geometry, bent. Directions are
//! in its local frame: tangent, bitangent and normal. One material covers all parts of a scene; their bump maps and
//! mirrors are ignored.
//!
//! Values of flat BTFs are relative to a white diffuser that faces the light: a point light of radiant intensity I at
//! distance d gives the radiance `value I / (π d²)`. The value includes the cosine.

mod border;
mod cover;
mod displaced;
mod material;
mod reference;
mod shell;
mod thumbnails;

pub use cover::{cover_wgsl, covered};
pub use material::FlatMaterial;
pub use reference::reference;
pub use thumbnails::{FlatRendering, FlatRenderings, flat_renderings};

use super::footprint::{footprint, from_behind, sample_level};
use super::sample_means::sample_means;
use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::{Caster, trace};
use super::vector::{add_scaled, subtract};
use brdfc_formats::direction::{Vector, dot};
use brdfc_metrics::image::LinearImage;
use cover::CoveredSurface;
use std::f64::consts::PI;

/// Tiles that cover the parts of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tiles {
    /// Tiles per unit of a mesh's uv.
    pub repeat: u32,
    /// Texels of a tile per side, to which mipmap levels refer.
    pub texels: usize,
}

/// Draws a scene whose parts all use one flat BTF, in the same steps as `flat_scene.wgsl`.
pub fn draw_on_cpu(scene: &Scene, frame: Frame, material: &FlatMaterial) -> LinearImage {
    let covered = material.cover(scene);
    let caster = Caster::new(&covered);
    let texels = material.decoder().parts().reflectance.size() as usize;
    let eye = covered.camera.eye;
    sample_means(&covered, frame, |pixel, sample| {
        let position = frame.sample_position(pixel, sample);
        let ray = covered.camera.ray(frame, position[0], position[1]);
        caster.all(eye, ray).iter().find_map(|hit| {
            let part = &covered.parts[hit.part as usize];
            let point = ShadingPoint::without_bump(part, hit, eye);
            let surface = CoveredSurface::new(&part.mesh, hit, &point, material.repeat());
            if surface.is_raised && from_behind(&part.mesh, hit.triangle, point.to_viewer) {
                return None;
            }
            let steps = footprint(&covered, frame, hit, position);
            let level = sample_level(steps, material.repeat(), texels, frame.samples);
            let (at, view) = (on_tiles(&point, material.repeat()), point.outgoing.map(|c| c as f32));
            let look = material.decoder().look(at, level, view, surface.flat_btf);
            if look.passes() || surface.is_outside(look.moved()) {
                return None;
            }
            let shown = moved(&point, look.offset().map(f64::from), surface.side);
            Some(reflected(&covered, shown, |light| {
                look.shaded(material.directions(), point.local(light).map(|c| c as f32))
            }))
        })
    })
}

/// Draws a scene whose parts are all covered by the same tiles. For a position in tiles, a mipmap level and a view in the
/// local frame, `look` returns the offset of what is shown there, in tiles and in that frame, and its radiance under a light
/// relative to a white diffuser that faces the light.
pub fn draw_tiles<Shade: Fn(Vector) -> [f32; 3]>(
    scene: &Scene,
    frame: Frame,
    tiles: Tiles,
    look: impl Fn([f32; 2], f32, Vector) -> (Vector, Shade) + Sync,
) -> LinearImage {
    let hits = trace(scene, frame).0;
    sample_means(scene, frame, |pixel, sample| {
        let hit = hits[pixel * frame.samples_per_pixel() + sample].as_ref()?;
        let mesh = &scene.parts[hit.part as usize].mesh;
        let point = ShadingPoint::without_bump(&scene.parts[hit.part as usize], hit, scene.camera.eye);
        let steps = footprint(scene, frame, hit, frame.sample_position(pixel, sample));
        let level = sample_level(steps, tiles.repeat, tiles.texels, frame.samples);
        let (offset, shade) = look(on_tiles(&point, tiles.repeat), level, point.outgoing);
        let side = CoveredSurface::new(mesh, hit, &point, tiles.repeat).side;
        Some(reflected(scene, moved(&point, offset, side), |light| shade(point.local(light))))
    })
}

/// Position of a point in tiles, as the shader computes it.
fn on_tiles(point: &ShadingPoint, repeat: u32) -> [f32; 2] {
    point.uv.map(|c| c as f32 * repeat as f32)
}

/// Position in world space at an offset in the local frame of a point, in tiles of this side.
fn moved(point: &ShadingPoint, offset: Vector, side: f64) -> Vector {
    add_scaled(point.position, side, point.world(offset))
}

/// Radiance towards the viewer of a position. `value` is relative radiance under a light in a direction of world space.
fn reflected(scene: &Scene, position: Vector, value: impl Fn(Vector) -> [f32; 3]) -> Vector {
    let mut radiance = [0.0; 3];
    for light in &scene.lights {
        let to_light = subtract(light.position, position);
        let squared = dot(to_light, to_light);
        if squared > 0.0 {
            let value = value(to_light.map(|c| c / squared.sqrt()));
            (0..3).for_each(|k| radiance[k] += f64::from(value[k]) * light.intensity[k] / (PI * squared));
        }
    }
    radiance
}
