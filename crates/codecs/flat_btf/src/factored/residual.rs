//! The residual of shadows: the share of the base's value where a light reaches the surface, and the share of the diffuse
//! albedo where it does not, in cells of the tile. Both are least squares over the texels around a cell and over all views;
//! shaded values in the scale of their cube roots, in which a few bright ones at borders of shadows do not brighten all. The
//! base alone determines them, so that everything after it is linear in the weights.

use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::VisibilityMask;
use brdfc_formats::flat_btf::factored::ResidualMap;
use brdfc_formats::tap::Tap;
use rayon::prelude::*;

/// Cells per side that are tried, as far as a cell has four texels per side.
const CELLS: [u32; 4] = [1, 4, 16, 64];
const TEXELS_OF_CELL: u32 = 4;
/// Weight of the coarser level, as a share of the mean weight of a cell.
const RIDGE: f64 = 1e-2;
/// Share of a texel above which it counts as lit, for albedos and components.
const WHOLE: f32 = 0.75;
/// Share of a texel below which it counts as shaded, and all but which as lit, for the residual.
const SHADED: f32 = 0.02;
/// Shares of the coarsest level where nothing is known: direct light alone.
const DIRECT: [f64; 2] = [1.0, 0.0];

/// Sums over the views of a texel under a light, each a product with the value and a square: of the base, which predicts
/// lit values; and of the cube root of the diffuse albedo, which predicts the cube root of shaded values.
pub(super) type Products = [[f32; 2]; 2];

/// Shares of some texels under each light, `texels x L`: a value is `lit_root³ F + shaded d`, with the value F of base and
/// components, and the diffuse albedo d.
#[derive(Debug, Clone)]
pub(super) struct Shares {
    pub(super) lit_roots: Vec<f32>,
    /// The same for fits: 0, which leaves a value out, at borders of shadows. Images do not match the surface that exactly.
    pub(super) fit_roots: Vec<f32>,
    pub(super) shaded: Vec<f32>,
}

/// The lights that reach each texel, as far as values depend on it.
#[derive(Debug, Clone)]
pub(super) struct Arrival {
    texels: usize,
    lights: usize,
    /// None for values before shadows.
    known: Option<Known>,
}

#[derive(Debug, Clone)]
struct Known {
    /// For each light, the share of each texel that it reaches.
    lit: Vec<f32>,
    sums: CellSums,
}

/// Sums of the finest cells: for each light `side²` cells, each with products of lit and of shaded texels.
#[derive(Debug, Clone)]
struct CellSums {
    side: u32,
    sums: Vec<[[f64; 2]; 2]>,
}

impl Arrival {
    /// Without sums. `lit` are the texels that each light reaches; none for values before shadows. `blur` is the weight of
    /// neighbours in values.
    pub(super) fn new(texels: u32, lights: usize, lit: Option<&VisibilityMask>, blur: f32) -> Self {
        let size = texels as usize;
        let known = lit.map(|mask| {
            let at = |k: usize| [k % size, k / size % size].map(|c| c as u32);
            let is_lit = |k: usize| f32::from(u8::from(mask.is_seen((k / (size * size)) as u32, at(k))));
            let lit: Vec<f32> = (0..lights * size * size).map(is_lit).collect();
            let lit = lit.par_chunks(size * size).flat_map_iter(|lit| blurred(lit, size, blur)).collect();
            let side = max_cells(texels);
            let sums = vec![[[0.0; 2]; 2]; lights * (side * side) as usize];
            Known { lit, sums: CellSums { side, sums } }
        });
        Self { texels: size, lights, known }
    }

    /// Returns true if values depend on the lights that reach a texel.
    pub(super) fn is_known(&self) -> bool {
        self.known.is_some()
    }

    /// Cells per side of the residuals to try, ascending: 0, no residual, for values before shadows.
    pub(super) fn sizes(&self) -> Vec<u32> {
        let most = max_cells(self.texels as u32);
        if self.is_known() { CELLS.into_iter().filter(|cells| *cells <= most).collect() } else { vec![0] }
    }

    /// Returns true if a light reaches all of a texel, or if values do not depend on it.
    pub(super) fn reaches(&self, texel: usize, light: usize) -> bool {
        let at = light * self.texels * self.texels + texel;
        self.known.as_ref().is_none_or(|known| known.lit[at] > WHOLE)
    }

    /// Adds texels from `first` on: products for each light of each.
    pub(super) fn add(&mut self, first: usize, products: &[Products]) {
        let (size, lights) = (self.texels, self.lights);
        let Some(Known { lit, sums: CellSums { side, sums } }) = &mut self.known else { return };
        let (side, cells) = (*side, (*side * *side) as usize);
        sums.par_chunks_mut(cells).enumerate().for_each(|(light, cells)| {
            for (texel, products) in (first..).zip(products.iter().skip(light).step_by(lights)) {
                let at = light * size * size + texel;
                for (cell, share) in around([texel % size, texel / size], size, side) {
                    // Texels at the border of a shadow say little of either side.
                    let counts = [lit[at] > 1.0 - SHADED, lit[at] < SHADED];
                    for ((sums, products), _) in
                        cells[cell].iter_mut().zip(products).zip(counts).filter(|(_, counts)| *counts)
                    {
                        sums.iter_mut().zip(products).for_each(|(sum, number)| *sum += f64::from(share * number));
                    }
                }
            }
        });
    }

    /// The residual of `cells` per side; none for 0, and for values before shadows.
    ///
    /// # Errors
    /// Returns an error for more lights than a texture can have.
    pub(super) fn residual(&self, cells: u32) -> Result<Option<ResidualMap>, FormatError> {
        let Some(known) = self.known.as_ref().filter(|_| cells > 0) else { return Ok(None) };
        let mut levels = vec![known.sums.clone()];
        while let Some(last) = levels.last().filter(|last| last.side > 1) {
            levels.push(last.halved());
        }
        // From one cell to the finest.
        let mut shares: Vec<Vec<[f64; 2]>> = Vec::new();
        for level in levels.iter().rev().filter(|level| level.side <= cells) {
            shares.push(level.shares(shares.last().map(Vec::as_slice)));
        }
        let bytes = shares.iter().rev().flatten().flatten().map(|share| ResidualMap::byte_of(*share as f32));
        ResidualMap::new(cells, self.lights as u32, bytes.collect()).map(Some)
    }

    /// Shares of some texels.
    pub(super) fn shares(&self, residual: Option<&ResidualMap>, texels: &[usize]) -> Shares {
        let of_texel = |texel: &usize| -> Vec<[f32; 3]> {
            let Some(known) = &self.known else { return vec![[1.0, 1.0, 0.0]; self.lights] };
            let taps = residual.map(|map| around([texel % self.texels, texel / self.texels], self.texels, map.size()));
            let of_light = |light: usize| {
                let lit = known.lit[light * self.texels * self.texels + texel];
                let shares = match (residual, &taps) {
                    (Some(map), Some(taps)) => {
                        let cells = map.layer(0, light as u32);
                        [0, 1].map(|channel: usize| {
                            let root = |(at, share): &(usize, f32)| share * f32::from(cells[2 * at + channel]) / 255.0;
                            ResidualMap::share(taps.iter().map(root).sum())
                        })
                    }
                    _ => DIRECT.map(|share| share as f32),
                };
                let root = (lit * shares[0]).cbrt();
                [root, if lit > WHOLE { root } else { 0.0 }, (1.0 - lit) * shares[1]]
            };
            (0..self.lights).map(of_light).collect()
        };
        let all: Vec<[f32; 3]> = texels.par_iter().flat_map_iter(of_texel).collect();
        let [lit_roots, fit_roots, shaded] = [0, 1, 2].map(|k: usize| all.iter().map(|shares| shares[k]).collect());
        Shares { lit_roots, fit_roots, shaded }
    }
}

/// Means with the two neighbours in both directions, which have the weight `blur` each.
fn blurred(lit: &[f32], size: usize, blur: f32) -> Vec<f32> {
    let near = |at: usize| [((at + size - 1) % size, blur), (at, 1.0 - 2.0 * blur), ((at + 1) % size, blur)];
    let mean = |texel: usize| {
        let row = |(row, share): (usize, f32)| {
            near(texel % size).iter().map(|(column, weight)| weight * share * lit[row * size + column]).sum::<f32>()
        };
        near(texel / size).into_iter().map(row).sum()
    };
    (0..lit.len()).map(mean).collect()
}

/// Maximum number of cells per side of a residual, a power of two, for a flat BTF of `texels` per side.
pub fn max_cells(texels: u32) -> u32 {
    let fitting = (texels / TEXELS_OF_CELL).clamp(1, CELLS[CELLS.len() - 1]);
    1 << fitting.ilog2()
}

/// Cells around the centre of a texel, and their shares.
fn around(texel: [usize; 2], texels: usize, cells: u32) -> [(usize, f32); 4] {
    let [column, row] = texel.map(|at| Tap::new((at as f32 + 0.5) / texels as f32 * cells as f32, cells, true));
    [0, 1, 2, 3].map(|k| {
        let share = |tap: Tap, second: usize| if second == 1 { tap.weight } else { 1.0 - tap.weight };
        let (right, below) = (k & 1, k >> 1);
        let cell = row.indices()[below] * cells as usize + column.indices()[right];
        (cell, share(row, below) * share(column, right))
    })
}

impl CellSums {
    /// Sums of cells of twice the side.
    fn halved(&self) -> Self {
        let (fine, side) = (self.side as usize, self.side as usize / 2);
        let of_light = |cells: &[[[f64; 2]; 2]]| {
            let mut sums = vec![[[0.0; 2]; 2]; side * side];
            for (at, cell) in cells.iter().enumerate() {
                let sum = &mut sums[at / fine / 2 * side + at % fine / 2];
                sum.as_flattened_mut().iter_mut().zip(cell.as_flattened()).for_each(|(sum, number)| *sum += number);
            }
            sums
        };
        Self { side: side as u32, sums: self.sums.chunks_exact(fine * fine).flat_map(of_light).collect() }
    }

    /// Shares of the light in each cell, reached and shaded, drawn towards those of the level above, of half the side.
    fn shares(&self, above: Option<&[[f64; 2]]>) -> Vec<[f64; 2]> {
        let side = self.side as usize;
        let count = side * side;
        let of_light = |(light, cells): (usize, &[[[f64; 2]; 2]])| {
            // The coarsest level has none above it.
            let ridge = if above.is_some() { RIDGE } else { 0.0 };
            let ridges = [0, 1]
                .map(|state: usize| ridge * cells.iter().map(|cell| cell[state][1]).sum::<f64>() / count as f64 + 1e-9);
            let share = |at: usize| {
                let half = side / 2;
                let prior =
                    above.map_or(DIRECT, |above| above[light * half * half + at / side / 2 * half + at % side / 2]);
                let least_squares = |state: usize, prior: f64| {
                    let [product, square] = cells[at][state];
                    (product + ridges[state] * prior) / (square + ridges[state])
                };
                [least_squares(0, prior[0]), least_squares(1, prior[1].cbrt()).powi(3)]
            };
            (0..count).map(share).collect::<Vec<_>>()
        };
        self.sums.chunks_exact(count).enumerate().flat_map(of_light).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tile whose left half a single light reaches, with values 0.6 of the base there and 0.125 of the albedo elsewhere,
    /// blurred across the border.
    #[test]
    fn blurred_borders_do_not_change_the_shares() {
        let size = 16;
        let bytes = (0..size * size).map(|k| if k % size < size / 2 { 255 } else { 0 }).collect();
        let mask = VisibilityMask::new(size, 1, bytes).unwrap();
        for blur in [0.0f32, 0.1, 0.25] {
            let mut arrival = Arrival::new(size, 1, Some(&mask), blur);
            let known = arrival.known.as_ref().unwrap();
            let border = known.lit[(size / 2 - 1) as usize];
            assert!((border - (1.0 - blur)).abs() < 1e-6 && (known.lit[8] - blur).abs() < 1e-6, "{border}");
            let (base, albedo) = (0.8f32, 0.5f32);
            let products: Vec<Products> = known
                .lit
                .iter()
                .map(|lit| {
                    let value = lit * 0.6 * base + (1.0 - lit) * 0.125 * albedo;
                    [[value * base, base * base], [value.cbrt() * albedo.cbrt(), albedo.cbrt().powi(2)]]
                })
                .collect();
            arrival.add(0, &products);
            let map = arrival.residual(1).unwrap().unwrap();
            let shares = [0, 1].map(|k: usize| ResidualMap::share(f32::from(map.layer(0, 0)[k]) / 255.0));
            // What leaks over the border brightens lit texels a little.
            assert!((shares[0] - 0.6).abs() < 0.02 && (shares[1] - 0.125).abs() < 0.005, "{blur}: {shares:?}");
            let Shares { lit_roots, fit_roots, shaded } = arrival.shares(Some(&map), &[3, 7, 8, 12]);
            let expected = [0.6, 0.6 * (1.0 - blur), 0.6 * blur, 0.0];
            assert!((0..4).all(|k| (lit_roots[k].powi(3) - expected[k]).abs() < 0.02), "{blur}: {lit_roots:?}");
            let left = [true, 1.0 - blur > WHOLE, false, false];
            assert!((0..4).all(|k| fit_roots[k] == if left[k] { lit_roots[k] } else { 0.0 }), "{blur}: {fit_roots:?}");
            assert!((shaded[0] == 0.0) && (shaded[3] - 0.125).abs() < 0.005, "{blur}: {shaded:?}");
        }
    }

    /// Cells without a light take the shares of the cells around them, and without any those of direct light.
    #[test]
    fn empty_cells_take_the_level_above() {
        let size = 32;
        let mask = VisibilityMask::new(size, 1, vec![255; (size * size) as usize]).unwrap();
        let mut arrival = Arrival::new(size, 1, Some(&mask), 0.0);
        assert_eq!((arrival.sizes(), max_cells(size), max_cells(3), max_cells(1000)), (vec![1, 4], 8, 1, 64));
        // Only the first row of texels says anything.
        arrival.add(0, &vec![[[0.5, 1.0], [0.0, 0.0]]; size as usize]);
        let map = arrival.residual(8).unwrap().unwrap();
        let cells = map.layer(0, 0);
        assert_eq!((cells.len(), map.levels()), (128, 4));
        assert!(cells.as_chunks::<2>().0.iter().all(|cell| *cell == [ResidualMap::byte_of(0.5), 0]), "{cells:?}");
        let none = Arrival::new(size, 1, Some(&mask), 0.0).residual(1).unwrap().unwrap();
        assert_eq!(none.layer(0, 0), [180, 0]);
    }

    /// A texel's cells are those that the decoder filters, across the border of the tile too.
    #[test]
    fn shares_are_those_of_the_decoder() {
        assert_eq!(
            around([0, 0], 8, 2).map(|(cell, share)| (cell, (share * 64.0).round())),
            [(3, 9.0), (2, 15.0), (1, 15.0), (0, 25.0)]
        );
        let cells: f32 = around([5, 2], 7, 4).iter().map(|(_, share)| share).sum();
        assert!((cells - 1.0).abs() < 1e-6);
    }
}
