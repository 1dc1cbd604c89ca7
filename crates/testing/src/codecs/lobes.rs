//! Lobes of BRDFs.

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, single};
use crate::packs::{Numbers, unit_vector};
use brdfc_formats::lobes::{Anchor, Lobe, LobesHeader, LobesPack, MAX_LOBES, MAX_SHARPNESS};
use brdfc_formats::{Pack, PackKind};

/// The tested codec.
pub struct Lobes;

/// A single lobe, a pair and so on in turn, around all anchors.
fn header([nodes, azimuths]: [u32; 2], lobes: usize, numbers: &mut Numbers) -> LobesHeader {
    let mut header = LobesHeader { nodes, azimuths, rows: 0, scale: 1.5, delta_e: [0.6, 2.1], lobes: Vec::new() };
    while header.lobes.len() < lobes {
        let row = header.rows;
        let anchor = Anchor::ALL[row as usize % 3];
        let [along, across] = [0; 2].map(|_| numbers.between(-1.5, 1.5) as f32);
        let sides = if row.is_multiple_of(2) || header.lobes.len() + 1 == lobes { &[1.0f32][..] } else { &[1.0, -1.0] };
        header.lobes.extend(sides.iter().map(|side| Lobe { anchor, tilt: [along, side * across], row }));
        header.rows += 1;
    }
    header
}

/// A pack with random weights.
fn any_weights(sizes: [u32; 2], lobes: usize, numbers: &mut Numbers) -> LobesPack {
    let header = header(sizes, lobes, numbers);
    let sharpest = f64::from(MAX_SHARPNESS);
    let mut texel = |_: usize| {
        let [r, g, b] = [0; 3].map(|_| numbers.between(-8.0, 2.0).exp2() as f32);
        [r, g, b, numbers.between(0.0, sharpest) as f32]
    };
    let weights: Vec<[f32; 4]> = (0..header.rows as usize * header.views()).map(&mut texel).collect();
    LobesPack::new(header, &weights).expect("weights in range")
}

impl TestedCodec for Lobes {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        any_weights([2, 1], 3, &mut Numbers::new(20)).to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |sizes: [u32; 2], lobes: usize| {
            let mut numbers = Numbers::new(21);
            let pack = any_weights(sizes, lobes, &mut numbers);
            let query = |at: usize| {
                let [x, y, z] = unit_vector(&mut numbers);
                // Also along the normal, which has no azimuth.
                let outgoing = match at % 64 {
                    0 => [0.0, 0.0, 1.0],
                    // Along the axes, where azimuths wrap.
                    1 => [0.6, 0.0, 0.8],
                    2 => [0.0, -0.6, 0.8],
                    _ => [x, y, z.abs()],
                };
                let lobe = numbers.bits() as usize % lobes;
                [four(outgoing, lobe as f32), [(at % 2) as f32, 0.0, 0.0, 0.0], [0.0; 4]]
            };
            let queries: Vec<Query> = (0..SIDE * SIDE).map(query).collect();
            let answer = |[a, b, _]: &Query| {
                let look = pack.lookup([a[0], a[1], a[2]], a[3] as usize);
                (if b[0] == 1.0 { four(look.weight, 0.0) } else { four(look.direction, look.sharpness) }, 1.0)
            };
            let expected = queries.iter().map(answer).collect();
            let [nodes, azimuths] = sizes;
            let name = format!("{nodes} view angles, {azimuths} azimuths, {lobes} lobes");
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
            Case { name, decoder: PackKind::Lobes, bindings, frame: EXACT, files, queries, expected }
        };
        vec![case([24, 1], MAX_LOBES), case([2, 1], 1), case([2, 1], 7), case([8, 8], 12), case([2, 3], 5)]
    }

    fn committed(&self) -> Files {
        let bytes = any_weights([5, 1], 6, &mut Numbers::new(22)).to_bytes(false);
        let anisotropic = any_weights([4, 5], 5, &mut Numbers::new(23)).to_bytes(false);
        let mut made = vec![("any-weights".to_owned(), bytes.clone()), ("anisotropic".to_owned(), anisotropic)];
        made.extend(foreign_forms("any-weights", &bytes));
        made
    }

    /// Hashes all lobes and weights, and look-ups of each lobe.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Lobes(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let header = pack.header();
        numbers.words([header.nodes, header.azimuths, header.rows]);
        for lobe in &header.lobes {
            numbers.words([lobe.anchor as u32, lobe.row]);
            numbers.add(lobe.tilt);
        }
        numbers.add([header.scale]);
        numbers.add(header.delta_e);
        numbers.add(pack.weights().iter().flatten().copied());
        for outgoing in directions().map(single) {
            for lobe in 0..pack.fetches() {
                let look = pack.lookup(outgoing, lobe);
                numbers.add(look.direction.into_iter().chain([look.sharpness]).chain(look.weight));
            }
        }
        of_columns([("values", numbers)])
    }
}
