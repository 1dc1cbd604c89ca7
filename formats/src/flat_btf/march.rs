//! Rays of sight and of light through the layers of a relief.

use super::layers::{Column, LayerHeader, LayerMap, Sheet};

/// Numbers of steps of a march. More steps find thinner detail and take more fetches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MarchSteps {
    /// Maximum steps of a ray of sight, 1 or more.
    pub sight: u32,
    /// Refinements of its end.
    pub refine: u32,
    /// Maximum steps of a ray of sight and a ray of light together: the less the first takes, the more has the second,
    /// at least 1.
    pub both: u32,
}

impl MarchSteps {
    /// Without layers there are no rays.
    pub(super) const NONE: Self = Self { sight: 0, refine: 0, both: 0 };

    /// Steps for a relief: enough for rays of sight at 50 degrees from the normal to take steps of 1.5 texels, 6 to 19;
    /// three refinements; and twice as many for both rays, up to 30.
    pub fn of(header: &LayerHeader) -> Self {
        let sight = (1.2 * header.range() * header.size as f32 / TEXELS_PER_STEP).ceil().clamp(6.0, 19.0) as u32;
        Self { sight, refine: 3, both: (2 * sight).min(30) }
    }
}

/// Texels that a step crosses, if the maximum number of steps allows.
const TEXELS_PER_STEP: f32 = 1.5;
/// Least cosine of the polar angle of a ray: flatter rays are raised.
const MIN_COSINE: f32 = 0.0625;
/// Largest tangent of the polar angle of a ray.
pub const MAX_SLOPE: f32 = 1.0 / MIN_COSINE;
/// Least number of steps of a ray that leaves a convex surface again, if the maximum allows.
const MIN_PASSING_STEPS: f32 = 4.0;
/// Distance from the surface at which rays of light start, in texels.
const RISE: f32 = 0.1;

/// The surface that a relief covers, around a point that is drawn: the plane, or a curved surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MacroSurface {
    /// Second derivatives of the surface's depth below its tangent plane, along tangent and bitangent, in 1 / tile: uu,
    /// uv, vv. Positive where the surface is convex.
    pub curvature: [f32; 3],
    /// Height of the point above the reference plane, in tiles.
    pub height: f32,
    /// Change of the coordinates u and v, in tiles, over one side of a tile along tangent and bitangent: ut, ub, vt, vb.
    /// The side of a tile is the root of its area, so that the determinant is 1, or -1 where the tile is mirrored. See
    /// [`MacroSurface::SQUARE`].
    pub stretch: [f32; 4],
}

impl MacroSurface {
    /// Stretch of square tiles along the tangent.
    pub const SQUARE: [f32; 4] = [1.0, 0.0, 0.0, 1.0];
    /// Largest change of coordinates of a stretched tile: at the pole of a ball tiles have no width.
    pub const MAX_STRETCH: f32 = 16.0;
    /// The reference plane itself.
    pub const PLANE: Self = Self { curvature: [0.0; 3], height: 0.0, stretch: Self::SQUARE };

    /// Change of the normal between the point that is drawn and one `along` the surface, in sides of a tile: x and y of
    /// the other normal in the frame of the first, with z = 1.
    pub(super) fn tilt(&self, along: [f32; 2]) -> [f32; 2] {
        product(self.curvature, along)
    }

    /// Distance along tangent and bitangent, in sides of a tile, over a change of the coordinates: the inverse of
    /// [`Self::tiles`], 0 if there is none; `flat_btf_from_tiles` of the shader.
    pub(super) fn distance_over_tiles(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let [ut, ub, vt, vb] = self.stretch;
        let determinant = ut * vb - ub * vt;
        if determinant == 0.0 {
            return [0.0; 2];
        }
        [(vb * u - ub * v) / determinant, (ut * v - vt * u) / determinant]
    }

    /// A direction in the frame along u and v, to which sampled directions refer: the rotation, or for mirrored tiles the
    /// reflection, that is nearest to the stretch.
    pub(super) fn aligned(&self, [x, y, z]: [f32; 3]) -> [f32; 3] {
        let [ut, ub, vt, vb] = self.stretch;
        let sign = if ut * vb - ub * vt < 0.0 { -1.0 } else { 1.0 };
        let (p, q) = (ut + sign * vb, ub - sign * vt);
        let length = (p * p + q * q).sqrt();
        if self.stretch == Self::SQUARE || length == 0.0 {
            return [x, y, z];
        }
        [(p * x + q * y) / length, (p * y - q * x) * sign / length, z]
    }

    /// A unit normal of the relief on square tiles, as it is on stretched tiles.
    pub(super) fn stretched(&self, normal: [f32; 3]) -> [f32; 3] {
        if self.stretch == Self::SQUARE {
            return normal;
        }
        let ([ut, ub, vt, vb], [x, y, z]) = (self.stretch, normal);
        let [x, y] = [ut * x + vt * y, ub * x + vb * y];
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }

    /// Change of the coordinates, in tiles, over a distance along tangent and bitangent in sides of a tile.
    fn tiles(&self, [x, y]: [f32; 2]) -> [f32; 2] {
        let [ut, ub, vt, vb] = self.stretch;
        [ut * x + ub * y, vt * x + vb * y]
    }

    /// Curvature of the parallel surface at a height, in tiles.
    fn at(&self, height: f32) -> [f32; 3] {
        let [uu, uv, vv] = self.curvature;
        let (along, across) = (1.0 + height * uu, 1.0 + height * vv);
        let determinant = (along * across - height * uv * (height * uv)).max(MIN_AREA_RATIO);
        [
            (uu * across - height * uv * uv) / determinant,
            uv / determinant,
            (vv * along - height * uv * uv) / determinant,
        ]
    }
}

/// Least ratio of areas at two heights: a relief as high as the radius of a surface is not drawn right.
const MIN_AREA_RATIO: f32 = 0.0625;

/// Product of a symmetric matrix, uu, uv, vv, and a vector.
fn product([uu, uv, vv]: [f32; 3], [x, y]: [f32; 2]) -> [f32; 2] {
    [uu * x + uv * y, uv * x + vv * y]
}

/// Tangent of the polar angle of a direction, along tangent and bitangent.
pub(super) fn slope(direction: [f32; 3]) -> [f32; 2] {
    let cosine = direction[2].max(MIN_COSINE);
    [direction[0] / cosine, direction[1] / cosine]
}

/// A point of the surface at the end of a ray of sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReliefPoint {
    /// Position over the reference plane in tiles, not wrapped.
    pub at: [f32; 2],
    /// Height in units of the header's range, 0 to 1. Below 0 if the ray passes the relief of a convex surface and
    /// leaves it again. 0 for an indirection map, which has no range.
    pub height: f32,
    /// The sheet that the ray met.
    pub sheet: Sheet,
    /// Height above the point that is drawn, in its frame and in tiles: the ray went on by this over its cosine.
    pub rise: f32,
    /// Steps that the ray took.
    pub steps: u32,
}

/// A ray over a surface, from `t = 0` to `last`. Over a plane it is straight.
#[derive(Debug, Clone, Copy)]
struct Ray {
    start: [f32; 2],
    /// Tiles that it crosses per unit of t at its start.
    across: [f32; 2],
    /// Half the change of that with t: tiles are longer, the higher above a convex surface.
    turn: [f32; 2],
    /// Height at the start, 0 to 1, its change with t, and half the change of that.
    height: f32,
    climb: f32,
    bend: f32,
    last: f32,
    /// The ray leaves a convex surface again without having reached the lowest point.
    passes: bool,
}

impl Ray {
    fn at(&self, t: f32) -> [f32; 2] {
        [0, 1].map(|k| self.start[k] + t * self.across[k] + t * t * self.turn[k])
    }

    fn height(&self, t: f32) -> f32 {
        self.height + t * self.climb + t * t * self.bend
    }
}

/// Position on a segment at which a ray enters the solid, 0 to 1; above 1 if it does not.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    share: f32,
    sheet: Sheet,
}

impl LayerMap {
    /// The point of the surface that a distant eye in the direction `view` sees behind the point `uv` of a surface
    /// that the relief covers. `uv` is in tiles and unbounded; `view` is a unit vector. `detail` is the mipmap level, 0
    /// the finest.
    pub fn seen(
        &self,
        uv: [f32; 2],
        view: [f32; 3],
        surface: MacroSurface,
        detail: f32,
        steps: MarchSteps,
    ) -> ReliefPoint {
        let (ray, back) = self.ray_of_sight(uv, view, surface);
        let count = self.steps(&ray, detail, steps.sight);
        let (mut a, mut above) = (0.0f32, self.column(ray.start, detail));
        let (mut b, mut below) = (ray.last, above);
        let mut met = Crossing { share: 2.0, sheet: Sheet::Base };
        let mut taken = count;
        for k in 1..=count {
            b = ray.last * (k as f32 / count as f32);
            below = self.column(ray.at(b), detail);
            met = self.crossing([ray.height(a), ray.height(b)], above, below);
            if met.share <= 1.0 {
                taken = k;
                break;
            }
            if k < count {
                a = b;
                above = below;
            }
        }
        if met.share > 1.0 {
            if ray.passes {
                return ReliefPoint { at: ray.at(ray.last), height: -1.0, sheet: Sheet::Base, rise: 0.0, steps: taken };
            }
            // Rounding at the lowest height.
            met = Crossing { share: 1.0, sheet: Sheet::Base };
        }
        for _ in 0..steps.refine {
            let middle = a + (b - a) * met.share;
            let column = self.column(ray.at(middle), detail);
            let first = self.crossing([ray.height(a), ray.height(middle)], above, column);
            if first.share <= 1.0 {
                (b, below, met) = (middle, column, first);
            } else {
                let second = self.crossing([ray.height(middle), ray.height(b)], column, below);
                met.share = 0.0;
                if second.share <= 1.0 {
                    met = second;
                }
                (a, above) = (middle, column);
            }
        }
        let share = a + (b - a) * met.share;
        let rise = back - share * self.header().range();
        ReliefPoint { at: ray.at(share), height: ray.height(share), sheet: met.sheet, rise, steps: taken }
    }

    /// Fraction, 0 or 1, of the light of a distant source in the direction `light` that reaches a point of the surface
    /// with a unit normal.
    pub fn lit(
        &self,
        point: &ReliefPoint,
        normal: [f32; 3],
        light: [f32; 3],
        surface: MacroSurface,
        detail: f32,
        steps: MarchSteps,
    ) -> f32 {
        self.lit_counted(point, normal, light, surface, detail, steps).0
    }

    /// The result of [`Self::lit`] and the number of columns that it takes.
    pub(super) fn lit_counted(
        &self,
        point: &ReliefPoint,
        normal: [f32; 3],
        light: [f32; 3],
        surface: MacroSurface,
        detail: f32,
        steps: MarchSteps,
    ) -> (f32, u32) {
        let rise = RISE / self.header().side(self.levels_of(detail).0) as f32;
        let [x, y] = surface.tiles([normal[0], normal[1]]);
        let start = [point.at[0] + rise * x, point.at[1] + rise * y];
        let mut column = self.column(start, detail);
        let range = self.header().range();
        let height = point.height + rise * normal[2] / range;
        // Steps may have left the point a little inside the solid.
        let above = rise / range;
        let height = match point.sheet {
            Sheet::Underside => height.min(column[2] - above),
            sheet => height.max(column[sheet as usize] + above),
        };
        if height >= 1.0 {
            return (1.0, 1);
        }
        let ray = self.ray_of_light(start, height, light, surface);
        let count = self.steps(&ray, detail, steps.both.saturating_sub(point.steps));
        let mut z = height;
        for k in 1..=count {
            let share = ray.last * (k as f32 / count as f32);
            let (next, end) = (self.column(ray.at(share), detail), ray.height(share));
            if self.crossing([z, end], column, next).share <= 1.0 {
                return (0.0, k + 1);
            }
            (z, column) = (end, next);
        }
        (1.0, count + 1)
    }

    /// The ray of sight from the highest point of the relief down, or over a concave surface from its own highest point;
    /// and the height of its start above the point that is drawn, in the frame of that point and in tiles.
    fn ray_of_sight(&self, uv: [f32; 2], view: [f32; 3], surface: MacroSurface) -> (Ray, f32) {
        let ([low, _], range) = (self.header().heights, self.header().range());
        let (slope, curvature) = (slope(view), surface.at(surface.height));
        let turned = product(curvature, slope);
        let bend = slope[0] * turned[0] + slope[1] * turned[1];
        let along = [0, 1].map(|k| slope[k] - surface.height * turned[k]);
        let turn = product(curvature, along);
        // Back up.
        let highest = low + range - surface.height;
        let high = if bend < 0.0 { highest.min(-0.5 / bend) } else { highest };
        let squared = (1.0 + 2.0 * bend * high).max(0.0);
        let fall = squared.sqrt();
        let back = 2.0 * high / (1.0 + fall);
        let height = 1.0 - (highest - high) / range;
        let bend = 0.5 * bend * range;
        let discriminant = squared - 4.0 * bend * height;
        let passes = discriminant < 0.0;
        let [x, y] = surface.tiles([0, 1].map(|k| along[k] - back * turn[k]));
        let ray = Ray {
            start: [uv[0] + back * x, uv[1] + back * y],
            across: surface.tiles([0, 1].map(|k| 2.0 * back * turn[k] - along[k])).map(|c| range * c),
            turn: surface.tiles(turn).map(|c| -(range * range * c)),
            height,
            climb: -fall,
            bend,
            // Where it reaches the lowest height, or else the height of its start again.
            last: if passes { fall / bend } else { 2.0 * height / (fall + discriminant.sqrt()) },
            passes,
        };
        (ray, back)
    }

    /// The ray of light from a point up to the highest point of the relief, or over a concave surface to its own.
    fn ray_of_light(&self, start: [f32; 2], height: f32, light: [f32; 3], surface: MacroSurface) -> Ray {
        let ([low, _], range) = (self.header().heights, self.header().range());
        let above = low + height * range;
        let (slope, curvature) = (slope(light), surface.at(above));
        let turned = product(curvature, slope);
        let along = [0, 1].map(|k| slope[k] - above * turned[k]);
        let turn = product(curvature, along);
        let up = (1.0 - height) * range;
        let bend = 0.5 * (slope[0] * turned[0] + slope[1] * turned[1]) * up;
        let discriminant = 1.0 + 4.0 * bend;
        Ray {
            start,
            across: surface.tiles(along).map(|c| up * c),
            turn: surface.tiles(turn).map(|c| -(up * up * c)),
            height,
            climb: 1.0 - height,
            bend: bend * (1.0 - height),
            last: if discriminant < 0.0 { -0.5 / bend } else { 2.0 / (1.0 + discriminant.sqrt()) },
            passes: false,
        }
    }

    /// Number of steps of a ray.
    fn steps(&self, ray: &Ray, detail: f32, most: u32) -> u32 {
        let side = self.header().side(self.levels_of(detail).0) as f32;
        let across = [ray.last * ray.across[0], ray.last * ray.across[1]];
        // A ray that starts and ends at the same height needs some in between.
        let least = if ray.passes { MIN_PASSING_STEPS } else { 1.0 };
        let texels = (across[0] * across[0] + across[1] * across[1]).sqrt() * side;
        (texels / TEXELS_PER_STEP).ceil().max(least).min(most.max(1) as f32) as u32
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
