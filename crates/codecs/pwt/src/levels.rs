//! Precomputed inverse transform (section 2, "Rendering"). Each coefficient of the light's polynomial becomes a mipmap.
//! Its finest level is chosen by the reduction of the error per byte.

use crate::image::Plane;
use crate::lifting::Wavelet;
use crate::tree::{PacketTree, Transform};
use brdfc_formats::tap::Tap;
use rayon::prelude::*;

/// Number of levels at which a term may begin.
pub const BASES: u32 = 4;

/// Continuation of planes beyond their borders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Borders {
    /// True for tiles that repeat.
    pub repeats: bool,
    /// Number of views that are stacked in a plane.
    pub views: usize,
}

impl Borders {
    /// Borders of a single view.
    pub fn of_one(repeats: bool) -> Self {
        Self { repeats, views: 1 }
    }
}

/// A term of a channel, with its images and errors for each first level.
#[derive(Debug, Clone, PartialEq)]
pub struct TermImages {
    /// Index of the channel.
    pub channel: usize,
    /// Index of the term.
    pub term: usize,
    /// Texels of all mipmap levels, finest first.
    pub levels: Vec<Plane>,
    /// Weighted squared error of the image, summed over texels, if the term begins at level 0, 1, …; the last is the
    /// error if it is omitted.
    pub errors: Vec<f64>,
}

impl TermImages {
    /// Creates the images from the term's coefficients in the tree. `weights` are the weights of texels in the error.
    pub fn new(
        (channel, term): (usize, usize),
        tree: &PacketTree,
        coefficients: &Plane,
        weights: &Plane,
        borders: Borders,
    ) -> Self {
        let levels = (0..=tree.transform().depth).map(|level| tree.truncated(coefficients, level)).collect();
        Self::of_levels((channel, term), levels, weights, borders)
    }

    /// Creates the images of a term whose tree has all details. `plane` is not transformed.
    pub fn of_plane(
        (channel, term): (usize, usize),
        transform: Transform,
        plane: Plane,
        weights: &Plane,
        borders: Borders,
    ) -> Self {
        let mut levels = vec![plane];
        if transform.wavelet == Wavelet::Haar {
            for level in 0..transform.depth as usize {
                levels.push(levels[level].means(1));
            }
        } else {
            let tree = PacketTree::pyramid(transform, levels[0].size);
            let mut coefficients = levels[0].clone();
            tree.analyse(&mut coefficients);
            levels.extend((1..=transform.depth).map(|level| tree.truncated(&coefficients, level)));
        }
        Self::of_levels((channel, term), levels, weights, borders)
    }

    fn of_levels((channel, term): (usize, usize), levels: Vec<Plane>, weights: &Plane, borders: Borders) -> Self {
        let depth = levels.len() as u32 - 1;
        let whole = &levels[0];
        let squares = |other: &[f32]| -> f64 {
            let pairs = whole.values.iter().zip(other).zip(&weights.values);
            pairs.map(|((a, b), w)| f64::from(a - b).powi(2) * f64::from(*w)).sum()
        };
        let bases = BASES.min(depth + 1);
        let mut errors: Vec<f64> = (0..bases)
            .map(|base| {
                let texels = rounded(&levels[base as usize]);
                squares(&magnified(&texels, base, borders).values)
            })
            .collect();
        errors.push(squares(&vec![0.0; whole.values.len()]));
        Self { channel, term, levels, errors }
    }
}

/// Images of all terms of all channels.
pub fn term_images(
    tree: &PacketTree,
    coefficients: &[Vec<Plane>; 3],
    weights: &Plane,
    borders: Borders,
) -> Vec<TermImages> {
    let all: Vec<(usize, usize)> =
        (0..3).flat_map(|channel| (0..coefficients[channel].len()).map(move |term| (channel, term))).collect();
    let image = |at: &(usize, usize)| TermImages::new(*at, tree, &coefficients[at.0][at.1], weights, borders);
    all.par_iter().map(image).collect()
}

/// Rounds a plane to 8 bits over its range.
fn rounded(plane: &Plane) -> Plane {
    let (low, high) = range(std::slice::from_ref(plane));
    let scale = (high - low) / 255.0;
    if scale <= 0.0 {
        return plane.clone();
    }
    let inverse = 1.0 / scale;
    let values = plane.values.iter().map(|v| low + scale * ((v - low) * inverse).round()).collect();
    Plane { size: plane.size, values }
}

/// Smallest and largest value of all levels.
pub fn range(levels: &[Plane]) -> (f32, f32) {
    let values = levels.iter().flat_map(|level| &level.values);
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Magnifies texels by `level` levels as a bilinear sampler does, view by view, with texel centres at halves.
pub fn magnified(plane: &Plane, level: u32, Borders { repeats, views }: Borders) -> Plane {
    if level == 0 {
        return plane.clone();
    }
    let [width, height] = plane.size;
    let size = [width << level, height << level];
    let taps = |side: usize| -> Vec<([usize; 2], f32)> {
        let texels = (1u32 << level) as f32;
        let taps = (0..side << level).map(|k| Tap::new((k as f32 + 0.5) / texels, side as u32, repeats));
        taps.map(|tap| (tap.indices(), tap.weight)).collect()
    };
    let (columns, of_view) = (taps(width), taps(height / views));
    let rows = (0..views).flat_map(|view| {
        let first = view * (height / views);
        of_view.iter().map(move |([upper, lower], weight)| ([first + upper, first + lower], *weight))
    });
    let mut values = vec![0.0; size[0] * size[1]];
    let mut line = vec![0.0f32; width];
    for (([upper, lower], weight), target) in rows.zip(values.chunks_exact_mut(size[0])) {
        let (a, b) = (&plane.values[upper * width..][..width], &plane.values[lower * width..][..width]);
        for ((value, a), b) in line.iter_mut().zip(a).zip(b) {
            *value = a + weight * (b - a);
        }
        for (value, ([left, right], weight)) in target.iter_mut().zip(&columns) {
            *value = line[*left] + weight * (line[*right] - line[*left]);
        }
    }
    Plane { size, values }
}
