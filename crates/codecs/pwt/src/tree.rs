//! Wavelet packets of images (section 2, "Wavelets for BTF"). A tree lists the subbands that are split further; the
//! best tree is found as by Coifman and Wickerhauser (1992).

use crate::image::{Plane, Rectangle};
use crate::lifting::{Border, Wavelet};
use std::collections::BTreeSet;

/// Wavelet transform of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Transform {
    /// The wavelet.
    pub wavelet: Wavelet,
    /// Extension beyond the borders.
    pub border: Border,
    /// Levels: sides are multiples of `2^depth`.
    pub depth: u32,
}

/// A subband that is not split further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Subband {
    /// Its coefficients in the transformed plane.
    pub rectangle: Rectangle,
    /// Level of detail: 0 is the finest, [`Transform::depth`] the remaining low-pass image.
    pub level: u32,
    /// Number of splits of the image for this subband.
    pub splits: u32,
}

/// Detail subbands that are split further. The low-pass subband is always split, to the last level.
#[derive(Debug, Clone, PartialEq)]
pub struct PacketTree {
    transform: Transform,
    size: [usize; 2],
    /// Numbers of the split detail subbands: 1 is the image, the quarters of `n` are `4n` to `4n + 3`.
    split: BTreeSet<u64>,
}

impl PacketTree {
    /// Creates a plain pyramid without further splits.
    pub fn pyramid(transform: Transform, size: [usize; 2]) -> Self {
        Self { transform, size, split: BTreeSet::new() }
    }

    /// Finds the tree with the least cost `Σ ln(1 + (c / step)²)` of the coefficients of these planes, which
    /// approximates their bits when rounded to `step`. Details are split at most `extra` times more.
    pub fn best(transform: Transform, planes: &[Plane], step: f32, extra: u32) -> Self {
        let size = planes.first().map_or([0, 0], |plane| plane.size);
        let mut tree = Self::pyramid(transform, size);
        let mut planes = planes.to_vec();
        let mut node = (1u64, Rectangle { first: [0, 0], size });
        for level in 0..transform.depth {
            planes.iter_mut().for_each(|plane| plane.split(node.1, transform.wavelet, transform.border));
            let quarters = node.1.quarters();
            let most = (transform.depth - level - 1).min(extra);
            for k in 1..4 {
                let number = 4 * node.0 + k as u64;
                tree.decide(&mut planes, (number, quarters[k]), step, most);
            }
            node = (4 * node.0, quarters[0]);
        }
        tree
    }

    /// Least cost of a subband, split or not.
    fn decide(&mut self, planes: &mut [Plane], (number, rectangle): (u64, Rectangle), step: f32, most: u32) -> f64 {
        let whole = cost(planes, rectangle, step);
        if most == 0 || rectangle.size.iter().any(|side| side % 2 != 0) {
            return whole;
        }
        let Transform { wavelet, border, .. } = self.transform;
        planes.iter_mut().for_each(|plane| plane.split(rectangle, wavelet, border));
        let quarters = rectangle.quarters().into_iter().enumerate();
        let parts: f64 =
            quarters.map(|(k, quarter)| self.decide(planes, (4 * number + k as u64, quarter), step, most - 1)).sum();
        if parts < whole {
            self.split.insert(number);
            parts
        } else {
            whole
        }
    }

    /// The wavelet transform.
    pub fn transform(&self) -> Transform {
        self.transform
    }

    /// All subbands: the low-pass one first, then details from the coarsest level.
    pub fn subbands(&self) -> Vec<Subband> {
        let mut subbands = Vec::new();
        let (mut number, mut rectangle) = (1u64, Rectangle { first: [0, 0], size: self.size });
        for level in 0..self.transform.depth {
            let quarters = rectangle.quarters();
            for k in (1..4).rev() {
                self.list(4 * number + k as u64, quarters[k], level, level + 1, &mut subbands);
            }
            (number, rectangle) = (4 * number, quarters[0]);
        }
        let depth = self.transform.depth;
        subbands.push(Subband { rectangle, level: depth, splits: depth });
        subbands.reverse();
        subbands
    }

    fn list(&self, number: u64, rectangle: Rectangle, level: u32, splits: u32, subbands: &mut Vec<Subband>) {
        if !self.split.contains(&number) {
            subbands.push(Subband { rectangle, level, splits });
            return;
        }
        for (k, quarter) in rectangle.quarters().into_iter().enumerate().rev() {
            self.list(4 * number + k as u64, quarter, level, splits + 1, subbands);
        }
    }

    /// Transforms a plane to coefficients, in place.
    pub fn analyse(&self, plane: &mut Plane) {
        let Transform { wavelet, border, depth } = self.transform;
        let (mut number, mut rectangle) = (1u64, plane.rectangle());
        for _ in 0..depth {
            plane.split(rectangle, wavelet, border);
            let quarters = rectangle.quarters();
            (1..4).for_each(|k| self.analyse_detail(plane, 4 * number + k as u64, quarters[k]));
            (number, rectangle) = (4 * number, quarters[0]);
        }
    }

    fn analyse_detail(&self, plane: &mut Plane, number: u64, rectangle: Rectangle) {
        if self.split.contains(&number) {
            plane.split(rectangle, self.transform.wavelet, self.transform.border);
            for (k, quarter) in rectangle.quarters().into_iter().enumerate() {
                self.analyse_detail(plane, 4 * number + k as u64, quarter);
            }
        }
    }

    /// Undoes [`Self::analyse`].
    pub fn synthesise(&self, plane: &mut Plane) {
        self.synthesise_from(plane, 0);
    }

    /// Joins all levels except the finest `levels`: the result is in the first `size >> levels` of the plane.
    fn synthesise_from(&self, plane: &mut Plane, levels: u32) {
        let Transform { wavelet, border, depth } = self.transform;
        let mut nodes = vec![(1u64, plane.rectangle())];
        for _ in 1..depth {
            let (number, rectangle) = nodes[nodes.len() - 1];
            nodes.push((4 * number, rectangle.quarters()[0]));
        }
        for (number, rectangle) in nodes[levels.min(depth) as usize..depth as usize].iter().rev() {
            for (k, quarter) in rectangle.quarters().into_iter().enumerate().skip(1) {
                self.synthesise_detail(plane, 4 * number + k as u64, quarter);
            }
            plane.join(*rectangle, wavelet, border);
        }
    }

    fn synthesise_detail(&self, plane: &mut Plane, number: u64, rectangle: Rectangle) {
        if self.split.contains(&number) {
            for (k, quarter) in rectangle.quarters().into_iter().enumerate() {
                self.synthesise_detail(plane, 4 * number + k as u64, quarter);
            }
            plane.join(rectangle, self.transform.wavelet, self.transform.border);
        }
    }

    /// Reconstructs the image at a level, with that level's size: finer details are omitted, and each texel is the
    /// mean of the area that it covers. Level 0 is the whole image.
    pub fn truncated(&self, coefficients: &Plane, level: u32) -> Plane {
        let mut plane = coefficients.clone();
        if level == 0 {
            self.synthesise(&mut plane);
            return plane;
        }
        self.synthesise_from(&mut plane, level);
        let size = plane.size.map(|side| side >> level);
        let rest = Rectangle { first: [0, 0], size };
        if self.transform.wavelet == Wavelet::Haar {
            // Means of means: every level has them, times 2.
            let values = (0..size[1]).flat_map(|y| plane.row(rest, y)).map(|value| value / (1 << level) as f32);
            return Plane { size, values: values.collect() };
        }
        let mut alone = Plane::zeros(plane.size);
        for y in 0..size[1] {
            alone.values[y * plane.size[0]..][..size[0]].copy_from_slice(plane.row(rest, y));
        }
        for below in (0..level).rev() {
            let rectangle = Rectangle { first: [0, 0], size: plane.size.map(|side| side >> below) };
            alone.join(rectangle, self.transform.wavelet, self.transform.border);
        }
        alone.means(level)
    }
}

fn cost(planes: &[Plane], rectangle: Rectangle, step: f32) -> f64 {
    let inverse = 1.0 / step;
    let of_row = |plane: &Plane, y: usize| -> f64 {
        plane.row(rectangle, y).iter().map(|c| f64::from((c * inverse).powi(2)).ln_1p()).sum()
    };
    planes.iter().map(|plane| (0..rectangle.size[1]).map(|y| of_row(plane, y)).sum::<f64>()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Plane;

    fn noise(size: [usize; 2], seed: u32) -> Plane {
        let mut state = seed;
        let values = (0..size[0] * size[1]).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32 - 0.5
        });
        Plane { size, values: values.collect() }
    }

    fn transforms() -> impl Iterator<Item = Transform> {
        let borders = [Border::Mirrored, Border::Periodic];
        let all = Wavelet::ALL.into_iter().flat_map(move |wavelet| borders.map(|border| (wavelet, border)));
        all.flat_map(|(wavelet, border)| (0..4).map(move |depth| Transform { wavelet, border, depth }))
    }

    fn difference(a: &Plane, b: &Plane) -> f32 {
        a.values.iter().zip(&b.values).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    #[test]
    fn reconstruction_is_perfect() {
        let rendering = noise([24, 16], 7);
        for transform in transforms() {
            for tree in [
                PacketTree::pyramid(transform, rendering.size),
                PacketTree::best(transform, std::slice::from_ref(&rendering), 0.01, 3),
                // The finest details are split once more.
                PacketTree { transform, size: rendering.size, split: (5..8).collect() },
            ] {
                let mut plane = rendering.clone();
                tree.analyse(&mut plane);
                assert!(transform.depth == 0 || difference(&plane, &rendering) > 0.1);
                tree.synthesise(&mut plane);
                assert!(difference(&plane, &rendering) < 1e-5, "{transform:?}");
            }
        }
    }

    /// Known answers: the low-pass subband of a constant holds its mean and details are 0; orthonormal wavelets
    /// preserve energy.
    #[test]
    fn constants_and_energies() {
        for transform in transforms() {
            let tree = PacketTree::pyramid(transform, [16, 8]);
            let mut plane = Plane { size: [16, 8], values: vec![3.0; 128] };
            tree.analyse(&mut plane);
            let subbands = tree.subbands();
            let first = plane.row(subbands[0].rectangle, 0)[0];
            assert!((first - 3.0 * (1 << transform.depth) as f32).abs() < 1e-4, "{transform:?} {first}");
            for subband in &subbands[1..] {
                let largest = (0..subband.rectangle.size[1]).flat_map(|y| plane.row(subband.rectangle, y).to_vec());
                assert!(largest.fold(0.0, |m: f32, c| m.max(c.abs())) < 1e-5, "{transform:?}");
            }
            let rendering = noise([32, 32], 3);
            let mut plane = rendering.clone();
            PacketTree::pyramid(transform, rendering.size).analyse(&mut plane);
            let energy = |plane: &Plane| plane.values.iter().map(|v| v * v).sum::<f32>();
            let ratio = energy(&plane) / energy(&rendering);
            let orthonormal = match (transform.wavelet, transform.border) {
                (Wavelet::Haar, _) | (Wavelet::Daubechies4, Border::Periodic) => 1e-5,
                (Wavelet::Cdf97, _) => 0.1,
                _ => continue,
            };
            assert!((ratio - 1.0).abs() < orthonormal, "{transform:?} {ratio}");
        }
    }

    #[test]
    fn subbands_cover_the_plane_once() {
        let rendering = noise([32, 32], 9);
        for transform in transforms() {
            let tree = PacketTree::best(transform, std::slice::from_ref(&rendering), 0.3, 2);
            let mut covered = Plane::zeros(rendering.size);
            for subband in tree.subbands() {
                let Rectangle { first: [x, y], size: [width, height] } = subband.rectangle;
                assert_eq!(subband.rectangle.size, rendering.size.map(|side| side >> subband.splits));
                for (i, j) in (0..height).flat_map(|j| (0..width).map(move |i| (i, j))) {
                    covered.values[(y + j) * 32 + x + i] += 1.0;
                }
            }
            assert!(covered.values.iter().all(|count| *count == 1.0), "{transform:?}");
        }
    }

    /// A level of the mipmap chain is the image without finer details, at that size.
    #[test]
    fn truncation_leaves_finer_details_out() {
        let rendering = noise([32, 16], 5);
        for transform in transforms() {
            let tree = PacketTree::best(transform, std::slice::from_ref(&rendering), 0.1, 1);
            let mut coefficients = rendering.clone();
            tree.analyse(&mut coefficients);
            for level in 0..=transform.depth {
                let mut coarse = coefficients.clone();
                for subband in tree.subbands().iter().filter(|subband| subband.level < level) {
                    for y in 0..subband.rectangle.size[1] {
                        coarse.row_mut(subband.rectangle, y).fill(0.0);
                    }
                }
                tree.synthesise(&mut coarse);
                let truncated = tree.truncated(&coefficients, level);
                assert_eq!(truncated.size, [32 >> level, 16 >> level]);
                assert!(difference(&truncated, &coarse.means(level)) < 1e-5, "{transform:?} {level}");
            }
        }
    }
}
