//! Consistency of translated decoders with their headers.

use brdfc_formats::PackKind;
use brdfc_shaders::{BindingKind, Language, shader};

pub fn text(decoder: PackKind, language: Language) -> String {
    String::from_utf8(shader(decoder, language).bytes).unwrap()
}

/// The text languages.
pub const TEXTS: [Language; 5] = [Language::Wgsl, Language::Glsl, Language::Essl300, Language::Hlsl, Language::Msl];

#[test]
fn every_decoder_has_every_language() {
    for decoder in PackKind::ALL {
        assert_eq!(PackKind::from_name(decoder.name()), Some(decoder));
        for language in TEXTS {
            let text = text(decoder, language);
            let (header, code) =
                text.split_at(text.lines().take_while(|line| line.starts_with("//")).map(|line| line.len() + 1).sum());
            assert!(header.is_ascii(), "{header}");
            let first =
                format!("// Decoder of {} of brdfc {}, ", decoder.descriptor().plural, env!("CARGO_PKG_VERSION"));
            assert!(header.starts_with(&first), "{header}");
            assert!(header.lines().all(|line| line.len() <= 120 && line.trim_end() == line), "{header}");
            for function in decoder.descriptor().functions {
                assert!(header.contains(&format!(" {function}(")), "{header}");
                assert_eq!(code.matches(&format!(" {function}(")).count().min(1), 1, "{} {function}", language.name());
            }
            // Translated code has no comments, and no names that a tool made up.
            if language != Language::Wgsl {
                assert!(text.is_ascii() && !text.contains("_group_") && !text.contains("nagaSampler"), "{text}");
                assert!(!text.contains("brdfc_entry") && !text.contains("void main"));
            }
            assert_eq!(text, self::text(decoder, language), "the same each time");
        }
        let words = shader(decoder, Language::Spirv).bytes;
        assert_eq!((words.len() % 4, &words[..4]), (0, &0x0723_0203u32.to_le_bytes()[..]));
    }
    for language in Language::ALL {
        assert_eq!(Language::from_name(language.name()), Some(language));
    }
}

#[test]
fn interfaces_are_those_of_the_blocks() {
    for decoder in PackKind::ALL {
        let interface = shader(decoder, Language::Wgsl).interface;
        let numbers: Vec<u32> = interface.bindings.iter().map(|binding| binding.binding).collect();
        assert!(numbers.is_sorted_by(|a, b| a < b), "{}: {numbers:?}", decoder.name());
        for binding in &interface.bindings {
            let BindingKind::Uniform { bytes, fields, .. } = &binding.kind else {
                assert!(!binding.about.is_empty(), "{}", binding.name);
                continue;
            };
            assert!(fields.len() > 2 && fields[0].offset == 0 && fields.is_sorted_by_key(|field| field.offset));
            assert!(fields[fields.len() - 1].offset < *bytes && bytes.is_multiple_of(16), "{}", binding.name);
        }
        assert!(interface.functions.iter().all(|function| !function.about.is_empty()), "{}", decoder.name());
    }
    let table = shader(PackKind::Table, Language::Glsl).interface;
    assert_eq!(table.functions[0].signature, "fn table_brdf(wi: vec3<f32>, wo: vec3<f32>) -> vec3<f32>");
    let BindingKind::Uniform { block, bytes, fields } = &table.bindings[1].kind else { panic!("no block") };
    assert_eq!((block.as_str(), *bytes), ("TableBrdfParameters", 144));
    let slope = fields.iter().find(|field| field.name == "slope").unwrap();
    assert_eq!((slope.ty.as_str(), slope.offset, slope.about.as_str()), ("f32", 44, "change of row density"));
    assert_eq!(
        table.bindings[2].kind,
        BindingKind::Texture { dimension: "3d".to_owned(), samples: "float".to_owned(), filtered: true }
    );
    assert_eq!(table.bindings[3].kind, BindingKind::Sampler);
}

#[test]
fn headers_have_the_declarations_of_the_language() {
    let of = |language| text(PackKind::Table, language);
    assert!(of(Language::Glsl).contains("//     vec3 table_brdf(vec3 wi, vec3 wo)\n"));
    assert!(of(Language::Hlsl).contains("//     float3 table_brdf(float3 wi, float3 wo)\n"));
    assert!(of(Language::Hlsl).contains("\nSamplerState table_brdf_sampler : register(s3);\n"));
    assert!(
        of(Language::Essl300).contains(
            "layout(std140) uniform TableBrdfParametersBlock { TableBrdfParameters table_brdf_parameters; };"
        )
    );
    assert!(of(Language::Essl300).contains("uniform highp sampler3D table_brdf_texels;"));
    assert!(
        of(Language::Msl).contains(
            "//     metal::float3 table_brdf(metal::float3 wi, metal::float3 wo, constant TableBrdfParameters&"
        )
    );
}
