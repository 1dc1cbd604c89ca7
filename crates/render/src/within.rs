//! Which pixels ask materials for directions that their packs were not made for.

use super::scene::{Frame, Scene};
use super::shading_point::ShadingPoint;
use super::trace::Hits;
use super::vector::subtract;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::direction::{DirectionPair, dot};
use brdfc_metrics::image::LinearImage;
use rayon::prelude::*;

/// Of each pixel, whether a sample of it sees a part that is seen from outside the range of its material, be it lit or not, or
/// lit from there; `directions` has one range for each part.
///
/// # Panics
/// If there are fewer ranges than parts, or hits of another frame.
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

/// The rendering without these pixels: as if there were no surface.
#[must_use]
pub fn without(mut image: LinearImage, left_out: &[bool]) -> LinearImage {
    for (pixel, _) in left_out.iter().enumerate().filter(|(_, out)| **out) {
        image.pixels[pixel] = [0.0; 3];
        image.coverage[pixel] = 0.0;
    }
    image
}

/// Share of the pixels that show a surface which are left out.
pub fn share_left_out(hits: &Hits, frame: Frame, left_out: &[bool]) -> f64 {
    let surfaces = hits.0.chunks(frame.samples_per_pixel()).filter(|pixel| pixel.iter().any(Option::is_some)).count();
    left_out.iter().filter(|out| **out).count() as f64 / surfaces.max(1) as f64
}

/// What a label says of it; nothing where nothing is left out.
pub fn left_out_in_words(share: f64) -> String {
    if share > 0.0 { format!(", {:.1} % left out", 100.0 * share) } else { String::new() }
}
