//! Selection of slices, and rounding of their values.

use super::fed::{Filling, Numbers, header, levels, table};
use super::row::{Measure, StressRow, U, Worst};
use super::stages::Stages;
use brdfc_core::Symmetry;
use brdfc_wavelet::haar::transform;
use brdfc_wavelet::recipe::Recipe;
use brdfc_wavelet::table::Table;

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    vec![threshold(stages, small), symmetric_energies(stages, small), quantise(stages, 8), quantise(stages, 16)]
}

/// Few distinct energies, so that nearly all are ties.
fn threshold(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    for levels in levels(small) {
        let count = 1usize << (2 * levels);
        let mut numbers = Numbers::new(5);
        let kinds: [&mut dyn FnMut() -> f64; 5] = [
            &mut || 0.0,
            &mut || 3.5,
            &mut || 1e-320,
            &mut {
                let mut a = Numbers::new(6);
                move || if a.unit() < 0.5 { 1e-24 } else { 1e12 }
            },
            &mut || numbers.below(7) as f64 * 1e-12,
        ];
        for energy in kinds {
            let energies: Vec<f64> = (0..count).map(|_| energy()).collect();
            // Repeated search for the maximum, of which the first counts; the scaling coefficient is always selected.
            let mut left: Vec<usize> = (1..count).collect();
            left.sort_by(|a, b| energies[*b].total_cmp(&energies[*a]));
            for asked in [0, 1, 2, count / 4 + 1, count - 1, count, count + 1] {
                let selected = (stages.threshold)(&energies, levels, asked);
                let weakest = selected.iter().skip(1).map(|k| energies[*k as usize]).fold(f64::INFINITY, f64::min);
                let mut dropped = (1..count).filter(|k| selected.binary_search(&(*k as u32)).is_err());
                // No discarded one is larger, or equal and earlier.
                let last_tie = selected.iter().skip(1).filter(|k| energies[**k as usize] == weakest).max();
                let right = |k: usize| {
                    energies[k] < weakest || (energies[k] == weakest && last_tie.is_none_or(|last| k as u32 > *last))
                };
                worst.check(selected.len() == asked.clamp(1, count));
                worst.check(selected.first() == Some(&0) && selected.windows(2).all(|pair| pair[0] < pair[1]));
                worst.check(selected.len() == 1 || dropped.all(right));
                worst.check(selected == (stages.threshold)(&energies, levels, asked));
            }
        }
    }
    worst.row(
        ["threshold", "all grids, energies that are all equal, two, or seven values"],
        Measure::Count,
        0.0,
        "the requested number, the largest, ties by index, the same each time",
    )
}

/// Coefficients that are images of each other must tie, otherwise packs of symmetric materials would be asymmetric.
fn symmetric_energies(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    for levels in levels(small).filter(|levels| *levels < 5) {
        for filling in Filling::ALL {
            let mirror = Symmetry { isotropic: false, mirror: true, reciprocal: false };
            let cells = 1usize << (2 * levels);
            let samples = filling.numbers(cells * cells / 4, &mut Numbers::new(7));
            let coefficients = transform(&table(levels, mirror, &samples));
            let energies = (stages.energies)(&coefficients);
            for flip in coefficients.fold.flips() {
                for k in 0..cells {
                    let image = brdfc_wavelet::haar::flip_coefficient(k, *flip).0;
                    worst.check(energies[k].to_bits() == energies[image].to_bits());
                }
            }
        }
    }
    worst.row(
        ["energies of slices, f64", "tables with mirrors"],
        Measure::Count,
        0.0,
        "images of a coefficient have bit-identical energies, since sums are sorted first",
    )
}

/// Slices of 8 bits, or of 10 to 16.
fn quantise(stages: &Stages, texture: u32) -> StressRow {
    let levels = 2;
    let cells = 1usize << (2 * levels);
    let all: Vec<u32> = (0..cells as u32).collect();
    let mut worst = Worst::default();
    for bits in if texture == 8 { 8..=8 } else { 10..=16 } {
        for filling in Filling::ALL {
            for offset in [0.0f32, 1e-6, 1.0, -1e6] {
                let samples = filling.numbers(cells * cells, &mut Numbers::new(8));
                let samples: Vec<f32> = samples.iter().map(|v| v + offset).collect();
                let table = table(levels, Symmetry::NONE, &samples);
                slices(stages, &table, &all, bits, &mut worst);
            }
        }
    }
    let fed = if texture == 8 {
        "8 bits: 1e-12 to 1e6, denormals, constants, far from 0, a spike"
    } else {
        "10 to 16 bits: the same"
    };
    let why = "half a step; scale and offset rounded to f32; between 8 and 16 bits half a step of the texture, too";
    worst.row(["rounding to texels", fed], Measure::OfBound, 1.0, why)
}

fn slices(stages: &Stages, table: &Table, all: &[u32], bits: u32, worst: &mut Worst) {
    let header = header(&Recipe { levels: 2, stored_levels: 2, bits, ..Recipe::default() }, 1.0, 0.01);
    let quantised = (stages.quantise)(table, all, &header);
    let bytes = header.texel_format().component_bytes();
    let (last, stored_last) = (f64::from((1u32 << bits) - 1), if bytes == 1 { 255.0 } else { 65535.0 });
    for k in all {
        let scale = quantised.scales[*k as usize + 1];
        let (range, offset) = (f64::from(scale.scale), f64::from(scale.offset));
        let spread = if bits == 8 || bits == 16 { 0.0 } else { 0.5 / stored_last };
        let rounded = 2.0 * U * (range + offset.abs() + f64::from(f32::MIN_POSITIVE));
        let allowed = range * (0.5 / last + spread) + rounded;
        for outer in 0..all.len() {
            let at = ((*k as usize + 1) * all.len() + outer) * bytes;
            let mut stored = [0u8; 2];
            stored[..bytes].copy_from_slice(&quantised.texels[at..at + bytes]);
            let found = offset + range * f64::from(u16::from_le_bytes(stored)) / stored_last;
            worst.add((found - f64::from(table.row(0, outer)[*k as usize])) / allowed);
        }
    }
}
