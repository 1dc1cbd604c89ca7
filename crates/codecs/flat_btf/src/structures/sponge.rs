//! A sponge: pores of several sizes in a rough surface.

use super::noise::{gradient_noise, lattice, mix, periodic_fractal, smooth_step};
use super::relief::{HEIGHT, Pointwise, RESOLUTION, SEED, Sample, StructureInfo};
use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;

pub(super) const INFO: StructureInfo = StructureInfo {
    name: "sponge",
    meaning: "pores of several sizes in a rough surface, a height field; one diffuse material",
    parameters: &[
        RESOLUTION,
        HEIGHT,
        SEED,
        Parameter::integer("count", [2.0, 16.0], 5.0, "places for the largest pores along either side"),
        Parameter::number("porosity", [0.0, 1.0], 0.7, "share of places that have a pore"),
    ],
    materials: &["synth:lambert?kd=0.75"],
    build: |values| Box::new(Sponge { seed: values[2] as u64, count: values[3] as i64, porosity: values[4] }),
};

/// Number of pore sizes, each half the previous one.
const SIZES: u32 = 3;
/// Depth of a pore in radii.
const DEPTH: f64 = 0.9;

struct Sponge {
    seed: u64,
    count: i64,
    porosity: f64,
}

impl Sponge {
    /// Depth of the deepest pore at a point, in tiles, and its depth relative to its floor.
    fn pores(&self, u: f64, v: f64) -> [f64; 2] {
        let mut deepest = [0.0, 0.0];
        for size in 0..SIZES {
            let cells = self.count << size;
            let seed = self.seed ^ (u64::from(size + 1) << 32);
            // Pores are not exactly round.
            let bend = |salt: u64| {
                let period = [2 * cells, 2 * cells];
                0.12 * gradient_noise(u * period[0] as f64, v * period[1] as f64, seed ^ salt, Some(period))
            };
            // Shifted, so that cells of different sizes share no edges.
            let shift = 0.37 * f64::from(size);
            let at = [u * cells as f64 + shift + bend(0x51), v * cells as f64 + shift + bend(0x52)];
            let cell = at.map(|x| x.floor() as i64);
            for [column, row] in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [cell[0] + dx, cell[1] + dy])) {
                let wrapped = [column.rem_euclid(cells), row.rem_euclid(cells)];
                let random = |k: u64| lattice(wrapped[0], wrapped[1], seed ^ (k << 40));
                if random(1) >= self.porosity {
                    continue;
                }
                let radius = mix(0.24, 0.56, random(2));
                let centre = [column as f64 + 0.5 + (random(3) - 0.5), row as f64 + 0.5 + (random(4) - 0.5)];
                let distance = (at[0] - centre[0]).hypot(at[1] - centre[1]) / radius;
                let hollow = 1.0 - smooth_step(0.25, 1.0, distance);
                let depth = DEPTH * radius * hollow * mix(0.7, 1.0, random(5)) / cells as f64;
                if depth > deepest[0] {
                    deepest = [depth, hollow];
                }
            }
        }
        deepest
    }
}

impl Pointwise for Sponge {
    fn sample(&self, u: f64, v: f64) -> Sample {
        let rough = periodic_fractal(u, v, self.seed ^ 0x70, [2 * self.count; 2], 4, 0.55);
        let broad = periodic_fractal(u, v, self.seed ^ 0x71, [2, 2], 2, 0.5);
        let [depth, hollow] = self.pores(u, v);
        let height = 0.02 * broad + 0.045 * rough / self.count as f64 - depth;
        // Darker and browner in pores; patches.
        let shade = (0.93 + 0.1 * broad + 0.05 * rough) * mix(1.0, 0.72, hollow);
        let tint = [0.95, 0.78, 0.42].map(|c: f64| (c.powf(1.0 + 0.35 * hollow) * shade).clamp(0.0, 1.0) as f32);
        ([u, v, height], VertexMaterial { tint, ..VertexMaterial::default() })
    }
}
