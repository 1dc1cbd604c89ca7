//! Pages in a browser, compared with `brdfc render`.

use crate::common::cli::Folder;
use brdfc_metrics::image::{ImageDifference, LinearImage, compare_images};
use brdfc_readers::colour::decode_srgb;
use brdfc_testing::browser::{result_of_page, with_script};
use serde_json::{Value, json};
use std::collections::BTreeMap;

pub(super) const SIDE: usize = 128;
pub(super) const SQUARE: [usize; 2] = [SIDE; 2];
/// Limit of the mean ΔE.
pub(super) const BOUND: f64 = 0.5;

/// Text and renderings of a page after each of these changes; `None` without a browser.
pub(super) struct Seen {
    /// Results of scripts that replace changes.
    pub(super) results: Vec<Value>,
    pub(super) api: String,
    first: f64,
    speed: f64,
    pub(super) renderings: Vec<LinearImage>,
    /// As coarse as the first rendering, with its exposure.
    firsts: Vec<LinearImage>,
    pub(super) exposures: Vec<f64>,
    pub(super) measured: Vec<Value>,
}

pub(super) fn seen(page: &str, size: [usize; 2], api: &str, changes: &[Value]) -> Option<Seen> {
    let script = "
const base64 = (bytes) => { let text = ''; for (const byte of bytes) { text += String.fromCharCode(byte); } return btoa(text); };
const say = (value) => fetch('/result', { method: 'POST', body: typeof value === 'string' ? value : JSON.stringify(value) });
addEventListener('error', ({ message }) => say(`error: ${message}`));
addEventListener('unhandledrejection', ({ reason }) => say(`error: ${reason?.name}: ${reason?.message ?? reason}`));
(async () => {
    const first = await brdfcView.first;
    const found = { first, api: document.getElementById('api').textContent, renderings: [], firsts: [], exposures: [], measured: [], results: [] };
    for (const changes of CHANGES) {
        if (typeof changes === 'string') {
            found.results.push(await (0, eval)(`(async () => { ${changes} })()`));
            continue;
        }
        await brdfcView.set(changes);
        for (const [list, isFirst] of [[found.firsts, true], [found.renderings, false]]) {
            const png = await brdfcView.rendering(isFirst);
            list.push(base64(new Uint8Array(await png.arrayBuffer())));
        }
        found.exposures.push(brdfcView.exposure());
        found.speed ??= await brdfcView.speed(2);
        found.measured.push(brdfcView.state.right < 0 ? null : await brdfcView.measure());
    }
    await say(found);
})();
";
    let script = script.replace("CHANGES", &json!(changes).to_string());
    let page = with_script(page, size, api, &script);
    let posted = result_of_page(&[("", "text/html", page.as_bytes())])?;
    let report: Value = serde_json::from_slice(&posted).unwrap_or_else(|_| {
        panic!("{}", String::from_utf8_lossy(&posted));
    });
    let rendering = |text: &Value| {
        use base64::Engine as _;
        let png = base64::engine::general_purpose::STANDARD.decode(text.as_str().unwrap()).unwrap();
        linear(&png)
    };
    Some(Seen {
        results: report["results"].as_array().unwrap().clone(),
        api: report["api"].as_str().unwrap().to_owned(),
        first: report["first"].as_f64().unwrap(),
        speed: report["speed"].as_f64().unwrap_or(0.0),
        renderings: report["renderings"].as_array().unwrap().iter().map(rendering).collect(),
        firsts: report["firsts"].as_array().unwrap().iter().map(rendering).collect(),
        exposures: report["exposures"].as_array().unwrap().iter().map(|exposure| exposure.as_f64().unwrap()).collect(),
        measured: report["measured"].as_array().unwrap().clone(),
    })
}

pub(super) fn linear(png: &[u8]) -> LinearImage {
    let image = image::load_from_memory(png).unwrap().to_rgb8();
    let pixels = image.pixels().map(|pixel| pixel.0.map(|code| decode_srgb(f64::from(code) / 255.0) as f32)).collect();
    let (width, height) = (image.width() as usize, image.height() as usize);
    LinearImage { pixels, coverage: vec![1.0; width * height], ..LinearImage::black(width, height) }
}

/// Renderings of `brdfc render`, each drawn once.
pub(super) struct Renders<'a> {
    folder: &'a Folder,
    known: BTreeMap<String, LinearImage>,
}

impl<'a> Renders<'a> {
    pub(super) fn of(folder: &'a Folder) -> Self {
        Self { folder, known: BTreeMap::new() }
    }

    /// Compares a page's rendering with that of these arguments, where that shows anything but its background.
    pub(super) fn against(&mut self, rendering: &LinearImage, arguments: &[&str]) -> ImageDifference {
        let draw = || {
            let (width, height) = (rendering.width, rendering.height);
            let size = format!("{width}x{height}");
            let words = [&["render"], arguments, &["--size", &size, "-o", "expected.png"]].concat();
            self.folder.run(&words).succeeded();
            linear(&self.folder.read("expected.png"))
        };
        against_image(rendering, self.known.entry(arguments.join(" ")).or_insert_with(draw))
    }
}

/// Compares a page's rendering with an image, where that shows anything but its background.
pub(super) fn against_image(rendering: &LinearImage, expected: &LinearImage) -> ImageDifference {
    let background = expected.pixels[0];
    let coverage: Vec<f32> = expected.pixels.iter().map(|pixel| f32::from(u8::from(*pixel != background))).collect();
    assert!(coverage.iter().sum::<f32>() > (coverage.len() / 8) as f32);
    let expected = LinearImage { coverage, ..expected.clone() };
    let shown = LinearImage { coverage: vec![0.0; rendering.pixels.len()], ..rendering.clone() };
    compare_images(&shown, &expected, 1.0)
}

pub(super) const APIS: [(&str, &str); 2] = [("webgl2", "WebGL 2"), ("webgpu", "WebGPU")];

/// Packs of BRDFs on every scene; another pack gives a different result.
#[test]
fn balls_cloths_and_teapots_are_those_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let red = brdfc_testing::testdata("demo/red_plastic.binary");
    let ward = "synth:ward?kd=0.2,0.15,0.1&ax=0.1&ay=0.4";
    folder.run(&["encode", &red, "-o", "table.ktx2"]).succeeded();
    folder.run(&["encode", ward, "-o", "anisotropic.ktx2"]).succeeded();
    folder.run(&["encode", ward, "--codec", "wavelet", "-o", "wavelet.ktx2"]).succeeded();
    folder.run(&["encode", ward, "--codec", "wavelet", "--bits", "12", "-o", "fine.ktx2"]).succeeded();
    let packs = ["table.ktx2", "anisotropic.ktx2", "wavelet.ktx2", "fine.ktx2"];
    folder.run(&[&["view"], &packs[..], &["-o", "view.html"]].concat()).succeeded();
    // Wavelet packs take a software driver seconds each.
    let cases = [
        ("table.ktx2", "sphere"),
        ("anisotropic.ktx2", "sphere"),
        ("anisotropic.ktx2", "cloth"),
        ("table.ktx2", "teapot"),
        ("table.ktx2", "plane"),
        ("wavelet.ktx2", "sphere"),
        ("fine.ktx2", "sphere"),
    ];
    let number = |pack: &str| packs.iter().position(|other| *other == pack).unwrap();
    let changes: Vec<Value> =
        cases.iter().map(|(pack, scene)| json!({ "scene": scene, "left": number(pack), "right": -1 })).collect();
    let mut renders = Renders::of(&folder);
    for (api, name) in APIS {
        let Some(found) = seen(&folder.text("view.html"), SQUARE, api, &changes) else { return };
        assert_eq!(found.api, name);
        println!(
            "view, {name}: the first rendering stood after {:.0} ms, {:.1} renderings a second",
            found.first, found.speed
        );
        for ((pack, scene), (rendering, first)) in cases.iter().zip(found.renderings.iter().zip(&found.firsts)) {
            let difference = renders.against(rendering, &[pack, "--scene", scene]);
            let of_first = renders.against(first, &[pack, "--scene", scene, "--samples", "1"]);
            println!(
                "view, {name}: {pack} on {scene}: ΔE {:.3}, of a first rendering {:.3}",
                difference.delta_e.mean, of_first.delta_e.mean
            );
            assert!(difference.delta_e.mean < BOUND, "{pack} on {scene}: {:?}", difference.delta_e);
            assert!(of_first.delta_e.mean < BOUND, "first, {pack} on {scene}: {:?}", of_first.delta_e);
        }
        // Another material is detected.
        let other = renders.against(&found.renderings[1], &["table.ktx2"]);
        assert!(other.delta_e.mean > 5.0, "{:?}", other.delta_e);
    }
}

/// The first rendering of a large page has the exposure of only some of its pixels.
#[test]
fn a_large_first_rendering_is_that_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let red = brdfc_testing::testdata("demo/red_plastic.binary");
    folder.run(&["encode", &red, "-o", "table.ktx2"]).succeeded();
    folder.run(&["view", "table.ktx2", "-o", "view.html"]).succeeded();
    let scenes = ["sphere", "teapot"];
    let changes = scenes.map(|scene| json!({ "scene": scene }));
    // Not narrower than high: a page fits a narrow window, `render` always fits the height.
    let Some(found) = seen(&folder.text("view.html"), [512, 512], "webgl2", &changes) else { return };
    let mut renders = Renders::of(&folder);
    for (scene, (rendering, first)) in scenes.iter().zip(found.renderings.iter().zip(&found.firsts)) {
        let words = ["table.ktx2", "--scene", scene];
        let fine = renders.against(rendering, &words).delta_e.mean;
        let of_first = renders.against(first, &[&words[..], &["--samples", "1"]].concat()).delta_e.mean;
        println!("view, 512 x 512: {scene}: ΔE {fine:.3}, of a first rendering {of_first:.3}");
        assert!(fine < BOUND && of_first < BOUND, "{scene}: {fine} {of_first}");
        // They are different renderings: fewer samples, another exposure.
        assert!(rendering.pixels != first.pixels);
    }
}

/// Prints the time of the first rendering, and renderings per second of a flat BTF at 512 x 512 pixels.
#[test]
#[ignore = "it prints times"]
fn first_renderings() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "-o", "table.ktx2"]).succeeded();
    folder.run(&["flatten", "synth:button", "-o", "button"]).succeeded();
    for (input, scenes) in [("table.ktx2", &["sphere"][..]), ("button", &["plane", "teapot"])] {
        folder.run(&["view", input, "-o", "view.html"]).succeeded();
        let speed = |scene: &&str| {
            json!(format!("await brdfcView.set({{ scene: '{scene}' }}); return [await brdfcView.speed(10)];"))
        };
        let changes: Vec<Value> = scenes.iter().map(speed).collect();
        for api in ["webgl2", "webgpu"] {
            let Some(found) = seen(&folder.text("view.html"), [512, 512], api, &changes) else { return };
            println!("{input}, {}: the first rendering stood after {:.0} ms", found.api, found.first);
            for (scene, speed) in scenes.iter().zip(&found.results) {
                println!("{input} on {scene}, {}: {:.1} renderings a second", found.api, speed[0].as_f64().unwrap());
            }
        }
    }
}

/// A page whose driver fails continues with WebGL 2, also while another option is being selected.
#[test]
fn a_driver_that_gives_up_is_replaced() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "-o", "a.ktx2"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.35", "-o", "b.ktx2"]).succeeded();
    folder.run(&["view", "a.ktx2", "b.ktx2", "-o", "view.html"]).succeeded();
    let page = folder.text("view.html").replacen(
        "<head>",
        "<head><script>
             if (globalThis.GPUAdapter) {
                 const { requestDevice } = GPUAdapter.prototype;
                 GPUAdapter.prototype.requestDevice = async function (...words) {
                     globalThis.lentDevice = await requestDevice.apply(this, words);
                     return lentDevice;
                 };
             }</script>",
        1,
    );
    let lost = |what: &str| {
        json!(format!(
                "const before = document.getElementById('canvas');
                 brdfcView.set({{ scene: 'teapot' }}).catch(() => undefined);
                 {what}
                 const end = performance.now() + 20000;
                 const isOld = () => document.getElementById('canvas') === before || !document.getElementById('wrong').hidden;
                 while (isOld() && performance.now() < end) {{ await new Promise((done) => setTimeout(done, 50)); }}
                 await brdfcView.set({{}});
                 const {{ mean, pixels }} = await brdfcView.measure();
                 return [document.getElementById('api').textContent, document.getElementById('wrong').hidden, mean, pixels];"
            ))
    };
    for (api, what) in [
        ("webgpu", "lentDevice.destroy();"),
        ("webgl2", "before.getContext('webgl2').getExtension('WEBGL_lose_context').loseContext();"),
    ] {
        let Some(found) = seen(&page, SQUARE, api, &[lost(what)]) else { return };
        println!("view, {api}: {}", found.results[0]);
        assert_eq!((&found.results[0][0], &found.results[0][1]), (&json!("WebGL 2"), &json!(true)), "{api}");
        assert!(found.results[0][2].as_f64().unwrap() > 0.05 && found.results[0][3].as_u64().unwrap() > 1250, "{api}");
    }
}

/// The difference of two packs on the page agrees with renderings of both.
#[test]
fn differences_are_those_of_the_renderings() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "-o", "a.ktx2"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.35", "-o", "b.ktx2"]).succeeded();
    folder.run(&["view", "a.ktx2", "b.ktx2", "-o", "view.html"]).succeeded();
    let changes =
        [json!({ "split": 1 }), json!({ "split": 0 }), json!({ "split": 0.5 }), json!({ "mode": "difference" })];
    let Some(found) = seen(&folder.text("view.html"), SQUARE, "webgl2", &changes) else { return };
    let [a, b, split, difference] = &found.renderings[..] else { panic!("four renderings") };
    let background = a.pixels[0];
    let covered = |image: &LinearImage| {
        let coverage = image.pixels.iter().map(|pixel| f32::from(u8::from(*pixel != background))).collect();
        LinearImage { coverage, ..image.clone() }
    };
    let apart = compare_images(&covered(a), &covered(b), 1.0).delta_e;
    let report = &found.measured[0];
    println!("view: ΔE {} as the page says, {:.3} of its renderings", report["mean"], apart.mean);
    assert!(apart.mean > 0.1 && (report["mean"].as_f64().unwrap() - apart.mean).abs() < 0.1);
    assert!((report["p95"].as_f64().unwrap() - apart.p95).abs() < 0.3);
    for row in 0..SIDE {
        let range = SIDE * row..SIDE * (row + 1);
        let ([left, _], [_, right]) = (halves(&a.pixels[range.clone()]), halves(&b.pixels[range.clone()]));
        assert!(split.pixels[range].iter().eq(left.iter().chain(right)), "row {row}");
    }
    // Nothing is compared outside the ball; on it, equal pixels are dark.
    assert_eq!(difference.pixels[0], background);
    assert!(difference.pixels.iter().any(|pixel| pixel.iter().sum::<f32>() < 0.1));
    assert!(difference.pixels != split.pixels);
}

/// The controls, used as by hand, and directions that one of both packs does not cover.
#[test]
fn controls_do_what_they_say() {
    let folder = Folder::new();
    folder.write(
        "scene.toml",
        "[materials.high]\nsource = \"synth:ggx?alpha=0.3\"\n\
             [[uses]]\nmaterial = \"high\"\nview_elevation = [40, 90]\n",
    );
    folder.run(&["build", "scene.toml", "--out", "packs"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "-o", "<!--<script>.ktx2"]).succeeded();
    folder.run(&["view", "packs", "--no-sources", "<!--<script>.ktx2", "-o", "view.html"]).succeeded();
    // A script that would become the page's own if names were not escaped, and each control with its effect.
    let slider = |name: &str, value: f64| {
        json!(format!(
            "const slider = document.querySelector('input[name={name}]'); slider.value = {value}; \
                 slider.dispatchEvent(new Event('input', {{ bubbles: true }})); return brdfcView.state.{name};"
        ))
    };
    let press = |key: &str| {
        json!(format!(
            "document.getElementById('canvas').dispatchEvent(new KeyboardEvent('keydown', {{ key: '{key}', bubbles: true }})); \
                 return [brdfcView.state.turn.yaw, brdfcView.state.zoom];"
        ))
    };
    let drag = json!(
        "const canvas = document.getElementById('canvas'); canvas.setPointerCapture = () => {};
             const event = (name, x, more) => canvas.dispatchEvent(
                 new PointerEvent(name, { clientX: x, clientY: 100, bubbles: true, pointerId: 1, ...more }));
             event('pointerdown', 100, { buttons: 1 });
             event('pointermove', 150, { buttons: 1, shiftKey: true });
             event('pointerup', 150, {});
             return brdfcView.state.light.yaw;"
    );
    let pinch = json!(
            "const canvas = document.getElementById('canvas'); canvas.setPointerCapture = () => {};
             const event = (name, pointerId, x) => canvas.dispatchEvent(
                 new PointerEvent(name, { clientX: x, clientY: 100, bubbles: true, pointerId, buttons: 1, pointerType: 'touch' }));
             const { zoom, turn } = brdfcView.state;
             event('pointerdown', 7, 100); event('pointerdown', 8, 150); event('pointermove', 8, 200);
             event('pointerup', 7, 100); event('pointerup', 8, 200);
             const found = [brdfcView.state.zoom / zoom, brdfcView.state.turn.yaw - turn.yaw];
             brdfcView.state.zoom = zoom;
             return found;"
        );
    let point = json!(
        "await brdfcView.set({}); await brdfcView.measure();
             document.getElementById('canvas').dispatchEvent(
                 new PointerEvent('pointermove', { clientX: 64, clientY: 64, bubbles: true, buttons: 0 }));
             await brdfcView.measure();
             return [document.getElementById('here').textContent, await brdfcView.measure()];"
    );
    let changes = [
        slider("split", 0.25),
        slider("stops", 1.0),
        press("ArrowLeft"),
        press("+"),
        drag,
        pinch,
        press("-"),
        slider("stops", 0.0),
        point,
    ];
    let Some(found) = seen(&folder.text("view.html"), SQUARE, "webgl2", &changes) else { return };
    let [split, stops, turned, nearer, lit, pinched, _, _, pointed] = &found.results[..] else {
        panic!("{:?}", found.results)
    };
    assert_eq!((split, stops), (&json!(0.25), &json!(1)));
    assert!(turned[0].as_f64().unwrap() > 0.05 && nearer[1].as_f64().unwrap() > 1.05 && lit.as_f64().unwrap() > 0.3);
    assert_eq!(pinched, &json!([2, 0]));
    let here = pointed[0].as_str().unwrap();
    assert!(here.starts_with("ΔE here: ") && here[10..].trim().parse::<f64>().is_ok(), "{here}");
    // The rim of the ball, which one of both does not cover, does not count.
    let (mean, pixels) = (pointed[1]["mean"].as_f64().unwrap(), pointed[1]["pixels"].as_u64().unwrap());
    println!("view: ΔE {mean:.3} over {pixels} pixels of a pack for high views");
    assert!(mean < 0.2 && (1250..7500).contains(&pixels), "{mean} {pixels}");
}

fn halves(row: &[[f32; 3]]) -> [&[[f32; 3]]; 2] {
    let (left, right) = row.split_at(SIDE / 2);
    [left, right]
}

#[test]
fn flat_btfs_and_renderings_under_light_are_those_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let small = ["--texels", "64", "--views", "grid:3x8@60", "--lights", "grid:3x8@60"];
    for (name, form, relief) in [("button", "factors", "layers"), ("brdf", "brdf", "layers"), ("map", "brdf", "vdim")] {
        let flat = ["flatten", "synth:button?resolution=48", "-o", name, "--reflectance", form, "--relief", relief];
        folder.run(&[&flat[..], &small].concat()).succeeded();
    }
    folder.run(&["pwt", "button", "-o", "view.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert?kd=0.5", "-o", "table.ktx2"]).succeeded();
    folder.run(&["encode", "synth:lambert?kd=0.5", "--codec", "wavelet", "-o", "wavelet.ktx2"]).succeeded();
    let lobes = ["encode", "synth:lambert?kd=0.5", "--codec", "lobes", "--max-fetches", "1", "-o", "lobes.ktx2"];
    folder.run(&lobes).succeeded();
    let all = ["button", "view.ktx2", "table.ktx2", "wavelet.ktx2", "brdf", "lobes.ktx2", "map"];
    let report = folder.run(&[&["view"], &all[..], &["-o", "view.html", "--json"]].concat()).succeeded().json();
    let alone = report["bytes_alone"].as_u64().unwrap();
    println!("view: {} KiB are the page's own, with packs of all five kinds", alone >> 10);
    // Views of trees take 12 KiB of them.
    assert!(alone < 320 << 10);
    let cases = [
        ("button", "plane"),
        ("button", "teapot"),
        ("view.ktx2", ""),
        ("brdf", "plane"),
        ("map", "plane"),
        ("map", "teapot"),
    ];
    let changes = [
        json!({ "scene": "plane", "left": 0, "right": -1 }),
        json!({ "scene": "teapot" }),
        json!({ "left": 1 }),
        json!({ "scene": "plane", "left": 4 }),
        json!({ "left": 6 }),
        json!({ "scene": "teapot" }),
    ];
    let mut renders = Renders::of(&folder);
    for (api, name) in APIS {
        let Some(found) = seen(&folder.text("view.html"), SQUARE, api, &changes) else { return };
        assert_eq!(found.api, name);
        for (k, (input, scene)) in cases.iter().enumerate() {
            // On a plane, `brdfc render` sets the exposure for the surface itself, which the page does not have.
            let exposure = format!("{:.4}", found.exposures[k]);
            let scene_of = if scene.is_empty() { vec![] } else { vec!["--scene", *scene] };
            let words = [&[*input, "--exposure", &exposure][..], &scene_of].concat();
            let difference = renders.against(&found.renderings[k], &words);
            println!("view, {name}: {input} {scene}: ΔE {:.3}", difference.delta_e.mean);
            // Displacements jump at outlines of the relief. On a curved surface, last bits of directions decide on which side a
            // pixel is: more often than through layers.
            let bound = if (*input, *scene) == ("map", "teapot") { 2.0 * BOUND } else { BOUND };
            assert!(difference.delta_e.mean < bound, "{input} {scene}: {:?}", difference.delta_e);
        }
        // Another surface is detected.
        let other = renders.against(&found.renderings[1], &["button", "--scene", "plane", "--exposure", "1"]);
        assert!(other.delta_e.mean > 5.0, "{:?}", other.delta_e);
    }
}
