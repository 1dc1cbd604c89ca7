//! Small renderings of the contents of a flat BTF.

use super::{FlatMaterial, draw_on_cpu};
use crate::rendering::{Panel, heat_map, to_panel};
use crate::scene::Frame;
use crate::scenes::Builtin;
use brdfc_formats::direction::Vector;
use brdfc_formats::flat_btf::StoredReflectance;
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf_trees::FlatTrees;
use brdfc_metrics::image::{LinearImage, auto_exposure};

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

/// Draws all renderings on the CPU.
pub fn flat_renderings(material: &FlatMaterial) -> FlatRenderings {
    FlatRenderings { tile: tile(material), texels: texels(material), scenes: scenes(material) }
}

fn tile(material: &FlatMaterial) -> Vec<FlatRendering> {
    let decoder = material.decoder();
    let along = [0.0, 0.0, 1.0];
    let side = direction(SLANTED, 0.0);
    let lit = |view: Vector, light: Vector| {
        let image = colours(|uv| material.value(uv.map(|c| c as f32), 0.0, view, light).map(f64::from));
        to_panel(&image, auto_exposure(&image))
    };
    let single = |v: Vector| v.map(|c| c as f32);
    let heights = field(|uv| decoder.seen(uv.map(|c| c as f32), single(along), 0.0).0.rise);
    let [low, high] = ends(&heights);
    let above_lowest: Vec<f32> = heights.iter().map(|height| height - low).collect();
    let rendering = |caption: String, panel: Panel| FlatRendering { caption, panel };
    vec![
        rendering("seen and lit along the normal".to_owned(), lit(along, along)),
        rendering(format!("lit from {:.0}°", LIT_FROM[0]), lit(along, direction(LIT_FROM[0], LIT_FROM[1]))),
        rendering(format!("seen from {SLANTED:.0}°"), lit(side, along)),
        rendering("heights: dark low to light high".to_owned(), scaled(&above_lowest, f64::from(high - low))),
    ]
}

fn texels(material: &FlatMaterial) -> Vec<FlatRendering> {
    match &material.decoder().parts().reflectance {
        StoredReflectance::Factors(factors) => texels_of_factors(factors),
        StoredReflectance::Trees(trees) => texels_of_trees(trees),
    }
}

/// Values of trees, before shadows that the relief adds.
fn texels_of_trees(trees: &FlatTrees) -> Vec<FlatRendering> {
    let along = [0.0, 0.0, 1.0];
    let side = direction(SLANTED, 0.0);
    let rendering = |caption: String, view: Vector, light: Vector| {
        let [view, light] = [view, light].map(|v| v.map(|c| c as f32));
        let image = colours(|uv| trees.value(uv.map(|c| c as f32), 0.0, view, light).map(f64::from));
        FlatRendering { caption, panel: to_panel(&image, auto_exposure(&image)) }
    };
    vec![
        rendering("seen and lit along the normal".to_owned(), along, along),
        rendering(format!("lit from {:.0}°", LIT_FROM[0]), along, direction(LIT_FROM[0], LIT_FROM[1])),
        rendering(format!("seen from {SLANTED:.0}°"), side, along),
    ]
}

fn texels_of_factors(reflectance: &FactoredFlatBtf) -> Vec<FlatRendering> {
    let base = |uv: [f64; 2]| *reflectance.filtered(uv.map(|c| c as f32), 0.0).base();
    let normals = bytes(|uv| base(uv).normal.map(|c| (255.0 * (0.5 + 0.5 * f64::from(c))).round() as u8));
    let diffuse = colours(|uv| base(uv).diffuse.map(f64::from));
    let gloss = field(|uv| base(uv).gloss);
    let most = ends(&gloss)[1];
    let (colour, number) = match reflectance.header().materials {
        0 => ("diffuse albedo", "gloss"),
        _ => ("tint", "share of the second material"),
    };
    let mut renderings = vec![
        FlatRendering { caption: "normals: x red, y green, z blue".to_owned(), panel: normals },
        FlatRendering { caption: colour.to_owned(), panel: to_panel(&diffuse, 1.0) },
    ];
    if most > 0.0 {
        let caption = format!("{number}: dark 0 to light {most:.2}");
        renderings.push(FlatRendering { caption, panel: scaled(&gloss, f64::from(most)) });
    }
    renderings
}

fn scenes(material: &FlatMaterial) -> Vec<FlatRendering> {
    let rendering = |caption: String, panel: Panel| FlatRendering { caption, panel };
    let mut renderings = Vec::new();
    for builtin in [Builtin::Plane, Builtin::Vase] {
        let scene = builtin.scene();
        let drawn = draw_on_cpu(&scene, FRAME, material);
        let exposure = auto_exposure(&drawn);
        renderings.push(rendering(builtin.name().to_owned(), to_panel(&drawn, exposure)));
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
    use brdfc_formats::flat_btf::factored::{
        BaseTable, BasisMap, ChromaRange, FactoredErrors, FactoredFlatBtf, FactoredHeader, WeightMap, WeightRange,
        slope_ranges, slope_words,
    };
    use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, LayerHeader, LayerMap};

    /// A step of the relief, whose texels left of the middle are low and red, the others high and blue.
    fn renderings() -> FlatRenderings {
        let header = FactoredHeader {
            size: 4,
            levels: 1,
            groups: 0,
            wide_groups: 0,
            residual: 0,
            views: Vec::new(),
            lights: Vec::new(),
            chroma: ChromaRange::ALL,
            materials: 0,
            axes: 0,
            table_levels: 1,
            albedos: [[0.0; 3]; 2],
            steps: [Vec::new(), Vec::new(), Vec::new()],
            errors: FactoredErrors::default(),
        };
        let basis = BasisMap::from_steps(header, &BaseTable::black(), |_, _, _, _| 0).unwrap();
        let colours = (0..16).flat_map(|k| if k % 4 < 2 { [204, 0, 0, 255] } else { [0, 0, 204, 0] });
        let up = slope_words([0.0, 0.0, 1.0]).map(u16::to_be_bytes).concat();
        let texels = colours.chain(up.iter().copied().cycle().take(64)).collect();
        let albedo = WeightRange { scale: 1.0, low: 0.0 };
        let weights = WeightMap::new(4, 1, [[albedo; 4], slope_ranges()].concat(), texels).unwrap();
        let reflectance = FactoredFlatBtf::new(basis, weights, None).unwrap();
        let layers = LayerHeader { size: 4, sheets: 1, levels: 1, heights: [0.0, 0.2] };
        let heights = (0..16).map(|k| if k % 4 < 2 { 0 } else { 255 }).collect();
        let layers = LayerMap::new(layers, heights, vec![[0.0; 2]; 4]).unwrap();
        let decoder = FlatBtfDecoder::new(FlatBtfParts::new(layers, reflectance));
        flat_renderings(&FlatMaterial::new(decoder, 4).unwrap())
    }

    fn pixel(panel: &Panel, [x, y]: [usize; 2]) -> [u8; 3] {
        let start = 3 * (y * panel.width + x);
        panel.rgb[start..start + 3].try_into().unwrap()
    }

    #[test]
    fn texels_are_at_their_parameters() {
        let renderings = renderings();
        let [_, diffuse, gloss] = renderings.texels.as_slice() else { panic!("{}", renderings.texels.len()) };
        let halves = [[SIDE / 4, SIDE / 2], [3 * SIDE / 4, SIDE / 2]];
        let [red, blue] = halves.map(|at| pixel(&diffuse.panel, at));
        assert!(red[0] > 200 && red[2] == 0 && blue[2] > 200 && blue[0] == 0, "{red:?} {blue:?}");
        let scale = heat_map(&[0.0, 1.0], 2, 1, 1.0).rgb;
        let ends = halves.map(|at| pixel(&gloss.panel, at));
        assert!(ends[0] == scale[3..] && ends[1] == scale[..3], "{ends:?}");
        // Heights of the tile are seen from above.
        let heights = halves.map(|at| pixel(&renderings.tile[3].panel, at));
        assert!(heights[0] == scale[..3] && heights[1] == scale[3..], "{heights:?}");
    }

    #[test]
    fn every_rendering_has_its_size_and_shows_something() {
        let renderings = renderings();
        assert_eq!([renderings.tile.len(), renderings.texels.len(), renderings.scenes.len()], [4, 3, 2]);
        let of_texels = renderings.texels.iter().skip(1);
        for rendering in renderings.tile.iter().chain(of_texels).chain(&renderings.scenes) {
            let Panel { width, height, rgb } = &rendering.panel;
            assert_eq!([*width, *height, rgb.len()], [SIDE, SIDE, 3 * SIDE * SIDE], "{}", rendering.caption);
            assert!(rgb.iter().any(|byte| *byte != rgb[0]), "{} is of one colour", rendering.caption);
        }
    }
}
