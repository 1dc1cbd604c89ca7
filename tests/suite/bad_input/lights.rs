//! RTI captures and polynomial texture maps.

use super::refused;
use crate::common::cli::Folder;

const HEADER: &str = "PTM_1.2\nPTM_FORMAT_RGB\n1 1\n2 2 2 2 2 0.5 160 160 160 127 127 0\n";

fn png(width: u32) -> Vec<u8> {
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(width, 4).write_to(&mut png, image::ImageFormat::Png).unwrap();
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
        ([4, 4], "2\na.png 0 0 1\nc.png 0 1 1", "l.lp: line 3, image: \"c.png\" does not exist; expected "),
        ([4, 4], "3\na.png 0 0 1\nb.png 0 1 1", "l.lp: line 1, number of lights: found 3, expected 2, "),
        ([4, 4], "1\na.png 0 0 0", "l.lp: line 2, direction: vector of length 0; expected "),
        ([4, 4], "1\na.png 0 1 0", "l.lp: line 2, direction: 0 1 0 is at or below the horizon; expected "),
        ([4, 4], "1\na.png 0 nan 1", "l.lp: line 2, y: found \"nan\", expected a finite number"),
        ([4, 4], "", "l.lp: number of lights: empty file; expected "),
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
    let jpeg = HEADER.replace("PTM_FORMAT_RGB", "PTM_FORMAT_JPEG_RGB");
    check_message(
        jpeg.as_bytes(),
        "format: found the unsupported \"PTM_FORMAT_JPEG_RGB\", expected PTM_FORMAT_RGB or PTM_FORMAT_LRGB",
    );
    folder.write("a.binary", &whole);
    refused(&folder, &["info", "a.binary"], 3, &["it looks like a polynomial texture map (.ptm)"]);
}

#[test]
fn neither_is_a_brdf() {
    let folder = stack([4, 4], "2\na.png 0 0 1\nb.png 0 1 1\n");
    folder.write("s/icon.ptm", [HEADER.as_bytes(), &[127; 18]].concat());
    for (input, what) in
        [("s", "an RTI capture"), ("s/l.lp", "an RTI capture"), ("s/icon.ptm", "a polynomial texture map")]
    {
        let found =
            format!("brdfc: {input}: input: {what} has no BRDF, only images of one view under many lights; expected");
        refused(&folder, &["encode", input, "-o", "p.ktx2"], 3, &[found.as_str(), ".binary (MERL)", "'brdfc info'"]);
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
