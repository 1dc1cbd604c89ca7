//! Every kind of input with every command: the table of `docs/inputs.md`.

use super::pwt::stack;
use super::pwt_views::{btf, ring};
use crate::common::cli::{Folder, states_what_is_expected};
use brdfc_formats::PackKind;
use brdfc_testing::codecs::tested;
use brdfc_testing::viewer_files::rti;
use std::collections::BTreeMap;
use std::path::Path;

/// The commands of the table, with the arguments after the input.
const COMMANDS: [(&str, &[&str]); 7] = [
    ("info", &[]),
    ("encode", &["--codec", "table", "--max-bytes", "4KiB", "--trust-fit", "-o", "out.ktx2"]),
    ("build", &["--out", "out"]),
    ("pwt", &["-o", "out.ptm"]),
    ("flatten", &["--texels", "8", "--flat-texels", "8", "-o", "out"]),
    ("view", &["-o", "out.html"]),
    ("report", &["-o", "out.html"]),
];

/// Commands by row of the table, in the order of the page.
fn rows() -> Vec<(String, Vec<String>)> {
    let page = include_str!("../../../docs/inputs.md");
    let section = page.split("\n## Which command takes what\n").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows = section.lines().filter(|line| line.starts_with("| ")).skip(1);
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        (cells[0].to_owned(), cells[2].split_whitespace().map(|name| name.trim_matches('`').to_owned()).collect())
    };
    rows.map(row).collect()
}

/// Inputs of each row.
fn inputs(folder: &Folder) -> BTreeMap<&'static str, Vec<String>> {
    let pack = |kind: PackKind| {
        let name = format!("packs/{}.ktx2", kind.name());
        folder.write(&name, tested(kind).small_pack(true));
        name
    };
    let run = |arguments: &[&str]| {
        folder.run(arguments).succeeded();
    };
    std::fs::create_dir(folder.path().join("packs")).unwrap();
    run(&["synth", "lambert", "-o", "table.binary", "--dimensions", "8x8x8"]);
    run(&["encode", "table.binary", "--codec", "table", "--max-bytes", "4KiB", "--trust-fit", "-o", "table.ktx2"]);
    run(&["synth", "lambert", "-o", "scan.csv", "--rows", "100"]);
    run(&["synth", "button?resolution=16", "-o", "mesh.obj"]);
    folder.write("h.rti", rti([4, 4], &[1.0; 4], &[0.0; 4], &[99; 4 * 4 * 3 * 4]));
    let grey = image::GrayImage::from_fn(8, 8, |x, y| image::Luma([(10 * x + 9 * y) as u8]));
    grey.save(folder.path().join("heights.png")).unwrap();
    btf(folder, "tile", &ring(&[40.0]));
    let sky = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo/sky.hdr");
    folder.write("sky.hdr", std::fs::read(sky).unwrap());
    run(&["build", "synth:lambert", "--out", "built", "--codec", "table", "--max-bytes", "4KiB"]);
    let manifest = "[materials.a]\nsource = \"synth:lambert\"\n[[uses]]\nmaterial = \"a\"\n";
    folder.write("scene.toml", manifest);
    run(&[
        "flatten",
        "synth:button?resolution=16",
        "--texels",
        "8",
        "--flat-texels",
        "8",
        "--reflectance",
        "factors",
        "-o",
        "flat",
    ]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    folder.write("notes.txt", "no input");
    let of = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    BTreeMap::from([
        ("analytic model", of(&["synth:lambert"])),
        ("structure", of(&["synth:button?resolution=16"])),
        ("table of a BRDF", of(&["table.binary"])),
        ("scan", of(&["scan.csv"])),
        ("pack of a BRDF", of(&["table.ktx2"])),
        ("pack of lobes", vec![pack(PackKind::Lobes)]),
        (
            "prefiltered environment, bandwidth map, importance samples",
            [PackKind::Environment, PackKind::Bandwidth, PackKind::Importance].map(pack).to_vec(),
        ),
        ("flat BTF", of(&["flat", "flat/flat.ktx2"])),
        ("polynomial wavelet tree", vec![pack(PackKind::Pwt)]),
        ("RTI capture", of(&["stack", "stack/dirs.lp"])),
        ("file of an RTI viewer", of(&["h.rti"])),
        ("ordinary BTF", of(&["tile"])),
        ("latitude-longitude image", of(&["sky.hdr"])),
        ("mesh", of(&["mesh.obj"])),
        ("height map", of(&["heights.png"])),
        ("manifest", of(&["scene.toml"])),
        ("output of a build", of(&["built", "built/report.json"])),
        ("any other folder or file", of(&["empty", "packs", "notes.txt"])),
    ])
}

#[test]
fn the_table_of_kinds_and_commands_is_true() {
    let folder = stack();
    let inputs = inputs(&folder);
    let rows = rows();
    assert_eq!(rows.len(), inputs.len(), "a row has no input here");
    let mut wrong = Vec::new();
    for (kind, taken) in &rows {
        for name in taken {
            assert!(COMMANDS.iter().any(|(command, _)| command == name), "{name} is not tried");
        }
        for input in inputs.get(kind.as_str()).unwrap_or_else(|| panic!("no input for {kind}")) {
            for (command, arguments) in COMMANDS {
                let ran = folder.run(&[&[command, input.as_str()][..], arguments].concat());
                let is_taken = taken.iter().any(|name| name == command);
                let message = &ran.stderr;
                let explains = states_what_is_expected(message) || message.contains("cannot read");
                let right = if is_taken { ran.code == 0 } else { (1..=4).contains(&ran.code) && explains };
                if !right {
                    wrong.push(format!("{command} {input} ({kind}): exit code {}: {message}", ran.code));
                }
                let _ = std::fs::remove_dir_all(folder.path().join("out"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join(""));
}
