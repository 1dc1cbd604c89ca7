//! Lobes on a page in a browser, compared with `brdfc render` and with the environment.

use super::drawn::{APIS, BOUND, Renders, SIDE, SQUARE, seen};
use crate::cli::environment::room;
use crate::common::cli::Folder;
use brdfc_formats::environment::{EnvironmentDecoder, EnvironmentPack};
use brdfc_metrics::image::LinearImage;
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use brdfc_testing::browser::{result_of_page, with_script};
use serde_json::json;
use std::f64::consts::{FRAC_PI_2, PI};

fn packs(folder: &Folder) {
    room(folder, "room.exr", 0);
    folder.run(&["environment", "room.exr", "-o", "room.env.ktx2"]).succeeded();
    for (name, model) in [("glossy.ktx2", "synth:ggx?kd=0.1,0.2,0.4&alpha=0.2"), ("matte.ktx2", "synth:lambert?kd=0.6")]
    {
        folder.run(&["encode", model, "--codec", "lobes", "-o", name]).succeeded();
    }
    let view = ["view", "glossy.ktx2", "matte.ktx2", "--environment", "room.env.ktx2", "-o", "view.html"];
    folder.run(&view).succeeded();
}

#[test]
fn lobes_are_those_of_render_in_any_rotation() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    packs(&folder);
    for quarters in 1..4 {
        room(&folder, &format!("room{quarters}.exr"), quarters);
    }
    let cases = [(0, "sphere", 0), (0, "sphere", 1), (0, "teapot", 2), (1, "cloth", 3), (1, "plane", 0)];
    let light = |quarters: u32| json!({ "yaw": f64::from(quarters) * FRAC_PI_2, "pitch": 0.3 });
    // `render` draws no background.
    let changes = cases.map(|(left, scene, quarters)| {
        json!({ "left": left, "right": -1, "scene": scene, "light": light(quarters), "behind": false })
    });
    let mut renders = Renders::of(&folder);
    for (api, name) in APIS {
        let Some(found) = seen(&folder.text("view.html"), SQUARE, api, &changes) else { return };
        assert_eq!(found.api, name);
        for (k, (left, scene, quarters)) in cases.into_iter().enumerate() {
            let pack = ["glossy.ktx2", "matte.ktx2"][left];
            let room = if quarters == 0 { "room.env.ktx2".to_owned() } else { format!("room{quarters}.exr") };
            let exposure = format!("{:.5}", found.exposures[k]);
            let words = [pack, "--environment", &room, "--scene", scene, "--exposure", &exposure];
            let difference = renders.against(&found.renderings[k], &words).delta_e;
            println!("view, {name}: {pack} on {scene}, {quarters} quarter turns: ΔE {:.3}", difference.mean);
            assert!(difference.mean < BOUND, "{pack} on {scene}, {quarters}: {difference:?}");
        }
        // The opposite rotation is detected.
        let exposure = format!("{:.5}", found.exposures[1]);
        let words = ["glossy.ktx2", "--environment", "room3.exr", "--scene", "sphere", "--exposure", &exposure];
        let other = renders.against(&found.renderings[1], &words).delta_e;
        assert!(other.mean > 5.0, "{other:?}");
    }
}

/// Displayed values of pixels of an image's border, from radiance in their directions.
fn border(decoder: &EnvironmentDecoder, exposure: f64, angle: f64) -> Vec<(usize, [f64; 3])> {
    let frame = Frame { width: SIDE, height: SIDE, samples: 1 };
    let camera = Builtin::Sphere.scene().camera;
    let (c, s) = (angle.cos(), angle.sin());
    let at = |pixel: usize| {
        let [x, y, z] = camera.ray(frame, (pixel % SIDE) as f64 + 0.5, (pixel / SIDE) as f64 + 0.5);
        let direction = [c * x - s * z, y, s * x + c * z].map(|c| c as f32);
        let sharpest = decoder.header().sharpest() as f32;
        (pixel, decoder.radiance(direction, sharpest).map(|c| (f64::from(c) * exposure).min(1.0)))
    };
    (0..SIDE).chain(SIDE * (SIDE - 1)..SIDE * SIDE).map(at).collect()
}

/// Mean difference of the border of a rendering, linear.
fn apart(rendering: &LinearImage, border: &[(usize, [f64; 3])]) -> f64 {
    let of = |(pixel, expected): &(usize, [f64; 3])| -> f64 {
        (0..3).map(|k| (f64::from(rendering.pixels[*pixel][k]) - expected[k]).abs()).sum::<f64>() / 3.0
    };
    border.iter().map(of).sum::<f64>() / border.len() as f64
}

/// The environment itself is behind the surface, and its controls turn and hide it.
#[test]
fn the_environment_is_behind_lobes() {
    let folder = Folder::new();
    packs(&folder);
    folder
        .run(&["view", "glossy.ktx2", "synth:lambert?kd=0.5", "--environment", "room.env.ktx2", "-o", "mixed.html"])
        .succeeded();
    let decoder = EnvironmentDecoder::new(&EnvironmentPack::from_bytes(&folder.read("room.env.ktx2")).unwrap());
    let slide = json!(
        "const slider = document.querySelector('input[name=rotation]'); slider.value = 90;
         slider.dispatchEvent(new Event('input', { bubbles: true }));
         return [brdfcView.state.light.yaw, document.getElementById('environment').hidden];"
    );
    let drag = json!(
        "const canvas = document.getElementById('canvas'); canvas.setPointerCapture = () => {};
         const event = (name, x, more) => canvas.dispatchEvent(
             new PointerEvent(name, { clientX: x, clientY: 100, bubbles: true, pointerId: 1, ...more }));
         event('pointerdown', 100, { buttons: 2 });
         event('pointermove', 50, { buttons: 2 });
         event('pointerup', 50, {});
         return [brdfcView.state.light.yaw, Number(document.querySelector('input[name=rotation]').value)];"
    );
    let hide =
        json!("const box = document.querySelector('input[name=behind]'); box.click(); return brdfcView.state.behind;");
    let address = json!(
        "const done = new Promise((resolve) => addEventListener('hashchange', resolve, { once: true }));
         location.hash = 'embed&light=-90&scene=sphere'; await done; return brdfcView.state.light.yaw;"
    );
    let changes = [
        json!({ "right": -1 }),
        slide,
        json!({}),
        drag,
        json!({}),
        address,
        json!({}),
        hide,
        json!({}),
        json!({ "right": 1, "behind": true }),
    ];
    for (api, name) in APIS {
        let Some(found) = seen(&folder.text("view.html"), SQUARE, api, &changes) else { return };
        let [slid, dragged, addressed, hidden] = &found.results[..] else { panic!("{:?}", found.results) };
        let yaw = dragged[0].as_f64().unwrap();
        assert_eq!((slid, hidden), (&json!([FRAC_PI_2, false]), &json!(false)));
        assert!(yaw < 1.3 && (dragged[1].as_f64().unwrap() - yaw.to_degrees()).abs() < 0.51, "{dragged}");
        assert_eq!(addressed.as_f64().unwrap(), -FRAC_PI_2);
        for (k, angle) in [0.0, FRAC_PI_2, yaw, -FRAC_PI_2].into_iter().enumerate() {
            let [right, wrong] = [angle, angle + PI]
                .map(|angle| apart(&found.renderings[k], &border(&decoder, found.exposures[k], angle)));
            println!("view, {name}: background at {angle:.2}: {right:.4}, half a turn off {wrong:.4}");
            assert!(right < 0.004 && wrong > 0.03, "{angle}: {right} {wrong}");
        }
        // Without it, the background has one colour.
        let [.., bare, pair] = &found.renderings[..] else { panic!("six renderings") };
        assert!((0..SIDE).all(|k| bare.pixels[k] == bare.pixels[0]));
        // It is behind both of a pair.
        let border = border(&decoder, found.exposures[5], -FRAC_PI_2);
        assert!(apart(pair, &border) < 0.004);
    }
    // Materials under different lights are not compared.
    let both = json!(
        "const option = document.querySelector('select[name=right] option[value=\"1\"]');
         const before = [brdfcView.state.right, option.disabled];
         await brdfcView.set({ left: 1 });
         return [...before, document.getElementById('environment').hidden];"
    );
    let Some(found) = seen(&folder.text("mixed.html"), SQUARE, "webgl2", &[both, json!({})]) else { return };
    assert_eq!(found.results[0], json!([-1, true, true]));
    assert!((0..SIDE).all(|k| found.renderings[0].pixels[k] == found.renderings[0].pixels[0]));
}

/// A device whose cube maps are smaller than the environment gets an error, and no black rendering.
#[test]
fn environments_beyond_the_limit_of_cube_maps_are_refused() {
    let folder = Folder::new();
    packs(&folder);
    let page = folder.text("view.html").replacen(
        "<head>",
        "<head><script>
             const { getParameter } = WebGL2RenderingContext.prototype;
             WebGL2RenderingContext.prototype.getParameter = function (name) {
                 return name === this.MAX_CUBE_MAP_TEXTURE_SIZE ? 32 : getParameter.call(this, name);
             };</script>",
        1,
    );
    let script = "
const wrong = document.getElementById('wrong');
const end = performance.now() + 20000;
while (wrong.hidden && performance.now() < end) { await new Promise((done) => setTimeout(done, 50)); }
await fetch('/result', { method: 'POST', body: wrong.textContent });
";
    let page = with_script(&page, SQUARE, "webgl2", script);
    let Some(posted) = result_of_page(&[("", "text/html", page.as_bytes())]) else { return };
    let text = String::from_utf8(posted).unwrap();
    assert!(text.contains("found a texture of 64 x 64 x 6 texels, expected at most 32 along a side"), "{text}");
}
