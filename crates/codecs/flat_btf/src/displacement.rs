//! Indirection maps in a sixteenth of their bytes: displacements in the view's own frame, for blocks of reference texels.

use brdfc_formats::FormatError;
use brdfc_formats::container::half;
use brdfc_formats::flat_btf::{DisplacementHeader, DisplacementMap, IndirectionHeader, IndirectionMap};
use rayon::prelude::*;

/// One block for each `coarser²` texels of the map. Of the displacements that these texels have in a view, the one stands for
/// all that is nearest to the others: a mean over both sides of a silhouette would be a point that none of them sees.
///
/// # Errors
/// A map whose sides are no multiple of `coarser`, or displacements that halves cannot hold.
pub fn displacements(map: &IndirectionMap, coarser: u32) -> Result<DisplacementMap, FormatError> {
    let IndirectionHeader { size, zenith_samples, azimuth_samples, .. } = *map.header();
    if coarser == 0 || !size.is_multiple_of(coarser) {
        let allowed = format!("a multiple of {coarser}");
        return Err(FormatError::whole("texels of the reference plane", size.to_string(), allowed));
    }
    let header = DisplacementHeader::new(IndirectionHeader { size: size / coarser, ..*map.header() });
    let blocks = header.blocks.size;
    let divisors: Vec<f64> = (0..zenith_samples).map(|k| header.divisor(k)).collect();
    let shares_of_block = |at: u32| -> Block {
        let corner = [at % blocks * coarser, at / blocks * coarser];
        let texels: Vec<[u32; 2]> =
            (0..coarser * coarser).map(|inside| [corner[0] + inside % coarser, corner[1] + inside / coarser]).collect();
        let views = (0..azimuth_samples).flat_map(|a| (0..zenith_samples).map(move |k| (k, a)));
        let values: Vec<[f64; 2]> = views
            .map(|(k, a)| {
                let azimuth = header.blocks.view_angles(k, a)[1];
                let seen: Vec<[f64; 2]> = texels
                    .iter()
                    .map(|texel| in_view(map.sample(*texel, k, a), azimuth, divisors[k as usize]))
                    .collect();
                nearest_to_all(&seen)
            })
            .collect();
        Block::new(&values)
    };
    let made: Vec<Block> = (0..blocks * blocks).into_par_iter().map(shares_of_block).collect();
    let [width, height] = header.blocks.extent();
    let rows = azimuth_samples + 1;
    let texel = |at: u32| {
        let ([column, row], samples) = ([at % width, at / width], &made);
        let (i, j, k) = (column / zenith_samples, row / rows, column % zenith_samples);
        let a = row % rows % azimuth_samples;
        samples[(j * blocks + i) as usize].bytes[(a * zenith_samples + k) as usize]
    };
    let texels = (0..width * height).map(texel).collect();
    DisplacementMap::new(header, made.iter().map(|block| block.range).collect(), texels)
}

/// A sample of the map in the frame of its view, divided.
fn in_view([x, y, distance, _]: [f32; 4], azimuth: f64, divisor: f64) -> [f64; 2] {
    let [x, y] = [x, y].map(|c| f64::from(c) * f64::from(distance) / divisor);
    let (sine, cosine) = azimuth.sin_cos();
    [x * cosine + y * sine, y * cosine - x * sine]
}

/// The one with the least sum of distances to all; of several the first.
fn nearest_to_all(values: &[[f64; 2]]) -> [f64; 2] {
    let cost = |a: &[f64; 2]| values.iter().map(|b| (a[0] - b[0]).hypot(a[1] - b[1])).sum::<f64>();
    values.iter().copied().min_by(|a, b| cost(a).total_cmp(&cost(b))).unwrap_or_default()
}

/// A block as it is stored.
struct Block {
    range: [u16; 4],
    /// Azimuth by azimuth.
    bytes: Vec<[u8; 2]>,
}

impl Block {
    fn new(values: &[[f64; 2]]) -> Self {
        let bounds = [0, 1].map(|axis: usize| {
            let of_axis = || values.iter().map(|value| value[axis]);
            let low = half::encode(of_axis().fold(f64::MAX, f64::min) as f32);
            let extent = of_axis().fold(f64::MIN, f64::max) - f64::from(half::decode(low));
            (low, half::encode(extent.max(0.0) as f32))
        });
        let byte = |value: f64, axis: usize| {
            let (low, extent) = bounds[axis];
            let [low, extent] = [low, extent].map(|bits| f64::from(half::decode(bits)));
            if extent > 0.0 { ((value - low) / extent * 255.0).round().clamp(0.0, 255.0) as u8 } else { 0 }
        };
        let bytes = values.iter().map(|value| [byte(value[0], 0), byte(value[1], 1)]).collect();
        Self { range: [bounds[0].0, bounds[0].1, bounds[1].0, bounds[1].1], bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::from_polar;
    use brdfc_formats::flat_btf::{
        DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatValues, Indirection, NormalMap, ReferenceMap,
    };

    const HEADER: IndirectionHeader =
        IndirectionHeader { size: 8, zenith_samples: 16, azimuth_samples: 16, largest_angle: 1.3 };

    /// What is seen of a plane at a height, through texels of the reference plane.
    fn plane(height: impl Fn([u32; 2]) -> f64) -> IndirectionMap {
        IndirectionMap::from_displacements(HEADER, |texel, k, a| {
            let [polar, azimuth] = HEADER.view_angles(k, a);
            let distance = -height(texel) * polar.tan();
            ([distance * azimuth.cos(), distance * azimuth.sin()].map(|c| c as f32), height(texel) as f32)
        })
        .unwrap()
    }

    fn decoder(indirection: Indirection) -> FlatBtfDecoder {
        let centre = |k: u32| [(k % 8) as f32 / 8.0 + 1.0 / 16.0, (k / 8) as f32 / 8.0 + 1.0 / 16.0];
        FlatBtfDecoder::new(FlatBtfParts {
            reference: ReferenceMap::new(8, (0..64).map(centre).collect()).unwrap(),
            indirection,
            normal: NormalMap::new(1, vec![[0.0, 0.0, 1.0]]).unwrap(),
            diffuse: DiffuseMap::new(1, vec![0]).unwrap(),
            values: FlatValues::None,
        })
        .unwrap()
    }

    /// Largest distance between what is seen and where a plane at this height is, over views between the samples.
    fn off(indirection: Indirection, height: f64) -> f64 {
        let decoder = decoder(indirection);
        let of_view = |step: u32| {
            let (polar, azimuth) = (1.25 * f64::from(step) / 200.0, 0.37 * f64::from(step));
            let view = from_polar(polar, azimuth);
            let [u, v, _] = decoder.indirection([0.4375, 0.5625], view.map(|c| c as f32));
            let distance = -height * polar.tan();
            let wanted = [0.4375 + distance * azimuth.cos(), 0.5625 + distance * azimuth.sin()];
            let [x, y] = [f64::from(u) - wanted[0], f64::from(v) - wanted[1]].map(|d| d - d.round());
            x.hypot(y)
        };
        (0..=200).map(of_view).fold(0.0, f64::max)
    }

    /// Known answer: a plane moves with the tangent, between samples too, where the map of directions and distances errs.
    #[test]
    fn a_plane_is_seen_where_it_is() {
        for (height, coarser) in [(0.05, 1), (0.05, 2), (-0.02, 4)] {
            let map = plane(|_| height);
            let made = off(Indirection::Compact(displacements(&map, coarser).unwrap()), height);
            assert!(made < 0.004, "{height} {coarser}: {made}");
            assert!(made < off(Indirection::Samples(map), height), "{height}");
        }
    }

    #[test]
    fn one_of_the_texels_stands_for_all() {
        // Three of each four texels see a plane far below.
        let map = plane(|[i, j]| if i % 2 + j % 2 == 0 { 0.1 } else { -0.2 });
        let made = displacements(&map, 2).unwrap();
        assert!(off(Indirection::Compact(made), -0.2) < 0.02);
        assert!(displacements(&map, 3).unwrap_err().to_string().contains("found 8; allowed a multiple of 3"));
    }
}
