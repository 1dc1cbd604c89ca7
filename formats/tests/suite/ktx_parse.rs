//! Reads packs with ktx-parse, which shares no code with this crate. Requires Node and its package registry.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

use crate::cube_maps::cube_maps;
use brdfc_formats::container::{Extent, PackedTexture, TexelFormat, Texture};
use brdfc_formats::crop::{Crop, DirectionRange};
use brdfc_formats::wavelet::WaveletPack;

fn hex(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        write!(text, "{byte:02x}").unwrap();
        text
    })
}

/// Expected findings of the script in the file of a pack, as JSON. The wavelet values are assembled here from
/// `formats/src/wavelet/spec.md`; values that all packs have come from our own reader.
fn expectation(pack: &WaveletPack, file: &[u8], supercompress: bool) -> String {
    let h = &pack.header;
    let vk_format = match (h.channels, h.bits) {
        (1, 8) => 9,
        (1, _) => 70,
        (_, 8) => 37,
        _ => 91,
    };
    let mut size = [1 << h.levels; 2];
    let mut header: Vec<u8> = Vec::new();
    for word in [2, h.parameterisation.code(), h.levels, h.stored_levels, h.channels, h.bits, pack.scales.len() as u32]
    {
        header.extend(word.to_le_bytes());
    }
    header.extend([h.mean.to_le_bytes(), h.bias.to_le_bytes(), u32::from(h.energy_preserving).to_le_bytes()].concat());
    let mut errors: Vec<u8> = Vec::new();
    for e in [pack.on_grid, pack.off_grid] {
        errors.extend(e.samples.to_le_bytes());
        for ratio in [e.rms, e.relative_mean, e.relative_p95, e.relative_p99, e.relative_max] {
            errors.extend(ratio.to_le_bytes());
        }
        for ratio in [e.log_rms, e.cosine_log_rms, e.albedo_max_difference, e.reciprocity] {
            errors.extend(ratio.to_le_bytes());
        }
    }
    let component = if h.bits == 8 { 1 } else { 2 };
    let mut entries = PackedTexture::from_bytes(file).unwrap().entries;
    let of_all = ["brdfc.bindings", "brdfc.checksum", "brdfc.image.", "brdfc.uniform."];
    entries.retain(|key, _| of_all.iter().any(|start| key.starts_with(start)));
    assert_eq!(entries.len(), of_all.len());
    entries.extend([("brdfc.wavelet".to_owned(), header), ("brdfc.wavelet.errors".to_owned(), errors)]);
    if let Some(Crop { directions: DirectionRange { light, view }, window }) = pack.crop {
        size = window.size;
        let words = [window.first, window.size].concat().into_iter().map(u32::to_le_bytes);
        let angles = [light.from, light.to, view.from, view.to].map(f32::to_le_bytes);
        entries.insert("brdfc.crop".to_owned(), words.chain(angles).flatten().collect());
    }
    let [width, height] = size;
    json([vk_format, component, width, height, pack.scales.len() as u32, 0, 1, 1], &entries, supercompress)
}

/// Expected findings for any texture.
fn texture_expectation(texture: &Texture, supercompress: bool) -> String {
    let (vk_format, word) = match texture.format {
        TexelFormat::R8Unorm => (9, 1),
        TexelFormat::Rg8Unorm => (16, 1),
        TexelFormat::Rgba8Unorm => (37, 1),
        TexelFormat::R16Unorm => (70, 2),
        TexelFormat::R16Float => (76, 2),
        TexelFormat::Rgba16Unorm => (91, 2),
        TexelFormat::Rgba16Float => (97, 2),
        TexelFormat::Rg16Float => (83, 2),
        TexelFormat::Rgba32Float => (109, 4),
        TexelFormat::R32Uint => (98, 4),
        TexelFormat::Rgba32Uint => (107, 4),
        TexelFormat::Rgb9E5 => (123, 4),
        TexelFormat::Rgb10A2Unorm => (64, 4),
    };
    let [width, height, depth, layers, faces] = match texture.extent {
        Extent::D2([width, height]) => [width, height, 0, 0, 1],
        Extent::D2Array([width, height, layers]) => [width, height, 0, layers, 1],
        Extent::D3([width, height, depth]) => [width, height, depth, 0, 1],
        Extent::Cube(side) => [side, side, 0, 0, 6],
    };
    json([vk_format, word, width, height, depth, layers, faces, texture.levels], &texture.entries, supercompress)
}

/// `fields` are format, size of a word, width, height, depth, layers, faces, levels.
fn json(fields: [u32; 8], entries: &BTreeMap<String, Vec<u8>>, supercompress: bool) -> String {
    let [vk_format, type_size, width, height, depth, layers, faces, levels] = fields;
    let fields = [
        ("vkFormat", vk_format),
        ("typeSize", type_size),
        ("pixelWidth", width),
        ("pixelHeight", height),
        ("pixelDepth", depth),
        ("layerCount", layers),
        ("faceCount", faces),
        ("levelCount", levels),
        ("supercompressionScheme", if supercompress { 2 } else { 0 }),
    ]
    .map(|(name, value)| format!("\"{name}\": {value}"));
    let orientation = if depth == 0 { "rd" } else { "rdi" };
    let mut all = vec![("KTXorientation", orientation.to_owned()), ("KTXwriter", "brdfc".to_owned())];
    all.extend(entries.iter().map(|(name, value)| (name.as_str(), hex(value))));
    let all: Vec<String> = all.iter().map(|(name, value)| format!("\"{name}\": \"{value}\"")).collect();
    format!("{{\"header\": {{{}}}, \"entries\": {{{}}}}}", fields.join(", "), all.join(", "))
}

fn run(folder: &Path, program: &str, arguments: &[&str]) -> std::io::Result<Output> {
    Command::new(program).args(arguments).current_dir(folder).output()
}

/// A copy of the folder of the script with its packages; `None` if they are not available.
fn installed() -> Option<tempfile::TempDir> {
    let folder = tempfile::tempdir().unwrap();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/ktx_parse");
    for name in ["package.json", "package-lock.json", ".npmrc", "check.mjs"] {
        std::fs::copy(source.join(name), folder.path().join(name)).unwrap();
    }
    let install = ["ci", "--ignore-scripts", "--prefer-offline", "--fetch-retries=0", "--fetch-timeout=20000"];
    for (program, arguments) in [("node", &["--version"][..]), ("npm", &install)] {
        match run(folder.path(), program, arguments) {
            Ok(output) if output.status.success() => {}
            Ok(output) => {
                println!("skipped: {program} fails: {}", String::from_utf8_lossy(&output.stderr));
                return None;
            }
            Err(error) => {
                println!("skipped: no {program}: {error}");
                return None;
            }
        }
    }
    Some(folder)
}

#[test]
fn another_implementation_reads_packs_and_writes_the_same_bytes() {
    let Some(folder) = installed() else { return };
    let packs = folder.path().join("packs");
    std::fs::create_dir(&packs).unwrap();
    let mut count = 0;
    let mut save = |file: &[u8], json: &str, texels: &[u8]| {
        for (extension, bytes) in [("ktx2", file), ("json", json.as_bytes()), ("texels", texels)] {
            std::fs::write(packs.join(format!("{count}.{extension}")), bytes).unwrap();
        }
        count += 1;
    };
    for supercompress in [false, true] {
        for (_, pack) in brdfc_testing::codecs::wavelet::packs() {
            let file = pack.to_bytes(supercompress);
            save(&file, &expectation(&pack, &file, supercompress), &pack.texels);
            // The image stored as key/value data is a file of its own.
            let image = &PackedTexture::from_bytes(&file).unwrap().entries["brdfc.image.wavelet_brdf_index"];
            let texture = Texture::from_bytes(image).unwrap();
            save(image, &texture_expectation(&texture, supercompress), &texture.texels);
        }
        for (_, texture) in brdfc_testing::packs::textures().into_iter().chain(cube_maps()) {
            save(&texture.to_bytes(supercompress), &texture_expectation(&texture, supercompress), &texture.texels);
        }
    }
    let output = run(folder.path(), "node", &["check.mjs", "packs"]).unwrap();
    let (found, problems) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{problems}");
    assert_eq!(found.trim(), format!("{count} packs"));

    // The script detects a single different texel.
    let first = packs.join("0.texels");
    let mut texels = std::fs::read(&first).unwrap();
    *texels.last_mut().unwrap() ^= 1;
    std::fs::write(first, texels).unwrap();
    let output = run(folder.path(), "node", &["check.mjs", "packs"]).unwrap();
    let problems = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success() && problems.contains("0: AssertionError") && problems.contains("texels"));
}
