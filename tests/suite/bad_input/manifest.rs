//! Scene manifests.

use super::refused;
use crate::common::cli::Folder;

const GOOD: &str = "\
[scene]
name = 'x'
[defaults]
grid = 4
[materials.paint]
source = 'synth:lewis'
[[uses]]
object = 'wall'
material = 'paint'
nearest = 2.0
";

#[track_caller]
fn bad(text: impl AsRef<[u8]>, expected: &str) {
    let folder = Folder::new();
    folder.write("scene.toml", text);
    for arguments in [["build", "scene.toml"].as_slice(), &["build", "scene.toml", "--dry-run"]] {
        refused(&folder, arguments, 3, &["brdfc: scene.toml: line ", ": found ", "; allowed ", expected]);
    }
}

/// A line added after line `after`, counted from 1.
fn with_line(after: usize, line: &str) -> String {
    let mut lines: Vec<&str> = GOOD.lines().collect();
    lines.insert(after, line);
    lines.join("\n")
}

#[test]
fn the_good_manifest_is_good() {
    let folder = Folder::new();
    folder.write("scene.toml", GOOD);
    folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
}

#[test]
fn unknown_keys_at_every_level() {
    for (after, line, expected) in [
        (
            0,
            "[secne]",
            "line 1, key: found \"secne\"; allowed scene, defaults, materials, uses, render (did you mean scene?)",
        ),
        (
            0,
            "material = 1",
            "line 1, key: found \"material\"; allowed scene, defaults, materials, uses, render (did you mean materials?)",
        ),
        (2, "titel = 1", "line 3, key in [scene]: found \"titel\"; allowed name, distance_scale, environment"),
        (2, "distance-scale = 1", "(did you mean distance_scale?)"),
        (4, "grit = 8", "line 5, key in [defaults]: found \"grit\"; allowed codec, max_delta_e,"),
        (4, "grit = 8", "(did you mean grid?)"),
        (6, "max_eror = 0.1", "line 7, key in [materials.paint]: found \"max_eror\""),
        (6, "max_eror = 0.1", "(did you mean max_error?)"),
        (6, "parameterization = 'tangent-pole'", "(did you mean parameterisation?)"),
        (10, "distance = 4", "line 11, key in [[uses]]: found \"distance\"; allowed object, material, nearest"),
        (10, "neerest = 4", "(did you mean nearest?)"),
    ] {
        bad(with_line(after, line), expected);
    }
    bad(
        GOOD.replace("[[uses]]", "[[use]]"),
        "key: found \"use\"; allowed scene, defaults, materials, uses, render (did you mean uses?)",
    );
}

#[test]
fn wrong_types() {
    for (from, to, line) in [
        ("name = 'x'", "name = 3", 2),
        ("grid = 4", "grid = 'four'", 4),
        ("grid = 4", "grid = 4.5", 4),
        ("grid = 4", "grid = -4", 4),
        ("grid = 4", "smooth = 1", 4),
        ("grid = 4", "bits = 99999999999", 4),
        ("source = 'synth:lewis'", "source = 3", 6),
        ("source = 'synth:lewis'", "source = ['a']", 6),
        ("material = 'paint'", "material = 1", 9),
        ("nearest = 2.0", "nearest = 'close'", 10),
    ] {
        let folder = Folder::new();
        folder.write("scene.toml", GOOD.replace(from, to));
        let told = refused(&folder, &["build", "scene.toml"], 3, &["brdfc: scene.toml: line ", ": found invalid "]);
        println!("{to}: {told}");
        let key = to.split(' ').next().unwrap();
        let place = told.split(": found").next().unwrap();
        assert!(place.contains(&format!("line {line}, ")) && place.ends_with(&format!(".{key}")), "{to}: {told}");
    }
    bad(with_line(6, "ratio = '4'"), "line 7, materials.paint.ratio: found invalid type: string \"4\"");
    bad(
        with_line(6, "require = { max_bytes = 'x' }"),
        "line 7, materials.paint.require.max_bytes: found invalid value",
    );
    bad(with_line(6, "require = { max_byte = 4 }"), "(did you mean max_bytes?)");
    bad(
        with_line(3, "require = { max_error = 3 }"),
        "line 4, defaults.require.max_error: found 3; allowed a fraction or a",
    );
    bad(format!("{GOOD}[materials.paint]\nsource = 'synth:lewis'\n"), "duplicate key in \"[materials.paint]\"");
    bad("scene = 3\n", "line 1, ");
    bad("uses = 3\n", "line 1, ");
    bad("materials = [1]\n", "line 1, ");
    bad("[materials]\npaint = 'file.brdf'\n", "line 2, ");
    bad("[materials.paint]\ngrid = 4\n", "line 1, materials.paint: found no source; allowed source = ");
    bad("[materials.paint]\nsource = 'synth:lewis'\n[[uses]]\nobject = 'x'\n", "missing field `material`");
}

#[test]
fn values_out_of_range() {
    for (line, expected) in [
        ("grid = 0", "materials.paint.grid: found 0; allowed 2, 4, 8, 16, 32 or 64"),
        ("grid = 24", "materials.paint.grid: found 24; allowed 2, 4, 8, 16, 32 or 64"),
        ("grid = 128", "materials.paint.grid: found 128; allowed"),
        ("bits = 9", "materials.paint.bits: found 9; allowed 8, or 10 to 16"),
        ("bits = 17", "materials.paint.bits: found 17; allowed"),
        ("ratio = 0.5", "materials.paint.ratio: found 0.5; allowed 1 to 4096"),
        ("ratio = nan", "materials.paint.ratio: found NaN; allowed"),
        ("ratio = inf", "materials.paint.ratio: found inf; allowed"),
        ("max_error = 0", "materials.paint.max_error: found 0; allowed a positive fraction"),
        ("max_error = -0.1", "materials.paint.max_error: found -0.1; allowed a fraction, such as 0.03"),
        ("max_error = 3", "materials.paint.max_error: found 3; allowed a fraction or a percentage: write 0.03 or 3%"),
        (
            "parameterisation = 'half-difference'",
            "materials.paint.parameterisation: found \"half-difference\"; allowed tangent-pole; half-difference angles are",
        ),
    ] {
        bad(with_line(6, line), &format!("line 7, {expected}"));
        bad(
            with_line(3, line).replace("grid = 4\n", ""),
            &format!("line 4, {}", expected.replace("materials.paint", "defaults")),
        );
    }
    bad(with_line(2, "distance_scale = 0"), "line 3, scene.distance_scale: found 0; allowed a positive number");
    bad(GOOD.replace("nearest = 2.0", "nearest = -1"), "uses[0].nearest: found -1; allowed a distance, 0 or more");
    bad(GOOD.replace("nearest = 2.0", "nearest = nan"), "uses[0].nearest: found NaN; allowed");
}

#[test]
fn two_targets() {
    bad(
        with_line(6, "ratio = 4\nmax_error = 0.1"),
        "line 7, materials.paint.ratio: found more than one target; allowed one of",
    );
    bad(
        with_line(6, "max_bytes = 4\nmax_error = 0.1"),
        "found more than one target; allowed one of ratio, max_error and max_bytes",
    );
    bad(with_line(3, "max_bytes = 4\nratio = 4"), "defaults.ratio: found more than one target");
    let folder = Folder::new();
    folder.write("scene.toml", with_line(6, "ratio = 4").replace("grid = 4", "grid = 4\nmax_error = 0.1"));
    folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
}

#[test]
fn uses_of_materials_that_are_not_there() {
    bad(
        GOOD.replace("material = 'paint'", "material = 'pant'"),
        "line 9, uses[0].material: found \"pant\"; allowed paint (did you mean paint?)",
    );
    bad(
        "[[uses]]\nmaterial = 'paint'\n",
        "line 2, uses[0].material: found \"paint\"; allowed a material (there are none)",
    );
}

#[test]
fn names_that_cannot_be_files() {
    for name in ["'../evil'", "'a/b'", "''", "'a b'", "'.hidden'", "'päint'", "'C:x'"] {
        let shown = name.trim_matches('\'');
        bad(
            GOOD.replace("materials.paint", &format!("materials.{name}")),
            &format!("line 5, materials.{shown}: found the name \"{shown}\"; allowed letters, digits, - and _"),
        );
    }
}

#[test]
fn text_that_is_no_manifest() {
    bad(b"[scene]\nname = '\xff'\n", "line 2, text: found byte 0xff; allowed UTF-8");
    bad("[scene]\nname = \n", "line 2, manifest: found ");
    bad("[scene\n", "line 1, manifest: found ");
    bad("[scene]\n[scene]\n", "line 2, manifest: found ");
    bad(GOOD.replace("grid = 4", "grid = 4\ngrid = 8"), "line 5, manifest: found ");
    bad("{\"scene\": {}}", "line 1, manifest: found ");
    bad([0u8; 64], "line 1, ");
}

#[test]
fn an_empty_manifest_makes_nothing() {
    for text in ["", "# nothing\n"] {
        let folder = Folder::new();
        folder.write("scene.toml", text);
        let words = ["brdfc: nothing to build: found 0 materials, and no use of any, in scene.toml; allowed one"];
        refused(&folder, &["build", "scene.toml", "--quiet"], 1, &words);
    }
}
