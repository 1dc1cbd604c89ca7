//! Files that require much memory: sparse files, and images that are small only on disk.

use super::refused;
use crate::common::cli::Folder;
use std::fs::File;
use std::io::Write;

#[test]
fn sparse_files_are_refused_before_memory_is_asked_for() {
    let folder = Folder::new();
    for (name, start, length, expected) in [
        (
            "a.binary",
            [4096i32; 3].map(i32::to_le_bytes).concat(),
            12 + 24 * (1 << 36),
            "file length: found 1.50 TiB, expected at most 2.00 GiB",
        ),
        ("a.csv", Vec::new(), 2 << 30, "line 1, text: NUL byte at byte 0 of the file; expected text without NUL bytes"),
    ] {
        let mut file = File::create(folder.path().join(name)).unwrap();
        file.write_all(&start).unwrap();
        file.set_len(length).unwrap();
        drop(file);
        // The folder is not read back, unlike in the checks of other refusals.
        let ran = folder.run(&["info", name]);
        assert_eq!((ran.code, ran.stderr), (3, format!("brdfc: {name}: {expected}\n")));
    }
}

/// An image of one colour, 8192 x 2048 pixels: a small file.
fn plain() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 8192, 2048);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::Fast);
    let mut image = encoder.write_header().unwrap();
    let mut writer = image.stream_writer().unwrap();
    let row = vec![90u8; 3 * 8192];
    (0..2048).for_each(|_| writer.write_all(&row).unwrap());
    writer.finish().unwrap();
    image.finish().unwrap();
    bytes
}

/// Three floats per pixel are 192 MiB, and the decoded image is 48 MiB.
#[test]
#[cfg(target_os = "linux")]
fn a_plain_image_takes_the_memory_of_its_pixels() {
    let folder = Folder::new();
    let mut large = plain();
    folder.write("a.png", &large);
    let script = "ulimit -v \"$1\" && exec \"$0\" bandwidth a.png --size 1x1 -o a.ktx2";
    let ran = |mebibytes: u32| {
        std::process::Command::new("sh")
            .args(["-c", script, env!("CARGO_BIN_EXE_brdfc"), &(mebibytes << 10).to_string()])
            .envs([("RAYON_NUM_THREADS", "1"), ("MALLOC_ARENA_MAX", "1")])
            .current_dir(folder.path())
            .output()
            .unwrap()
    };
    let output = ran(400);
    assert!(output.status.success(), "{output:?}");
    // With less memory it is an error.
    let output = ran(220);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(3), "{said}");
    assert!(said.contains("a.png: pixels: 16777216 take 192.00 MiB; expected a size that fits in memory"), "{said}");
    let wide = Folder::new();
    large[16..20].copy_from_slice(&9000u32.to_be_bytes());
    let crc = crc(&large[12..29]);
    large[29..33].copy_from_slice(&crc.to_be_bytes());
    wide.write("a.png", large);
    let expected =
        ["a.png: image: found 9000 x 2048 pixels, expected a complete PNG or JPEG of at most 8192 pixels along a side"];
    refused(&wide, &["bandwidth", "a.png", "--size", "1x1", "-o", "a.ktx2"], 3, &expected);
}

/// Checksum of a PNG's chunk.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| (crc >> 1) ^ (0xedb8_8320 * (crc & 1)))
    })
}
