//! RTI captures: written captures are read back, and faults are reported.

use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_source::InputError;
use brdfc_source::rti_capture::RtiCapture;
use brdfc_testing::shared_data;
use std::path::Path;

const SIZE: [usize; 2] = [5, 3];
/// Coplanar lights; the last is not of length 1.
const LIGHTS: [[f32; 3]; 4] = [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8], [3.0, 0.0, 3.0]];

/// Multiples of 1/1024 from 0 to 2, which 16-bit floats hold exactly; different in every image.
fn pixels(light: usize) -> Vec<[f32; 3]> {
    let value = |at: usize, k: usize| ((at * 131 + k * 37 + light * 71) % 2048) as f32 / 1024.0;
    (0..SIZE[0] * SIZE[1]).map(|at| [0, 1, 2].map(|k| value(at, k))).collect()
}

fn write_stack(folder: &Path, format: StackFormat) {
    let list = write_rti_capture(folder, &LIGHTS, SIZE, format, pixels).unwrap();
    assert!(list.ends_with("dirs.lp"));
}

fn error(path: &Path) -> String {
    RtiCapture::open(path).expect_err("an error").to_string()
}

/// Writes a capture under lights at different heights. `save` writes the images.
fn stack_of(folder: &Path, names: &[&str], save: impl Fn(&Path, usize)) {
    let mut list = format!("{}\r\n", names.len());
    for (k, name) in names.iter().enumerate() {
        list += &format!("{name} {k} 0 2\r\n\r\n");
        save(&folder.join(name), k);
    }
    std::fs::write(folder.join("Lights.LP"), list).unwrap();
}

fn grey(path: &Path) {
    image::GrayImage::new(4, 2).save_with_format(path, image::ImageFormat::Png).unwrap();
}

#[test]
fn exr_stacks_come_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    write_stack(folder.path(), StackFormat::Exr);
    for path in [folder.path().to_owned(), folder.path().join("dirs.lp")] {
        let stack = RtiCapture::open(&path).unwrap();
        assert_eq!((stack.len(), stack.size()), (4, SIZE));
        assert_eq!(stack.lights()[..3], LIGHTS[..3]);
        let diagonal = stack.lights()[3];
        assert!((diagonal[0] - 0.5f32.sqrt()).abs() < 1e-7 && diagonal[0] == diagonal[2], "{diagonal:?}");
        for light in 0..4 {
            let image = stack.image(light).unwrap();
            assert_eq!(([image.width, image.height], image.pixels), (SIZE, pixels(light)));
            assert!(stack.file(light).ends_with(format!("000{light}.exr")));
        }
        assert!(stack.image(4).unwrap_err().to_string().ends_with("light: found 4, expected less than 4"));
        let facts = stack.facts();
        assert_eq!(
            (facts.lights, facts.polar_angles, &facts.extensions[..]),
            (4, [0.0, 45.0], &["exr".to_owned()][..])
        );
    }
    assert_ne!(pixels(1), pixels(2), "the test can tell images apart");
}

#[test]
fn png_stacks_are_clipped_srgb_and_the_same_every_time() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    folders.iter().for_each(|folder| write_stack(folder.path(), StackFormat::Png));
    let image = RtiCapture::open(folders[0].path()).unwrap().image(3).unwrap();
    for (found, written) in image.pixels.iter().flatten().zip(pixels(3).iter().flatten()) {
        // Half a level is at most this much of linear light.
        assert!((found - written.min(1.0)).abs() < 0.0046, "{found} {written}");
    }
    for name in ["dirs.lp", "0000.png", "0003.png"] {
        let [a, b] = folders.each_ref().map(|folder| std::fs::read(folder.path().join(name)).unwrap());
        assert_eq!(a, b, "{name}");
    }
}

#[test]
fn invalid_captures_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let write = |lights: &[[f32; 3]], pixels: usize| {
        let write = write_rti_capture(folder.path(), lights, [2, 2], StackFormat::Png, |_| vec![[0.5; 3]; pixels]);
        write.unwrap_err().to_string()
    };
    assert!(write(&[], 4).contains("number of lights: found 0"));
    assert!(write(&[[0.0, 1.0, 0.0]], 4).contains("at or below the horizon"));
    assert!(write(&[LIGHTS[0], [0.0, 1.0, 0.0]], 4).contains("light 1: [0.0, 1.0, 0.0] is at or below the horizon"));
    assert!(write(&[[0.0, f32::NAN, 1.0]], 4).contains("no finite vector"));
    assert!(write(&[[0.0, 0.0, 1.0], [0.0, f32::NAN, 1.0]], 4).contains("light 1: [0.0, NaN, 1.0]; expected finite"));
    assert_eq!(write(&LIGHTS, 3), "3 pixels for an image of 2 x 2");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Equal levels are the same light in all kinds of images.
#[test]
fn eight_and_sixteen_bits_and_grey_and_jpeg() {
    let folder = tempfile::tempdir().unwrap();
    let names = [
        "a 8.png",
        "16.png",
        "8.tif",
        "16.tiff",
        "grey.png",
        "grey16.png",
        "grey16.tif",
        "alpha.png",
        "rgb.jpg",
        "grey.jpeg",
    ];
    stack_of(folder.path(), &names, |path, k| {
        let image: image::DynamicImage = match k {
            0 | 2 => image::RgbImage::from_pixel(8, 8, image::Rgb([255, 188, 10])).into(),
            1 | 3 => image::ImageBuffer::from_pixel(8, 8, image::Rgb([65535u16, 188 * 257, 10 * 257])).into(),
            4 => image::GrayImage::from_pixel(8, 8, image::Luma([188])).into(),
            5 | 6 => image::ImageBuffer::from_pixel(8, 8, image::Luma([188u16 * 257])).into(),
            7 => image::ImageBuffer::from_pixel(8, 8, image::LumaA([188u8, 3])).into(),
            8 => image::RgbImage::from_pixel(8, 8, image::Rgb([188; 3])).into(),
            _ => image::GrayImage::from_pixel(8, 8, image::Luma([188])).into(),
        };
        image.save(path).unwrap();
    });
    let stack = RtiCapture::open(folder.path()).unwrap();
    for (light, name) in names.iter().enumerate() {
        let expected = if light < 4 { [1.0, 0.502_886_5, 0.003_035_27] } else { [0.502_886_5; 3] };
        let image = stack.image(light).unwrap();
        assert_eq!(image.pixels.len(), 64);
        let within = if light < 8 { 1e-6 } else { 0.02 };
        for (found, expected) in image.pixels.iter().flat_map(|pixel| pixel.iter().zip(expected)) {
            assert!((found - expected).abs() < within, "{name}: {found} {expected}");
        }
    }
}

/// Pixels and directory of an image of 3 x 2, compressed by LZW and by Deflate.
const COMPRESSED_TIFF: [&str; 2] = [
    "49492a0018000000803fd780a052f1ff028241a11057fc040a00000103000100000003000000010103000100000002000000020103000300\
     0000960000000301030001000000050000000601030001000000020000001101040001000000080000001501030001000000030000001601\
     030001000000020000001701040001000000100000001c010300010000000100000000000000080008000800",
    "49492a001a000000789cfbbf878b6bcfffff48240064ef0a9f000a0000010300010000000300000001010300010000000200000002010300\
     03000000980000000301030001000000080000000601030001000000020000001101040001000000080000001501030001000000030000\
     001601030001000000020000001701040001000000110000001c010300010000000100000000000000080008000800",
];

#[test]
fn tiff_is_compressed_or_cut() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = |hex: &str| -> Vec<u8> {
        let digits = hex.as_bytes().chunks(2);
        digits.map(|two| u8::from_str_radix(std::str::from_utf8(two).unwrap(), 16).unwrap()).collect()
    };
    stack_of(folder.path(), &["lzw.tif", "deflate.TIFF"], |path, k| {
        std::fs::write(path, bytes(COMPRESSED_TIFF[k])).unwrap();
    });
    let stack = RtiCapture::open(folder.path()).unwrap();
    let [a, b] = [[1.0, 0.502_886_5, 0.003_035_27], [0.003_035_27, 0.502_886_5, 1.0]];
    for light in 0..2 {
        let image = stack.image(light).unwrap();
        for (found, expected) in image.pixels.iter().flatten().zip([a, b, a, b, a, b].as_flattened()) {
            assert!((found - expected).abs() < 1e-6, "{light}: {:?}", image.pixels);
        }
    }
    let whole = bytes(COMPRESSED_TIFF[0]);
    let mut refused = 0;
    for length in 0..whole.len() {
        std::fs::write(folder.path().join("lzw.tif"), &whole[..length]).unwrap();
        let read = RtiCapture::open(folder.path()).and_then(|stack| stack.image(0));
        assert!(matches!(read, Ok(_) | Err(InputError::Format { .. })), "{length}");
        refused += usize::from(read.is_err());
    }
    assert!(refused > 140, "{refused} of {}", whole.len());
}

#[test]
fn names_may_have_folders_that_exist_or_not() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    for file in ["in/a.png", "b.png", "c.png", "d.png"] {
        grey(&folder.path().join(file));
    }
    let list = folder.path().join("x.lp");
    std::fs::write(&list, "4\nin\\a.png 0 0 1\nC:\\b.png 0 1 1\n/photos/c.png 1 0 1\ngone/d.png 1 1 1\n").unwrap();
    let stack = RtiCapture::open(&list).unwrap();
    for (light, end) in ["in/a.png", "b.png", "c.png", "d.png"].into_iter().enumerate() {
        assert_eq!(stack.file(light), folder.path().join(end));
    }
    std::fs::write(&list, "2\n\nb.png 0 0 1\ngone/b.png 1 1 1\n").unwrap();
    assert!(
        error(&list).ends_with("x.lp: line 4, image: \"gone/b.png\" is already on line 3; expected each image once")
    );
    std::fs::write(&list, "2\nb.png 0 0 1\nin/b.jpg 1 1 1\n").unwrap();
    let stack = RtiCapture::open(&list).unwrap();
    assert_eq!(
        (stack.len(), stack.notes()),
        (1, &["left out 1 light, without an image: in/b.jpg (line 3)".to_owned()][..])
    );
    std::fs::write(&list, "1\nin/z.jpg 1 1 1\n").unwrap();
    let expected = "x.lp: line 2, image: \"in/z.jpg\" does not exist, like all images of lights above the horizon; \
                    expected a path, or a file next to this one";
    assert!(error(&list).ends_with(expected), "{}", error(&list));
    // The image of a light below the horizon exists, but nothing needs it.
    std::fs::write(&list, "3\nb.png 0 0 -1\ngone.png 0 1 -1\nin/z.jpg 1 1 1\n").unwrap();
    let expected = expected.replace("line 2", "line 4");
    assert!(error(&list).ends_with(&expected), "{}", error(&list));
}

/// Lists that were written on other systems: names in another case, form or extension, absolute paths, bytes of Windows-1252,
/// commas, a vector that is not finite, and files of macOS.
#[test]
fn lists_of_other_systems() {
    let folder = tempfile::tempdir().unwrap();
    let other = tempfile::tempdir().unwrap();
    grey(&other.path().join("e.png"));
    for file in ["a.png", "B.PNG", "caf\u{e9}.png", "d.png"] {
        grey(&folder.path().join(file));
    }
    for file in ["._x.lp", "._a.png"] {
        std::fs::write(folder.path().join(file), "attributes").unwrap();
    }
    let list = folder.path().join("x.lp");
    let absolute = other.path().join("e.png");
    let lines = format!(
        "6\nA.png 0 0 1\nb.png 0,6 0 0,8\ncafe\u{301}.png 0 1 1\nd.tif 1 0 1\n{} 1 1 1\nf.png nan 0 1\n",
        absolute.display()
    );
    std::fs::write(&list, &lines).unwrap();
    let stack = RtiCapture::open(folder.path()).unwrap();
    let files: Vec<_> = (0..stack.len()).map(|light| stack.file(light).to_owned()).collect();
    let expected = ["a.png", "B.PNG", "caf\u{e9}.png", "d.png"].map(|name| folder.path().join(name));
    assert_eq!(files, [&expected[..], &[absolute]].concat());
    let notes = [
        "left out 1 light, with a vector that is not finite: f.png (line 7)",
        "found 4 images under a similar name: a.png for A.png (line 2), B.PNG for b.png (line 3), caf\u{e9}.png for \
         cafe\u{301}.png (line 4) and 1 more",
    ];
    assert_eq!(stack.notes(), notes);
    // A file that two names could mean, or that another line names, is none.
    grey(&folder.path().join("d.jpg"));
    std::fs::write(&list, "3\na.png 0 0 1\nd.tif 1 0 1\na.jpg 1 1 1\n").unwrap();
    let stack = RtiCapture::open(folder.path()).unwrap();
    assert_eq!(stack.notes(), ["left out 2 lights, without an image: d.tif (line 3), a.jpg (line 4)"]);
    std::fs::write(&list, b"1\rC:\\Donn\xe9es\\a.png 0 0 1\r\x1a").unwrap();
    assert_eq!(RtiCapture::open(folder.path()).unwrap().file(0), folder.path().join("a.png"));
}

#[test]
fn images_of_two_sizes_too_large_or_broken() {
    let folder = tempfile::tempdir().unwrap();
    let save = |width: u32, height: u32| image::RgbImage::new(width, height).save(folder.path().join("b.jpg")).unwrap();
    stack_of(folder.path(), &["a.png", "b.jpg"], |path, _| grey(path));
    save(2, 4);
    assert!(error(folder.path()).ends_with("b.jpg: image size: found 2 x 4, expected 4 x 2, the size of a.png"));
    save(16385, 1);
    assert!(error(folder.path()).contains("b.jpg: image size: found 16385 x 1, expected 1 to 16384 along each side"));
    std::fs::write(folder.path().join("b.jpg"), "no image").unwrap();
    let text = error(folder.path());
    assert!(text.ends_with("b.jpg: image: found text, expected a complete PNG, JPEG, TIFF or EXR image"), "{text}");
    std::fs::write(folder.path().join("b.jpg"), b"GIF89a\x01\x00\x01\x00").unwrap();
    assert!(
        error(folder.path()).ends_with("b.jpg: image: found Gif, expected a complete PNG, JPEG, TIFF or EXR image")
    );
    // Every cut of a JPEG is an error, when it is opened or when it is read.
    let noise = image::RgbImage::from_fn(4, 2, |x, y| image::Rgb([(x * 60) as u8, (y * 99) as u8, 7]));
    noise.save(folder.path().join("b.jpg")).unwrap();
    let whole = std::fs::read(folder.path().join("b.jpg")).unwrap();
    assert!(RtiCapture::open(folder.path()).unwrap().image(1).is_ok());
    let mut refused = 0;
    for length in 0..whole.len() {
        std::fs::write(folder.path().join("b.jpg"), &whole[..length]).unwrap();
        let opened = RtiCapture::open(folder.path());
        refused += usize::from(opened.is_err());
        let read = opened.and_then(|stack| stack.image(1));
        assert!(matches!(read, Err(InputError::Format { .. })), "{length}");
    }
    assert!(refused > 100 && refused < whole.len(), "{refused} of {}", whole.len());
    let text = RtiCapture::open(folder.path()).and_then(|stack| stack.image(1)).unwrap_err().to_string();
    let expected = "b.jpg: image: no end-of-image marker (FF D9): the JPEG is truncated; expected a complete PNG, JPEG, TIFF or EXR image";
    assert!(text.ends_with(expected), "{text}");
}

#[test]
fn lists_that_are_none_or_several() {
    let folder = tempfile::tempdir().unwrap();
    assert!(
        error(folder.path())
            .ends_with("lists of lights: no .lp file; expected one .lp file in the folder, or the path of one")
    );
    grey(&folder.path().join("a.png"));
    let list = folder.path().join("b.lp");
    let error_of = |bytes: &[u8]| {
        std::fs::write(&list, bytes).unwrap();
        error(folder.path())
    };
    assert!(
        error_of(b"1\na.png 0 0 0").ends_with("b.lp: line 2, direction: vector of length 0; expected any other length")
    );
    assert!(error_of(b"2\n").contains("b.lp: line 1, lights: no lines after the first"));
    assert!(
        error_of(b"\x89PNG\r\n\x1a\n\0").ends_with("UTF-8; it looks like a PNG image (.png)")
            || error_of(b"\0").contains("NUL")
    );
    assert!(error_of(&[7, 0, 255]).contains("b.lp: line 1, text: NUL byte"));
    assert!(error_of(b"").contains("number of lights: empty file"));
    std::fs::write(&list, "1\na.png 0 0 1").unwrap();
    assert!(RtiCapture::open(folder.path()).is_ok());
    std::fs::write(folder.path().join("a.LP"), "").unwrap();
    assert!(error(folder.path()).contains("lists of lights: found a.LP, b.lp, expected one .lp file in the folder"));
    assert!(RtiCapture::open(&list).is_ok());
    let io = RtiCapture::open(&folder.path().join("none.lp"));
    assert!(matches!(io, Err(InputError::Io { .. })));
}

/// 72 photographs of an icon.
#[test]
fn a_real_stack() {
    let Some(folder) = shared_data("rti/icon") else { return };
    let stack = RtiCapture::open(&folder).unwrap();
    assert_eq!((stack.len(), stack.size()), (72, [402, 395]));
    assert!(stack.file(0).ends_with("image01.jpg"));
    for (found, stated) in stack.lights()[0].iter().zip([0.205_158_6, -0.237_020_6, 0.949_595_3]) {
        assert!((found - stated).abs() < 1e-6, "{:?}", stack.lights()[0]);
    }
    // The image as the library decodes it to 16 bits, level by level.
    let image = stack.image(5).unwrap();
    let other = image::open(stack.file(5)).unwrap().into_rgb16();
    for (found, code) in image.pixels.iter().flatten().zip(other.as_raw()) {
        assert_eq!(*found, brdfc_readers::colour::decode_srgb(f64::from(*code) / 65535.0) as f32);
    }
    let mean = |light: usize| stack.image(light).unwrap().pixels.iter().flatten().sum::<f32>() / (3.0 * 402.0 * 395.0);
    assert!((0.01..0.9).contains(&mean(0)) && mean(0) != mean(1));
    let start = std::time::Instant::now();
    let count = (0..stack.len()).map(|light| stack.image(light).unwrap().pixels.len()).sum::<usize>();
    println!("{:.2} ms per image", start.elapsed().as_secs_f64() * 1e3 / stack.len() as f64);
    assert_eq!(count, 72 * 402 * 395);
}
