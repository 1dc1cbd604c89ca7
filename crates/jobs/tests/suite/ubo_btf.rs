//! Files of the Bonn database of 2014 as ordinary BTFs.

#[path = "../../../readers/tests/suite/ubo_btf/write.rs"]
mod write_btf;

use brdfc_formats::direction_set::DirectionSet;
use brdfc_jobs::flatten::{SurfaceFacts, describe_surface};
use brdfc_readers::ubo_btf::{Channel, ColourModel, Description, Scalar, UboBtf};
use brdfc_source::btf_stack::BtfStack;
use brdfc_source::open::open;
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::{Input, InputError, Kind};
use std::path::{Path, PathBuf};
use write_btf::to_bytes;

/// Red grows with the texel, green with the pair of directions, blue is 0.25: 2 x 3 texels, one view, two lights.
fn example(has_cosine: bool) -> UboBtf {
    let set = |angles: &[[f64; 2]]| DirectionSet::new("of the file", angles.to_vec()).unwrap();
    let description = Description {
        version: 2,
        devices: ["dome", "", "LED"].map(str::to_owned),
        texels_per_millimetre: 1.0,
        rgb_factors: [1.0; 3],
        has_cosine,
        xml_bytes: 0,
        views: set(&[[30.0, 0.0]]),
        lights: set(&[[0.0, 0.0], [60.0, 90.0]]),
        size: [2, 3],
        colour_model: ColourModel::Rgb,
    };
    let channel = |pairs: &[f32], texels: &[f32]| Channel::new(1, pairs, texels, Scalar::Half).unwrap();
    let red = channel(&[1.0, 1.0], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    let channels = [red, channel(&[0.5, 1.0], &[1.0; 6]), channel(&[0.25; 2], &[1.0; 6])];
    UboBtf::new(description, channels).unwrap()
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn images_are_radiance_relative_to_white() {
    let folder = tempfile::tempdir().unwrap();
    for (name, has_cosine, factor) in [("without.btf", false, 0.5), ("WITH.BTF", true, 1.0)] {
        let path = write(folder.path(), name, &to_bytes(&example(has_cosine), Scalar::Half));
        assert_eq!(Kind::of(&path.as_path().into()).unwrap(), Kind::Btf);
        let btf = OrdinaryBtf::open(&path).unwrap();
        assert_eq!((btf.size(), btf.views().len(), btf.lights().len()), ([2, 3], 1, 2));
        assert_eq!(btf.lights().angles[1], [60.0, 90.0]);
        let image = btf.image(0, 0).unwrap();
        assert_eq!((image.width, image.height), (2, 3));
        assert_eq!(image.pixels, (0..6).map(|k| [k as f32, 0.5, 0.25]).collect::<Vec<_>>());
        // Under the light at 60 degrees.
        for (k, pixel) in btf.image(0, 1).unwrap().pixels.iter().enumerate() {
            for (found, value) in pixel.iter().zip([k as f32, 1.0, 0.25]) {
                assert!((found - factor * value).abs() < 1e-6, "{name} {pixel:?}");
            }
        }
        assert!(btf.image(0, 2).is_err() && btf.image(1, 0).is_err());
    }
    assert!(BtfStack::open(&folder.path().join("without.btf")).is_err());
}

#[test]
fn files_are_described_and_rejected_as_other_inputs() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = to_bytes(&example(false), Scalar::Single);
    let path = write(folder.path(), "felt.btf", &bytes);
    let facts = describe_surface(&Input::from(path.clone().into_os_string())).unwrap();
    let SurfaceFacts::UboBtf { views, lights, size, components, devices, memory_bytes, .. } = facts else {
        panic!("{facts:?}")
    };
    assert_eq!((views, lights, size, components), (1, 2, [2, 3], vec![1, 1, 1]));
    assert_eq!((devices, memory_bytes), (vec!["dome".to_owned(), "LED".to_owned()], 3 * 8 * 4));

    let error_of = |path: &Path| open(path.as_os_str().to_owned(), None).err().expect("an error").to_string();
    assert!(error_of(&path).contains("found a BTF, expected .binary (MERL), "), "{}", error_of(&path));
    let misnamed = error_of(&write(folder.path(), "felt.binary", &bytes));
    assert!(misnamed.contains("it looks like a BTF of the Bonn database of 2014 (.btf)"), "{misnamed}");

    let error = |bytes: &[u8]| OrdinaryBtf::open(&write(folder.path(), "bad.btf", bytes)).err().expect("an error");
    assert!(error(&bytes[..100]).to_string().contains("bad.btf: byte"));
    assert!(error(b"\x89PNG\r\n\x1a\n...").to_string().ends_with("; it looks like a PNG image (.png)"));
    assert!(matches!(OrdinaryBtf::open(&folder.path().join("none.btf")), Err(InputError::Io { .. })));
}
