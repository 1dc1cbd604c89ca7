//! `brdfc report`.

use super::schemas::conforms;
use crate::common::cli::{Folder, inputs};

/// Three materials, one of which cannot be read and one misses what is required of it.
fn folder() -> Folder {
    let folder = Folder::new();
    inputs(&folder);
    folder.write("broken.brdf", "no scan");
    folder.write(
        "scene.toml",
        "[scene]\nname = 'shop'\n[materials.table]\nsource = 'table.binary'\n[materials.broken]\nsource = 'broken.brdf'\n\
         [materials.ward]\nsource = 'synth:ward?ay=0.5'\ncodec = 'wavelet'\ngrid = 4\n\
         [materials.ward.require]\nmax_delta_e = 0.01\n\
         [[uses]]\nmaterial = 'table'\n[[uses]]\nmaterial = 'broken'\n[[uses]]\nmaterial = 'ward'\n",
    );
    let ran = folder.run(&["build", "scene.toml"]);
    assert_eq!(ran.code, 3, "{}", ran.stderr);
    folder
}

#[test]
fn the_page_stands_alone_and_says_what_the_build_says() {
    let folder = folder();
    let ran = folder.run(&["report", "packs", "-o", "page.html", "--json"]).succeeded();
    conforms("report", &ran.json());
    let page = folder.text("page.html");
    for words in [
        "shop: packs and their errors",
        "2 of them failed",
        "require.max_delta_e: found",
        "id=\"table\"",
        "broken.brdf",
    ] {
        assert!(page.contains(words), "{words}");
    }
    // Ball and cloth of two materials: source, pack and difference; and both balls at a glance.
    assert_eq!(page.matches("<img src=\"data:image/png;base64,").count(), 2 * 6 + 2 * 2);
    assert!(
        !page.contains("http") || page.matches("http").count() == page.matches("http://www.w3.org/2000/svg").count()
    );
    assert!(!page.contains("<link") && !page.contains("src=\"/") && page.matches("<script").count() == 1);
    let table = folder.text("page.csv");
    assert_eq!(table.lines().count(), 4, "{table}");
    let columns = table.lines().next().unwrap().split(',').count();
    assert!(table.lines().all(|line| line.split(',').count() >= columns), "{table}");
    let figures: serde_json::Value = serde_json::from_str(&folder.text("page.json")).unwrap();
    assert!(figures == ran.json());
    let worst = figures["materials"][2]["by_angle"]["worst"].as_array().unwrap();
    assert!(figures["materials"][2]["material"] == "ward" && !worst.is_empty());

    // The same build gives the same page.
    folder.run(&["report", "packs", "-o", "again.html"]).succeeded();
    assert!(folder.text("again.html") == page);
    // Without the store nothing is known of sources, and of times.
    std::fs::remove_dir_all(folder.path().join("packs/.brdfc-cache")).unwrap();
    folder.run(&["report", "packs", "-o", "bare.html"]).succeeded();
    let bare = folder.text("bare.html");
    assert!(
        bare.contains("Not compared with its source") && bare.matches("<img").count() == 2 * 2 + 2,
        "{}",
        bare.len()
    );
}

#[test]
fn a_contact_sheet_shows_every_material_on_any_number_of_threads() {
    let folder = folder();
    let sheet = |jobs: &str, build: &str| {
        folder.run(&["report", build, "-o", "page.html", "--sheet", "sheet.png", "--jobs", jobs]).succeeded();
        folder.read("sheet.png")
    };
    let bytes = sheet("1", "packs");
    assert!(bytes == sheet("2", "packs"));
    let image = image::load_from_memory(&bytes).unwrap().into_rgb8();
    // Three cells in two columns: each with a row of balls and one of cloths.
    assert!(image.width() > 2 * 3 * 96 && image.height() > 2 * 2 * 96, "{} x {}", image.width(), image.height());
    // Red is what failed or misses what is required.
    let failed = |image: &image::RgbImage| image.pixels().filter(|pixel| pixel.0 == [179, 38, 30]).count();
    assert!(failed(&image) > 200, "{}", failed(&image));
    folder.run(&["build", "synth:lambert", "--codec", "table", "--out", "white"]).succeeded();
    let one = image::load_from_memory(&sheet("1", "white")).unwrap().into_rgb8();
    assert!(failed(&one) == 0 && one.height() < image.height());

    let refused = |code: i32, words: &str, sheet: &str| {
        let ran = folder.run(&["report", "packs", "-o", "page.html", "--sheet", sheet]);
        assert!(ran.code == code && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
    };
    refused(2, "--sheet: found sheet.jpg; allowed a name that ends in .png", "sheet.jpg");
    refused(4, "there is no folder no", "no/sheet.png");
}

#[test]
fn what_got_worse_is_exit_code_1() {
    let folder = Folder::new();
    inputs(&folder);
    let build = |bytes: &str, out: &str| {
        folder
            .run(&["build", "table.binary", "synth:ward", "--codec", "table", "--max-bytes", bytes, "--out", out])
            .succeeded();
    };
    build("8KiB", "before");
    build("2KiB", "now");
    let report = |arguments: &[&str]| folder.run(&[&["report", "now", "-o", "page.html"], arguments].concat());
    let ran = report(&["--against", "before"]);
    assert_eq!(ran.code, 1, "{}", ran.stderr);
    assert!(ran.stdout.contains("ward: mean ΔE: found ") && ran.stderr.contains("figures are worse than before"));
    assert!(folder.text("page.html").contains("Worse than before"));
    report(&["--against", "now/report.json"]).succeeded();
    assert!(folder.text("page.html").contains("Nothing is worse"));
    report(&["--against", "before", "--tolerance", "99999%"]).succeeded();
    for (arguments, code, words) in [
        (&["--against", "gone.json"][..], 4, "gone.json: cannot read"),
        (&["--against", "table.binary"], 3, "table.binary: found "),
        (&["--tolerance", "1%"], 2, "--against"),
        (&["--against", "before", "--tolerance", "3"], 2, "--tolerance: found 3; allowed a fraction or a percentage"),
    ] {
        let ran = report(arguments);
        assert!(ran.code == code && ran.stderr.contains(words), "{arguments:?}: {} {}", ran.code, ran.stderr);
    }
}

#[test]
fn folders_that_are_not_what_their_report_says() {
    let folder = Folder::new();
    folder.run(&["build", "synth:lambert", "synth:velvet", "--codec", "table"]).succeeded();
    let refused = |code: i32, words: &str, arguments: &[&str]| {
        let ran = folder.run(&[&["report"], arguments].concat());
        assert!(ran.code == code && ran.stderr.contains(words), "{} {}", ran.code, ran.stderr);
        assert!(!folder.path().join("page.html").exists());
    };
    refused(4, "nowhere/report.json: cannot read", &["nowhere", "-o", "page.html"]);
    refused(2, "--output: found page.pdf; allowed a name that ends in .html", &["packs", "-o", "page.pdf"]);
    refused(2, "packs/report.json, an input", &["packs", "-o", "packs/report.html"]);
    let list = folder.write("packs/.brdfc-cache/commit/list", "begun");
    refused(3, "packs: found a build that was killed while files changed places", &["packs", "-o", "page.html"]);
    std::fs::remove_file(list).unwrap();
    std::fs::copy(folder.path().join("packs/lambert.brdf.ktx2"), folder.path().join("packs/velvet.brdf.ktx2")).unwrap();
    refused(
        3,
        "packs/velvet.brdf.ktx2: found another pack; allowed the pack that report.json names",
        &["packs", "-o", "page.html"],
    );
    std::fs::remove_file(folder.path().join("packs/velvet.brdf.ktx2")).unwrap();
    refused(4, "packs/velvet.brdf.ktx2: cannot read", &["packs", "-o", "page.html"]);
}
