//! Broken RGL files: each error has the place and the field, and none panics.

use std::f32::consts::{FRAC_PI_2, PI};

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::{FormatError, Place};
use brdfc_readers::rgl::{Colour, Rgl};
use brdfc_readers::tensor::{ElementKind, TensorFile};
use brdfc_source::rgl::RglSource;
use brdfc_testing::tensor::{Container, Field, Material};

fn material() -> Container {
    Material::default().container()
}

fn refused(container: &Container) -> FormatError {
    Rgl::from_bytes(&container.build()).unwrap_err()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

/// Reads and, if the file is valid, evaluates it.
fn survive(bytes: &[u8]) -> bool {
    let Ok(rgl) = Rgl::from_bytes(bytes) else { return false };
    if let Ok(source) = RglSource::new(rgl, |wavelengths| Ok(vec![[1.0; 3]; wavelengths.len()])) {
        let pair = DirectionPair::from_angles(0.4, 0.3, 0.8, 2.0);
        assert!(source.eval(pair, &mut Tally::default()).iter().all(|v| v.is_finite()));
    }
    true
}

#[test]
fn a_whole_file_reads_back() {
    let rgl = Rgl::from_bytes(&material().build()).unwrap();
    assert_eq!(rgl.description, "test");
    assert_eq!((rgl.phi_i.as_slice(), rgl.theta_i.len(), rgl.jacobian), ([0.0].as_slice(), 2, true));
    assert_eq!((rgl.ndf.values.as_slice(), rgl.sigma.values.as_slice()), ([2.0; 4].as_slice(), [0.5; 4].as_slice()));
    let Colour::Rgb(values) = rgl.colour else { panic!("not RGB") };
    assert_eq!(values.len(), 24);
}

#[test]
fn every_truncation_is_an_error() {
    let container = material();
    let bytes = container.build();
    let start = container.data_offsets()[0];
    let boundaries = container.data_offsets().into_iter().flat_map(|offset| [offset - 1, offset, offset + 1]);
    for length in (0..start).chain(boundaries).chain([bytes.len() - 1]) {
        assert!(Rgl::from_bytes(&bytes[..length]).is_err(), "{length} bytes");
    }
    assert!(Rgl::from_bytes(&bytes).is_ok());
}

#[test]
fn no_single_corrupt_byte_panics() {
    let container = material();
    let bytes = container.build();
    let start = container.data_offsets()[0];
    let mut valid = 0;
    for offset in 0..bytes.len() {
        let mut broken = bytes.clone();
        // All values in the headers, and a sample of them in the data.
        let step = if offset < start { 1 } else { 15 };
        for value in (0..=u8::MAX).step_by(step) {
            broken[offset] = value;
            valid += usize::from(survive(&broken));
        }
    }
    assert!(valid >= start);
}

#[test]
fn magic_and_version_are_checked() {
    let bytes = material().build();
    for (offset, value, field) in [(0, b'T', "magic"), (11, b' ', "magic"), (12, 2, "version"), (13, 1, "version")] {
        let mut broken = bytes.clone();
        broken[offset] = value;
        assert_eq!(Rgl::from_bytes(&broken).unwrap_err().field, field);
    }
    assert_eq!(
        Rgl::from_bytes(b"tensor_file\0\x01\x07\0\0\0\0").unwrap_err().to_string(),
        "byte 12, version: found 1.7, expected 1.0"
    );
}

#[test]
fn a_field_count_beyond_the_file_ends_with_the_file() {
    let mut bytes = material().build();
    bytes[14..18].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(Rgl::from_bytes(&bytes).is_err());
}

#[test]
fn extents_that_do_not_fit_are_refused() {
    for extents in [
        vec![0, 2, 2, 2],
        vec![1, 2, 2, 0],
        vec![1, 2, 1 << 31, 1 << 31],
        vec![1 << 63],
        vec![u64::MAX; 4],
        vec![1 << 32, 1 << 32, 1 << 32, 0],
        vec![0, u64::MAX, u64::MAX],
        vec![1 << 31],
        vec![1, 2, 2, 1000],
        vec![1, 2, 4],
        vec![8],
        vec![1; 60_000],
        vec![],
    ] {
        let mut container = material();
        container.field("vndf").shape = extents.clone();
        let error = refused(&container);
        assert!(error.field.starts_with("vndf"), "{extents:?}: {error}");
    }
}

#[test]
fn a_shape_longer_than_the_file_is_refused() {
    let container = material();
    let mut bytes = container.build();
    let rank = container.header_offsets()[5] + 2 + "vndf".len();
    bytes[rank..rank + 2].copy_from_slice(&u16::MAX.to_le_bytes());
    assert_eq!(Rgl::from_bytes(&bytes).unwrap_err().field, "shape");
}

#[test]
fn data_are_after_the_headers_and_inside_the_file() {
    let container = material();
    let bytes = container.build();
    let field = container.header_offsets()[5] + 2 + "vndf".len() + 3;
    let end = bytes.len() as u64;
    for offset in [0, container.data_offsets()[0] as u64 / 2, end - 31, end, end + 1, 1 << 63, u64::MAX] {
        let mut broken = bytes.clone();
        broken[field..field + 8].copy_from_slice(&offset.to_le_bytes());
        let error = Rgl::from_bytes(&broken).unwrap_err();
        assert!(error.field.starts_with("vndf"), "{offset}: {error}");
    }
}

#[test]
fn names_are_utf_8_and_unique() {
    let mut twice = material();
    twice.fields.push(Field { name: b"ndf".to_vec(), ..twice.fields[4].clone() });
    let error = refused(&twice);
    let header = twice.header_offsets()[twice.fields.len() - 1] as u64;
    assert_eq!((error.field.as_ref(), error.place), ("ndf name", Place::Byte(header)));

    let mut binary = material();
    binary.fields[4].name = b"si\xffma".to_vec();
    let error = refused(&binary);
    let header = binary.header_offsets()[4] as u64;
    assert_eq!((error.field.as_ref(), error.place), ("name", Place::Byte(header + 2 + 2)));
}

#[test]
fn a_value_that_is_not_finite_or_out_of_range_is_named_with_its_byte() {
    for (name, values) in [
        ("phi_i", vec![f32::NAN, f32::INFINITY, 7.0, -7.0]),
        ("theta_i", vec![f32::NAN, -0.1, 1.6, 2.0]),
        ("ndf", vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -1.0]),
        ("sigma", vec![f32::NAN, f32::INFINITY, -1.0]),
        ("vndf", vec![f32::NAN, f32::INFINITY, -1.0]),
        ("rgb", vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY]),
    ] {
        for value in values {
            let mut container = material();
            let field = container.field(name);
            let last = field.data.len() - 4;
            field.data[last..].copy_from_slice(&value.to_le_bytes());
            let index = container.fields.iter().position(|f| f.name == name.as_bytes()).unwrap();
            let error = refused(&container);
            assert!(error.field.starts_with(&format!("{name} element")), "{error}");
            assert_eq!(error.place, Place::Byte((container.data_offsets()[index] + last) as u64));
        }
    }
    let mut container = material();
    container.field("jacobian").data = vec![2];
    assert_eq!(refused(&container).field, "jacobian element 0");
    // Measured colours may be negative.
    let mut container = material();
    container.field("rgb").data[0..4].copy_from_slice(&(-0.01f32).to_le_bytes());
    assert!(Rgl::from_bytes(&container.build()).is_ok());
}

#[test]
fn axes_increase_strictly() {
    for values in [[0.5, 0.5], [0.6, 0.5]] {
        let mut container = material();
        container.field("theta_i").data = floats(&values);
        assert_eq!(refused(&container).field, "theta_i element 1");
    }
    let container = Material { wavelengths: Some(vec![700.0, 400.0]), colour: |_| 1.0, ..Material::default() };
    assert_eq!(refused(&container.container()).field, "wavelengths element 1");
}

#[test]
fn azimuths_cover_the_circle_or_a_known_part_of_it() {
    let with = |phi_i: [f32; 3]| Material { phi_i: phi_i.to_vec(), ..Material::default() }.container();
    for (phi_i, field) in [
        ([0.0, 1.0, 0.75 * PI], "phi_i span"),
        ([0.0, 0.1, 0.3], "phi_i span"),
        ([-PI, 0.0, PI + 0.1], "phi_i span"),
        ([-0.25 * PI, 0.0, 0.25 * PI], "phi_i range"),
    ] {
        assert_eq!(refused(&with(phi_i)).field, field, "{phi_i:?}");
    }
    for phi_i in [[-PI, 0.0, PI], [0.0, 3.0, 2.0 * PI], [-PI, -1.0, 0.0], [0.0, 1.0, FRAC_PI_2]] {
        assert!(Rgl::from_bytes(&with(phi_i).build()).is_ok(), "{phi_i:?}");
    }
}

#[test]
fn every_field_but_luminance_is_required() {
    for name in ["description", "phi_i", "theta_i", "ndf", "sigma", "vndf", "jacobian", "rgb"] {
        let error = refused(&material().without(name));
        assert!(error.field.starts_with(name), "{error}");
    }
    assert!(Rgl::from_bytes(&material().without("luminance").build()).is_ok());
    let spectral = Material { wavelengths: Some(vec![400.0]), colour: |_| 1.0, ..Material::default() }.container();
    assert!(Rgl::from_bytes(&spectral.build()).is_ok());
    assert_eq!(refused(&spectral.without("wavelengths")).field, "wavelengths");
}

#[test]
fn rgb_and_spectra_exclude_each_other() {
    let mut both = material().f32("wavelengths", &[3], [400.0, 500.0, 600.0]);
    let rgb = both.field("rgb").clone();
    both.fields.push(Field { name: b"spectra".to_vec(), ..rgb });
    assert_eq!(refused(&both).field, "spectra field");
}

#[test]
fn shapes_fit_each_other() {
    let reshaped = |name: &str, shape: &[u64]| {
        let mut container = material().without(name);
        let count = shape.iter().product::<u64>() as usize;
        container = container.f32(name, shape, vec![0.5; count]);
        refused(&container)
    };
    for (name, shape) in [
        ("phi_i", vec![1, 1]),
        ("phi_i", vec![0]),
        ("theta_i", vec![2, 1]),
        ("ndf", vec![4]),
        ("ndf", vec![1, 4]),
        ("sigma", vec![4, 1]),
        ("vndf", vec![2, 1, 2, 2]),
        ("vndf", vec![1, 2, 2, 1]),
        ("luminance", vec![1, 2, 3, 2]),
        ("rgb", vec![1, 2, 4, 2, 2]),
        ("rgb", vec![1, 2, 3, 4]),
    ] {
        assert_eq!(reshaped(name, &shape).field, format!("{name} shape"), "{shape:?}");
    }
    let mut container = material();
    container.field("jacobian").shape = vec![1, 1];
    assert_eq!(refused(&container).field, "jacobian shape");
}

#[test]
fn element_types_are_checked() {
    for name in ["description", "phi_i", "theta_i", "ndf", "sigma", "vndf", "luminance", "jacobian", "rgb"] {
        let mut container = material();
        container.field(name).code = 2;
        assert_eq!(refused(&container).field, format!("{name} element type"));
        container.field(name).code = 12;
        assert_eq!(refused(&container).field, format!("{name} element type"));
        container.field(name).code = 0;
        assert_eq!(refused(&container).field, format!("{name} element type"));
    }
}

#[test]
fn visible_normals_that_are_all_zero_are_refused() {
    let mut container = material();
    container.field("vndf").data[16..].fill(0);
    assert_eq!(refused(&container).field, "vndf element 4");
}

#[test]
fn unknown_fields_are_checked_as_containers_and_then_ignored() {
    let mut container = material();
    for code in 1..=11u8 {
        let size = [1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8][usize::from(code) - 1];
        container.fields.push(Field { name: vec![b'a' + code], code, shape: vec![3], data: vec![0xff; 3 * size] });
    }
    container.fields.push(Field { name: b"scalar".to_vec(), code: 10, shape: vec![], data: vec![0; 4] });
    container.fields.push(Field { name: b"empty".to_vec(), code: 10, shape: vec![4, 0], data: vec![] });
    container = container.u8("valid", &[1, 2, 3]);
    let bytes = container.build();
    assert_eq!(Rgl::from_bytes(&bytes), Rgl::from_bytes(&material().build()));
    let file = TensorFile::parse(&bytes).unwrap();
    assert_eq!(file.get("scalar").unwrap().kind, ElementKind::F32);
    assert_eq!((file.get("scalar").unwrap().data.len(), file.get("empty").unwrap().data.len()), (4, 0));
    assert_eq!(file.tensors().len(), container.fields.len());
}

#[test]
fn the_dump_on_the_page_of_the_layout_is_this_file() {
    let page = include_str!("../../../../crates/readers/src/rgl.md");
    let bytes = material().build();
    let mut lines = 0;
    for line in page.lines() {
        let Some((offset, rest)) = line.split_once("  ") else { continue };
        let Ok(offset) = usize::from_str_radix(offset, 16) else { continue };
        let hex: Vec<u8> =
            rest.split("  ").next().unwrap().split(' ').map(|b| u8::from_str_radix(b, 16).unwrap()).collect();
        assert_eq!(hex, bytes[offset..offset + 16], "line {offset:#x}");
        lines += 1;
    }
    assert_eq!(lines, 6);
}
