//! The package for the web rejects files that are not packs, and packs that its shaders do not decode.

use super::web::files;
use crate::common::cli::Folder;
use brdfc_formats::container::Texture;
use brdfc_testing::browser::{File, result_of_page};
use brdfc_testing::gradient;
use std::collections::BTreeMap;

/// A pack with other metadata.
fn with_entries(pack: &[u8], change: impl FnOnce(&mut BTreeMap<String, Vec<u8>>)) -> Vec<u8> {
    let mut texture = Texture::from_bytes(pack).unwrap();
    change(&mut texture.entries);
    texture.to_bytes(true)
}

/// A pack with one changed place in its list of bindings.
fn with_list(pack: &[u8], from: &str, to: &str) -> Vec<u8> {
    with_entries(pack, |entries| {
        let list = entries.get_mut("brdfc.bindings").unwrap();
        let text = String::from_utf8(list.clone()).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{from}: {text}");
        *list = text.replace(from, to).into_bytes();
    })
}

/// The package rejects the same files as the program, and the message states the place, the found and the expected value.
#[test]
fn files_that_are_damaged_are_refused_by_the_package() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "-o", "it.ktx2"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "--codec", "wavelet", "--bits", "12", "-o", "wide.ktx2"]).succeeded();
    let Some(mut files) = files(&folder) else { return };
    let (table, wavelet, gradient) = (folder.read("it.ktx2"), folder.read("wide.ktx2"), gradient::file());
    let mut flipped = gradient.clone();
    *flipped.last_mut().unwrap() ^= 1;
    let without_list = with_entries(&gradient, |entries| _ = entries.remove("brdfc.bindings"));
    let with_more = with_entries(&gradient, |entries| _ = entries.insert("brdfc.image.more".to_owned(), Vec::new()));
    let more: String = (44..=70).map(|slot| format!("{slot} sampler{slot} sampler clamp\n")).collect();
    let with_more_samplers = with_list(&gradient, "\n\0", &format!("\n{more}\0"));
    let mut cases = vec![
        ("whole", gradient.clone(), "loaded"),
        ("table", table.clone(), "loaded"),
        ("wavelet", wavelet.clone(), "loaded"),
        ("flipped", flipped, "the file is damaged"),
        ("short", table[..60].to_vec(), ", in 60 bytes; expected a complete KTX2 file"),
        ("empty", Vec::new(), ", in 0 bytes; expected a complete KTX2 file"),
        ("text", b"no pack, but a text".to_vec(), ", in 19 bytes; expected a complete KTX2 file"),
        ("no list", without_list, "brdfc.bindings: not among the keys brdfc.checksum, brdfc.gradient, brdfc.image"),
        ("more images", with_more, "brdfc.image.more: no binding names this key; expected keys that "),
        ("more samplers", with_more_samplers, "brdfc.bindings samplers: found 28, expected at most 16"),
    ];
    for (pack, from, to, expected) in [
        (&table, "decoder table 1", "decoder table 2", "version of table: found 2, expected 1"),
        (
            &table,
            "table_brdf_curve",
            "table_other",
            "slot 4: found texture table_other, 2d of float, filtered, expected texture table_brdf_curve, 2d of float, filtered, as",
        ),
        (
            &table,
            "2d r16float 1 1 1 1 table_brdf_sampler",
            "2d r16float 1 1 1 1 -",
            "slot 4: found texture table_brdf_curve, 2d of float, not filtered, expected texture table_brdf_curve, 2d of float, filtered",
        ),
        (
            &table,
            "2d r16float 1 1 1 1 table_brdf_sampler",
            "2d r32uint 1 1 1 1 -",
            "slot 4: found texture table_brdf_curve, 2d of uint, not filtered, expected texture table_brdf_curve, 2d of float, filtered",
        ),
        (
            &table,
            "2d r16float 1 1 1 1 table_brdf_sampler",
            "3d r16float 1 1 1 1 table_brdf_sampler",
            "slot 4: found texture table_brdf_curve, 3d of float, filtered, expected texture table_brdf_curve, 2d of float, filtered",
        ),
        (
            &wavelet,
            " -\n",
            " wavelet_brdf_sampler\n",
            "slot 7: found texture wavelet_brdf_index, 2d of float, filtered, expected texture wavelet_brdf_index, 2d of float, not filtered",
        ),
        (&gradient, "\n\0", "\n", "bytes that are not valid text; expected lines of UTF-8 text that end with "),
        (&gradient, "gradient 1", "gradient 01", "line 1: found 01, expected 1 to 4294967295"),
        (&gradient, "decoder", "coder", "line 1: found coder gradient 1, expected 'decoder', its name and its version"),
        (
            &gradient,
            "e frame",
            "e clock",
            "line 2: found 0 brdfc_frame clock, expected frame, uniform, texture or sampler",
        ),
        (&gradient, "0 brdfc_frame", "1 brdfc_frame", "line 2: found 1, expected slot 0 for a frame"),
        (&gradient, "brdfc_frame", "Frame", "line 2: found Frame, expected a name of a to z"),
        (&gradient, "uniform 32", "uniform 24", "line 3: found 24, expected a multiple of 16"),
        (&gradient, "uniform 32", "uniform 16400", "line 3: found 16400, expected 16 to 16384"),
        (
            &gradient,
            "uniform 32",
            "uniform 48",
            "gradient_parameters: found 32 bytes, expected 48, as brdfc.bindings line 3",
        ),
        (&gradient, "41 ", "40 ", "line 4: found slot 40, expected slots in ascending order, each once"),
        (&gradient, "gradient_ramp", "gradient_shade", "line 5: found gradient_shade, expected a unique name"),
        (&gradient, "texture file", "texture entry", "found 0 bindings of the file's own texture, expected one"),
        (&gradient, "texture file", "texture empty", "line 4: found 8 x 1 x 1, expected one texel"),
        (&gradient, "r8unorm 8", "r8unorm 9000", "line 4: found 9000, expected 1 to 8192"),
        (
            &gradient,
            "r8unorm 8",
            "r8unorm 7",
            "texture: found 1 levels of 2d, 8 x 1 x 1 texels of r8unorm, expected 1 levels of 2d, 7",
        ),
        (
            &gradient,
            "2d r8unorm 8 1 1",
            "cube r8unorm 8 1 6",
            "line 4: found cube of [8, 1, 6], expected 2d, 2d-array, 3d or",
        ),
        (
            &gradient,
            "2d r8unorm 8 1 1",
            "cube r8unorm 8 8 6",
            "texture: found 1 levels of 2d, 8 x 1 x 1 texels of r8unorm",
        ),
        (&gradient, "2d r8unorm 8 1 1", "2d-array r8unorm 8192 8192 64", "expected at most 1073741824 for all images"),
        (
            &gradient,
            "gradient_shade",
            "other",
            "brdfc.image.other: missing; expected a key of this name, as brdfc.bindings line 5",
        ),
        (&gradient, "16 8 1 4", "16 8 1 6", "line 5: found 6, expected 1 to 5"),
        (
            &gradient,
            "16 8 1 4",
            "16 8 1 3",
            "brdfc.image.gradient_shade: found 4 levels of 2d, 16 x 8 x 1 texels of r16float",
        ),
        (&gradient, "r16float", "r16half", "line 5: found r16half, expected r8unorm or "),
        (&gradient, "r16float", "r32uint", "line 5: found gradient_sampler, expected -, because integers are "),
        (
            &gradient,
            "43 gradient_sampler",
            "43 other",
            "line 5: found gradient_sampler, expected the name of a sampler in the list, or -",
        ),
        (&gradient, "43 ", "1000 ", "line 6: found 1000, expected 0 to 999"),
        (&gradient, "sampler repeat", "sampler mirror", "line 6: found mirror, expected clamp or repeat"),
    ] {
        cases.push((to, with_list(pack, from, to), expected));
    }
    for (k, (_, bytes, _)) in cases.iter().enumerate() {
        files.push((format!("{k}.ktx2"), "image/ktx2", bytes.clone()));
    }
    let page = format!(
        "<script type=\"module\">
import {{ loadPack, uploadWebGpu }} from './dist/index.js';
const results = {{ cases: [] }};
const of = (file, options) => loadPack(file, options).then(() => 'loaded', ({{ message }}) => message);
for (let k = 0; k < {}; k += 1) {{
    // The first ones have a valid checksum.
    results.cases.push(await of(`${{k}}.ktx2`, {{ verify: k < 4 }}));
}}
results.scale = await of('packs/it.ktx2', {{ distanceScale: -1 }});
results.filter = await of('packs/it.ktx2', {{ filter: 'none' }});
const wide = await loadPack('packs/wide.ktx2');
try {{
    uploadWebGpu({{ features: new Set() }}, wide);
}} catch ({{ message }}) {{
    results.wide = message;
}}
fetch('/result', {{ method: 'POST', body: JSON.stringify(results) }});
</script>",
        cases.len()
    );
    files.push((String::new(), "text/html", page.into_bytes()));
    let served: Vec<File<'_>> =
        files.iter().map(|(name, media, bytes)| (name.as_str(), *media, bytes.as_slice())).collect();
    let Some(results) = result_of_page(&served) else { return };
    let results: serde_json::Value = serde_json::from_slice(&results).unwrap();
    for (k, (name, _, expected)) in cases.iter().enumerate() {
        let found = results["cases"][k].as_str().unwrap();
        assert!(found.contains(expected), "{name}: {found}");
        // A fetched file has its name in front.
        assert!(*expected == "loaded" || found.starts_with(&format!("{k}.ktx2: ")), "{name}: {found}");
    }
    for (name, expected) in [
        ("wide", "device: the pack needs the feature float32-filterable; "),
        ("scale", "distanceScale: found -1, expected a number above 0"),
        ("filter", "filter: found none, expected shader or sampler"),
    ] {
        let found = results[name].as_str().unwrap();
        assert!(found.contains(expected), "{name}: {found}");
    }
}
