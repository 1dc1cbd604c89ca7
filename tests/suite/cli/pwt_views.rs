//! `brdfc pwt --view all`: packs of all views of a BTF.

use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_jobs::btf_stack::{StackFormat, write_image};
use brdfc_readers::btf_stack::ImageAngles;
use std::path::{Path, PathBuf};

const SIZE: usize = 16;

fn unit([polar, azimuth]: [f64; 2]) -> [f32; 3] {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()].map(|c| c as f32)
}

/// The pole and rings of six directions.
pub(super) fn ring(polar: &[f64]) -> Vec<[f64; 2]> {
    let of_ring = |polar: &f64| (0..6).map(|k| [*polar, 60.0 * f64::from(k)]).collect::<Vec<_>>();
    [[0.0, 0.0]].into_iter().chain(polar.iter().flat_map(of_ring)).collect()
}

/// A wavy Lambertian tile, darker at the left for views from there, as a folder of images.
pub(super) fn btf(folder: &Folder, name: &str, views: &[[f64; 2]]) {
    let lights = ring(&[30.0, 60.0]);
    for (number, (view, light)) in
        views.iter().flat_map(|view| lights.iter().map(move |light| (view, light))).enumerate()
    {
        let ([tint, ..], l) = (unit(*view), unit(*light));
        let pixel = |at: usize| {
            let (x, y) = ((at % SIZE) as f32, (at / SIZE) as f32);
            let slope = [(x * std::f32::consts::TAU / 16.0).sin(), (y * std::f32::consts::TAU / 8.0).sin()];
            let cosine = l[2] - 0.4 * (slope[0] * l[0] + slope[1] * l[1]);
            [0.7, 0.5 + 0.3 * tint, 0.3].map(|albedo| (albedo * cosine).max(0.0))
        };
        let pixels: Vec<_> = (0..SIZE * SIZE).map(pixel).collect();
        let angles = ImageAngles { view: *view, light: *light };
        write_image(&folder.path().join(name), number, angles, &pixels, [SIZE; 2], StackFormat::Png).unwrap();
    }
}

/// Images of a folder and the folders in it, in order.
fn images(folder: &Path) -> Vec<PathBuf> {
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<PathBuf> = paths.flat_map(|path| if path.is_dir() { images(&path) } else { vec![path] }).collect();
    all.sort();
    all
}

/// Errors at fitted and held-out views and lights, the file's facts, a comparison, and values that follow the view.
#[test]
fn all_views_in_one_pack() {
    let folder = Folder::new();
    btf(&folder, "tile", &ring(&[40.0, 70.0]));
    let arguments = ["pwt", "tile", "-o", "tile.ktx2", "--view", "all", "--hold-out", "2", "--hold-out-views", "3"];
    let report = folder.run(&[&arguments[..], &["--max-bytes", "64KiB", "--json"]].concat()).succeeded().json();
    conforms("pwt", &report);
    assert_eq!((&report["views"], &report["lights"], &report["met"]), (&10.into(), &11.into(), &true.into()));
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let held = &report["held_out_views"];
    assert_eq!(held["views"].as_array().unwrap().len(), 3);
    for psnr in [&report["psnr"], &report["held_out"]["psnr"], &held["psnr"], &held["psnr_at_held_out_lights"]] {
        assert!(number(psnr) > 28.0, "{report}");
    }
    let info = folder.run(&["info", "tile.ktx2"]).succeeded().stdout;
    assert!(info.contains("10 views under any light"), "{info}");
    let compared = folder.run(&["compare", "tile", "tile.ktx2", "--json"]).succeeded().json();
    conforms("compare", &compared);
    assert_eq!((&compared["kind"], compared["views"].as_array().unwrap().len()), (&"btf".into(), 13));
    assert!(number(&compared["psnr"]) > 28.0, "{compared}");
    let missed = folder.run(&["compare", "tile", "tile.ktx2", "--max-delta-e", "0.01"]);
    assert!(missed.code == 1 && missed.stderr.contains("--max-delta-e: found "), "{missed:?}");
    folder.write(
        "at.csv",
        "u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0.3,0.3,0,0,1,0.6427876,0,0.7660444\n0.3,0.3,0,0,1,-0.6427876,0,0.7660444\n",
    );
    let values = folder.run(&["eval", "tile.ktx2", "--directions", "at.csv"]).succeeded().stdout;
    let green =
        |line: usize| -> f64 { values.lines().nth(line).unwrap().split(',').rev().nth(1).unwrap().parse().unwrap() };
    assert!(green(1) > 1.5 * green(2), "{values}");
}

/// The pack of all views at a target of bytes is within it, and `--views` is the same option.
#[test]
fn a_target_is_over_all_views() {
    let folder = Folder::new();
    btf(&folder, "tile", &ring(&[50.0]));
    let made = |flag: &str, output: &str| {
        let arguments = ["pwt", "tile", "-o", output, flag, "all", "--max-bytes", "20KiB", "--json"];
        folder.run(&arguments).succeeded().json()
    };
    let report = made("--views", "a.ktx2");
    assert!(report["bytes_on_gpu"].as_u64().unwrap() <= 20 << 10 && report["views"] == 7, "{report}");
    made("--view", "b.ktx2");
    assert_eq!(folder.read("a.ktx2"), folder.read("b.ktx2"));
}

/// Wrong input and options: an error, its exit code, and no output.
#[test]
fn wrong_views_are_errors_without_output() {
    let folder = Folder::new();
    btf(&folder, "tile", &ring(&[50.0]));
    btf(&folder, "one", &[[0.0, 0.0]]);
    btf(&folder, "gap", &ring(&[50.0]));
    std::fs::remove_file(&images(&folder.path().join("gap"))[0]).unwrap();
    btf(&folder, "sizes", &ring(&[50.0]));
    let angles = ImageAngles { view: [0.0, 0.0], light: [0.0, 0.0] };
    write_image(&folder.path().join("sizes"), 0, angles, &[[0.5; 3]; 4], [2; 2], StackFormat::Png).unwrap();
    for (options, code, expected) in [
        (&["one", "--view", "all"][..], 3, "one: views: found 1, expected 2 to 256; --view 0 takes one"),
        (&["gap", "--view", "all"], 3, "missing"),
        (&["sizes", "--view", "all"], 3, "2 x 2"),
        (&["gone", "--view", "all"], 4, "gone"),
        (&["tile", "--view", "some"], 2, "expected 0 to the number of views - 1, or all"),
        (&["tile", "--view", "7"], 2, "--view: found 7, expected 0 to 6"),
        (&["tile", "--view", "-1"], 2, "expected 0 to the number of views - 1, or all"),
        (&["tile", "--hold-out-views", "1"], 2, "--hold-out-views needs --view all"),
        (&["tile", "--view", "all", "--hold-out-views", "6"], 2, "--hold-out-views: found 6, expected 0 to 5, as"),
        (&["tile", "--view", "all", "--seed", "3"], 2, "--seed needs --hold-out or --hold-out-views"),
        (
            &["tile", "--view", "all", "--wavelet", "cdf97"],
            2,
            "--wavelet: found cdf97, expected haar for several views",
        ),
        (&["tile", "--view", "all", "--normals", "n.png"], 2, "--view all is not allowed together with --normals"),
    ] {
        let refused = folder.run(&[&["pwt", "-o", "out.ktx2"], options].concat());
        assert!(refused.code == code && refused.stderr.contains(expected), "{options:?}: {refused:?}");
        assert!(!folder.path().join("out.ktx2").exists() && !folder.path().join("n.png").exists(), "{options:?}");
    }
    let refused = folder.run(&["pwt", "tile", "-o", "out.ptm", "--view", "all"]);
    assert!(refused.code == 2 && refused.stderr.contains("--view all does not apply to an output .ptm"), "{refused:?}");
    folder.run(&["pwt", "tile", "-o", "all.ktx2", "--view", "all"]).succeeded();
    let refused = folder.run(&["pwt", "all.ktx2", "-o", "out.ptm"]);
    assert!(
        refused.code == 3 && refused.stderr.contains("views: found 7, expected a pack of one view, or the BTF itself"),
        "{refused:?}"
    );
    let refused = folder.run(&["compare", "tile", "tile/none.ktx2"]);
    assert!(refused.code == 4 && refused.stderr.contains("tile/none.ktx2"), "{refused:?}");
    let most = u64::MAX.to_string();
    let refused = folder.run(&["pwt", "tile", "-o", "out.ktx2", "--view", "all", "--hold-out-views", &most]);
    assert!(
        refused.code == 2 && refused.stderr.contains("--hold-out-views: found 18446744073709551615"),
        "{refused:?}"
    );
}

/// Images that exceed the limit of memory are an error before they are decoded.
#[test]
fn too_many_pixels_are_an_error() {
    const SIDE: usize = 2560;
    let folder = Folder::new();
    btf(&folder, "tile", &ring(&[50.0]));
    let angles = ImageAngles { view: [0.0, 0.0], light: [0.0, 0.0] };
    let large = vec![[0.5; 3]; SIDE * SIDE];
    let large = write_image(&folder.path().join("large"), 0, angles, &large, [SIDE; 2], StackFormat::Png).unwrap();
    for image in images(&folder.path().join("tile")) {
        std::fs::copy(&large, image).unwrap();
    }
    let refused = folder.run(&["pwt", "tile", "-o", "out.ktx2", "--view", "all"]);
    let expected = "tile: photographs: found 91 of 2560 x 2560 pixels, 6.7 GiB, expected at most 6 GiB in all";
    assert!(refused.code == 3 && refused.stderr.contains(expected), "{refused:?}");
    assert!(!folder.path().join("out.ktx2").exists());
}
