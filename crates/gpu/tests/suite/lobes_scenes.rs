//! Lobes on scenes: the shader compared with the CPU, and the CPU with the integral over the environment.

use brdfc_core::address::parse_synth;
use brdfc_environment::prefilter;
use brdfc_formats::environment::EnvironmentPack;
use brdfc_formats::lobes::{Anchor, Lobe, LobesHeader, LobesPack};
use brdfc_gpu::{LobesRenderer, draw_lobes, lobes_scene_source};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_render::lobes::{IntegralMaterial, PrefilteredLight, converged_integral, draw_integral, draw_on_cpu};
use brdfc_render::scene::{Environment, Frame, Scene};
use brdfc_render::scenes::Builtin;

const FRAME: Frame = Frame { width: 64, height: 64, samples: 2 };

/// A sky with a soft sun, brighter than 1.
fn environment() -> EnvironmentPack {
    let radiance = |d: [f64; 3]| {
        let length = d.iter().map(|c| c * c).sum::<f64>().sqrt();
        let [x, y, z] = d.map(|c| c / length);
        let sun = 30.0 * ((0.6 * x + 0.64 * y + 0.48 * z - 1.0) / 0.02).exp();
        [0.3 + 0.2 * y + sun, 0.3 + 0.1 * x + 0.9 * sun, 0.4 + 0.1 * z + 0.7 * sun]
    };
    prefilter(&radiance, 32, 2, &()).unwrap()
}

/// Irradiance, a highlight and a pair around it, with weights that differ by azimuth.
fn lobes(azimuths: u32) -> LobesPack {
    let lobe = |anchor, tilt, row| Lobe { anchor, tilt, row };
    let lobes = vec![
        lobe(Anchor::Normal, [0.0, 0.0], 0),
        lobe(Anchor::Mirror, [0.05, 0.0], 1),
        lobe(Anchor::Mirror, [0.0, 0.2], 2),
        lobe(Anchor::Mirror, [0.0, -0.2], 2),
        lobe(Anchor::Viewer, [0.0, 0.0], 3),
    ];
    let weights = [
        [[0.3, 0.1, 0.05, 0.0], [0.1, 0.05, 0.02, 0.0]],
        [[0.1, 0.1, 0.1, 2.4], [0.5, 0.5, 0.5, 3.0]],
        [[0.02, 0.02, 0.02, 1.5], [0.1, 0.1, 0.1, 1.5]],
        [[0.05, 0.02, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]],
    ];
    let texel = |azimuth: u32, [r, g, b, sharpness]: [f32; 4]| {
        let factor = 1.0 + azimuth as f32;
        [factor * r, factor * g, factor * b, sharpness]
    };
    let row = |row: &[[f32; 4]; 2]| -> Vec<[f32; 4]> {
        (0..azimuths).flat_map(|azimuth| row.map(|weights| texel(azimuth, weights))).collect()
    };
    let texels: Vec<[f32; 4]> = weights.iter().flat_map(row).collect();
    LobesPack::new(LobesHeader { nodes: 2, azimuths, rows: 4, scale: 1.0, delta_e: [0.0; 2], lobes }, &texels).unwrap()
}

fn mean_delta_e(a: &LinearImage, b: &LinearImage) -> f64 {
    compare_images(a, b, auto_exposure(b)).delta_e.mean
}

#[test]
fn shader_and_cpu_draw_the_same_renderings() {
    let Some(gpu) = crate::common::gpu() else { return };
    for (builtin, azimuths) in
        [(Builtin::Sphere, 1), (Builtin::BumpyBall, 1), (Builtin::Teapot, 1), (Builtin::BumpyBall, 3)]
    {
        let (light, lobes) = (PrefilteredLight::new(environment()), lobes(azimuths));
        let scene = builtin.scene();
        let cpu = draw_on_cpu(&scene, FRAME, &light, &[Some(&lobes)]);
        let lit = cpu.pixels.iter().filter(|pixel| pixel[0] > 0.0).count();
        assert!(lit > FRAME.width * FRAME.height / 8, "{}: {lit} are lit", builtin.name());
        let shader = draw_lobes(gpu, &scene, FRAME, &light, &[Some(&lobes)]).unwrap();
        let mean = mean_delta_e(&shader, &cpu);
        println!("{}: mean ΔE {mean}", builtin.name());
        assert!(mean < 0.1, "{}: {mean}", builtin.name());
        // The controls: changes of the shader are noticed.
        for (old, new) in [
            ("lobe.weight * ", "1.1 * lobe.weight * "),
            ("lobe.direction.y * frame[1]", "-lobe.direction.x * frame[1]"),
            (
                "environment_radiance(direction, lobe.sharpness)",
                "environment_radiance(direction, lobe.sharpness - 0.5)",
            ),
        ] {
            let source = lobes_scene_source();
            assert!(source.contains(old), "{old}");
            let source = source.replace(old, new);
            let renderer = LobesRenderer::new(gpu, source, &light).unwrap();
            let loaded = renderer.load(&scene, &[Some(&lobes)]).unwrap();
            let changed = renderer.draw(&loaded, &scene.camera, FRAME).unwrap();
            assert!(mean_delta_e(&changed, &cpu) > 0.3, "{}: {new}", builtin.name());
        }
    }
}

/// A scene of several parts, one without lobes, one below a mirror.
#[test]
fn parts_have_lobes_of_their_own() {
    let Some(gpu) = crate::common::gpu() else { return };
    let scene = Builtin::Table.scene();
    let mirror = scene.parts.iter().position(|part| part.surface.mirror > 0.0).unwrap();
    let plain = scene.parts.iter().position(|part| part.surface.mirror == 0.0).unwrap();
    let light = PrefilteredLight::new(environment());
    let (isotropic, anisotropic) = (lobes(1), lobes(3));
    let mut packs: Vec<Option<&LobesPack>> = vec![Some(&isotropic); scene.parts.len()];
    packs[plain] = None;
    packs[mirror] = Some(&anisotropic);
    let cpu = draw_on_cpu(&scene, FRAME, &light, &packs);
    let mean = mean_delta_e(&draw_lobes(gpu, &scene, FRAME, &light, &packs).unwrap(), &cpu);
    assert!(mean < 0.1, "{mean}");
    // The controls: other lobes on one part, and no mirror, are noticed.
    let differs = |scene: &Scene, packs: &[Option<&LobesPack>]| {
        mean_delta_e(&draw_lobes(gpu, scene, FRAME, &light, packs).unwrap(), &cpu) > 0.2
    };
    let mut others = packs.clone();
    others[plain] = Some(&isotropic);
    assert!(differs(&scene, &others));
    others = packs.clone();
    others[mirror] = Some(&isotropic);
    assert!(differs(&scene, &others));
    let mut without = scene.clone();
    without.parts[mirror].surface.mirror = 0.0;
    assert!(differs(&without, &packs));
}

/// A white Lambert surface in uniform light looks like the light, by lobes and by the integral.
#[test]
fn a_white_furnace_is_invisible() {
    let uniform = prefilter(&|_| [0.7; 3], 16, 1, &()).unwrap();
    let lobe = Lobe { anchor: Anchor::Normal, tilt: [0.0; 2], row: 0 };
    let header = LobesHeader { nodes: 2, azimuths: 1, rows: 1, scale: 1.0, delta_e: [0.0; 2], lobes: vec![lobe] };
    let white = LobesPack::new(header, &[[1.0, 1.0, 1.0, 0.0]; 2]).unwrap();
    let light = PrefilteredLight::new(uniform);
    let scene = Scene { environment: Environment::of(4, 2, |_| [0.7; 3]), ..Builtin::Sphere.scene() };
    let by_lobes = draw_on_cpu(&scene, FRAME, &light, &[Some(&white)]);
    let source = parse_synth("synth:lambert?kd=1").unwrap();
    let material = IntegralMaterial::new(source.as_ref()).unwrap();
    let integral = draw_integral(&scene, FRAME, &[Some(&material)], 1024).image;
    let surface = |image: &LinearImage| {
        image.pixels.iter().zip(&image.coverage).filter(|(_, c)| **c == 1.0).map(|(p, _)| p[0]).collect::<Vec<_>>()
    };
    assert!(surface(&by_lobes).len() > 500);
    assert!(surface(&by_lobes).iter().all(|value| (value / 0.7 - 1.0).abs() < 2e-3));
    assert!(surface(&integral).iter().all(|value| (value / 0.7 - 1.0).abs() < 0.03));
}

/// The noise that an integral states is the difference from one with 64 times as many directions.
#[test]
fn an_integral_states_its_noise() {
    let uneven = |direction: [f64; 3]| if direction[1] > 0.8 { [9.0, 7.0, 5.0] } else { [0.4, 0.5, 0.6] };
    let environment = Environment::of(64, 32, |direction| uneven(direction).map(|c| c as f32));
    let scene = Scene { environment, ..Builtin::Sphere.scene() };
    let source = parse_synth("synth:ggx?kd=0.2&f0=0.5&alpha=0.2").unwrap();
    let material = IntegralMaterial::new(source.as_ref()).unwrap();
    let drawn = |directions| draw_integral(&scene, FRAME, &[Some(&material)], directions);
    let (rough, fine) = (drawn(128), drawn(8192));
    let exposure = auto_exposure(&fine.image);
    let stated = rough.noise(exposure).delta_e.mean;
    let found = compare_images(&rough.image, &fine.image, exposure).delta_e.mean;
    assert!(stated > 0.2 && (0.9..1.1).contains(&(stated / found)), "stated {stated}, found {found}");
    // The control: a half alone has more.
    let half = compare_images(&rough.half, &fine.image, exposure).delta_e.mean;
    assert!(half > 1.2 * found, "half {half}, mean {found}");
    // A rendering that differs little gets a better reference, one that differs much the first one.
    let against = |image| converged_integral(&scene, FRAME, &[Some(&material)], image).noise(exposure).delta_e.mean;
    let noise = against(&fine.image);
    assert!(noise < 0.6 * stated, "{noise}");
    let black = LinearImage { pixels: vec![[0.0; 3]; fine.image.pixels.len()], ..fine.image.clone() };
    assert!(against(&black) > 1.5 * noise);
}
