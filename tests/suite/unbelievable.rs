//! Scans that do not determine their material, and limits of every codec: none is met, because all codecs share the checks.

use brdfc::{DirectionPair, Tally};
use brdfc_readers::merl::{Dimensions, pair_of_angles, write};
use brdfc_testing::program::Folder;
use std::f64::consts::PI;
use std::fmt::Write as _;

/// Codecs with the options that choose them.
const CODECS: [&[&str]; 5] = [
    &["--codec", "table"],
    &["--codec", "factored"],
    &["--codec", "wavelet", "--grid", "8"],
    &["--codec", "lobes"],
    &[],
];

/// Limits that any pack of a believable scan meets: ΔE and `ε_r`.
const LOOSE: [&str; 2] = ["90", "900%"];
/// Limits below the error of a fit to noise.
const TIGHT: [&str; 2] = ["0.5", "2%"];

/// A scan that cannot be believed.
struct Kind {
    model: &'static str,
    /// Number of incidences.
    incidences: usize,
    /// Returns true for direction pairs that are measured.
    measured: fn(DirectionPair) -> bool,
    /// Relative noise of the rows.
    noise: f64,
    /// Value in the file by the measured one.
    stored: fn(f64) -> f64,
    /// Factor of the repeated copy of each row.
    repeated: Option<f64>,
    /// Limits of ΔE and `ε_r`; `None` for a limit of the error of the fit.
    limits: Option<[&'static str; 2]>,
    /// Part of the message.
    expected: &'static str,
    /// True if `--trust-fit` accepts the scan.
    can_be_trusted: bool,
}

const DENSE: Kind = Kind {
    model: "synth:ggx?kd=0.3,0.1,0.05&alpha=0.4",
    incidences: 10,
    measured: |_| true,
    noise: 0.0,
    stored: |value| value,
    repeated: None,
    limits: Some(LOOSE),
    expected: "",
    can_be_trusted: true,
};

fn has_mirror_gap(pair: DirectionPair) -> bool {
    let half = [0, 1, 2].map(|axis| pair.incoming[axis] + pair.outgoing[axis]);
    half[0].hypot(half[1]).atan2(half[2]) > 0.07
}

impl Kind {
    fn csv(&self) -> String {
        let model = brdfc::open(self.model).expect("a model");
        let mut text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n".to_owned();
        let (viewers, azimuths) = (13, 19);
        let step = |k: usize, count: usize| 1.52 * k as f64 / (count - 1) as f64;
        let mut seed = 7u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 40) as f64 / f64::from(1 << 23) - 1.0
        };
        for light in 0..self.incidences {
            let theta_i = if self.incidences == 1 { 0.6 } else { step(light, self.incidences) };
            for (viewer, azimuth) in (0..viewers).flat_map(|viewer| (0..azimuths).map(move |azimuth| (viewer, azimuth)))
            {
                let phi = PI * azimuth as f64 / (azimuths - 1) as f64;
                let pair = DirectionPair::from_angles(theta_i, 0.0, step(viewer, viewers), phi);
                if !(self.measured)(pair) {
                    continue;
                }
                let factor = 1.0 + self.noise * random();
                let value = model.source().eval(pair, &mut Tally::default()).map(|f| (self.stored)(f * factor));
                for times in [Some(1.0), self.repeated].into_iter().flatten() {
                    let ([ix, iy, iz], [ox, oy, oz], [r, g, b]) =
                        (pair.incoming, pair.outgoing, value.map(|f| times * f));
                    writeln!(text, "{ix},{iy},{iz},{ox},{oy},{oz},{r},{g},{b}").expect("memory");
                }
            }
        }
        text
    }

    /// Encodes the scan by each codec. `fails` is the expected outcome. `--trust-fit` is the same code for all
    /// codecs and runs with one.
    fn check(&self, fails: bool) {
        let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
        folder.write("scan.csv", self.csv());
        let mut wrong = Vec::new();
        for codec in CODECS {
            let limits: Vec<&str> = match self.limits {
                None => vec!["--max-fit-error", "900%"],
                Some([delta_e, _]) if codec.contains(&"lobes") => vec!["--max-delta-e", delta_e],
                Some([_, error]) if codec.contains(&"wavelet") => vec!["--max-error", error],
                Some([delta_e, error]) => vec!["--max-delta-e", delta_e, "--max-error", error],
            };
            let run = |more: &[&str]| {
                folder.run(&[&["encode", "scan.csv", "-o", "pack.ktx2"], codec, &limits[..], more].concat())
            };
            let ran = run(&[]);
            if ran.code != i32::from(fails) || !ran.stderr.contains(self.expected) {
                wrong.push(format!("{codec:?}: {} {}", ran.code, ran.stderr));
            }
            if codec != CODECS[0] {
                continue;
            }
            let trusted = run(&["--trust-fit"]);
            // The error of the pack alone may miss tight limits, but no longer that of the fit.
            let accepted = match self.limits == Some(TIGHT) {
                true => !trusted.stderr.contains(self.expected),
                false => trusted.code == 0,
            };
            if accepted != self.can_be_trusted {
                wrong.push(format!("{codec:?} --trust-fit: {} {}", trusted.code, trusted.stderr));
            }
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    }
}

/// One test per row.
macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident: $kind:expr;)*) => {
        $($(#[$doc])* #[test] fn $name() { $kind.check(true); })*
    };
}

kinds! {
    black: Kind { model: "synth:lambert?kd=0", expected: "black", can_be_trusted: false, ..DENSE };
    one_incidence: Kind { incidences: 1, expected: "are more than 10° from any sample", ..DENSE };
    /// No light and viewer more than 90° apart.
    gaps_beyond_the_ball: Kind {
        model: "synth:lambert?kd=0.3,0.1,0.2",
        measured: |pair| (0..3).map(|axis| pair.incoming[axis] * pair.outgoing[axis]).sum::<f64>() >= 0.0,
        expected: "of the test directions, over which",
        ..DENSE
    };
    noise: Kind { noise: 0.9, limits: Some(TIGHT), expected: "against the material", ..DENSE };
    narrow_highlight: Kind {
        model: "synth:ggx?kd=0.05&alpha=0.04",
        measured: has_mirror_gap,
        expected: "narrower than the samples resolve",
        ..DENSE
    };
    /// Rows end 17° from the plane of incidence: half vectors are up to 15° from the normal at high incidences, and 1° at low ones.
    highlight_missed_at_high_incidences: Kind {
        model: "synth:ggx?kd=0.05&f0=0.9&alpha=0.15",
        measured: |pair| pair.outgoing[1].atan2(pair.outgoing[0]).abs() < 2.85,
        expected: "at 70° incidence values rise",
        ..DENSE
    };
    saturated: Kind { stored: |value| value.min(0.12), expected: "the detector was saturated", ..DENSE };
    /// Noise of the signal, not of the light.
    saturated_with_noise: Kind {
        stored: |value| value.min(0.12) * (1.0 + 2e-3 * (1e4 * value).sin()),
        expected: "the detector was saturated",
        ..DENSE
    };
    rounded: Kind {
        stored: |value| (100.0 * value).round() / 100.0,
        expected: "values are rounded to multiples of 0.01,",
        ..DENSE
    };
    repeats: Kind { repeated: Some(100.0), expected: "repeated samples of", ..DENSE };
    extrapolated: Kind {
        measured: |pair| pair.incoming[2] > 0.5 && pair.outgoing[2] > 0.5,
        limits: None,
        expected: "extrapolated: ",
        ..DENSE
    };
}

/// Flat BTFs of such materials fail as their packs do.
#[test]
fn flat_btfs_share_the_checks() {
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    folder.write("one.csv", Kind { incidences: 1, ..DENSE }.csv());
    let flatten = |material: &str, more: &[&str]| {
        let small = ["--texels", "16", "--views", "grid:2x6@50", "--max-delta-e", "50"];
        let input = ["flatten", "synth:folds?resolution=24", "-o", "out", "--material", material];
        folder.run(&[&input[..], &small, more].concat())
    };
    let black = flatten("synth:lambert?kd=0", &[]);
    assert!(black.code == 1 && black.stderr.contains("--max-delta-e: no light: the material is black"), "{black:?}");
    // Black or saturated by images.
    image::RgbImage::new(4, 4).save(folder.path().join("black.png")).unwrap();
    let coloured = flatten("synth:lambert", &["--colour", "black.png"]);
    assert!(
        coloured.code == 1 && coloured.stderr.contains("--max-delta-e: no error: all values are black or white"),
        "{coloured:?}"
    );
    // Channels that are no weights of materials.
    let mixed = |name: &str, materials: usize| {
        let materials = ["--material", "synth:lambert"].repeat(materials - 1);
        flatten("synth:lambert?kd=0.1", &[&["--weights", name], &materials[..]].concat())
    };
    image::GrayImage::from_pixel(4, 4, image::Luma([99])).save(folder.path().join("grey.png")).unwrap();
    image::RgbaImage::from_pixel(4, 4, image::Rgba([9, 90, 0, 255])).save(folder.path().join("opaque.png")).unwrap();
    let mut gap = image::RgbImage::from_pixel(4, 4, image::Rgb([9, 90, 0]));
    gap.put_pixel(2, 1, image::Rgb([0; 3]));
    gap.save(folder.path().join("gap.png")).unwrap();
    for (name, materials, message) in [
        (
            "grey.png",
            2,
            "grey.png: weights: found nearly the same weight of all materials at every texel, as in a grey image",
        ),
        ("opaque.png", 4, "opaque.png: weights: found alpha of 1 at every texel, as in an image without transparency"),
    ] {
        let ran = mixed(name, materials);
        assert!(ran.code == 3 && ran.stderr.contains(message), "{ran:?}");
    }
    mixed("opaque.png", 3).succeeded();
    let gap = mixed("gap.png", 2).succeeded();
    assert!(gap.stdout.contains("6.250 % of the texels have no weight: they are of the first material"), "{gap:?}");
    let small = ["--texels", "16", "--views", "grid:2x6@50", "--lights", "grid:2x6@50", "--write-images", "btf"];
    folder.run(&[&["flatten", "synth:folds?resolution=24", "-o", "surface"][..], &small].concat()).succeeded();
    for level in [None, Some(0), Some(255)] {
        for name in folder.files("btf").into_keys().filter(|name| level.is_some() && name.ends_with(".png")) {
            let path = folder.path().join("btf").join(name);
            let mut image = image::open(&path).unwrap().into_rgb8();
            image.fill(level.unwrap_or(0));
            image.save(&path).unwrap();
        }
        let ran = folder.run(&["flatten", "btf", "-o", "of-images", "--texels", "16", "--max-delta-e", "50"]);
        let refused = ran.code == 1 && ran.stderr.contains("--max-delta-e: no error: all values are black or white");
        assert_eq!((ran.code == 0, refused), (level.is_none(), level.is_some()), "{level:?}: {ran:?}");
    }
    let one = flatten("one.csv", &[]);
    assert!(one.code == 1 && one.stderr.contains("one.csv: fit: no reliable fit: "), "{one:?}");
    flatten("one.csv", &["--trust-fit"]).succeeded();
    flatten("synth:lambert", &[]).succeeded();
}

/// Value that a table stores by its angles and the value of a model; `None` for a missing cell.
type Stored = fn([f64; 3], f64) -> Option<f64>;

/// Tables with gaps, coarse tables and saturated ones are as doubtful as scans are.
#[test]
fn tables_share_the_checks() {
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    let dimensions =
        |theta_half, theta_difference, phi_difference| Dimensions { theta_half, theta_difference, phi_difference };
    let fine = dimensions(45, 45, 90);
    let cases: [(Dimensions, Stored, &str); 9] = [
        (
            fine,
            |[half, ..], value| (!(0.14..=0.7).contains(&half)).then_some(value),
            "are more than 10° from any sample",
        ),
        (fine, |[half, ..], value| (half > 0.25).then_some(value), "narrower than the samples resolve"),
        (fine, |_, value| Some(value.min(0.2)), "samples are equal"),
        (fine, |_, value| Some((20.0 * value).round() / 20.0), "values are rounded to multiples of 0.05,"),
        (fine, |[_, difference, _], value| (difference < 1.13).then_some(value), "7 % of the test directions"),
        (dimensions(8, 4, 6), |_, value| Some(value), "are more than 10° from any sample"),
        (dimensions(4, 45, 90), |_, value| Some(value), "are more than 10° from any sample"),
        (fine, |_, value| Some(value), ""),
        // Single cells are missing.
        (fine, |[half, _, azimuth], value| ((half * 97.0 + azimuth * 31.0).sin() < 0.99).then_some(value), ""),
    ];
    for (number, (dimensions, stored, expected)) in cases.into_iter().enumerate() {
        let model = brdfc::open("synth:ggx?kd=0.3,0.1,0.05&alpha=0.2").expect("a model");
        let mut bytes = Vec::new();
        let value = |angles| {
            let pair = pair_of_angles(angles);
            let [r, g, b] = model.source().eval(pair, &mut Tally::default());
            stored(angles, r).map(|r| [r, g, b])
        };
        write(&mut bytes, dimensions, value).expect("memory");
        folder.write("table.binary", bytes);
        let ran = folder.run(&[
            "encode",
            "table.binary",
            "-o",
            "pack.ktx2",
            "--max-delta-e",
            "20",
            "--max-error",
            "900%",
            "--codec",
            "table",
        ]);
        let is_doubtful = !expected.is_empty();
        assert!(ran.code == i32::from(is_doubtful) && ran.stderr.contains(expected), "{number}: {ran:?}");
        let trusted =
            ["encode", "table.binary", "-o", "pack.ktx2", "--max-delta-e", "20", "--codec", "table", "--trust-fit"];
        folder.run(&trusted).succeeded();
    }
}

/// A detector's limit, or a mark of missing samples. It may also be the material, so that limits do not fail.
#[test]
fn many_darkest_samples_are_noted() {
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    for (smallest, note) in [
        (0.0, "are 0 in all channels, which counts as measured; leave out samples that were not"),
        (0.02, "have the smallest value, 0.020 0.020 0.020: if it is the detector's limit, the material is"),
    ] {
        let csv = Kind { model: "synth:ggx?kd=0.03&alpha=0.4", ..DENSE }.csv();
        let raised = |line: &str| {
            let mut fields: Vec<String> = line.split(',').map(str::to_owned).collect();
            for field in &mut fields[6..] {
                let value: Option<f64> = field.parse().ok();
                *field = value.map_or(field.clone(), |v| if v < 0.02 { smallest } else { v }.to_string());
            }
            fields.join(",")
        };
        folder.write("scan.csv", csv.lines().map(raised).collect::<Vec<_>>().join("\n"));
        let ran = folder.run(&["encode", "scan.csv", "-o", "pack.ktx2", "--codec", "table"]).succeeded();
        assert!(ran.stderr.contains(note), "{}", ran.stderr);
    }
}

/// Commands without checks of their own print why a scan does not determine its material.
#[test]
fn all_commands_print_gaps() {
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    folder.write("one.csv", Kind { incidences: 1, ..DENSE }.csv());
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0.6,0,0.8,-0.6,0,0.8\n");
    for command in [
        &["info", "one.csv"][..],
        &["compare", "one.csv", "synth:lewis"],
        &["eval", "one.csv", "--directions", "pairs.csv"],
        &["samples", "one.csv", "-o", "samples.ktx2"],
        &["convert", "one.csv", "-o", "one.binary", "--dimensions", "30x30x60"],
        &["bandwidth", "one.csv", "-o", "bandwidth.ktx2"],
    ] {
        let ran = folder.run(command).succeeded();
        assert!(ran.stderr.contains("one.csv: the samples do not determine the material: "), "{command:?}: {ran:?}");
    }
    folder.write("dense.csv", DENSE.csv());
    let dense = folder.run(&["info", "dense.csv"]).succeeded();
    assert!(!dense.stderr.contains("not determine"), "{dense:?}");
    // The error of a fit has a limit in conversions, too.
    let convert = |limit: &str| {
        let table = ["convert", "dense.csv", "-o", "table.binary", "--dimensions", "30x30x60"];
        folder.run(&[&table[..], &["--max-fit-error", limit]].concat())
    };
    assert!(convert("50%").code == 0 && convert("0.0001%").code == 1);
}

/// A table in MERL's layout cannot hold the two values of exchanged directions.
#[test]
fn conversions_say_what_they_lose() {
    let folder = Folder::of(env!("CARGO_BIN_EXE_brdfc"));
    folder.write("noisy.csv", Kind { noise: 0.9, ..DENSE }.csv());
    let convert = |input: &str, more: &[&str]| {
        folder.run(&[&["convert", input, "-o", "table.binary", "--dimensions", "45x45x90"], more].concat())
    };
    let lost = convert("noisy.csv", &["--smooth", "false"]).succeeded();
    assert!(lost.stderr.contains("the file differs from its source by a mean ΔE of "), "{lost:?}");
    let missed = convert("noisy.csv", &["--smooth", "false", "--max-delta-e", "0.5", "--trust-fit"]);
    assert!(missed.code == 1 && missed.stderr.contains("--max-delta-e: found a mean of "), "{missed:?}");
    assert_eq!(folder.files(".").len(), 2, "the file is written");
    let black = convert("synth:lambert?kd=0", &["--max-error", "10%"]);
    assert!(black.code == 1 && black.stderr.contains("--max-error: no sample above the floor"), "{black:?}");
    let good = convert("synth:ggx?alpha=0.4", &["--max-delta-e", "1", "--max-error", "20%"]).succeeded();
    assert!(!good.stderr.contains("differs"), "{good:?}");
}

/// The control: dense scans meet the same limits, also of constants, and of models without Fresnel's factor, whose largest value is the same
/// at all incidences.
#[test]
fn dense_scans_are_believed() {
    DENSE.check(false);
    for model in ["synth:lambert?kd=0.3,0.1,0.2", "synth:lewis"] {
        Kind { model, ..DENSE }.check(false);
    }
}
