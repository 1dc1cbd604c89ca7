//! `--smooth` and `--neighbours`, and the keys of manifests.

use crate::common::cli::Folder;

/// A folder with a table with noise, a scan and a pack.
fn inputs() -> Folder {
    let folder = Folder::new();
    folder.run(&["synth", "ggx?alpha=0.3", "-o", "clean.binary", "--dimensions", "16x16x32"]).succeeded();
    let mut table = folder.read("clean.binary");
    for (number, cell) in table[12..].chunks_exact_mut(8).enumerate() {
        let uniform = (number as u32).wrapping_mul(0x9E37_79B1).rotate_left(13) as f64 / f64::from(u32::MAX);
        let value = f64::from_le_bytes(cell.try_into().unwrap());
        cell.copy_from_slice(&(value * (0.7 + 0.6 * uniform)).to_le_bytes());
    }
    folder.write("noisy.binary", table);
    folder.run(&["synth", "lambert", "-o", "scan.csv", "--rows", "300", "--noise", "0.03"]).succeeded();
    folder
}

/// A path may follow `--smooth`; a number is its radius.
#[test]
fn info_prints_noise_and_radius() {
    let folder = inputs();
    let plain = folder.run(&["info", "noisy.binary"]).succeeded().stdout;
    assert!(!plain.contains("noise"), "{plain}");
    for (arguments, radius) in [
        (&["info", "--smooth", "3", "noisy.binary", "--json"][..], Some(3)),
        (&["info", "noisy.binary", "--smooth=16", "--json"], Some(16)),
        (&["info", "--smooth", "noisy.binary", "--json"], None),
        (&["info", "noisy.binary", "--json", "--smooth"], None),
    ] {
        let smoothed = &folder.run(arguments).succeeded().json()["smoothed"];
        let most = smoothed["radius"][1].as_u64().unwrap();
        assert!(radius.map_or((2..=8).contains(&most), |radius| most == radius), "{arguments:?}: {smoothed}");
        let noise = smoothed["noise"].as_f64().unwrap();
        assert!((0.1..0.4).contains(&noise), "{arguments:?}: {smoothed}");
    }
    let text = folder.run(&["info", "--smooth", "noisy.binary"]).succeeded().stdout;
    assert!(text.contains("estimated noise of the values") && text.contains("cells on each side of a fit"), "{text}");
}

#[test]
fn wrong_values_are_rejected() {
    let folder = inputs();
    for (arguments, expected) in [
        (
            &["--smooth", "1", "noisy.binary"][..],
            "--smooth: found 1, expected true, false, or a radius of 2 to 16 cells",
        ),
        (&["--smooth", "-3", "noisy.binary"], "--smooth: found -3, expected true, false, or a radius"),
        (&["noisy.binary", "--smooth=wide"], "--smooth: found \"wide\", expected true, false, or a radius"),
        (
            &["scan.csv", "--smooth", "3"],
            "--smooth with a radius does not apply to scan.csv, only to MERL and RGL tables",
        ),
        (
            &["synth:lambert", "--smooth"],
            "--smooth does not apply to synth:lambert, only to scans, and MERL and RGL tables",
        ),
        (&["noisy.binary", "--neighbours", "20"], "--neighbours does not apply to noisy.binary, only to scans"),
        (
            &["scan.csv", "--neighbours", "0"],
            "--neighbours: found 0, expected 1 to the number of distinct direction pairs",
        ),
    ] {
        let ran = folder.run(&[&["info"], arguments].concat());
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{arguments:?}: {:?} {}", ran.code, ran.stderr);
    }
}

/// Smoothed values reach every command, and all codecs.
#[test]
fn commands_read_smoothed_values() {
    let folder = inputs();
    let delta_e = |more: &[&str]| {
        let arguments = [&["compare", "clean.binary", "noisy.binary", "--json"], more].concat();
        folder.run(&arguments).succeeded().json()["rendering"]["delta_e"]["mean"].as_f64().unwrap()
    };
    let [rough, smoothed] = [&[][..], &["--smooth"]].map(delta_e);
    assert!(smoothed < 0.5 * rough, "{rough} {smoothed}");
    for codec in ["table", "factored", "wavelet"] {
        let [rough, smoothed] = [&[][..], &["--smooth"]].map(|more| {
            let encode = ["encode", "noisy.binary", "-o", "pack.ktx2", "--codec", codec];
            folder.run(&[&encode, more].concat()).succeeded();
            let compare = ["compare", "clean.binary", "pack.ktx2", "--json"];
            folder.run(&compare).succeeded().json()["rendering"]["delta_e"]["mean"].as_f64().unwrap()
        });
        assert!(smoothed < 0.7 * rough, "{codec}: {rough} {smoothed}");
    }
    let mean = |more: &[&str]| {
        let bandwidth = ["bandwidth", "noisy.binary", "-o", "map.ktx2", "--resolution", "32", "--json"];
        folder.run(&[&bandwidth, more].concat()).succeeded().json()["mean"].as_f64().unwrap()
    };
    let [rough, smoothed] = [&[][..], &["--smooth"]].map(mean);
    assert!(smoothed < 0.9 * rough, "{rough} {smoothed}");
    let samples = |more: &[&str]| {
        let samples = ["samples", "noisy.binary", "-o", "samples.ktx2", "--count", "64", "--polar", "4"];
        folder.run(&[&samples, more].concat()).succeeded();
        folder.read("samples.ktx2")
    };
    assert!(samples(&[]) != samples(&["--smooth"]));
}

/// Keys of a material override the defaults, and flags too. The store tells the settings apart.
#[test]
fn builds_smooth_what_their_manifest_says() {
    let folder = inputs();
    let scene = |defaults: &str, own: &str| {
        folder.write(
            "scene.toml",
            format!(
                "[defaults]\nmax_bytes = 2048\n{defaults}\n[materials.a]\nsource = 'noisy.binary'\n{own}\n\
                 [[uses]]\nmaterial = 'a'\n"
            ),
        );
    };
    let built = |more: &[&str]| {
        let report = folder.run(&[&["build", "scene.toml", "--json"], more].concat()).succeeded().json();
        (folder.read("packs/a.brdf.ktx2"), report["materials"][0]["cached"] == true)
    };
    scene("", "");
    let (plain, _) = built(&[]);
    scene("smooth = true", "");
    let (chosen, cached) = built(&[]);
    assert!(chosen != plain && !cached);
    assert!(built(&[]) == (chosen.clone(), true));
    scene("smooth = 4", "smooth = true");
    assert!(built(&[]) == (chosen.clone(), true), "the material's own key comes first");
    scene("smooth = 4", "");
    let (four, cached) = built(&[]);
    assert!(four != chosen && four != plain && !cached);
    assert!(built(&["--smooth"]) == (chosen, true), "a flag overrides the defaults");
    scene("smooth = 4", "smooth = false");
    assert!(built(&[]).0 == plain);
    // The page of a build reads sources with the settings of the build.
    let drawn_source = |own: &str| {
        scene("", own);
        built(&[]);
        folder.run(&["report", "packs", "-o", "report.html"]).succeeded();
        let page = String::from_utf8(folder.read("report.html")).unwrap();
        let (before, _) = page.split_once("\" alt=\"sphere of a, source\"").expect("a rendering of the source");
        before.rsplit_once("<img src=\"").expect("an image").1.to_owned()
    };
    assert!(drawn_source("smooth = 4") != drawn_source(""));
}

/// Builds check settings before any work. A radius for all materials is for tables, and a scan's own one is an error.
#[test]
fn builds_check_settings() {
    let folder = inputs();
    let refused = folder.run(&["build", "scan.csv", "--neighbours", "0"]);
    assert!(refused.code == 2 && refused.stderr.contains("--neighbours: found 0"), "{refused:?}");
    let built = folder.run(&["build", "noisy.binary", "scan.csv", "--smooth", "4", "--max-bytes", "2048", "--quiet"]);
    assert_eq!(built.code, 0, "{built:?}");
    let own = "[materials.a]\nsource = 'scan.csv'\nsmooth = 4\n[[uses]]\nmaterial = 'a'\n";
    folder.write("scene.toml", own);
    let refused = folder.run(&["build", "scene.toml", "--out", "other"]);
    assert!(refused.code != 0 && refused.stderr.contains("smooth: found 4"), "{refused:?}");
}
