//! Scans of known models: the printed error of a pack is its true error, or the fit is reported as the weaker part.

use brdfc::compare::{Pairs, reflectances};
use brdfc::encode::remarks;
use brdfc::{Budget, DirectionPair, Tally};
use brdfc_testing::program::Folder;
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;

/// Simulated scan of a model.
struct Scan {
    name: &'static str,
    model: &'static str,
    /// Polar angles of light and viewer, azimuths.
    counts: [usize; 3],
    /// Largest polar angle, degrees.
    steepest: f64,
    /// Relative noise of each value.
    noise: f64,
    /// Returns true if a direction pair, given by its polar angles in degrees, is missing.
    gap: fn(f64, f64) -> bool,
    /// Smallest azimuth between the viewers and the plane of incidence, degrees.
    turned: f64,
    /// Index of the polar angle of light whose values are multiplied by 1.5; 0 for none.
    brighter: usize,
    /// Factor of the repeated copy of every row.
    repeated: Option<f64>,
    /// True if the fit should be good enough to be trusted: a control for the others.
    believed: bool,
}

const GGX: &str = "synth:ggx?kd=0.3,0.1,0.05&alpha=0.35";
const PLAIN: Scan = Scan {
    name: "dense",
    model: GGX,
    counts: [18, 24, 37],
    steepest: 87.5,
    noise: 0.0,
    gap: |_, _| false,
    turned: 0.0,
    brighter: 0,
    repeated: None,
    believed: true,
};

/// Numbers from -1 to 1, the same on every run.
fn noise(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*seed >> 40) as f64 / f64::from(1 << 23) - 1.0
}

impl Scan {
    fn csv(&self) -> String {
        let model = brdfc::open(self.model).expect("a model");
        let mut text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n".to_owned();
        let mut seed = 7;
        let [lights, viewers, azimuths] = self.counts;
        let polar = |k: usize, count: usize| {
            let degrees = if count == 1 { 45.0 } else { self.steepest * k as f64 / (count - 1) as f64 };
            degrees.to_radians().min(FRAC_PI_2)
        };
        for light in 0..lights {
            for viewer in 0..viewers {
                for azimuth in 0..azimuths {
                    let [theta_i, theta_o] = [polar(light, lights), polar(viewer, viewers)];
                    let turned = self.turned.to_radians();
                    let phi = turned + (PI - 2.0 * turned) * azimuth as f64 / (azimuths.max(2) - 1) as f64;
                    if (self.gap)(theta_i.to_degrees(), theta_o.to_degrees()) {
                        continue;
                    }
                    let pair = DirectionPair::from_angles(theta_i, 0.0, theta_o, phi);
                    let value = model.source().eval(pair, &mut Tally::default());
                    let brighter = if self.brighter > 0 && self.brighter == light { 1.5 } else { 1.0 };
                    let factor = brighter * (1.0 + self.noise * noise(&mut seed));
                    for times in [Some(1.0), self.repeated].into_iter().flatten() {
                        let [r, g, b] = value.map(|v| v * factor * times);
                        writeln!(text, "{theta_i},0,{theta_o},{phi},{r},{g},{b}").expect("memory");
                    }
                }
            }
        }
        text
    }
}

#[test]
fn printed_errors_are_true_or_the_fit_is_reported() {
    let scans = [
        PLAIN,
        Scan {
            name: "dense, another model",
            model: "synth:ward?kd=0.2&ks=0.1&ax=0.3&ay=0.3",
            believed: false,
            ..PLAIN
        },
        Scan { name: "dense, matte", model: "synth:lambert?kd=0.5,0.3,0.1", counts: [9, 12, 13], ..PLAIN },
        Scan { name: "a little noise", noise: 0.02, ..PLAIN },
        Scan { name: "much noise", noise: 0.5, counts: [8, 12, 13], believed: false, ..PLAIN },
        Scan { name: "sparse", counts: [5, 6, 7], believed: false, ..PLAIN },
        Scan { name: "coarse", model: "synth:ggx?kd=0.2&alpha=0.08", counts: [7, 9, 13], believed: true, ..PLAIN },
        Scan { name: "narrow", model: "synth:ggx?kd=0.05&alpha=0.05", turned: 10.0, believed: false, ..PLAIN },
        Scan { name: "one incidence too bright", brighter: 5, counts: [9, 12, 13], believed: false, ..PLAIN },
        Scan {
            name: "a gap",
            gap: |i, o| (25.0..60.0).contains(&i) || (25.0..60.0).contains(&o),
            believed: false,
            ..PLAIN
        },
        Scan { name: "one incidence", counts: [1, 19, 2], believed: false, ..PLAIN },
        Scan {
            name: "repeated with 100 times the value",
            repeated: Some(100.0),
            counts: [9, 12, 13],
            believed: false,
            ..PLAIN
        },
    ];
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    let mut lines = String::new();
    let mut wrong = Vec::new();
    for scan in scans {
        let path = folder.write("scan.csv", scan.csv());
        let [truth, material] = [brdfc::open(scan.model), brdfc::open(path)].map(|opened| opened.expect("a material"));
        let pack = material.encode_closest(Budget::default(), &()).expect("a pack");
        let file = folder.write("pack.ktx2", pack.bytes());
        let decoded = brdfc::open(file).expect("a pack");
        let compared = reflectances(&truth, &decoded, Pairs::OfEncoder).expect("comparable");
        let (printed, real) = (pack.errors().delta_e, compared.comparison.rendering.delta_e.mean);
        let reported = remarks(pack.report()).iter().any(|line| line.contains("less accurate than the pack"));
        let fit = pack.report().fit.as_ref().expect("a scan has a fit");
        writeln!(lines, "{}: printed {printed:.3}, true {real:.3}, reported {reported}, {fit:?}", scan.name)
            .expect("memory");
        let is_true = (printed - real).abs() <= 0.3 * real;
        if !(is_true || reported) || scan.believed == reported {
            wrong.push(scan.name);
        }
    }
    println!("{lines}");
    assert!(wrong.is_empty(), "{wrong:?}:\n{lines}");
}
