//! Polynomial wavelet trees.
//!
//! Bounds with the sampler filtering: every filtered number may be off by three steps of its range, for two axes and
//! the mipmap levels. The bound is the resulting change of the colour when the channels are off by their sums.

use crate::codec::{Files, Measured, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE, four};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, points, single as as_f32};
use crate::packs::{Numbers, unit_vector};
use crate::sampler::{ROUNDING, SAMPLED, STEP, SamplerCase};
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::pwt::{
    Component, Domain, LightBasis, LightCoordinates, LightMap, PWT_ENTRY, PwtDecoder, PwtErrors, PwtHeader, PwtPack,
    TextureHeader,
};
use brdfc_formats::{Pack, PackKind};

/// A header that repeats if `extent` is its size and `repeats` is set: grey of channel 0, weights equal to the terms,
/// no textures yet.
pub fn plain(size: [u32; 2], extent: [u32; 2], levels: u32, basis: LightBasis) -> PwtHeader {
    let polynomial = if basis.coordinates == LightCoordinates::Learned { 0 } else { basis.terms() };
    let triangle = (0..polynomial).flat_map(|k| (0..=k).map(move |j| if j == k { 1.0 } else { 0.0 })).collect();
    PwtHeader {
        size,
        extent,
        repeats: false,
        levels,
        basis,
        views: None,
        domain: Domain::Linear,
        colour: [[1.0; 3], [0.0; 3], [0.0; 3]],
        triangle,
        light_map: None,
        textures: Vec::new(),
        errors: PwtErrors { lights: 0, psnr: 0.0, held_out_psnr: 0.0, delta_e: 0.0 },
    }
}

/// A texture of one number for channel 0.
pub fn single(level: u32, term: u32, scale: f32, low: f32) -> TextureHeader {
    TextureHeader { level, channels: 1, components: vec![Component { channel: 0, term, scale, low }] }
}

/// Bytes of each texture.
pub fn lengths(header: &PwtHeader) -> Vec<usize> {
    let of = |texture: &TextureHeader| {
        let texels = (texture.level..=header.levels)
            .map(|level| header.extent.iter().map(|side| (side >> level) as usize).product::<usize>());
        texels.sum::<usize>() * texture.components.len() * header.view_count() as usize
    };
    header.textures.iter().map(of).collect()
}

/// A pack of random texels.
pub fn random(header: PwtHeader, seed: u64) -> PwtPack {
    let mut numbers = Numbers::new(seed);
    let texels = lengths(&header).into_iter().map(|count| (0..count).map(|_| numbers.bits() as u8).collect()).collect();
    PwtPack::new(header, texels).expect("a header in range")
}

/// A header with made-up numbers: textures by level, channels and layers.
pub(super) fn any(header: PwtHeader, domain: Domain, textures: &[[u32; 3]], seed: u64) -> PwtHeader {
    let mut numbers = Numbers::new(seed);
    let terms = header.basis.terms() as u32;
    let mut between = |low, high| numbers.between(low, high) as f32;
    let triangle = header.triangle.iter().map(|diagonal| diagonal + between(-0.2, 0.2)).collect();
    let colour = [[0.0; 3]; 3].map(|axis| axis.map(|_: f32| between(-0.8, 0.8)));
    let errors = PwtErrors {
        lights: 40,
        psnr: between(20.0, 50.0),
        held_out_psnr: between(20.0, 50.0),
        delta_e: between(0.0, 5.0),
    };
    let mut count = 0;
    let textures = textures.iter().map(|[level, channels, layers]| {
        let component = |_| {
            count += 1;
            // Alternates between terms and channels.
            Component { channel: count % 3, term: count / 3 % terms, scale: between(0.1, 2.0), low: between(-1.0, 0.5) }
        };
        let components = (0..channels * layers).map(component).collect();
        TextureHeader { level: *level, channels: *channels, components }
    });
    let textures = textures.collect();
    PwtHeader { domain, triangle, colour, errors, textures, ..header }
}

/// Mesh of five views: the normal, and a ring.
pub fn five_views() -> DirectionMesh {
    let set = DirectionSet::grid(2, 4, 60.0).expect("angles in range");
    DirectionMesh::new(&set).expect("separate directions")
}

/// Packs of all domains and coordinates, by name: tiles and others, with one texture and more, of one view and of five.
pub fn packs() -> Vec<(&'static str, PwtPack)> {
    let basis = |coordinates, degree| LightBasis { coordinates, degree };
    let tile = PwtHeader { repeats: true, ..plain([8, 4], [8, 4], 2, basis(LightCoordinates::Projected, 2)) };
    let odd = plain([5, 3], [8, 4], 2, basis(LightCoordinates::Hemisphere, 5));
    let coarse = plain([6, 7], [8, 8], 3, basis(LightCoordinates::Paraboloid, 1));
    let one = plain([1, 1], [1, 1], 0, basis(LightCoordinates::Paraboloid, 0));
    let of_map = plain([7, 4], [8, 4], 1, basis(LightCoordinates::Learned, 5));
    let views = plain([4, 8], [4, 8], 2, basis(LightCoordinates::Learned, 3));
    let views = PwtHeader { repeats: true, views: Some(five_views()), ..views };
    [
        ("tile-projected-linear", any(tile, Domain::Linear, &[[0, 4, 1], [1, 2, 3], [2, 1, 5]], 1)),
        ("odd-hemisphere-display", any(odd, Domain::Display, &[[0, 1, 2], [2, 4, 27]], 2)),
        ("coarse-paraboloid-log", any(coarse, Domain::Logarithm { epsilon: 0.02 }, &[[1, 2, 4]], 3)),
        ("one-texel-cube-root", any(one, Domain::CubeRoot, &[[0, 4, 1]], 4)),
        ("image-learned-display", learned(any(of_map, Domain::Display, &[[0, 4, 1], [1, 4, 1]], 5), 9)),
        // Two textures of one level.
        ("views-learned-display", learned(any(views, Domain::Display, &[[0, 4, 1], [0, 4, 2], [1, 2, 1]], 6), 11)),
    ]
    .into_iter()
    .zip(5..)
    .map(|((name, header), seed)| (name, random(header, seed)))
    .collect()
}

/// Largest difference of the texels of [`learned`].
const MAP_RANGE: f32 = 0.6;

/// A header of learned terms: a map of random numbers, and the texels' components for all channels.
pub(super) fn learned(header: PwtHeader, seed: u64) -> PwtHeader {
    const SIDE: u32 = 4;
    let mut numbers = Numbers::new(seed);
    let mut number = || numbers.between(-0.5, 0.5) as f32 * MAP_RANGE;
    let texels: Vec<[f32; 3]> =
        (0..header.basis.terms() * (SIDE * SIDE) as usize).map(|_| [number(), number(), number()]).collect();
    let mut textures = header.textures;
    textures.iter_mut().flat_map(|texture| &mut texture.components).for_each(|component| component.channel = 0);
    let light_map = Some(LightMap::new(SIDE, &texels).expect("numbers in range"));
    PwtHeader { light_map, textures, colour: [[1.0; 3], [0.0; 3], [0.0; 3]], ..header }
}

/// The example of the layout's page: two terms of a tile of 2 x 2 texels, one of them coarse.
pub fn example() -> PwtPack {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 1 };
    let textures = vec![single(0, 0, 1.0, 0.0), single(1, 1, 0.5, -0.25)];
    let errors = PwtErrors { lights: 3, psnr: 40.0, held_out_psnr: 35.0, delta_e: 0.5 };
    let header = PwtHeader { repeats: true, textures, errors, ..plain([2, 2], [2, 2], 1, basis) };
    PwtPack::new(header, vec![vec![0, 255, 51, 102, 102], vec![204]]).expect("a header in range")
}

/// Places on images, levels and lights.
fn queries() -> Vec<Query> {
    let mut numbers = Numbers::new(13);
    let query = |k: usize| {
        let [u, v] = [0; 2].map(|_| numbers.between(-0.2, 1.2) as f32);
        let [[x, y, z], [a, b, c]] = [0; 2].map(|_| unit_vector(&mut numbers));
        [[u, v, (k % 9) as f32 / 4.0, 0.0], [x, y, z.abs(), 0.0], [a, b, c.abs(), 0.0]]
    };
    (0..SIDE * SIDE).map(query).collect()
}

/// Error bound for a colour of a tree at a place, view and light: that of three views, by their weights.
pub(super) fn bound(decoder: &PwtDecoder, query: &Query) -> [f64; 4] {
    let [_, _, c] = query;
    let (views, shares) = decoder.pack().header().seen([c[0], c[1], c[2]]);
    let mut bounds = [0.0; 4];
    for (view, share) in views.into_iter().zip(shares) {
        let of_view = bound_of_view(decoder, query, view);
        bounds.iter_mut().zip(of_view).for_each(|(sum, bound)| *sum += f64::from(share) * bound);
    }
    bounds
}

fn bound_of_view(decoder: &PwtDecoder, [a, b, _]: &Query, view: u32) -> [f64; 4] {
    let header = decoder.pack().header();
    let weights = header.weights([b[0], b[1], b[2]]);
    let sum = decoder.sum([a[0], a[1]], a[2], view, &weights);
    let mut off = [0.0f32; 3];
    // Weights of learned terms are filtered, too: by two axes, between texels of a small map.
    let of_map = if header.light_map.is_some() { 2.0 * STEP * MAP_RANGE } else { 0.0 };
    off.iter_mut().for_each(|off| *off += of_map);
    for (component, weight) in header.components().zip(header.component_weights(&weights)) {
        let largest = component.low.abs().max((component.low + component.scale).abs());
        for (off, weight) in off.iter_mut().zip(weight) {
            *off += 3.0 * STEP * weight.abs() * component.scale.abs() + of_map * largest;
        }
    }
    let colour = |k: usize| {
        let [low, here, high] =
            [sum[k] - off[k], sum[k], sum[k] + off[k]].map(|value| f64::from(header.domain.decode(value)));
        (high - here).max(here - low) + ROUNDING * (here + 1e-2)
    };
    [colour(0), colour(1), colour(2), 1e-6]
}

fn value(decoder: &PwtDecoder, [a, b, c]: &Query) -> [f32; 3] {
    decoder.value([a[0], a[1]], a[2], [c[0], c[1], c[2]], [b[0], b[1], b[2]])
}

/// The case of a polynomial wavelet tree.
fn sampler_case(name: &str, pack: PwtPack) -> SamplerCase {
    let (bindings, queries) = (pack.bindings().into_owned(), queries());
    let is_filtered = pack.header().extent != [1; 2];
    let decoder = PwtDecoder::new(pack);
    let answer = |query: &Query| (four(value(&decoder, query), 0.0), 1e-2);
    let expected = queries.iter().map(answer).collect();
    let allowed = queries.iter().map(|query| bound(&decoder, query)).collect();
    let (name, files) = (name.to_owned(), Vec::new());
    let case = Case { name, decoder: PackKind::Pwt, bindings, frame: SAMPLED, files, queries, expected };
    SamplerCase { case, allowed, is_filtered }
}

/// The tested codec.
pub struct Pwt;

impl TestedCodec for Pwt {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        example().to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let queries = queries();
        let case = |(name, pack): (&str, PwtPack)| {
            let (bindings, files) = (pack.bindings().into_owned(), vec![pack.to_bytes(true)]);
            let decoder = PwtDecoder::new(pack);
            let answer = |query: &Query| (four(value(&decoder, query), 0.0), 1e-2);
            let expected = queries.iter().map(answer).collect();
            let (name, decoder, queries) = (name.to_owned(), PackKind::Pwt, queries.clone());
            Case { name, decoder, bindings, frame: EXACT, files, queries, expected }
        };
        packs().into_iter().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        packs().into_iter().map(|(name, pack)| sampler_case(name, pack)).collect()
    }

    fn committed(&self) -> Files {
        let packs = packs();
        let mut made = vec![("page-example".to_owned(), example().to_bytes(false))];
        made.extend(packs.iter().map(|(name, pack)| (format!("any-texels-{name}"), pack.to_bytes(false))));
        let (name, pack) = &packs[0];
        made.push((format!("any-texels-{name}-zstandard"), pack.to_bytes(true)));
        made.extend(foreign_forms(&format!("any-texels-{name}"), &pack.to_bytes(false)));
        made
    }

    /// Hashes its header, all texels, weights of all terms, and look-ups at and between all levels.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::Pwt(pack) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let header = pack.header().clone();
        let PwtErrors { lights, psnr, held_out_psnr, delta_e } = header.errors;
        numbers.words(header.size.into_iter().chain(header.extent));
        numbers.words([u32::from(header.repeats), header.levels, header.basis.degree, lights]);
        numbers.words(header.views.iter().flat_map(|mesh| mesh.words().iter().copied()));
        numbers.add([psnr, held_out_psnr, delta_e]);
        for texture in 0..header.textures.len() {
            numbers.words(pack.texels(texture).iter().map(|texel| u32::from(*texel)));
        }
        let decoder = PwtDecoder::new(pack);
        for light in directions().map(as_f32) {
            let weights = header.weights(light);
            // Below the horizon they are finite, too, except at the pole.
            numbers.add(weights.into_iter().flatten());
            for (k, uv) in points().enumerate().step_by(3) {
                let level = 0.3 * (k % 12) as f32;
                numbers.add(decoder.sum(uv, level, k as u32 % header.view_count(), &weights));
                // Seen from the other side.
                numbers.add(decoder.value(uv, level, [-light[0], -light[1], light[2].abs()], light));
            }
        }
        of_columns([("values", numbers)])
    }

    fn measured(&self) -> &'static [Measured] {
        &[(PWT_ENTRY, Some(84..100))]
    }
}
