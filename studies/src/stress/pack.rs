//! Packs written to bytes and read back, up to the limits of 16-bit indices and of 3D textures.

use super::fed::{Numbers, Of, constant, header};
use super::row::{Measure, StressRow, Worst};
use super::stages::Stages;
use brdfc_core::Symmetry;
use brdfc_formats::ErrorSummary;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::{MAX_SLICES, SliceScale, WaveletPack};
use brdfc_jobs::encode::EncodeError;
use brdfc_wavelet::recipe::{Recipe, Target};

/// A pack whose last coefficients are stored, so that the largest entries are at the end of the index map.
pub fn pack(levels: u32, retained: usize, bits: u32, energy_preserving: bool, seed: u64) -> WaveletPack {
    let recipe = Recipe { levels, stored_levels: levels, bits, energy_preserving, ..Recipe::default() };
    let header = header(&recipe, 0.3, 0.01);
    let mut numbers = Numbers::new(seed);
    let cells = header.cells();
    let mut index = vec![0u16; cells];
    index[0] = 1;
    for slice in 2..=retained {
        index[cells - 1 - (retained - slice)] = slice as u16;
    }
    let scale = |numbers: &mut Numbers| {
        let scale = numbers.between(0.0, 4.0) as f32;
        SliceScale { scale, offset: -(numbers.unit() as f32) * scale }
    };
    // All coefficients of the other trees.
    let trees = header.coefficients() - cells;
    index.extend((retained + 1..).take(trees).map(|slice| slice as u16));
    let slices = retained + trees;
    let mut scales = vec![SliceScale::default()];
    scales.extend((0..slices).map(|_| scale(&mut numbers)));
    let slice = cells * header.texel_format().texel_bytes();
    let mut texels = vec![0; slice];
    texels.extend((0..slices * slice).map(|_| numbers.below(256) as u8));
    let (on_grid, off_grid) = (ErrorSummary::default(), ErrorSummary::default());
    WaveletPack { header, index, scales, on_grid, off_grid, crop: None, texels }
}

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let mut back = Worst::default();
    for levels in super::fed::levels(small) {
        let cells = 1usize << (2 * levels);
        for retained in [1, 2, cells / 2, cells].map(|retained| retained.min(MAX_SLICES - 1)) {
            // The largest of 16 bits has 16 MiB.
            for bits in [8, 16] {
                let pack = pack(levels, retained, bits, false, 9);
                back.check((stages.read)(&(stages.write)(&pack)).is_ok_and(|read| read == pack));
            }
        }
    }
    // Always at the limit, also with `small`: 64 x 64 cells and 2,047 slices in addition to the zero slice.
    let most = pack(6, MAX_SLICES - 1, 8, false, 9);
    back.check(
        (stages.read)(&(stages.write)(&most)).is_ok_and(|read| read.index.last() == Some(&2047) && read == most),
    );
    let mut refused = Worst::default();
    refused.check((stages.read)(&(stages.write)(&pack(6, MAX_SLICES, 8, false, 9))).is_err());
    let ratio = |ratio| Recipe { levels: 6, stored_levels: 6, target: Target::Ratio(ratio), ..Recipe::default() };
    for asked in [1.0, 1.5, 2.0] {
        let refusal = (stages.encode)(&constant(0.3), &ratio(asked));
        let slices = |found: &str| found.split(' ').find_map(|count| count.parse::<usize>().ok().filter(|n| *n > 2));
        refused.check(matches!(&refusal, Err(EncodeError::Size { field: "ratio", found, .. }) if slices(found) > Some(MAX_SLICES)));
    }
    let mut rows = vec![
        back.row(
            ["packs written and read", "all grids, 1 to 2047 slices, 8 and 16 bits"],
            Measure::Count,
            0.0,
            "a file contains the written values",
        ),
        refused.row(
            ["limit of slices", "2,049 slices of a 64 x 64 grid"],
            Measure::Count,
            0.0,
            "3D textures have at most 2,048 layers: rejected before the work, and by readers",
        ),
    ];
    if !small {
        rows.push(all_slices(stages));
    }
    rows
}

/// Encodes the maximum number of slices of a pack.
fn all_slices(stages: &Stages) -> StressRow {
    let mut worst = Worst::default();
    let source =
        Of { value: |pair: DirectionPair| 0.2 + pair.incoming[2] * pair.outgoing[2], symmetry: Symmetry::FULL };
    let recipe = Recipe {
        levels: 6,
        stored_levels: 6,
        target: Target::MaxBytes(u64::MAX),
        measure_off_grid: false,
        supercompress: false,
        ..Recipe::visible()
    };
    match (stages.encode)(&source, &recipe) {
        Ok(made) => {
            worst.check(made.pack.slices() == MAX_SLICES);
            worst.check((stages.read)(&made.bytes).is_ok_and(|read| read == made.pack));
        }
        Err(_) => worst.check(false),
    }
    worst.row(
        ["packs written and read", "an encode of a 64 x 64 grid without a limit of bytes"],
        Measure::Count,
        0.0,
        "the maximum number of slices of a 3D texture, numbers of 16 bits, and a file that is read again",
    )
}
