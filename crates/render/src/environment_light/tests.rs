use super::*;
use crate::environment_sampler::{EnvironmentSampler, FramedEnvironmentSampler};
use crate::lobe_sampler::{BalancedSampler, CosineSampler};
use crate::scene::Camera;
use crate::shade::SourceReflectance;
use crate::testing::{plain_scene, quad};
use crate::trace::Hit;
use brdfc_core::address::parse_synth;

/// A point whose normal is between all axes.
fn point() -> ShadingPoint {
    let mut scene = plain_scene(quad(2.0, 0.0), CAMERA);
    let up = 1.0 / 3f32.sqrt();
    for vertex in &mut scene.parts[0].mesh.vertices {
        vertex.normal = [up; 3];
        vertex.tangent = [0.5f32.sqrt(), -(0.5f32.sqrt()), 0.0];
    }
    ShadingPoint::new(&scene.parts[0], &Hit { part: 0, triangle: 0, barycentric: [0.3, 0.3] }, CAMERA.eye)
}

const CAMERA: Camera = Camera { eye: [2.0, 0.5, 3.0], target: [0.0; 3], up: [0.0, 1.0, 0.0], field_of_view: 20.0 };

struct Lambert([f64; 3]);

impl Reflectance for Lambert {
    fn eval(&self, _: DirectionPair, _: f64) -> [f64; 3] {
        self.0.map(|albedo| albedo / PI)
    }
}

/// The control: the cosine is divided out again.
struct WithoutCosine<'a>(&'a dyn Reflectance);

impl Reflectance for WithoutCosine<'_> {
    fn eval(&self, pair: DirectionPair, distance: f64) -> [f64; 3] {
        self.0.eval(pair, distance).map(|f| f / pair.incoming[2])
    }
}

fn plain(radiance: f32) -> Environment {
    Environment { width: 16, height: 8, pixels: vec![[radiance; 3]; 128] }
}

/// Dim colours, and two small sources thousands of times as bright.
fn lamps() -> Environment {
    let (width, height) = (64, 32);
    let mut pixels: Vec<[f32; 3]> =
        (0..width * height).map(|i| [0.1 + 0.05 * (i % 7) as f32, 0.2, 0.1 + 0.002 * (i / width) as f32]).collect();
    pixels[6 * width + 9] = [900.0, 700.0, 500.0];
    pixels[11 * width + 62] = [200.0, 300.0, 600.0];
    Environment { width, height, pixels }
}

fn framed<'a>(environment: &'a EnvironmentSampler, point: &'a ShadingPoint) -> FramedEnvironmentSampler<'a> {
    FramedEnvironmentSampler { environment, point, shift: [0.0; 2] }
}

#[test]
fn a_matte_surface_in_a_constant_environment_has_its_albedo() {
    let (point, environment, albedo) = (point(), plain(2.5), [0.2, 0.5, 0.8]);
    let light = EnvironmentSampler::new(&environment);
    let framed = framed(&light, &point);
    let both = BalancedSampler { first: &CosineSampler::default(), second: &framed };
    let samplers: [(&dyn LobeSampler, f64); 3] = [(&CosineSampler::default(), 1e-9), (&framed, 5e-3), (&both, 5e-3)];
    for (sampler, tolerance) in samplers {
        let found = reflected(&point, &environment, &Lambert(albedo), sampler, 8192);
        for k in 0..3 {
            let error = (found.radiance[k] / (2.5 * albedo[k]) - 1.0).abs();
            assert!(error < tolerance, "{found:?}");
            assert!(error * 2.5 * albedo[k] < 4.0 * found.error[k] + 1e-9, "{found:?}");
        }
        // The control: without the cosine it is twice as much.
        let wrong = reflected(&point, &environment, &WithoutCosine(&Lambert(albedo)), &framed, 8192);
        assert!((wrong.radiance[0] / (2.5 * albedo[0]) - 2.0).abs() < 0.02, "{wrong:?}");
    }
    let sum = quadrature(&point, &environment, &Lambert(albedo), 16);
    assert!((sum[1] / (2.5 * albedo[1]) - 1.0).abs() < 1e-3, "{sum:?}");
}

/// The bilinear look-up turns a texel into a tent, `∫ tent sin θ dθ dφ = sin θ 2 (1 - cos Δθ) / Δθ Δφ`.
#[test]
fn a_single_bright_texel_is_one_term() {
    let point = point();
    let (width, height) = (256, 128);
    let material = parse_synth("synth:ward?kd=0.3,0.1,0.05&ks=0.1&ax=0.4&ay=0.6").unwrap();
    let material = SourceReflectance(material.as_ref());
    for (row, column) in [(30, 40), (50, 20), (20, 90)] {
        let mut pixels = vec![[0.0; 3]; width * height];
        pixels[row * width + column] = [10.0, 20.0, 30.0];
        let environment = Environment { width, height, pixels };
        let (step, around) = (PI / height as f64, TAU / width as f64);
        let (theta, phi) = (step * (row as f64 + 0.5), around * (column as f64 + 0.5));
        let direction = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()];
        let incoming = point.local(direction);
        assert!(incoming[2] > 0.1);
        let solid_angle = theta.sin() * 2.0 * (1.0 - step.cos()) / step * around;
        let f_r = material.eval(DirectionPair::new(incoming, point.outgoing), point.distance);
        let expected = [0, 1, 2].map(|k| f_r[k] * incoming[2] * solid_angle * 10.0 * (k + 1) as f64);

        let light = EnvironmentSampler::new(&environment);
        let found = reflected(&point, &environment, &material, &framed(&light, &point), 4096);
        let close = |found: Vector, tolerance: f64| (0..3).all(|k| (found[k] / expected[k] - 1.0).abs() < tolerance);
        assert!(close(found.radiance, 3e-3), "{found:?} {expected:?}");
        assert!(close(quadrature(&point, &environment, &material, 4), 2e-2));
        // The control: a cosine more or less.
        let wrong = reflected(&point, &environment, &WithoutCosine(&material), &framed(&light, &point), 4096);
        assert!(!close(wrong.radiance, 3e-3), "{wrong:?}");
    }
}

#[test]
fn samples_agree_with_the_sum_over_texels_within_their_error() {
    let (point, environment) = (point(), lamps());
    let light = EnvironmentSampler::new(&environment);
    let framed = framed(&light, &point);
    let both = BalancedSampler { first: &CosineSampler::default(), second: &framed };
    for address in
        ["synth:lambert?kd=0.5", "synth:ward?kd=0.1&ks=0.3&ax=0.15&ay=0.15", "synth:lewis?kd=0.1&ks=0.3&n=30"]
    {
        let material = parse_synth(address).unwrap();
        let material = SourceReflectance(material.as_ref());
        let expected = quadrature(&point, &environment, &material, 16);
        let coarse = quadrature(&point, &environment, &material, 8);
        let found = reflected(&point, &environment, &material, &both, 1 << 14);
        let by_cosine = reflected(&point, &environment, &material, &CosineSampler::default(), 1 << 14);
        for k in 0..3 {
            let left = (expected[k] - coarse[k]).abs();
            let error = (found.radiance[k] - expected[k]).abs();
            assert!(error < 3.0 * found.error[k] + left, "{address}: {found:?} {expected:?} {coarse:?}");
            assert!(found.error[k] < 0.01 * expected[k], "{address}: {found:?}");
            // Small sources are the reason to sample the light, too.
            assert!(by_cosine.error[k] > 3.0 * found.error[k], "{address}: {by_cosine:?} {found:?}");
            let wrong = reflected(&point, &environment, &WithoutCosine(&material), &both, 1 << 14);
            assert!((wrong.radiance[k] - expected[k]).abs() > 10.0 * found.error[k], "{address}: {wrong:?}");
        }
    }
}
