//! Look-ups in a prefiltered environment on the CPU.

use super::cube::FacePoint;
use super::header::{EnvironmentHeader, IRRADIANCE_SIDE};
use super::pack::EnvironmentPack;

/// A decoded environment. Look-ups filter across the edges of the cube, as GPUs do.
#[derive(Debug, Clone)]
pub struct EnvironmentDecoder {
    header: EnvironmentHeader,
    /// Mipmap levels, from the finest.
    levels: Vec<Level>,
    irradiance: Level,
}

/// A level whose faces have a border of one texel from their neighbours.
#[derive(Debug, Clone)]
struct Level {
    /// Texels along each side of a face, without the border.
    side: usize,
    /// Six faces of `(side + 2)²` texels, row by row.
    texels: Vec<[f32; 3]>,
}

impl EnvironmentDecoder {
    /// Decodes all texels.
    pub fn new(pack: &EnvironmentPack) -> Self {
        let header = pack.header();
        let level = |level: u32| Level::new((header.side >> level) as usize, &pack.level(level).collect::<Vec<_>>());
        let irradiance = Level::new(IRRADIANCE_SIDE as usize, &pack.irradiance().collect::<Vec<_>>());
        Self { header, levels: (0..header.levels()).map(level).collect(), irradiance }
    }

    /// Sizes and scale of the environment.
    pub fn header(&self) -> EnvironmentHeader {
        self.header
    }

    /// Filtered radiance from a direction of any length but 0, in the frame of the environment, W/(m² sr). A sharpness
    /// of 0 gives the irradiance over π, 1 to the sharpest level narrower and narrower Gaussian kernels, see
    /// [`EnvironmentHeader::deviation`]; fractions blend.
    pub fn radiance(&self, direction: [f32; 3], sharpness: f32) -> [f32; 3] {
        let point = FacePoint::of(direction.map(f64::from));
        let blend = |a: [f32; 3], b: [f32; 3], share: f32| [0, 1, 2].map(|k| a[k] + share * (b[k] - a[k]));
        if sharpness <= 0.0 {
            return self.irradiance.filtered(point);
        }
        let level = self.header.level(sharpness);
        let (finer, share) = (level as usize, level.fract());
        let fine = self.levels[finer].filtered(point);
        if sharpness < 1.0 {
            blend(self.irradiance.filtered(point), fine, sharpness)
        } else if share > 0.0 {
            blend(fine, self.levels[finer + 1].filtered(point), share)
        } else {
            fine
        }
    }
}

impl Level {
    fn new(side: usize, inner: &[[f32; 3]]) -> Self {
        let wide = side + 2;
        let texel = |face: usize, column: usize, row: usize| inner[(face * side + row) * side + column];
        let nearest = |point: FacePoint| {
            let [column, row] = [point.s, point.t].map(|c| ((0.5 * (c + 1.0) * side as f64) as usize).min(side - 1));
            texel(point.face, column, row)
        };
        let is_inside = |at: usize| (1..=side).contains(&at);
        let mut texels = Vec::with_capacity(6 * wide * wide);
        for (face, row, column) in (0..6).flat_map(|f| (0..wide).flat_map(move |r| (0..wide).map(move |c| (f, r, c)))) {
            let across = |column: usize, row: usize| {
                nearest(FacePoint::of(
                    FacePoint::on_grid(face, side, [column as f64 - 0.5, row as f64 - 0.5]).direction(),
                ))
            };
            texels.push(match (is_inside(column), is_inside(row)) {
                (true, true) => texel(face, column - 1, row - 1),
                (false, false) => {
                    // Three faces meet at a corner, and no fourth texel exists: the mean of the three.
                    let [inner_column, inner_row] = [column, row].map(|at| at.clamp(1, side));
                    let three = [
                        across(inner_column, row),
                        across(column, inner_row),
                        texel(face, inner_column - 1, inner_row - 1),
                    ];
                    [0, 1, 2].map(|k| three.iter().map(|texel| texel[k]).sum::<f32>() / 3.0)
                }
                _ => across(column, row),
            });
        }
        Self { side, texels }
    }

    /// Bilinear value at a point.
    fn filtered(&self, point: FacePoint) -> [f32; 3] {
        let [(column, right), (row, down)] = [point.s, point.t].map(|c| {
            let position = 0.5 * (c + 1.0) * self.side as f64 + 0.5;
            let lower = (position as usize).min(self.side);
            (lower, (position - lower as f64) as f32)
        });
        let wide = self.side + 2;
        let first = (point.face * wide + row) * wide + column;
        let [a, b, c, d] = [first, first + 1, first + wide, first + wide + 1].map(|at| self.texels[at]);
        [0, 1, 2].map(|k| {
            let above = a[k] + right * (b[k] - a[k]);
            let below = c[k] + right * (d[k] - c[k]);
            above + down * (below - above)
        })
    }
}
