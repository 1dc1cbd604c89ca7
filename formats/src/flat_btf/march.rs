//! Rays of sight and of light through the layers of a relief.

use super::layers::{Column, LayerHeader, LayerMap, Sheet};

/// Numbers of steps of a march. More steps find thinner detail and take more fetches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarchSteps {
    /// Maximum steps of a ray of sight, 1 or more.
    pub sight: u32,
    /// Refinements of its end.
    pub refine: u32,
    /// Maximum steps of a ray of light, 1 or more.
    pub light: u32,
}

impl MarchSteps {
    /// Steps for a relief: enough for rays at 50 degrees from the normal to take steps of 1.5 texels, 6 to 24; three
    /// refinements.
    pub fn of(header: &LayerHeader) -> Self {
        let steps = (1.2 * header.range() * header.size as f32 / TEXELS_PER_STEP).ceil().clamp(6.0, 24.0) as u32;
        Self { sight: steps, refine: 3, light: steps }
    }
}

/// Texels that a step crosses, if the maximum number of steps allows.
const TEXELS_PER_STEP: f32 = 1.5;
/// Least cosine of the polar angle of a ray: flatter rays are raised.
const MIN_COSINE: f32 = 0.0625;
/// Distance from the surface at which rays of light start, in texels.
const RISE: f32 = 0.1;

/// A point of the surface at the end of a ray of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefPoint {
    /// Position over the reference plane in tiles, not wrapped.
    pub at: [f32; 2],
    /// Height in units of the header's range, 0 to 1.
    pub height: f32,
    /// The sheet that the ray met.
    pub sheet: Sheet,
}

/// Position on a segment at which a ray enters the solid, 0 to 1; above 1 if it does not.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    share: f32,
    sheet: Sheet,
}

impl LayerMap {
    /// The point of the surface that a distant eye in the direction `view` sees behind the point `uv` of the reference
    /// plane. `uv` is in tiles and unbounded; `view` is a unit vector. `detail` is the mipmap level, 0 the finest.
    pub fn seen(&self, uv: [f32; 2], view: [f32; 3], detail: f32, steps: MarchSteps) -> ReliefPoint {
        let ([low, _], range) = (self.header().heights, self.header().range());
        let cosine = view[2].max(MIN_COSINE);
        let slope = [view[0] / cosine, view[1] / cosine];
        let high = low + range;
        let start = [uv[0] + slope[0] * high, uv[1] + slope[1] * high];
        let across = [slope[0] * range, slope[1] * range];
        let at = |share: f32| [start[0] - share * across[0], start[1] - share * across[1]];
        let count = self.steps(across, detail, steps.sight);
        let (mut a, mut above) = (0.0f32, self.column(start, detail));
        let (mut b, mut below) = (1.0f32, above);
        let mut met = Crossing { share: 2.0, sheet: Sheet::Base };
        for k in 1..=count {
            b = k as f32 / count as f32;
            below = self.column(at(b), detail);
            met = self.crossing([1.0 - a, 1.0 - b], above, below);
            if met.share <= 1.0 {
                break;
            }
            if k < count {
                a = b;
                above = below;
            }
        }
        if met.share > 1.0 {
            // Rounding at the lowest height.
            met = Crossing { share: 1.0, sheet: Sheet::Base };
        }
        for _ in 0..steps.refine {
            let middle = a + (b - a) * met.share;
            let column = self.column(at(middle), detail);
            let first = self.crossing([1.0 - a, 1.0 - middle], above, column);
            if first.share <= 1.0 {
                (b, below, met) = (middle, column, first);
            } else {
                let second = self.crossing([1.0 - middle, 1.0 - b], column, below);
                met.share = 0.0;
                if second.share <= 1.0 {
                    met = second;
                }
                (a, above) = (middle, column);
            }
        }
        let share = a + (b - a) * met.share;
        ReliefPoint { at: at(share), height: 1.0 - share, sheet: met.sheet }
    }

    /// Fraction, 0 or 1, of the light of a distant source in the direction `light` that reaches a point of the surface
    /// with a unit normal.
    pub fn lit(&self, point: &ReliefPoint, normal: [f32; 3], light: [f32; 3], detail: f32, steps: MarchSteps) -> f32 {
        let (range, side) = (self.header().range(), self.header().side(self.levels_of(detail).0) as f32);
        let rise = RISE / side;
        let start = [point.at[0] + rise * normal[0], point.at[1] + rise * normal[1]];
        let height = point.height + rise * normal[2] / range;
        if height >= 1.0 {
            return 1.0;
        }
        let cosine = light[2].max(MIN_COSINE);
        let up = (1.0 - height) * range;
        let across = [light[0] / cosine * up, light[1] / cosine * up];
        let count = self.steps(across, detail, steps.light);
        let (mut z, mut column) = (height, self.column(start, detail));
        for k in 1..=count {
            let share = k as f32 / count as f32;
            let next = self.column([start[0] + share * across[0], start[1] + share * across[1]], detail);
            let above = height + share * (1.0 - height);
            if self.crossing([z, above], column, next).share <= 1.0 {
                return 0.0;
            }
            (z, column) = (above, next);
        }
        1.0
    }

    /// Number of steps of a ray that crosses `across`, in tiles.
    fn steps(&self, across: [f32; 2], detail: f32, most: u32) -> u32 {
        let side = self.header().side(self.levels_of(detail).0) as f32;
        let texels = (across[0] * across[0] + across[1] * across[1]).sqrt() * side;
        (texels / TEXELS_PER_STEP).ceil().max(1.0).min(most.max(1) as f32) as u32
    }

    /// First share of a segment of a ray, from height `z[0]` to `z[1]`, inside the solid. Heights of columns are
    /// linear in between.
    fn crossing(&self, z: [f32; 2], from: Column, to: Column) -> Crossing {
        let [into_base, _] = above_zero(from[0] - z[0], to[0] - z[1]);
        let mut found = Crossing { share: into_base, sheet: Sheet::Base };
        if self.header().sheets > 1 {
            let [below_top, last_below] = above_zero(from[1] - z[0], to[1] - z[1]);
            let [above_underside, last_above] = above_zero(z[0] - from[2], z[1] - to[2]);
            let first = below_top.max(above_underside);
            if first <= last_below.min(last_above) && first < found.share {
                let sheet = if below_top >= above_underside { Sheet::Top } else { Sheet::Underside };
                found = Crossing { share: first, sheet };
            }
        }
        found
    }
}

/// First and last share of a segment at which a linear function is at least 0: 2 and -1 if nowhere.
fn above_zero(from: f32, to: f32) -> [f32; 2] {
    let zero = from / (from - to);
    let (at_first, at_last) = (from >= 0.0, to >= 0.0);
    let first = if at_first {
        0.0
    } else if at_last {
        zero
    } else {
        2.0
    };
    let last = if at_last {
        1.0
    } else if at_first {
        zero
    } else {
        -1.0
    };
    [first, last]
}
