//! Bandwidth and variance of points that share incident directions.
//!
//! Points of a tile of 4 x 4 each look along a sixteenth of four times `n_b` directions, their own run of the sequence,
//! and reuse the results of the other points of the same part and nearly the same normal: "Interleaved sampling"
//! (Keller and Heidrich 2001). So an average is over up to `4 n_b` directions for the work of `n_b / 4`. If fewer than
//! four points are alike, a point looks along the next runs itself, and the average is over `n_b`. Bandwidth follows
//! the mean curvature of the points that are alike.

use super::{AdaptiveScene, Settings, TexturePoint};
use crate::gbuffer::GBuffer;
use brdfc_formats::bandwidth::brdf_cell;
use brdfc_formats::bandwidth::propagation::{
    Bandwidth, BandwidthAverage, BandwidthSurface, DirectedLight, VarianceEstimate,
};
use rayon::prelude::*;

/// Points along each side of a tile.
const SIDE: usize = 4;
/// Points of a tile.
const POINTS: usize = SIDE * SIDE;
/// Number of shares that make up `n_b` directions.
const ENOUGH: usize = 4;
/// Maximum number of directions: far more than samples of a lobe.
pub const MAX_DIRECTIONS: u32 = 1 << 16;
/// Points are of the same piece of a surface if their normals have at least this cosine, 18°.
const SAME_PIECE: f32 = 0.95;

/// Estimates of all points, row by row; 0 without a surface.
pub(super) struct Estimates {
    /// Weighted mean of the directions, equation 5, in cycles per radian.
    pub mean: Vec<f32>,
    /// Maximum of the directions whose light reaches the viewer, in cycles per radian.
    pub maximum: Vec<f32>,
    /// Visible deviation.
    pub deviation: Vec<f32>,
}

/// Estimates all points of a buffer, whose mean curvatures are `curvature`.
pub(super) fn estimates(
    scene: &AdaptiveScene<'_>,
    buffer: &GBuffer,
    curvature: &[f32],
    settings: &Settings,
) -> Estimates {
    let textures: Vec<_> =
        (0..buffer.part.len()).into_par_iter().map(|point| scene.texture_at(buffer, point)).collect();
    let run = settings.directions.clamp(1, MAX_DIRECTIONS).div_ceil(ENOUGH as u32);
    let tile = Tile { scene, buffer, curvature, textures: &textures, run };
    let zeros = vec![0.0; buffer.part.len()];
    let mut all = Estimates { mean: zeros.clone(), maximum: zeros.clone(), deviation: zeros };
    // Each row of tiles is a task.
    let [mean, maximum, deviation] =
        [&mut all.mean, &mut all.maximum, &mut all.deviation].map(|of| of.par_chunks_mut(SIDE * buffer.width));
    mean.zip(maximum).zip(deviation).enumerate().for_each(|(row, ((mean, maximum), deviation))| {
        let first = row * SIDE * buffer.width;
        for column in (0..buffer.width).step_by(SIDE) {
            let points: [Option<usize>; POINTS] = std::array::from_fn(|k| {
                let (x, point) = (column + k % SIDE, first + k / SIDE * buffer.width + column + k % SIDE);
                (x < buffer.width && point < buffer.part.len() && buffer.part_at(point).is_some()).then_some(point)
            });
            if points.iter().all(Option::is_none) {
                continue;
            }
            let (shares, alike) = (tile.shares(&points), tile.alike(&points));
            for (k, alike) in alike.into_iter().enumerate() {
                let Some(point) = points[k] else { continue };
                let all = tile.joined((k, point), &shares, alike);
                let albedo = scene.materials[tile.part(point)].albedo * textures[point].luminance();
                let luminance = albedo * all.variance.mean();
                mean[point - first] = all.average.mean().angular;
                maximum[point - first] = all.maximum;
                deviation[point - first] = visible_deviation(all.variance.relative(0.0), luminance, settings.white);
            }
        }
    });
    all
}

/// Effect of an error of the estimate on the rendering: standard deviation of one sample in the display's encoded
/// values.
///
/// For `N_i` samples of pixels with displayed values `s(L)`, the sum of squared errors `Σ (σ_i s'(L_i))² / N_i` is
/// least for a given sum of `N_i` if `N_i` is proportional to `σ_i s'(L_i)`. `V` is `σ²` relative to the squared mean.
/// `s` is nearly the power 1/2.2 up to white, and constant above it.
fn visible_deviation(variance: f32, luminance: f32, white: f32) -> f32 {
    let shown = luminance / white;
    let response = if shown < 1.0 { shown.sqrt() } else { 1.0 / (shown * shown) };
    variance.sqrt() * response
}

/// Scene, buffer and settings of the tiles.
struct Tile<'a> {
    scene: &'a AdaptiveScene<'a>,
    buffer: &'a GBuffer,
    curvature: &'a [f32],
    textures: &'a [TexturePoint],
    /// Number of directions per point.
    run: u32,
}

/// Sums over some of the directions of a point.
#[derive(Debug, Clone, Copy, Default)]
struct Share {
    average: BandwidthAverage,
    /// Cycles per radian.
    maximum: f32,
    variance: VarianceEstimate,
}

impl Share {
    fn join(self, other: Self) -> Self {
        Self {
            average: self.average.join(other.average),
            maximum: self.maximum.max(other.maximum),
            variance: self.variance.join(other.variance),
        }
    }
}

impl Tile<'_> {
    /// Part of a point, which must show a surface.
    fn part(&self, point: usize) -> usize {
        self.buffer.part_at(point).expect("points of tiles show a surface")
    }

    /// The share of each point, along its own directions.
    fn shares(&self, points: &[Option<usize>; POINTS]) -> [Share; POINTS] {
        std::array::from_fn(|k| points[k].map_or(Share::default(), |point| self.share(point, k)))
    }

    /// For each point, one bit for each point of the tile that shows the same piece of a surface, including itself.
    fn alike(&self, points: &[Option<usize>; POINTS]) -> [u16; POINTS] {
        let normals = points.map(|point| point.map_or([0.0; 3], |point| self.buffer.normal[point]));
        let parts = points.map(|point| point.map(|point| self.buffer.part[point]));
        let mut alike = std::array::from_fn(|k| 1 << k);
        for a in 0..POINTS {
            for b in 0..a {
                let (m, n) = (normals[a], normals[b]);
                let same = parts[a] == parts[b] && m[0] * n[0] + m[1] * n[1] + m[2] * n[2] >= SAME_PIECE;
                alike[a] |= u16::from(same) << b;
                alike[b] |= u16::from(same) << a;
            }
        }
        alike
    }

    /// Sums the shares for point `k` of a tile, given the points like it.
    fn joined(&self, (k, point): (usize, usize), shares: &[Share; POINTS], alike: u16) -> Share {
        let is_alike = |other: &usize| alike >> other & 1 == 1;
        let joined = (0..POINTS).filter(is_alike).fold(Share::default(), |all, other| all.join(shares[other]));
        let missing = ENOUGH.saturating_sub(alike.count_ones() as usize);
        let next = (k + 1..k + POINTS).map(|other| other % POINTS).filter(|other| !is_alike(other)).take(missing);
        next.fold(joined, |all, other| all.join(self.share(point, other)))
    }

    /// Evaluates a run of directions of a point.
    fn share(&self, point: usize, number: usize) -> Share {
        let frame = self.buffer.frame(point);
        let material = &self.scene.materials[self.part(point)];
        let outgoing = frame.local(self.buffer.to_viewer[point]);
        let outgoing_cell = brdf_cell(outgoing);
        let mut share = Share::default();
        let first = number as u32 * self.run;
        for index in first..first + self.run {
            let (incoming, inverse_density) = material.samples.sample(outgoing, index);
            if inverse_density <= 0.0 {
                share.variance = share.variance.add_range(DirectedLight::default(), 0.0);
                continue;
            }
            let map = self.scene.light.bandwidth();
            let (incoming_cell, texel) = map.cell_and_texel(incoming, frame.world(incoming));
            let light = self.scene.light.at(texel, inverse_density / (ENOUGH as u32 * self.run) as f32);
            let surface = BandwidthSurface {
                cos_incoming: incoming[2],
                cos_outgoing: outgoing[2],
                curvature: self.curvature[point],
                lobe: material.bandwidth.brdf_cells(incoming_cell, outgoing_cell),
                texture: self.textures[point].bandwidth,
            };
            let arrives = Bandwidth::distant(light.bandwidth).one_bounce(0.0, surface, self.buffer.distance[point]);
            let own = surface.albedo(self.buffer.distance[point]).angular;
            let shows = Bandwidth { angular: arrives.angular.max(own), ..arrives };
            share.average = share.average.add(shows, light.radiance);
            if light.radiance > 0.0 {
                share.maximum = share.maximum.max(shows.angular);
            }
            share.variance = share.variance.add_range(light, surface.lobe);
        }
        share
    }
}
