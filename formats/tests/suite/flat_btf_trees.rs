//! Flat BTFs of trees: values of the decoder, and files that break a rule.

use brdfc_formats::container::{Extent, TexelFormat};
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfFile, FlatBtfParts, MacroSurface, Relief};
use brdfc_formats::flat_btf_trees::FlatTrees;
use brdfc_formats::flat_btf_trees::shader::{FlatTreesParameters, flat_trees_wgsl};
use brdfc_formats::pwt::{LightBasis, LightCoordinates, PwtDecoder, PwtHeader};
use brdfc_formats::{Pack, PackKind};
use brdfc_testing::codecs::flat_btf::{
    SMALL, factored_file, file, indirections, layers, refusal, reshape, sampled_relief, set_texel, set_word, survives,
};
use brdfc_testing::codecs::flat_btf_trees::{trees, trees_file};
use brdfc_testing::codecs::pwt::{plain, random, single};

const KEY: &str = "brdfc.flat-btf.trees";
const VIEW: [f32; 3] = [0.48, -0.36, 0.8];

fn decoder(trees: FlatTrees) -> FlatBtfDecoder {
    FlatBtfDecoder::new(FlatBtfParts::new(layers(SMALL, 3), trees))
}

#[test]
fn files_come_back() {
    for is_learned in [false, true] {
        let made = file(layers(SMALL, 3), trees(is_learned));
        for supercompress in [false, true] {
            let bytes = made.to_bytes(supercompress);
            let Pack::FlatBtfTrees(read) = Pack::from_bytes(&bytes).unwrap() else { panic!("another kind") };
            assert!(*read == made && read.to_bytes(supercompress) == bytes && survives(&bytes));
            assert_eq!(read.bindings().decoder, PackKind::FlatBtfTrees.name());
            assert!(read.bindings().textures().count() <= 14 && read.directions.is_none());
        }
    }
}

/// The value is that of the trees at the parameters of the visible point, times what reaches it.
#[test]
fn values_are_those_of_trees_at_the_visible_point() {
    let (mut reached, mut hidden) = (0, 0);
    for is_learned in [false, true] {
        let (trees, decoder) = (trees(is_learned), decoder(trees(is_learned)));
        let pack = PwtDecoder::new(trees.pack().clone());
        for k in 0..200u16 {
            let (x, y) = (f32::from(k % 20) / 20.0, f32::from(k / 20) / 10.0);
            let light = [0.6 * (2.0 * x - 1.0), 0.6 * y, (1.0 - 0.36 * ((2.0 * x - 1.0).powi(2) + y * y)).sqrt()];
            let look = decoder.look([x, y], 0.5, VIEW, MacroSurface::PLANE);
            let lit = if is_learned { 1.0 } else { look.reached(None, light) };
            if lit > 0.0 {
                reached += 1
            } else {
                hidden += 1
            }
            let expected = pack.value(look.parameters(), 0.5, VIEW, light).map(|value| value * lit);
            assert_eq!(look.shaded(None, light), expected, "{k}");
            assert_eq!((look.normal(), look.texel().is_none()), ([0.0, 0.0, 1.0], true));
        }
    }
    assert!(reached > 250 && hidden > 10, "{reached} {hidden}");
}

/// Below the lowest light the value is that of the lowest light, times the ratio of cosines.
#[test]
fn low_lights_are_dimmed() {
    let decoder = decoder(trees(true));
    let value = |z: f32| {
        let across = (1.0 - z * z).sqrt();
        decoder.shaded(None, [0.3, 0.7], 0.0, VIEW, [0.6 * across, 0.8 * across, z])
    };
    let lowest = value(0.25);
    assert!(lowest[0] > 0.1, "{lowest:?}");
    for (found, expected) in value(0.125).into_iter().zip(lowest) {
        assert!((found - 0.5 * expected).abs() <= 1e-5 * expected, "{found} {expected}");
    }
    assert_eq!((value(0.0), value(-0.5)), ([0.0; 3], [0.0; 3]));
}

/// Known answer: one texel with the term 1, a constant 0.25, without a relief.
#[test]
fn a_constant_is_a_constant() {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 0 };
    let header =
        PwtHeader { repeats: true, textures: vec![single(0, 0, 0.0, 0.25)], ..plain([1, 1], [1, 1], 0, basis) };
    let trees = FlatTrees::new(random(header, 1), true, 0.5).unwrap();
    let decoder = decoder(trees);
    assert_eq!(decoder.shaded(None, [0.1, 0.9], 0.0, VIEW, [0.0, 0.6, 0.8]), [0.25; 3]);
    assert_eq!(decoder.shaded(None, [0.1, 0.9], 3.0, VIEW, [0.0, 0.96, 0.25])[0], 0.125);
}

#[test]
fn trees_are_square_tiles_with_a_lowest_light() {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 0 };
    let pack = |repeats, size| {
        random(PwtHeader { repeats, textures: vec![single(0, 0, 1.0, 0.0)], ..plain(size, size, 0, basis) }, 1)
    };
    let error = |repeats, size, lowest| FlatTrees::new(pack(repeats, size), false, lowest).unwrap_err().to_string();
    assert_eq!(error(true, [4, 8], 0.5), "trees of a flat BTF: found a tile of 4 x 8, expected a square tile");
    assert_eq!(error(false, [4, 4], 0.5), "trees of a flat BTF: found an image of 4 x 4, expected a square tile");
    for (lowest, text) in [(0.0, "0"), (f32::NAN, "NaN"), (1.5, "1.5"), (-1.0, "-1")] {
        let expected = format!("{KEY} cosine of the lowest light: found {text}, expected above 0, at most 1");
        assert_eq!(error(true, [4, 4], lowest), expected);
    }
}

#[test]
fn broken_headers_and_images_are_rejected() {
    let file = trees_file();
    let with = |offset, word| refusal(&file, |file| set_word(file, KEY, offset, word)).to_string();
    assert_eq!(with(0, 2), format!("{KEY} version: found 2, expected 1 to 1"));
    assert_eq!(with(4, 2), format!("{KEY} shadows: found 2, expected 0 to 1"));
    assert!(with(8, f32::NAN.to_bits()).starts_with(&format!("{KEY} cosine of the lowest light: found NaN")));
    // The uniform block has other shadows than the header.
    assert!(with(4, 0).starts_with("brdfc.uniform.flat_trees_parameters byte 0: found"));
    let cut = refusal(&file, |file| file.entries.get_mut(KEY).unwrap().truncate(8));
    assert_eq!(cut.to_string(), format!("{KEY}: found 8 bytes, expected 12 bytes"));
    let of_pwt = |offset, word| refusal(&file, |file| set_word(file, "brdfc.pwt", offset, word)).to_string();
    assert_eq!(of_pwt(104, 6), "direction_mesh_words, directions: found 5, expected 6, as brdfc.pwt says");
    assert!(of_pwt(40, 3).starts_with("brdfc.pwt texture level: end of data"), "{}", of_pwt(40, 3));
    assert_eq!(of_pwt(88, f32::NAN.to_bits()), "brdfc.pwt psnr: found NaN, expected finite numbers");
    let shape =
        refusal(&file, |file| reshape(file, "pwt_texture_1", TexelFormat::R8Unorm, Extent::D2Array([2, 2, 4]), 2));
    assert!(shape.to_string().starts_with("pwt_texture_1: found"), "{shape}");
    let map = refusal(&file, |file| set_texel(file, "pwt_light_map", 0, &[0, 0x7e, 0, 0, 0, 0, 0, 0]));
    assert!(map.to_string().contains("light map"), "{map}");
    // Without its header, the file has to have the parts of factors.
    let missing = refusal(&file, |file| drop(file.entries.remove(KEY)));
    assert!(missing.to_string().contains("brdfc.flat-btf"), "{missing}");
    let both = refusal(&file, |file| drop(file.entries.insert("brdfc.flat-btf.factored".to_owned(), Vec::new())));
    let expected = format!("reflectance: found both brdfc.flat-btf.factored and {KEY}, expected either ");
    assert!(both.to_string().starts_with(&expected), "{both}");
    // The header alone does not make trees of factors.
    let header = 1u32.to_le_bytes().repeat(3);
    let other = refusal(&factored_file(), |file| {
        file.entries.remove("brdfc.flat-btf.factored");
        file.entries.insert(KEY.to_owned(), [&header[..8], &0.5f32.to_le_bytes()].concat());
    });
    assert!(other.to_string().starts_with("brdfc.pwt: not among the keys"), "{other}");
}

/// Trees have shadows of their own.
#[test]
fn sampled_shadows_are_rejected() {
    let relief: Relief = sampled_relief(SMALL, true, |lights| indirections(SMALL, lights, 8));
    let error = FlatBtfFile::new(FlatBtfDecoder::new(FlatBtfParts::new(relief, trees(true)))).unwrap_err();
    assert_eq!(error.to_string(), "part shadows: found 5 lights, expected none, because trees include shadows");
}

#[test]
fn the_shader_validates_and_its_block_is_the_one_that_rust_writes() {
    let source = flat_trees_wgsl();
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    let find = |ty: &naga::Type| ty.name.as_deref() == Some("FlatTreesParameters");
    let (_, block) = module.types.iter().find(|(_, ty)| find(ty)).expect("the block has its name");
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, FlatTreesParameters::SIZE);
    let names: Vec<&str> = members.iter().map(|member| member.name.as_deref().unwrap()).collect();
    assert_eq!(names, ["has_shadows", "lowest_light", "reserved_0", "reserved_1"]);
    let bytes = FlatTreesParameters::to_bytes(&trees(true));
    assert_eq!(bytes, *[1, 0.25f32.to_bits(), 0, 0].map(u32::to_le_bytes).as_flattened());
}
