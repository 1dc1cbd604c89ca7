//! The package for the web loads and binds packs from files, in WebGL 2 and in WebGPU. Results are compared with the
//! CPU decoder. `bindings/web/build` makes the package.

use crate::browser::numbers;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::wavelet::Filter;
use brdfc_formats::{BrdfShader, PackKind};
use brdfc_shaders::Language;
use brdfc_testing::browser::{File, result_of_page};
use brdfc_testing::codecs::cases;
use brdfc_testing::engines::{Case, Query, call, check, macros};
use brdfc_testing::gradient;
use serde_json::{Value, json};

const PAGE: &str = "<!doctype html><meta charset=utf-8><title>brdfc</title>
<script type=importmap>{ \"imports\": { \"three\": \"/three/three.module.js\" } }</script>
<script type=module src=package.js></script>";

/// The call in WGSL. Wide texels may be floats, which the package binds without filtering, so samplers are not used on
/// them.
fn wgsl_call(decoder: PackKind) -> String {
    let exact =
        |brdf: BrdfShader| format!("vec4f({}, 0.0)", brdf.exact.replace("(wi, wo, level", "(a.xyz, b.xyz, a.w"));
    decoder.descriptor().brdf.filter(|brdf| brdf.may_be_wide).map_or_else(|| call(decoder), exact)
}

fn agrees(api: &str) {
    let folder = brdfc_testing::repository().join("bindings/web/dist");
    let Ok(entries) = std::fs::read_dir(&folder) else {
        println!("skipped: the package for the web is missing; run ./bindings/web/build");
        return;
    };
    let mut built: Vec<(String, Vec<u8>)> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "js"))
        .map(|path| (format!("dist/{}", path.file_name().unwrap().to_str().unwrap()), std::fs::read(&path).unwrap()))
        .collect();
    let three = folder.join("../node_modules/three/build");
    for file in ["three.module.js", "three.core.js"] {
        built.push((format!("three/{file}"), std::fs::read(three.join(file)).unwrap()));
    }
    // The package has no renderers that use these.
    const OTHER: [PackKind; 2] = [PackKind::Bandwidth, PackKind::Importance];
    // The test computes, and WebGPU on SwiftShader then filters cube maps wrongly near their edges.
    let is_wrong = |case: &Case| api == "webgpu" && case.decoder == PackKind::Environment;
    let loaded = |case: &Case| !OTHER.contains(&case.decoder) && !is_wrong(case) && !case.files.is_empty();
    let cases: Vec<Case> = cases().into_iter().filter(loaded).collect();
    let mut files: Vec<(String, &str, Vec<u8>)> = Vec::new();
    let mut listed = Vec::new();
    let mut add = |name: &str, file: Vec<u8>, queries: &[Query], frame: FrameBlock, mut item: Value| {
        let k = listed.len();
        let group = |g: usize| queries.iter().flat_map(move |query| query[g]);
        let queries = (0..3).flat_map(group).flat_map(f32::to_le_bytes).collect();
        files.push((format!("{k}/queries"), "application/octet-stream", queries));
        files.push((format!("{k}/x.ktx2"), "image/ktx2", file));
        let wavelet = match frame.blend {
            Filter::Nearest => "nearest",
            Filter::Slices => "slices",
            Filter::Bilinear => "bilinear",
        };
        let filter = if frame.sampler_filters { "sampler" } else { "shader" };
        item["name"] = name.into();
        item["options"] = json!({
            "filter": filter, "wavelet": wavelet, "distanceScale": frame.distance_scale, "verify": true,
        });
        listed.push(item);
    };
    for case in &cases {
        let item = json!({ "glsl": call(case.decoder), "wgsl": wgsl_call(case.decoder) });
        add(&case.name, case.files[0].clone(), &case.queries, case.frame, item);
    }
    // The package has no decoder of this kind.
    let unknown = json!({
        "glsl": gradient::CALL,
        "wgsl": gradient::CALL,
        "shader": { "essl300": gradient::ESSL300, "wgsl": gradient::wgsl() },
    });
    add("gradient", gradient::file(), &gradient::queries(), gradient::FRAME, unknown);
    let list = json!({ "api": api, "macros": macros(Language::Essl300), "cases": listed }).to_string();
    let mut served: Vec<File<'_>> = vec![
        ("", "text/html", PAGE.as_bytes()),
        ("package.js", "text/javascript", include_bytes!("package.js")),
        ("cases.json", "application/json", list.as_bytes()),
    ];
    served.extend(built.iter().map(|(name, bytes)| (name.as_str(), "text/javascript", bytes.as_slice())));
    served.extend(files.iter().map(|(name, media, bytes)| (name.as_str(), *media, bytes.as_slice())));
    let Some(posted) = result_of_page(&served) else { return };
    let found = numbers(&posted, listed.len());
    let (of_gradient, of_cases) = found.split_last().unwrap();
    check(&format!("package, {api}"), &cases, of_cases);
    gradient::check(&format!("package, {api}"), of_gradient);
}

#[test]
fn files_loaded_for_webgl_2_agree_with_the_cpu() {
    agrees("webgl2");
}

#[test]
fn files_loaded_for_three_js_agree_with_the_cpu() {
    agrees("three");
}

#[test]
fn files_loaded_for_webgpu_agree_with_the_cpu() {
    agrees("webgpu");
}
