//! Generated RTI captures.

use brdfc_pwt::LightSamples;

/// Lights on a spiral from the pole to near the horizon, computed without trigonometry: successive lights turn by an
/// angle of the 3-4-5 triangle.
pub fn spiral(count: usize) -> Vec<[f32; 3]> {
    let mut turn = [1.0f64, 0.0];
    let light = |k: usize| {
        let z = 1.0 - 0.9 * (k as f64 + 0.5) / count as f64;
        let r = (1.0 - z * z).sqrt();
        // (-0.8 + 0.6 i): about 143 degrees.
        turn = [-0.8 * turn[0] - 0.6 * turn[1], 0.6 * turn[0] - 0.8 * turn[1]];
        [r * turn[0], r * turn[1], z].map(|c| c as f32)
    };
    (0..count).map(light).collect()
}

/// Slopes of a relief at a pixel: smooth, periodic over the image, -0.5 to 0.5.
fn slopes([x, y]: [usize; 2], [width, height]: [usize; 2]) -> [f32; 2] {
    // A parabola for each half period: continuous, like a sine.
    let wave = |k: usize, n: usize| {
        let t = 2.0 * ((k as f32 + 0.5) / n as f32).fract() - 1.0;
        2.0 * t * (1.0 - t.abs())
    };
    [wave(x, width), wave(3 * y + x, height)]
}

fn stack(
    size: [usize; 2],
    lights: Vec<[f32; 3]>,
    repeats: bool,
    value: impl Fn([usize; 2], [f32; 3]) -> [f32; 3],
) -> LightSamples {
    let at = |k: usize| [k % size[0], k / size[0]];
    let image = |light: &[f32; 3]| (0..size[0] * size[1]).map(|k| value(at(k), *light)).collect();
    let images: Vec<Vec<[f32; 3]>> = lights.iter().map(image).collect();
    LightSamples { repeats, ..LightSamples::new(size, lights, images) }
}

/// A relief whose values are polynomials of degree 1 in `x` and `y` of the light.
pub fn polynomial(size: [usize; 2], lights: Vec<[f32; 3]>, repeats: bool) -> LightSamples {
    stack(size, lights, repeats, |at, [x, y, _]| {
        let [p, q] = slopes(at, size);
        let shade = 0.5 + 0.4 * (p * x + q * y);
        [shade, 0.8 * shade, 0.5 * shade]
    })
}

/// A Lambertian relief with attached shadows and coloured stripes.
pub fn lambert(size: [usize; 2], lights: Vec<[f32; 3]>, repeats: bool) -> LightSamples {
    stack(size, lights, repeats, |at, [x, y, z]| {
        let [p, q] = slopes(at, size).map(|slope| 2.0 * slope);
        let shade = ((z - p * x - q * y) / (1.0 + p * p + q * q).sqrt()).max(0.0);
        let red = if at[0] / 4 % 2 == 0 { 0.8 } else { 0.3 };
        [red * shade, 0.5 * shade, 0.4 * shade]
    })
}

/// A relief with a highlight around the mirror direction of a viewer above.
pub fn shiny(size: [usize; 2], lights: Vec<[f32; 3]>) -> LightSamples {
    stack(size, lights, false, |at, [x, y, z]| {
        let [p, q] = slopes(at, size);
        let length = (p * p + q * q + 1.0).sqrt();
        let half = (x * x + y * y + (z + 1.0) * (z + 1.0)).sqrt();
        let cosine = ((p * x + q * y + z) / length).max(0.0);
        let squared = ((p * x + q * y + z + 1.0) / (length * half)).max(0.0).powi(2);
        let gloss = 0.5 * squared.powi(32);
        [0.4, 0.3, 0.2].map(|colour| colour * cosine + gloss)
    })
}

/// Neighbouring lights are averaged until few enough are left, and lights that are few enough stay.
#[test]
fn neighbouring_lights_are_averaged() {
    let samples = lambert([4, 4], spiral(300), false);
    assert_eq!(*samples.at_most(300), samples);
    for most in [1, 7, 100] {
        let few = samples.at_most(most);
        assert!((most.div_ceil(4)..=most).contains(&few.lights.len()), "{most}: {}", few.lights.len());
        few.check().unwrap();
    }
    // The mean of all photographs.
    let one = samples.at_most(1);
    let mean = samples.images.iter().map(|image| image.pixel(5)[0]).sum::<f32>() / 300.0;
    assert!((one.images[0].pixel(5)[0] - mean).abs() < 1e-4);
}
