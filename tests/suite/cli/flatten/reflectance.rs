//! The forms of reflectance: which one `brdfc flatten` selects, and what each allows.

use super::{file, flatten, number, report};
use crate::common::cli::Folder;
use serde_json::Value;

/// Known materials need no views: their file is smaller, and closer to the surface than factors of a few views.
#[test]
fn structures_get_a_brdf_that_is_smaller_than_factors() {
    let folder = Folder::new();
    for name in ["button", "folds", "knit", "sponge"] {
        let surface = format!("synth:{name}?resolution=32");
        let made = |form: &str| {
            let out = format!("{name}-{form}");
            report(flatten(&folder, &[&surface, "-o", &out, "--reflectance", form]))
        };
        let [chosen, brdf, factors] = ["auto", "brdf", "factors"].map(made);
        let form = |report: &Value| [&report["settings"], &report["report"]].map(|of| of["reflectance"].clone());
        assert_eq!(form(&chosen), ["auto", "brdf"], "{name}");
        assert_eq!(form(&brdf), ["brdf", "brdf"], "{name}");
        assert_eq!(form(&factors), ["factors", "factors"], "{name}");
        assert_eq!(chosen["report"], brdf["report"], "{name}");
        // Tables have the same size for any number of texels, of which these assets have few.
        let of_texels = |report: &Value| {
            report["gpu_bytes"].as_u64().unwrap() - report["images"]["factored_tables"].as_u64().unwrap()
        };
        let [small, large] = [&chosen, &factors].map(of_texels);
        assert!(small < large, "{name}: {small} {large}");
        let errors = [&chosen, &factors].map(|report| number(&report["report"]["errors"]["from_surface"]["mean"]));
        assert!(errors[0] < errors[1], "{name}: {errors:?}");
        // Only factors have views.
        let (without, with) = (&chosen["report"], &factors["report"]);
        assert!(without.get("seen").is_none() && without.get("never_seen").is_none(), "{name}: {without}");
        assert!(number(&with["seen"]) < 1.0 && with["never_seen"].is_u64(), "{name}: {with}");
        assert_eq!(without["factored"]["components"], 0, "{name}");
        assert!(number(&with["factored"]["components"]) > 0.0, "{name}");
        assert!(number(&without["factored"]["errors"]["seen_mean"]) < 0.7, "{name}: {without}");
        assert!(chosen["images"].get("direction_mesh_words").is_none(), "{name}");
        assert!(factors["images"].get("direction_mesh_words").is_some(), "{name}");
        // The form does not change the relief.
        let [first, second] = ["auto", "factors"].map(|form| file(&folder, &format!("{name}-{form}")));
        assert!(first.decoder.parts().relief == second.decoder.parts().relief, "{name}");
    }
}

#[test]
fn three_materials_get_factors() {
    let folder = Folder::new();
    folder.write(
        "pyramid.obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 0.5 0.1\n\
         usemtl clay\nf 1 2 5\nusemtl tin\nf 2 3 5\nusemtl ash\nf 3 4 5\nf 4 1 5\n",
    );
    let [clay, tin, ash] = ["clay=synth:lambert?kd=0.5", "tin=synth:lewis", "ash=synth:ggx?alpha=0.3"];
    let three = ["pyramid.obj", "-o", "three", "--material", clay, "--material", tin, "--material", ash];
    let made = report(flatten(&folder, &three));
    assert_eq!(made["report"]["reflectance"], "factors");
    assert_eq!(made["materials"].as_array().unwrap().len(), 3);
    let refused = flatten(&folder, &[&three[..], &["--reflectance", "brdf"]].concat());
    assert_eq!(refused.code, 3, "{refused:?}");
    let expected = "brdfc: materials: found 3 materials, expected at most 2 for the reflectance brdf\n";
    assert!(refused.stderr.ends_with(expected) && refused.stdout.is_empty(), "{refused:?}");
    folder.write("plane.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl clay\nf 1 2 3\nusemtl tin\nf 1 3 4\n");
    let two = ["plane.obj", "-o", "two", "--material", clay, "--material", tin];
    assert_eq!(report(flatten(&folder, &two))["report"]["reflectance"], "brdf");
}

/// They are refused before anything is read or written.
#[test]
fn options_that_do_not_apply_to_a_brdf() {
    let folder = Folder::new();
    folder.write("images/tl000 pl000 tv000 pv000.png", b"no image");
    let only_factors = "does not apply to --reflectance brdf, only to --reflectance factors and pwt";
    for (input, options, expected) in [
        ("gone.obj", &["--fill", "poisson"][..], format!("--fill {only_factors}")),
        ("gone.obj", &["--fill", "push-pull"], format!("--fill {only_factors}")),
        ("gone.obj", &["--bounces", "4"], format!("--bounces {only_factors}")),
        ("gone.obj", &["--max-bytes", "9KiB"], format!("--max-bytes {only_factors}")),
        (
            "images",
            &[],
            "--reflectance brdf does not apply to an ordinary BTF, only to surfaces with materials".to_owned(),
        ),
    ] {
        let ran = flatten(&folder, &[&[input, "-o", "never", "--reflectance", "brdf"], options].concat());
        assert_eq!((ran.code, ran.stderr), (2, format!("brdfc: {expected}\n")), "{input} {options:?}");
        assert!(!folder.path().join("never").exists(), "{options:?}");
    }
    // Bounces do not apply by default either: they choose factors.
    let knit = ["synth:knit?resolution=24", "-o", "knit"];
    let form = |more: &[&str]| report(flatten(&folder, &[&knit[..], more].concat()))["report"]["reflectance"].clone();
    assert_eq!(form(&["--bounces", "2"]), "factors");
    assert_eq!(form(&["--bounces", "0"]), "brdf");
    // A limit of ΔE and views do apply.
    assert_eq!(form(&["--reflectance", "brdf", "--max-delta-e", "1", "--lights", "grid:3x8@60"]), "brdf");
}

#[test]
fn light_of_one_bounce_brightens_and_does_not_depend_on_threads() {
    let folder = Folder::new();
    let sponge = "synth:sponge?resolution=32&height=1.5";
    let flat = |input: &str, more: &[&str]| {
        let arguments = ["flatten", input, "--name", "s", "--texels", "16"];
        folder.run(&[&arguments[..], more].concat()).succeeded();
    };
    let bounces = ["--views", "grid:2x6@50", "--fill", "push-pull", "--bounces", "8"];
    for (out, jobs) in [("one", "1"), ("three", "3")] {
        flat(sponge, &[&bounces[..], &["-o", out, "-j", jobs]].concat());
    }
    let files = |out: &str| folder.files(out);
    assert!(files("one").values().eq(files("three").values()));
    let listed: Value = serde_json::from_str(&file(&folder, "one").report).unwrap();
    assert_eq!(listed["report"]["reflectance"], "factors");
    assert!(listed["report"]["errors"].as_object().unwrap().is_empty(), "the comparison knows direct light only");
    // Images contain shadows, like light of one bounce.
    let written = ["--views", "grid:2x6@50", "-o", "known", "--write-images", "images", "--image-format", "exr"];
    flat(sponge, &written);
    flat("images", &["--geometry", sponge, "--fill", "push-pull", "-o", "direct"]);
    let mut places = "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n".to_owned();
    for k in 0..256 {
        let [u, v] = [k % 16, k / 16].map(|at| (f64::from(at) + 0.5) / 16.0);
        for light in ["0,0,1", "0.6,0,0.8", "0,0.6,0.8", "-0.6,0,0.8", "0,-0.6,0.8"] {
            places += &format!("{u},{v},{light},0,0,1\n{u},{v},{light},0.6,0,0.8\n");
        }
    }
    folder.write("places.csv", places);
    let brightness = |out: &str| {
        let values = folder.run(&["eval", out, "--directions", "places.csv"]).succeeded().stdout;
        let green = values.lines().skip(1).map(|line| line.split(',').nth_back(1).unwrap().parse::<f64>().unwrap());
        green.sum::<f64>() / 2560.0
    };
    let (direct, bounced) = (brightness("direct"), brightness("one"));
    assert!(bounced > 1.02 * direct && bounced < 1.6 * direct, "{direct} {bounced}");
}
