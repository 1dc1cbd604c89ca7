//! Figures 3, 4, 6, 7 and 9: the parameters of a surface, one view of its flat BTF, and the indirection map of a file.

use super::figures::{SIDE, UNSEEN, magnified};
use brdfc_flat_btf::light_field::{ComputedField, FillGuide, FlattenedView, Holes, visible};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::rebuild::{ViewImage, sample_bilinear};
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::container::half;
use brdfc_formats::direction::{Vector, dot, from_polar};
use brdfc_formats::flat_btf::{FlatBtfDecoder, Vdim, VdimSamples};
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_render::rendering::{Panel, sheet};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

/// Polar angle and azimuth of the view and of the light of figures 4 and 9, degrees.
const VIEW: [f64; 2] = [60.0, 35.0];
const LIGHT: [f64; 2] = [30.0, 100.0];
/// Squares of parameters along each side of the tile in figure 3.
const SQUARES: f64 = 16.0;
/// Polar angle of the view of figure 3, and the part of a tile that its panels show, whole and near.
const OBLIQUE: f64 = 55.0;
const SHOWN: [f64; 2] = [1.25, 0.4];
/// Brightness of surfaces in figure 3 that face away from the light.
const AMBIENT: f64 = 0.25;
/// Blocks of figure 7 along each side, of the many of the whole map.
const BLOCKS: usize = 16;

/// One view of a flat BTF, and what the file has of it.
pub struct Illustrations {
    /// Figure 3: the surface with squares of its parameters, whole and near, and the normals of the file over the parameters.
    pub parameterisation: Panel,
    /// Figure 4: a view of the flat BTF; blue where it does not see texels, and filled by push-pull.
    pub holes: Panel,
    /// Figure 6: parameters that the view along the normal sees, and displacements of three other views.
    pub displacements: Panel,
    /// Figure 7: the packed map of the file, reduced, and the views of one of its texels.
    pub layout: Panel,
    /// Figure 9: a view of the flat BTF, the parameters that its pixels see, the rebuilt image, the surface, and the
    /// difference of both.
    pub reconstruction: Panel,
}

impl Illustrations {
    /// Draws the figures of a file and its indirection map, which is not compact. Images have as many texels as the map.
    pub(super) fn new(model: &MesoModel, appearance: &Appearance, (file, map): (&FlatBtfDecoder, &Vdim)) -> Self {
        let [view, light] = [VIEW, LIGHT].map(|[polar, azimuth]| from_polar(polar.to_radians(), azimuth.to_radians()));
        let size = file.parts().reflectance.size() as usize;
        let (seen, [flat, push_pull]) = flat_images(model, appearance, [view, light], size);
        let holed: Vec<[u8; 3]> = seen.iter().zip(&flat).map(|(s, v)| if *s { encoded(*v) } else { UNSEEN }).collect();
        Self {
            parameterisation: parameterisation(model, file),
            holes: row([holed, push_pull.into_iter().map(encoded).collect()]),
            displacements: displacements(map),
            layout: layout(map),
            reconstruction: reconstruction(model, appearance, map, [view, light], &flat),
        }
    }
}

/// Texels that a view sees, and its flat image with holes filled by Poisson inpainting and by push-pull.
fn flat_images(
    model: &MesoModel,
    appearance: &Appearance,
    [view, light]: [Vector; 2],
    size: usize,
) -> (Vec<bool>, [Vec<[f32; 3]>; 2]) {
    let texels = model.texels(size);
    // Holes are filled after the view from above.
    let (views, lights) = ([view, [0.0, 0.0, 1.0]], [light]);
    let masks = views.map(|view| visible(&texels, &model.caster, view));
    let reached = [visible(&texels, &model.caster, light)];
    let field = ComputedField::new(&texels, appearance, &views, &lights, &reached);
    let Ok(guide) = FillGuide::new(&field, &masks, &[1, 0], 1);
    let images = [Holes::Poisson(&guide), Holes::PushPull].map(|holes| {
        let Ok(flattened) = FlattenedView::new(&field, 0, &masks[0], holes);
        let Ok(image) = flattened.image(0);
        image
    });
    let [seen, _] = masks;
    (seen, images)
}

fn parameterisation(model: &MesoModel, file: &FlatBtfDecoder) -> Panel {
    let reflectance = file.parts().reflectance.factors().expect("the study makes no trees");
    let size = reflectance.header().size;
    let normal = |at: u32| {
        let normal = reflectance.texel([at % size, at / size]).base().normal;
        normal.map(|c| byte(0.5 + 0.5 * c))
    };
    let normals = square((0..size * size).map(normal).collect());
    sheet(&[oblique(model, SHOWN[0]), oblique(model, SHOWN[1]), normals])
}

/// The surface from an oblique view without perspective, `shown` tiles wide.
fn oblique(model: &MesoModel, shown: f64) -> Panel {
    let polar = OBLIQUE.to_radians();
    let (view, light) = (from_polar(polar, -FRAC_PI_2), from_polar(FRAC_PI_2 / 2.0, -0.8 * PI));
    let pixel = |at: usize| {
        let [right, down] = [at % SIDE, at / SIDE].map(|c| shown * ((c as f64 + 0.5) / SIDE as f64 - 0.5));
        let seen = model.seen([0.5 + right, 0.5 - down / polar.cos()], view);
        let [u, v] = seen.parameters.map(|c| (SQUARES * c).floor() as i64);
        let colour = if (u + v).rem_euclid(2) == 0 { [0.9, 0.45, 0.12] } else { [0.8, 0.8, 0.78] };
        let lit = dot(model.point(&seen.hit).normal, light).max(0.0);
        colour.map(|c| encode_srgb_byte((AMBIENT + (1.0 - AMBIENT) * lit) * c))
    };
    let rgb: Vec<[u8; 3]> = (0..SIDE * SIDE).into_par_iter().map(pixel).collect();
    Panel { width: SIDE, height: SIDE, rgb: rgb.concat() }
}

fn displacements(map: &Vdim) -> Panel {
    let header = map.header();
    let size = header.size;
    let seen = |texel: u32, view: Vector| {
        let centre = [texel % size, texel / size].map(|c| (c as f32 + 0.5) / size as f32);
        map.seen(centre, view.map(|c| c as f32), 0.0).0
    };
    let of_view = |view: Vector| (0..size * size).map(|texel| seen(texel, view)).collect::<Vec<[f32; 2]>>();
    let reference = of_view([0.0, 0.0, 1.0]);
    // Stored views, so that nothing is blended.
    let polar = 3 * (header.polar_angles - 1) / 4;
    let views = [0, 1, 2].map(|k| {
        let [polar, azimuth] = header.view_angles(polar, k * (header.azimuth_rows - 1) / 3);
        let moved = of_view(from_polar(polar, azimuth)).into_iter().zip(&reference);
        moved.map(|(seen, r)| [seen[0] - r[0], seen[1] - r[1]]).collect::<Vec<_>>()
    });
    let longest = views.iter().flatten().flatten().fold(f32::MIN_POSITIVE, |most, c| most.max(c.abs()));
    let colours = views.map(|view| view.into_iter().map(|d| of_pair(d.map(|c| 0.5 + 0.5 * c / longest))).collect());
    let [a, b, c] = colours;
    row([reference.into_iter().map(|at| of_pair(at.map(|c| c - c.floor()))).collect(), a, b, c])
}

fn layout(map: &Vdim) -> Panel {
    let header = map.header();
    let [size, polar, rows] = [header.size, header.polar_angles, header.azimuth_rows].map(|count| count as usize);
    let width = size * polar;
    let VdimSamples::Halves(packed) = map.samples() else { unreachable!("a map that is not compact") };
    let packed: Vec<[f32; 4]> = packed.iter().map(|texel| texel.map(half::decode)).collect();
    let longest = packed.iter().fold(f32::MIN_POSITIVE, |most, texel| most.max(texel[2]));
    let colours: Vec<[u8; 3]> =
        packed.iter().map(|[x, y, d, _]| [0.5 + 0.5 * x, 0.5 + 0.5 * y, d / longest].map(byte)).collect();
    let at = |x: usize, y: usize| colours[y * width + x];
    let texel_of = |block: usize, k: usize| [block % size * polar + k % polar, block / size * rows + k / polar];
    // The block with the longest displacements, which has a silhouette.
    let total = |block: &usize| {
        let lengths = (0..polar * rows).map(|k| texel_of(*block, k)).map(|[x, y]| packed[y * width + x][2]);
        lengths.sum::<f32>()
    };
    let block = (0..size * size).max_by(|a, b| total(a).total_cmp(&total(b))).unwrap_or(0);
    let one = (0..polar * rows).map(|k| texel_of(block, k)).map(|[x, y]| at(x, y)).collect::<Vec<_>>();
    // Each pixel is the mean of as many texels as make both panels equally large. Texels that are left over are cut off.
    let reduced = (size / BLOCKS).max(1);
    let [across, down] = [polar, rows].map(|count| size / reduced * count);
    let mean = |k: usize| {
        let texels =
            (0..reduced * reduced).map(|n| at(k % across * reduced + n % reduced, k / across * reduced + n / reduced));
        let sum = texels.fold([0usize; 3], |sum, texel| [0, 1, 2].map(|c: usize| sum[c] + usize::from(texel[c])));
        sum.map(|c| (c / (reduced * reduced)) as u8)
    };
    let whole = Panel { width: across, height: down, rgb: (0..across * down).map(mean).collect::<Vec<_>>().concat() };
    let one = magnified(&Panel { width: polar, height: rows, rgb: one.concat() }, down / rows);
    sheet(&[whole, one])
}

fn reconstruction(
    model: &MesoModel,
    appearance: &Appearance,
    map: &Vdim,
    [view, light]: [Vector; 2],
    flat: &[[f32; 3]],
) -> Panel {
    let seen = map.parameters(view.map(|c| c as f32));
    let colours = |image: Vec<[f32; 3]>| image.into_iter().map(encoded).collect::<Vec<_>>();
    let rebuilt = colours(sample_bilinear(flat, &seen));
    let direct = colours(ViewImage::new(model, view, map.header().size as usize, 1).direct(model, appearance, light));
    let difference = rebuilt.iter().zip(&direct).map(|(a, b)| [0, 1, 2].map(|c: usize| a[c].abs_diff(b[c]))).collect();
    let parameters = seen.into_iter().map(of_pair).collect();
    row([colours(flat.to_vec()), parameters, rebuilt, direct, difference])
}

/// Squares of texels side by side.
fn row<const N: usize>(squares: [Vec<[u8; 3]>; N]) -> Panel {
    sheet(&squares.map(square))
}

/// A square of texels, of which the first row is the lowest, as [`SIDE`] x [`SIDE`] pixels.
fn square(texels: Vec<[u8; 3]>) -> Panel {
    let size = texels.len().isqrt();
    let pixel = |at: usize| {
        let [x, y] = [at % SIDE, SIDE - 1 - at / SIDE].map(|c| c * size / SIDE);
        texels[y * size + x]
    };
    Panel { width: SIDE, height: SIDE, rgb: (0..SIDE * SIDE).map(pixel).collect::<Vec<_>>().concat() }
}

/// Two numbers from 0 to 1 as red and green.
fn of_pair([u, v]: [f32; 2]) -> [u8; 3] {
    [u, v, 0.5].map(byte)
}

fn byte(share: f32) -> u8 {
    (255.0 * share.clamp(0.0, 1.0)).round() as u8
}

fn encoded(value: [f32; 3]) -> [u8; 3] {
    value.map(|c| encode_srgb_byte(f64::from(c).min(1.0)))
}

#[cfg(test)]
mod tests {
    use super::super::figures::pixel;
    use super::*;
    use brdfc_flat_btf::structures::Structure;

    #[test]
    fn the_first_row_of_a_square_is_the_lowest() {
        let panel = square(vec![[1; 3], [2; 3], [3; 3], [4; 3]]);
        let last = SIDE - 1;
        let corners = [[0, last], [last, last], [0, 0], [last, 0]];
        assert_eq!(corners.map(|at| pixel(&panel, at)), [[1; 3], [2; 3], [3; 3], [4; 3]]);
    }

    /// A side view does not see all of the surface; the control is the view from above, which sees a height field.
    #[test]
    fn texels_that_a_view_does_not_see_are_filled() {
        let structure = Structure::parse("knit?resolution=32&height=2").unwrap();
        let model = MesoModel::new(structure.mesh(), 0, &()).unwrap();
        let unseen = |polar: f64| {
            let views = [from_polar(polar, 0.6), from_polar(0.5, 2.0)];
            let (seen, [poisson, push_pull]) = flat_images(&model, &structure.appearance(), views, 16);
            let images = poisson.iter().zip(&push_pull);
            assert!(seen.iter().zip(images).all(|(seen, (a, b))| !seen || a == b), "seen texels stay");
            seen.iter().filter(|seen| !**seen).count()
        };
        assert!(unseen(1.2) > unseen(0.0), "{} {}", unseen(1.2), unseen(0.0));
    }
}
