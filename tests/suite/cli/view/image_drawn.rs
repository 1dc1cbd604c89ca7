//! Images under lights of the page, compared with `brdfc render` and photographs.

use super::drawn::{APIS, BOUND, SQUARE, against_image, linear, seen};
use crate::cli::pwt::stack;
use crate::common::cli::Folder;
use brdfc_metrics::image::LinearImage;
use serde_json::{Value, json};

/// Rendering under a light, and a photograph in the same view.
fn expected(folder: &Folder, photograph: usize, [x, y, z]: [f64; 3]) -> [LinearImage; 2] {
    folder.write("stack/one.lp", format!("1\n{photograph:04}.png {x} {y} {z}\n"));
    let files = ["-o", "rendering.png", "--reference", "photograph.png"];
    let view = ["render", "p.ktx2", "--source", "stack/one.lp", "--exposure", "1", "--size", "128x128"];
    folder.run(&[&view[..], &files].concat()).succeeded();
    ["rendering.png", "photograph.png"].map(|file| linear(&folder.read(file)))
}

fn light([x, y, z]: [f64; 3], brightness: f64) -> Value {
    json!({ "direction": [x, y, z], "brightness": brightness })
}

/// Lights of the capture, from its list.
fn lights_of(folder: &Folder) -> Vec<[f64; 3]> {
    let list = folder.text("stack/dirs.lp");
    let numbers = |line: &str| -> Vec<f64> { line.split(' ').skip(1).map(|word| word.parse().unwrap()).collect() };
    list.lines().skip(1).map(|line| numbers(line).try_into().unwrap()).collect()
}

#[test]
fn images_are_those_of_render_and_photographs_under_any_light() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    folder.run(&["view", "p.ktx2", "stack", "-o", "view.html"]).succeeded();
    let lights = lights_of(&folder);
    // Near the light of one photograph, and opposite.
    let [x, y, z] = lights[22];
    let (a, b) = ([x, y, z], [-x, -y, z]);
    let opposite = |from: &[f64; 3]| from.iter().zip(b).map(|(p, q)| p * q).sum::<f64>();
    let other = (0..lights.len()).max_by(|p, q| opposite(&lights[*p]).total_cmp(&opposite(&lights[*q]))).unwrap();
    let alone = |item: usize, lights: &[Value]| json!({ "left": item, "right": -1, "lights": lights, "chosen": 0 });
    let both = [light(a, 0.5), light(b, 0.4)];
    let changes = [
        alone(0, &[light(a, 1.0)]),
        alone(0, &[light(b, 1.0)]),
        alone(0, &both),
        alone(1, &[light(a, 1.0)]),
        alone(1, &both),
        json!({ "left": 0, "right": 1, "lights": [light(a, 1.0)], "mode": "split" }),
    ];
    let [[lit, photograph], [lit_opposite, of_opposite]] = [expected(&folder, 22, a), expected(&folder, other, b)];
    for (api, name) in APIS {
        let Some(found) = seen(&folder.text("view.html"), SQUARE, api, &changes) else { return };
        assert_eq!(found.api, name);
        assert!(found.exposures.iter().all(|exposure| *exposure == 1.0), "{:?}", found.exposures);
        let [of_a, of_b, sum, photograph_a, photographs, split] = &found.renderings[..] else { panic!("six") };
        let mean = |rendering: &LinearImage, expected: &LinearImage| against_image(rendering, expected).delta_e.mean;
        let near = [(of_a, &lit), (of_b, &lit_opposite), (photograph_a, &photograph)].map(|(p, q)| mean(p, q));
        println!("view, {name}: ΔE {near:.3?} of a light, the opposite one and a photograph");
        // The photograph is a JPEG file.
        assert!(near[0] < BOUND && near[1] < BOUND && near[2] < 3.0 * BOUND, "{near:?}");
        // Other lights are detected, and other photographs.
        assert!(mean(of_a, &lit_opposite) > 5.0 && mean(photograph_a, &of_opposite) > 5.0);
        // Two lights are the sum of both.
        for (sum, [first, second]) in [(sum, [&lit, &lit_opposite]), (photographs, [&photograph, &of_opposite])] {
            let mut expected = first.clone();
            let added = first.pixels.iter().zip(&second.pixels);
            expected.pixels = added.map(|(a, b)| [0, 1, 2].map(|k| 0.5 * a[k] + 0.4 * b[k])).collect();
            // The background is not a sum.
            expected.pixels.iter_mut().zip(&first.pixels).for_each(|(pixel, one)| {
                if *one == first.pixels[0] {
                    *pixel = first.pixels[0];
                }
            });
            let apart = mean(sum, &expected);
            assert!(apart < 3.0 * BOUND && mean(sum, first) > 3.0, "{apart}");
        }
        // The pack is left of the divider, the photograph right of it.
        let columns = |image: &LinearImage, from: usize, to: usize| -> Vec<[f32; 3]> {
            image.pixels.chunks(SQUARE[0]).flat_map(|row| row[from..to].to_vec()).collect()
        };
        assert!(columns(split, 0, 64) == columns(of_a, 0, 64));
        assert!(columns(split, 64, 128) == columns(photograph_a, 64, 128));
        assert!(found_measure(&found) > 0.0);
    }
}

fn found_measure(found: &super::drawn::Seen) -> f64 {
    found.measured.last().unwrap()["mean"].as_f64().unwrap()
}

/// Mouse, keys and the disc of lights, used as by hand.
#[test]
fn the_light_follows_the_mouse() {
    let folder = stack();
    folder.run(&["pwt", "stack", "-o", "p.ktx2"]).succeeded();
    folder.run(&["view", "p.ktx2", "stack", "-o", "view.html"]).succeeded();
    let lights = lights_of(&folder);
    let setup = "
        const canvas = document.getElementById('canvas'); canvas.setPointerCapture = () => {};
        const disc = document.getElementById('disc'); disc.setPointerCapture = () => {};
        const { state } = brdfcView;
        const text = () => document.getElementById('light').textContent;
        const event = (target, name, x, y, more) => target.dispatchEvent(
            new PointerEvent(name, { clientX: x, clientY: y, bubbles: true, pointerId: 1, ...more }));
        const press = (key, more) => canvas.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, ...more }));
        const first = () => state.lights[state.chosen].direction;";
    let script = |text: &str| json!(format!("{setup} {text}"));
    let drag = "event(canvas, 'pointerdown', 60, 60, { buttons: 1 }); event(canvas, 'pointermove', 80, 50, { buttons: 1, MORE });
        event(canvas, 'pointerup', 80, 50, {});";
    let [x, y, _] = lights[9];
    let on_dot = format!(
        "document.body.classList.remove('embedded');
         const box = disc.getBoundingClientRect();
         const at = (x, y) => [box.left + (x / 2.2 + 0.5) * box.width, box.top + (0.5 - y / 2.2) * box.height];
         event(disc, 'pointerdown', ...at({x} + 0.02, {y} - 0.02), {{ buttons: 1 }});
         event(disc, 'pointerup', 0, 0, {{}});
         const found = [first(), text(), document.querySelectorAll('.dot').length, document.querySelectorAll('.dot.used').length];
         event(disc, 'pointermove', ...at(0.1, 0.2), {{ buttons: 1 }});
         found.push(first());
         document.body.classList.add('embedded');
         return found;"
    );
    let changes = [
        script(&format!("const before = first(); {} return [before, first(), state.pan];", drag.replace("MORE", ""))),
        script(&format!(
            "const before = first(); {} return [before, first(), state.pan];",
            drag.replace("MORE", "shiftKey: true")
        )),
        script(
            "const before = first(); press('ArrowRight'); press('ArrowUp'); const after = first();
            press('+'); return [before, after, state.zoom];",
        ),
        script(&on_dot),
        script(
            "for (const id of ['add', 'add']) { document.getElementById(id).click(); }
            const isFull = document.getElementById('add').disabled;
            const slider = document.getElementById('brightness'); slider.value = 1.5;
            slider.dispatchEvent(new Event('input', { bubbles: true }));
            const found = [state.lights.length, isFull, state.chosen, state.lights[2].brightness];
            document.getElementById('remove').click();
            return [...found, state.lights.length];",
        ),
        script(
            "await brdfcView.set({ lights: [{ direction: [0, 0, 1], brightness: 1 }], chosen: 0 });
            for (let k = 0; k < 60; k += 1) { press('ArrowLeft'); } return first();",
        ),
        script(
            "location.hash = '#light=0.3,-0.4;-0.5,0'; await new Promise((done) => setTimeout(done, 100));
            return [state.lights.length, first()];",
        ),
    ];
    let Some(found) = seen(&folder.text("view.html"), SQUARE, "webgl2", &changes) else { return };
    let [dragged, panned, pressed, on_dot, several, at_rim, address] = &found.results[..] else { panic!("seven") };
    let number = |value: &Value| value.as_f64().unwrap();
    let moved = |of: &Value| [0, 1].map(|k| number(&of[1][k]) - number(&of[0][k]));
    let close = |found: [f64; 2], expected: [f64; 2]| found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(moved(dragged), [0.1, 0.05]) && dragged[2] == json!([0, 0]), "{dragged}");
    // The image follows the pointer, and the light stays.
    assert!(
        close(moved(panned), [0.0, 0.0]) && number(&panned[2][0]) < -0.1 && number(&panned[2][1]) > 0.05,
        "{panned}"
    );
    assert!(close(moved(pressed), [0.04, 0.04]) && number(&pressed[2]) > 1.05, "{pressed}");
    assert!(close([number(&on_dot[0][0]), number(&on_dot[0][1])], [x, y]), "{on_dot}");
    let text = on_dot[1].as_str().unwrap();
    assert!(text.contains("Nearest photograph: 0009.png") && text.ends_with("0.0° from the light."), "{text}");
    assert_eq!((&on_dot[2], &on_dot[3]), (&json!(40), &json!(1)));
    assert!(close([number(&on_dot[4][0]), number(&on_dot[4][1])], [0.1, 0.2]), "{on_dot}");
    assert_eq!(*several, json!([3, true, 2, 1.5, 2]));
    assert!((number(&at_rim[0]) + 0.9962).abs() < 1e-3 && number(&at_rim[2]) > 0.08, "{at_rim}");
    assert!(address[0] == 2 && close([number(&address[1][0]), number(&address[1][1])], [0.3, -0.4]), "{address}");
}
