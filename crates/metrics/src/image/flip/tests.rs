use super::*;

fn image(width: usize, height: usize, pixel: impl Fn(usize, usize) -> [f32; 3]) -> LinearImage {
    LinearImage {
        pixels: (0..width * height).map(|i| pixel(i % width, i / width)).collect(),
        coverage: vec![1.0; width * height],
        ..LinearImage::black(width, height)
    }
}

fn plain(colour: [f32; 3]) -> LinearImage {
    image(16, 16, |_, _| colour)
}

/// Fine structure and blocks in all channels.
fn pattern(seed: usize) -> LinearImage {
    image(40, 32, |x, y| {
        [0, 1, 2].map(|k| {
            let blocks = (x / 6) * 31 * (k + 2) + (y / 5) * 17 + seed * 13 * (x % 7);
            ((x * x * 3 + y * y * 5 + x * y * (k + 1) * 7 + blocks) % 256) as f32 / 255.0
        })
    })
}

/// The mean over squares of `2 radius + 1` pixels.
fn blurred(of: &LinearImage, radius: i64) -> LinearImage {
    image(of.width, of.height, |x, y| {
        let near = |at: usize, step: i64, size: usize| (at as i64 + step).clamp(0, size as i64 - 1) as usize;
        let mut sum = [0.0; 3];
        for (down, right) in (-radius..=radius).flat_map(|a| (-radius..=radius).map(move |b| (a, b))) {
            let pixel = of.pixels[near(y, down, of.height) * of.width + near(x, right, of.width)];
            (0..3).for_each(|k| sum[k] += pixel[k] / (2 * radius + 1).pow(2) as f32);
        }
        sum
    })
}

fn mean(a: &LinearImage, b: &LinearImage) -> f64 {
    flip(a, b, 1.0, PIXELS_PER_DEGREE).mean
}

#[test]
fn equal_images_have_no_difference() {
    let a = pattern(0);
    let found = flip(&a, &a, 1.0, PIXELS_PER_DEGREE);
    assert!(found.mean == 0.0 && found.map.iter().all(|value| *value == 0.0));
}

/// Green and blue are the farthest apart, `HyAB^0.7` = 41.276; black and white 100^0.7 lies above the knee.
#[test]
fn plain_colours_have_known_differences() {
    let largest = largest_colour_difference();
    assert!((largest - 41.276).abs() < 0.005, "{largest}");
    assert!((mean(&plain([0.0, 1.0, 0.0]), &plain([0.0, 0.0, 1.0])) - 1.0).abs() < 1e-5);
    let knee = 0.4 * largest;
    let expected = 0.95 + 0.05 * (100f64.powf(0.7) - knee) / (largest - knee);
    let found = mean(&plain([1.0; 3]), &plain([0.0; 3]));
    assert!((found - expected).abs() < 1e-5 && (found - 0.9674).abs() < 1e-4, "{found}");
}

/// Values of the authors' own program, version 1.7 (PyPI: flip-evaluator), for the same linear images.
#[test]
fn the_differences_are_those_of_the_authors() {
    let (a, b) = (pattern(0), pattern(1));
    let found = flip(&a, &b, 1.0, 67.0);
    assert!((found.mean - 0.345_133).abs() < 1e-4, "{}", found.mean);
    for (x, y, expected) in [(0, 0, 0.336_377), (20, 16, 0.289_332), (39, 31, 0.449_799)] {
        let value = found.map[y * 40 + x];
        assert!((value - expected).abs() < 5e-4, "({x}, {y}): {value} {expected}");
    }
    let near = flip(&a, &b, 1.0, 20.0);
    assert!((near.mean - 0.603_392).abs() < 1e-4, "{}", near.mean);

    let soft = image(40, 32, |x, y| a.pixels[y * 40 + x].map(|c| 0.5 * c + 0.25));
    let inside = |x, y| (10..25).contains(&x) && (10..20).contains(&y);
    let patched = image(40, 32, |x, y| if inside(x, y) { [0.9, 0.2, 0.1] } else { soft.pixels[y * 40 + x] });
    assert!((mean(&soft, &patched) - 0.147_831).abs() < 1e-4, "{}", mean(&soft, &patched));

    let grey = plain([0.5; 3]);
    let dot = image(16, 16, |x, y| [if (x, y) == (8, 8) { 0.9 } else { 0.5 }; 3]);
    let found = flip(&grey, &dot, 1.0, 67.0);
    assert!((found.mean - 0.007_306).abs() < 1e-5, "{}", found.mean);
    for (x, expected) in [(8, 0.180_112), (9, 0.134_068), (12, 0.001_418)] {
        assert!((found.map[8 * 16 + x] - expected).abs() < 2e-4, "{x}: {}", found.map[8 * 16 + x]);
    }
}

#[test]
fn the_order_of_images_does_not_matter() {
    let (a, b) = (pattern(0), pattern(1));
    let [forth, back] = [flip(&a, &b, 1.0, PIXELS_PER_DEGREE), flip(&b, &a, 1.0, PIXELS_PER_DEGREE)];
    assert_eq!(forth, back);
    // Control: for other images the result differs.
    assert_ne!(forth, flip(&a, &pattern(2), 1.0, PIXELS_PER_DEGREE));
}

#[test]
fn a_wider_blur_is_a_larger_difference() {
    let sharp = pattern(0);
    let found: Vec<f64> = [0, 1, 2, 4].iter().map(|radius| mean(&sharp, &blurred(&sharp, *radius))).collect();
    assert!(found[0] == 0.0 && found.windows(2).all(|pair| pair[0] < pair[1]), "{found:?}");
    assert!(found[3] < 1.0);
}

/// From afar fine structure is invisible; without the filters the distance would not matter.
#[test]
fn fine_structure_is_visible_from_near_only() {
    let grey = plain([0.5; 3]);
    let checks = image(16, 16, |x, y| [if (x + y) % 2 == 0 { 0.4 } else { 0.6 }; 3]);
    let [near, far] = [15.0, 120.0].map(|pixels| flip(&grey, &checks, 1.0, pixels).mean);
    assert!(near > 10.0 * far, "{near} {far}");
}

/// The separated filters are the sums of Gaussians of the plane, in double precision.
#[test]
fn separated_filters_are_those_of_the_plane() {
    let (width, height) = (23, 19);
    let plane: Vec<f32> = (0..width * height).map(|i| ((i * i * 7 + i * 13) % 101) as f32 - 50.0).collect();
    let radius = 10i64;
    for channel in 0..3 {
        let found = sensitivity_filtered(&plane, width, channel, 67.0);
        let sum_over = |x: usize, y: usize, terms: &[[f64; 2]]| {
            let (mut sum, mut weights) = (0.0, 0.0);
            for (down, right) in (-radius..=radius).flat_map(|a| (-radius..=radius).map(move |b| (a, b))) {
                let squared = (down * down + right * right) as f64 / (67.0 * 67.0);
                let gaussian = |[a, b]: &[f64; 2]| a * (PI / b).sqrt() * (-PI * PI * squared / b).exp();
                let weight: f64 = terms.iter().map(gaussian).sum();
                let row = (y as i64 + down).clamp(0, height as i64 - 1) as usize;
                let column = (x as i64 + right).clamp(0, width as i64 - 1) as usize;
                sum += weight * f64::from(plane[row * width + column]);
                weights += weight;
            }
            sum / weights
        };
        for (x, y) in [(0, 0), (11, 9), (22, 18), (3, 17)] {
            let value = f64::from(found[y * width + x]);
            let expected = sum_over(x, y, SENSITIVITY[channel]);
            assert!((value - expected).abs() < 1e-4, "{channel}: {value} {expected}");
            // Control: a single Gaussian of the two.
            let short = sum_over(x, y, &SENSITIVITY[2][..1]);
            assert!((value - short).abs() > 1e-3, "{channel}: {value} {short}");
        }
    }
}

#[test]
fn weights_of_features_sum_to_1_on_each_side() {
    for pixels_per_degree in [0.1, 5.0, 67.0, 300.0] {
        let [smooth, edge, point] = feature_kernels(pixels_per_degree);
        let side = |kernel: &[f32], sign: f32| kernel.iter().map(|w| (sign * w).max(0.0)).sum::<f32>();
        assert!((side(&smooth, 1.0) - 1.0).abs() < 1e-5);
        assert!([&smooth, &edge, &point].iter().all(|kernel| kernel.iter().all(|w| w.is_finite())));
        if pixels_per_degree > 1.0 {
            let sums = [side(&edge, 1.0), side(&edge, -1.0), side(&point, 1.0), side(&point, -1.0)];
            assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-5), "{sums:?}");
        }
    }
}

#[test]
fn surfaces_have_a_mean_of_their_own() {
    let (mut a, mut b) = (plain([0.2; 3]), plain([0.2; 3]));
    for pixel in 0..128 {
        (a.coverage[pixel], b.coverage[pixel]) = (0.0, 0.0);
        (a.pixels[pixel], b.pixels[pixel]) = ([0.0; 3], [0.0; 3]);
    }
    b.pixels[255] = [0.9; 3];
    let found = flip(&a, &b, 1.0, PIXELS_PER_DEGREE);
    assert!((found.mean_on_surfaces / found.mean - 2.0).abs() < 1e-3, "{found:?}");
}

#[test]
fn bad_images_make_no_bad_numbers() {
    assert_eq!(flip(&LinearImage::black(0, 3), &LinearImage::black(0, 3), 1.0, 67.0).mean, 0.0);
    let mut a = plain([0.5; 3]);
    a.pixels[7] = [f32::NAN, f32::INFINITY, -1.0];
    let found = flip(&a, &plain([0.5; 3]), 1.0, 67.0);
    assert!(found.map.iter().all(|value| (0.0..=1.0).contains(value)) && found.mean > 0.0);
}

#[test]
fn threads_do_not_matter() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| flip(&pattern(0), &pattern(1), 1.0, PIXELS_PER_DEGREE))
    };
    assert_eq!(run(1), run(4));
}
