//! WGSL of polynomial wavelet trees without a graphics adapter: it validates, its uniform block matches the one that
//! Rust writes, and it calls only functions that browsers accept.

use brdfc_formats::pwt::shader::{PWT_WGSL, PwtParameters};
use brdfc_testing::codecs::pwt::packs;
use naga::valid::{Capabilities, ValidationFlags, Validator};

fn parsed() -> naga::Module {
    naga::front::wgsl::parse_str(PWT_WGSL).unwrap_or_else(|error| panic!("{}", error.emit_to_string(PWT_WGSL)))
}

/// No capabilities beyond WebGPU without features.
#[test]
fn it_validates() {
    let result = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&parsed());
    assert!(result.is_ok(), "{}", result.unwrap_err().emit_to_string(PWT_WGSL));
}

#[test]
fn a_mistake_does_not_validate() {
    let source = PWT_WGSL.replace("var linear = value;", "var linear = 0u;");
    assert!(source != PWT_WGSL);
    let valid = naga::front::wgsl::parse_str(&source)
        .is_ok_and(|module| Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok());
    assert!(!valid);
}

/// Sampling with implicit derivatives is only valid in uniform control flow.
#[test]
fn every_fetch_names_its_level() {
    let code: String = PWT_WGSL.lines().map(|line| line.split("//").next().unwrap()).collect();
    assert!(!code.contains("textureSample("));
    assert!(code.contains("textureSampleLevel(") && code.contains("textureLoad("));
}

/// Size and offsets by naga's layout, and the contents for each pack.
#[test]
fn the_uniform_block_matches_rust() {
    let module = parsed();
    let block = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("PwtParameters"));
    let naga::TypeInner::Struct { members, span } = &block.expect("the block has its name").1.inner else {
        panic!("not a struct")
    };
    assert_eq!(*span as usize, PwtParameters::SIZE);
    for (name, pack) in packs() {
        let bytes = PwtParameters::to_bytes(&pack);
        assert_eq!(bytes.len(), PwtParameters::SIZE);
        let header = pack.header();
        let (domain, epsilon) = header.domain.code();
        let of = |number: &dyn Fn(usize) -> u32| (0..header.textures.len()).map(number).collect::<Vec<u32>>();
        for member in members {
            let field = member.name.as_deref().unwrap();
            let bits = |numbers: &[f32]| numbers.iter().map(|n| n.to_bits()).collect::<Vec<u32>>();
            let expected = match field {
                "size" => bits(&header.size.map(|side| side as f32)),
                "extent" => bits(&header.extent.map(|side| side as f32)),
                "repeats" => vec![u32::from(header.repeats)],
                "coordinates" => vec![header.basis.coordinates as u32],
                "degree" => vec![header.basis.degree],
                "domain" => vec![domain],
                "epsilon" => bits(&[epsilon]),
                "textures" => vec![header.textures.len() as u32],
                "levels" => vec![header.levels],
                "map_side" => vec![header.light_map.as_ref().map_or(0, |map| map.side())],
                "views" => vec![header.view_count()],
                "reserved_0" | "reserved_1" | "reserved_2" => vec![0],
                "first_level" => of(&|k| header.textures[k].level),
                "layers" => of(&|k| header.textures[k].layers()),
                "channels" => of(&|k| header.textures[k].channels),
                "colour" => bits(&header.colour.map(|[r, g, b]| [r, g, b, 0.0]).concat()),
                "triangle" => bits(&header.triangle),
                "components" => {
                    header.components().flat_map(|c| bits(&[c.channel as f32, c.term as f32, c.scale, c.low])).collect()
                }
                _ => panic!("no such field: {field}"),
            };
            let words = bytes[member.offset as usize..].chunks_exact(4).take(expected.len());
            let found: Vec<u32> = words.map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
            assert_eq!(found, expected, "{name}: {field}");
        }
    }
}

/// The arrays are long enough for any pack.
#[test]
fn arrays_hold_the_largest_pack() {
    use brdfc_formats::pwt::{MAX_COMPONENTS, MAX_TERMS, MAX_TEXTURES};
    assert!(
        PWT_WGSL.contains(&format!("triangle: array<vec4<f32>, {}>", (MAX_TERMS * (MAX_TERMS + 1) / 2).div_ceil(4)))
    );
    assert!(PWT_WGSL.contains(&format!("components: array<vec4<f32>, {MAX_COMPONENTS}>")));
    assert_eq!(PWT_WGSL.matches("texture_2d_array<f32>").count(), MAX_TEXTURES + 1, "and the light map");
}
