//! Flat BTFs of trees.
//!
//! Cases and bounds are those of flat BTFs and of polynomial wavelet trees: positions are exact for layers of one height and for
//! indirection maps of one displacement, so that the bounds of trees hold at the parameters.

use super::flat_btf::{
    SMALL, Sizes, any_query, case, compact_indirections, file, flat_indirections, flat_relief, indirections, layers,
    level_of, query_value, relief_values, steady_queries,
};
use super::pwt::{any, bound, five_views, learned, plain, random};
use crate::codec::{Files, Measured, TestedCodec};
use crate::engines::{Case, EXACT, Query, SIDE};
use crate::golden::Hashes;
use crate::golden::foreign::foreign_forms;
use crate::golden::values::{Values, directions, of_columns, points, single};
use crate::packs::Numbers;
use crate::sampler::{ROUNDING, SAMPLED, SamplerCase};
use brdfc_formats::Pack;
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile, FlatBtfParts, LayerMap, Relief, Vdim};
use brdfc_formats::flat_btf_trees::FlatTrees;
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, PWT_ENTRY, PwtDecoder, PwtHeader};

/// Cosine of the lowest light of made-up trees, above which some queries are.
const LOWEST_LIGHT: f32 = 0.25;

/// Trees of five views and `4 x 4` texels: polynomials without shadows, or learned terms with them.
pub fn trees(is_learned: bool) -> FlatTrees {
    let coordinates = if is_learned { LightCoordinates::Learned } else { LightCoordinates::Paraboloid };
    let basis = LightBasis { coordinates, degree: if is_learned { 3 } else { 2 } };
    let tile = PwtHeader { repeats: true, views: Some(five_views()), ..plain([4, 4], [4, 4], 2, basis) };
    let header = match is_learned {
        true => learned(any(tile, Domain::Display, &[[0, 4, 1], [1, 2, 1]], 21), 22),
        false => any(tile, Domain::CubeRoot, &[[0, 4, 2], [1, 4, 1], [2, 1, 2]], 23),
    };
    FlatTrees::new(random(header, 24), is_learned, LOWEST_LIGHT).expect("a square tile")
}

/// A file of trees of learned terms over three sheets.
pub fn trees_file() -> FlatBtfFile {
    file(layers(SMALL, 3), trees(true))
}

/// Both forms of trees over each form of relief.
fn some_trees(layers: fn(Sizes) -> LayerMap, maps: [fn(Sizes, u32) -> Vdim; 2]) -> [(&'static str, FlatBtfDecoder); 4] {
    let map = |of: fn(Sizes, u32) -> Vdim| Relief::sampled(of(SMALL, 0), None).expect("a map without shadows");
    [
        ("trees", layers(SMALL).into(), trees(false)),
        ("trees with shadows", layers(Sizes { sheets: 1, ..SMALL }).into(), trees(true)),
        ("indirection map with trees", map(maps[0]), trees(false)),
        ("compact indirection map with trees", map(maps[1]), trees(true)),
    ]
    .map(|(name, relief, trees): (_, Relief, _)| (name, FlatBtfDecoder::new(FlatBtfParts::new(relief, trees))))
}

/// Error bound for a value over a relief of one height.
fn tree_bound(decoder: &FlatBtfDecoder, [a, view, light]: &Query) -> [f64; 4] {
    let trees = decoder.parts().reflectance.trees().expect("trees");
    let (_, [u, v]) = decoder.seen([a[0], a[1]], [view[0], view[1], view[2]], a[2]);
    let z = light[2].max(LOWEST_LIGHT);
    let flat = ((1.0 - z * z) / (light[0] * light[0] + light[1] * light[1]).max(1e-12)).sqrt();
    let raised = [light[0] * flat, light[1] * flat, z, 0.0];
    let query = [[u, v, a[2], 0.0], if light[2] < LOWEST_LIGHT { raised } else { *light }, *view];
    // Positions are rounded.
    bound(&PwtDecoder::new(trees.pack().clone()), &query).map(|bound| bound * 1.1 + ROUNDING)
}

/// The case of trees over a relief of one height.
fn sampler_case(name: &str, decoder: &FlatBtfDecoder) -> SamplerCase {
    let mut numbers = Numbers::new(14);
    let queries = (0..SIDE * SIDE).map(|at| any_query(&mut numbers, at));
    let answers = queries.map(|query| (query, query_value(decoder, None, &query))).collect();
    let case = case(name, decoder, SAMPLED, Vec::new(), answers);
    let allowed = case.queries.iter().map(|query| tree_bound(decoder, query)).collect();
    SamplerCase { case, allowed, is_filtered: true }
}

/// The tested codec.
pub struct FlatBtfTrees;

impl TestedCodec for FlatBtfTrees {
    fn small_pack(&self, supercompress: bool) -> Vec<u8> {
        let layers = layers(Sizes { plane: 4, sheets: 1, ..SMALL }, 7);
        file(layers, trees(false)).to_bytes(supercompress)
    }

    fn cases(&self) -> Vec<Case> {
        let case = |(name, decoder): (&str, FlatBtfDecoder)| {
            let file = FlatBtfFile::new(decoder.clone()).expect("parts that match").to_bytes(true);
            case(name, &decoder, EXACT, vec![file], steady_queries(&decoder))
        };
        let maps: [fn(Sizes, u32) -> Vdim; 2] =
            [|sizes, lights| indirections(sizes, lights, 8), |sizes, lights| compact_indirections(sizes, lights, 8)];
        some_trees(|sizes| layers(sizes, 4), maps).into_iter().map(case).collect()
    }

    fn sampler_cases(&self) -> Vec<SamplerCase> {
        let some = some_trees(flat_relief, [flat_indirections, super::flat_btf::flat_compact_indirections]);
        some.iter().map(|(name, decoder)| sampler_case(name, decoder)).collect()
    }

    fn committed(&self) -> Files {
        let mut packs: Files = Vec::new();
        for (name, file) in [("polynomials", file(layers(SMALL, 13), trees(false))), ("learned", trees_file())] {
            let bytes = file.to_bytes(false);
            packs.extend(foreign_forms(name, &bytes));
            packs.push((name.to_owned(), bytes));
        }
        packs
    }

    /// Hashes the relief, all texels, and values behind rays of sight at and between all levels.
    fn hashes(&self, pack: Pack) -> Hashes {
        let Pack::FlatBtfTrees(file) = pack else { unreachable!("{}", pack.kind().name()) };
        let mut numbers = Values::default();
        let FlatBtfParts { relief, reflectance } = file.decoder.parts();
        relief_values(relief, &mut numbers);
        let trees = reflectance.trees().expect("a file of this kind");
        numbers.words([trees.size(), trees.levels(), u32::from(trees.has_shadows())]);
        numbers.add([trees.lowest_light()]);
        for texture in 0..trees.pack().header().textures.len() {
            numbers.words(trees.pack().texels(texture).iter().map(|texel| u32::from(*texel)));
        }
        for light in directions().map(single) {
            let view = [-light[0], -light[1], light[2].abs()];
            for (k, uv) in (0..).zip(points()).step_by(3) {
                numbers.add(file.decoder.shaded(None, uv, level_of(k), view, light));
            }
        }
        of_columns([("values", numbers)])
    }

    fn measured(&self) -> &'static [Measured] {
        &[(PWT_ENTRY, Some(84..100))]
    }
}
