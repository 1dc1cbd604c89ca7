//! Figures 11, 13 and 14: variance over the views, and apparent BRDFs.

use super::coherency::TexelVariances;
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_render::rendering::{Panel, octave_map, sheet};

/// Range of the colour scale of variances, below the largest one.
const OCTAVES: f32 = 12.0;
/// Pixels per side of a panel of variances, at least.
pub(super) const SIDE: usize = 256;
/// Pixels per view and light of an apparent BRDF.
const MAGNIFICATION: usize = 3;
/// Marks what a view does not see.
pub(super) const UNSEEN: [u8; 3] = [40, 70, 200];

/// Figure 11: variance of the ordinary BTF, of the flat BTF with holes filled by push-pull, and of its seen texels; on one
/// logarithmic scale, dark to pale yellow.
pub(super) fn variance_figure(variances: [&TexelVariances; 3]) -> Panel {
    // All in one row, so that they share the scale.
    let all: Vec<f32> =
        variances.iter().flat_map(|map| map.iter().map(|variance| variance.unwrap_or(0.0) as f32)).collect();
    let mut colours = octave_map(&all, all.len(), 1, OCTAVES).rgb.into_iter();
    let panels = variances.map(|map| {
        let side = map.len().isqrt();
        let rgb = colours.by_ref().take(3 * map.len()).collect();
        magnified(&Panel { width: side, height: side, rgb }, SIDE.div_ceil(side))
    });
    let common = panels.iter().map(|panel| panel.height).max().unwrap_or(0);
    sheet(&panels.map(|panel| magnified(&panel, common / panel.height)))
}

/// An apparent BRDF: values for each view (rows) and light (columns), and the views that see the texel.
pub(super) struct ApparentBrdf {
    pub(super) values: Vec<[f32; 3]>,
    pub(super) seen: Vec<bool>,
}

/// Figures 13 and 14: apparent BRDFs side by side, blue where a view does not see the texel.
pub(super) fn apparent_figure(brdfs: &[ApparentBrdf], lights: usize) -> Panel {
    let panel = |brdf: &ApparentBrdf| {
        let colour = |(k, value): (usize, &[f32; 3])| {
            if brdf.seen[k / lights] { value.map(|c| encode_srgb_byte(f64::from(c).min(1.0))) } else { UNSEEN }
        };
        let rgb = brdf.values.iter().enumerate().flat_map(colour).collect();
        magnified(&Panel { width: lights, height: brdf.values.len() / lights, rgb }, MAGNIFICATION)
    };
    sheet(&brdfs.iter().map(panel).collect::<Vec<_>>())
}

/// Repeats each pixel in both directions.
pub(super) fn magnified(panel: &Panel, times: usize) -> Panel {
    let row = |y: usize| {
        let pixels = panel.rgb[3 * panel.width * y..3 * panel.width * (y + 1)].chunks_exact(3);
        pixels.flat_map(|pixel| pixel.repeat(times)).collect::<Vec<u8>>().repeat(times)
    };
    let rgb = (0..panel.height).flat_map(row).collect();
    Panel { width: times * panel.width, height: times * panel.height, rgb }
}

#[cfg(test)]
pub(super) fn pixel(panel: &Panel, [x, y]: [usize; 2]) -> [u8; 3] {
    let start = 3 * (y * panel.width + x);
    panel.rgb[start..start + 3].try_into().unwrap()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_view_does_not_see_is_blue() {
        let values = vec![[0.0; 3], [1.0; 3], [2.0; 3], [0.0; 3]];
        let figure = apparent_figure(&[ApparentBrdf { values, seen: vec![true, false] }], 2);
        assert_eq!([figure.width, figure.height], [2 * MAGNIFICATION; 2]);
        let last = 2 * MAGNIFICATION - 1;
        assert_eq!([[0, 0], [last, 0]].map(|at| pixel(&figure, at)), [[0; 3], [255; 3]]);
        assert_eq!([[0, last], [last, last]].map(|at| pixel(&figure, at)), [UNSEEN; 2]);
    }

    #[test]
    fn variances_share_one_scale_and_size() {
        let (coarse, fine) = (vec![Some(4.0); 4], [Some(8.0), None, Some(8.0), Some(4.0)].repeat(4));
        let figure = variance_figure([&coarse, &fine, &fine]);
        let first = pixel(&figure, [0, 0]);
        assert_eq!(figure.height, SIDE);
        let at = |x, y| pixel(&figure, [figure.width - SIDE + x * SIDE / 4, y * SIDE / 4]);
        assert_eq!(at(3, 0), first, "half the largest");
        assert_ne!(at(0, 0), first);
        assert_eq!(at(1, 0), octave_map(&[0.0], 1, 1, OCTAVES).rgb[..]);
    }
}
