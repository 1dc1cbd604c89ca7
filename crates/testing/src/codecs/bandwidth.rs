//! Bandwidth maps.

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, points, single};
use crate::packs::{Numbers, sealed, unit_vector};
use brdfc_formats::bandwidth::{BandwidthHeader, BandwidthKind, BandwidthMap};
use brdfc_formats::container::Texture;
use brdfc_formats::{Pack, PackKind};

/// The tested codec.
pub struct Bandwidth;

impl TestedCodec for Bandwidth {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let kind = BandwidthKind::Texture { metres: [0.5, 0.25], tiles: true };
        let header = BandwidthHeader { kind, epsilon: 0.01, transformed: [4, 2] };
        BandwidthMap::new(header, [2, 1], &[8.0, 12.5]).unwrap().to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let mut numbers = Numbers::new(15);
        let mut map = |kind, size: [u32; 2], largest: f64| {
            let header = BandwidthHeader { kind, epsilon: 0.01, transformed: size };
            let values: Vec<f32> = (0..size[0] * size[1]).map(|_| numbers.between(0.0, largest) as f32).collect();
            BandwidthMap::new(header, size, &values).unwrap()
        };
        let maps = [
            map(BandwidthKind::Brdf, [256; 2], 30.0),
            map(BandwidthKind::Environment, [512, 256], 80.0),
            map(BandwidthKind::Texture { metres: [0.01; 2], tiles: true }, [300, 77], 3e6),
        ];
        let queries: Vec<Query> = (0..SIDE * SIDE)
            .map(|_| {
                let [i, o] = [0; 2].map(|_| unit_vector(&mut numbers)).map(|[x, y, z]| [x, y, z.abs(), 0.0]);
                [i, o, [numbers.between(-2.0, 3.0) as f32, numbers.between(-2.0, 3.0) as f32, 0.0, 0.0]]
            })
            .collect();
        let three = |v: &[f32; 4]| [v[0], v[1], v[2]];
        let answer = |[a, b, c]: &Query| {
            let [brdf, environment, texture] = &maps;
            (
                [brdf.brdf(three(a), three(b)), environment.environment(three(a)), texture.texture([c[0], c[1]]), 0.0],
                1.0,
            )
        };
        let expected = queries.iter().map(answer).collect();
        let bindings = maps.iter().flat_map(|map| map.bindings().into_owned()).collect();
        let files = maps.iter().map(|map| map.to_bytes(true)).collect();
        let (name, decoder) = ("three maps".to_owned(), PackKind::Bandwidth);
        vec![Case { name, decoder, bindings, frame: EXACT, files, queries, expected }]
    }

    fn committed(&self) -> Files {
        let mut numbers = Numbers::new(4);
        let values: Vec<f32> = (0..15).map(|_| numbers.between(0.0, 40.0) as f32).collect();
        let header = BandwidthHeader { kind: BandwidthKind::Environment, epsilon: 0.02, transformed: [64, 32] };
        let map = BandwidthMap::new(header, [5, 3], &values).expect("values in range").to_bytes(false);
        // A writer uses the smallest sufficient scale.
        let mut texture = Texture::from_bytes(&map).expect("our own map");
        let entry = texture.entries.get_mut("brdfc.bandwidth").expect("the entry of a map");
        entry[36..].copy_from_slice(&64f32.to_le_bytes());
        // The uniform block starts with it.
        let block =
            texture.entries.get_mut("brdfc.uniform.bandwidth_environment_parameters").expect("the block of a map");
        block[..4].copy_from_slice(&64f32.to_le_bytes());
        let scaled = sealed(texture.to_bytes(false));
        let mut made = vec![("environment-scaled".to_owned(), scaled.clone())];
        made.extend(foreign_forms("environment-scaled", &scaled));
        made
    }

    /// Hashes all its values, and look-ups of its kind.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Bandwidth(map) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let header = map.header();
        numbers.words(header.transformed.into_iter().chain(map.size()));
        numbers.add([header.epsilon]);
        if let BandwidthKind::Texture { metres, tiles } = header.kind {
            numbers.add(metres);
            numbers.words([u32::from(tiles)]);
        }
        numbers.add(map.values());
        for incoming in directions().map(single) {
            numbers.add([map.environment(incoming)]);
            numbers.add(directions().map(single).map(|outgoing| map.brdf(incoming, outgoing)));
        }
        numbers.add(points().map(|uv| map.texture(uv)));
        of_columns([("values", numbers)])
    }
}
