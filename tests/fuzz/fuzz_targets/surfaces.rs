//! Arbitrary bytes, or a valid file with edits, for every reader of the inputs and files of flat BTFs, of bandwidth maps, importance
//! samples, prefiltered environments and lobes; meshes are welded, packs written and read again.
#![no_main]

mod edits;

use brdfc_flat_btf::weld::weld;
use brdfc_formats::FormatError;
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::container::seal;
use brdfc_formats::environment::EnvironmentPack;
use brdfc_formats::flat_btf::FlatBtfFile;
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_formats::lobes::LobesPack;
use brdfc_readers::direction_list;
use brdfc_readers::meso::{TriangleMesh, obj, ply};
use brdfc_source::meso::{heights_from_exr, heights_from_png};
use brdfc_source::radiance_image;
use brdfc_testing::codec::TestedCodec;
use brdfc_testing::codecs::environment::Environment;
use brdfc_testing::codecs::flat_btf;
use brdfc_testing::codecs::lobes::Lobes;
use libfuzzer_sys::fuzz_target;

const READERS: u8 = 13;

/// Two triangles over the tile.
const OBJ: &[u8] = b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl clay\nf 1 2 3\nf 1 3 4\n";
const PLY: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 2\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 2 3\n";
const HDR: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x40\x40\x40\x80";

fn environment() -> BandwidthMap {
    let header = BandwidthHeader { kind: BandwidthKind::Environment, epsilon: 0.01, transformed: [8, 4] };
    BandwidthMap::new(header, [4, 2], &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]).expect("a map")
}

fn samples() -> ImportancePack {
    let header = ImportanceHeader { polar: 2, azimuths: 1, samples: 2 };
    ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 4]).expect("a pack")
}

fn valid(reader: u8) -> Vec<u8> {
    match reader {
        0 => OBJ.to_vec(),
        1 => PLY.to_vec(),
        2 => b"index,theta_deg,phi_deg\n0,0,0\n1,40,-90\n2,40,90\n".to_vec(),
        3 => HDR.to_vec(),
        4 => flat_btf::materials_file().to_bytes(false),
        5 => flat_btf::factored_file().to_bytes(false),
        6 => environment().to_bytes(false),
        7 => samples().to_bytes(false),
        8 => Environment.small_pack(false),
        9 => Lobes.small_pack(false),
        // Without edits, because compressed images rarely survive them.
        _ => Vec::new(),
    }
}

fn surface(mesh: Result<TriangleMesh, FormatError>) -> bool {
    mesh.map(|mesh| drop(weld(&mesh, 1.0))).is_ok()
}

/// Reads, writes and reads again.
macro_rules! again {
    ($part:ty, $bytes:expr) => {
        <$part>::from_bytes($bytes)
            .map(|part| {
                let written = part.to_bytes(true);
                let again = <$part>::from_bytes(&written).expect("what is written is read");
                assert_eq!(part.to_bytes(false), again.to_bytes(false));
            })
            .is_ok()
    };
}

fn read(reader: u8, bytes: &[u8]) -> bool {
    match reader {
        0 => surface(obj::from_bytes(bytes)),
        1 => surface(ply::from_bytes(bytes)),
        2 => direction_list::from_csv(bytes).is_ok(),
        3 => radiance_image::from_hdr(bytes).is_ok(),
        4 | 5 => again!(FlatBtfFile, bytes),
        6 => again!(BandwidthMap, bytes),
        7 => again!(ImportancePack, bytes),
        8 => again!(EnvironmentPack, bytes),
        9 => again!(LobesPack, bytes),
        10 => heights_from_png(bytes).is_ok(),
        11 => heights_from_exr(bytes).is_ok(),
        _ => radiance_image::from_exr(bytes).is_ok(),
    }
}

fuzz_target!(|data: &[u8]| {
    let Some((choice, rest)) = data.split_first() else { return };
    let reader = (choice & 0x7f) % READERS;
    if choice & 0x80 == 0 {
        let mut bytes = valid(reader);
        let edited = !bytes.is_empty();
        edits::edit(&mut bytes, rest);
        // For packs, after the checksum.
        seal(&mut bytes);
        // Otherwise the edits would apply to a file that was never valid.
        assert!(read(reader, &bytes) || rest.len() >= 4 || !edited, "reader {reader}");
    } else {
        read(reader, rest);
    }
});
