//! Materials of mipmap levels: what texels show from afar, where they cover more of the relief than a normal describes.
//!
//! Normals within a texel spread highlights, and its parts hide and shade each other. Each level has tables of its own
//! for that: a non-negative mixture of the gloss under normals that scatter by several widths, and factors of gloss and
//! diffuse reflection by half and difference angles. They are fitted to rays against the surface. That the spread of
//! normals widens highlights is the idea of LEAN mapping (Olano and Baker 2010), which assumes one normal distribution.

use crate::factored::FactorError;
use crate::model::MesoModel;
use crate::probes::{Place, direct_radiance};
use crate::surface::Appearance;
use brdfc_core::progress::Progress;
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, add_scaled, cross, dot, from_polar, normalize};
use brdfc_formats::flat_btf::factored::{
    BaseAngles, BaseMaterial, BaseTable, BaseTexel, BasisMap, DIFFERENCE_ANGLES, FactoredFlatBtf, HALF_ANGLES,
    LevelTable, MAX_ENTRY,
};
use brdfc_formats::flat_btf::{FlatBtfDecoder, MacroSurface, SampledDirections};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Rays of sight per level. One in [`HELD_OUT`] is for measuring.
const RAYS: usize = 40_000;
const HELD_OUT: usize = 4;
/// Rays of a chunk, the unit of ordered sums.
const CHUNK: usize = 1000;
/// Least cosine of the polar angle of views and lights.
const LEAST_COSINE: f64 = 0.15;
/// Standard deviations of the slopes of scattered normals. The first is the material itself.
const SPREADS: [f64; 5] = [0.0, 0.1, 0.2, 0.4, 0.8];
/// Normals per spread, and azimuths per entry of a table.
const SCATTERED: usize = 48;
const AZIMUTHS: usize = 16;
/// Nodes between which factors are linear, by half and by difference angle.
const HALF_NODES: usize = 4;
const DIFFERENCE_NODES: usize = 4;
/// Numbers of a material that are fitted: factors of the diffuse reflection, then factors of each gloss.
const DIFFUSE: usize = HALF_NODES * DIFFERENCE_NODES;
const FITTED: usize = DIFFUSE + SPREADS.len() * DIFFERENCE_NODES;
/// Pull to the level before, as a share of the evidence.
const PULL: f64 = 2e-3;
/// Rounds of the fit, each of which weights by the values of the one before; and sweeps of its solver.
const ROUNDS: usize = 3;
const SWEEPS: usize = 400;

/// Mean radiance of a mipmap level over that of the surface, for rays that were held out of the fit. If the relief has no
/// shadows, neither has the surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct FarLevel {
    /// The level, 1 the first that is coarser than the texels.
    pub level: u32,
    /// Ratio of both, over views and lights up to 81 degrees from the normal.
    pub brightness: f64,
}

/// A ray of sight and a ray of light through a texel of a level.
struct Ray {
    /// Radiance of the surface at a point of the texel, relative to a white diffuser that faces the light.
    truth: [f64; 3],
    /// Angles to the mean normal for the axis of each material; `None` for texels in the shadow.
    seen: Option<Lit>,
}

struct Lit {
    tint: [f64; 3],
    shares: [f64; 2],
    angles: Vec<BaseAngles>,
}

/// A number that a value depends on in proportion, with the factor of each channel.
type Term = (usize, [f64; 3]);

/// Tables of a material under scattered normals.
struct Scattered<'a> {
    material: &'a BaseMaterial,
    glosses: Vec<Vec<[f32; 3]>>,
}

/// Replaces the tables of the materials by tables for each level. The decoder has the same number of tables, of which
/// the first counts, and these sampled directions. `progress` receives a step per level.
///
/// # Errors
/// Returns an error if `progress` cancels; otherwise only for tables that cannot be stored.
pub fn far_materials<E>(
    (decoder, directions): (&FlatBtfDecoder, Option<&SampledDirections>),
    model: &MesoModel,
    appearance: &Appearance,
    progress: &dyn Progress,
) -> Result<(FactoredFlatBtf, Vec<FarLevel>), FactorError<E>> {
    let reflectance = decoder.parts().reflectance.factors().expect(FACTORS);
    let header = reflectance.header();
    let materials = reflectance.basis().materials();
    let scattered: Vec<Scattered<'_>> = materials.par_iter().map(Scattered::new).collect();
    let mut made: Vec<BaseMaterial> = materials.to_vec();
    let mut numbers = vec![as_it_is(); materials.len()].concat();
    let mut levels = Vec::new();
    for index in 1..header.table_levels as usize {
        let level = index as u32;
        let rays = rays((decoder, directions), model, appearance, level);
        numbers = fit(&scattered, &rays, &numbers);
        for ((material, scattered), numbers) in made.iter_mut().zip(&scattered).zip(numbers.chunks_exact(FITTED)) {
            material.tables[index] = scattered.table(numbers)?;
        }
        progress.step()?;
        levels.push(FarLevel { level, brightness: brightness(&scattered, &rays, &numbers, is_held_out) });
    }
    let basis = BasisMap::of_materials(header.clone(), &made)?;
    Ok((FactoredFlatBtf::new(basis, reflectance.weights().clone(), None)?, levels))
}

/// Numbers of a material close up.
fn as_it_is() -> Vec<f64> {
    (0..FITTED).map(|k| if k < DIFFUSE + DIFFERENCE_NODES { 1.0 } else { 0.0 }).collect()
}

/// The `k`-th point of a sequence that covers a cube of N dimensions evenly, by additive recurrence: steps are powers of
/// the reciprocal of `root`, which solves `x^(N + 1) = x + 1`.
fn evenly<const N: usize>(k: usize, root: f64) -> [f64; N] {
    std::array::from_fn(|n| (0.5 + (k as f64 + 1.0) * root.powi(-(n as i32 + 1))).fract())
}

/// Form of the reflectance of known materials.
const FACTORS: &str = "known materials have a base";
const ROOT_OF_2: f64 = 1.324_717_957_244_746;
const ROOT_OF_8: f64 = 1.085_070_245_491_451;

/// Casts rays through texels of a level.
fn rays(
    (decoder, directions): (&FlatBtfDecoder, Option<&SampledDirections>),
    model: &MesoModel,
    appearance: &Appearance,
    level: u32,
) -> Vec<Ray> {
    let reflectance = decoder.parts().reflectance.factors().expect(FACTORS);
    let side = f64::from((reflectance.header().size >> level).max(1));
    let detail = level as f32;
    // Tables must not add shadows to a relief without them.
    let shadows = decoder.parts().relief.casts_shadows();
    let one = |k: usize| {
        let [x, y, across, down, cosine, azimuth, a, b] = evenly::<8>(k, ROOT_OF_8);
        let view = from_polar((LEAST_COSINE + (1.0 - LEAST_COSINE) * cosine).acos(), TAU * azimuth);
        let light = if k.is_multiple_of(2) {
            from_polar((LEAST_COSINE + (1.0 - LEAST_COSINE) * a).acos(), TAU * b)
        } else {
            near_mirrored(view, a, b)
        };
        // Of the two texels per side that a pixel of the level covers (`factored_mipmap_level`), one: normals between texels
        // are filtered, too, and with both, tables are too blurred for pixels of several samples.
        let at = [x + (across - 0.5) / side, y + (down - 0.5) / side];
        let truth = direct_radiance(model, appearance, Place { at, view, light }, shadows).map(f64::from);
        let [view, light] = [view, light].map(|v| v.map(|c| c as f32));
        let look = decoder.look([x as f32, y as f32], detail, view, MacroSurface::PLANE);
        let (base, lit) = (look.texel().expect(FACTORS).base(), look.reached(directions, light));
        let angles = |material: &BaseMaterial| BaseAngles::new(material.axis(), base.normal, view, light);
        let angles: Option<Vec<BaseAngles>> = reflectance.basis().materials().iter().map(angles).collect();
        let seen = angles.filter(|_| lit > 0.0).map(|angles| of_texel(base, lit, angles));
        Ray { truth, seen }
    };
    (0..RAYS).into_par_iter().map(one).collect()
}

fn of_texel(base: &BaseTexel, lit: f32, angles: Vec<BaseAngles>) -> Lit {
    let second = if angles.len() > 1 { f64::from(base.gloss) } else { 0.0 };
    Lit { tint: base.diffuse.map(|c| f64::from(lit * c)), shares: [1.0 - second, second], angles }
}

/// A light whose half vector with a view is near the normal of the plane; above the horizon.
fn near_mirrored(view: Vector, a: f64, b: f64) -> Vector {
    let half = from_polar(0.7 * a * a, TAU * b);
    let twice = 2.0 * (0..3).map(|k| half[k] * view[k]).sum::<f64>();
    let [x, y, z] = [0, 1, 2].map(|k: usize| twice * half[k] - view[k]);
    normalize([x, y, z.max(LEAST_COSINE)])
}

/// The two nodes around a position of 0 to 1, with their weights.
fn hats(position: f64, nodes: usize) -> [(usize, f64); 2] {
    let scaled = position.clamp(0.0, 1.0) * (nodes - 1) as f64;
    let first = (scaled as usize).min(nodes - 2);
    let share = scaled - first as f64;
    [(first, 1.0 - share), (first + 1, share)]
}

/// Nodes of half and difference angles of an entry of a table.
fn nodes(entry: usize) -> [[(usize, f64); 2]; 2] {
    let (half, difference) = (entry / DIFFERENCE_ANGLES, entry % DIFFERENCE_ANGLES);
    [
        hats(half as f64 / (HALF_ANGLES - 1) as f64, HALF_NODES),
        hats(difference as f64 / (DIFFERENCE_ANGLES - 1) as f64, DIFFERENCE_NODES),
    ]
}

impl<'a> Scattered<'a> {
    fn new(material: &'a BaseMaterial) -> Self {
        let glosses = SPREADS.par_iter().map(|spread| scattered(&material.tables[0].gloss, *spread)).collect();
        Self { material, glosses }
    }

    /// Table of fitted numbers.
    fn table(&self, numbers: &[f64]) -> Result<LevelTable, FormatError> {
        let (mut entries, mut factors) = (Vec::new(), Vec::new());
        for at in 0..HALF_ANGLES * DIFFERENCE_ANGLES {
            let [half, difference] = nodes(at);
            let (mut entry, mut factor) = ([0.0; 3], 0.0);
            for (j, along) in difference {
                factor +=
                    half.map(|(i, across)| across * along * numbers[i * DIFFERENCE_NODES + j]).iter().sum::<f64>();
                for (spread, gloss) in self.glosses.iter().enumerate() {
                    let share = along * numbers[DIFFUSE + spread * DIFFERENCE_NODES + j];
                    (0..3).for_each(|c| entry[c] += share * f64::from(gloss[at][c]));
                }
            }
            entries.push(entry.map(|c| (c as f32).min(MAX_ENTRY)));
            factors.push((factor as f32).min(MAX_ENTRY));
        }
        LevelTable::new(BaseTable::new(entries)?.over(self.material.axis()), factors)
    }

    /// Terms of a value of the material, scaled by `share`; numbers from `first` on. As in a table, factors are linear
    /// between entries.
    fn terms(&self, angles: &BaseAngles, share: [f64; 3], first: usize, terms: &mut Vec<Term>) {
        let mut all = [[0.0; 3]; FITTED];
        let mut add = |k: usize, factor: f64, value: [f32; 3]| {
            (0..3).for_each(|c| all[k][c] += factor * share[c] * f64::from(value[c]));
        };
        for (at, weight) in angles.taps {
            let [half, difference] = nodes(at);
            let (diffuse, glossy) = (f64::from(weight * angles.cosine), f64::from(weight * angles.geometry));
            for (j, along) in difference {
                for (i, across) in half {
                    add(i * DIFFERENCE_NODES + j, diffuse * across * along, self.material.diffuse);
                }
                for (spread, gloss) in self.glosses.iter().enumerate() {
                    add(DIFFUSE + spread * DIFFERENCE_NODES + j, glossy * along, gloss[at]);
                }
            }
        }
        let used = all.into_iter().enumerate().filter(|(_, term)| *term != [0.0; 3]);
        terms.extend(used.map(|(k, term)| (first + k, term)));
    }
}

/// A table under normals that scatter around the normal: for each entry, the ratio of the mean glossy reflection towards
/// the view, weighted by what the view sees of each normal, to the factor that the table is multiplied by.
fn scattered(table: &BaseTable, spread: f64) -> Vec<[f32; 3]> {
    if spread == 0.0 {
        return table.entries().to_vec();
    }
    let mut sums = vec![([0.0f64; 3], 0.0f64); HALF_ANGLES * DIFFERENCE_ANGLES];
    for difference in 0..DIFFERENCE_ANGLES {
        // A pair around the half vector, along an axis of which the normal takes all azimuths. Opposite vectors have none.
        let cosine = (1.0 - difference as f64 / (DIFFERENCE_ANGLES - 1) as f64).max(0.02);
        let sine = (1.0 - cosine * cosine).sqrt();
        let pair @ [view, light] = [[sine, 0.0, cosine], [-sine, 0.0, cosine]];
        let [seen, lit] = pair.map(|v| v.map(|c| c as f32));
        for k in 0..2 * HALF_ANGLES * AZIMUTHS {
            let half = (k / AZIMUTHS) as f64 / (2 * HALF_ANGLES - 1) as f64;
            let azimuth = TAU * ((k % AZIMUTHS) as f64 + 0.5) / AZIMUTHS as f64;
            let normal = from_polar((1.0 - half.powi(4)).acos(), azimuth);
            let Some(angles) = BaseAngles::new(table.axis(), normal.map(|c| c as f32), seen, lit) else { continue };
            let across = normalize(cross(if normal[2] < 0.9 { [0.0, 0.0, 1.0] } else { [1.0, 0.0, 0.0] }, normal));
            let along = cross(normal, across);
            let (mut mean, mut visible) = ([0.0f64; 3], 1e-9);
            for n in 0..SCATTERED {
                let [u, v] = evenly::<2>(SCATTERED * (k % AZIMUTHS) + n, ROOT_OF_2);
                // Slopes with a normal distribution.
                let length = spread * (-2.0 * (1.0 - u).ln()).sqrt();
                let (sine, cosine) = (TAU * v).sin_cos();
                let moved = normalize(add_scaled(add_scaled(normal, length * cosine, across), length * sine, along));
                let outgoing = dot(moved, view).max(0.0);
                visible += outgoing;
                if dot(moved, light) > 0.0
                    && let Some(angles) = BaseAngles::new(table.axis(), moved.map(|c| c as f32), seen, lit)
                {
                    let value = table.at(&angles.taps);
                    (0..3).for_each(|c| mean[c] += outgoing * f64::from(angles.geometry * value[c]));
                }
            }
            for (at, weight) in angles.taps {
                let (entry, factor) = &mut sums[at];
                (0..3).for_each(|c| entry[c] += f64::from(weight) * mean[c] / visible);
                *factor += f64::from(weight * angles.geometry);
            }
        }
    }
    let entry = |(at, (sum, factor)): (usize, &([f64; 3], f64))| {
        if *factor > 1e-6 { sum.map(|c| ((c / factor) as f32).min(MAX_ENTRY)) } else { table.entries()[at] }
    };
    sums.iter().enumerate().map(entry).collect()
}

/// Terms of a ray's value.
fn terms(scattered: &[Scattered<'_>], ray: &Ray) -> Vec<Term> {
    let mut terms = Vec::new();
    if let Some(lit) = &ray.seen {
        for (m, (scattered, angles)) in scattered.iter().zip(&lit.angles).enumerate() {
            let share = lit.tint.map(|tint| lit.shares[m] * tint);
            scattered.terms(angles, share, m * FITTED, &mut terms);
        }
    }
    terms
}

fn value(terms: &[Term], numbers: &[f64]) -> [f64; 3] {
    terms.iter().fold([0.0; 3], |sum, (at, term)| [0, 1, 2].map(|c: usize| sum[c] + numbers[*at] * term[c]))
}

/// Normal equations: a symmetric matrix row by row, and a right side.
struct Equations {
    matrix: Vec<f64>,
    right: Vec<f64>,
}

impl Equations {
    fn new(count: usize) -> Self {
        Self { matrix: vec![0.0; count * count], right: vec![0.0; count] }
    }

    fn add(&mut self, terms: &[Term], weight: f64, truth: [f64; 3]) {
        let count = self.right.len();
        for (a, x) in terms {
            self.right[*a] += weight * (0..3).map(|c| x[c] * truth[c]).sum::<f64>();
            for (b, y) in terms {
                self.matrix[a * count + b] += weight * (0..3).map(|c| x[c] * y[c]).sum::<f64>();
            }
        }
    }

    fn sum(mut self, other: &Self) -> Self {
        self.matrix.iter_mut().zip(&other.matrix).for_each(|(sum, number)| *sum += number);
        self.right.iter_mut().zip(&other.right).for_each(|(sum, number)| *sum += number);
        self
    }

    /// The non-negative numbers with the smallest squared error, pulled to those before: coordinate descent.
    fn solve(&self, before: &[f64]) -> Vec<f64> {
        let count = self.right.len();
        let largest = (0..count).map(|k| self.matrix[k * count + k]).fold(0.0, f64::max);
        let pull: Vec<f64> = (0..count).map(|k| PULL * self.matrix[k * count + k] + 1e-9 * largest + 1e-30).collect();
        let mut numbers = before.to_vec();
        for _ in 0..SWEEPS {
            for k in 0..count {
                let row = &self.matrix[k * count..][..count];
                let product: f64 = row.iter().zip(&numbers).map(|(a, x)| a * x).sum();
                let gradient = product - self.right[k] + pull[k] * (numbers[k] - before[k]);
                numbers[k] = (numbers[k] - gradient / (row[k] + pull[k])).max(0.0);
            }
        }
        numbers
    }
}

/// Fits the numbers of all materials to rays.
fn fit(scattered: &[Scattered<'_>], rays: &[Ray], before: &[f64]) -> Vec<f64> {
    let mut numbers = before.to_vec();
    for _ in 0..ROUNDS {
        let of_chunk = |(chunk, rays): (usize, &[Ray])| {
            let mut equations = Equations::new(before.len());
            for (k, ray) in rays.iter().enumerate() {
                if !is_held_out(chunk * CHUNK + k) {
                    let terms = terms(scattered, ray);
                    let mean = value(&terms, &numbers).iter().sum::<f64>() / 3.0;
                    // Equal steps of the cube root look alike.
                    equations.add(&terms, (0.05 + mean).powf(-4.0 / 3.0), ray.truth);
                }
            }
            equations
        };
        let made: Vec<Equations> = rays.par_chunks(CHUNK).enumerate().map(of_chunk).collect();
        numbers = made.iter().fold(Equations::new(before.len()), Equations::sum).solve(before);
    }
    // Energy is kept, which weights by appearance do not ensure.
    let scale = 1.0 / brightness(scattered, rays, &numbers, |ray| !is_held_out(ray));
    if scale.is_finite() { numbers.iter().map(|number| scale * number).collect() } else { numbers }
}

fn is_held_out(ray: usize) -> bool {
    // Pairs of rays, one with a light near the mirrored direction.
    (ray / 2).is_multiple_of(HELD_OUT)
}

/// Ratio of the mean value to the mean truth over some of the rays with lights in all directions.
fn brightness(scattered: &[Scattered<'_>], rays: &[Ray], numbers: &[f64], is_used: impl Fn(usize) -> bool) -> f64 {
    let used = rays.iter().enumerate().filter(|(k, _)| k.is_multiple_of(2) && is_used(*k));
    let sums = used.fold([0.0; 2], |sums, (_, ray)| {
        let found = value(&terms(scattered, ray), numbers);
        [sums[0] + found.iter().sum::<f64>(), sums[1] + ray.truth.iter().sum::<f64>()]
    });
    if sums[1] > 0.0 { sums[0] / sums[1] } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::{
        FlatBtfEncoded, FlatInput, FlattenRecipe, MemoryScratch, Reflectance, ReliefForm, ValueSource, encode,
    };
    use crate::factored::FactoredTarget;
    use crate::fill::FillMethod;
    use crate::mesh::PeriodicMesh;
    use crate::testing::{bumps, height_field};
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction_set::DirectionSet;

    fn encoded(mesh: PeriodicMesh, appearance: &Appearance) -> FlatBtfEncoded {
        let recipe = FlattenRecipe {
            relief: ReliefForm::Layers,
            texels: 32,
            flat_texels: 32,
            views: DirectionSet::ubo2003(),
            lights: DirectionSet::ubo2003(),
            fill: FillMethod::PushPull,
            bounces: 0,
            reflectance: Reflectance::Brdf,
            target: FactoredTarget::Error(1.0),
        };
        let input = FlatInput { mesh, repairs: None, values: ValueSource::Computed(appearance) };
        encode(input, &recipe, &MemoryScratch::default(), &()).unwrap()
    }

    fn of(material: &str) -> Appearance {
        Appearance { sources: vec![parse_synth(material).unwrap()], ..Appearance::default() }
    }

    #[test]
    fn a_plane_looks_the_same_from_afar() {
        let made = encoded(height_field(7, |_, _| 0.25), &of("synth:lambert?kd=0.5"));
        assert_eq!(made.report.far.iter().map(|far| far.level).collect::<Vec<_>>(), [1, 2, 3, 4, 5]);
        assert!(made.report.far.iter().all(|far| (far.brightness - 1.0).abs() < 2e-3), "{:?}", made.report.far);
        let material = &made.decoder.parts().reflectance.factors().unwrap().basis().materials()[0];
        assert_eq!(material.tables.len(), 6);
        for table in &material.tables {
            let entries = table.gloss.entries().iter().flatten();
            assert!(entries.clone().all(|c| *c < 1e-2) && table.diffuse.iter().all(|a| (a - 1.0).abs() < 0.02));
        }
    }

    /// The control are the tables of the material itself.
    #[test]
    fn reliefs_keep_their_brightness_from_afar() {
        let appearance = of("synth:lewis?kd=0.4&ks=0.2&n=20");
        let made = encoded(bumps(32, 0.4), &appearance);
        assert!(made.report.far.iter().all(|far| (far.brightness - 1.0).abs() < 0.03), "{:?}", made.report.far);
        let materials = made.decoder.parts().reflectance.factors().unwrap().basis().materials();
        let scattered: Vec<Scattered<'_>> = materials.iter().map(Scattered::new).collect();
        let rays = rays((&made.decoder, None), &made.model, &appearance, 5);
        let without = brightness(&scattered, &rays, &as_it_is(), is_held_out);
        assert!(without > 1.08, "{without}");
    }

    #[test]
    fn scattered_normals_spread_highlights() {
        let made = encoded(height_field(7, |_, _| 0.0), &of("synth:ggx?alpha=0.1"));
        let table = &made.decoder.parts().reflectance.factors().unwrap().basis().materials()[0].tables[0].gloss;
        let at = |entries: &[[f32; 3]], half: usize| entries[half * DIFFERENCE_ANGLES][1];
        assert_eq!(scattered(table, 0.0), table.entries());
        let spread = scattered(table, 0.2);
        // Half angles of 0 and of 24 degrees.
        assert!(at(&spread, 1) < 0.5 * at(table.entries(), 1), "{} {}", at(&spread, 1), at(table.entries(), 1));
        assert!(at(&spread, 25) > 2.0 * at(table.entries(), 25), "{} {}", at(&spread, 25), at(table.entries(), 25));
        // An entry at 35 degrees and a difference angle of 31, by a grid of slopes.
        let (row, column, sigma) = (31usize, 1usize, 0.4);
        let scattered = scattered(table, sigma)[row * DIFFERENCE_ANGLES + column][1];
        let (sine, cosine) = ((1.0f64 - (6.0 / 7.0f64).powi(2)).sqrt(), 6.0 / 7.0);
        let [view, light] = [[sine, 0.0, cosine], [-sine, 0.0, cosine]];
        let single = |v: Vector| v.map(|c| c as f32);
        let (mut sum, mut factor) = (0.0, 0.0);
        for azimuth in 0..64 {
            let normal = from_polar((1.0 - (row as f64 / 47.0).powi(4)).acos(), TAU * f64::from(azimuth) / 64.0);
            let of = |n: Vector| BaseAngles::new(table.axis(), single(n), single(view), single(light));
            let Some(centre) = of(normal) else { continue };
            factor += f64::from(centre.geometry);
            let across = normalize(cross([0.0, 0.0, 1.0], normal));
            let along = cross(normal, across);
            let (mut mean, mut visible) = (0.0, 0.0);
            for k in 0..81 * 81 {
                let [a, b] = [k / 81, k % 81].map(|c| (f64::from(c) - 40.0) / 10.0);
                let density = (-0.5 * (a * a + b * b)).exp();
                let moved = normalize(add_scaled(add_scaled(normal, sigma * a, across), sigma * b, along));
                let seen = density * dot(moved, view).max(0.0);
                visible += seen;
                mean += of(moved).map_or(0.0, |it| seen * f64::from(it.geometry * table.at(&it.taps)[1]));
            }
            sum += mean / visible;
        }
        let expected = (sum / factor) as f32;
        assert!((scattered - expected).abs() < 0.1 * expected, "{scattered} {expected}");
    }

    #[test]
    fn the_number_of_threads_changes_nothing() {
        let made = [1, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| encoded(bumps(16, 0.4), &of("synth:lewis?kd=0.4&ks=0.2&n=20")).decoder)
        });
        assert_eq!(made[0], made[1]);
    }
}
