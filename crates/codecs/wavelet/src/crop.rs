//! Parts of a wavelet pack that a limited range of directions never uses: outer cells, one for each direction of light,
//! and coefficients that no viewer's cell depends on.

use brdfc_formats::crop::{Crop, DirectionRange, Elevations, Window};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::{Header, WaveletPack, haar::detail_indices};
use std::f64::consts::PI;

/// Width of the ring around the cells that filtering reads.
const GUARD: f64 = 1.0;

/// Crops a pack to the data that look-ups within a range of directions read. Packs over half-difference angles stay
/// unchanged.
pub fn crop(pack: WaveletPack, directions: DirectionRange) -> WaveletPack {
    let header = pack.header;
    if directions.is_all() || header.parameterisation != Parameterisation::TangentPole {
        return pack;
    }
    let pack = without_unneeded(pack, &needed_coefficients(&header, directions.view));
    pack.cropped(Crop { directions, window: window(&header, directions.light) })
        .expect("a window is within its own grid")
}

/// Rectangle of outer cells that look-ups within a range read, with a ring around them.
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

/// Marks the coefficients that influence a cell that look-ups within a range read, or a neighbour of such a cell.
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

/// Marks the cells that bilinear filtering reads for a direction within the range, and their neighbours.
fn needed_cells(grid: usize, range: Elevations) -> Vec<bool> {
    let step = PI / grid as f64;
    // The sine of an angle is largest in the middle of its range, or at the closest end.
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

/// Drops the slices of unneeded coefficients from a pack.
fn without_unneeded(pack: WaveletPack, needed: &[bool]) -> WaveletPack {
    let slice_bytes = pack.header.cells() * pack.header.texel_format().texel_bytes();
    let retained: Vec<usize> =
        (0..pack.index.len()).filter(|k| pack.index[*k] != 0 && needed[pack.header.in_finest_tree(*k)]).collect();
    let old = || std::iter::once(0).chain(retained.iter().map(|k| usize::from(pack.index[*k])));
    let mut index = vec![0u16; pack.index.len()];
    (1..).zip(&retained).for_each(|(slice, k)| index[*k] = slice);
    WaveletPack {
        index,
        scales: old().map(|slice| pack.scales[slice]).collect(),
        texels: old().flat_map(|slice| &pack.texels[slice * slice_bytes..][..slice_bytes]).copied().collect(),
        ..pack
    }
}
