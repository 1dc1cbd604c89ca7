//! Analytic models against physical laws and values worked out by hand.

use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, cell_centre, from_polar};
use brdfc_testing::checks::{albedo, isotropy, largest_albedo, mirror, reciprocity, value};
use std::f64::consts::{FRAC_PI_2, PI};

const ADDRESSES: [&str; 15] = [
    "synth:lambert",
    "synth:lambert?kd=0.8,0.5,0.1",
    "synth:lewis",
    "synth:lewis?kd=0.1,0.2,0.3&ks=0.5&n=300",
    "synth:ward",
    "synth:ward?kd=0&ks=0.2,0.1,0.1&ax=0.2&ay=0.2",
    "synth:poulin",
    "synth:poulin?kd=0.3,0.2,0.1&ks=0.2&d=2&h=-1&n=200",
    "synth:poulin?d=4&h=0.7",
    "synth:poulin?h=1",
    "synth:ggx",
    "synth:ggx?kd=0&f0=0.9,0.6,0.2&alpha=0.05",
    "synth:ggx?alpha_x=0.1&alpha_y=0.6",
    "synth:velvet",
    "synth:velvet?kd=0.1,0.02,0.03&sx=0.4&sy=0.4",
];

fn source(address: &str) -> Box<dyn Source> {
    parse_synth(address).unwrap()
}

#[test]
fn models_obey_the_symmetries_they_claim() {
    for address in ADDRESSES {
        let source = source(address);
        let symmetry = source.symmetry();
        assert!(symmetry.reciprocal && symmetry.mirror, "{address}");
        let (exchanged, mirrored) = (reciprocity(source.as_ref()), mirror(source.as_ref()));
        assert!(exchanged <= 1e-12 && mirrored <= 1e-12, "{address}: {exchanged:e} {mirrored:e}");
        let turned = isotropy(source.as_ref());
        assert!(if symmetry.isotropic { turned < 1e-9 } else { turned > 0.1 }, "{address}: {turned:e}");
    }
}

#[test]
fn grey_models_have_equal_channels() {
    for address in ADDRESSES {
        let source = source(address);
        let equal = brdfc_testing::checks::random_pairs(200)
            .into_iter()
            .map(|p| value(source.as_ref(), p))
            .all(|v| v == [v[0]; 3]);
        assert_eq!(source.is_grey(), equal, "{address}");
    }
}

#[test]
fn values_are_zero_below_the_horizon_and_every_evaluation_counts() {
    let below = DirectionPair::from_angles(0.5, 1.0, 1.6, 0.2);
    let grazing = DirectionPair::new([1.0, 0.0, 0.0], [0.0, 0.0, 1.0]);
    for address in ADDRESSES {
        let (source, mut tally) = (source(address), Tally::default());
        for pair in [below, below.exchanged(), grazing, grazing.exchanged()] {
            assert_eq!(source.eval(pair, &mut tally), [0.0; 3], "{address}");
        }
        assert_eq!(tally, Tally { evaluations: 4, ..Tally::default() });
        for z in [1e-4, 1e-10, 1e-100, 1e-200] {
            for y in [[0.0, 0.0], [0.6, 0.6], [0.6, -0.6], [1.0, 1.0], [1.0, -1.0]] {
                let [i, o] = y.map(|y: f64| [(1.0 - y * y).sqrt(), y, z]);
                let v = source.eval(DirectionPair::new(i, o), &mut tally);
                assert!(v.iter().all(|c| c.is_finite() && *c >= 0.0), "{address} {i:?} {o:?}: {v:?}");
            }
        }
    }
}

fn assert_near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance * expected.abs(), "found {found}, expected {expected}");
}

#[test]
fn lambert_is_constant_and_white_reflects_everything() {
    let pair = DirectionPair::from_angles(0.3, 0.1, 1.2, 2.0);
    assert_near(value(source("synth:lambert?kd=0.25,0.5,1").as_ref(), pair)[1], 0.15915494309189535, 1e-15);
    let white = source("synth:lambert?kd=1");
    for theta in [0.0, 0.7, 1.4] {
        assert_near(albedo(white.as_ref(), from_polar(theta, 0.4), 16)[2], 1.0, 1e-12);
    }
}

#[test]
fn lewis_has_the_value_worked_out_by_hand() {
    // wi = (0.6, 0, 0.8), wo = (0, 0.6, 0.8): cos α = 0.64, and 0.5 / π + 0.25 · 4 / 2π · 0.4096.
    let pair = DirectionPair::new([0.6, 0.0, 0.8], [0.0, 0.6, 0.8]);
    let found = value(source("synth:lewis?kd=0.5&ks=0.25&n=2").as_ref(), pair)[0];
    assert_near(found, 0.159_154_943_1 + 0.159_154_943_1 * 0.4096, 1e-9);
    // In the mirror direction the lobe is (n + 2) / 2π = 22 / 2π.
    let pair = DirectionPair::new([0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]);
    assert_near(value(source("synth:lewis?kd=0&ks=1&n=20").as_ref(), pair)[0], 3.501_408_748, 1e-9);
    // A clipped lobe has the albedo ks at normal incidence.
    assert_near(albedo(source("synth:lewis?kd=0&ks=1&n=20").as_ref(), [0.0, 0.0, 1.0], 200)[0], 1.0, 1e-3);
}

#[test]
fn ward_has_the_value_worked_out_by_hand() {
    // wi = (0.6, 0, 0.8), wo = (0, 0, 1): h ∝ (1, 0, 3), so the exponent is -(1/3)² / 0.2² = -2.7777777778.
    // exp(-2.7777777778) = 0.0621765240; 4π · 0.2 · 0.5 = 1.2566370614; sqrt 0.8 = 0.8944271910.
    let pair = DirectionPair::new([0.6, 0.0, 0.8], [0.0, 0.0, 1.0]);
    let found = value(source("synth:ward?kd=0&ks=1&ax=0.2&ay=0.5").as_ref(), pair)[0];
    assert_near(found, 0.062_176_524_0 / (1.256_637_061_4 * 0.894_427_191_0), 1e-8);
    // Across, the slope has less effect: -(1/3)² / 0.5² = -0.4444444444, exp = 0.6411803884.
    let pair = DirectionPair::new([0.0, 0.6, 0.8], [0.0, 0.0, 1.0]);
    let found = value(source("synth:ward?kd=0&ks=1&ax=0.2&ay=0.5").as_ref(), pair)[0];
    assert_near(found, 0.641_180_388_4 / (1.256_637_061_4 * 0.894_427_191_0), 1e-8);
}

#[test]
fn ggx_has_the_value_worked_out_by_hand_and_conserves_energy() {
    // Both at the normal, α = 0.5: D = 1 / (π 0.25), G = 1, F = 0.04, over 4.
    let normal = [0.0, 0.0, 1.0];
    let found = value(source("synth:ggx?kd=0&f0=0.04&alpha=0.5").as_ref(), DirectionPair::new(normal, normal))[0];
    assert_near(found, 0.012_732_395_447, 1e-9);
    for alpha in [0.2, 0.4, 0.7, 1.0] {
        let mirror = source(&format!("synth:ggx?kd=0&f0=1&alpha={alpha}"));
        let largest = largest_albedo(mirror.as_ref(), 100);
        assert!(largest < 1.001, "{alpha}: {largest}");
    }
    let smooth = source("synth:ggx?kd=0&f0=1&alpha=0.05");
    for theta in [0.0, 0.5, 1.0] {
        let found = albedo(smooth.as_ref(), from_polar(theta, 0.3), 200)[0];
        assert!((0.98..1.0005).contains(&found), "{theta}: {found}");
    }
    let rough = albedo(source("synth:ggx?kd=0&f0=1&alpha=1").as_ref(), from_polar(1.0, 0.0), 100)[0];
    assert!(rough < 0.9, "{rough}");
}

#[test]
fn poulin_is_flat_where_the_floor_covers_the_cylinders() {
    let (kd, ks, n) = (0.3, 0.2, 30.0);
    for (shape, tolerance) in [("d=2.5&h=1", 1e-12), ("d=100&h=0.9999", 2e-2)] {
        let source = source(&format!("synth:poulin?kd={kd}&ks={ks}&n={n}&{shape}"));
        for (i, o) in [((0.2, 0.3), (0.5, 2.0)), ((0.7, 1.5), (0.9, 4.4)), ((0.0, 0.0), (0.0, 0.0))] {
            let (i, o) = (from_polar(i.0, i.1), from_polar(o.0, o.1));
            let sum: Vector = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
            let cosine = sum[2] / (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt();
            let flat = kd / PI + ks * (n + 2.0) / (2.0 * PI) * cosine.powf(n);
            assert_near(value(source.as_ref(), DirectionPair::new(i, o))[0], flat, tolerance);
        }
    }
}

#[test]
fn poulin_has_the_value_worked_out_by_hand() {
    // Light and viewer at the normal, touching half cylinders, kd only: 1/(2π) ∫ sin² β over [0, π] = 1/4.
    let normal = DirectionPair::new([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]);
    assert_near(value(source("synth:poulin?kd=1&ks=0&d=2&h=0").as_ref(), normal)[0], 0.25, 1e-12);
    // Spread to d = 4, a floor of width 2 joins in: (π/2 + 2) / 4π.
    assert_near(value(source("synth:poulin?kd=1&ks=0&d=4&h=0").as_ref(), normal)[0], 0.284_154_943_092, 1e-11);
}

#[test]
fn poulin_loses_energy_and_is_anisotropic() {
    for shape in ["d=2&h=-1", "d=2&h=0", "d=2.5&h=0", "d=3&h=-0.5", "d=5&h=0.8"] {
        let source = source(&format!("synth:poulin?kd=1&ks=0&{shape}"));
        let largest = largest_albedo(source.as_ref(), 40);
        assert!(largest > 0.5 && largest < 1.0 + 1e-3, "{shape}: {largest}");
    }
    let shiny = source("synth:poulin?kd=0&ks=0.2&n=50");
    let tilted = |phi: f64| value(shiny.as_ref(), DirectionPair::new(from_polar(0.6, phi), from_polar(0.2, phi)))[0];
    let (along, across) = (tilted(0.0), tilted(FRAC_PI_2));
    assert!(across > 3.0 * along, "along {along}, across {across}");
}

/// Mean over all cells of the table of 32 x 32 incoming and 32 x 32 outgoing directions.
fn table_mean(source: &dyn Source) -> f64 {
    let cells: Vec<Vector> = (0..32 * 32).map(|k| cell_centre(k % 32, k / 32, 32)).collect();
    let sum: f64 =
        cells.iter().map(|&i| cells.iter().map(|&o| value(source, DirectionPair::new(i, o))[0]).sum::<f64>()).sum();
    sum / (cells.len() * cells.len()) as f64
}

#[test]
fn means_over_the_table_are_known() {
    assert_near(table_mean(source("synth:lewis?kd=0.6&ks=0.3&n=20").as_ref()), 0.246_335, 1e-5);
    assert_near(table_mean(source("synth:ward?kd=0.2&ks=0.1&ax=0.15&ay=0.5").as_ref()), 0.081_077, 1e-5);
}

/// A source that violates every law.
struct Broken(fn(DirectionPair) -> f64);

impl Source for Broken {
    fn eval(&self, pair: DirectionPair, _: &mut Tally) -> [f64; 3] {
        [self.0(pair) / PI; 3]
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::FULL
    }
}

#[test]
fn the_checks_notice_violations() {
    let fine = Broken(|_| 1.0);
    assert_eq!([reciprocity(&fine), mirror(&fine), isotropy(&fine)], [0.0; 3]);
    assert!(largest_albedo(&fine, 8) < 1.0 + 1e-12);

    assert!(reciprocity(&Broken(|p| 1.0 + 0.1 * p.incoming[2])) > 0.01);
    assert!(mirror(&Broken(|p| 1.0 + 0.1 * p.incoming[0] * p.outgoing[0] * p.incoming[1])) > 0.01);
    assert!(isotropy(&Broken(|p| 1.0 + 0.1 * p.incoming[0].abs() * p.outgoing[0].abs())) > 0.01);
    assert!(largest_albedo(&Broken(|p| 1.0 + 0.1 * p.incoming[2]), 8) > 1.05);
}
