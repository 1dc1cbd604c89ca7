//! BTF image stacks: written stacks are read back, and faults are reported.

use brdfc_formats::direction_set::DirectionSet;
use brdfc_jobs::btf_stack::{StackFormat, write_image};
use brdfc_readers::btf_stack::ImageAngles;
use brdfc_source::InputError;
use brdfc_source::btf_stack::BtfStack;
use std::path::{Path, PathBuf};

const SIZE: [usize; 2] = [5, 3];

fn views() -> DirectionSet {
    DirectionSet::grid(3, 4, 75.0).unwrap()
}

fn lights() -> DirectionSet {
    DirectionSet::grid(2, 3, 40.0).unwrap()
}

/// Multiples of 1/1024 from 0 to 2, which 16-bit floats hold exactly; different in every image.
fn pixels(view: usize, light: usize) -> Vec<[f32; 3]> {
    let value = |at: usize, k: usize| ((at * 131 + k * 37 + view * 17 + light * 71) % 2048) as f32 / 1024.0;
    (0..SIZE[0] * SIZE[1]).map(|at| [0, 1, 2].map(|k| value(at, k))).collect()
}

fn angles(view: usize, light: usize) -> ImageAngles {
    ImageAngles { light: lights().angles[light], view: views().angles[view] }
}

fn write_stack(folder: &Path, format: StackFormat) -> Vec<PathBuf> {
    let mut paths = Vec::new();
    for light in 0..lights().len() {
        for view in 0..views().len() {
            let number = light * views().len() + view;
            paths.push(write_image(folder, number, angles(view, light), &pixels(view, light), SIZE, format).unwrap());
        }
    }
    paths
}

fn open_error(folder: &Path) -> String {
    BtfStack::open(folder).err().expect("an error").to_string()
}

#[test]
fn exr_stacks_come_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_stack(folder.path(), StackFormat::Exr);
    assert!(paths[8].ends_with("tv075_pv270/00008 tl000 pl000 tv075 pv270.exr"), "{:?}", paths[8]);
    assert!(paths[1].ends_with("tv037.5_pv000/00001 tl000 pl000 tv037.5 pv000.exr"), "{:?}", paths[1]);
    std::fs::write(folder.path().join("readme.txt"), "not an image").unwrap();
    let stack = BtfStack::open(folder.path()).unwrap();
    assert_eq!((&stack.views().angles, &stack.lights().angles), (&views().angles, &lights().angles));
    assert_eq!(stack.size(), SIZE);
    for view in 0..views().len() {
        for light in 0..lights().len() {
            let image = stack.view(view, light).unwrap();
            assert_eq!([image.width, image.height], SIZE);
            assert_eq!(image.pixels, pixels(view, light), "view {view}, light {light}");
        }
    }
    assert_ne!(pixels(1, 2), pixels(2, 1), "the test can tell images apart");
    for (view, light, part) in [(9, 0, "view: found 9, expected less than 9"), (0, 4, "light: found 4")] {
        let error = stack.view(view, light).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn png_stacks_are_clipped_srgb() {
    let folder = tempfile::tempdir().unwrap();
    write_stack(folder.path(), StackFormat::Png);
    let stack = BtfStack::open(folder.path()).unwrap();
    let image = stack.view(3, 2).unwrap();
    let mut clipped = 0;
    for (found, written) in image.pixels.iter().flatten().zip(pixels(3, 2).iter().flatten()) {
        // Half a level is at most this much of linear light.
        assert!((found - written.min(1.0)).abs() < 0.0046, "{found} {written}");
        clipped += usize::from(*written > 1.0);
    }
    assert!(clipped > 0 && clipped < 45);
}

/// Row 0 is the top and column 0 the left, also in files by other programs.
#[test]
fn eight_and_sixteen_bits_and_grey_and_jpeg() {
    let folder = tempfile::tempdir().unwrap();
    let save = |image: image::DynamicImage, light: &str, extension: &str| {
        image.save(folder.path().join(format!("tl{light} pl000 tv000 pv000.{extension}"))).unwrap();
    };
    let mut eight = image::RgbaImage::new(2, 2);
    eight.put_pixel(1, 0, image::Rgba([255, 188, 10, 0]));
    save(eight.into(), "000", "png");
    let mut sixteen = image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::new(2, 2);
    sixteen.put_pixel(1, 0, image::Rgb([65535, 188 * 257, 10 * 257 + 128]));
    save(sixteen.into(), "010", "png");
    let mut grey = image::GrayImage::new(2, 2);
    grey.put_pixel(0, 1, image::Luma([188]));
    save(grey.into(), "020", "png");
    save(image::RgbImage::from_pixel(2, 2, image::Rgb([188; 3])).into(), "030", "jpg");
    let stack = BtfStack::open(folder.path()).unwrap();
    let read = |light: usize| stack.view(0, light).unwrap().pixels;
    let close = |a: [f32; 3], b: [f32; 3], within: f32| a.iter().zip(b).all(|(a, b)| (a - b).abs() < within);
    assert!(close(read(0)[1], [1.0, 0.502_886_5, 0.003_035_27], 1e-6), "{:?}", read(0));
    assert_eq!((read(0)[0], read(0)[2]), ([0.0; 3], [0.0; 3]));
    assert!(close(read(1)[1], [1.0, 0.502_886_5, 0.003_187_3], 1e-6), "{:?}", read(1));
    assert!(close(read(2)[2], [0.502_886_5; 3], 1e-6) && read(2)[1] == [0.0; 3], "{:?}", read(2));
    assert!(read(3).into_iter().all(|pixel| close(pixel, [0.502_886_5; 3], 0.02)), "{:?}", read(3));
}

#[test]
fn missing_and_duplicate_images() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_stack(folder.path(), StackFormat::Png);
    std::fs::remove_file(&paths[5]).unwrap();
    let error = open_error(folder.path());
    let expected = "stack: 1 of 36 images missing, the first at tl000 pl000 tv075 pv000; expected images of all 9";
    assert!(error.contains(expected), "{error}");
    std::fs::copy(&paths[4], folder.path().join("tl000 pl000 tv037.50 pv270.png")).unwrap();
    assert!(open_error(folder.path()).contains("repeats the directions of"), "{}", open_error(folder.path()));
}

#[test]
fn images_of_two_sizes() {
    let folder = tempfile::tempdir().unwrap();
    let paths = write_stack(folder.path(), StackFormat::Png);
    image::RgbImage::new(3, 5).save(&paths[7]).unwrap();
    let error = open_error(folder.path());
    assert!(error.contains(&paths[7].file_name().unwrap().to_string_lossy().into_owned()), "{error}");
    let first = paths[0].file_name().unwrap().to_string_lossy();
    assert!(error.contains("found 3 x 5, expected 5 x 3, the size of ") && error.contains(&*first), "{error}");
}

#[test]
fn images_that_are_too_large_broken_or_of_another_kind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tl000 pl000 tv000 pv000.png");
    image::GrayImage::new(16385, 1).save(&path).unwrap();
    assert!(open_error(folder.path()).contains("found 16385 x 1, expected 1 to 16384"));
    std::fs::write(&path, b"GIF89a\x01\x00\x01\x00").unwrap();
    assert!(open_error(folder.path()).contains("PNG, JPEG, TIFF or EXR"));
    std::fs::write(&path, b"").unwrap();
    assert!(open_error(folder.path()).contains("PNG, JPEG, TIFF or EXR"));
    image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([(x * y) as u8, x as u8, y as u8])).save(&path).unwrap();
    let whole = std::fs::read(&path).unwrap();
    // The header is intact, so only decoding fails.
    std::fs::write(&path, &whole[..whole.len() / 2]).unwrap();
    let stack = BtfStack::open(folder.path()).unwrap();
    let error = stack.view(0, 0).unwrap_err();
    assert!(matches!(error, InputError::Format { .. }) && error.to_string().contains("tl000"), "{error}");
    // The size changes after opening.
    image::RgbImage::new(2, 2).save(&path).unwrap();
    assert!(stack.view(0, 0).unwrap_err().to_string().contains("found 2 x 2, expected 64 x 64"));
    std::fs::remove_file(&path).unwrap();
    assert!(matches!(stack.view(0, 0), Err(InputError::Io { .. })));
    std::fs::write(&path, &whole).unwrap();
    assert!(stack.view(0, 0).is_ok());
}

#[test]
fn broken_files_do_not_panic() {
    let folder = tempfile::tempdir().unwrap();
    for format in [StackFormat::Png, StackFormat::Exr] {
        let path = write_image(folder.path(), 0, angles(0, 0), &pixels(0, 0), SIZE, format).unwrap();
        let whole = std::fs::read(&path).unwrap();
        let mut refused = 0;
        for at in 0..whole.len() {
            for flip in [0x01, 0xff] {
                let mut changed = whole.clone();
                changed[at] ^= flip;
                std::fs::write(&path, changed).unwrap();
                let read = BtfStack::open(folder.path()).and_then(|stack| stack.view(0, 0));
                refused += usize::from(read.is_err());
            }
        }
        assert!(refused > 50, "{refused}");
        std::fs::remove_file(path).unwrap();
    }
}

#[test]
fn no_images_or_no_folder() {
    let folder = tempfile::tempdir().unwrap();
    assert!(open_error(folder.path()).contains("no images"));
    assert!(matches!(BtfStack::open(&folder.path().join("none")), Err(InputError::Io { .. })));
    // Two levels are searched, not three.
    let deep = folder.path().join("a/b");
    std::fs::create_dir_all(&deep).unwrap();
    image::GrayImage::new(1, 1).save(deep.join("tl000 pl000 tv000 pv000.png")).unwrap();
    assert!(open_error(folder.path()).contains("no images"));
    assert!(BtfStack::open(&folder.path().join("a")).is_ok());
}

#[test]
#[cfg(unix)]
fn links_to_folders_are_not_entered() {
    let folder = tempfile::tempdir().unwrap();
    write_stack(folder.path(), StackFormat::Png);
    std::os::unix::fs::symlink(folder.path(), folder.path().join("loop")).unwrap();
    std::os::unix::fs::symlink("nothing", folder.path().join("tl080 pl000 tv000 pv000.png")).unwrap();
    assert_eq!(BtfStack::open(folder.path()).unwrap().views().len(), 9);
}

#[test]
fn invalid_images_are_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let write = |pixels: &[[f32; 3]], size| {
        write_image(folder.path(), 0, angles(0, 0), pixels, size, StackFormat::Png).unwrap_err().to_string()
    };
    assert_eq!(write(&[[0.0; 3]; 5], [2, 3]), "5 pixels for an image of 2 x 3");
    assert!(write(&[], [0, 0]).contains("0 pixels"));
    assert!(write(&[[0.0; 3], [0.0, f32::NAN, 0.0]], [2, 1]).contains("pixel (1, 0)"));
    assert!(write(&[[f32::INFINITY, 0.0, 0.0]], [1, 1]).contains("pixel (0, 0)"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn the_same_bytes_every_time() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    for format in [StackFormat::Png, StackFormat::Exr] {
        let [first, second] = folders.each_ref().map(|folder| write_stack(folder.path(), format));
        for (a, b) in first.iter().zip(&second) {
            assert_eq!(std::fs::read(a).unwrap(), std::fs::read(b).unwrap());
        }
    }
}
