//! Importance samples.

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, single};
use crate::packs::{Numbers, unit_vector};
use brdfc_formats::importance::{ImportanceHeader, ImportancePack};
use brdfc_formats::{Pack, PackKind};

/// The tested codec.
pub struct Importance;

impl TestedCodec for Importance {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let header = ImportanceHeader { polar: 1, azimuths: 1, samples: 2 };
        ImportancePack::new(header, vec![[0.0, 0.0, 1.0, 1.0]; 2]).unwrap().to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |header: ImportanceHeader| {
            let mut numbers = Numbers::new(16);
            let texels = (0..header.rows() * header.samples).map(|_| {
                let [x, y, z] = unit_vector(&mut numbers);
                [x, y, z.abs(), numbers.between(-6.0, 6.0).exp2() as f32]
            });
            let pack = ImportancePack::new(header, texels.collect()).unwrap();
            let queries: Vec<Query> = (0..SIDE * SIDE)
                .map(|_| {
                    let [x, y, z] = unit_vector(&mut numbers);
                    [[x, y, z.abs(), (numbers.bits() % 5000) as f32], [0.0; 4], [0.0; 4]]
                })
                .collect();
            let answer = |[a, ..]: &Query| {
                let (incoming, inverse_density) = pack.sample([a[0], a[1], a[2]], a[3] as u32);
                (four(incoming, inverse_density), 1.0)
            };
            let expected = queries.iter().map(answer).collect();
            let name = format!("{} polar angles, {} azimuths", header.polar, header.azimuths);
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
            Case { name, decoder: PackKind::Importance, bindings, frame: EXACT, files, queries, expected }
        };
        vec![
            case(ImportanceHeader { polar: 64, azimuths: 1, samples: 50 }),
            case(ImportanceHeader { polar: 7, azimuths: 12, samples: 64 }),
        ]
    }

    fn committed(&self) -> Files {
        let header = ImportanceHeader { polar: 2, azimuths: 4, samples: 3 };
        let mut numbers = Numbers::new(6);
        let mut texel = |_| {
            let [p, q] = [0; 2].map(|_| numbers.between(-0.7, 0.7));
            let square = p * p + q * q;
            // The length is not exactly 1.
            let length = numbers.between(0.999_997, 1.000_003) / (1.0 + square);
            let half = [2.0 * p, 2.0 * q, 1.0 - square].map(|c| (c * length) as f32);
            [half[0], half[1], half[2], numbers.between(0.01, 90.0) as f32]
        };
        let texels = (0..header.rows() * header.samples).map(&mut texel).collect();
        let bytes = ImportancePack::new(header, texels).expect("half vectors with densities").to_bytes(false);
        let mut made = vec![("any-samples".to_owned(), bytes.clone())];
        made.extend(foreign_forms("any-samples", &bytes));
        made
    }

    /// Hashes all half vectors with their densities, and samples of fixed directions.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Importance(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let header = pack.header();
        numbers.words([header.polar, header.azimuths, header.samples]);
        numbers.add(pack.texels().iter().flatten().copied());
        for outgoing in directions().map(single) {
            for index in 0..2 * header.samples.min(16) {
                let (incoming, inverse) = pack.sample(outgoing, index);
                numbers.add(incoming);
                numbers.add([inverse]);
            }
        }
        of_columns([("values", numbers)])
    }
}
