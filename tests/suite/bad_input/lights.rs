//! RTI captures and polynomial texture maps.

use super::refused;
use crate::common::cli::Folder;
use brdfc_testing::viewer_files::rti;

const HEADER: &str = "PTM_1.2\nPTM_FORMAT_RGB\n1 1\n2 2 2 2 2 0.5 160 160 160 127 127 0\n";

fn png(width: u32) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(width, 4).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

/// An image of one grey.
fn grey_png(level: u8) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_pixel(4, 4, image::Luma([level])).write_to(&mut png, image::ImageFormat::Png).unwrap();
    png.into_inner()
}

/// Images of two widths, and a list.
fn stack(widths: [u32; 2], list: &str) -> Folder {
    let folder = Folder::new();
    folder.write("s/a.png", png(widths[0]));
    folder.write("s/b.png", png(widths[1]));
    folder.write("s/l.lp", list);
    folder
}

#[test]
fn stacks_that_are_broken() {
    let list = "2\na.png 0 0 1\nb.png 0 1 1\n";
    stack([4, 4], list).run(&["info", "s"]).succeeded();
    for (widths, list, expected) in [
        ([4, 5], list, "b.png: image size: found 5 x 4, expected 4 x 4, the size of a.png"),
        ([4, 4], "2\nc.png 0 0 1\nd.png 0 1 1", "l.lp: line 2, image: \"c.png\" does not exist, like all images"),
        ([4, 4], "2\na.png 0 0 -1\nd.png 0 1 1", "l.lp: line 3, image: \"d.png\" does not exist, like all images"),
        ([4, 4], "3\n", "l.lp: line 1, lights: no lines after the first; expected "),
        ([4, 4], "2\na.png 0 0 1\na.png 0 1 1", "l.lp: line 3, image: \"a.png\" is already on line 2; expected "),
        ([4, 4], "1\na.png 0 0 0", "l.lp: line 2, direction: vector of length 0; expected "),
        ([4, 4], "1\na.png 0 1 0", "l.lp: line 2, direction: 0 1 0 is at or below the horizon, like all "),
        ([4, 4], "1\na.png 0 nan 1", "l.lp: line 2, direction: no finite vector in the list"),
        ([4, 4], "", "l.lp: number of lights: empty file; expected "),
        ([4, 4], "1\na.png x 0 1", "l.lp: line 2, x: found \"x\", expected a number"),
        ([4, 4], "1\0", "l.lp: line 1, text: NUL byte"),
    ] {
        for input in ["s", "s/l.lp"] {
            refused(&stack(widths, list), &["info", input], 3, &["brdfc: s/", expected]);
        }
    }
    let folder = stack([4, 4], list);
    folder.write("s/other.LP", list);
    refused(
        &folder,
        &["info", "s"],
        3,
        &["s: lists of lights: found l.lp, other.LP, expected one .lp file in the folder"],
    );
}

/// A TIFF of 4 x 4 grey integers of 32 bits.
fn deep_tiff() -> Vec<u8> {
    let entries = [
        [256, 4],
        [257, 4],
        [258, 32],
        [259, 1],
        [262, 1],
        [273, 8 + 2 + 12 * 10 + 4],
        [277, 1],
        [278, 4],
        [279, 64],
        [339, 1],
    ];
    let entry =
        |[tag, value]: [u16; 2]| [tag.to_le_bytes(), [3, 0], [1, 0], [0, 0], value.to_le_bytes(), [0, 0]].concat();
    let entries = entries.map(entry).concat();
    [&b"II*\0\x08\0\0\0\x0a\0"[..], &entries, &[0; 4], &[0; 64]].concat()
}

#[test]
fn photographs_that_are_broken() {
    let folder = stack([4, 4], "2\na.png 0 0 1\nb.png 0 1 1\n");
    let mut jpeg = std::io::Cursor::new(Vec::new());
    image::RgbImage::new(4, 4).write_to(&mut jpeg, image::ImageFormat::Jpeg).unwrap();
    // Readers go by the contents.
    for (bytes, expected) in [
        (&jpeg.into_inner()[..100], "a.png: image: Format error decoding Jpeg: "),
        (&png(4)[..60], "; expected a complete PNG, JPEG, TIFF or EXR image\n"),
        (&deep_tiff(), "found Uint of 32 bits (SampleFormat), expected grey or RGB of unsigned integers of 8 or 16"),
    ] {
        folder.write("s/a.png", bytes);
        let message = refused(&folder, &["pwt", "s", "-o", "p.ktx2"], 3, &["brdfc: s/a.png: ", expected]);
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}

/// Captures that differ from their list: the capture is read, and notes say what was left out.
#[test]
fn stacks_that_differ_from_their_list() {
    // As in a published capture: the list states 47, has 48 rows, and there are 47 photographs.
    let folder = Folder::new();
    let mut list = "47\n".to_owned();
    for light in 0..48 {
        let angle = 0.13 * light as f32;
        list += &format!("photo {light}.png {} {} {}\n", angle.sin(), angle.cos(), 0.5 + 0.02 * light as f32);
        if light != 31 {
            folder.write(&format!("s/photo {light}.png"), grey_png(40 + light));
        }
    }
    folder.write("s/l.lp", &list);
    let notes = ["the list states 47 lights and has 48", "left out 1 light, without an image: photo 31.png (line 33)"];
    let ran = folder.run(&["pwt", "s", "-o", "p.ktx2", "--json"]).succeeded();
    assert_eq!((&ran.json()["lights"], &ran.json()["notes"]), (&47.into(), &serde_json::json!(notes)));
    assert!(notes.iter().all(|note| ran.stderr.contains(&format!("note: s: {note}\n"))), "{}", ran.stderr);
    let ran = folder.run(&["compare", "s", "p.ktx2"]).succeeded();
    assert!(notes.iter().all(|note| ran.stderr.contains(&format!("note: s: {note}\n"))), "{}", ran.stderr);
    let report = folder.run(&["info", "s", "--json"]).succeeded().json();
    assert_eq!((&report["lights"], &report["notes"]), (&47.into(), &serde_json::json!(notes)));
    assert!(folder.run(&["info", "s"]).succeeded().stdout.contains(notes[0]));
    assert!(!folder.run(&["pwt", "s", "-o", "p.ktx2", "--quiet"]).succeeded().stderr.contains("note"));
    // Negative control: a list that fits has no note.
    folder.write("s/photo 31.png", grey_png(71));
    folder.write("s/l.lp", list.replacen("47", "48", 1));
    let ran = folder.run(&["pwt", "s", "-o", "p.ktx2", "--json"]).succeeded();
    assert!(!ran.stderr.contains("note") && ran.json()["notes"] == serde_json::json!([]), "{ran:?}");
    // Lights behind the plane, among them some of HP's own example, and photographs with nothing to fit.
    folder.write("s/photo 0.png", grey_png(0));
    folder.write("s/photo 1.png", grey_png(255));
    let behind = list.replacen("47", "48", 1) + "photo 48.png 0.8 0.6 -0.000204\n";
    folder.write("s/l.lp", behind.replacen("48", "49", 1));
    folder.write("s/photo 48.png", grey_png(9));
    let ran = folder.run(&["pwt", "s", "-o", "p.ktx2", "--json"]).succeeded();
    assert_eq!(ran.json()["lights"], 46);
    assert_eq!(ran.json()["notes"].as_array().unwrap().len(), 3);
    for note in [
        "left out 1 light, at or below the horizon: photo 48.png (line 50)",
        "left out 1 light, whose photograph is black everywhere: photo 0.png",
        "left out 1 light, whose photograph is white everywhere: photo 1.png",
    ] {
        assert!(ran.stderr.contains(&format!("note: s: {note}\n")), "{}", ran.stderr);
    }
    let dark = stack([4, 4], "2\na.png 0 0 1\nb.png 0 1 1\n");
    let ran = dark.run(&["pwt", "s", "-o", "p.ktx2"]).succeeded();
    assert!(ran.stderr.contains("note: s: 2 images: black everywhere\n"), "{}", ran.stderr);
    let ran = dark.run(&["pwt", "s", "-o", "p.ktx2", "--quality", "20"]);
    assert!(ran.code == 1 && ran.stderr.contains("neither black nor white"), "{}", ran.stderr);
}

/// The most lights that a list may have, and one more.
#[test]
fn as_many_lights_as_a_list_may_have() {
    let folder = Folder::new();
    let rows = |count: usize| -> String {
        let row = |light: usize| {
            let (r, angle) = ((light as f32 / 4200.0).sqrt(), 2.4 * light as f32);
            format!("{light}.png {} {} {}\n", r * angle.cos(), r * angle.sin(), (1.0 - r * r).sqrt())
        };
        (0..count).map(row).collect()
    };
    for light in 0..4096 {
        folder.write(&format!("s/{light}.png"), grey_png((50 + light % 200) as u8));
    }
    folder.write("s/l.lp", format!("4096\n{}", rows(4096)));
    let ran = folder.run(&["pwt", "s", "-o", "p.ktx2", "--json"]).succeeded();
    assert_eq!(ran.json()["lights"], 4096);
    folder.write("s/l.lp", format!("4097\n{}", rows(4097)));
    refused(
        &folder,
        &["pwt", "s", "-o", "p.ktx2"],
        3,
        &["l.lp: line 1, number of lights: found 4097, expected 1 to 4096"],
    );
    folder.write("s/l.lp", rows(4097));
    refused(&folder, &["pwt", "s", "-o", "p.ktx2"], 3, &["l.lp: line 4097, light: too many lights; expected at most"]);
}

#[test]
fn files_of_harmonics_that_are_broken() {
    let folder = Folder::new();
    let whole = rti([2, 1], &[1.0; 9], &[0.0; 9], &[100; 54]);
    folder.write("a.rti", &whole);
    folder.run(&["info", "a.rti"]).succeeded();
    folder.run(&["pwt", "a.rti", "-o", "p.ktx2"]).succeeded();
    let text = |old: &str, new: &str| {
        let at = whole.windows(old.len()).position(|bytes| bytes == old.as_bytes()).unwrap();
        [&whole[..at], new.as_bytes(), &whole[at + old.len()..]].concat()
    };
    for (bytes, expected) in [
        (Vec::new(), "line 1, type: end of data; expected a header of 7 numbers"),
        (png(4), "it looks like a PNG image (.png)"),
        (whole[..whole.len() - 1].to_vec(), "file length: found 125 bytes after the header, expected 126: 9 scales"),
        (whole[..40].to_vec(), "file length: found "),
        (text("9 2 1", "10 2 1"), "line 4, terms: found \"10\", expected 4, 9 or 16"),
        (text("9 2 1", "4 2 1"), "file length: found 126 bytes after the header, expected 56: 4 scales"),
        (text("9 2 1", "9 1 1"), "line 4, basis type: found 1 (LRGB), expected 2 (RGB)"),
        (text("\n3\r", "\n4\r"), "line 2, type: found 4 (adaptive basis functions), expected 3"),
        (text("2 1 3", "0 1 3"), "line 3, width: found \"0\", expected 1 to 65536"),
        (text("2 1 3", "9999 9999 3"), "expected 2699460099: 9 scales"),
    ] {
        folder.write("a.rti", bytes);
        for command in [&["info", "a.rti"][..], &["pwt", "a.rti", "-o", "q.ktx2"]] {
            refused(&folder, command, 3, &["brdfc: a.rti: ", expected]);
        }
    }
    folder.write("a.ptm", &whole);
    refused(&folder, &["info", "a.ptm"], 3, &["it looks like an RTI file of hemispherical harmonics (.rti)"]);
    assert!(!folder.path().join("q.ktx2").exists());
}

#[test]
fn maps_that_are_broken() {
    let folder = Folder::new();
    let whole = [HEADER.as_bytes(), &[127; 18]].concat();
    folder.write("a.ptm", &whole);
    folder.run(&["info", "a.ptm"]).succeeded();
    let check_message = |bytes: &[u8], expected: &str| {
        folder.write("a.ptm", bytes);
        refused(&folder, &["info", "a.ptm"], 3, &["brdfc: a.ptm: ", expected]);
    };
    check_message(b"", "line 1, version: end of data; expected a header of 16 words");
    check_message(&png(4), "it looks like a PNG image (.png)");
    check_message(
        &whole[..whole.len() - 1],
        "file length: found 17 bytes after the header, expected 18 for 1 x 1 pixels",
    );
    for format in ["PTM_FORMAT_JPEGLS_RGB", "PTM_FORMAT_LUM"] {
        let expected =
            format!("format: found the unsupported \"{format}\", expected PTM_FORMAT_RGB, PTM_FORMAT_LRGB, ");
        check_message(HEADER.replace("PTM_FORMAT_RGB", format).as_bytes(), &expected);
    }
    let jpeg = HEADER.replace("PTM_FORMAT_RGB", "PTM_FORMAT_JPEG_RGB");
    check_message(jpeg.as_bytes(), "line 5, compression parameter: end of data; expected a header of 143 words");
    folder.write("a.binary", &whole);
    refused(&folder, &["info", "a.binary"], 3, &["it looks like a polynomial texture map (.ptm)"]);
}

#[test]
fn neither_is_a_brdf() {
    let folder = stack([4, 4], "2\na.png 0 0 1\nb.png 0 1 1\n");
    folder.write("s/icon.ptm", [HEADER.as_bytes(), &[127; 18]].concat());
    folder.write("s/icon.rti", rti([1, 1], &[1.0; 4], &[0.0; 4], &[9; 12]));
    for (input, what) in [
        ("s", "an RTI capture"),
        ("s/l.lp", "an RTI capture"),
        ("s/icon.ptm", "a polynomial texture map"),
        ("s/icon.rti", "an RTI file"),
    ] {
        let found = format!("brdfc: {input}: input: found {what}, expected .binary (MERL), ");
        let words = [found.as_str(), "; 'brdfc pwt' makes a pack of it\n"];
        refused(&folder, &["encode", input, "-o", "p.ktx2"], 3, &words);
        folder.write("pairs.csv", "wi_x,wi_y,wi_z\n");
        refused(&folder, &["eval", input, "--directions", "pairs.csv"], 3, &words);
    }
    refused(&folder, &["encode", "gone.lp", "-o", "p.ktx2"], 4, &["gone.lp: cannot read"]);
    folder.write("lies.ptm", png(4));
    refused(&folder, &["encode", "lies.ptm", "-o", "p.ktx2"], 3, &["it looks like a PNG image (.png)"]);
    let command = |list: &str| {
        let output = folder.command(&["info", "-"]).write_stdin(list.to_owned()).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let (code, message) = command("1\na.png 0 0 1\n");
    assert!(
        code == Some(3)
            && message.contains("stdin: input: found the lights of an RTI capture, expected the path of the list"),
        "{message}"
    );
}
