//! Compact indirection maps, a sixteenth of the bytes: displacements in the view's own frame, for blocks of reference
//! texels.

use brdfc_formats::FormatError;
use brdfc_formats::container::half;
use brdfc_formats::flat_btf::{DisplacementHeader, DisplacementMap, IndirectionHeader, ReferenceMap, SAME_SIDE};
use rayon::prelude::*;

/// Largest side of a reference plane, in texels, with one block per texel: with 16 x 24 views the blocks take 12.5 MiB.
const SINGLE: u32 = 128;

/// Side of a block for a reference plane of `size` texels per side: 2 for even sizes above 128, else 1.
pub fn coarser(size: u32) -> u32 {
    if size > SINGLE && size.is_multiple_of(2) { 2 } else { 1 }
}

/// Encodes an indirection map with one block per `coarser²` texels. The displacement of texel `(i, j)` in the view of
/// sample `(k, a)` is in parameters. Each block stores the medoid of its texels' displacements in a view, that is, the
/// one nearest to the others: a mean over both sides of a silhouette would be a point that none of them sees.
///
/// Along the normal, texels of a block may see another side of a silhouette than the texel in its middle. They take a
/// reference extrapolated from that texel, because the block's displacement does not apply to their own. The function
/// therefore returns a new reference map, too.
///
/// # Errors
/// Returns an error if the sides of the map are no multiple of `coarser` or differ from the sides of the reference, or
/// if a displacement does not fit into a half.
pub fn displacements(
    map: IndirectionHeader,
    reference: &ReferenceMap,
    displacement: impl Fn([u32; 2], u32, u32) -> [f32; 2] + Sync,
    coarser: u32,
) -> Result<(DisplacementMap, ReferenceMap), FormatError> {
    let IndirectionHeader { size, zenith_samples, azimuth_samples, .. } = map;
    if coarser == 0 || !size.is_multiple_of(coarser) {
        let allowed = format!("a multiple of {coarser}");
        return Err(FormatError::whole("texels of the reference plane", size.to_string(), allowed));
    }
    if reference.size() != size {
        let found = reference.size().to_string();
        return Err(FormatError::whole("size of the part reference", found, format!("{size}, the size of the map")));
    }
    let header = DisplacementHeader::new(IndirectionHeader { size: size / coarser, ..map });
    let blocks = header.blocks.size;
    let divisors: Vec<f64> = (0..zenith_samples).map(|k| header.divisor(k)).collect();
    let of_block = |at: u32| -> Block {
        let corner = [at % blocks * coarser, at / blocks * coarser];
        let texels: Vec<[u32; 2]> =
            (0..coarser * coarser).map(|inside| [corner[0] + inside % coarser, corner[1] + inside / coarser]).collect();
        let own = |[i, j]: &[u32; 2]| reference.parameters()[(j * size + i) as usize].map(f64::from);
        let own: Vec<[f64; 2]> = texels.iter().map(own).collect();
        let references = on_one_side(&own, &texels, size);
        // Difference between each texel's own reference and its new one.
        let moved: Vec<[f64; 2]> = own.iter().zip(&references).map(|(own, now)| apart(*own, *now)).collect();
        let views = (0..azimuth_samples).flat_map(|a| (0..zenith_samples).map(move |k| (k, a)));
        let values: Vec<[f64; 2]> = views
            .map(|(k, a)| {
                let azimuth = header.blocks.view_angles(k, a)[1];
                let seen = |(texel, moved): (&[u32; 2], &[f64; 2])| {
                    let [x, y] = displacement(*texel, k, a).map(f64::from);
                    in_view([x + moved[0], y + moved[1]], azimuth, divisors[k as usize])
                };
                let seen: Vec<[f64; 2]> = texels.iter().zip(&moved).map(seen).collect();
                seen[nearest_to_all(&seen)]
            })
            .collect();
        Block::new(&values, references)
    };
    let made: Vec<Block> = (0..blocks * blocks).into_par_iter().map(of_block).collect();
    let [width, height] = header.blocks.extent();
    let rows = azimuth_samples + 1;
    let texel = |at: u32| {
        let ([column, row], samples) = ([at % width, at / width], &made);
        let (i, j, k) = (column / zenith_samples, row / rows, column % zenith_samples);
        let a = row % rows % azimuth_samples;
        samples[(j * blocks + i) as usize].bytes[(a * zenith_samples + k) as usize]
    };
    let texels = (0..width * height).map(texel).collect();
    let displacements = DisplacementMap::new(header, made.iter().map(|block| block.range).collect(), texels)?;
    let parameters = (0..size * size).map(|at| {
        let [i, j] = [at % size, at / size];
        let inside = j % coarser * coarser + i % coarser;
        made[(j / coarser * blocks + i / coarser) as usize].references[inside as usize]
    });
    Ok((displacements, ReferenceMap::new(size, parameters.collect())?))
}

/// Parameters of the texels of a block. Texels on another side of a silhouette than the middle texel, or on it,
/// continue from the middle texel as the reference plane does.
fn on_one_side(own: &[[f64; 2]], texels: &[[u32; 2]], size: u32) -> Vec<[f64; 2]> {
    let middle = nearest_to_all_by(own.len(), |a, b| {
        let [x, y] = apart(own[a], own[b]);
        x.hypot(y)
    });
    let texel = 1.0 / f64::from(size);
    let of_texel = |k: usize| {
        let [x, y] = apart(own[k], own[middle]);
        if x.abs().max(y.abs()) <= f64::from(SAME_SIDE) * texel {
            return own[k];
        }
        [0, 1].map(|axis| own[middle][axis] + (f64::from(texels[k][axis]) - f64::from(texels[middle][axis])) * texel)
    };
    (0..own.len()).map(of_texel).collect()
}

/// Difference of parameters, which have period 1.
fn apart(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|axis| {
        let difference = a[axis] - b[axis];
        difference - difference.round()
    })
}

/// Rotates a displacement into the frame of its view and divides it.
fn in_view(displacement: [f64; 2], azimuth: f64, divisor: f64) -> [f64; 2] {
    let [x, y] = displacement.map(|c| c / divisor);
    let (sine, cosine) = azimuth.sin_cos();
    [x * cosine + y * sine, y * cosine - x * sine]
}

/// Index of the value with the least sum of distances to all.
fn nearest_to_all(values: &[[f64; 2]]) -> usize {
    nearest_to_all_by(values.len(), |a, b| (values[a][0] - values[b][0]).hypot(values[a][1] - values[b][1]))
}

/// Index of the item with the least sum of distances to all; the first of equals.
fn nearest_to_all_by(count: usize, distance: impl Fn(usize, usize) -> f64) -> usize {
    let cost = |a: usize| (0..count).map(|b| distance(a, b)).sum::<f64>();
    (0..count).min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or(0)
}

/// A block as stored.
struct Block {
    references: Vec<[f32; 2]>,
    range: [u16; 4],
    /// Azimuth by azimuth.
    bytes: Vec<[u8; 2]>,
}

impl Block {
    fn new(values: &[[f64; 2]], references: Vec<[f64; 2]>) -> Self {
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
        let references = references.into_iter().map(|parameters| parameters.map(|c| c as f32)).collect();
        Self { references, range: [bounds[0].0, bounds[0].1, bounds[1].0, bounds[1].1], bytes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction::from_polar;
    use brdfc_formats::flat_btf::{
        DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatValues, Indirection, IndirectionMap, NormalMap,
    };

    const HEADER: IndirectionHeader =
        IndirectionHeader { size: 16, zenith_samples: 16, azimuth_samples: 16, largest_angle: 1.3 };

    /// The map of a plane at `height(texel)`.
    fn plane(height: impl Fn([u32; 2]) -> f64) -> IndirectionMap {
        IndirectionMap::from_displacements(HEADER, |texel, k, a| {
            let [polar, azimuth] = HEADER.view_angles(k, a);
            let distance = -height(texel) * polar.tan();
            ([distance * azimuth.cos(), distance * azimuth.sin()].map(|c| c as f32), height(texel) as f32)
        })
        .unwrap()
    }

    /// Reference map of the plane: its own parameters.
    fn reference() -> ReferenceMap {
        let centre = |k: u32| [(k % 16) as f32 / 16.0 + 1.0 / 32.0, (k / 16) as f32 / 16.0 + 1.0 / 32.0];
        ReferenceMap::new(16, (0..256).map(centre).collect()).unwrap()
    }

    /// Decoder of a map with this reference.
    fn decoder(reference: ReferenceMap, indirection: Indirection) -> FlatBtfDecoder {
        FlatBtfDecoder::new(FlatBtfParts {
            reference,
            indirection,
            normal: NormalMap::new(1, vec![[0.0, 0.0, 1.0]]).unwrap(),
            diffuse: DiffuseMap::new(1, vec![0]).unwrap(),
            values: FlatValues::None,
        })
        .unwrap()
    }

    fn of_map(
        map: &IndirectionMap,
        reference: &ReferenceMap,
        coarser: u32,
    ) -> Result<(DisplacementMap, ReferenceMap), FormatError> {
        displacements(*map.header(), reference, |texel, k, a| map.displacement(texel, k, a), coarser)
    }

    fn compact(map: &IndirectionMap, coarser: u32) -> FlatBtfDecoder {
        let (made, reference) = of_map(map, &reference(), coarser).unwrap();
        decoder(reference, made.into())
    }

    /// Largest distance between the decoded position and the position of a plane at this height, over views between the
    /// samples.
    fn off(decoder: &FlatBtfDecoder, height: f64) -> f64 {
        let of_view = |step: u32| {
            let (polar, azimuth) = (1.25 * f64::from(step) / 200.0, 0.37 * f64::from(step));
            let view = from_polar(polar, azimuth);
            let [u, v, _] = decoder.indirection([0.46875, 0.53125], view.map(|c| c as f32));
            let distance = -height * polar.tan();
            let expected = [0.46875 + distance * azimuth.cos(), 0.53125 + distance * azimuth.sin()];
            let [x, y] = apart([u, v].map(f64::from), expected);
            x.hypot(y)
        };
        (0..=200).map(of_view).fold(0.0, f64::max)
    }

    /// Known answer: a plane moves with the tangent, between samples too, where the map of directions and distances has
    /// errors.
    #[test]
    fn a_plane_is_seen_where_it_is() {
        for (height, coarser) in [(0.05, 1), (0.05, 2), (-0.02, 4)] {
            let map = plane(|_| height);
            let made = off(&compact(&map, coarser), height);
            assert!(made < 0.004, "{height} {coarser}: {made}");
            assert!(made < off(&decoder(reference(), map.into()), height), "{height}");
        }
    }

    #[test]
    fn many_texels_share_blocks() {
        assert_eq!([16, 127, 128, 129, 130, 256, 512].map(coarser), [1, 1, 1, 1, 2, 2, 2]);
    }

    #[test]
    fn one_of_the_texels_stands_for_all() {
        // Three of every four texels see a plane far below.
        let map = plane(|[i, j]| if i % 2 + j % 2 == 0 { 0.1 } else { -0.2 });
        assert!(off(&compact(&map, 2), -0.2) < 0.02);
        let refused = of_map(&map, &reference(), 3).unwrap_err().to_string();
        assert!(refused.contains("found 16, expected a multiple of 3"), "{refused}");
    }

    /// Along the normal, one of four texels sees another part of the parameters; from the side, all see the same plane.
    #[test]
    fn texels_on_another_side_of_a_silhouette_follow_the_others() {
        let map = plane(|_| 0.05);
        let aside = |k: usize| if k % 2 == 1 && (k / 16).is_multiple_of(2) { 0.4 } else { 0.0 };
        let own: Vec<[f32; 2]> =
            reference().parameters().iter().enumerate().map(|(k, [u, v])| [u + aside(k), *v]).collect();
        let moved = IndirectionMap::from_displacements(HEADER, |[i, j], k, a| {
            let [x, y, distance, height] = map.sample([i, j], k, a);
            ([x * distance - aside((16 * j + i) as usize), y * distance], height)
        });
        let moved = moved.unwrap();
        let (made, side) = of_map(&moved, &ReferenceMap::new(16, own.clone()).unwrap(), 2).unwrap();
        assert_eq!(side, reference());
        assert!(off(&decoder(side, made.clone().into()), 0.05) < 0.004);
        // With their own reference, the displacement leads to a wrong point.
        assert!(off(&decoder(ReferenceMap::new(16, own).unwrap(), made.into()), 0.05) > 0.3);
    }
}
