use super::*;
use brdfc_core::Symmetry;
use brdfc_formats::direction::dot;

/// A round lobe about a fixed axis, `exp(s (cos α - 1))`.
struct Spot {
    axis: Vector,
    sharpness: f64,
}

impl Source for Spot {
    fn eval(&self, pair: DirectionPair, _: &mut Tally) -> [f64; 3] {
        [(self.sharpness * (dot(pair.outgoing, self.axis) - 1.0)).exp(); 3]
    }
    fn symmetry(&self) -> Symmetry {
        Symmetry::NONE
    }
    fn is_grey(&self) -> bool {
        true
    }
}

/// `cos^n` about the mirror direction, plus a constant.
struct Phong {
    exponent: f64,
    /// Anisotropic along the tangent unless 1.
    brush: f64,
    symmetry: Symmetry,
}

impl Source for Phong {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        let [x, y, z] = pair.incoming;
        let [a, b, c] = pair.outgoing;
        let off = (a + x).powi(2) * self.brush + (b + y).powi(2) + (c - z).powi(2);
        let value = 0.1 + (1.0 - 0.5 * off).max(0.0).powf(self.exponent);
        [value, 0.5 * value, 0.1]
    }
    fn symmetry(&self) -> Symmetry {
        self.symmetry
    }
}

fn phong(exponent: f64) -> Phong {
    Phong { exponent, brush: 1.0, symmetry: Symmetry::FULL }
}

fn peak(values: &[f32]) -> f32 {
    values.iter().copied().fold(0.0, f32::max)
}

fn spot_peak(theta: f64, azimuth: f64, sharpness: f64, wrong: impl Fn(f64) -> f64) -> f32 {
    let image = LobeImage::new(64);
    let spot = Spot { axis: from_polar(theta, azimuth), sharpness };
    let lobe = image.lobe(&spot, incoming([0, 0]), false, &mut Tally::default());
    let found = image.bandwidth(&lobe[0], 0.01);
    let inside = (0..found.len()).filter(|n| image.theta[*n] < FRAC_PI_2);
    inside.map(|n| found[n] * wrong(image.theta[n]) as f32).fold(0.0, f32::max)
}

#[test]
fn a_lobe_has_its_bandwidth_at_any_angle() {
    for sharpness in [16.0, 64.0] {
        let peaks = [0.0f64, 20.0, 40.0, 60.0].map(|theta| spot_peak(theta.to_radians(), 0.7, sharpness, |_| 1.0));
        println!("{sharpness}: {peaks:?}");
        assert!(peaks.iter().all(|p| (p / peaks[0] - 1.0).abs() < 0.2), "{sharpness}: {peaks:?}");
        let expected = ((2.0 * sharpness * 100f64.ln()).sqrt() / TAU) as f32;
        assert!((0.8..1.5).contains(&(peaks[0] / expected)), "{peaks:?} {expected}");
        // The negative control: the Jacobian of an orthographic map.
        let wrong = [0.0f64, 60.0].map(|theta| spot_peak(theta.to_radians(), 0.7, sharpness, |t| t.cos().max(0.1)));
        assert!((wrong[1] / wrong[0] - 1.0).abs() > 0.3, "{wrong:?}");
    }
}

#[test]
fn doubling_an_exponent_raises_the_peak_by_the_square_root_of_2() {
    let peaks: Vec<f32> = (2..=8).map(|n| peak(&lobe_bandwidth(&phong(2f64.powi(n)), 64, 0.01).values)).collect();
    println!("{peaks:?}");
    for pair in peaks.windows(2) {
        let ratio = f64::from(pair[1] / pair[0]);
        assert!((ratio / 2f64.sqrt() - 1.0).abs() < 0.2, "{ratio}: {peaks:?}");
    }
}

#[test]
fn the_threshold_hardly_matters() {
    for exponent in [10.0, 100.0] {
        // Up to 45 degrees of incidence: lobes that the horizon cuts off have an edge there.
        let peaks = [0.003, 0.01, 0.03]
            .map(|epsilon| peak(&lobe_bandwidth(&phong(exponent), 64, epsilon).values[..8 * CELLS * SIDE]));
        println!("{exponent}: {peaks:?}");
        assert!(peaks.iter().all(|p| (p / peaks[1] - 1.0).abs() < 0.35), "{exponent}: {peaks:?}");
    }
}

#[test]
fn a_constant_lobe_has_no_bandwidth() {
    let constant = Phong { exponent: 0.0, ..phong(1.0) };
    assert!(lobe_bandwidth(&constant, 64, 0.01).values.iter().all(|value| *value == 0.0));
}

/// `cos^n` falls to half at `1.18 / √n` radians. With 64 pixels per side, 16 pixels are within that radius up to an
/// exponent of 113.
#[test]
fn lobes_too_narrow_for_the_pixels_are_found() {
    let narrow = |exponent: f64, side: usize| lobe_bandwidth(&phong(exponent), side, 0.01).narrow;
    assert_eq!([10.0, 50.0, 2000.0].map(|exponent| narrow(exponent, 64)), [false, false, true]);
    assert_eq!([64, 128, 256].map(|side| narrow(1000.0, side)), [true, true, false]);
    // A constant lobe, with and without noise.
    assert!(!narrow(0.0, 64));
    struct Noise;
    impl Source for Noise {
        fn eval(&self, pair: DirectionPair, _: &mut Tally) -> [f64; 3] {
            let [x, y, _] = pair.outgoing;
            [1.0 + 0.2 * (1e5 * (x + 0.7 * y)).sin(); 3]
        }
        fn symmetry(&self) -> Symmetry {
            Symmetry::NONE
        }
        fn is_grey(&self) -> bool {
            true
        }
    }
    let noise = lobe_bandwidth(&Noise, 32, 0.01);
    assert!(peak(&noise.values) > 4.0 && !noise.narrow, "{}", peak(&noise.values));
}

/// The highlight is in the cell of the mirror direction; the negative control, a mean over the surrounding cells, would
/// hide it.
#[test]
fn the_peak_is_at_the_highlight() {
    let map = lobe_bandwidth(&phong(200.0), 64, 0.01).values;
    for (i, j) in [(0, 7), (5, 9), (12, 4)] {
        let block = |k: usize, l: usize| map[(16 * j + l) * SIDE + 16 * i + k];
        let mirror = block((i + 8) % 16, j);
        let all: Vec<f32> = (0..256).map(|n| block(n % 16, n / 16)).collect();
        assert!(mirror > 0.9 * peak(&all), "{mirror} {}", peak(&all));
        assert!(block(i, j) < 0.5 * mirror, "behind it is calm: {} {mirror}", block(i, j));
        let mean = all.iter().sum::<f32>() / 256.0;
        assert!(mean < 0.7 * mirror, "{mean} {mirror}");
    }
}

/// The negative control: a mean over the pixels of a cell.
#[test]
fn a_cell_keeps_the_largest_of_its_pixels() {
    let image = LobeImage::new(64);
    let source = phong(100.0);
    let lobe = image.lobe(&source, incoming([0, 8]), false, &mut Tally::default());
    let values = image.bandwidth(&lobe[0], 0.01);
    // Number of cells that are lower than one of their pixels.
    let lower = |cells: [[f32; CELLS]; CELLS]| {
        let is_lower = |(number, members): &(usize, &Vec<usize>)| {
            assert!(!members.is_empty());
            members.iter().any(|pixel| values[*pixel] > 1.0001 * cells[number / CELLS][number % CELLS])
        };
        image.members.iter().enumerate().filter(is_lower).count()
    };
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    let tally = &mut Tally::default();
    assert_eq!(lower(image.cells(&source, [0, 8], 0.01, tally).0), 0);
    let wrong = lower(image.cells_by(&source, [0, 8], 0.01, tally, mean).0);
    assert!(wrong > 20, "{wrong}");
}

/// Compares with and without the symmetry, up to the alignment of wavelets.
#[test]
fn symmetries_save_lobes_and_change_little() {
    let plain = Symmetry::NONE;
    let isotropic = Symmetry { isotropic: true, ..plain };
    let mirror = Symmetry { mirror: true, ..plain };
    for (symmetry, brush, share) in [(isotropic, 1.0, 16), (Symmetry::FULL, 1.0, 32), (mirror, 4.0, 4)] {
        let with = lobe_bandwidth(&Phong { symmetry, exponent: 20.0, brush }, 32, 0.01);
        let without = lobe_bandwidth(&Phong { symmetry: plain, exponent: 20.0, brush }, 32, 0.01);
        assert_eq!(with.tally.evaluations * share, without.tally.evaluations);
        for (a, b) in with.values.iter().zip(&without.values) {
            assert!(a / b < 2.0 && b / a < 2.0, "{symmetry:?}: {a} {b}");
        }
    }
}
