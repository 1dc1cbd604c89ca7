//! Scene manifests.

use super::refused;
use crate::common::cli::{Folder, states_what_is_expected};

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
        let message = refused(&folder, arguments, 3, &["brdfc: scene.toml: line ", expected]);
        // A problem without a value has its remedy.
        assert!(states_what_is_expected(&message) || message.contains("; "), "{message}");
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
            "line 1, key: found \"secne\", expected scene, defaults, materials, captures, btfs, environments, uses or render; did you mean scene?",
        ),
        (
            0,
            "material = 1",
            "line 1, key: found \"material\", expected scene, defaults, materials, captures, btfs, environments, uses or render; did you mean mat",
        ),
        (2, "titel = 1", "line 3, key in [scene]: found \"titel\", expected name, distance_scale or environment"),
        (2, "distance-scale = 1", "did you mean distance_scale?"),
        (4, "grit = 8", "line 5, key in [defaults]: found \"grit\", expected codec, max_delta_e,"),
        (4, "grit = 8", "did you mean grid?"),
        (6, "max_eror = 0.1", "line 7, key in [materials.paint]: found \"max_eror\""),
        (6, "max_eror = 0.1", "did you mean max_error?"),
        (6, "parameterization = 'tangent-pole'", "did you mean parameterisation?"),
        (10, "distance = 4", "line 11, key in [[uses]]: found \"distance\", expected object, material, nearest"),
        (10, "neerest = 4", "did you mean nearest?"),
    ] {
        bad(with_line(after, line), expected);
    }
    bad(
        GOOD.replace("[[uses]]", "[[use]]"),
        "key: found \"use\", expected scene, defaults, materials, captures, btfs, environments, uses or render; did you mean uses?",
    );
}

#[test]
fn wrong_types() {
    for (from, to, line) in [
        ("name = 'x'", "name = 3", 2),
        ("name = 'x'", "name = 1979-05-27", 2),
        ("grid = 4", "grid = 'four'", 4),
        ("grid = 4", "grid = 99999999999999999999999", 4),
        ("grid = 4", "ratio = 99999999999999999999999", 4),
        ("grid = 4", "ratio = 1e999", 4),
        ("grid = 4", "max_bytes = -3", 4),
        ("grid = 4", "max_error = true", 4),
        ("grid = 4", "require = 3", 4),
        ("nearest = 2.0", "nearest = [1]", 10),
        ("grid = 4", "grid = 4.5", 4),
        ("grid = 4", "grid = -4", 4),
        ("grid = 4", "smooth = 2.5", 4),
        ("grid = 4", "bits = 99999999999", 4),
        ("source = 'synth:lewis'", "source = 3", 6),
        ("source = 'synth:lewis'", "source = ['a']", 6),
        ("material = 'paint'", "material = 1", 9),
        ("nearest = 2.0", "nearest = 'close'", 10),
    ] {
        let folder = Folder::new();
        folder.write("scene.toml", GOOD.replace(from, to));
        let value = to.split(" = ").nth(1).unwrap();
        let message = refused(&folder, &["build", "scene.toml"], 3, &[&format!(": found {value}, expected ")]);
        names_no_type(&message);
        let key = to.split(' ').next().unwrap();
        let place = message.split(": found").next().unwrap();
        assert!(place.contains(&format!("line {line}, ")) && place.ends_with(&format!(".{key}")), "{to}: {message}");
    }
    bad(with_line(6, "ratio = '4'"), "line 7, materials.paint.ratio: found '4', expected a number: 1 to 4096");
    bad(
        with_line(6, "require = { max_bytes = 'x' }"),
        "line 7, materials.paint.require.max_bytes: found 'x', expected a whole number of bytes, such as 16384, 16KiB or",
    );
    bad(with_line(6, "require = { max_byte = 4 }"), "did you mean max_bytes?");
    bad(
        with_line(3, "require = { max_error = 3 }"),
        "line 4, defaults.require.max_error: found 3, expected a fraction or a",
    );
    bad(format!("{GOOD}[materials.paint]\nsource = 'synth:lewis'\n"), "duplicate key in \"[materials.paint]\"");
    bad("[materials.paint]\ngrid = 4\n", "line 1, materials.paint: no source; expected source = ");
    bad(
        "[materials.paint]\nsource = 'synth:lewis'\n[[uses]]\nobject = 'x'\n",
        "uses[0]: no material; expected material = ",
    );
}

/// Words of the program that users do not know.
#[track_caller]
fn names_no_type(message: &str) {
    for word in ["struct", "enum", "i128", "f64", "u32", "sequence", " map", "invalid", "length", "`"] {
        assert!(!message.contains(word), "{word}: {message}");
    }
    // Ours alone, not that of the parser as well.
    assert_eq!(message.matches("expected").count(), 1, "{message}");
}

#[test]
fn errors_of_tables_and_lists_state_the_expected_type() {
    let elevations = "two numbers: [from, to], 0 to 90 degrees above the surface, 5 apart or more";
    let (sides, eye) = ("a whole number: 1 to 8192", "three numbers: [x, y, z]");
    for (line, place, found, allowed) in [
        ("scene = 3", "line 1, scene", "3", "a table, [scene]"),
        ("defaults = 'x'", "line 1, defaults", "'x'", "a table, [defaults]"),
        ("render = 3", "line 1, render", "3", "a table, [render]"),
        ("uses = 3", "line 1, uses", "3", "tables, each [[uses]]"),
        ("uses = [3]", "line 1, uses", "[3]", "tables, each [[uses]]"),
        ("[uses]\nmaterial = 'x'", "line 1, uses", "a table", "tables, each [[uses]]"),
        ("materials = [1]", "line 1, materials", "[1]", "tables, each [materials.NAME]"),
        ("[[materials]]\nsource = 'a'", "line 1, materials", "a list with tables", "tables, each [materials.NAME]"),
        ("[materials]\na = 'a.brdf'", "line 2, materials.a", "'a.brdf'", "a table, [materials.a]"),
        ("[materials.a]\nrequire = 3", "line 2, materials.a.require", "3", "a table, [materials.a.require]"),
        ("[[scene]]", "line 1, scene", "a list with tables", "a table, [scene]"),
        ("[[render]]", "line 1, render", "a list with tables", "a table, [render]"),
        ("[render]\ncamera = 1", "line 2, render.camera", "1", "a table, [render.camera]"),
        ("[render]\nlights = 1", "line 2, render.lights", "1", "tables, each [[render.lights]]"),
        (
            "[render]\nmaterials = ['X']",
            "line 2, render.materials",
            "['X']",
            "a table, [render.materials]: part = \"mat",
        ),
        ("[render]\nmaterials = { ball = 3 }", "line 2, render.materials.ball", "3", "a string"),
        ("[render]\nwidth = -1", "line 2, render.width", "-1", sides),
        ("[render]\nwidth = 1.5", "line 2, render.width", "1.5", sides),
        ("[render.camera]\neye = [1, 2]", "line 2, render.camera.eye", "[1, 2]", eye),
        ("[render.camera]\neye = [1, 2, 3, 4]", "line 2, render.camera.eye", "[1, 2, 3, 4]", eye),
        ("[render.camera]\nup = [1, 'a', 3]", "line 2, render.camera.up", "[1, 'a', 3]", eye),
        (
            "[[render.lights]]\nintensity = 3",
            "line 1, render.lights[0]",
            "no position",
            "position = three numbers: [x, y, z]",
        ),
        (
            "[[render.lights]]\nposition = [1, 2, 3]\nintensity = [1, 2]",
            "line 3, render.lights[0].intensity",
            "[1, 2]",
            "a number or three: W/sr, grey or [r, g, b], 0 or more",
        ),
        ("[[uses]]\nview_elevation = [35]", "line 2, uses[0].view_elevation", "[35]", elevations),
        ("[[uses]]\nview_elevation = 35", "line 2, uses[0].view_elevation", "35", elevations),
        ("[[uses]]\nlight_elevation = ['a', 'b']", "line 2, uses[0].light_elevation", "['a', 'b']", elevations),
        ("[[uses]]\nlight_elevation = [-5, 5, 9]", "line 2, uses[0].light_elevation", "[-5, 5, 9]", elevations),
        ("[[uses]]\nlight_elevation = [10, 40, 9]", "line 2, uses[0].light_elevation", "[10, 40, 9]", elevations),
        (
            "[[uses]]\nlighting = 'points'",
            "line 2, uses[0].lighting",
            "'points'",
            "a list of strings: points, environment",
        ),
        (
            "[materials.a]\nsource = 'x'\nlobes = { max_fetches = 33 }",
            "line 3, materials.a.lobes.max_fetches",
            "33",
            "1 to 32 for lobes",
        ),
        ("[defaults.lobes]\nmax_delta_e = 0", "line 2, defaults.lobes.max_delta_e", "0", "1e-6 to 100"),
        (
            "[defaults.lobes]\nmax_bytes = 8",
            "line 2, key in [defaults.lobes]",
            "\"max_bytes\"",
            "max_delta_e or max_fetches",
        ),
        ("[[uses]]\nmaps = [3]", "line 2, uses[0].maps", "[3]", "a list of strings: lobes, bandwidth, samples"),
    ] {
        let folder = Folder::new();
        folder.write("scene.toml", line);
        let wrong = if found == "no position" { "no position;".to_owned() } else { format!("found {found},") };
        let words = format!("brdfc: scene.toml: {place}: {wrong} expected {allowed}");
        names_no_type(&refused(&folder, &["build", "scene.toml"], 3, &[&words]));
    }
}

/// A number that is too large for its type is reported as it was written.
#[test]
fn huge_numbers() {
    let digits = "9".repeat(60);
    for (line, allowed) in [
        ("ratio = 99999999999999999999999", "a number: 1 to 4096"),
        ("max_fetches = 99999999999", "a whole number: 1 or more (up to 4294967295)"),
        (
            "max_bytes = 99999999999999999999",
            "a whole number of bytes, such as 16384, 16KiB or 1MiB (up to 9223372036854775807)",
        ),
        ("bias = 1e999", "a number: 1e-6 to 1"),
        ("max_delta_e = 1e99", "1e-6 to 100"),
        ("max_delta_e = 1e-99", "1e-6 to 100"),
    ] {
        let (key, value) = line.split_once(" = ").unwrap();
        bad(with_line(6, line), &format!("line 7, materials.paint.{key}: found {value}, expected {allowed}"));
    }
    for (value, most) in [
        ("99999999999999999999", "9223372036854775807; larger ones have an exponent"),
        ("1e999", "1.7976931348623157e308"),
    ] {
        let expected =
            format!("uses[0].nearest: found {value}, expected a number: a distance, 0 or more (up to {most}");
        bad(GOOD.replace("nearest = 2.0", &format!("nearest = {value}")), &expected);
    }
    bad(with_line(6, &format!("bits = {digits}")), &format!("found {}..., expected a whole number: 8", &digits[..40]));
}

/// Errors about files name the key as well.
#[test]
fn errors_of_sources_state_their_line() {
    for (source, expected) in [
        ("nothing*.binary", "line 6, materials.paint.source, nothing*.binary: no file matches; expected a file"),
        ("[.binary", "line 6, materials.paint.source, [.binary: invalid pattern: [ without ]"),
        ("-", "line 6, materials.paint.source: found \"-\", expected a file, a pattern or a synth: address; manifests"),
    ] {
        bad(GOOD.replace("synth:lewis", source), expected);
    }
}

#[test]
fn values_out_of_range() {
    for (line, expected) in [
        ("grid = 0", "materials.paint.grid: found 0, expected 2, 4, 8, 16, 32 or 64"),
        ("grid = 24", "materials.paint.grid: found 24, expected 2, 4, 8, 16, 32 or 64"),
        ("grid = 128", "materials.paint.grid: found 128, expected"),
        ("bits = 9", "materials.paint.bits: found 9, expected 8, or 10 to 16"),
        ("bits = 17", "materials.paint.bits: found 17, expected"),
        ("smooth = 17", "materials.paint.smooth: found 17, expected true, false, or a radius of 2 to 16 cells"),
        ("neighbours = 0", "materials.paint.neighbours: found 0, expected 1 to the number of distinct direction pairs"),
        ("ratio = 0.5", "materials.paint.ratio: found 0.5, expected 1 to 4096"),
        ("ratio = nan", "materials.paint.ratio: found NaN, expected"),
        ("ratio = inf", "materials.paint.ratio: found inf, expected"),
        ("max_error = 0", "materials.paint.max_error: found 0, expected a positive fraction"),
        ("max_error = -0.1", "materials.paint.max_error: found -0.1, expected a fraction, such as 0.03"),
        ("max_error = 3", "materials.paint.max_error: found 3, expected a fraction or a percentage; write 0.03 or 3%"),
        (
            "parameterisation = 'half-difference'",
            "materials.paint.parameterisation: found \"half-difference\", expected tangent-pole; use the codec table for half-difference angles",
        ),
    ] {
        bad(with_line(6, line), &format!("line 7, {expected}"));
        bad(
            with_line(3, line).replace("grid = 4\n", ""),
            &format!("line 4, {}", expected.replace("materials.paint", "defaults")),
        );
    }
    bad(with_line(2, "distance_scale = 0"), "line 3, scene.distance_scale: found 0, expected a positive number");
    bad(GOOD.replace("nearest = 2.0", "nearest = -1"), "uses[0].nearest: found -1, expected a distance, 0 or more");
    bad(GOOD.replace("nearest = 2.0", "nearest = nan"), "uses[0].nearest: found NaN, expected");
}

#[test]
fn two_targets() {
    bad(with_line(6, "ratio = 4\nmax_error = 0.1"), "line 7, materials.paint.ratio: several limits; set only one of");
    bad(
        with_line(6, "max_bytes = 4\nmax_error = 0.1"),
        "max_error: several limits; set only one of ratio, max_error and max_bytes",
    );
    bad(with_line(3, "max_bytes = 4\nratio = 4"), "defaults.ratio: several limits");
    let folder = Folder::new();
    folder.write("scene.toml", with_line(6, "ratio = 4").replace("grid = 4", "grid = 4\nmax_error = 0.1"));
    folder.run(&["build", "scene.toml", "--dry-run"]).succeeded();
}

#[test]
fn uses_of_materials_that_are_not_there() {
    bad(
        GOOD.replace("material = 'paint'", "material = 'pant'"),
        "line 9, uses[0].material: found \"pant\", expected paint",
    );
    bad(
        "[[uses]]\nmaterial = 'paint'\n",
        "line 2, uses[0].material: found \"paint\", expected a material; the manifest has none",
    );
}

#[test]
fn names_that_cannot_be_files() {
    for name in ["'../evil'", "'a/b'", "''", "'a b'", "'.hidden'", "'C:x'"] {
        let shown = name.trim_matches('\'');
        bad(
            GOOD.replace("materials.paint", &format!("materials.{name}")),
            &format!(
                "line 5, materials.{shown}: found the name \"{shown}\", expected letters of any script, digits, - and _"
            ),
        );
    }
}

#[test]
fn text_that_is_no_manifest() {
    bad(b"[scene]\nname = '\xff'\n", "line 2, text: found byte 0xff, expected UTF-8");
    bad("[scene]\nname = \n", "line 2, manifest: ");
    bad("[scene\n", "line 1, manifest: ");
    bad("[scene]\n[scene]\n", "; expected TOML as described in docs/manifest.md");
    bad(GOOD.replace("grid = 4", "grid = 4\ngrid = 8"), "line 5, manifest: ");
    bad("{\"scene\": {}}", "line 1, manifest: ");
    bad([0u8; 64], "line 1, manifest: ");
}

#[test]
fn an_empty_manifest_makes_nothing() {
    for text in ["", "# nothing\n"] {
        let folder = Folder::new();
        folder.write("scene.toml", text);
        let words = ["brdfc: scene.toml: nothing to build: 0 materials and no uses; add [[uses]]"];
        refused(&folder, &["build", "scene.toml", "--quiet"], 1, &words);
    }
}
