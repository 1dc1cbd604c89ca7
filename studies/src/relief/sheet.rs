//! A contact sheet of the layers next to the surface: near, far and in motion.

use super::methods::Method;
use super::renderings::{
    AZIMUTHS, DISTANCE, FAR_SAMPLES, FAR_TILES, MOTION, Rendering, SAMPLES, Surface, changes, counted, plane_from,
    share_of_jumps,
};
use brdfc_render::contact_sheet::{Cell, contact_sheet};
use brdfc_render::rendering::{DELTA_E_FULL_SCALE, Panel, difference_panel, heat_map, to_panel};
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::scenes::Builtin;

/// Size of each rendering.
const FRAME: Frame = Frame { width: 176, height: 132, samples: SAMPLES };
/// Share of the usual distance of a camera that is near.
const NEAR: f64 = 0.3;
/// Polar angle of a flat view, degrees.
const FLAT: f64 = 70.0;

/// Draws plane, vase and teapot: as a whole, near, far, in motion and from a low angle. Calls `done` after each.
pub(super) fn sheet(surface: Surface<'_>, layers: &Method<'_>, done: &dyn Fn()) -> Panel {
    let [polar, turn] = MOTION;
    let [azimuth, other, _] = AZIMUTHS;
    let (plane, vase) = (Builtin::Plane.tiles(), Builtin::Vase.tiles());
    let draw = |scene, tiles, samples| surface.drawn(scene, FRAME, tiles, samples);
    let still = |name: &str, scene, tiles, samples| counted(still(name, &draw(scene, tiles, samples), layers), done);
    let moving = |name: &str, scene: &dyn Fn(f64) -> Scene, tiles| {
        counted(moving(name, &[0.0, turn].map(|by| draw(scene(by), tiles, SAMPLES)), layers), done)
    };
    contact_sheet(&[
        still("plane", plane_from(polar, azimuth, DISTANCE), plane, SAMPLES),
        still("vase", Builtin::Vase.scene(), vase, SAMPLES),
        still("plane, near", plane_from(polar, azimuth, NEAR * DISTANCE), plane, SAMPLES),
        still("vase, near", nearer(Builtin::Vase.scene()), vase, SAMPLES),
        still("vase, near, light from the right", mirrored_light(nearer(Builtin::Vase.scene())), vase, SAMPLES),
        still("plane, far", Builtin::Plane.scene(), FAR_TILES, FAR_SAMPLES),
        still("vase, far", Builtin::Vase.scene(), 3 * vase, FAR_SAMPLES),
        moving("plane in motion", &|by| plane_from(polar, azimuth + by, DISTANCE), plane),
        moving("vase in motion", &|by| turned(Builtin::Vase.scene(), by), vase),
        still("plane, flat view", plane_from(FLAT, other, DISTANCE), plane, SAMPLES),
        still("teapot", Builtin::Teapot.scene(), Builtin::Teapot.tiles(), SAMPLES),
    ])
}

/// Number of calls of `done`.
pub(super) const COUNT: usize = 11;

fn still(name: &str, rendering: &Rendering, layers: &Method<'_>) -> Cell {
    let image = rendering.drawn(layers);
    let row = rendering.row(&image);
    let details = format!("ΔE {:.2}, brightness {:.1} %", row.delta_e, 100.0 * row.brightness);
    let (surface, exposure) = (&rendering.surface, rendering.exposure);
    let difference = difference_panel(&image, surface, exposure);
    cell(name, details, [to_panel(surface, exposure), to_panel(&image, exposure), difference])
}

fn moving(name: &str, pair: &[Rendering; 2], layers: &Method<'_>) -> Cell {
    let images = pair.each_ref().map(|rendering| rendering.drawn(layers));
    let changes = changes(pair, &images);
    let details = format!("change of ΔE over 0.5°: {:.1} % jump", 100.0 * share_of_jumps(&changes));
    let (after, exposure) = (&pair[1], pair[0].exposure);
    let change = heat_map(&changes, FRAME.width, FRAME.height, DELTA_E_FULL_SCALE);
    cell(name, details, [to_panel(&after.surface, exposure), to_panel(&images[1], exposure), change])
}

fn cell(name: &str, details: String, panels: [Panel; 3]) -> Cell {
    Cell { name: name.to_owned(), details, failed: false, rows: vec![panels.map(Some)] }
}

/// The same scene from nearer.
fn nearer(mut scene: Scene) -> Scene {
    let camera = &mut scene.camera;
    camera.eye = [0, 1, 2].map(|k| camera.target[k] + NEAR * (camera.eye[k] - camera.target[k]));
    scene
}

/// The same scene with each light on the other side: with the scene before, figure 8 of Hadim et al. 2009.
fn mirrored_light(mut scene: Scene) -> Scene {
    scene.lights.iter_mut().for_each(|light| light.position[0] *= -1.0);
    scene
}

/// The same scene after the camera went around it by an angle in degrees.
fn turned(mut scene: Scene, angle: f64) -> Scene {
    let (sine, cosine) = angle.to_radians().sin_cos();
    let camera = &mut scene.camera;
    let [x, y, z] = [0, 1, 2].map(|k| camera.eye[k] - camera.target[k]);
    let around = [cosine * x + sine * z, y, cosine * z - sine * x];
    camera.eye = [0, 1, 2].map(|k| camera.target[k] + around[k]);
    scene
}
