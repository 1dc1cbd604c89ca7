//! `brdfc shader`.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_formats::PackKind;
use brdfc_formats::words::one_of;

#[test]
fn every_kind_in_every_language() {
    let folder = Folder::new();
    for decoder in PackKind::ALL {
        let kind = decoder.name();
        for language in ["wgsl", "glsl", "essl300", "hlsl", "msl", "spirv"] {
            let file = format!("{kind}.{language}");
            let run = ["shader", kind, "--language", language, "-o", &file];
            let report = folder.run(&[&run[..], &["--json"]].concat()).succeeded().json();
            conforms("shader", &report);
            let bytes = folder.read(&file);
            assert_eq!(report["bytes_on_disk"], bytes.len());
            assert_eq!((&report["decoder"], &report["language"]), (&kind.into(), &language.into()));
            assert_eq!(report["entry_point"]["name"].as_str(), (language == "spirv").then_some("evaluate"));
            let called = report["functions"][0]["name"].as_str().unwrap();
            assert_eq!(report["bindings_version"], decoder.descriptor().version);
            let calls = decoder.descriptor().brdf.is_some() && !["msl", "spirv"].contains(&language);
            assert_eq!(report["brdf"]["filtered"].is_string(), calls, "{file}");
            if language != "spirv" {
                assert!(String::from_utf8(bytes).unwrap().contains(&format!(" {called}(")), "{file}");
            }
        }
    }
    // Standard output is the same.
    let printed = folder.run(&["shader", "table", "--language", "glsl"]).succeeded();
    assert_eq!(printed.stdout.as_bytes(), folder.read("table.glsl"));
    let written = folder.run(&["shader", "table", "--language", "glsl", "-o", "other.glsl"]).succeeded();
    assert!(
        written.stdout.starts_with("table decoder in glsl: ") && written.stdout.contains("call table_brdf, "),
        "{}",
        written.stdout
    );
    assert_eq!(folder.read("other.glsl"), folder.read("table.glsl"));
    folder.write("pack.ktx2", "a pack");
    let refused = folder.run(&["shader", "table", "--language", "glsl", "-o", "pack.ktx2"]);
    assert!(
        refused.code == 2 && refused.stderr.contains("--output: pack.ktx2 has the extension of packs"),
        "{}",
        refused.stderr
    );
    assert_eq!(folder.read("pack.ktx2"), b"a pack");
}

#[test]
fn packs_and_folders_say_their_kind() {
    let folder = Folder::new();
    for (codec, kind) in [("table", "table"), ("wavelet", "wavelet")] {
        let file = format!("{codec}.ktx2");
        folder.run(&["encode", "synth:lambert", "--codec", codec, "-o", &file]).succeeded();
        let report = folder.run(&["shader", &file, "--language", "hlsl", "--json"]).succeeded().json();
        assert_eq!(report["decoder"], kind);
    }
    let small = ["--texels", "8", "--views", "grid:2x3@40", "--lights", "grid:2x3@40"];
    folder.run(&[&["flatten", "synth:knit?resolution=24", "-o", "knit"][..], &small].concat()).succeeded();
    for flat in ["knit", "knit/knit.ktx2"] {
        let report = folder.run(&["shader", flat, "--language", "essl300", "--json"]).succeeded().json();
        assert_eq!(report["decoder"], "flat-btf", "{flat}");
    }
}

#[test]
fn an_unknown_kind_is_reported() {
    let folder = Folder::new();
    let kinds = PackKind::ALL.map(PackKind::name);
    let unknown = format!("KIND: found \"tabel\", expected {}, or a pack", one_of(&kinds));
    folder.write("some.ktx2", b"no pack");
    folder.write("report.json", b"{}");
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    for (arguments, code, problem) in [
        (&["shader", "tabel", "--language", "glsl"][..], 2, unknown.as_str()),
        (&["shader", "table"], 2, "--language"),
        (&["shader", "table", "--language", "cg"], 2, "invalid value 'cg'"),
        (&["shader", "some.ktx2", "--language", "glsl"], 3, "some.ktx2: "),
        (
            &["shader", "report.json", "--language", "glsl"],
            3,
            "report.json: input: found the output of a build, expected table, ",
        ),
        (&["shader", "empty", "--language", "glsl"], 3, "empty: input: found a folder, expected table, "),
        (&["shader", "some.ktx2", "--language", "glsl", "-o", "some.ktx2"], 2, "would overwrite the input some.ktx2"),
        (&["shader", "table", "--language", "glsl", "-o", "gone/x.glsl"], 4, "there is no folder gone"),
    ] {
        let ran = folder.run(arguments);
        assert!(ran.code == code && ran.stderr.contains(problem) && ran.stdout.is_empty(), "{arguments:?}: {ran:?}");
    }
    assert_eq!(folder.read("some.ktx2"), b"no pack");
}
