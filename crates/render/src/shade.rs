//! Shading on the CPU: the reference that the shader's images are compared with. `scene.wgsl` performs the same steps.

use super::sample_means::sample_means;
use super::scene::{Frame, PointLight, Scene, Surface};
use super::shading_point::ShadingPoint;
use super::trace::{Hit, Hits};
use super::vector::{add_scaled, subtract};
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, dot};
use brdfc_metrics::image::LinearImage;

/// Source of `f_r` for shading.
pub trait Reflectance: Sync {
    /// `f_r`, linear RGB, 1/sr, not negative. `distance` is the distance of the viewer.
    fn eval(&self, pair: DirectionPair, distance: f64) -> [f64; 3];
}

/// An unmodified source at every distance. Negative values of interpolated measurements count as 0.
pub struct SourceReflectance<'a>(pub &'a dyn Source);

impl Reflectance for SourceReflectance<'_> {
    fn eval(&self, pair: DirectionPair, _: f64) -> [f64; 3] {
        self.0.eval(pair, &mut Tally::default()).map(|f| f.max(0.0))
    }
}

/// A material whose tangent is turned by 90 degrees. It looks the same only if the material is isotropic.
pub struct Turned<'a>(pub &'a dyn Reflectance);

impl Reflectance for Turned<'_> {
    fn eval(&self, DirectionPair { incoming, outgoing }: DirectionPair, distance: f64) -> [f64; 3] {
        let turned = |[x, y, z]: Vector| [y, -x, z];
        self.0.eval(DirectionPair::new(turned(incoming), turned(outgoing)), distance)
    }
}

/// Shades hits, with one material for each part. Values of a pixel are the mean over its samples.
///
/// # Panics
/// If there are fewer materials than parts, or if the hits belong to another frame.
pub fn shade(scene: &Scene, frame: Frame, hits: &Hits, materials: &[&dyn Reflectance]) -> LinearImage {
    let samples = frame.samples_per_pixel();
    assert_eq!(hits.0.len(), frame.width * frame.height * samples, "hits of this frame");
    assert!(materials.len() >= scene.parts.len(), "one material for each part");
    sample_means(scene, frame, |pixel, sample| {
        let hit = hits.0[pixel * samples + sample].as_ref()?;
        let part = hit.part as usize;
        let point = ShadingPoint::new(&scene.parts[part], hit, scene.camera.eye);
        Some(reflected(scene, &scene.parts[part].surface, &point, materials[part]))
    })
}

/// Shades as [`shade`] does, but computes light only at the vertices and interpolates it across triangles (Gouraud 1971), as
/// hardware without pixel shaders did.
///
/// # Panics
/// If there are fewer materials than parts, or if the hits belong to another frame.
pub fn shade_by_vertex(scene: &Scene, frame: Frame, hits: &Hits, materials: &[&dyn Reflectance]) -> LinearImage {
    let samples = frame.samples_per_pixel();
    assert_eq!(hits.0.len(), frame.width * frame.height * samples, "hits of this frame");
    assert!(materials.len() >= scene.parts.len(), "one material for each part");
    sample_means(scene, frame, |pixel, sample| {
        let hit = hits.0[pixel * samples + sample].as_ref()?;
        let part = &scene.parts[hit.part as usize];
        let corners = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]].map(|barycentric| {
            let point = ShadingPoint::new(part, &Hit { barycentric, ..*hit }, scene.camera.eye);
            reflected(scene, &part.surface, &point, materials[hit.part as usize])
        });
        let [u, v] = hit.barycentric.map(f64::from);
        Some([0, 1, 2].map(|k| (1.0 - u - v) * corners[0][k] + u * corners[1][k] + v * corners[2][k]))
    })
}

/// Radiance towards the viewer: lights, and a share of the mirrored environment.
fn reflected(scene: &Scene, surface: &Surface, point: &ShadingPoint, material: &dyn Reflectance) -> Vector {
    let mut radiance = [0.0; 3];
    for light in &scene.lights {
        let added = from_light(light, point, material);
        (0..3).for_each(|channel| radiance[channel] += added[channel]);
    }
    let fresnel = mirror_share(surface, point.outgoing[2]);
    if fresnel > 0.0 {
        let environment = scene.environment.at(mirrored(point));
        (0..3).for_each(|channel| {
            radiance[channel] = (1.0 - fresnel) * radiance[channel] + fresnel * environment[channel];
        });
    }
    radiance
}

/// Share of the light of a mirror direction that the mirror of a surface reflects, by the cosine of the view angle (Schlick
/// 1994). The material below it gets the rest.
pub(super) fn mirror_share(surface: &Surface, cosine: f64) -> f64 {
    let mirror = f64::from(surface.mirror);
    if mirror > 0.0 { mirror + (1.0 - mirror) * (1.0 - cosine).powi(5) } else { 0.0 }
}

/// One term of equation 1 of Claustres et al. 2007: `f_r I cos θi / |x - x_light|²`.
fn from_light(light: &PointLight, point: &ShadingPoint, material: &dyn Reflectance) -> Vector {
    let to_light = subtract(light.position, point.position);
    let distance_squared = dot(to_light, to_light);
    let incoming = point.local(to_light.map(|c| c / distance_squared.sqrt()));
    // A light in the surface itself has no direction.
    if incoming[2] <= 0.0 || incoming[2].is_nan() {
        return [0.0; 3];
    }
    let f_r = material.eval(DirectionPair::new(incoming, point.outgoing), point.distance);
    [0, 1, 2].map(|channel| f_r[channel] * light.intensity[channel] * incoming[2] / distance_squared)
}

/// Direction of the mirror reflection.
fn mirrored(point: &ShadingPoint) -> Vector {
    let twice = 2.0 * dot(point.normal, point.to_viewer);
    add_scaled(point.to_viewer.map(|c| -c), twice, point.normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, HeightMap};
    use crate::testing::{plain_scene, quad};
    use crate::trace::trace;
    use std::f64::consts::PI;

    const FRAME: Frame = Frame { width: 21, height: 15, samples: 1 };
    const CAMERA: Camera = Camera { eye: [0.4, -0.3, 4.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 25.0 };

    struct Lambert([f64; 3]);

    impl Reflectance for Lambert {
        fn eval(&self, _: DirectionPair, _: f64) -> [f64; 3] {
            self.0.map(|albedo| albedo / PI)
        }
    }

    /// Reflects only along the tangent.
    struct Brushed;

    impl Reflectance for Brushed {
        fn eval(&self, pair: DirectionPair, _: f64) -> [f64; 3] {
            [pair.incoming[0].powi(2), pair.outgoing[0].powi(2), pair.incoming[0] * pair.outgoing[0]]
        }
    }

    #[test]
    fn a_turned_tangent_lies_across() {
        let pair = DirectionPair::new([0.6, 0.0, 0.8], [0.28, 0.96, 0.0]);
        assert_eq!(Turned(&Brushed).eval(pair, 1.0), [0.0, 0.96 * 0.96, 0.0]);
        assert_eq!(Turned(&Turned(&Brushed)).eval(pair, 1.0), Brushed.eval(pair, 1.0));
        let plain = Lambert([0.5; 3]);
        assert_eq!(image(&lit(), &Turned(&plain)).pixels, image(&lit(), &plain).pixels);
        assert_ne!(image(&lit(), &Turned(&Brushed)).pixels, image(&lit(), &Brushed).pixels);
    }

    fn lit() -> Scene {
        let light = PointLight { position: [0.5, 1.0, 2.0], intensity: [3.0, 2.0, 1.0] };
        Scene { lights: vec![light], ..plain_scene(quad(4.0, 0.0), CAMERA) }
    }

    /// Point where the pixel's ray meets the plane z = 0.
    fn on_plane(pixel: usize) -> Vector {
        let [x, y] = FRAME.sample_position(pixel, 0);
        let d = CAMERA.ray(FRAME, x, y);
        add_scaled(CAMERA.eye, -CAMERA.eye[2] / d[2], d)
    }

    fn image(scene: &Scene, material: &dyn Reflectance) -> LinearImage {
        shade(scene, FRAME, &trace(scene, FRAME), &[material])
    }

    #[test]
    fn light_of_vertices_is_interpolated() {
        let (scene, lambert) = (lit(), Lambert([0.5; 3]));
        let hits = trace(&scene, FRAME);
        let vertex = shade_by_vertex(&scene, FRAME, &hits, &[&lambert]);
        let at_corner = |x: f64, y: f64| {
            let to_light = [0.5 - x, 1.0 - y, 2.0];
            let squared = dot(to_light, to_light);
            [3.0, 2.0, 1.0].map(|intensity| 0.5 / PI * intensity * 2.0 / (squared * squared.sqrt()))
        };
        let [a, b, c, d] = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]].map(|[x, y]| at_corner(x, y));
        let expected = |pixel: usize| {
            let [x, y] = [0, 1].map(|k| 0.25 * (on_plane(pixel)[k] + 2.0));
            // Triangles below and above the diagonal.
            if y <= x {
                [0, 1, 2].map(|k| (1.0 - x) * a[k] + (x - y) * b[k] + y * c[k])
            } else {
                [0, 1, 2].map(|k| (1.0 - y) * a[k] + x * c[k] + (y - x) * d[k])
            }
        };
        assert!(largest_error(&vertex, expected) < 1e-5);
        // Light of pixels has its maximum below the light.
        assert!(largest_error(&shade(&scene, FRAME, &hits, &[&lambert]), expected) > 0.05);
    }

    fn largest_error(image: &LinearImage, expected: impl Fn(usize) -> Vector) -> f64 {
        let error = |(pixel, value): (usize, &[f32; 3])| {
            let expected = expected(pixel);
            (0..3).map(|k| (f64::from(value[k]) - expected[k]).abs() / expected[k].abs()).fold(0.0, f64::max)
        };
        image.pixels.iter().enumerate().map(error).fold(0.0, f64::max)
    }

    #[test]
    fn a_matte_plane_under_a_point_light() {
        let scene = lit();
        let albedo = [0.2, 0.5, 0.8];
        let drawn = image(&scene, &Lambert(albedo));
        let equation = |exponent: i32| {
            let scene = &scene;
            move |pixel: usize| -> Vector {
                let r = subtract(scene.lights[0].position, on_plane(pixel));
                let distance = dot(r, r).sqrt();
                let share = r[2] / distance / distance.powi(exponent);
                [0, 1, 2].map(|k| albedo[k] / PI * scene.lights[0].intensity[k] * share)
            }
        };
        assert!(largest_error(&drawn, equation(2)) < 1e-5);
        // The controls: another fall-off, another light.
        assert!(largest_error(&drawn, equation(1)) > 0.1);
        let mut moved = scene.clone();
        moved.lights[0].position[0] += 0.3;
        assert!(largest_error(&image(&moved, &Lambert(albedo)), equation(2)) > 0.01);
    }

    #[test]
    fn light_adds_up() {
        let mut scene = lit();
        let one = image(&scene, &Lambert([0.5; 3]));
        scene.lights.push(scene.lights[0]);
        let two = image(&scene, &Lambert([0.5; 3]));
        assert!(one.pixels.iter().zip(&two.pixels).all(|(a, b)| (2.0 * a[1] - b[1]).abs() < 1e-6));
    }

    #[test]
    fn the_back_of_a_sheet_is_lit_from_its_own_side() {
        let scene = lit();
        let mut behind = scene.clone();
        behind.camera.eye[2] = -4.0;
        let dark = image(&behind, &Lambert([0.5; 3]));
        assert!(dark.pixels.iter().all(|p| *p == [0.0; 3]));
        behind.lights[0].position[2] = -2.0;
        let lit = image(&behind, &Lambert([0.5; 3]));
        assert!(lit.pixels.iter().all(|p| p[0] > 0.0));
    }

    #[test]
    fn a_mirror_in_a_white_furnace_is_white() {
        let mut scene = plain_scene(quad(4.0, 0.0), CAMERA);
        scene.parts[0].surface.mirror = 1.0;
        let drawn = image(&scene, &Lambert([0.0; 3]));
        assert!(drawn.pixels.iter().all(|p| p.iter().all(|c| (c - 1.0).abs() < 1e-6)));
        scene.parts[0].surface.mirror = 0.5;
        let half = image(&scene, &Lambert([0.0; 3]));
        assert!(half.pixels.iter().all(|p| (0.49..0.51).contains(&p[0])));
    }

    #[test]
    fn the_mean_of_samples_and_their_coverage() {
        // A mirror in a white furnace is white.
        let mut scene = plain_scene(quad(0.5, 0.0), CAMERA);
        scene.parts[0].surface.mirror = 1.0;
        let frame = Frame { samples: 3, ..FRAME };
        let drawn = shade(&scene, frame, &trace(&scene, frame), &[&Lambert([0.5; 3])]);
        let partly = drawn.coverage.iter().filter(|c| **c > 0.0 && **c < 1.0).count();
        assert!(partly > 0);
        for (pixel, coverage) in drawn.pixels.iter().zip(&drawn.coverage) {
            assert!((pixel[0] - coverage).abs() < 1e-6, "{pixel:?} {coverage}");
        }
    }

    #[test]
    fn a_slope_turns_the_normal() {
        let mut scene = lit();
        let size = 64;
        // A ramp of slope 0.5 along u, cut off where the map repeats.
        let heights = (0..size * size).map(|i| 0.5 * (i % size) as f32 / size as f32).collect();
        scene.parts[0].surface.bump = Some(HeightMap { size, heights });
        let drawn = image(&scene, &Lambert([1.0; 3]));
        let normal = [-0.5 / 1.25f64.sqrt(), 0.0, 1.0 / 1.25f64.sqrt()];
        let middle = FRAME.width * (FRAME.height / 2) + FRAME.width / 2;
        let r = subtract(scene.lights[0].position, on_plane(middle));
        let expected = dot(r, normal) / dot(r, r).powf(1.5) * scene.lights[0].intensity[0] / PI;
        assert!((f64::from(drawn.pixels[middle][0]) - expected).abs() < 1e-4 * expected, "{:?}", drawn.pixels[middle]);
    }

    #[test]
    fn threads_do_not_matter() {
        let scene = lit();
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| image(&scene, &Lambert([0.3; 3])))
        };
        assert_eq!(run(1), run(4));
    }
}
