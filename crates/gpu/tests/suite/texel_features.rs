//! Checks the optional texel formats in `formats/src/container/spec.md` against the features that wgpu requires.

use wgpu::{Features, TextureFormat};

const FORMATS: [(&str, TextureFormat); 11] = [
    ("R8_UNORM", TextureFormat::R8Unorm),
    ("R8G8_UNORM", TextureFormat::Rg8Unorm),
    ("R8G8B8A8_UNORM", TextureFormat::Rgba8Unorm),
    ("A2B10G10R10_UNORM_PACK32", TextureFormat::Rgb10a2Unorm),
    ("R16_UNORM", TextureFormat::R16Unorm),
    ("R16_SFLOAT", TextureFormat::R16Float),
    ("R16G16B16A16_UNORM", TextureFormat::Rgba16Unorm),
    ("R16G16B16A16_SFLOAT", TextureFormat::Rgba16Float),
    ("R16G16_SFLOAT", TextureFormat::Rg16Float),
    ("R32G32B32A32_SFLOAT", TextureFormat::Rgba32Float),
    ("E5B9G9R9_UFLOAT_PACK32", TextureFormat::Rgb9e5Ufloat),
];

#[test]
fn the_page_names_the_features_that_formats_need() {
    let page = include_str!("../../../../formats/src/container/spec.md");
    let (_, section) = page.split_once("### Required features").expect("the section");
    let (section, _) = section.split_once("\n## ").unwrap();
    let row_of = |name: &str| {
        let own = format!("`{name}`");
        let mut rows = section.lines().filter(|line| line.starts_with('|'));
        let found = rows.clone().find(|row| row.split('|').nth(1).is_some_and(|formats| formats.contains(&own)));
        found.or_else(|| rows.find(|row| row.contains("all others"))).unwrap()
    };
    for (name, format) in FORMATS {
        let row = row_of(name);
        let optional = format.required_features() == Features::TEXTURE_FORMAT_16BIT_NORM;
        assert_eq!(row.contains("TEXTURE_FORMAT_16BIT_NORM"), optional, "{name}");
        assert_eq!(row.contains("texture-formats-tier1"), optional, "{name}");
        assert!(optional || format.required_features().is_empty(), "{name}");
        let filtered = format.guaranteed_format_features(Features::TEXTURE_FORMAT_16BIT_NORM).flags;
        let filtered = filtered.contains(wgpu::TextureFormatFeatureFlags::FILTERABLE);
        assert_eq!(row.contains("not filtered here"), !filtered, "{name}");
    }
}
