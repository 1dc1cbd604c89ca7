//! Tests the conversion of near lights to distant ones with generated captures.

use crate::stacks::{shiny, spiral};
use brdfc_pwt::LightSamples;
use brdfc_pwt::near::{MAX_LIGHTS, distant};
use brdfc_readers::near_lights::NearLights;
use brdfc_readers::pixels::Pixels;

const SIZE: [usize; 2] = [64, 48];

/// Lights at 1.2 widths of the images from their middle, and farther on one side.
fn positions(lights: &[[f32; 3]]) -> Vec<[f64; 3]> {
    let position = |[x, y, z]: &[f32; 3]| [*x, *y, *z].map(|c| f64::from(c) * (1.2 + 0.2 * f64::from(*x)));
    lights.iter().map(position).collect()
}

/// Photographs under near lights: each pixel has its own direction and distance.
fn photographs(near: &NearLights, lights: &[[f32; 3]]) -> LightSamples {
    let [width, height] = SIZE;
    let mut images = vec![vec![[0.0; 3]; width * height]; lights.len()];
    for at in 0..width * height {
        let seen = near.directions([(at % width) as f64 + 0.5, (at / width) as f64 + 0.5]);
        let pixel = shiny(SIZE, seen);
        for (light, image) in images.iter_mut().enumerate() {
            let factor = near.factors(light, at / width).nth(at % width).unwrap();
            image[at] = pixel.images[light].pixel(at).map(|c| c / factor);
        }
    }
    LightSamples::new(SIZE, lights.to_vec(), images)
}

/// Root of the mean squared difference of square roots, which are nearly sRGB levels.
fn difference(a: &LightSamples, b: &LightSamples) -> f64 {
    let squares = |(a, b): (&Pixels, &Pixels)| -> f64 {
        let (a, b) = (a.clone().into_linear(), b.clone().into_linear());
        let one = |(a, b): (&f32, &f32)| f64::from(a.sqrt() - b.sqrt()).powi(2);
        a.as_flattened().iter().zip(b.as_flattened()).map(one).sum()
    };
    let sum: f64 = a.images.iter().zip(&b.images).map(squares).sum();
    (sum / (3 * SIZE[0] * SIZE[1] * a.images.len()) as f64).sqrt()
}

fn at_mean_distance(samples: &LightSamples, near: &NearLights) -> LightSamples {
    let images = samples.images.iter().enumerate().map(|(light, image)| near.at_mean_distance(light, image.clone()));
    LightSamples { images: images.collect(), ..samples.clone() }
}

/// Converted photographs are those of distant lights; distances alone, and positions on the other side, are negative controls.
#[test]
fn near_lights_become_distant() {
    let lights = spiral(60);
    let near = NearLights::new(positions(&lights), SIZE);
    let expected = shiny(SIZE, lights.clone());
    let raw = photographs(&near, &lights);
    let even = at_mean_distance(&raw, &near);
    let found = distant(&even, &near).unwrap();
    let mirrored = NearLights::new(positions(&lights).into_iter().map(|[x, y, z]| [-x, -y, z]).collect(), SIZE);
    let wrong = distant(&even, &mirrored).unwrap();
    let [raw, even, found, wrong] = [&raw, &even, &found, &wrong].map(|samples| difference(samples, &expected));
    println!("{raw} {even} {found} {wrong}");
    assert!(even < 0.9 * raw && found < 0.6 * even && wrong > even, "{raw} {even} {found} {wrong}");
}

/// Lights far away stay as they are.
#[test]
fn distant_lights_stay() {
    let lights = spiral(20);
    let far = lights.iter().map(|light| light.map(|c| 1e5 * f64::from(c))).collect();
    let near = NearLights::new(far, SIZE);
    let samples = shiny(SIZE, lights);
    let found = distant(&at_mean_distance(&samples, &near), &near).unwrap();
    assert!(difference(&found, &samples) < 1e-4);
}

/// Images narrower than the grid, one light, and too many.
#[test]
fn few_pixels_and_lights() {
    let one = LightSamples::new([3, 2], vec![[0.0, 0.0, 1.0]], vec![vec![[0.5; 3]; 6]]);
    let found = distant(&one, &NearLights::new(vec![[0.0, 0.0, 1.0]], [3, 2])).unwrap();
    assert!(found.images[0].linear(0..6).as_flattened().iter().all(|value| (value - 0.5).abs() < 1e-5));
    let count = MAX_LIGHTS + 1;
    let many = LightSamples::new([1, 1], vec![[0.0, 0.0, 1.0]; count], vec![vec![[0.5; 3]]; count]);
    let error = distant(&many, &NearLights::new(vec![[0.0, 0.0, 1.0]; count], [1, 1])).unwrap_err();
    assert_eq!(error.to_string(), "near lights: found 401, expected at most 400");
}
