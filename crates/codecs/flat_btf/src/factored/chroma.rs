//! Range of colours that texels have: decoders clamp sums of components to it.

use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{ChromaRange, to_opponent};
use brdfc_formats::flat_btf::{FlatView, VisibilityMask};
use rayon::prelude::*;

/// Lightness of a grey of 0.5 % of a white diffuser: darker values have no measurable colour.
const DARK: f32 = 20.0;
/// Texels of a unit of parallel work.
const CHUNK: usize = 4096;

/// Smallest and largest ratio of each opponent colour to lightness.
type Ratios = [[f32; 2]; 2];

/// Range of the ratios of the texels visited.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chroma(Ratios);

impl Chroma {
    pub(super) fn none() -> Self {
        Self([[f32::INFINITY, f32::NEG_INFINITY]; 2])
    }

    fn and(self, other: Self) -> Self {
        Self([0, 1].map(|k: usize| [self.0[k][0].min(other.0[k][0]), self.0[k][1].max(other.0[k][1])]))
    }

    /// Adds every texel that a view sees under one light each; the light changes from view to view and from texel to
    /// texel.
    pub(super) fn add_view(&mut self, view: &FlatView, mask: &VisibilityMask) {
        let header = view.header();
        let (size, lights, number) = (header.size, header.lights.len(), header.view);
        let texels: Vec<u32> = (0..size * size).collect();
        let of_chunk = |texels: &[u32]| {
            let seen = texels.iter().filter(|at| mask.is_seen(number, [**at % size, **at / size]));
            seen.fold(Self::none(), |all, at| {
                let light = (*at as usize + number as usize) % lights;
                let [lightness, a, b] = to_opponent(rgb9e5::decode(view.light(light as u32)[*at as usize]));
                if lightness > DARK { all.and(Self([a, b].map(|c| [c / lightness; 2]))) } else { all }
            })
        };
        let chunks: Vec<Self> = texels.par_chunks(CHUNK).map(of_chunk).collect();
        *self = chunks.into_iter().fold(*self, Self::and);
    }

    /// Range of the texels visited; all colours if none was bright enough.
    pub(super) fn range(self) -> ChromaRange {
        if self.0[0][0] > self.0[0][1] { ChromaRange::ALL } else { ChromaRange::around(self.0) }
    }
}
