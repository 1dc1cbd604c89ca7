//! Tests the conversion of near lights to distant ones with generated captures.

use crate::stacks::{shiny, spiral};
use brdfc_pwt::LightSamples;
use brdfc_pwt::near::MAX_LIGHTS;
use brdfc_readers::near_lights::NearLights;
use brdfc_readers::pixels::Pixels;

const SIZE: [usize; 2] = [64, 48];

/// Lights at 1.2 widths of the images from their middle, and farther on one side.
fn positions(lights: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let position = |[x, y, z]: &[f32; 3]| [*x, *y, *z].map(|c| f64::from(c) * (1.2 + 0.2 * f64::from(*x)));
    lights.iter().map(position).collect()
}

/// Photographs under near lights: each pixel has its own direction and distance.
fn photographs(near: NearLights, lights: &[[f32; 3]], size: [usize; 2]) -> LightSamples {
    let [width, height] = size;
    let mut images = vec![vec![[0.0; 3]; width * height]; lights.len()];
    for at in 0..width * height {
        let point = [at % width, at / width].map(|k| k as f64 + 0.5);
        let pixel = shiny(size, near.directions(point));
        for (light, image) in images.iter_mut().enumerate() {
            image[at] = pixel.images[light].pixel(at).map(|c| c / near.factor(light, point));
        }
    }
    LightSamples { near: Some(near), ..LightSamples::new(size, lights.to_vec(), images) }
}

/// Root of the mean squared difference of square roots, which are nearly sRGB levels.
fn difference(a: &LightSamples, b: &LightSamples) -> f64 {
    let squares = |(a, b): (&Pixels, &Pixels)| -> f64 {
        let (a, b) = (a.clone().into_linear(), b.clone().into_linear());
        let one = |(a, b): (&f32, &f32)| f64::from(a.sqrt() - b.sqrt()).powi(2);
        a.as_flattened().iter().zip(b.as_flattened()).map(one).sum()
    };
    let sum: f64 = a.images.iter().zip(&b.images).map(squares).sum();
    (sum / (3 * a.size[0] * a.size[1] * a.images.len()) as f64).sqrt()
}

/// Converted photographs are those of distant lights; directions alone, and positions on the other side, are negative controls.
#[test]
fn near_lights_become_distant() {
    let lights = spiral(60);
    let expected = shiny(SIZE, lights.clone());
    let raw = photographs(NearLights::new(positions(&lights), SIZE), &lights, SIZE);
    let mirrored = positions(&lights).into_iter().map(|[x, y, z]| [-x, -y, z]).collect();
    let wrong = LightSamples { near: Some(NearLights::new(mirrored, SIZE)), ..raw.clone() };
    let [found, wrong] = [&raw, &wrong].map(|samples| difference(&samples.distant().unwrap(), &expected));
    let raw = difference(&raw, &expected);
    assert!(found < 0.35 * raw && wrong > raw, "{raw} {found} {wrong}");
}

/// Photographs that are fitted do not depend on those that are held out.
#[test]
fn held_out_lights_are_not_seen() {
    let lights = spiral(24);
    let samples = photographs(NearLights::new(positions(&lights), SIZE), &lights, SIZE);
    let mut other = samples.clone();
    let left_out = [3, 8, 20];
    left_out.iter().for_each(|light| other.images[*light].to_mut().iter_mut().for_each(|pixel| *pixel = [0.7; 3]));
    let [[fitted, unseen], [same, changed]] = [&samples, &other].map(|samples| samples.split(&left_out).unwrap());
    assert_eq!((fitted.lights.len(), unseen.lights[1]), (21, lights[8]));
    assert!(fitted == same && difference(&unseen, &changed) > 0.1);
    assert!(fitted.near.is_none() && unseen.near.is_none());
    // Distances stay relative to those of all lights.
    let whole = samples.distant().unwrap().without(&left_out);
    assert!(difference(&fitted, &whole) < 0.05, "{}", difference(&fitted, &whole));
}

/// Lights far away stay as they are.
#[test]
fn distant_lights_stay() {
    let lights = spiral(20);
    let far = lights.iter().map(|light| light.map(|c| 1e5 * f64::from(c))).collect();
    let samples = shiny(SIZE, lights);
    let near = LightSamples { near: Some(NearLights::new(far, SIZE)), ..samples.clone() };
    assert!(difference(&near.distant().unwrap(), &samples) < 1e-4);
    assert_eq!(*samples.distant().unwrap(), samples);
}

/// Images narrower than the grid, one light, and too many.
#[test]
fn few_pixels_and_lights() {
    let near = |count: usize, size: [usize; 2]| {
        let samples =
            LightSamples::new(size, vec![[0.0, 0.0, 1.0]; count], vec![vec![[0.5; 3]; size[0] * size[1]]; count]);
        LightSamples { near: Some(NearLights::new(vec![[0.0, 0.0, 1e5]; count], size)), ..samples }
    };
    let one = near(1, [3, 2]);
    let found = one.distant().unwrap().images[0].clone();
    assert!(found.linear(0..6).as_flattened().iter().all(|value| (value - 0.5).abs() < 1e-5), "{found:?}");
    let lights = spiral(60);
    for size in [[3, 2], [1, 1], [13, 5]] {
        let raw = photographs(NearLights::new(positions(&lights), size), &lights, size);
        let expected = shiny(size, lights.clone());
        let [found, raw] = [&raw.distant().unwrap(), &raw].map(|samples| difference(samples, &expected));
        assert!(found < 0.6 * raw, "{size:?}: {found} {raw}");
    }
    let error = near(MAX_LIGHTS + 1, [1, 1]).distant().unwrap_err();
    assert_eq!(error.to_string(), "near lights: found 401, expected at most 400");
}
