//! A knitted fabric: columns of V-shaped stitches of twisted yarn.

use super::noise::{lattice, mix, periodic_fractal, smooth_step};
use super::relief::{HEIGHT, Pointwise, RESOLUTION, SEED, Sample, StructureInfo};
use crate::mesh::VertexMaterial;
use brdfc_core::analytic::Parameter;
use std::f64::consts::TAU;

pub(super) const INFO: StructureInfo = StructureInfo {
    name: "knit",
    meaning: "rows of V-shaped stitches of twisted yarn, a height field; two materials",
    parameters: &[
        RESOLUTION,
        HEIGHT,
        SEED,
        Parameter::integer("count", [2.0, 16.0], 5.0, "columns of stitches; three rows per two columns"),
        Parameter::number("irregularity", [0.0, 1.0], 0.5, "how much stitches differ"),
    ],
    materials: &["synth:velvet?kd=0.45&ks=0.3&sx=0.6&sy=0.6", "synth:lewis?kd=0.5&ks=0.15&n=15"],
    build: |values| {
        let columns = values[3] as i64;
        Box::new(Knit { seed: values[2] as u64, columns, rows: (3 * columns + 1) / 2, irregularity: values[4] })
    },
};

/// Half axes of a leg, along and across, in widths of a column.
const LEG: [f64; 2] = [0.62, 0.235];
/// Slope of a leg, columns per column along the fabric: tangent of its angle to the column.
const SLANT: f64 = 0.42;
/// Height of a leg, in widths of a column.
const RELIEF: f64 = 0.24;

struct Knit {
    seed: u64,
    columns: i64,
    rows: i64,
    irregularity: f64,
}

/// The topmost yarn at a point.
struct Top {
    height: f64,
    row: i64,
    /// Random number of the stitch, 0 to 1.
    stitch: f64,
    /// Height above the groove between fibres, 0 to 1.
    fibre: f64,
}

impl Knit {
    fn top(&self, x: f64, y: f64) -> Top {
        // Coordinates in widths of a column.
        let at = [x * self.columns as f64, y * self.columns as f64];
        let row_height = self.columns as f64 / self.rows as f64;
        let (half, row) = ((2.0 * at[0]).floor() as i64, (at[1] / row_height).floor() as i64);
        // The yarn under the stitches, where no leg covers it.
        let mut top = Top { height: 0.0, row: row.rem_euclid(self.rows), stitch: 0.5, fibre: 0.0 };
        for (half, row) in (-1..=1).flat_map(|dx| (-2..=2).map(move |dy| (half + dx, row + dy))) {
            let wrapped = [half.rem_euclid(2 * self.columns), row.rem_euclid(self.rows)];
            let random = |k: u64| lattice(wrapped[0], wrapped[1], self.seed ^ (k << 40));
            let vary = |k: u64, amount: f64| self.irregularity * amount * (2.0 * random(k) - 1.0);
            let centre = [0.5 * half as f64 + 0.25 + vary(1, 0.04), (row as f64 + 0.5) * row_height + vary(2, 0.07)];
            let away = [at[0] - centre[0], at[1] - centre[1]];
            // The legs of a V lean apart.
            let side = if half.rem_euclid(2) == 0 { -1.0 } else { 1.0 };
            let slant = side * (SLANT + vary(3, 0.1));
            let length = 1.0f64.hypot(slant);
            let along = (slant * away[0] + away[1]) / length;
            let across = (away[0] - slant * away[1]) / length;
            let width = LEG[1] * (1.0 + vary(4, 0.12));
            let [a, b] = [along / LEG[0], across / width];
            let inside = 1.0 - a * a - b * b;
            if inside <= 0.0 {
                continue;
            }
            // The yarn is round where it is on top and dives under its neighbours at its ends.
            let body = (1.0 + vary(5, 0.12)) * inside.powf(0.6) - 0.12 * side * a;
            // Plies wind around the yarn: oblique grooves across it.
            let turns = 3.6 * along / LEG[0] + 1.3 * side * b + random(6);
            let fibre = 0.5 + 0.5 * (TAU * turns * 0.5).cos();
            let height = RELIEF * (body + 0.085 * (fibre - 0.5) * inside.sqrt());
            if height > top.height {
                top = Top { height, row: wrapped[1], stitch: random(7), fibre };
            }
        }
        top
    }
}

impl Pointwise for Knit {
    fn sample(&self, u: f64, v: f64) -> Sample {
        let top = self.top(u, v);
        let fine = periodic_fractal(u, v, self.seed ^ 0xf1b, [8 * self.columns, 4 * self.columns], 2, 0.5);
        let wave = periodic_fractal(u, v, self.seed ^ 0x3a7e, [2, 2], 1, 0.5);
        let height = (top.height + self.irregularity * (0.006 * fine + 0.05 * wave)) / self.columns as f64;
        // One yarn makes one row.
        let yarn = |k: u64| lattice(0, top.row, self.seed ^ (k << 48));
        let shade = mix(0.72, 1.0, yarn(1)) * mix(0.88, 1.0, top.stitch) * mix(0.82, 1.0, top.fibre);
        let deep = mix(0.7, 1.0, smooth_step(0.0, 0.6 * RELIEF, top.height));
        let dye = if yarn(2) < 0.3 { [0.85, 0.8, 0.68] } else { [0.62, 0.2, 0.16] };
        let tint = dye.map(|d: f64| ((d * shade + 0.02 * fine) * deep).clamp(0.0, 1.0) as f32);
        let glossy = (mix(0.1, 0.7, yarn(3)) * mix(0.5, 1.0, top.fibre)) as f32;
        ([u, v, height], VertexMaterial { weights: [1.0 - glossy, glossy, 0.0, 0.0], tint })
    }
}
