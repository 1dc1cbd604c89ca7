//! Factored flat BTFs: known answers of the decoder, its filter, the shader's block, and rejected parts.

use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::factored::shader::{FACTORED_WGSL, FactoredParameters};
use brdfc_formats::flat_btf::factored::{
    BASE_LAYERS, BaseTable, BaseTexel, BasisMap, ChromaRange, FactoredErrors, FactoredFlatBtf, FactoredHeader,
    ResidualMap, TablePlace, WeightMap, WeightRange, from_opponent, to_opponent,
};
use brdfc_formats::flat_btf::shader::FLAT_BTF_WGSL;
use brdfc_formats::flat_btf::{
    BlendedDirection, FlatBtfFile, MacroSurface, MarchSteps, Sheet, ViewWeights, unit_vectors,
};
use brdfc_testing::codecs::flat_btf::{
    BASE, Factors, MATERIALS, SMALL, Sizes, base_table, directions, example_layers, factored, factored_example,
    layers_of, only, towards, weights,
};
use brdfc_testing::golden::corpus::packs;
use brdfc_testing::packs::Numbers;
use naga::valid::{Capabilities, ValidationFlags, Validator};

const TWO: Factors = Factors { groups: 2, wide_groups: 1, residual: 2, ..BASE };

/// Filtered value at parameters of the flat BTF.
fn value(
    asset: &FactoredFlatBtf,
    uv: [f32; 2],
    detail: f32,
    view: BlendedDirection,
    light: BlendedDirection,
) -> [f32; 3] {
    asset.filtered(uv, detail).blended(view, light)
}

pub(crate) fn close(found: [f32; 3], expected: [f32; 3], tolerance: f32) {
    let good = (0..3).all(|k| (found[k] - expected[k]).abs() <= tolerance * (1.0 + expected[k].abs()));
    assert!(good, "{found:?} instead of {expected:?}");
}

/// An asset of one grey component with known values: lightness `100 w` in view 0, `50 w` in view 1.
fn grey(size: u32, levels: u32, weight: impl Fn(u32, u32) -> u8) -> FactoredFlatBtf {
    let header = FactoredHeader {
        size,
        levels,
        groups: 1,
        wide_groups: 1,
        residual: 0,
        views: directions(2, 1),
        lights: directions(3, 2),
        chroma: ChromaRange::ALL,
        materials: 0,
        axes: 0,
        table_levels: 1,
        albedos: [[0.0; 3]; 2],
        steps: [vec![0.01; 4], vec![0.0; 4], vec![0.0; 4]],
        errors: FactoredErrors::default(),
    };
    let basis = BasisMap::from_steps(header, &BaseTable::black(), |view, _, colour, component| {
        if colour == 0 && component == 0 { 10_000 / (1 + view as i32) } else { 0 }
    });
    let sides: Vec<u32> = (0..levels).map(|level| (size >> level).max(1)).collect();
    let texels = |side: u32| (0..side * side).map(move |at| (at % side, at / side));
    let weights = |side: u32| {
        let of_base = vec![0; 4 * (BASE_LAYERS * side * side) as usize];
        of_base.into_iter().chain(texels(side).flat_map(|(x, y)| [weight(x, y), 0, 0, 0])).collect::<Vec<u8>>()
    };
    let weights = sides.iter().flat_map(|side| weights(*side)).collect();
    let range = WeightRange { scale: 1.0, low: 0.0 };
    let weights = WeightMap::new(size, levels, vec![range; 12], weights).unwrap();
    FactoredFlatBtf::new(basis.unwrap(), weights, None).unwrap()
}

fn lightness(value: f32) -> [f32; 3] {
    from_opponent([value, 0.0, 0.0])
}

#[test]
fn texels_are_sums() {
    let asset = grey(4, 1, |x, _| [0, 51, 102, 255][x as usize]);
    for (x, weight) in [(0, 0.0), (1, 0.2), (2, 0.4), (3, 1.0)] {
        close(asset.texel([x, 2]).value(0, 0), lightness(100.0 * weight), 1e-6);
        close(asset.texel([x, 2]).value(1, 0), lightness(50.0 * weight), 1e-6);
        // At the centre of a texel the filter returns that texel.
        let uv = [(x as f32 + 0.5) / 4.0, 0.625];
        assert_eq!(value(&asset, uv, 0.0, towards(only(1)), towards(only(2))), asset.texel([x, 2]).value(1, 2));
    }
}

/// Weights are filtered and pairs are blended before the sum is converted to a colour.
#[test]
fn sums_are_blended_before_conversion_to_a_colour() {
    let asset = grey(4, 1, |x, _| [0, 51, 102, 255][x as usize]);
    // Between texels 1 and 2, and across the border between 3 and 0.
    for (u, weight) in [(0.5, 0.3), (0.4375, 0.25), (0.0, 0.5), (1.0, 0.5), (-3.0, 0.5), (0.9375, 0.75)] {
        close(value(&asset, [u, 0.4], 0.0, towards(only(0)), towards(only(0))), lightness(100.0 * weight), 1e-5);
    }
    let half = ViewWeights { indices: [0, 1, 0], weights: [0.5, 0.5, 0.0] };
    let lights = ViewWeights { indices: [0, 1, 2], weights: [0.5, 0.25, 0.25] };
    let blended = value(&asset, [0.875, 0.1], 0.0, towards(half), towards(only(0)));
    close(blended, lightness(75.0), 1e-5);
    close(value(&asset, [0.875, 0.1], 0.0, towards(half), towards(lights)), lightness(75.0), 1e-5);
    // The mean of the colours differs.
    let [full, dim] = [100.0, 50.0].map(|value| lightness(value)[0]);
    assert!((blended[0] - 0.5 * (full + dim)).abs() > 0.05);
}

/// The level of detail blends two mipmap levels, and is clamped to the coarsest.
#[test]
fn levels_of_detail() {
    let levels: [Vec<u8>; 3] = [[0, 51, 102, 255].to_vec(), vec![51, 204], vec![153]];
    let asset = grey(4, 3, |_, _| 0);
    let texels = levels.iter().flat_map(|row| {
        let (row, of_base) = (row.clone(), vec![0; 8 * row.len() * row.len()]);
        let texels = (0..row.len()).flat_map(move |_| row.clone().into_iter().flat_map(|byte| [byte, 0, 0, 0]));
        of_base.into_iter().chain(texels)
    });
    let ranges = asset.weights().ranges().to_vec();
    let weights = WeightMap::new(4, 3, ranges, texels.collect()).unwrap();
    let asset = FactoredFlatBtf::new(asset.basis().clone(), weights, None).unwrap();
    let at = |u: f32, detail: f32| value(&asset, [u, 0.3], detail, towards(only(0)), towards(only(0)));
    for (u, detail, weight) in [
        (0.375, 0.0, 0.2),
        (0.375, -1.0, 0.2),
        (0.25, 1.0, 0.2),
        (0.5, 1.0, 0.5),
        (0.25, 0.5, 0.5 * (0.1 + 0.2)),
        (0.75, 1.25, 0.75 * 0.8 + 0.25 * 0.6),
        (0.1, 2.0, 0.6),
        (0.1, 9.0, 0.6),
    ] {
        close(at(u, detail), lightness(100.0 * weight), 2e-5);
    }
}

/// The first share of a light's cell is a factor of the value where the light arrives, the second one of the diffuse
/// albedo elsewhere. Square roots of both are filtered, and blended over lights.
#[test]
fn the_residual_corrects_shadows() {
    let asset = factored(SMALL, TWO, 4);
    let map = asset.residual().unwrap();
    assert_eq!((map.size(), map.levels(), map.lights()), (2, 2, 5));
    assert_eq!([0.0, 0.25, 1.0, 9.0].map(ResidualMap::byte_of), [0, 90, 180, 255]);
    let root = |level: u32, light: u32, cell: usize| -> [f32; 2] {
        [0, 1].map(|channel: usize| f32::from(map.layer(level, light)[2 * cell + channel]) / 180.0)
    };
    let blend = |a: [f32; 2], b: [f32; 2], share: f32| [0, 1].map(|k: usize| a[k] + share * (b[k] - a[k]));
    let two = ViewWeights { indices: [1, 4, 0], weights: [0.75, 0.25, 0.0] };
    for (uv, detail, lights, roots) in [
        // Centres of cells, which are twice as large as texels; the border between two, and one beyond the tile.
        ([0.25, 0.25], 0.0, only(3), root(0, 3, 0)),
        ([0.75, -0.25], 1.0, only(3), root(0, 3, 3)),
        ([0.5, 0.25], 0.0, only(2), blend(root(0, 2, 0), root(0, 2, 1), 0.5)),
        ([1.0, 0.75], 0.0, only(2), blend(root(0, 2, 3), root(0, 2, 2), 0.5)),
        ([0.75, 0.25], 0.0, two, blend(root(0, 1, 1), root(0, 4, 1), 0.25)),
        // One cell remains at the coarsest level of the texels.
        ([0.25, 0.25], 1.5, only(0), blend(root(0, 0, 0), root(1, 0, 0), 0.5)),
        ([0.6, 0.1], 2.0, only(0), root(1, 0, 0)),
        ([0.6, 0.1], 9.0, only(0), root(1, 0, 0)),
    ] {
        let texel = asset.filtered(uv, detail);
        let [reached, shaded] = roots.map(|root| root * root);
        let (value, diffuse) = ([0.5, 2.0, 0.125], texel.base().diffuse);
        assert!(diffuse[0] > 0.0);
        for lit in [1.0, 0.0, 0.25] {
            let expected = [0, 1, 2].map(|c: usize| lit * reached * value[c] + (1.0 - lit) * shaded * diffuse[c]);
            close(texel.shadowed(value, lights, lit), expected, 1e-5);
        }
    }
    // A texel has the cell of its centre. Without a residual, light that does not arrive leaves nothing.
    let (texel, same) = (asset.texel([2, 1]), asset.filtered([0.625, 0.375], 0.0));
    assert_eq!(texel.shadowed([1.0; 3], two, 0.5), same.shadowed([1.0; 3], two, 0.5));
    let without = factored(SMALL, Factors { residual: 0, ..TWO }, 4);
    assert_eq!(without.filtered([0.3, 0.2], 0.0).shadowed([0.5, 2.0, 0.0], only(77), 0.25), [0.125, 0.5, 0.0]);
}

/// Compares with a sum in double precision: sides that are not powers of two, many components of both widths.
#[test]
fn sums_of_both_widths() {
    let sizes = Sizes { flat: 5, ..SMALL };
    for (groups, wide_groups) in [(1, 0), (3, 1), (16, 5)] {
        let asset = factored(sizes, Factors { groups, wide_groups, ..BASE }, 4);
        let header = asset.header();
        for (k, [x, y]) in [[0u32, 0], [4, 1], [2, 3]].into_iter().enumerate() {
            let (view, light) = (k as u32, (2 * k + 1) as u32 % 5);
            let mut sums = [0.0f64; 3];
            for colour in 0..3 {
                for (component, integer) in asset.basis().integers(view, light, colour).enumerate() {
                    let layer = asset.weights().layer(0, BASE_LAYERS + component as u32 / 4);
                    let byte = layer[(y * 5 + x) as usize * 4 + component % 4];
                    let WeightRange { scale, low } = asset.weights().ranges()[8 + component];
                    let weight = f64::from(low) + f64::from(scale) * f64::from(byte) / 255.0;
                    sums[colour] += weight * f64::from(header.steps[colour][component]) * f64::from(integer);
                }
            }
            let [seen_from, lit_from] =
                [unit_vectors(&header.views)[view as usize], unit_vectors(&header.lights)[light as usize]];
            let base = to_opponent(asset.basis().base().colour(asset.texel([x, y]).base(), seen_from, lit_from));
            let all = [0, 1, 2].map(|k: usize| base[k] + sums[k] as f32);
            let shown = from_opponent(header.chroma.bound(all));
            close(asset.texel([x, y]).value(view, light), shown, 1e-4);
        }
    }
}

/// Compares the committed files with a decoder written from the specification alone, in double precision and another
/// language.
#[test]
fn the_committed_asset_has_known_values() {
    let packs = packs("flat_btf");
    let file = FlatBtfFile::from_bytes(&packs["example.ktx2"]).unwrap();
    let asset = file.decoder.parts().reflectance.factors().unwrap();
    assert_eq!(asset.basis(), factored_example().basis(), "the rules that made it");
    for (texel, view, light, expected) in [
        ([1, 2], 1, 1, [0.901_752_7, 0.477_779_2, 0.634_908_5]),
        ([3, 3], 2, 2, [0.040_095_73, 0.040_061_5, 0.035_558_08]),
        ([2, 0], 1, 2, [1.307_942_6, 1.644_456_3, 0.752_292_6]),
    ] {
        close(asset.texel(texel).value(view, light), expected, 1e-6);
    }
    // Before shadows, and where a quarter of the light arrives.
    for (uv, detail, view, light, expected, shadowed) in [
        ([0.5, 0.25], 0.0, 1, 0, [2.264_989_2, 2.325_143_5, 1.352_888_2], [0.275_029_1, 0.290_765_5, 0.148_649_7]),
        ([0.9375, -0.4], 0.5, 2, 1, [2.997_795, 3.283_199_7, 3.120_952_4], [0.828_148_2, 0.959_019_1, 0.926_872_4]),
        ([0.1, 0.3], 7.0, 0, 2, [1.195_464_4, 0.777_438_9, 1.009_549], [1.233_680_5, 0.212_5, 0.702_430_6]),
    ] {
        close(asset.filtered(uv, detail).shadowed(expected, only(light), 0.25), shadowed, 1e-6);
        close(value(asset, uv, detail, towards(only(view)), towards(only(light))), expected, 1e-6);
        let other = value(asset, uv, detail, towards(only((view + 1) % 3)), towards(only(light)));
        assert!((other[0] - expected[0]).abs() > 1e-3, "another view differs");
    }
    // Ends of rays of sight by short steps and bisection, and the light that reaches them.
    let decoder = file.decoder.clone().with_steps(MarchSteps { sight: 64, refine: 30, both: 128 });
    let layers = layers_of(decoder.parts());
    assert_eq!(layers, &example_layers(), "the rules that made them");
    let (up, right, back) = ([0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [0.0, 0.8, 0.6]);
    let (oblique, steep) = ([-0.48, 0.64, 0.6], [0.0, 0.6, 0.8]);
    for (uv, view, level, at, height, sheet, parameters, lit) in [
        ([0.3, 0.1], up, 0.0, [0.3, 0.1], 0.890_980_4, Sheet::Top, [0.282_812_5, 0.124_218_8], 1.0),
        ([0.55, 0.6], right, 0.25, [0.422_715, 0.6], 0.160_573_5, Sheet::Base, [0.405_241_9, 0.633_593_7], 1.0),
        (
            [1.3, -0.45],
            oblique,
            1.5,
            [1.440_545, -0.637_393_3],
            0.148_637_5,
            Sheet::Base,
            [0.429_016_6, 0.385_656_9],
            0.0,
        ),
        ([0.7, 0.45], [0.0, -0.8, 0.6], -1.0, [0.7, 0.174_646_8], 0.913_03, Sheet::Top, [0.732_812_5, 0.197_281], 1.0),
        ([0.4, 0.5], steep, 0.0, [0.4, 0.374_852_9], 0.166_274_5, Sheet::Base, [0.379_687_5, 0.394_375], 0.0),
    ] {
        let (point, found) = decoder.seen(uv, view, level);
        let off = [point.at[0] - at[0], point.at[1] - at[1], point.height - height];
        let off = off.into_iter().chain((0..2).map(|k: usize| found[k] - parameters[k]));
        assert!(point.sheet == sheet && off.into_iter().all(|c| c.abs() < 1e-5), "{uv:?}: {point:?} {found:?}");
        let reached =
            |light| layers.lit(&point, up, light, MacroSurface::PLANE, level + decoder.finer(), decoder.steps());
        assert_eq!([reached(right), reached(back)], [lit, 1.0], "{uv:?}");
    }
}

#[test]
fn integers_round_trip() {
    let asset = factored(SMALL, TWO, 1);
    let most = |component: usize| if component < 4 { 32767 } else { 127 };
    let step = |view: usize, light: usize, colour: usize, component: usize| {
        let at = ((view * 5 + light) * 3 + colour) * 8 + component;
        [0, 1, -1, 1 << 20, -(1 << 20), 77, -100][at % 7]
    };
    let basis = BasisMap::from_steps(asset.header().clone(), asset.basis().base(), step).unwrap();
    for (view, light, colour) in [(0, 0, 0), (2, 4, 2), (1, 3, 1)] {
        let found: Vec<f32> = basis.integers(view, light, colour).collect();
        let expected = |k: usize| step(view as usize, light as usize, colour, k).clamp(-most(k), most(k)) as f32;
        assert_eq!(found, (0..8).map(expected).collect::<Vec<f32>>());
    }
}

#[test]
fn graphics_memory_is_the_sum_of_the_texels() {
    for residual in [0, 1, 5] {
        let asset = factored(Sizes { flat: 6, ..SMALL }, Factors { residual, ..TWO }, 3);
        let bytes = [asset.weights().texels().len(), asset.residual().map_or(0, |map| map.texels().len())];
        let basis = size_of_val(asset.basis().words()) + asset.basis().table_texels().len();
        assert_eq!(asset.gpu_bytes(), (bytes[0] + bytes[1] + basis) as u64);
    }
}

#[test]
fn parts_of_other_assets_are_rejected() {
    let asset = |sizes, factors| factored(sizes, factors, 3);
    let first = asset(SMALL, TWO);
    let refusal = |weights: &FactoredFlatBtf, residual: Option<&FactoredFlatBtf>| {
        let residual = residual.and_then(FactoredFlatBtf::residual).cloned();
        FactoredFlatBtf::new(first.basis().clone(), weights.weights().clone(), residual).map(drop)
    };
    assert_eq!(refusal(&first, Some(&first)), Ok(()));
    let field = |result: Result<(), FormatError>| result.unwrap_err().field.into_owned();
    let sized = asset(Sizes { flat: 5, ..SMALL }, TWO);
    let others = [asset(SMALL, Factors { levels: 2, ..TWO }), sized, asset(SMALL, Factors { groups: 3, ..TWO })];
    for other in &others {
        assert_eq!(field(refusal(other, Some(&first))), "size of the part weights");
    }
    for other in [asset(Sizes { lights: 4, ..SMALL }, TWO), asset(SMALL, Factors { residual: 1, ..TWO })] {
        assert_eq!(field(refusal(&first, Some(&other))), "size of the part residual");
    }
    assert_eq!(field(refusal(&first, None)), "part residual");
    let without = asset(SMALL, Factors { residual: 0, ..TWO });
    let superfluous = FactoredFlatBtf::new(without.basis().clone(), first.weights().clone(), first.residual().cloned());
    assert_eq!(field(superfluous.map(drop)), "part residual");
}

#[test]
fn the_shader_validates_after_that_of_flat_btfs() {
    let valid = |source: &str| {
        let module = naga::front::wgsl::parse_str(source).map_err(|error| error.emit_to_string(source))?;
        let checked = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
        checked.map(|_| module).map_err(|error| error.emit_to_string(source))
    };
    let source = format!("{FLAT_BTF_WGSL}\n{FACTORED_WGSL}");
    let module = valid(&source).unwrap_or_else(|error| panic!("{error}"));
    assert!(valid(&source.replace("var sum = 0.0;", "var sum = 0u;")).is_err(), "a mistake");
    assert!(!FACTORED_WGSL.contains("textureSample("));
    let find = |ty: &&naga::Type| ty.name.as_deref() == Some("FactoredParameters");
    let block = module.types.iter().map(|(_, ty)| ty).find(find).expect("the block has its name");
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, FactoredParameters::SIZE);
    let asset = factored(SMALL, TWO, 5);
    let bytes = FactoredParameters::to_bytes(&asset);
    assert_eq!(bytes.len(), FactoredParameters::SIZE);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    let number = |at: usize| f32::from_bits(word(at));
    for member in members {
        let at = member.offset as usize;
        match member.name.as_deref().unwrap() {
            "size" => assert_eq!(word(at), 4),
            "levels" => assert_eq!(word(at), 3),
            "groups" => assert_eq!(word(at), 2),
            "wide_groups" => assert_eq!(word(at), 1),
            "residual" | "residual_levels" => assert_eq!(word(at), 2),
            "residual_octaves" => assert_eq!(number(at), 1.0),
            "chroma" => assert_eq!(word(at), asset.header().chroma.word()),
            "lowest_light" => assert_eq!(number(at), asset.lowest_light()),
            "table_levels" => assert_eq!(word(at), 1),
            "materials" | "axes" => assert_eq!(word(at), 0),
            "albedos" => assert_eq!(number(at), 0.0),
            "steps" => {
                let found = [0, 1, 2].map(|colour| number(at + 256 * colour + 4 * 7));
                assert_eq!(found, [0, 1, 2].map(|colour| asset.header().steps[colour][7]));
            }
            "scales" => assert_eq!([12, 32, 60, 64].map(|k| number(at + k)), [1.0, 200.0, 60.0, 0.0]),
            "lows" => assert_eq!([16, 32, 60, 64].map(|k| number(at + k)), [-0.5, 1.0, -25.0, 0.0]),
            other => panic!("no such field: {other}"),
        }
    }
    // Without components there are no groups, views, lights and residual; the base keeps its ranges.
    let base = factored(SMALL, BASE, 5);
    let bytes = FactoredParameters::to_bytes(&base);
    assert_eq!(bytes.len(), FactoredParameters::SIZE);
    let word = |at: usize| u32::from_le_bytes(bytes[at..][..4].try_into().unwrap());
    let first: Vec<u32> = (0..12).map(|k| word(4 * k)).collect();
    assert_eq!(first, [4, 3, 0, 0, 0, base.header().chroma.word(), 0, 0, 0, 1, 0, 0]);
    let [steps, scales, lows] = [80, 80 + 768, 80 + 768 + 288];
    assert!((0..192).all(|k| word(steps + 4 * k) == 0), "no steps");
    for (k, range) in base.weights().ranges().iter().enumerate() {
        let found = [scales, lows].map(|array| f32::from_bits(word(array + 4 * k)));
        assert_eq!(found, [range.scale, range.low], "{k}");
    }
    assert!((8..72).all(|k| word(scales + 4 * k) == 0 && word(lows + 4 * k) == 0), "no weights");
    // Two materials, the second over mirror angles, with two levels of tables.
    let bytes = FactoredParameters::to_bytes(&factored(SMALL, MATERIALS, 5));
    assert_eq!(bytes[28..48], *[2u32, 2, 2, 0, 0].map(u32::to_le_bytes).as_flattened());
    let albedos = [0.75f32, 0.5, 0.25, 0.0, 0.125, 0.25, 0.0, 0.0];
    assert_eq!(bytes[48..80], *albedos.map(f32::to_le_bytes).as_flattened());
}

/// Directions with weight 0 are not decoded, so their indices can be anything.
#[test]
fn directions_of_weight_0_are_ignored() {
    let asset = factored(SMALL, TWO, 9);
    let mut numbers = Numbers::new(2);
    for _ in 0..50 {
        let [views, lights] = [3, 5].map(|count| towards(weights(&mut numbers, count)));
        let uv = [0; 2].map(|_| numbers.between(-2.0, 2.0) as f32);
        let detail = numbers.between(0.0, 2.0) as f32;
        let nowhere = |mut direction: BlendedDirection| {
            let samples = &mut direction.samples;
            (0..3).filter(|k| samples.weights[*k] == 0.0).for_each(|k| samples.indices[k] = 77);
            direction
        };
        let found = value(&asset, uv, detail, views, lights);
        assert_eq!(value(&asset, uv, detail, nowhere(views), nowhere(lights)), found);
    }
    let nowhere = |index: u32| ViewWeights { indices: [index, 77, 99], weights: [1.0, 0.0, 0.0] };
    let blended = |views: ViewWeights, lights: ViewWeights| {
        value(
            &asset,
            [0.2; 2],
            0.5,
            BlendedDirection { samples: views, ..towards(only(2)) },
            BlendedDirection { samples: lights, ..towards(only(2)) },
        )
    };
    assert_eq!(blended(nowhere(2), nowhere(2)), blended(only(2), only(2)));
}

/// A base alone: the colour of the exact direction, not of the samples that approximate it.
#[test]
fn the_base_uses_the_exact_direction() {
    let of = grey(2, 1, |_, _| 0);
    let basis = BasisMap::from_steps(of.header().clone(), &base_table(), |_, _, _, _| 0).unwrap();
    let range = |scale: f32, low: f32| WeightRange { scale, low };
    // Albedo 0.4, 0.2, 0.1, gloss 0.5, a normal inclined by 2 atan(0.25).
    let ranges = [range(1.0, 0.0), range(0.5, 0.0), range(0.25, 0.0), range(1.25, 0.0)].into_iter();
    let slopes = [range(0.0, 0.25), range(0.0, 0.0), range(0.0, 0.0), range(0.0, 0.0)];
    let ranges = ranges.chain(slopes).chain([range(0.0, 0.0); 4]).collect();
    let weights = WeightMap::new(2, 1, ranges, [[102; 16], [0; 16], [0; 16]].concat()).unwrap();
    let asset = FactoredFlatBtf::new(basis, weights, None).unwrap();
    let (normal, tables) = ([8.0 / 17.0, 0.0, 15.0 / 17.0], TablePlace::default());
    let texel = BaseTexel { diffuse: [0.4, 0.2, 0.1], gloss: 0.5, normal, tables };
    for (view, light) in
        [([0.0, 0.0, 1.0], [0.6, 0.0, 0.8]), ([0.0, 0.6, 0.8], [0.0, -0.6, 0.8]), ([0.28, 0.0, 0.96], [0.0, 0.8, 0.6])]
    {
        let ask = |light: [f32; 3], index: u32| {
            let [view, light] = [view, light].map(|direction| BlendedDirection { direction, samples: only(index) });
            value(&asset, [0.3, 0.7], 0.0, view, light)
        };
        let expected = base_table().colour(&texel, view, light);
        assert!(expected[0] > 0.1);
        close(ask(light, 0), expected, 1e-5);
        close(ask(light, 1), expected, 1e-5);
        // Lights lower than all sampled ones are raised to the lowest, with the same azimuth.
        let lowest = asset.lowest_light();
        let low = [0.0, 1.0f32, 0.0];
        let raised = [0.0, (1.0 - lowest * lowest).sqrt(), lowest];
        close(ask(low, 0), base_table().colour(&texel, view, raised), 1e-5);
    }
}
