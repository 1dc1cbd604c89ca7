//! `brdfc info`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_testing::packs::sealed;

#[test]
fn files_of_what_is_not_there_cannot_be_read() {
    let folder = Folder::new();
    folder.write("some.txt", b"no pack");
    for (name, code, problem) in [
        ("gone", 4, "gone: cannot read"),
        ("some.txt", 3, "some.txt: file name: found extension .txt, expected a pack"),
    ] {
        let ran = folder.run(&["info", name, "--files"]);
        assert!(ran.code == code && ran.stderr.contains(problem), "{name}: {}", ran.stderr);
    }
}

#[test]
fn every_kind_is_named_with_its_sizes() {
    let folder = Folder::new();
    let [table, round, brushed, rgl, model] = inputs(&folder);
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    for (input, kind, words) in [
        (table, "merl", "12 x 12 x 24"),
        (round, "scan", "31 wavelengths, 400 to 700 nm"),
        (brushed, "scan", "anisotropic"),
        (rgl, "rgl", "4 x 4"),
        (model, "synth", "synth:ward?kd=0.2,0.1,0.1&ks=0.1&ax=0.15&ay=0.5"),
        ("p.ktx2", "wavelet-pack", "4 x 4 per hemisphere"),
    ] {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        conforms("info", &report);
        assert_eq!(report["kind"], kind);
        let ran = folder.run(&["info", input]).succeeded();
        assert!(ran.stdout.contains(words), "{input}: {}", ran.stdout);
        // The scans are small.
        let of_gaps = ran.stderr.lines().all(|line| line.contains(": the samples do not determine the material: "));
        assert!(of_gaps && ran.stderr.is_empty() == (kind != "scan"), "{input}: {}", ran.stderr);
    }
}

#[test]
fn files_are_listed_with_their_metadata() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lambert?kd=0.5", "-o", "it.ktx2"]).succeeded();
    let printed = folder.run(&["info", "it.ktx2", "--files", "--json"]).succeeded().json();
    conforms("files", &printed);
    let file = &printed["files"]["it.ktx2"];
    assert_eq!((file["dimension"].as_str(), file["levels"].as_u64()), (Some("3d"), Some(1)));
    // As the report of the encoding states.
    let encoded = folder.run(&["encode", "synth:lambert?kd=0.5", "-o", "it.ktx2", "--json"]).succeeded().json();
    assert!(file["entries"]["brdfc.table"].is_string());
    assert!(encoded.to_string().contains(&file["entries"]["brdfc.table"].to_string()));
    let table = folder.run(&["info", "it.ktx2", "--files"]).succeeded().stdout;
    assert!(table.contains("it.ktx2") && table.contains(" brdfc.table "), "{table}");
    // Required features of a device.
    assert!(folder.run(&["info", "it.ktx2"]).succeeded().stdout.contains("any with WebGPU or WebGL 2"));
    let fine =
        ["encode", "synth:ggx?alpha=0.3", "--codec", "wavelet", "--ratio", "2", "--bits", "12", "-o", "fine.ktx2"];
    folder.run(&fine).succeeded();
    let words = folder.run(&["info", "fine.ktx2"]).succeeded().stdout;
    assert!(
        words.contains("texture-formats-tier1 of WebGPU") && words.contains("more than WebGL 2 guarantees"),
        "{words}"
    );
    for other in ["synth:lambert", "fine.ktx"] {
        let ran = folder.run(&["info", other, "--files"]);
        assert!(ran.code >= 2 && !ran.stderr.is_empty());
    }
    // A flat BTF has several.
    let small = ["--texels", "16", "--views", "grid:2x6@50", "--lights", "grid:2x6@50"];
    folder.run(&[&["flatten", "synth:button?resolution=24", "-o", "button"][..], &small].concat()).succeeded();
    let printed = folder.run(&["info", "button", "--files", "--json"]).succeeded().json();
    conforms("files", &printed);
    assert!(printed["files"]["button.ktx2"]["entries"]["brdfc.flat-btf.layers"].is_string());
    for (image, format) in [
        ("flat_btf_heights", "rgba8unorm"),
        ("flat_btf_displacements", "rg16float"),
        ("factored_tables", "rgba16float"),
    ] {
        assert_eq!(printed["files"][format!("button.ktx2#brdfc.image.{image}")]["texel_format"], format);
    }
    // Its own texels are the weights.
    assert_eq!(printed["files"].as_object().unwrap().len(), 4);
    assert!(folder.run(&["info", "button"]).succeeded().stdout.contains("devices "));
}

#[test]
fn symmetries_are_reported() {
    let folder = Folder::new();
    let symmetry = |input: &str| {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        ["isotropic", "mirror", "reciprocal"].map(|key| report["symmetry"][key].as_bool().unwrap())
    };
    assert_eq!(symmetry("synth:ggx"), [true; 3]);
    assert_eq!(symmetry("synth:ward"), [false, true, true]);
    folder.run(&["synth", "ggx", "-o", "a.binary", "--dimensions", "6x6x12"]).succeeded();
    assert_eq!(symmetry("a.binary"), [true; 3]);
    let mut bytes = folder.read("a.binary");
    // One cell off the plane of incidence, twice as bright in red: its mirror image is another cell.
    let cell = 12 + 8 * (2 * 6 * 12 + 2 * 12 + 3);
    let red = f64::from_le_bytes(bytes[cell..cell + 8].try_into().unwrap());
    assert!(red > 0.0);
    bytes[cell..cell + 8].copy_from_slice(&(2.0 * red).to_le_bytes());
    folder.write("b.binary", &bytes);
    assert_eq!(symmetry("b.binary"), [true, false, true]);
}

#[test]
fn the_case_of_the_extension_does_not_matter() {
    let folder = Folder::new();
    folder.run(&["synth", "ggx", "-o", "a.binary", "--dimensions", "6x6x12"]).succeeded();
    folder.write("B.BINARY", folder.read("a.binary"));
    folder.run(&["info", "B.BINARY"]).succeeded();
    folder.write("c.data", folder.read("a.binary"));
    let ran = folder.run(&["info", "c.data"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("c.data: file name: found extension .data, expected .binary (MERL)"), "{}", ran.stderr);
}

#[test]
fn importance_samples_are_distinguished_from_other_packs() {
    let folder = Folder::new();
    let header = ImportanceHeader { polar: 2, azimuths: 4, samples: 3 };
    let bytes = ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 24]).unwrap().to_bytes(true);
    folder.write("p.ktx2", &bytes);
    let report = folder.run(&["info", "p.ktx2", "--json"]).succeeded().json();
    conforms("info", &report);
    assert_eq!((&report["kind"], &report["samples"]), (&"importance-pack".into(), &3.into()));
    let text = folder.run(&["info", "p.ktx2"]).succeeded().stdout;
    assert!(text.contains("2 polar angles x 4 azimuths") && text.contains("384 B"), "{text}");
    // A damaged one is still identified, and other commands report what is missing.
    let mut texels = vec![[0.0, 0.0, 1.0, 1.0]; 24];
    texels[5][3] = 2.0;
    let bytes = ImportancePack::new(header, texels).unwrap().to_bytes(false);
    let at = bytes.windows(4).rposition(|word| word == 2.0f32.to_le_bytes()).unwrap();
    folder.write("q.ktx2", sealed([&bytes[..at], &(-2.0f32).to_le_bytes(), &bytes[at + 4..]].concat()));
    let ran = folder.run(&["info", "q.ktx2"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("q.ktx2: importance texel (2, 1)"), "{}", ran.stderr);
    let ran = folder.run(&["compare", "p.ktx2", "synth:ggx"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("pack: found an importance-sample pack, expected a pack of a BRDF"), "{}", ran.stderr);
}

#[test]
fn polynomial_wavelet_trees_are_distinguished_from_other_packs() {
    let folder = Folder::new();
    let bytes = brdfc_testing::codecs::pwt::example().to_bytes(true);
    folder.write("p.ktx2", &bytes);
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    let report = folder.run(&["info", "p.ktx2", "--json"]).succeeded().json();
    conforms("info", &report);
    assert_eq!((&report["kind"], &report["size"]), (&"pwt-pack".into(), &serde_json::json!([2, 2])));
    assert_eq!((&report["coordinates"], &report["gpu_bytes"]), (&"projected".into(), &6.into()));
    assert_eq!(report["textures"][1], serde_json::json!({ "level": 1, "size": [1, 1], "layers": 1, "channels": 1 }));
    assert_eq!((&report["errors"]["lights"], &report["errors"]["psnr"]), (&3.into(), &40.0.into()));
    let text = folder.run(&["info", "p.ktx2"]).succeeded().stdout;
    for words in ["polynomial wavelet tree", "2 x 2, a tile", "level 1: 1 x 1", "PSNR 40.00 dB", "6 B"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    // A damaged one is reported by its field, and commands that need a BRDF report the kind.
    let at = bytes.windows(4).position(|word| word == 35.0f32.to_le_bytes()).unwrap();
    folder.write("q.ktx2", sealed([&bytes[..at], &f32::NAN.to_le_bytes(), &bytes[at + 4..]].concat()));
    let ran = folder.run(&["info", "q.ktx2"]);
    assert_eq!(ran.code, 3);
    assert!(ran.stderr.contains("q.ktx2: brdfc.pwt held-out psnr: found NaN"), "{}", ran.stderr);
    for arguments in [
        &["compare", "p.ktx2", "synth:ggx"][..],
        &["encode", "p.ktx2", "-o", "o.ktx2"],
        &["samples", "p.ktx2", "-o", "o.ktx2"],
        &["bandwidth", "p.ktx2", "-o", "o.ktx2"],
    ] {
        let ran = folder.run(arguments);
        assert_eq!(ran.code, 3, "{arguments:?}: {}", ran.stderr);
        let expected = "pack: found a polynomial wavelet tree, expected a pack of a BRDF";
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
}

/// Two triangles over a tile of side `side`.
fn tile(side: &str) -> String {
    "v 0 0 0.1\nv S 0 0.1\nv S S 0.1\nv 0 S 0.1\nusemtl clay\nf 1 2 3\nf 1 3 4\n".replace('S', side)
}

#[test]
fn what_flatten_takes_is_described() {
    let folder = Folder::new();
    folder.write("tile.obj", tile("2.5"));
    folder.write("over.obj", tile("1").replace("f 1 3 4", "f 4 3 1\nf 4 3 1"));
    folder.write("open.obj", tile("1").replace("f 1 3 4\n", ""));
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_fn(8, 6, |x, _| image::Luma([51 * (x as u8 % 6)]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    folder.write("h.png", png.get_ref());
    let name = |light: &str, view: &str| format!("s/tl{light} pl000 tv{view} pv000.png");
    for (light, view) in [("000", "000"), ("030", "000"), ("000", "030")] {
        folder.write(&name(light, view), png.get_ref());
    }
    let info = |input: &str| {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        conforms("info-surface", &report);
        let text = folder.run(&["info", input]).succeeded();
        assert_eq!(text.stderr, "");
        (report, text.stdout)
    };
    let (mesh, text) = info("tile.obj");
    assert_eq!((&mesh["kind"], &mesh["triangles"], &mesh["tile"]), (&"mesh".into(), &2.into(), &2.5.into()));
    assert_eq!((&mesh["materials"][0], &mesh["bounds"][0][1]), (&"clay".into(), &2.5.into()));
    assert!(text.contains("with --tile 2.5") && text.contains("clay"), "{text}");
    assert!(text.lines().any(|line| line.starts_with("repaired ") && line.ends_with("nothing")), "{text}");
    let (over, text) = info("over.obj");
    assert_eq!(over["repaired"]["duplicate_triangles"], 1);
    assert!(text.contains("1 duplicate triangles were left out; 1 triangles were turned over"), "{text}");
    let (open, text) = info("open.obj");
    assert!(open["tile"].is_null() && open["problem"].as_str().unwrap().contains("hole"), "{open}");
    assert!(text.contains("does not close"), "{text}");
    let (heights, text) = info("h.png");
    assert_eq!(
        (&heights["kind"], &heights["size"][0], &heights["values"][1]),
        (&"height-map".into(), &8.into(), &1.0.into())
    );
    assert!(text.contains("8 x 6") && text.contains("0 to 1"), "{text}");
    let (stack, text) = info("s");
    assert_eq!(
        (&stack["views"], &stack["lights"], &stack["images"], &stack["missing"]),
        (&2.into(), &2.into(), &3.into(), &1.into())
    );
    assert_eq!(stack["extensions"][0], "png");
    assert!(text.contains("1; 'brdfc flatten' requires all"), "{text}");
    let (structure, text) = info("synth:button?resolution=16");
    assert_eq!((&structure["kind"], &structure["triangles"]), (&"structure".into(), &512.into()));
    assert!(text.contains("synth:button?resolution=16&height=1"), "{text}");
    let wrong = folder.run(&["info", "synth:buton"]);
    assert!(wrong.code == 3 && wrong.stderr.contains("structures: button, folds"), "{}", wrong.stderr);
    let wrong = folder.run(&["info", "synth:button?resolution=1"]);
    assert!(wrong.code == 3 && wrong.stderr.contains("resolution of button"), "{}", wrong.stderr);
}

#[test]
fn flat_btfs_and_damaged_ones() {
    let folder = Folder::new();
    let small = ["--texels", "8", "--views", "grid:2x3@40"];
    folder.run(&[&["flatten", "synth:knit?resolution=16", "-o", "knit"], &small[..]].concat()).succeeded();
    let file = "knit/knit.ktx2";
    let whole = folder.run(&["info", file, "--json"]).succeeded().json();
    conforms("flat-btf", &whole);
    assert_eq!(folder.run(&["info", "knit", "--json"]).succeeded().json(), whole);
    assert_eq!(whole["bytes"].as_u64(), Some(folder.read(file).len() as u64));
    let images = whole["images"].as_object().unwrap();
    assert_eq!(images.values().map(|bytes| bytes.as_u64().unwrap()).sum::<u64>(), whole["gpu_bytes"].as_u64().unwrap());
    let ran = folder.run(&["compare", "synth:lewis", file]);
    assert_eq!(ran.code, 3);
    let expected = "found a flat BTF, expected a pack of a BRDF; a flat BTF has no single BRDF";
    assert!(ran.stderr.contains(expected), "{}", ran.stderr);
    // Two in a folder must be distinguished.
    folder.write("two/a.ktx2", folder.read(file));
    folder.write("two/b.ktx2", folder.read(file));
    let ran = folder.run(&["info", "two"]);
    assert!(
        ran.code == 3 && ran.stderr.contains("flat BTFs: found a.ktx2, b.ktx2, expected a folder with one flat BTF"),
        "{}",
        ran.stderr
    );
    let bytes = folder.read(file);
    for at in [0, 100, bytes.len() / 2, bytes.len() - 1] {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1;
        folder.write(file, damaged);
        for arguments in [["info", file], ["report", "knit"]] {
            let more: &[&str] = if arguments[0] == "report" { &["-o", "page.html"] } else { &[] };
            let ran = folder.run(&[&arguments[..], more].concat());
            // A folder without any of our files is one of a build, whose report is missing.
            let code = if at == 0 && arguments[0] == "report" { 4 } else { 3 };
            assert_eq!(ran.code, code, "{at} {arguments:?} {}", ran.stderr);
        }
    }
}

#[test]
fn the_plane_has_a_name_and_no_negative_heights() {
    let folder = Folder::new();
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(8, 8, image::Luma([128])).write_to(&mut png, image::ImageFormat::Png).unwrap();
    folder.write("s/tl000 pl000 tv000 pv000.png", png.get_ref());
    let ran = folder.run(&["flatten", "s", "-o", "out", "--texels", "8"]).succeeded();
    assert!(ran.stdout.contains("s over the plane") && ran.stdout.contains("0.0000 to 0.0000 tiles"), "{}", ran.stdout);
    assert!(!ran.stdout.contains("-0.0"), "{}", ran.stdout);
}

/// An RTI capture of two images, one of them in a folder, and a polynomial texture map.
#[test]
fn renderings_under_many_lights_are_described() {
    let folder = Folder::new();
    for name in ["s/a 1.png", "s/in/b.png"] {
        let mut png = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(8, 6).write_to(&mut png, image::ImageFormat::Png).unwrap();
        folder.write(name, png.get_ref());
    }
    folder.write("s/lights.lp", "2\r\na 1.png 0 0 3\r\nin\\b.png 1 0 1\r\n");
    let header = "PTM_1.2\nPTM_FORMAT_LRGB\n1 1\n2 2 2 2 2 0.5 160 160 160 127 127 0\n";
    let ptm = [header.as_bytes(), &[255; 9]].concat();
    folder.write("icon.ptm", &ptm);
    let info = |input: &str| {
        let report = folder.run(&["info", input, "--json"]).succeeded().json();
        conforms("info", &report);
        (report, folder.run(&["info", input]).succeeded().stdout)
    };
    for input in ["s", "s/lights.lp"] {
        let (report, text) = info(input);
        assert_eq!((&report["kind"], &report["lights"]), (&"rti-capture".into(), &2.into()));
        assert_eq!((&report["size"][0], &report["polar_angles"][1]), (&8.into(), &45.0.into()));
        assert!(text.contains("0 to 45 degrees") && text.contains("8 x 6") && text.contains(".png"), "{text}");
    }
    let (report, text) = info("icon.ptm");
    assert_eq!((&report["kind"], &report["format"]), (&"ptm".into(), &"PTM_FORMAT_LRGB".into()));
    assert_eq!((&report["scale"][5], &report["bias"][0]), (&0.5.into(), &160.into()));
    assert!(text.contains("polynomial texture map") && text.contains("2 2 2 2 2 0.5"), "{text}");
    let piped = folder.command(&["info", "-", "--json"]).write_stdin(ptm).output().unwrap();
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&piped.stdout).unwrap(), report);
}

#[test]
fn damaged_packs_and_folders_of_packs() {
    let folder = Folder::new();
    folder.run(&["build", "synth:lambert", "synth:ward", "--max-bytes", "1KiB", "--out", "packs"]).succeeded();
    let ran = folder.run(&["info", "packs"]);
    let remedy = "; name one of its packs, or use 'brdfc report'\n";
    assert!(ran.code == 3 && ran.stderr.starts_with("brdfc: packs: input: found the output of a build"), "{ran:?}");
    assert!(ran.stderr.ends_with(remedy), "{ran:?}");
    std::fs::remove_file(folder.path().join("packs/report.json")).unwrap();
    let ran = folder.run(&["info", "packs"]);
    let found = "brdfc: packs: input: found a folder of packs without the report of a build, expected ";
    assert!(
        ran.code == 3 && ran.stderr.starts_with(found) && ran.stderr.ends_with("; name one of its packs\n"),
        "{ran:?}"
    );
    let mut bytes = folder.read("packs/ward.brdf.ktx2");
    let last = bytes.len() - 1;
    bytes[last] ^= 1;
    folder.write("damaged.ktx2", bytes);
    let [whole, files] =
        [&["info", "damaged.ktx2"][..], &["info", "damaged.ktx2", "--files"]].map(|run| folder.run(run));
    assert!(whole.code == 3 && whole.stderr.contains("checksum"), "{whole:?}");
    assert_eq!((files.code, files.stderr), (whole.code, whole.stderr));
}
