//! `brdfc pwt` and the files of RTI viewers: `.ptm` and `.rti`.

use super::pwt::{SIZE, stack};
use super::schemas::conforms;
use crate::common::cli::Folder;
use brdfc_readers::ptm::{Ptm, PtmModel};
use brdfc_testing::viewer_files::{compressed_ptm, rti};

#[test]
fn maps_convert_in_both_directions() {
    let folder = stack();
    for (model, format) in [("rgb", "PTM_FORMAT_RGB"), ("lrgb", "PTM_FORMAT_LRGB")] {
        let report = folder.run(&["pwt", "stack", "-o", "m.ptm", "--model", model, "--json"]).succeeded().json();
        conforms("pwt", &report);
        assert_eq!((&report["kind"], &report["model"]), (&"ptm".into(), &model.into()));
        let message = folder.run(&["info", "m.ptm", "--json"]).succeeded().json();
        assert_eq!(message["format"], format);
        // The pack of a map shows the same image as the map.
        let pack = folder.run(&["pwt", "m.ptm", "-o", "m.ktx2", "--json"]).succeeded().json();
        assert_eq!((&pack["coordinates"], &pack["degree"]), (&"projected".into(), &2.into()));
        assert!(pack["psnr"].as_f64().unwrap() > 40.0, "{pack}");
    }
    // A pack for viewers that read only maps.
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    folder.run(&["pwt", "p.ktx2", "-o", "back.ptm"]).succeeded();
    let compared = folder.run(&["compare", "stack", "back.ptm", "--json"]).succeeded().json();
    assert!(compared["psnr"].as_f64().unwrap() > 20.0, "{compared}");
}

/// The pack of a file of harmonics has its terms, and shows the same image; also as text of `info` and `compare`.
#[test]
fn files_of_harmonics_become_packs() {
    let folder = stack();
    for terms in [4, 9, 16] {
        // White from above, and small terms that differ by pixel and channel.
        let scale: Vec<f32> = (0..terms).map(|k| if k == 0 { 1.5 } else { 0.2 }).collect();
        let bias: Vec<f32> = (0..terms).map(|k| if k == 0 { 0.3 } else { -0.1 }).collect();
        let smooth = |at: usize, k: usize| {
            let (x, y) = ((at % SIZE[0]) as f32, (at / SIZE[0]) as f32);
            (127.0 + 100.0 * (0.1 * x + k as f32).sin() * (0.08 * y).cos()) as u8
        };
        let bytes: Vec<u8> = (0..SIZE[0] * SIZE[1]).flat_map(|at| (0..3 * terms).map(move |k| smooth(at, k))).collect();
        folder.write("h.rti", rti(SIZE.map(|side| side as u32), &scale, &bias, &bytes));
        let report = folder.run(&["info", "h.rti", "--json"]).succeeded().json();
        conforms("info", &report);
        assert_eq!((&report["kind"], report["scale"].as_array().unwrap().len()), (&"rti".into(), terms));
        let text = folder.run(&["info", "h.rti"]).succeeded().stdout;
        assert!(text.contains("45 x 38") && text.contains(&format!("{terms} for each channel")), "{text}");
        let pack = folder.run(&["pwt", "h.rti", "-o", "h.ktx2", "--json"]).succeeded().json();
        conforms("pwt", &pack);
        let degree = terms.isqrt() - 1;
        assert_eq!((&pack["coordinates"], &pack["degree"]), (&"hemisphere".into(), &degree.into()));
        assert!(pack["psnr"].as_f64().unwrap() > 40.0, "{terms}: {pack}");
        // Negative control: fewer terms than those of the file.
        let fewer = format!("{}", degree - 1);
        let less = folder.run(&["pwt", "h.rti", "-o", "l.ktx2", "--degree", &fewer, "--json"]).succeeded().json();
        assert!(less["psnr"].as_f64().unwrap() < pack["psnr"].as_f64().unwrap() - 3.0, "{terms}: {less} {pack}");
    }
    let report = folder.run(&["compare", "stack", "h.rti", "--json"]).succeeded().json();
    conforms("compare", &report);
    folder.run(&["pwt", "h.rti", "-o", "h.ptm"]).succeeded();
    let ran = folder.run(&["pwt", "h.rti", "-o", "h.ktx2", "--view", "0"]);
    assert!(ran.code == 2 && ran.stderr.contains("--view does not apply to an RTI file, only to BTFs"), "{ran:?}");
}

/// The planes of a compressed map are grey JPEGs; the map shows what the uncompressed one shows.
#[test]
fn compressed_maps_are_read() {
    let folder = stack();
    for (model, format, planes) in [("rgb", "PTM_FORMAT_JPEG_RGB", 18), ("lrgb", "PTM_FORMAT_JPEG_LRGB", 9)] {
        folder.run(&["pwt", "stack", "-o", "m.ptm", "--model", model]).succeeded();
        let map = Ptm::from_bytes(&folder.read("m.ptm"), &|_, _| Err("no planes".to_owned())).unwrap();
        let byte = |plane: usize, pixel: usize| match map.model() {
            PtmModel::Rgb(pixels) => pixels[pixel][plane / 6][plane % 6],
            PtmModel::Lrgb { colour, .. } if plane >= 6 => colour[pixel][plane - 6],
            PtmModel::Lrgb { luminance, .. } => luminance[pixel][plane],
        };
        let jpegs: Vec<Vec<u8>> = (0..planes)
            .map(|plane| {
                let [width, height] = map.size();
                let grey = image::GrayImage::from_fn(width, height, |x, y| {
                    let pixel = ((height - 1 - y) * width + x) as usize;
                    let reference = if plane + 1 == planes { byte(0, pixel).wrapping_sub(128) } else { 0 };
                    image::Luma([byte(plane, pixel).wrapping_sub(reference)])
                });
                let mut jpeg = Vec::new();
                let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 100);
                grey.write_with_encoder(encoder).unwrap();
                jpeg
            })
            .collect();
        let whole = compressed_ptm(format, map.size(), map.scale(), map.bias(), &jpegs);
        folder.write("c.ptm", &whole);
        assert_eq!(folder.run(&["info", "c.ptm", "--json"]).succeeded().json()["format"], format);
        let of = |name: &str| {
            let report = folder.run(&["compare", "stack", name, "--json"]).succeeded().json();
            report["psnr"].as_f64().unwrap()
        };
        let [plain, compressed] = ["m.ptm", "c.ptm"].map(of);
        assert!((plain - compressed).abs() < 1.0, "{model}: {plain} {compressed}");
        folder.run(&["pwt", "c.ptm", "-o", "c.ktx2"]).succeeded();
        // Planes of another size or with colours, and a file that is cut.
        let mut colours = std::io::Cursor::new(Vec::new());
        image::RgbImage::new(45, 38).write_to(&mut colours, image::ImageFormat::Jpeg).unwrap();
        let mut narrow = std::io::Cursor::new(Vec::new());
        image::GrayImage::new(44, 38).write_to(&mut narrow, image::ImageFormat::Jpeg).unwrap();
        for (jpeg, found) in [(colours, "colours"), (narrow, "44 x 38 pixels"), (Default::default(), "")] {
            let mut jpegs = jpegs.clone();
            jpegs[2] = jpeg.into_inner();
            folder.write("w.ptm", compressed_ptm(format, map.size(), map.scale(), map.bias(), &jpegs));
            let ran = folder.run(&["pwt", "w.ptm", "-o", "x.ktx2"]);
            let message = format!("brdfc: w.ptm: plane 2: {found}");
            assert!(ran.code == 3 && ran.stderr.starts_with(&message), "{}", ran.stderr);
            assert!(ran.stderr.contains("; expected a grey JPEG of 45 x 38 pixels"), "{}", ran.stderr);
        }
        folder.write("w.ptm", &whole[..whole.len() - 1]);
        let ran = folder.run(&["pwt", "w.ptm", "-o", "x.ktx2"]);
        assert!(ran.code == 3 && ran.stderr.starts_with("brdfc: w.ptm: file length: found "), "{}", ran.stderr);
    }
}

/// A map has one form: options for other forms are rejected, gates first of all.
#[test]
fn options_of_packs_are_refused_with_maps() {
    let folder = Folder::new();
    for options in [
        &["--quality", "100"][..],
        &["--max-delta-e", "0.01"],
        &["--hold-out", "2"],
        &["--wavelet", "haar"],
        &["--packets", "1"],
        &["--tile"],
    ] {
        let ran = folder.run(&[&["pwt", "nothing", "-o", "x.ptm"][..], options].concat());
        let message = format!("{} does not apply to an output .ptm, only to packs", options[0]);
        assert!(ran.code == 2 && ran.stderr.contains(&message), "{}", ran.stderr);
    }
}
