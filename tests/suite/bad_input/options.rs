//! Options without effect or with loss of data, and outputs that cannot be written: detected before the work.

use super::refused;
use crate::common::cli::Folder;

const SMALL: [&str; 4] = ["--texels", "8", "--views", "grid:2x3@40"];
const TILE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
const IMAGE: &str = "s/tl000 pl000 tv000 pv000.png";

/// A folder with one input of each kind.
fn inputs() -> Folder {
    let folder = Folder::new();
    folder.write("m.obj", TILE);
    folder
        .write("named.obj", TILE.replace("f 1 2 3", "usemtl clay\nf 1 2 3").replace("f 1 3 4", "usemtl tin\nf 1 3 4"));
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(8, 8).write_to(&mut png, image::ImageFormat::Png).unwrap();
    folder.write("h.png", png.get_ref());
    folder.write(IMAGE, png.get_ref());
    folder
}

#[test]
#[cfg(feature = "render")]
fn one_file_for_two_renderings() {
    let folder = inputs();
    let both = |code, options: &[&str], expected: &[&str]| {
        refused(&folder, &[&["render", "synth:lewis"][..], options].concat(), code, expected);
    };
    let expected = ["--output and --reference: both are same.png; choose different paths"];
    both(2, &["-o", "same.png", "--reference", "same.png", "--difference", "d.png"], &expected);
    both(2, &["-o", "a.png", "--sheet", "./s.png", "--difference", "s.png"], &["--difference and --sheet"]);
}

#[test]
fn options_that_go_with_another_input() {
    let folder = inputs();
    let structure = "synth:knit?resolution=16";
    for (input, options, expected) in [
        ("s", &["--views", "ubo2003"][..], "--views does not apply to an ordinary BTF, only to surfaces"),
        ("s", &["--lights", "ubo2003"], "--lights does not apply to an ordinary BTF"),
        ("s", &["--tile", "2"], "--tile does not apply to a plane, only to meshes"),
        ("s", &["--height-scale", "0.1"], "--height-scale does not apply to a plane, only to height maps"),
        ("s", &["--height-offset", "0"], "--height-offset does not apply to a plane"),
        ("s", &["--geometry", "h.png", "--tile", "1"], "--tile does not apply to a height map"),
        ("s", &["--geometry", "m.obj", "--height-scale", "1"], "--height-scale does not apply to a mesh"),
        (structure, &["--tile", "1"], "--tile does not apply to a structure"),
        (structure, &["--height-scale", "0.1"], "--height-scale does not apply to a structure"),
        (structure, &["--height-offset", "0"], "--height-offset does not apply to a structure"),
        ("m.obj", &["--height-scale", "0.1"], "--height-scale does not apply to a mesh"),
        ("m.obj", &["--height-offset", "0.1"], "--height-offset does not apply to a mesh"),
        ("h.png", &["--tile", "1"], "--tile does not apply to a height map"),
        ("h.png", &["--height-scale", "NaN"], "--height-scale: found NaN, expected -10 to 10"),
        (structure, &["--image-format", "exr"], "--image-format requires --write-images"),
        (
            structure,
            &["--reflectance", "brdf", "--fill", "poisson"],
            "--fill does not apply to --reflectance brdf, only to --reflectance factors",
        ),
        (
            structure,
            &["--reflectance", "brdf", "--max-bytes", "9KiB"],
            "--max-bytes does not apply to --reflectance brdf",
        ),
        (structure, &["--reflectance", "brdf", "--bounces", "4"], "--bounces does not apply to --reflectance brdf"),
        ("s", &["--reflectance", "brdf"], "--reflectance brdf does not apply to an ordinary BTF, only to surfaces"),
        (structure, &["--max-delta-e", "0"], "--max-delta-e: found 0, expected above 0, up to 100"),
        (structure, &["--max-bytes", "12"], "--max-bytes: found 12, expected "),
        (structure, &["--max-bytes", "20KiB", "--max-delta-e", "1"], "--max-bytes"),
        (structure, &["--weights", "h.png"], "--weights: found one material"),
        ("m.obj", &["--weights", "h.png", "--material", "synth:lambert"], "--weights: found one material"),
        (
            "named.obj",
            &["--material", "clay=synth:lambert", "--material", "clay=synth:lewis"],
            "--material: the name clay is given twice",
        ),
        (
            "named.obj",
            &["--material", "synth:lambert", "--material", "synth:lewis"],
            "--material: found 2 materials without a name, expected one, for clay, tin",
        ),
        (structure, &["--bounces", "4", "--write-images", "images"], "--write-images does not apply to --bounces"),
        (structure, &["--bounces", "4", "--write-flat", "raw"], "--write-flat does not apply to --bounces"),
        (structure, &["--views", "grid:1x6@50"], "--views: found \"grid:1x6@50\", expected 2 polar angles or more"),
        (structure, &["--texels", "24"], "--texels: found 24, expected a power of two from 4 to 2048"),
        (structure, &["--flat-texels", "2048"], "memory: found "),
        (structure, &["--max-bytes", "0"], "--max-bytes: found 0, expected "),
        (structure, &["--name", " "], "--name: found \" \", expected letters"),
        (structure, &["--name", "a "], "--name: found \"a \""),
    ] {
        let message = refused(&folder, &[&["flatten", input, "-o", "out"], options].concat(), 2, &[expected]);
        assert!(!message.contains("brdfc.flat-btf"), "{message}");
    }
    for out in ["..", "/"] {
        let words = ["--out: found \"", ", which names the asset, expected letters"];
        refused(&folder, &["flatten", structure, "-o", out], 2, &words);
    }
    let rest = ["--material", "clay=synth:lambert", "--material", "synth:lewis"];
    folder.run(&[&["flatten", "named.obj", "-o", "out"], &rest[..], &SMALL].concat()).succeeded();
}

#[test]
#[cfg(feature = "render")]
fn flat_btfs_that_are_not_drawn() {
    let folder = inputs();
    folder.run(&[&["flatten", "m.obj", "-o", "out"], &SMALL[..]].concat()).succeeded();
    refused(&folder, &["render", "out", "--filter", "nearest"], 2, &["--filter does not apply to out, a flat BTF"]);
    let mut file = folder.read("out/out.ktx2");
    let last = file.len() - 1;
    file[last] ^= 1;
    folder.write("out/out.ktx2", &file);
    refused(&folder, &["render", "out"], 3, &["out/out.ktx2: checksum of the file: found "]);
    folder.write("out/out.ktx2", &file[..last / 2]);
    refused(&folder, &["render", "out"], 3, &["out/out.ktx2: "]);
}

#[test]
fn folders_that_are_files_or_not_empty() {
    let folder = inputs();
    let knit = ["flatten", "synth:knit?resolution=16"];
    let with = |more: &[&str], code, expected: &[&str]| {
        refused(&folder, &[&knit[..], more, &SMALL].concat(), code, expected);
    };
    with(&["-o", "m.obj"], 4, &["m.obj: cannot write: not a folder"]);
    with(&["-o", "out", "--write-images", "m.obj"], 4, &["m.obj: cannot write: not a folder"]);
    with(
        &["-o", "out", "--write-images", "./out"],
        2,
        &["--out and --write-images: both are ./out; choose different paths"],
    );
    let full = ["--write-images: s is not empty; choose a new or empty folder"];
    with(&["-o", "out", "--write-images", "s"], 2, &full);
    with(&["-o", "out", "--write-flat", "s"], 2, &["--write-flat: s is not empty; choose a new or empty folder"]);
    let nested = ["--write-images", "raw/images", "--write-flat", "raw"];
    with(&[&["-o", "out"], &nested[..]].concat(), 2, &["--write-images and --write-flat: one is inside the other"]);
    assert!(!folder.path().join("out").exists(), "before the work");
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    folder.run(&[&knit[..], &["-o", "out", "--write-images", "empty"], &SMALL].concat()).succeeded();
    assert_eq!(folder.files("empty").len(), 16);
    // Images next to those of a BTF would be read as its own.
    for (flag, out) in [("--normals", "empty/n.png"), ("--web", "empty/web"), ("--albedo", "empty/new/a.png")] {
        let expected = format!("{flag}: {out} would be read as an image of empty; choose another folder");
        refused(&folder, &["pwt", "empty", "--view", "0", flag, out], 2, &[&expected]);
    }
    folder.run(&["pwt", "empty", "--view", "0", "-o", "empty/view.ktx2"]).succeeded();
}

#[test]
fn synth_files_of_another_kind() {
    let folder = Folder::new();
    for (model, output, options, expected) in [
        ("folds", "x.stl", &[][..], "--output: found x.stl, expected a name that ends in .binary"),
        ("folds", "x.binary", &[], "--output: found x.binary, expected a name that ends in .obj or .ply"),
        ("lewis", "x.obj", &[], "--output: found x.obj, expected a name that ends in .binary, .brdf or .csv"),
        (
            "folds",
            "y.ply",
            &["--rows", "5", "--noise", "NaN"],
            "--rows does not apply to y.ply, only to .brdf and .csv files",
        ),
        ("folds", "y.ply", &["--noise", "NaN"], "--noise does not apply to y.ply"),
        ("folds", "y.obj", &["--dimensions", "0x0x0"], "--dimensions does not apply to y.obj, only to .binary files"),
        ("lewis", "y.csv", &["--dimensions", "9x9x9"], "--dimensions does not apply to y.csv"),
        ("lewis", "y.binary", &["--seed", "1"], "--seed does not apply to y.binary"),
    ] {
        refused(&folder, &[&["synth", model, "-o", output], options].concat(), 2, &[expected]);
    }
    folder.run(&["synth", "folds?resolution=16", "-o", "x.PLY"]).succeeded();
    folder.run(&["info", "x.PLY"]).succeeded();
}

/// No memory and no time is spent on files that are not inputs.
#[test]
#[cfg(target_os = "linux")]
fn devices_and_files_without_end() {
    let folder = inputs();
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.brdf")).unwrap();
    for name in ["big.png", "big.csv", "big.ktx2", "big.obj", "big.toml"] {
        let file = std::fs::File::create(folder.path().join(name)).unwrap();
        file.set_len(30 << 30).unwrap();
    }
    let check_message = |arguments: &[&str], expected: &str| {
        let ran = folder.run(arguments);
        assert_eq!((ran.code, ran.stdout.as_str()), (3, ""), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    };
    check_message(&["info", "/dev/zero"], "/dev/zero: file: found a device, expected a file or a pipe");
    check_message(&["info", "zero.brdf"], "found a device");
    let length = "file length: found 30.00 GiB, expected at most ";
    check_message(&["flatten", "m.obj", "-o", "out", "--colour", "big.png"], length);
    check_message(&["flatten", "m.obj", "-o", "out", "--views", "big.csv"], length);
    check_message(&["flatten", "big.obj", "-o", "out"], length);
    check_message(&["info", "big.ktx2"], length);
    check_message(&["compare", "synth:lewis", "synth:lewis", "--directions", "big.csv"], length);
    check_message(&["build", "big.toml", "--dry-run"], length);
    assert!(!folder.path().join("out").exists());
}

#[test]
fn colours_that_are_no_srgb_codes() {
    let folder = inputs();
    let mut exr = std::io::Cursor::new(Vec::new());
    let image = image::Rgb32FImage::from_pixel(4, 4, image::Rgb([2.0f32; 3]));
    image::DynamicImage::from(image).write_to(&mut exr, image::ImageFormat::OpenExr).unwrap();
    folder.write("x.exr", exr.get_ref());
    let flatten = ["flatten", "m.obj", "-o", "out", "--colour", "x.exr"];
    refused(&folder, &flatten, 3, &["x.exr: image: found OpenExr, expected a complete PNG or JPEG"]);
    // Truncated: the error is not in the channels.
    folder.write("cut.exr", &exr.get_ref()[..exr.get_ref().len() / 2]);
    refused(&folder, &["info", "cut.exr"], 3, &["cut.exr: EXR: ", "; expected a complete EXR"]);
}

/// The header of a PNG says 2e9 x 2e9.
#[test]
fn images_of_a_stack_that_declare_too_much() {
    let folder = inputs();
    let mut bytes = folder.read(IMAGE);
    bytes[16..24].copy_from_slice(&[2_000_000_000u32.to_be_bytes(), 2_000_000_000u32.to_be_bytes()].concat());
    let mut crc = u32::MAX;
    for byte in &bytes[12..29] {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = (crc >> 1) ^ (0xedb8_8320 * (crc & 1)));
    }
    bytes[29..33].copy_from_slice(&(!crc).to_be_bytes());
    folder.write(IMAGE, bytes);
    let message = refused(
        &folder,
        &["flatten", "s", "-o", "out"],
        3,
        &["image size: found 2000000000 x 2000000000, expected 1 to 16384"],
    );
    assert!(!message.contains("emory"), "{message}");
}

#[test]
fn outputs_that_are_inputs() {
    let folder = inputs();
    std::fs::create_dir(folder.path().join("packs")).unwrap();
    folder.run(&["encode", "synth:velvet", "--grid", "4", "-o", "packs/a.brdf.ktx2"]).succeeded();
    let retained = folder.read("packs/a.brdf.ktx2");
    folder.write("packs/s.toml", "[materials.a]\nsource = 'a.brdf.ktx2'\n[[uses]]\nmaterial = 'a'\n");
    let ran = folder.run(&["build", "packs/s.toml", "--out", "packs"]);
    assert_eq!(ran.code, 2, "{}", ran.stderr);
    assert!(ran.stderr.contains("--out: would overwrite the input packs/a.brdf.ktx2; choose"), "{}", ran.stderr);
    assert_eq!(folder.read("packs/a.brdf.ktx2"), retained);
    folder.write("packs/report.json", "[materials.b]\nsource = 'synth:velvet'\n[[uses]]\nmaterial = 'b'\n");
    let ran = folder.run(&["build", "packs/report.json", "--out", "packs", "--force"]);
    assert!(ran.code == 2 && ran.stderr.contains("would overwrite the input packs/report.json"), "{}", ran.stderr);
    let sky = std::fs::read(brdfc_testing::testdata("demo/sky.hdr")).unwrap();
    folder.write("sky.exr", &sky);
    let lit = "[scene]\nenvironment = 'sky.exr'\n[materials.a]\nsource = 'synth:velvet'\n[[uses]]\nmaterial = 'a'\n";
    folder.write("lit.toml", lit);
    let ran = folder.run(&["render", "lit.toml", "-o", "sky.exr"]);
    assert!(ran.code == 2 && ran.stderr.contains("--output: would overwrite the input sky.exr"), "{}", ran.stderr);
    assert_eq!(folder.read("sky.exr"), sky);
    folder.write("stack/views.csv", "");
    let ran = folder.run(&["flatten", "stack", "--out", "stack/../stack"]);
    assert!(ran.code == 2 && ran.stderr.contains("; choose different paths"), "{}", ran.stderr);
}

#[test]
fn negative_numbers_are_values_and_not_flags() {
    let folder = inputs();
    for (arguments, expected) in [
        (["encode", "synth:velvet", "-o", "a.ktx2", "--max-error", "-1"], "--max-error: found -1, expected"),
        (["eval", "synth:velvet", "--directions", "a.csv", "--lod", "-1"], "--lod: found -1, expected 0"),
    ] {
        let ran = folder.run(&arguments);
        assert!(ran.code == 2 && ran.stderr.contains(expected), "{}", ran.stderr);
    }
}

/// An error budget that has nothing to measure is not met.
#[test]
fn an_error_budget_of_a_black_material_fails() {
    let folder = inputs();
    let ran = folder.run(&["encode", "synth:lambert?kd=0", "-o", "a.ktx2", "--grid", "4", "--max-error", "0.01"]);
    assert!(ran.code == 1 && ran.stderr.contains("the material is black everywhere"), "{}", ran.stderr);
    folder.run(&["encode", "synth:lambert?kd=0", "-o", "a.ktx2", "--grid", "4"]).succeeded();
}
