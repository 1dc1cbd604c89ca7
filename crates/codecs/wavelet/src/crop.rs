//! What a wavelet pack needs not hold where a scene shows a material from some directions only: outer cells, which are
//! lights', and coefficients that no viewer's cell depends on.

use brdfc_formats::crop::{Crop, DirectionRange, Elevations, Window};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::{Header, WaveletPack, haar::detail_indices};
use std::f64::consts::PI;

/// Cells around those that filtering touches.
const GUARD: f64 = 1.0;

/// A pack without what look-ups within a range of directions do not touch. Packs over half-difference angles stay as they
/// are.
pub fn crop(pack: WaveletPack, directions: DirectionRange) -> WaveletPack {
    let header = pack.header;
    if directions.is_all() || header.parameterisation != Parameterisation::TangentPole {
        return pack;
    }
    let pack = without_unneeded(pack, &needed_coefficients(&header, directions.view));
    pack.cropped(Crop { directions, window: window(&header, directions.light) })
        .expect("a window is within the grid that it was found for")
}

/// The rectangle of outer cells that look-ups within a range touch, and a ring around them.
pub fn window(header: &Header, light: Elevations) -> Window {
    let grid = header.grid();
    let needed = needed_cells(grid, light);
    let bounds = |place: &dyn Fn(usize) -> usize| {
        let all = || (0..grid * grid).filter(|cell| needed[*cell]).map(place);
        (all().min().unwrap_or(0) as u32, all().max().unwrap_or(0) as u32)
    };
    let (columns, rows) = (bounds(&|cell| cell % grid), bounds(&|cell| cell / grid));
    Window::between([columns.0, rows.0], [columns.1, rows.1])
}

/// Of each coefficient, whether a cell that look-ups within a range touch, or one beside it, depends on it.
pub fn needed_coefficients(header: &Header, view: Elevations) -> Vec<bool> {
    let (grid, levels) = (header.grid(), header.levels);
    let mut needed = vec![false; header.cells()];
    needed[0] = true;
    for cell in needed_cells(grid, view).iter().enumerate().filter_map(|(cell, is_needed)| is_needed.then_some(cell)) {
        let (column, row) = (cell % grid, cell / grid);
        for j in 0..levels {
            let child_row = row >> (levels - j - 1);
            let (latitude, longitude) = detail_indices(j, column >> (levels - j), child_row >> 1, child_row);
            (needed[latitude], needed[longitude]) = (true, true);
        }
    }
    needed
}

/// Of each cell, whether a direction within the range is so close that bilinear filtering touches it, or one beside it.
fn needed_cells(grid: usize, range: Elevations) -> Vec<bool> {
    let step = PI / grid as f64;
    // The sine of an angle is largest in the middle of its range, or at the end that is nearest to it.
    let sines = |cell: usize| {
        let [low, high] = [-0.5 - GUARD, 1.5 + GUARD].map(|off| ((cell as f64 + off) * step).clamp(0.0, PI));
        let most = if low <= PI / 2.0 && high >= PI / 2.0 { 1.0 } else { low.sin().max(high.sin()) };
        [low.sin().min(high.sin()), most]
    };
    let sines: Vec<[f64; 2]> = (0..grid).map(sines).collect();
    let [lowest, highest] = range.sines();
    // z is the product of the sines of longitude and colatitude.
    let touched = |cell: usize| {
        let (column, row) = (sines[cell % grid], sines[cell / grid]);
        column[1] * row[1] >= lowest && column[0] * row[0] <= highest
    };
    (0..grid * grid).map(touched).collect()
}

/// The pack without the slices of coefficients that are not needed.
fn without_unneeded(pack: WaveletPack, needed: &[bool]) -> WaveletPack {
    let slice_bytes = pack.header.cells() * pack.header.texel_format().texel_bytes();
    let kept: Vec<usize> = (0..pack.index.len()).filter(|k| pack.index[*k] != 0 && needed[*k]).collect();
    let old = || std::iter::once(0).chain(kept.iter().map(|k| usize::from(pack.index[*k])));
    let mut index = vec![0u16; pack.index.len()];
    (1..).zip(&kept).for_each(|(slice, k)| index[*k] = slice);
    WaveletPack {
        index,
        scales: old().map(|slice| pack.scales[slice]).collect(),
        texels: old().flat_map(|slice| &pack.texels[slice * slice_bytes..][..slice_bytes]).copied().collect(),
        ..pack
    }
}
