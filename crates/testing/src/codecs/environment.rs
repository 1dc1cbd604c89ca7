//! Prefiltered environments.

use crate::codec::{Files, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, single};
use crate::packs::{Numbers, read_texture, sealed};
use brdfc_formats::direction::normalize;
use brdfc_formats::environment::cube::FacePoint;
use brdfc_formats::environment::{
    ENVIRONMENT_ENTRY, EnvironmentDecoder, EnvironmentHeader, EnvironmentPack, IRRADIANCE_SIDE,
};
use brdfc_formats::{Pack, PackKind};
use std::f64::consts::TAU;

/// The tested codec.
pub struct Environment;

/// Cosine of the angle around corners of the cube in which queries have no answers: half a texel of the coarsest level.
/// Drivers differ where three texels meet.
const CORNER: f64 = 0.94;

/// A pack of the radiance from each direction, times noise of this relative size in every texel.
pub fn noisy(side: u32, noise: f64, radiance: impl Fn([f64; 3]) -> [f64; 3]) -> EnvironmentPack {
    let mut numbers = Numbers::new(17);
    let levels = EnvironmentHeader { side, scale: 1.0 }.levels();
    let mut faces = |side: u32| -> Vec<[f32; 3]> {
        let side = side as usize;
        let mut texel = |at: usize| {
            let centre = [at % side, at / side % side].map(|place| place as f64 + 0.5);
            let direction = FacePoint::on_grid(at / (side * side), side, centre).direction();
            radiance(normalize(direction)).map(|c| (c * numbers.between(1.0 - noise, 1.0 + noise)) as f32)
        };
        (0..6 * side * side).map(&mut texel).collect()
    };
    let levels: Vec<_> = (0..levels).map(|level| faces(side >> level)).collect();
    EnvironmentPack::new(side, &levels, &faces(IRRADIANCE_SIDE)).expect("radiance in range")
}

impl TestedCodec for Environment {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        noisy(8, 0.0, |[x, y, z]| [1.0 + x, 2.0 + y, 0.5 + 0.5 * z]).to_bytes(supercompress)
    }

    /// Shaders leave the filter to the sampler, which may have weights of 8 bits. Neighbours differ by about 1 %, so that
    /// these weights are within the bound of exact answers.
    fn cases(&self) -> Vec<Case> {
        let case = |side: u32, brightness: f64| {
            let pack = noisy(side, 0.005, |direction| direction.map(|c| brightness * (1.0 + 0.04 * c)));
            let (header, decoder) = (pack.header(), EnvironmentDecoder::new(&pack));
            let last = f64::from(header.sharpest());
            let mut numbers = Numbers::new(18);
            let mut direction = || loop {
                let (y, turn) = (numbers.between(-1.0, 1.0), numbers.between(0.0, TAU));
                let sine = (1.0 - y * y).sqrt();
                let direction = [sine * turn.cos(), y, sine * turn.sin()];
                if direction.map(f64::abs).iter().sum::<f64>() < CORNER * 3f64.sqrt() {
                    let length = numbers.between(0.3, 3.0);
                    return (single(direction.map(|c| c * length)), numbers.between(-1.0, last + 1.0));
                }
            };
            let query = |at: usize| {
                let (direction, sharpness) = direction();
                // Also whole numbers, below and above the range.
                let sharpness = if at.is_multiple_of(3) { sharpness.floor() } else { sharpness };
                [four(direction, sharpness as f32), [0.0; 4], [0.0; 4]]
            };
            let queries: Vec<Query> = (0..SIDE * SIDE).map(query).collect();
            let answer = |[a, ..]: &Query| (four(decoder.radiance([a[0], a[1], a[2]], a[3]), 0.0), 1.0);
            let expected = queries.iter().map(answer).collect();
            let name = format!("side {side}, scale {}", header.scale);
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
            Case { name, decoder: PackKind::Environment, bindings, frame: EXACT, files, queries, expected }
        };
        vec![case(32, 1.8), case(8, 1.2e5)]
    }

    fn committed(&self) -> Files {
        let mut numbers = Numbers::new(19);
        let mut level = |side: usize| -> Vec<[f32; 3]> {
            let mut texel = || [0; 3].map(|_| numbers.between(-12.0, 12.0).exp2() as f32);
            (0..6 * side * side).map(|_| texel()).collect()
        };
        let levels = [16, 8].map(&mut level);
        let irradiance = level(IRRADIANCE_SIDE as usize);
        let bytes = EnvironmentPack::new(16, &levels, &irradiance).expect("radiance in range").to_bytes(false);
        // A writer uses powers of two.
        let mut texture = read_texture(&bytes).expect("our own pack");
        let scale = 0.3f32.to_le_bytes();
        texture.entries.get_mut(ENVIRONMENT_ENTRY).expect("the entry of a pack")[8..].copy_from_slice(&scale);
        let block = texture.entries.get_mut("brdfc.uniform.environment_parameters").expect("the block of a pack");
        block[4..8].copy_from_slice(&scale);
        let scaled = sealed(texture.to_bytes(false));
        let mut made = vec![("any-texels".to_owned(), bytes), ("scaled".to_owned(), scaled.clone())];
        made.extend(foreign_forms("scaled", &scaled));
        made
    }

    /// Hashes all texels, and look-ups at every level, between levels and across edges.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Environment(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let header = pack.header();
        numbers.words([header.side]);
        numbers.add([header.scale]);
        numbers.words(pack.texels());
        let decoder = EnvironmentDecoder::new(&pack);
        for direction in directions().map(single) {
            // All six faces.
            let [x, y, z] = direction;
            for direction in [[x, y, z], [z, x, y], [y, z, x], [x, -y, -z], [-z, x, y], [-y, -z, -x]] {
                for step in -1..=4 * header.sharpest() as i32 + 1 {
                    numbers.add(decoder.radiance(direction, 0.25 * step as f32));
                }
            }
        }
        of_columns([("values", numbers)])
    }
}
