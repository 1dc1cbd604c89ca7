//! Bandwidth and variance of points that share incident directions.
//!
//! Points of a tile of 4 x 4 each look along a sixteenth of four times `n_b` directions, different ones, and take over what
//! the other points of the same part and nearly the same normal have found along theirs: "Interleaved sampling" (Keller and
//! Heidrich 2001). So an average is over as many as `4 n_b` directions for the work of `n_b / 4`. Where fewer than four
//! points are alike, a point looks along the missing directions itself, and the average is over `n_b`.

use super::{AdaptiveScene, Settings};
use crate::render::gbuffer::GBuffer;
use brdfc_formats::bandwidth_propagation::{Bandwidth, BandwidthAverage, DirectedLight, Surface, VarianceEstimate};
use brdfc_formats::pack::bandwidth::brdf_cell;
use rayon::prelude::*;

/// Points along each side of a tile.
const SIDE: usize = 4;
/// Points of a tile.
const POINTS: usize = SIDE * SIDE;
/// Shares that make `n_b` directions.
const ENOUGH: usize = 4;
/// Points whose normals have at least this cosine, 18°, are of the same piece of a surface.
const SAME_PIECE: f32 = 0.95;

/// Cycles per radian and, by the rule `deviation` from relative variance, luminance and white, deviation of all points, row by
/// row; 0 where no surface is.
pub(super) fn bandwidth_and_deviation(
    scene: &AdaptiveScene<'_>,
    buffer: &GBuffer,
    curvature: &[f32],
    settings: &Settings,
    deviation: fn(f32, f32, f32) -> f32,
) -> (Vec<f32>, Vec<f32>) {
    let tile = Tile { scene, buffer, curvature, directions: settings.directions };
    let columns = buffer.width.div_ceil(SIDE);
    let points = |at: usize| -> [Option<usize>; POINTS] {
        let (x, y) = (at % columns * SIDE, at / columns * SIDE);
        std::array::from_fn(|k| {
            let (x, y) = (x + k % SIDE, y + k / SIDE);
            let point = y * buffer.width + x;
            (x < buffer.width && y < buffer.height && buffer.part_at(point).is_some()).then_some(point)
        })
    };
    let found = |at: usize| {
        let points = points(at);
        let shares = tile.shares(&points);
        let values = std::array::from_fn::<_, POINTS, _>(|k| {
            let point = points[k]?;
            let all = tile.joined(&points, &shares, k);
            let luminance = scene.materials[tile.part(point)].albedo * all.variance.mean();
            let deviation = deviation(all.variance.relative(0.0), luminance, settings.white);
            Some((point, all.average.mean().angular, deviation))
        });
        values
    };
    let tiles: Vec<_> = (0..columns * buffer.height.div_ceil(SIDE)).into_par_iter().map(found).collect();
    let (mut angular, mut deviation) = (vec![0.0; buffer.part.len()], vec![0.0; buffer.part.len()]);
    for (point, of_angle, of_sample) in tiles.into_iter().flatten().flatten() {
        (angular[point], deviation[point]) = (of_angle, of_sample);
    }
    (angular, deviation)
}

/// What tiles are looked up in.
struct Tile<'a> {
    scene: &'a AdaptiveScene<'a>,
    buffer: &'a GBuffer,
    curvature: &'a [f32],
    directions: u32,
}

/// What some of the directions of a point find.
#[derive(Debug, Clone, Copy, Default)]
struct Share {
    average: BandwidthAverage,
    variance: VarianceEstimate,
}

impl Share {
    fn join(self, other: Self) -> Self {
        Self { average: self.average.join(other.average), variance: self.variance.join(other.variance) }
    }
}

impl Tile<'_> {
    /// Of a point that shows a surface.
    fn part(&self, point: usize) -> usize {
        self.buffer.part_at(point).expect("points of tiles show a surface")
    }

    /// What each point finds along its own directions.
    fn shares(&self, points: &[Option<usize>; POINTS]) -> [Share; POINTS] {
        std::array::from_fn(|k| points[k].map_or(Share::default(), |point| self.share(point, k)))
    }

    /// All that counts for point `k`.
    fn joined(&self, points: &[Option<usize>; POINTS], shares: &[Share; POINTS], k: usize) -> Share {
        let point = points[k].expect("a point of the tile");
        let is_taken = |other: usize| points[other].is_some_and(|other| self.is_same_piece(point, other));
        let (mut all, mut count) = (Share::default(), 0);
        for other in 0..POINTS {
            if other == k || is_taken(other) {
                all = all.join(shares[other]);
                count += 1;
            }
        }
        for other in 0..POINTS {
            if count >= ENOUGH {
                break;
            }
            if other != k && !is_taken(other) {
                all = all.join(self.share(point, other));
                count += 1;
            }
        }
        all
    }

    fn is_same_piece(&self, a: usize, b: usize) -> bool {
        let (m, n) = (self.buffer.normal[a], self.buffer.normal[b]);
        self.buffer.part[a] == self.buffer.part[b] && m[0] * n[0] + m[1] * n[1] + m[2] * n[2] >= SAME_PIECE
    }

    /// Of every sixteenth direction from `first` on.
    fn share(&self, point: usize, first: usize) -> Share {
        let frame = self.buffer.frame(point);
        let material = &self.scene.materials[self.part(point)];
        let outgoing = frame.local(self.buffer.to_viewer[point]);
        let outgoing_cell = brdf_cell(outgoing);
        let mut share = Share::default();
        for index in (first as u32..ENOUGH as u32 * self.directions).step_by(POINTS) {
            let (incoming, inverse_density) = material.samples.sample(outgoing, index);
            if inverse_density <= 0.0 {
                share.variance = share.variance.add_range(DirectedLight::default(), 0.0);
                continue;
            }
            let light = self.scene.light.at(frame.world(incoming), inverse_density / self.directions as f32);
            let surface = Surface {
                cos_incoming: incoming[2],
                cos_outgoing: outgoing[2],
                curvature: self.curvature[point],
                lobe: material.bandwidth.brdf_cells(brdf_cell(incoming), outgoing_cell),
                texture: 0.0,
            };
            let arrives = Bandwidth::distant(light.bandwidth).one_bounce(0.0, surface, self.buffer.distance[point]);
            share.average = share.average.add(arrives, light.radiance);
            share.variance = share.variance.add_range(light, surface.lobe);
        }
        share
    }
}
