//! Arbitrary bytes, or a valid file with edits, for every reader of measured data; the result is evaluated.
#![no_main]

mod edits;
#[path = "../../../crates/readers/tests/suite/ubo_btf/write.rs"]
mod write_btf;

use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, TexelFormat, Texture, rgb9e5};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_readers::alta::AltaTable;
use brdfc_readers::colour::rgb_weights;
use brdfc_readers::cube_map::{CubeMap, is_pack};
use brdfc_readers::merl::{self, Merl};
use brdfc_readers::ptm::Ptm;
use brdfc_readers::rgl::Rgl;
use brdfc_readers::rti::Rti;
use brdfc_readers::rti_capture::LightPositions;
use brdfc_readers::scan::Scan;
use brdfc_readers::scan_csv;
use brdfc_readers::ubo_btf::{Channel, ColourModel, Description, Scalar, UboBtf};
use brdfc_readers::viewer_file::ViewerFile;
use brdfc_source::{MerlSource, RglSource, ScanSource};
use brdfc_testing::tensor;
use libfuzzer_sys::fuzz_target;
use std::collections::BTreeMap;
use std::f32::consts::FRAC_PI_2;
use write_btf::to_bytes;

const READERS: u8 = 12;

fn valid(reader: u8) -> Vec<u8> {
    match reader {
        0 => {
            let dimensions = merl::Dimensions { theta_half: 2, theta_difference: 2, phi_difference: 4 };
            let mut bytes = Vec::new();
            let value = |[h, d, p]: [f64; 3]| (d < 1.0 || p < 1.0).then_some([h + 0.1, d, p]);
            merl::write(&mut bytes, dimensions, value).expect("memory takes it");
            bytes
        }
        1 => {
            let rows: String = (0..9).map(|k| format!("0.{k} {} 0.5 -1.{k} 0.1 1e-{k}\n", k % 2)).collect();
            format!("# scan\n2\n450 650 # nm\n{rows}").into_bytes()
        }
        2 => {
            let rows: String = (0..9).map(|k| format!("0.{k},{},0.5,-1.{k},0.1,1e-{k},-1\n", k % 2)).collect();
            format!("{}\n{rows}", scan_csv::ANGLE_COLUMNS.join(",")).into_bytes()
        }
        3 => b"id,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n7,0,0,1,0,0.6,0.8\n".to_vec(),
        4 => {
            let rows: String = (0..9).map(|k| format!("0.{k} 0.3 -0.{k} 1e-{k}\n")).collect();
            format!("#DIM 3 1\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n#PARAM_OUT INV_STERADIAN\n{rows}").into_bytes()
        }
        5 => tensor::Material { phi_i: vec![0.0, 0.8, FRAC_PI_2], ..Default::default() }.container().build(),
        6 => tensor::Material { wavelengths: Some(vec![450.0, 650.0]), colour: |at| at.s, ..Default::default() }
            .container()
            .build(),
        7 => b"3\r\na 1.png 0 0 2\nb/c.jpg -1e-1 0.5 1\nd\\e.exr 3 0 4\n".to_vec(),
        11 => {
            let numbers = (0..8).flat_map(|k| (k as f32).to_le_bytes());
            b"#HSH1.2\r\n3\r\n2 1 3\r\n4 2 1\r\n".iter().copied().chain(numbers).chain(0..24).collect()
        }
        10 => {
            let texels: Vec<u8> =
                (0..6 * 16u32).flat_map(|at| rgb9e5::encode([at as f32, 1.0, 2.0]).to_le_bytes()).collect();
            let (format, extent) = (TexelFormat::Rgb9E5, Extent::Cube(4));
            Texture { format, extent, entries: BTreeMap::new(), levels: 1, texels }.to_bytes(true)
        }
        9 => {
            let set = DirectionSet::grid(2, 2, 60.0).expect("a small set");
            let description = Description {
                version: 4,
                devices: [const { String::new() }; 3],
                texels_per_millimetre: 1.0,
                rgb_factors: [1.0; 3],
                has_cosine: false,
                xml_bytes: 0,
                views: set.clone(),
                lights: set,
                size: [2, 3],
                colour_model: ColourModel::LogYRatioUv,
            };
            let channel =
                |k| Channel::new(k, &vec![0.25; 9 * k], &vec![-0.5; 6 * k], Scalar::Half).expect("whole rows");
            to_bytes(&UboBtf::new(description, [2, 1, 1].map(channel)).expect("as many rows"), Scalar::Half)
        }
        _ => {
            let luminance: Vec<_> = (0..6).map(|k| [k as f32, -0.5, 3.0, 1.0, 0.0, 200.0 - k as f32]).collect();
            let map = Ptm::from_coefficients_lrgb([2, 3], &luminance, &[[9, 90, 255]; 6]);
            map.expect("coefficients are finite").to_bytes()
        }
    }
}

fn evaluate(source: &dyn Source) {
    for (theta_i, theta_o) in [(0.4, 0.8), (0.0, 0.0), (1.5, 1.55)] {
        let pair = DirectionPair::from_angles(theta_i, 0.3, theta_o, 2.0);
        let value = source.eval(pair, &mut Tally::default());
        assert!(value.iter().all(|v| v.is_finite()), "{value:?}");
    }
}

fn check_light(direction: &[f32; 3]) {
    let length = direction.iter().map(|c| c * c).sum::<f32>();
    assert!((length - 1.0).abs() < 1e-5, "{direction:?}");
}

/// Reads a map whose planes are not compressed.
fn map_from_bytes(bytes: &[u8]) -> Result<Ptm, FormatError> {
    Ptm::from_bytes(bytes, &|plane, _| Ok(plane.to_vec()))
}

fn check_map(map: &Ptm) {
    let value = map.value(0, [0.3, -0.6]);
    assert!(value.iter().all(|v| (0.0..=255.0).contains(v)), "{value:?}");
    assert_eq!(map_from_bytes(&map.to_bytes()).expect("a map").model(), map.model());
}

fn check_cube(cube: &CubeMap) {
    assert_eq!(cube.texels().len(), 6 * (cube.side() as usize).pow(2));
    assert!(cube.texels().iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
}

/// Returns true if the reader accepts the bytes and, for reflectance, a source can be built from them.
fn read(reader: u8, bytes: &[u8]) -> bool {
    match reader {
        0 => Merl::from_bytes(bytes).map(|table| evaluate(&MerlSource::new(table))).is_ok(),
        1 | 2 => {
            let scan = if reader == 1 { Scan::from_bytes(bytes) } else { scan_csv::from_bytes(bytes) };
            scan.and_then(|scan| ScanSource::new(&scan)).map(|source| evaluate(&source)).is_ok()
        }
        3 => scan_csv::directions_from_bytes(bytes).is_ok(),
        4 => AltaTable::from_bytes(bytes)
            .and_then(|table| ScanSource::new(&table.scan))
            .map(|source| evaluate(&source))
            .is_ok(),
        7 => LightPositions::from_bytes(bytes).map(|lights| lights.directions.iter().for_each(check_light)).is_ok(),
        8 => map_from_bytes(bytes).map(|map| check_map(&map)).is_ok(),
        11 => Rti::from_bytes(bytes)
            .map(|rti| assert!(rti.under([0.6, 0.0, 0.8])(0).iter().all(|level| level.is_finite())))
            .is_ok(),
        10 => !is_pack(bytes) && CubeMap::from_bytes(bytes).map(|cube| check_cube(&cube)).is_ok(),
        9 => UboBtf::from_bytes(bytes)
            .and_then(|btf| btf.image(0, 0))
            .map(|image| assert!(image.iter().flatten().all(|v| v.is_finite())))
            .is_ok(),
        _ => Rgl::from_bytes(bytes)
            .and_then(|rgl| RglSource::new(rgl, rgb_weights))
            .map(|source| evaluate(&source))
            .is_ok(),
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((choice, rest)) = data.split_first() else { return };
    let reader = (choice & 0x7f) % READERS;
    if choice & 0x80 == 0 {
        let mut bytes = valid(reader);
        edits::edit(&mut bytes, rest);
        // Otherwise the edits would apply to a file that was never valid.
        assert!(read(reader, &bytes) || rest.len() >= 4, "reader {reader}");
    } else {
        read(reader, rest);
    }
});
