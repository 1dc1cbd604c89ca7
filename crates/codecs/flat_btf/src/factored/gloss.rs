//! Fits the table of the base to some texels by alternating least squares: the table, then the albedos of each texel.

use super::base::{Albedo, AlbedoSums, MIN_COSINE, Rays, Reaches, perceptual_weight};
use super::sample::Sample;
use super::words::ViewWords;
use brdfc_formats::FormatError;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{Axis, BaseAngles, BaseTable, DIFFERENCE_ANGLES, HALF_ANGLES, MAX_ENTRY};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Number of texels that the table is fitted to.
const TEXELS: usize = 1000;
/// Number of texels whose squares are summed together.
const STRIP: usize = 125;
const ROUNDS: usize = 3;
const ENTRIES: usize = HALF_ANGLES * DIFFERENCE_ANGLES;
/// Regularisation, as shares of the mean of the diagonal: curvature over half angles, slope over difference angles. It
/// fills holes and smooths noise.
const CURVATURE: f64 = 3e-4;
const SLOPE: f64 = 3e-5;
/// Beyond this entry over half angles, about 25 degrees, only one in `THINNED` pairs is used.
const NARROW: usize = 26 * DIFFERENCE_ANGLES;
const THINNED: usize = 7;
/// Beyond this entry, about 40 degrees, values initially count as diffuse.
const WIDE: usize = 33 * DIFFERENCE_ANGLES;

/// Normal equations of the table.
struct Equations {
    matrix: DMatrix<f64>,
    right: [DVector<f64>; 3],
}

impl Equations {
    fn new() -> Self {
        Self { matrix: DMatrix::zeros(ENTRIES, ENTRIES), right: [(); 3].map(|()| DVector::zeros(ENTRIES)) }
    }

    /// Adds a pair with glossy remainder `difference`; its gloss is `scale` times the table.
    fn add(&mut self, angles: &BaseAngles, scale: f64, weight: f64, difference: [f64; 3]) {
        for (at, share) in angles.taps {
            let share = weight * scale * f64::from(share);
            for (k, right) in self.right.iter_mut().enumerate() {
                right[at] += share * difference[k];
            }
            for (other, factor) in angles.taps {
                self.matrix[(at, other)] += share * scale * f64::from(factor);
            }
        }
    }

    fn sum(mut self, other: Self) -> Self {
        self.matrix += other.matrix;
        self.right.iter_mut().zip(other.right).for_each(|(sum, right)| *sum += right);
        self
    }

    /// Least squares solution for the table.
    fn solve(mut self) -> Vec<[f32; 3]> {
        let mean = self.matrix.trace() / ENTRIES as f64;
        let mut pull = |share: f64, terms: &[(usize, f64)]| {
            for (a, x) in terms {
                for (b, y) in terms {
                    self.matrix[(*a, *b)] += share * mean * x * y;
                }
            }
        };
        for i in 0..HALF_ANGLES {
            for j in 0..DIFFERENCE_ANGLES {
                let at = i * DIFFERENCE_ANGLES + j;
                if (1..HALF_ANGLES - 1).contains(&i) {
                    pull(CURVATURE, &[(at - DIFFERENCE_ANGLES, -1.0), (at, 2.0), (at + DIFFERENCE_ANGLES, -1.0)]);
                }
                if j + 1 < DIFFERENCE_ANGLES {
                    pull(SLOPE, &[(at, 1.0), (at + 1, -1.0)]);
                }
                pull(1e-9, &[(at, 1.0)]);
            }
        }
        // Black entries have no equations.
        for k in 0..ENTRIES {
            self.matrix[(k, k)] += f64::MIN_POSITIVE;
        }
        let Some(factors) = self.matrix.cholesky() else { return vec![[0.0; 3]; ENTRIES] };
        let solved = self.right.map(|right| factors.solve(&right));
        let number = |number: f64| if number > 0.0 { (number as f32).min(MAX_ENTRY) } else { 0.0 };
        (0..ENTRIES).map(|at| [0, 1, 2].map(|k: usize| number(solved[k][at]))).collect()
    }
}

/// Fits a table over an axis to texels with these normals, which lights reach as the surface says. Returns it with the
/// albedos of these texels.
///
/// # Errors
/// Returns an error only for invalid tables, which values of views never produce.
pub(super) fn fit_table(
    axis: Axis,
    sample: &Sample,
    normals: &[[f32; 3]],
    rays: &Rays,
    reaches: &Reaches<'_>,
) -> Result<(BaseTable, Vec<Albedo>), FormatError> {
    let fit = TableFit { axis, sample, normals, rays, texels: sample.texels.len().min(TEXELS) };
    let mut table = BaseTable::black().over(axis);
    let lit = fit.sums(&table).lit(reaches);
    let mut albedos = fit.first_albedos(&lit);
    for _ in 0..ROUNDS {
        table = BaseTable::new(fit.equations(&albedos, &lit).solve())?.over(axis);
        albedos = fit.sums(&table).solve(reaches);
    }
    Ok((table, albedos))
}

struct TableFit<'a> {
    axis: Axis,
    sample: &'a Sample,
    normals: &'a [[f32; 3]],
    rays: &'a Rays,
    texels: usize,
}

impl TableFit<'_> {
    fn sums(&self, table: &BaseTable) -> AlbedoSums {
        let mut sums = AlbedoSums::new(self.texels, self.rays.lights.len());
        let stride = self.sample.texels.len();
        let words = self.sample.views.iter().enumerate();
        let words: Vec<ViewWords<'_>> =
            words.map(|(view, words)| ViewWords { view, words, first: 0, stride }).collect();
        sums.add(table, self.rays, self.normals, &self.sample.masks, &words);
        sums
    }

    /// Visits the pairs of a texel that are used: seen, lit, and not at a grazing angle.
    fn each_pair(&self, texel: usize, lit: &[bool], mut pair: impl FnMut(&BaseAngles, usize, [f32; 3])) {
        let lights = self.rays.lights.len();
        for (view, outgoing) in self.rays.views.iter().enumerate() {
            if !self.sample.masks.is_seen(texel, view) {
                continue;
            }
            for (light, incoming) in self.rays.lights.iter().enumerate().filter(|(l, _)| lit[texel * lights + l]) {
                if let Some(angles) = BaseAngles::new(self.axis, self.normals[texel], *outgoing, *incoming)
                    && angles.cosine >= MIN_COSINE
                    && angles.outgoing >= MIN_COSINE
                {
                    pair(&angles, view * lights + light, rgb9e5::decode(self.sample.word(texel, view, light)));
                }
            }
        }
    }

    /// Initial albedos: medians far from the mirrored direction, and a gloss of 1.
    fn first_albedos(&self, lit: &[bool]) -> Vec<Albedo> {
        let of_texel = |texel: usize| {
            let mut seen = [const { Vec::new() }; 3];
            self.each_pair(texel, lit, |angles, _, value| {
                if angles.taps[0].0 >= WIDE && angles.cosine > 2.0 * MIN_COSINE {
                    seen.iter_mut().zip(value).for_each(|(seen, c)| seen.push(c / angles.cosine));
                }
            });
            let [r, g, b] = seen.map(|mut seen| {
                let middle = seen.len() / 2;
                if seen.is_empty() { 0.0 } else { *seen.select_nth_unstable_by(middle, f32::total_cmp).1 }
            });
            [r, g, b, 1.0]
        };
        (0..self.texels).into_par_iter().map(of_texel).collect()
    }

    fn equations(&self, albedos: &[Albedo], lit: &[bool]) -> Equations {
        let strips: Vec<usize> = (0..self.texels).step_by(STRIP).collect();
        let of_strip = |first: &usize| {
            let mut equations = Equations::new();
            for texel in *first..self.texels.min(first + STRIP) {
                let [r, g, b, gloss] = albedos[texel];
                self.each_pair(texel, lit, |angles, number, value| {
                    if angles.taps[0].0 < NARROW || (number + texel).is_multiple_of(THINNED) {
                        let diffuse = [r, g, b].map(|albedo| albedo * angles.cosine);
                        let rest = [0, 1, 2].map(|k: usize| f64::from(value[k] - diffuse[k]));
                        let scale = f64::from(gloss * angles.geometry);
                        equations.add(angles, scale, f64::from(perceptual_weight(value)), rest);
                    }
                });
            }
            equations
        };
        let made: Vec<Equations> = strips.par_iter().map(of_strip).collect();
        made.into_iter().fold(Equations::new(), Equations::sum)
    }
}
