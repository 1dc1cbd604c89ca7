//! Geometry, images and options that 'brdfc flatten' rejects.

use super::refused;
use crate::common::cli::{Folder, states_what_is_expected};

/// Two triangles over the unit tile.
const TILE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";

fn bad_mesh(text: &str, expected: &[&str]) {
    let folder = Folder::new();
    folder.write("m.obj", text);
    let all = [&["brdfc: m.obj: "], expected].concat();
    let message = refused(&folder, &["flatten", "m.obj", "-o", "out", "--texels", "8"], 3, &all);
    assert!(states_what_is_expected(&message), "{message}");
}

#[test]
fn the_tile_of_these_tests_is_a_surface() {
    let folder = Folder::new();
    folder.write("m.obj", TILE);
    let small = ["--texels", "8", "--views", "grid:2x3@40"];
    folder.run(&[&["flatten", "m.obj", "-o", "out"], &small[..]].concat()).succeeded();
}

#[test]
fn meshes_that_are_no_periodic_surface() {
    bad_mesh("", &["m.obj"]);
    bad_mesh("v 0 0 nan\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", &["line 1"]);
    bad_mesh("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 9\n", &["line 4"]);
    bad_mesh("v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n", &["one triangle", "hole"]);
    bad_mesh("v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3\nf 1 3 4\n", &["--tile 2"]);
    bad_mesh(&format!("{TILE}v 0.2 0.2 1\nf 1 2 5\n"), &["more than two triangles"]);
    bad_mesh("v 0 0 0\nv 0 0 0\nv 0 0 0\nf 1 2 3\n", &["triangles"]);
}

#[test]
fn zero_area_tiles_and_unknown_names() {
    let folder = Folder::new();
    folder.write("m.obj", TILE);
    for tile in ["0", "nan", "inf"] {
        let expected = ["--tile: found ", ", expected a finite length above 0"];
        refused(&folder, &["flatten", "m.obj", "-o", "out", "--tile", tile], 2, &expected);
    }
    // A file that is no flat BTF has the errors of reading one.
    folder.write("cut.ktx2", "");
    refused(&folder, &["report", "cut.ktx2", "-o", "cut.html"], 3, &["cut.ktx2"]);
    refused(&folder, &["flatten", "m.xyz", "-o", "out"], 4, &["m.xyz"]);
    folder.write("m.xyz", "");
    refused(&folder, &["flatten", "m.xyz", "-o", "out"], 3, &["extension .xyz", ".obj"]);
    refused(&folder, &["flatten", "synth:buton", "-o", "out"], 3, &["did you mean button?"]);
    refused(&folder, &["flatten", "synth:button?count=900", "-o", "out"], 3, &["count of button"]);
    refused(&folder, &["flatten", "m.obj", "-o", "out", "--material", "clay=synth:lambert"], 2, &["clay"]);
}

#[test]
fn options_out_of_range() {
    let folder = Folder::new();
    for (option, value, allowed) in [
        ("--texels", "2", "4 to 2048"),
        ("--flat-texels", "100", "a power of two"),
        ("--texels", "24", "a power of two"),
        ("--flat-texels", "4096", "4 to 2048"),
        ("--bounces", "1025", "0 to 1024"),
        ("--views", "ubo", "ubo2003"),
        ("--views", "grid:4@10", "grid:5x12@75"),
        ("--name", "../x", "letters"),
        ("--height-scale", "nan", "-10 to 10"),
    ] {
        let wrong = ["flatten", "synth:button?resolution=16", "-o", "out", option, value];
        refused(&folder, &wrong, 2, &[option.trim_start_matches('-'), "found ", allowed]);
    }
    let wrong = ["flatten", "synth:button?resolution=16", "-o", "out", "--geometry", "synth:button"];
    refused(&folder, &wrong, 2, &["--geometry does not apply to surfaces", "folder of images"]);
}

fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = Vec::new();
    let pixels = vec![128u8; 3 * (width * height) as usize];
    let mut writer = std::io::Cursor::new(&mut bytes);
    image::write_buffer_with_format(
        &mut writer,
        &pixels,
        width,
        height,
        image::ColorType::Rgb8,
        image::ImageFormat::Png,
    )
    .unwrap();
    bytes
}

#[test]
fn stacks_with_gaps_or_odd_images() {
    let stack = |files: &[(&str, u32)], expected: &[&str]| {
        let folder = Folder::new();
        for (name, size) in files {
            folder.write(&format!("s/{name}"), png(*size, *size));
        }
        let message = refused(&folder, &["flatten", "s", "-o", "out"], 3, expected);
        assert!(states_what_is_expected(&message), "{message}");
    };
    let name = "tv000_pv000/00000 tl000 pl000 tv000 pv000.png";
    stack(&[(name, 8), ("tv000_pv000/00001 tl015 pl000 tv000 pv000.png", 9)], &["9"]);
    stack(&[(name, 8), ("tv015_pv000/00001 tl015 pl000 tv015 pv000.png", 8)], &["missing", "tl"]);
    stack(&[("tv000_pv000/00000 tl000 tv000 pv000.png", 8)], &["pl"]);
    stack(&[("readme.txt", 8)], &["image"]);
}
