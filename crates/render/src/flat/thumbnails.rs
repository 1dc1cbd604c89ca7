//! Small renderings of the contents of a flat BTF.

use super::{FlatForm, FlatMaterial, draw_on_cpu};
use crate::rendering::{DELTA_E_FULL_SCALE, Panel, difference_panel, heat_map, to_panel};
use crate::scene::Frame;
use crate::scenes::Builtin;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::VisibilityMask;
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};

/// Pixels of a rendering, per side.
pub const SIDE: usize = 160;
/// Samples of a pixel, per side.
const SAMPLES: usize = 2;
/// Polar angle of oblique views, degrees.
const SLANTED: f64 = 60.0;
/// Polar angle and azimuth of oblique light, degrees.
const LIT_FROM: [f64; 2] = [50.0, 135.0];
const FRAME: Frame = Frame { width: SIDE, height: SIDE, samples: SAMPLES };

/// A rendering with its caption.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlatRendering {
    /// Caption of the rendering.
    pub caption: String,
    /// The rendering, 160 pixels per side.
    pub panel: Panel,
}

/// Renderings of one material.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlatRenderings {
    /// Over one tile of the reference plane, u to the right and v down.
    pub tile: Vec<FlatRendering>,
    /// Contents of texels over the parameters, in the same orientation.
    pub texels: Vec<FlatRendering>,
    /// Renderings of curved and flat surfaces that the material covers.
    pub scenes: Vec<FlatRendering>,
}

/// Draws all renderings on the CPU, in the full form if there are views. `mask` says which texels each view sees.
pub fn flat_renderings(material: &FlatMaterial, mask: Option<&VisibilityMask>) -> FlatRenderings {
    FlatRenderings { tile: tile(material), texels: texels(material, mask), scenes: scenes(material) }
}

fn form(material: &FlatMaterial) -> FlatForm {
    if material.has_views() { FlatForm::Full } else { FlatForm::Light }
}

fn tile(material: &FlatMaterial) -> Vec<FlatRendering> {
    let decoder = material.decoder();
    let header = decoder.parts().indirection.header();
    let along = [0.0, 0.0, 1.0];
    let slanted = SLANTED.min(f64::from(header.largest_angle).to_degrees());
    let side = direction(slanted, 0.0);
    let lit = |view: Vector, light: Vector| {
        // A tile is a fraction of the unit of uv.
        let of_tile = |uv: [f64; 2]| uv.map(|c| c / f64::from(material.repeat()));
        let image = colours(|uv| material.value(form(material), of_tile(uv), 0.0, view, light).map(f64::from));
        to_panel(&image, auto_exposure(&image))
    };
    let single = |v: Vector| v.map(|c| c as f32);
    let at = |uv: [f64; 2], view: Vector| decoder.indirection(uv.map(|c| c as f32), single(view));
    let moved = |uv: [f64; 2]| {
        let ([u, v, _], [s, t, _]) = (at(uv, along), at(uv, side));
        let [x, y] = [s - u, t - v].map(|d| d - d.round());
        (x * x + y * y).sqrt()
    };
    let offsets = field(moved);
    let largest = ends(&offsets)[1];
    let rendering = |caption: String, panel: Panel| FlatRendering { caption, panel };
    vec![
        rendering("seen and lit along the normal".to_owned(), lit(along, along)),
        rendering(format!("lit from {:.0}°", LIT_FROM[0]), lit(along, direction(LIT_FROM[0], LIT_FROM[1]))),
        rendering(format!("seen from {slanted:.0}°"), lit(side, along)),
        rendering(
            format!("offsets at {slanted:.0}°: dark 0 to light {largest:.2} in u and v"),
            scaled(&offsets, f64::from(largest)),
        ),
    ]
}

fn texels(material: &FlatMaterial, mask: Option<&VisibilityMask>) -> Vec<FlatRendering> {
    let parts = material.decoder().parts();
    let size = parts.diffuse.size();
    let nearest = |uv: [f64; 2]| uv.map(|c| ((c * f64::from(size)) as u32).min(size - 1));
    let index = |uv: [f64; 2]| {
        let [column, row] = nearest(uv);
        (row * size + column) as usize
    };
    let normals =
        bytes(|uv| parts.normal.normals()[index(uv)].map(|c| (255.0 * (0.5 + 0.5 * f64::from(c))).round() as u8));
    let diffuse = colours(|uv| rgb9e5::decode(parts.diffuse.texels()[index(uv)]).map(f64::from));
    let mut renderings = vec![
        FlatRendering { caption: "normals: x red, y green, z blue".to_owned(), panel: normals },
        FlatRendering { caption: "diffuse colours".to_owned(), panel: to_panel(&diffuse, 1.0) },
    ];
    if let Some(mask) = mask.filter(|mask| mask.size() == size && mask.views() > 0) {
        let seen = field(|uv| {
            let count = (0..mask.views()).filter(|view| mask.is_seen(*view, nearest(uv))).count();
            count as f32 / mask.views() as f32
        });
        let caption = "views that see a texel: dark none to light all".to_owned();
        renderings.push(FlatRendering { caption, panel: scaled(&seen, 1.0) });
    }
    renderings
}

fn scenes(material: &FlatMaterial) -> Vec<FlatRendering> {
    let rendering = |caption: String, panel: Panel| FlatRendering { caption, panel };
    let mut renderings = Vec::new();
    for builtin in [Builtin::Plane, Builtin::Vase] {
        let scene = builtin.scene();
        let drawn = draw_on_cpu(&scene, FRAME, material, form(material));
        let exposure = auto_exposure(&drawn);
        renderings.push(rendering(builtin.name().to_owned(), to_panel(&drawn, exposure)));
        if builtin == Builtin::Vase && material.has_views() {
            let light = draw_on_cpu(&scene, FRAME, material, FlatForm::Light);
            let mean = compare_images(&light, &drawn, exposure).delta_e.mean;
            renderings.push(rendering("vase in the light form".to_owned(), to_panel(&light, exposure)));
            let caption = format!("their difference: ΔE {mean:.2}, dark 0 to light {DELTA_E_FULL_SCALE}");
            renderings.push(rendering(caption, difference_panel(&light, &drawn, exposure)));
        }
    }
    renderings
}

/// A unit vector from polar angle and azimuth in degrees.
fn direction(polar: f64, azimuth: f64) -> Vector {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
}

/// Position of a pixel's middle, 0 to 1.
fn middle(pixel: usize, offset: [f64; 2]) -> [f64; 2] {
    let at = [pixel % SIDE, pixel / SIDE];
    [0, 1].map(|k| (at[k] as f64 + offset[k]) / SIDE as f64)
}

/// Linear colours, averaged over each pixel.
fn colours(value: impl Fn([f64; 2]) -> [f64; 3]) -> LinearImage {
    let offsets = (0..SAMPLES * SAMPLES).map(|k| [k % SAMPLES, k / SAMPLES]);
    let offsets: Vec<[f64; 2]> = offsets.map(|at| at.map(|c| (c as f64 + 0.5) / SAMPLES as f64)).collect();
    let mean = |pixel: usize| {
        let mut sum = [0.0; 3];
        for offset in &offsets {
            let value = value(middle(pixel, *offset));
            (0..3).for_each(|k| sum[k] += value[k] / offsets.len() as f64);
        }
        sum.map(|c| c as f32)
    };
    let pixels: Vec<[f32; 3]> = (0..SIDE * SIDE).map(mean).collect();
    LinearImage { coverage: vec![1.0; pixels.len()], pixels, ..LinearImage::black(SIDE, SIDE) }
}

/// Unconverted bytes at each pixel's middle.
fn bytes(value: impl Fn([f64; 2]) -> [u8; 3]) -> Panel {
    let rgb = (0..SIDE * SIDE).flat_map(|pixel| value(middle(pixel, [0.5; 2])));
    Panel { width: SIDE, height: SIDE, rgb: rgb.collect() }
}

/// Numbers at each pixel's middle.
fn field(value: impl Fn([f64; 2]) -> f32) -> Vec<f32> {
    (0..SIDE * SIDE).map(|pixel| value(middle(pixel, [0.5; 2]))).collect()
}

fn scaled(values: &[f32], full_scale: f64) -> Panel {
    heat_map(values, SIDE, SIDE, full_scale.max(f64::from(f32::MIN_POSITIVE)))
}

fn ends(values: &[f32]) -> [f32; 2] {
    values.iter().fold([f32::MAX, f32::MIN], |[low, high], v| [low.min(*v), high.max(*v)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::flat_btf::{DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatValues};
    use brdfc_testing::codecs::flat_btf::{SMALL, parts};

    const SEEN: [u8; 16] = [255, 255, 0, 0, 255, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

    /// A light form whose texels left of the middle are red, the others blue.
    fn renderings() -> FlatRenderings {
        let half = |k: usize| if k % 4 < 2 { [0.8, 0.0, 0.0] } else { [0.0, 0.0, 0.8] };
        let colours: Vec<[f32; 3]> = (0..16).map(half).collect();
        let diffuse = DiffuseMap::from_colours(4, &colours).unwrap();
        let parts = FlatBtfParts { diffuse, values: FlatValues::None, ..parts(SMALL, 3) };
        let material = FlatMaterial::new(FlatBtfDecoder::new(parts).unwrap(), 4).unwrap();
        let mask = VisibilityMask::new(4, 2, [SEEN, [0; 16]].concat()).unwrap();
        flat_renderings(&material, Some(&mask))
    }

    fn pixel(panel: &Panel, [x, y]: [usize; 2]) -> [u8; 3] {
        let start = 3 * (y * panel.width + x);
        panel.rgb[start..start + 3].try_into().unwrap()
    }

    #[test]
    fn texels_are_at_their_parameters() {
        let renderings = renderings();
        let [_, diffuse, seen] = renderings.texels.as_slice() else { panic!("{}", renderings.texels.len()) };
        let [red, blue] = [[SIDE / 4, SIDE / 2], [3 * SIDE / 4, SIDE / 2]].map(|at| pixel(&diffuse.panel, at));
        assert!(red[0] > 200 && red[2] == 0 && blue[2] > 200 && blue[0] == 0, "{red:?} {blue:?}");
        // One of two views sees the upper left quarter, none the rest.
        let scale = heat_map(&[0.0, 0.5], 2, 1, 1.0).rgb;
        assert_eq!(pixel(&seen.panel, [SIDE / 4, SIDE / 4]), scale[3..]);
        for at in [[3 * SIDE / 4, SIDE / 4], [SIDE / 4, 3 * SIDE / 4]] {
            assert_eq!(pixel(&seen.panel, at), scale[..3]);
        }
    }

    #[test]
    fn every_rendering_has_its_size_and_offsets_reach_both_ends_of_their_scale() {
        let renderings = renderings();
        assert_eq!([renderings.tile.len(), renderings.texels.len(), renderings.scenes.len()], [4, 3, 2]);
        for rendering in renderings.tile.iter().chain(&renderings.texels).chain(&renderings.scenes) {
            let Panel { width, height, rgb } = &rendering.panel;
            assert_eq!([*width, *height, rgb.len()], [SIDE, SIDE, 3 * SIDE * SIDE], "{}", rendering.caption);
            assert!(rgb.iter().any(|byte| *byte != rgb[0]), "{} is of one colour", rendering.caption);
        }
        let lightest = heat_map(&[1.0], 1, 1, 1.0).rgb;
        let offsets = &renderings.tile[3];
        assert!(offsets.caption.starts_with("offsets at 60°: dark 0 to light 0."), "{}", offsets.caption);
        assert!(offsets.panel.rgb.chunks_exact(3).any(|rgb| rgb == lightest));
    }
}
