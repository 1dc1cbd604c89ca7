//! Shipped WGSL without a graphics adapter: it validates, its uniform block matches the one that Rust writes, and it
//! calls only functions that browsers accept.

use brdfc_formats::PackKind;
use brdfc_formats::bindings::{FRAME_WGSL, FrameBlock};
use brdfc_formats::combined_wgsl;
use brdfc_formats::crop::{Crop, DirectionRange, Window};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::flat_btf::shader::{FLAT_BTF_WGSL, FlatBtfParameters};
use brdfc_formats::flat_btf::{FlatBtfDecoder, MarchSteps};
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::WaveletPack;
use brdfc_formats::wavelet::shader::{WAVELET_BRDF_WGSL, WaveletBrdfParameters};
use brdfc_testing::codecs::flat_btf::{SMALL, base_file, layers_of, parts, vdim_file};
use brdfc_testing::codecs::wavelet::{energy_preserving, header, pack};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::collections::BTreeMap;

fn parsed() -> naga::Module {
    naga::front::wgsl::parse_str(WAVELET_BRDF_WGSL)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(WAVELET_BRDF_WGSL)))
}

/// No capabilities beyond WebGPU without features.
#[test]
fn it_validates() {
    let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&parsed());
    assert!(result.is_ok(), "{}", result.unwrap_err().emit_to_string(WAVELET_BRDF_WGSL));
}

#[test]
fn a_mistake_does_not_validate() {
    let source = WAVELET_BRDF_WGSL.replace("var value = vec3<f32>(0.0);", "var value = 0u;");
    assert!(source != WAVELET_BRDF_WGSL);
    let valid = naga::front::wgsl::parse_str(&source)
        .is_ok_and(|module| Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok());
    assert!(!valid);
}

/// Sampling with implicit derivatives is only valid in uniform control flow.
#[test]
fn every_fetch_names_its_level() {
    let code: String = WAVELET_BRDF_WGSL.lines().map(|line| line.split("//").next().unwrap()).collect();
    assert!(!code.contains("textureSample("));
    assert!(code.contains("textureSampleLevel(") && code.contains("textureLoad("));
}

#[test]
fn the_uniform_block_is_the_one_that_rust_writes() {
    let module = parsed();
    let (_, block) = module
        .types
        .iter()
        .find(|(_, ty)| ty.name.as_deref() == Some("WaveletBrdfParameters"))
        .expect("the block has its name");
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, WaveletBrdfParameters::SIZE);
    let whole = pack(header(Parameterisation::HalfDifference, 3, 3, 8), 9, 1);
    let window = Window { first: [1, 2], size: [3, 5] };
    let pack = whole.cropped(Crop { directions: DirectionRange::ALL, window }).expect("within the grid");
    let parameters = WaveletBrdfParameters::new(&pack);
    let bytes = parameters.to_bytes();
    let mut seen = 0;
    for member in members {
        let name = member.name.as_deref().unwrap();
        let word = u32::from_le_bytes(bytes[member.offset as usize..][..4].try_into().unwrap());
        let expected = match name {
            "levels" => 3,
            "parameterisation" => 1,
            "channels" => 3,
            "mean" => 0.25f32.to_bits(),
            "bias" => 0.01f32.to_bits(),
            "scaling_scale" => pack.scales[1].scale.to_bits(),
            "scaling_offset" => pack.scales[1].offset.to_bits(),
            "slices" => (pack.slices() as f32).to_bits(),
            "reserved_0" | "reserved_1" => 0,
            "trees" => 0,
            "window" => 0x0503_0201,
            _ => panic!("no such field: {name}"),
        };
        assert_eq!(word, expected, "{name}");
        let float = ["mean", "bias", "scaling_scale", "scaling_offset", "slices", "reserved_1"].contains(&name);
        let kind = module.types[member.ty].inner.scalar_kind();
        assert_eq!(kind, Some(if float { naga::ScalarKind::Float } else { naga::ScalarKind::Uint }), "{name}");
        if name == "trees" {
            let preserving = WaveletBrdfParameters::new(&self::pack(energy_preserving(2, 1, 8), 3, 1));
            assert_eq!(preserving.to_bytes()[member.offset as usize..][..4], [2, 0, 0, 0]);
        }
        seen += 1;
    }
    assert_eq!(seen, 12);
}

#[test]
fn the_index_map_has_slice_scale_and_offset() {
    let texels_of = |pack: &WaveletPack| -> Vec<[f32; 4]> {
        let bindings = pack.bindings();
        let (_, texels) = bindings.textures().find(|(name, _)| *name == "wavelet_brdf_index").unwrap();
        let floats = |texel: &[u8; 16]| texel.as_chunks::<4>().0.iter().map(|c| f32::from_le_bytes(*c)).collect();
        let four = |floats: Vec<f32>| [floats[0], floats[1], floats[2], floats[3]];
        texels.bytes.as_chunks::<16>().0.iter().map(|texel| four(floats(texel))).collect()
    };
    let pack = pack(header(Parameterisation::TangentPole, 2, 1, 8), 5, 3);
    let texels = texels_of(&pack);
    assert_eq!(texels.len(), 16);
    assert_eq!(std::mem::size_of_val(&texels[..]) as u64 + pack.texels.len() as u64, pack.gpu_bytes());
    for (texel, slice) in texels.iter().zip(&pack.index) {
        let scale = pack.scales[usize::from(*slice)];
        assert_eq!(*texel, [f32::from(*slice), scale.scale, scale.offset, 0.0]);
    }
    // Trees of 1 and 4 coefficients, in rows of their own.
    let preserving = self::pack(energy_preserving(2, 1, 8), 5, 3);
    let found = texels_of(&preserving);
    assert_eq!(std::mem::size_of_val(&found[..]) as u64 + preserving.texels.len() as u64, preserving.gpu_bytes());
    assert_eq!(found[16..].iter().map(|texel| texel[0]).collect::<Vec<_>>(), [6.0, 7.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0]);
}

fn flat_btf() -> naga::Module {
    naga::front::wgsl::parse_str(FLAT_BTF_WGSL)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(FLAT_BTF_WGSL)))
}

#[test]
fn the_flat_btf_shader_validates() {
    let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&flat_btf());
    assert!(result.is_ok(), "{}", result.unwrap_err().emit_to_string(FLAT_BTF_WGSL));
    let source = FLAT_BTF_WGSL.replace("var heights = vec3<f32>(0.0);", "var heights = 0u;");
    assert!(source != FLAT_BTF_WGSL);
    let valid = naga::front::wgsl::parse_str(&source)
        .is_ok_and(|module| Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok());
    assert!(!valid, "a mistake");
    let code: String = FLAT_BTF_WGSL.lines().map(|line| line.split("//").next().unwrap()).collect();
    assert!(!code.contains("textureSample(") && code.contains("textureSampleLevel("));
}

/// All decoders can be combined in one shader: they share no names, and no slots except that of the frame block.
#[test]
fn the_shaders_share_no_names() {
    let decoders = PackKind::ALL.map(|kind| (kind.descriptor().wgsl)());
    let source = combined_wgsl(decoders.iter().map(String::as_str));
    let module =
        naga::front::wgsl::parse_str(&source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
    assert!(Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok());
    let slots: Vec<u32> =
        module.global_variables.iter().filter_map(|(_, variable)| Some(variable.binding?.binding)).collect();
    let distinct: std::collections::BTreeSet<u32> = slots.iter().copied().collect();
    assert!(slots.len() == distinct.len() && slots.len() > 30, "{slots:?}");
}

#[test]
fn the_uniform_block_of_flat_btfs_is_the_one_that_rust_writes() {
    let module = flat_btf();
    let find = |ty: &naga::Type| ty.name.as_deref() == Some("FlatBtfParameters");
    let (_, block) = module.types.iter().find(|(_, ty)| find(ty)).expect("the block has its name");
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, FlatBtfParameters::SIZE);
    let steps = MarchSteps { sight: 21, refine: 3, both: 30 };
    let decoder = FlatBtfDecoder::new(parts(SMALL, 1)).with_steps(steps);
    let bytes = FlatBtfParameters::to_bytes(&decoder);
    let names: Vec<&str> = members.iter().map(|member| member.name.as_deref().unwrap()).collect();
    let words = [
        ("size", 8),
        ("sheets", 3),
        ("levels", 4),
        ("sight_steps", 21),
        ("refine_steps", 3),
        ("both_steps", 30),
        ("low", (-0.25f32).to_bits()),
        ("range", 0.5f32.to_bits()),
        ("finer", 1.0f32.to_bits()),
        ("polar_angles", 0),
        ("azimuth_rows", 0),
        ("largest_angle", 0),
        ("lights", 0),
        ("block", 0),
        ("largest_tangent", 0),
        ("reserved", 0),
    ];
    assert_eq!(names, words.map(|(name, _)| name));
    for (member, (name, expected)) in members.iter().zip(words) {
        let word = u32::from_le_bytes(bytes[member.offset as usize..][..4].try_into().unwrap());
        assert_eq!(word, expected, "{name}");
        let is_float = ["low", "range", "finer", "largest_angle", "largest_tangent"].contains(&name);
        let kind = if is_float { naga::ScalarKind::Float } else { naga::ScalarKind::Uint };
        assert_eq!(module.types[member.ty].inner.scalar_kind(), Some(kind), "{name}");
    }
    // One sheet; the steps of the relief.
    let base = base_file().decoder;
    let MarchSteps { sight, refine, both } = MarchSteps::of(layers_of(base.parts()).header());
    let base = FlatBtfParameters::to_bytes(&base);
    assert_eq!(base[..24], *[8, 1, 4, sight, refine, both].map(u32::to_le_bytes).as_flattened());
    // An indirection map, with shadows of five lights.
    let map = FlatBtfParameters::to_bytes(&vdim_file().decoder);
    let [finer, angle, tangent] = [1.0, 1.25, 1.25f64.tan() as f32].map(f32::to_bits);
    let words = [8, 0, 4, 0, 0, 0, 0, 0, finer, 4, 5, angle, 5, 0, tangent, 0];
    assert_eq!(map, *words.map(u32::to_le_bytes).as_flattened());
}

/// Constants of the shader are those of the CPU decoder.
#[test]
fn the_constants_of_flat_btfs_are_those_of_the_cpu() {
    let of = |source: &str, prefix: &str| -> BTreeMap<String, f32> {
        let constant = |line: &str| {
            let (name, value) = line.strip_prefix("const ")?.strip_prefix(prefix)?.split_once(": f32 = ")?;
            Some((name.to_owned(), value.strip_suffix(';')?.parse().ok()?))
        };
        source.lines().filter_map(constant).collect()
    };
    let shader = of(FLAT_BTF_WGSL, "FLAT_BTF_");
    let names: Vec<&str> = shader.keys().map(String::as_str).collect();
    assert_eq!(names, ["MIN_AREA_RATIO", "MIN_COSINE", "MIN_PASSING_STEPS", "RISE", "TEXELS_PER_STEP"]);
    assert_eq!(shader, of(include_str!("../../src/flat_btf/march.rs"), ""));
    let changed = FLAT_BTF_WGSL.replace("FLAT_BTF_RISE: f32 = ", "FLAT_BTF_RISE: f32 = 9");
    assert_ne!(shader, of(&changed, "FLAT_BTF_"));
}

#[test]
fn the_block_of_the_frame_is_the_one_that_rust_writes() {
    let module = naga::front::wgsl::parse_str(FRAME_WGSL).unwrap();
    let block = module.types.iter().map(|(_, ty)| ty).find(|ty| ty.name.as_deref() == Some("BrdfcFrame")).unwrap();
    let naga::TypeInner::Struct { members, span } = &block.inner else { panic!("not a struct") };
    assert_eq!(*span as usize, FrameBlock::SIZE);
    let names: Vec<_> = members.iter().map(|member| (member.name.as_deref().unwrap(), member.offset)).collect();
    assert_eq!(names, [("distance_scale", 0), ("sampler_filters", 4), ("blend", 8), ("reserved", 12)]);
    let bytes = FrameBlock { distance_scale: 0.25, ..FrameBlock::default() }.to_bytes();
    assert_eq!(bytes, *[0.25f32.to_le_bytes(), 1u32.to_le_bytes(), 2u32.to_le_bytes(), [0; 4]].as_flattened());
    assert_eq!(FrameBlock::exact().to_bytes()[4..8], [0; 4]);
}

/// Each shader is self-contained, so each contains a copy of the arctangent if it needs one, with the same steps.
#[test]
fn the_arctangent_is_one() {
    let of = |shader: &str| -> Vec<String> {
        let functions = shader.split("fn ").filter_map(|rest| {
            let prefix = rest.split('(').next()?.strip_suffix("_atan2")?;
            let function = &rest[..rest.find("\n}\n").expect("an end")];
            Some(function.replace(&format!("{prefix}_"), "").replace(&format!("{}_", prefix.to_uppercase()), ""))
        });
        functions.collect()
    };
    let found: Vec<String> = PackKind::ALL.into_iter().flat_map(|kind| of(&(kind.descriptor().wgsl)())).collect();
    assert!(found.len() > 2 && found[0].lines().count() > 20, "{found:#?}");
    assert!(found.iter().all(|function| *function == found[0]), "{found:#?}");
    assert_ne!(of(&WAVELET_BRDF_WGSL.replace("9.642198e-2", "9.6e-2")), found[..1]);
}

/// The calls and the shader in the README are valid WGSL after the decoders that it names.
#[test]
fn calls_in_the_readme_validate() {
    let page = include_str!("../../README.md");
    let check = |source: &str| {
        let module =
            naga::front::wgsl::parse_str(source).unwrap_or_else(|error| panic!("{}", error.emit_to_string(source)));
        let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module);
        assert!(result.is_ok(), "{}", result.unwrap_err().emit_to_string(source));
    };
    for kind in PackKind::ALL {
        let (decoder, wgsl) = (kind.name(), (kind.descriptor().wgsl)());
        let row =
            page.lines().find(|line| line.starts_with(&format!("| `{decoder}` | "))).expect("a row of the decoder");
        let calls: Vec<&str> = row.split('`').skip(5).step_by(2).collect();
        assert!(!calls.is_empty(), "{row}");
        for call in calls {
            check(&format!(
                "{wgsl}\n@fragment fn call(@location(0) uv: vec2<f32>, @location(1) wi: vec3<f32>, @location(2) wo: vec3<f32>,\n\
                 @location(3) distance: f32, @location(4) @interpolate(flat) index: u32, @location(5) direction: vec3<f32>,\n\
                 @location(6) sharpness: f32) {{ let result = {call}; }}"
            ));
        }
    }
    let (_, shader) = page.split_once("```wgsl\n").expect("a shader");
    check(&format!("{TABLE_BRDF_WGSL}\n{}", shader.split("```").next().expect("its end")));
}
