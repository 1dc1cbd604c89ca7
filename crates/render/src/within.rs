//! Pixels that need directions outside the domain of a material's pack.

use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::Hits;
use super::vector::subtract;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::{DirectionPair, dot};
use brdfc_metrics::image::LinearImage;
use rayon::prelude::*;

/// For each pixel, true if one of its samples sees a part from outside the range of its material, lit or not, or lit
/// from outside. `directions` has one range for each part.
///
/// # Panics
/// If there are fewer ranges than parts, or if the hits belong to another frame.
pub fn outside(scene: &Scene, frame: Frame, hits: &Hits, directions: &[DirectionRange]) -> Vec<bool> {
    let samples = frame.samples_per_pixel();
    assert_eq!(hits.0.len(), frame.width * frame.height * samples, "hits of this frame");
    let is_outside = |hit: &super::trace::Hit| {
        let part = &scene.parts[hit.part as usize];
        let range = directions[hit.part as usize];
        if range.is_all() {
            return false;
        }
        let point = ShadingPoint::new(part, hit, scene.camera.eye);
        if !range.view.contain(point.outgoing) {
            return true;
        }
        scene.lights.iter().any(|light| {
            let to_light = subtract(light.position, point.position);
            let incoming = point.local(to_light.map(|c| c / dot(to_light, to_light).sqrt()));
            incoming[2] > 0.0 && !range.contains(DirectionPair::new(incoming, point.outgoing))
        })
    };
    hits.0.par_chunks(samples).map(|pixel| pixel.iter().flatten().any(is_outside)).collect()
}

/// The image without these pixels, as if they showed no surface.
#[must_use]
pub fn without(mut image: LinearImage, left_out: &[bool]) -> LinearImage {
    for (pixel, _) in left_out.iter().enumerate().filter(|(_, out)| **out) {
        image.pixels[pixel] = [0.0; 3];
        image.coverage[pixel] = 0.0;
    }
    image
}

/// Share of the surface pixels that are left out.
pub fn share_left_out(hits: &Hits, frame: Frame, left_out: &[bool]) -> f64 {
    let surfaces = hits.0.chunks(frame.samples_per_pixel()).filter(|pixel| pixel.iter().any(Option::is_some)).count();
    left_out.iter().filter(|out| **out).count() as f64 / surfaces.max(1) as f64
}

/// Label of this share, empty for 0.
pub fn left_out_summary(share: f64) -> String {
    if share > 0.0 { format!(", {:.1} % left out", 100.0 * share) } else { String::new() }
}
