//! Compact samples of indirection maps, a sixteenth of the bytes for blocks of 2 x 2 texels: displacements in the frame of
//! the view, divided by their growth towards the horizon, as bytes between two bounds for each block.

use crate::factored::with_mipmaps;
use crate::model::MesoModel;
use crate::vdim::MeasuredVdim;
use brdfc_formats::FormatError;
use brdfc_formats::container::half;
use brdfc_formats::flat_btf::{CompactSamples, MAX_HEIGHT, Vdim, VdimHeader, VdimSamples};
use rayon::prelude::*;

/// Maximum blocks per side. With 16 x 16 views the blocks of all levels take 11 MiB.
const MAX_BLOCKS: u32 = 128;
/// Maximum distance from the parameters of the middle texel, along each axis and in texels, on the same side of a silhouette.
const SAME_SIDE: f64 = 4.0;

/// Texels per side of a block for a plane of `texels` per side, a power of two.
pub fn texels_of_block(texels: u32) -> u32 {
    texels.div_ceil(MAX_BLOCKS)
}

/// Heights of a surface over its parameters, on all levels of a map.
pub struct ParameterHeights {
    /// Heights of byte 0 and of byte 255, in tiles.
    range: [f32; 2],
    bytes: Vec<u8>,
    finest: VdimHeader,
}

impl ParameterHeights {
    /// Heights of the texels of a map, whose header is `finest`.
    pub fn new(model: &MesoModel, finest: &VdimHeader) -> Self {
        let [low, high] = model.mesh.height_range();
        // A plane has a range, too.
        let margin = 1e-3 + 1e-3 * (high - low);
        let range = [low - margin, high + margin].map(|z| (z as f32).clamp(-MAX_HEIGHT, MAX_HEIGHT));
        let share = |z: f64| (z - f64::from(range[0])) / f64::from(range[1] - range[0]);
        let byte = |z: f64| (255.0 * share(z).clamp(0.0, 1.0)).round() as u8;
        let size = finest.size as usize;
        let bytes: Vec<u8> = model.texels(size).points.iter().map(|point| byte(point.position[2])).collect();
        let bytes = with_mipmaps(&bytes, &vec![1.0; size * size], 1, finest.levels);
        Self { range, bytes, finest: *finest }
    }

    /// Heights of the level that has `size` texels per side.
    fn of_level(&self, size: u32) -> Vec<u8> {
        let level = (self.finest.size / size).ilog2();
        let [first, end] =
            [level, level + 1].map(|level| self.finest.reference_extent().texels_of_levels(level) as usize);
        self.bytes[first..end].to_vec()
    }
}

impl MeasuredVdim {
    /// Rounds to a map of compact samples with blocks of `texels` x `texels`. Each block stores the medoid of its texels' displacements in a view, the one
    /// nearest to the others: a mean over both sides of a silhouette would be a point that none of them sees.
    ///
    /// Along the normal, texels of a block may see another side of a silhouette than the texel in its middle, so that the
    /// block's displacement does not apply to their parameters. They take a reference that continues from that texel.
    ///
    /// # Errors
    /// Returns an error if the header or a number is out of range.
    pub fn compact(&self, texels: u32, heights: &ParameterHeights) -> Result<Vdim, FormatError> {
        let header = VdimHeader { block: texels, ..self.header };
        header.check()?;
        let VdimHeader { size, polar_angles, azimuth_rows, .. } = header;
        let blocks = size / texels;
        let made: Vec<Block> = (0..blocks * blocks)
            .into_par_iter()
            .map(|at| Block::new(self, texels, [at % blocks * texels, at / blocks * texels]))
            .collect();
        let (width, rows) = (blocks * polar_angles, azimuth_rows);
        let packed = (0..width * blocks * rows).map(|at| {
            let (column, row) = (at % width, at / width);
            let (i, j, k, a) = (column / polar_angles, row / rows, column % polar_angles, row % rows % (rows - 1));
            made[(j * blocks + i) as usize].bytes[(a * polar_angles + k) as usize]
        });
        let reference = (0..size * size).map(|at| {
            let [i, j] = [at % size, at / size];
            let inside = j % texels * texels + i % texels;
            made[(j / texels * blocks + i / texels) as usize].references[inside as usize]
        });
        let bounds = |of: usize| made.iter().map(move |block| block.bounds[of]);
        let ranges = bounds(0).chain(bounds(1)).collect();
        let heights_of_level = heights.of_level(size);
        let samples =
            CompactSamples { range: heights.range, ranges, packed: packed.collect(), heights: heights_of_level };
        Vdim::new(header, reference.collect(), VdimSamples::Compact(samples))
    }
}

/// A block as stored.
struct Block {
    /// Of its texels, row by row.
    references: Vec<[f32; 2]>,
    /// Minima and extents.
    bounds: [[f32; 2]; 2],
    /// Azimuth by azimuth, below the last row.
    bytes: Vec<[u8; 2]>,
}

impl Block {
    /// The block of `block` x `block` texels of which `corner` is the first.
    fn new(map: &MeasuredVdim, block: u32, corner: [u32; 2]) -> Self {
        let VdimHeader { size, polar_angles, azimuth_rows, .. } = map.header;
        let texels: Vec<[u32; 2]> =
            (0..block * block).map(|k| [corner[0] + k % block, corner[1] + k / block]).collect();
        // Both less the centres of the texels.
        let own: Vec<[f64; 2]> =
            texels.iter().map(|[i, j]| map.reference[(j * size + i) as usize].map(f64::from)).collect();
        let references = on_one_side(&own, SAME_SIDE / f64::from(size));
        let mut values = Vec::with_capacity((polar_angles * (azimuth_rows - 1)) as usize);
        for a in 0..azimuth_rows - 1 {
            for k in 0..polar_angles {
                let (azimuth, growth) = (map.header.view_angles(k, a)[1], map.header.growth(k));
                let of_texel = |at: usize| {
                    let moved = map.seen(texels[at], k, a).displacement;
                    let moved = [0, 1].map(|c| f64::from(moved[c]) + own[at][c] - references[at][c]);
                    in_view(moved, azimuth, growth)
                };
                let seen: Vec<[f64; 2]> = (0..texels.len()).map(of_texel).collect();
                values.push(seen[medoid(&seen)]);
            }
        }
        let bounds = bounds(&values);
        let byte = |value: f64, axis: usize| {
            let [low, extent] = bounds.map(|bound| f64::from(bound[axis]));
            if extent > 0.0 { (255.0 * ((value - low) / extent).clamp(0.0, 1.0)).round() as u8 } else { 0 }
        };
        let bytes = values.iter().map(|value| [byte(value[0], 0), byte(value[1], 1)]).collect();
        Self { references: references.into_iter().map(|r| r.map(|c| c as f32)).collect(), bounds, bytes }
    }
}

/// References of the texels of a block, less their centres: those on another side of a silhouette than the middle texel
/// continue from it as the plane does.
fn on_one_side(own: &[[f64; 2]], most: f64) -> Vec<[f64; 2]> {
    let middle = own[medoid(own)];
    let is_same = |r: &[f64; 2]| (0..2).all(|c| (r[c] - middle[c]).abs() <= most);
    own.iter().map(|r| if is_same(r) { *r } else { middle }).collect()
}

/// Rotates a displacement into the frame of its view and divides it.
fn in_view([x, y]: [f64; 2], azimuth: f64, growth: f64) -> [f64; 2] {
    let (sine, cosine) = azimuth.sin_cos();
    [(x * cosine + y * sine) / growth, (y * cosine - x * sine) / growth]
}

/// Minima and extents of values, as halves. The minimum is rounded before the extent is measured.
fn bounds(values: &[[f64; 2]]) -> [[f32; 2]; 2] {
    let rounded = |number: f64| half::decode(half::encode(number as f32));
    let of_axis = |axis: usize| values.iter().map(move |value| value[axis]);
    let low = [0, 1].map(|axis| rounded(of_axis(axis).fold(f64::MAX, f64::min)));
    let extent = [0, 1].map(|axis| rounded((of_axis(axis).fold(f64::MIN, f64::max) - f64::from(low[axis])).max(0.0)));
    [low, extent]
}

/// Index of the value with the least sum of distances to all; the first of equals.
fn medoid(values: &[[f64; 2]]) -> usize {
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let cost = |a: usize| values.iter().map(|b| distance(values[a], *b)).sum::<f64>();
    (0..values.len()).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::height_field;
    use crate::vdim::indirection;
    use brdfc_core::progress::Cancelled;
    use brdfc_formats::direction::from_polar;

    const HEADER: VdimHeader =
        VdimHeader { size: 16, block: 2, polar_angles: 16, azimuth_rows: 17, largest_angle: 1.3, levels: 4, lights: 0 };

    #[derive(Debug)]
    #[expect(dead_code, reason = "printed by tests that fail")]
    enum Failed {
        Format(FormatError),
        Cancelled(Cancelled),
    }

    impl From<FormatError> for Failed {
        fn from(error: FormatError) -> Self {
            Self::Format(error)
        }
    }

    impl From<Cancelled> for Failed {
        fn from(cancelled: Cancelled) -> Self {
            Self::Cancelled(cancelled)
        }
    }

    fn map(model: &MesoModel, header: VdimHeader, is_compact: bool) -> Vdim {
        indirection::<Failed>(model, header, 2, is_compact, &()).unwrap()
    }

    fn model(height: impl Fn(f64, f64) -> f64) -> MesoModel {
        MesoModel::new(height_field(32, height), 0, &()).unwrap()
    }

    /// Largest distance of the parameters from `expected`, over views between the samples and points between the centres.
    fn off(map: &Vdim, expected: impl Fn([f64; 2], f64, f64) -> [f64; 2]) -> f64 {
        let of_view = |step: u32| {
            let (polar, azimuth) = (1.25 * f64::from(step) / 200.0, 0.37 * f64::from(step));
            let at = [0.031 * f64::from(step % 32), 0.029 * f64::from(step % 31)];
            let (found, _) = map.seen(at.map(|c| c as f32), from_polar(polar, azimuth).map(|c| c as f32), 0.0);
            let expected = expected(at, polar, azimuth);
            (f64::from(found[0]) - expected[0]).hypot(f64::from(found[1]) - expected[1])
        };
        (0..=200).map(of_view).fold(0.0, f64::max)
    }

    /// Known answer: a plane moves with the tangent, between samples too, where halves in frames of the tile have errors.
    #[test]
    fn a_raised_plane_is_seen_where_it_is() {
        let height = 0.11;
        let model = model(|_, _| height);
        let moved = |[x, y]: [f64; 2], polar: f64, azimuth: f64| {
            [x + height * polar.tan() * azimuth.cos(), y + height * polar.tan() * azimuth.sin()]
        };
        let compact = map(&model, HEADER, true);
        let found = off(&compact, moved);
        assert!(found < 0.004, "{found}");
        let halves = off(&map(&model, VdimHeader { block: 1, levels: 5, ..HEADER }, false), moved);
        assert!(found < 0.5 * halves, "{found} {halves}");
        // On all levels, and with its height.
        for level in 0..4 {
            let ([u, _], z) = compact.seen([0.4, 0.6], from_polar(0.7, 0.0).map(|c| c as f32), level as f32);
            assert!((f64::from(u) - 0.4 - height * 0.7f64.tan()).abs() < 0.004 && (f64::from(z) - height).abs() < 1e-3);
        }
    }

    /// Heights are looked up at the parameters of the visible point.
    #[test]
    fn heights_are_those_of_the_visible_point() {
        let model = model(|x, _| 0.1 * (std::f64::consts::TAU * x).sin());
        let [compact, halves] = [(2, 4, true), (1, 5, false)]
            .map(|(block, levels, is_compact)| map(&model, VdimHeader { block, levels, ..HEADER }, is_compact));
        let mut largest = 0.0f32;
        for k in 0..100u32 {
            let view = from_polar(0.01 * f64::from(k % 50), 0.4 * f64::from(k)).map(|c| c as f32);
            let at = [0.0131 * k as f32, 0.0377 * k as f32];
            let [a, b] = [&compact, &halves].map(|map| map.seen(at, view, 0.0).1);
            assert!((a - b).abs() < 0.03, "{k}: {a} {b}");
            largest = largest.max(a.abs());
        }
        assert!(largest > 0.09, "{largest}");
    }

    /// Along the normal some texels of a block see the top of a wall, others the ground: all take the side of the middle.
    #[test]
    fn texels_on_another_side_of_a_silhouette_follow_the_middle() {
        let own = [[0.0; 2], [0.01, 0.0], [0.4, 0.1], [0.0, 0.02]];
        assert_eq!(on_one_side(&own, 0.1), [[0.0; 2], [0.01, 0.0], [0.0; 2], [0.0, 0.02]]);
        assert_eq!(on_one_side(&own, 0.5), own);
    }

    #[test]
    fn blocks_are_at_most_128_per_side() {
        assert_eq!([4, 64, 128, 256, 512, 2048].map(texels_of_block), [1, 1, 1, 2, 4, 16]);
    }

    #[test]
    fn equal_values_have_no_extent() {
        let [low, extent] = bounds(&[[0.25, -0.5]; 3]);
        assert_eq!((low, extent), ([0.25, -0.5], [0.0; 2]));
        let [low, extent] = bounds(&[[0.1, 0.0], [0.3, 0.0]]);
        assert!((low[0] - 0.1).abs() < 1e-4 && (low[0] + extent[0] - 0.3).abs() < 1e-4);
    }
}
