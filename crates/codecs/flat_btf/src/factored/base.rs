//! The base: a table of gloss for the whole surface and, for each texel, a diffuse and a glossy albedo under its
//! normal. It is fitted to seen and lit values; shadows and components account for the rest.

use super::masks::Masks;
use super::quantise::{weight_byte, weight_ranges};
use super::residual::Products;
use super::words::ViewWords;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{
    BaseAngles, BaseTable, BaseTexel, TablePlace, WeightRange, cube_root, slope_ranges, slope_texel, slope_words,
    to_opponent,
};
use brdfc_formats::flat_btf::{FlatHeader, unit_vectors};
use rayon::prelude::*;

/// Texels of a strip, the unit of parallel work.
const STRIP: usize = 128;
/// Weight of a value in a view that does not see the texel. It defines texels that no view sees.
const UNSEEN: f32 = 1e-3;
/// Cosines below which a pair is ignored: errors of normals are largest there.
pub(super) const MIN_COSINE: f32 = 0.1;
/// Share of the cube roots of a texel's brightest values above which a light counts as reaching it.
const LIT_SHARE: f32 = 0.05;
/// Maximum gloss of a texel, relative to the table.
const MAX_GLOSS: f32 = 2.0;

/// Sampled directions as unit vectors.
#[derive(Debug, Clone)]
pub(super) struct Rays {
    pub(super) views: Vec<[f32; 3]>,
    pub(super) lights: Vec<[f32; 3]>,
}

impl Rays {
    pub(super) fn new(directions: &FlatHeader) -> Self {
        Self { views: unit_vectors(&directions.views), lights: unit_vectors(&directions.lights) }
    }
}

/// Normals after quantisation.
pub(super) fn stored_normals(normals: &[[f32; 3]]) -> Vec<[f32; 3]> {
    normals.iter().map(|normal| slope_texel(slope_words(*normal))).collect()
}

/// Perceptual weight of a difference in such a value: equal steps of its cube root look alike.
#[inline]
pub(super) fn perceptual_weight([r, g, b]: [f32; 3]) -> f32 {
    let root = cube_root(0.05 + (r + g + b) * (1.0 / 3.0));
    1.0 / (root * root * root * root)
}

/// Cube root of the mean channel.
#[inline]
fn mean_root([r, g, b]: [f32; 3]) -> f32 {
    cube_root((r + g + b) * (1.0 / 3.0))
}

/// Returns true if a light reaches a texel, the second and first argument, as the surface says.
pub(super) type Reaches<'a> = dyn Fn(usize, usize) -> bool + Sync + 'a;

/// Diffuse albedo (three), gloss.
pub(super) type Albedo = [f32; 4];

/// Sums over views for solving albedos, for each texel and light: with weight w, value x, cosine c, and gloss g of the
/// table in red, green, blue, they are `w c²`, `w c g` (three), `w g·g`, `w c x` (three), `w g·x`, and, for all angles,
/// the cube root of the mean channel and 1, without w.
#[derive(Debug, Clone)]
pub(super) struct AlbedoSums {
    lights: usize,
    numbers: Vec<[f32; 11]>,
}

impl AlbedoSums {
    /// Bytes of a texel and light, with [`AlbedoSums::products`].
    pub(super) const BYTES: usize = 60;

    pub(super) fn new(texels: usize, lights: usize) -> Self {
        Self { lights, numbers: vec![[0.0; 11]; texels * lights] }
    }

    /// Adds some views of texels with these normals.
    pub(super) fn add(
        &mut self,
        table: &BaseTable,
        rays: &Rays,
        normals: &[[f32; 3]],
        masks: &Masks,
        views: &[ViewWords<'_>],
    ) {
        let lights = self.lights;
        self.numbers.par_chunks_mut(STRIP * lights).enumerate().for_each(|(strip, numbers)| {
            let (first, count) = (strip * STRIP, numbers.len() / lights);
            for view in views {
                let outgoing = rays.views[view.view];
                for (light, incoming) in rays.lights.iter().enumerate() {
                    let words = &view.words[light * view.stride + view.first + first..][..count];
                    for (texel, word) in words.iter().enumerate() {
                        let x = rgb9e5::decode(*word);
                        let sums = &mut numbers[texel * lights + light];
                        let normal = normals[first + texel];
                        let seen = if masks.is_seen(first + texel, view.view) { 1.0 } else { UNSEEN };
                        sums[9] += seen * mean_root(x);
                        sums[10] += seen;
                        let Some(angles) = BaseAngles::new(table.axis(), normal, outgoing, *incoming) else { continue };
                        if angles.cosine < MIN_COSINE || angles.outgoing < MIN_COSINE {
                            continue;
                        }
                        let (weight, c) = (seen * perceptual_weight(x), angles.cosine);
                        let g = table.at(&angles.taps).map(|t| t * angles.geometry);
                        sums[0] += weight * c * c;
                        for k in 0..3 {
                            sums[1 + k] += weight * c * g[k];
                            sums[5 + k] += weight * c * x[k];
                        }
                        sums[4] += weight * (g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
                        sums[8] += weight * (g[0] * x[0] + g[1] * x[1] + g[2] * x[2]);
                    }
                }
            }
        });
    }

    /// For each texel and light, true if the light reaches the texel: `texels x L`. The surface says so, `reaches`, and the
    /// values do; only the values where the surface lets no bright light reach a texel.
    pub(super) fn lit(&self, reaches: &Reaches<'_>) -> Vec<bool> {
        let of_texel = |(texel, numbers): (usize, &[[f32; 11]])| -> Vec<bool> {
            let least = LIT_SHARE * numbers.iter().map(|sums| sums[9]).fold(0.0, f32::max);
            let bright: Vec<bool> = numbers.iter().map(|sums| sums[9] > least).collect();
            let any = (0..bright.len()).any(|light| bright[light] && reaches(texel, light));
            (0..bright.len()).map(|light| bright[light] && (!any || reaches(texel, light))).collect()
        };
        self.numbers.par_chunks(self.lights).enumerate().flat_map_iter(of_texel).collect()
    }

    /// For each texel and light, the products of values with the base, and of cube roots of values with those of the diffuse
    /// albedo: `texels x L`.
    pub(super) fn products(&self, albedos: &[Albedo]) -> Vec<Products> {
        let of_texel = |(numbers, [r, g, b, gloss]): (&[[f32; 11]], &Albedo)| {
            let of_light = |[cosines, cg0, cg1, cg2, gg, cx0, cx1, cx2, gx, roots, all]: &[f32; 11]| {
                let (square, mixed) = (r * r + g * g + b * b, r * cg0 + g * cg1 + b * cg2);
                let root = mean_root([*r, *g, *b]);
                [
                    [r * cx0 + g * cx1 + b * cx2 + gloss * gx, square * cosines + gloss * (2.0 * mixed + gloss * gg)],
                    [root * roots, root * root * all],
                ]
            };
            numbers.iter().map(of_light).collect::<Vec<_>>()
        };
        self.numbers.par_chunks(self.lights).zip(albedos).flat_map_iter(of_texel).collect()
    }

    /// Least squares albedos over the lights that reach each texel.
    pub(super) fn solve(&self, reaches: &Reaches<'_>) -> Vec<Albedo> {
        let lit = self.lit(reaches);
        let texels = self.numbers.par_chunks(self.lights).zip(lit.par_chunks(self.lights));
        texels
            .map(|(numbers, lit)| {
                let mut all = [0.0f64; 9];
                for numbers in numbers.iter().zip(lit).filter(|(_, lit)| **lit).map(|(numbers, _)| numbers) {
                    all.iter_mut().zip(numbers).for_each(|(sum, number)| *sum += f64::from(*number));
                }
                solve_albedo(all)
            })
            .collect()
    }
}

/// Least squares albedos from sums of `w c²`, `w c g` (three), `w g·g`, `w c x` (three) and `w g·x`.
pub(super) fn solve_albedo(sums: [f64; 9]) -> Albedo {
    let [cosines, across @ .., gg, d0, d1, d2, gx] = sums;
    if cosines <= 1e-9 {
        return [0.0; 4];
    }
    let diffuse = [d0, d1, d2];
    let shared = |other: [f64; 3]| (0..3).map(|k| across[k] * other[k] / cosines).sum::<f64>();
    let (above, below) = (gx - shared(diffuse), gg - shared(across));
    let gloss = if below > 1e-6 * gg.max(1e-9) { (above / below).clamp(0.0, f64::from(MAX_GLOSS)) } else { 0.0 };
    let albedo = |k: usize| ((diffuse[k] - across[k] * gloss) / cosines).max(0.0) as f32;
    [albedo(0), albedo(1), albedo(2), gloss as f32]
}

/// The base of all texels as decoders read it.
#[derive(Debug, Clone)]
pub(super) struct StoredBase {
    pub(super) table: BaseTable,
    /// Ranges of diffuse albedo (three) and gloss.
    ranges: [WeightRange; 4],
    albedos: Vec<[u8; 4]>,
    slopes: Vec<[u16; 2]>,
    texels: Vec<BaseTexel>,
}

impl StoredBase {
    /// Quantises a fitted base.
    pub(super) fn new(table: BaseTable, albedos: &[Albedo], normals: &[[f32; 3]]) -> Self {
        let ranges: [WeightRange; 4] =
            weight_ranges(albedos.as_flattened(), 4).try_into().expect("one to each of four numbers");
        let bytes = |albedo: &Albedo| [0, 1, 2, 3].map(|k: usize| weight_byte(albedo[k], ranges[k]));
        let albedos: Vec<[u8; 4]> = albedos.iter().map(bytes).collect();
        let slopes: Vec<[u16; 2]> = normals.iter().map(|normal| slope_words(*normal)).collect();
        let texel = |(bytes, slopes): (&[u8; 4], &[u16; 2])| {
            let [r, g, b, gloss] = [0, 1, 2, 3].map(|k: usize| ranges[k].of_byte(bytes[k]).max(0.0));
            BaseTexel { diffuse: [r, g, b], gloss, normal: slope_texel(*slopes), tables: TablePlace::default() }
        };
        let texels = albedos.iter().zip(&slopes).map(texel).collect();
        Self { table, ranges, albedos, slopes, texels }
    }

    /// The base of some texels alone.
    pub(super) fn of(&self, texels: &[usize]) -> Self {
        Self {
            table: self.table.clone(),
            ranges: self.ranges,
            albedos: texels.iter().map(|at| self.albedos[*at]).collect(),
            slopes: texels.iter().map(|at| self.slopes[*at]).collect(),
            texels: texels.iter().map(|at| self.texels[*at]).collect(),
        }
    }

    /// Values of a texel as decoders read them.
    pub(super) fn texel(&self, texel: usize) -> &BaseTexel {
        &self.texels[texel]
    }

    /// Ranges of the numbers of both layers.
    pub(super) fn ranges(&self) -> Vec<WeightRange> {
        [self.ranges, slope_ranges()].concat()
    }

    /// Bytes of the first layer.
    pub(super) fn albedos(&self) -> &[[u8; 4]] {
        &self.albedos
    }

    /// Numbers of the second layer.
    pub(super) fn slopes(&self) -> &[[u16; 2]] {
        &self.slopes
    }

    /// A value of a texel less the share `shaded` of its diffuse albedo, 0 or more.
    #[inline]
    pub(super) fn without(&self, texel: usize, shaded: f32, value: [f32; 3]) -> [f32; 3] {
        let diffuse = self.texels[texel].diffuse;
        [0, 1, 2].map(|c: usize| (value[c] - shaded * diffuse[c]).max(0.0))
    }

    /// Lightness and opponent colours of a texel in a view under an unshadowed light.
    #[inline]
    pub(super) fn opponent(&self, texel: usize, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        to_opponent(self.table.colour(&self.texels[texel], view, light))
    }
}
