//! Packs against the physics of their sources. Every check has a negative control that fails.

use brdfc_core::address::parse_synth;
use brdfc_core::{PackSource, Source, Symmetry};
use brdfc_formats::direction::{DirectionPair, Parameterisation, Vector, cell_centre, from_polar, from_tangent_pole};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_metrics::compare::compare;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_testing::checks::{albedo, value};
use brdfc_testing::wrapped::{Claiming, OneWay};
use brdfc_wavelet::encode::{Encoded, encode};
use brdfc_wavelet::haar;
use brdfc_wavelet::log_encode::{DEFAULT_BIAS, LogEncoding, log_encode};
use brdfc_wavelet::measure::grid_error;
use brdfc_wavelet::recipe::{Recipe, Target};
use brdfc_wavelet::resample::resample;
use brdfc_wavelet::table::{Grid, Table};
use std::f64::consts::{FRAC_1_PI, FRAC_1_SQRT_2, PI};

fn source(address: &str) -> Box<dyn Source> {
    parse_synth(address).unwrap()
}

fn grid(parameterisation: Parameterisation, levels: u32) -> Grid {
    Grid { parameterisation, levels }
}

fn tangent_pole(levels: u32) -> Grid {
    grid(Parameterisation::TangentPole, levels)
}

fn encoded(source: &dyn Source, grid: Grid, change: impl Fn(&mut Recipe)) -> Encoded {
    let Grid { parameterisation, levels } = grid;
    let mut recipe = Recipe { parameterisation, levels, stored_levels: levels, ..Recipe::default() };
    change(&mut recipe);
    encode(source, &recipe, &()).unwrap()
}

/// The pack as an engine sees it: through the bytes of its file.
fn decoded(encoded: &Encoded, level: Option<f32>) -> PackSource {
    PackSource::new(&WaveletPack::from_bytes(&encoded.bytes).unwrap(), level)
}

/// Largest relative distance of a source from a constant colour.
fn distance_from_constant(source: &dyn Source, constant: [f64; 3]) -> f64 {
    brdfc_testing::checks::random_pairs(500)
        .into_iter()
        .flat_map(|pair| {
            let found = value(source, pair);
            (0..3).map(move |c| (found[c] / constant[c] - 1.0).abs())
        })
        .fold(0.0, f64::max)
}

#[test]
fn lambert_is_the_same_constant_at_every_direction_and_level() {
    for parameterisation in Parameterisation::NAMES.map(|(_, p)| p) {
        for (address, albedo, allowed) in [
            ("synth:lambert?kd=0.5", [0.5; 3], 1e-5),
            // Half a step of 8 bits of the scaling slice, which spans ln 8 from the darkest to the brightest channel.
            ("synth:lambert?kd=0.8,0.5,0.1", [0.8, 0.5, 0.1], 8f64.ln() / 510.0 * 1.1),
        ] {
            let pack = encoded(source(address).as_ref(), grid(parameterisation, 3), |_| ());
            for level in [0.0, 0.5, 1.0, 2.75, 3.0] {
                let found = distance_from_constant(&decoded(&pack, Some(level)), albedo.map(|kd| kd * FRAC_1_PI));
                assert!(found <= allowed, "{address}, {parameterisation:?}, level {level}: {found}");
            }
        }
    }
    let shiny = encoded(source("synth:lewis?kd=0.5&ks=0.05").as_ref(), tangent_pole(3), |_| ());
    let found = distance_from_constant(&decoded(&shiny, None), [0.5 * FRAC_1_PI; 3]);
    assert!(found > 0.05, "a little gloss is visible: {found}");
}

#[test]
fn a_white_pack_reflects_everything() {
    let white = encoded(source("synth:lambert?kd=1").as_ref(), tangent_pole(4), |_| ());
    let grey = encoded(source("synth:lambert?kd=0.98").as_ref(), tangent_pole(4), |_| ());
    for theta in [0.0, 0.6, 1.2, 1.5] {
        let found = albedo(&decoded(&white, None), from_polar(theta, 0.7), 16)[0];
        assert!((found - 1.0).abs() < 1e-4, "{theta}: {found}");
        let less = albedo(&decoded(&grey, None), from_polar(theta, 0.7), 16)[0];
        assert!((less - 1.0).abs() > 0.01, "{less}");
    }
}

#[test]
fn tables_of_symmetric_sources_have_the_symmetries() {
    for address in ["synth:ward?kd=0.2&ay=0.5", "synth:lewis"] {
        let claimed = source(address);
        let none = Claiming(source(address), Symmetry::NONE);
        for parameterisation in Parameterisation::NAMES.map(|(_, p)| p) {
            let (folded, tally) = resample(claimed.as_ref(), grid(parameterisation, 3));
            let (whole, all) = resample(&none, grid(parameterisation, 3));
            assert!(tally.evaluations * 4 < all.evaluations, "{} of {}", tally.evaluations, all.evaluations);
            assert!(largest_difference(&folded, &whole) < 1e-5, "{address}, {parameterisation:?}");
        }
    }
    let full = Symmetry { isotropic: false, ..Symmetry::FULL };
    let (folded, _) = resample(&Claiming(Box::new(OneWay(source("synth:lewis"))), full), tangent_pole(3));
    let (whole, _) = resample(&OneWay(source("synth:lewis")), tangent_pole(3));
    assert!(largest_difference(&folded, &whole) > 0.1, "a false claim is detected");
}

#[test]
fn half_difference_tables_hold_nothing_from_the_horizon_itself() {
    let (table, _) = resample(source("synth:ward?kd=0.2&ay=0.5").as_ref(), grid(Parameterisation::HalfDifference, 4));
    // Between 1e-3 above the horizon and the normal no value exceeds 400 / sr, and the mean is that of a grey paint.
    assert!(table.values.iter().all(|v| *v < 400.0) && table.mean() < 1.0, "mean {}", table.mean());
}

/// Largest relative difference of two tables of one grid, cell by cell. Pairs exactly on the horizon are left out:
/// rounding decides between a value and the value just above.
fn largest_difference(a: &Table, b: &Table) -> f64 {
    let (n, cells) = (a.grid.n(), a.grid.cells());
    let at = |table: &Table, outer: usize, inner: usize| {
        let (row, flip) = table.fold.locate(outer);
        f64::from(table.row(0, row)[flip.cell(inner, n)])
    };
    let centre = |cell: usize| cell_centre(cell % n, cell / n, n);
    let mut largest: f64 = 0.0;
    for outer in 0..cells {
        for inner in 0..cells {
            let pair = a.grid.parameterisation.from_axes(centre(outer), centre(inner));
            if pair.incoming[2].abs().min(pair.outgoing[2].abs()) < 1e-9 {
                continue;
            }
            let (x, y) = (at(a, outer, inner), at(b, outer, inner));
            largest = largest.max((x - y).abs() / x.abs().max(y.abs()).max(1e-12));
        }
    }
    largest
}

#[test]
fn a_pack_of_a_reciprocal_source_is_nearly_reciprocal() {
    let fine = |r: &mut Recipe| (r.target, r.bits) = (Target::Ratio(1.0), 16);
    let good = encoded(source("synth:lewis").as_ref(), tangent_pole(3), fine);
    assert!(good.on_grid.reciprocity < 1e-4, "{}", good.on_grid.reciprocity);
    let bad = encoded(&OneWay(source("synth:lewis")), tangent_pole(3), fine);
    assert!(bad.on_grid.reciprocity > 0.1, "{}", bad.on_grid.reciprocity);
}

#[test]
fn a_false_claim_of_reciprocity_shows_at_test_directions() {
    let claim = Symmetry { isotropic: false, ..Symmetry::FULL };
    let honest = encoded(&OneWay(source("synth:lewis?n=3")), tangent_pole(4), |_| ());
    let lying = encoded(&Claiming(Box::new(OneWay(source("synth:lewis?n=3"))), claim), tangent_pole(4), |_| ());
    let [honest, lying] = [honest, lying].map(|e| e.off_grid.norms.relative_mean);
    assert!(lying > 2.0 * honest && lying > 0.1, "{honest} {lying}");
}

#[test]
fn half_difference_suits_a_glossy_isotropic_source() {
    let glossy = source("synth:ggx?kd=0.1&f0=0.2&alpha=0.15");
    let [tangent, half] = Parameterisation::NAMES.map(|(_, p)| encoded(glossy.as_ref(), grid(p, 4), |_| ()));
    // The RMS is dominated by the highlight; ε_r gives the dark rest the same weight, and is no better.
    let uniform = PairSet::new(random_pairs(2000, 2007));
    let [a, b] = [&tangent, &half].map(|e| compare(glossy.as_ref(), &decoded(e, None), &uniform).0.norms.rms);
    println!("RMS at test directions: tangent-pole {a:.4}, half-difference {b:.4}");
    assert!(b < 0.75 * a, "{a} {b}");
    // The file's bytes decode to the measured values.
    let (again, _) = compare(glossy.as_ref(), &decoded(&half, None), &PairSet::comparison());
    assert_eq!(again, half.off_grid);
    // Negative control: the same texels, read with the other parameterisation.
    let mut swapped = half.pack.clone();
    swapped.header.parameterisation = Parameterisation::TangentPole;
    let (wrong, _) = compare(glossy.as_ref(), &PackSource::new(&swapped, None), &uniform);
    assert!(wrong.norms.rms > 2.0 * b, "{}", wrong.norms.rms);
}

/// Coefficient `k` of an image of `n` x `n` samples, as an inner product with its wavelet: independent of the tested
/// code, without a cascade.
fn coefficient(k: usize, n: usize, sample: impl Fn(usize, usize) -> f64) -> f64 {
    // Columns and rows of the wavelet's support, and where its sign changes.
    let (columns, rows, split_rows) = match k {
        0 => (0..n, 0..n, None),
        _ => {
            let side = 1usize << (k.ilog2() / 2);
            let (first, block) = (side * side, n / side);
            if k < 2 * first {
                let (row, column) = ((k - first) / side, (k - first) % side);
                (column * block..(column + 1) * block, row * block..(row + 1) * block, Some(true))
            } else {
                let (row, column) = ((k - 2 * first) / side, (k - 2 * first) % side);
                let half = block / 2;
                (column * block..(column + 1) * block, row * half..(row + 1) * half, Some(false))
            }
        }
    };
    let (middle_row, middle_column) = ((rows.start + rows.end) / 2, (columns.start + columns.end) / 2);
    let norm = ((rows.len() * columns.len()) as f64).sqrt();
    let mut sum = 0.0;
    for row in rows {
        for column in columns.clone() {
            let negative = match split_rows {
                None => false,
                Some(true) => row >= middle_row,
                Some(false) => column >= middle_column,
            };
            sum += if negative { -sample(row, column) } else { sample(row, column) };
        }
    }
    sum / norm
}

/// Largest absolute difference between the table's coefficients in f32 and those of the source in f64.
fn largest_coefficient_error(model: &dyn Source, reference_bias: f64) -> f64 {
    let grid = tangent_pole(3);
    let n = grid.n();
    let (table, _) = resample(model, grid);
    let encoding = LogEncoding::of(&table, DEFAULT_BIAS);
    let coefficients = haar::transform(&log_encode(&table, encoding));

    let centre = |cell: usize| cell_centre(cell % n, cell / n, n);
    let f = |outer: usize, inner: usize| value(model, DirectionPair::new(centre(outer), centre(inner)))[0];
    let all: Vec<f64> = (0..64).flat_map(|outer| (0..64).map(move |inner| f(outer, inner))).collect();
    let mean = all.iter().sum::<f64>() / all.len() as f64;
    let mut largest: f64 = 0.0;
    for (row, outer) in coefficients.fold.rows().iter().enumerate() {
        let image = |r: usize, c: usize| (all[*outer as usize * 64 + r * n + c] / mean + reference_bias).ln();
        for (k, found) in coefficients.row(0, row).iter().enumerate() {
            largest = largest.max((f64::from(*found) - coefficient(k, n, image)).abs());
        }
    }
    largest
}

#[test]
fn single_precision_costs_less_than_a_step_of_16_bits() {
    // Logarithms are within ±6, and a scaling coefficient is up to 8 of them: 48 · 2^-24 per rounding, a few roundings.
    for address in ["synth:lewis", "synth:ward", "synth:poulin", "synth:ggx?alpha=0.1"] {
        let found = largest_coefficient_error(source(address).as_ref(), DEFAULT_BIAS);
        println!("{address}: {found:e}");
        assert!(found < 1.5e-5, "{address}: {found:e}");
    }
    let wrong = largest_coefficient_error(source("synth:lewis").as_ref(), DEFAULT_BIAS * 1.01);
    assert!(wrong > 1e-4, "{wrong:e}");
}

#[test]
fn the_transform_divides_by_the_square_root_of_two() {
    let mut coefficients = [0.0; 4];
    haar::forward(&[1.0, 0.0, 0.0, 0.0], 2, &mut coefficients, &mut Vec::new());
    for (found, expected) in coefficients.into_iter().zip([0.5, 0.5, FRAC_1_SQRT_2, 0.0]) {
        assert!((found - expected).abs() < 1e-15, "{coefficients:?}");
    }
}

#[test]
fn scaled_details_are_noticed() {
    let model = source("synth:lewis");
    let pack = encoded(model.as_ref(), tangent_pole(4), |r| (r.target, r.bits) = (Target::Ratio(1.0), 16)).pack;
    let (table, _) = resample(model.as_ref(), tangent_pole(4));
    let error = |pack: &WaveletPack| {
        grid_error(&table, &WaveletDecoder::new(pack), brdfc_formats::crop::DirectionRange::ALL).norms.relative_mean
    };
    let mut scaled = pack.clone();
    for slice in &mut scaled.scales[2..] {
        (slice.scale, slice.offset) = (slice.scale * std::f32::consts::SQRT_2, slice.offset * std::f32::consts::SQRT_2);
    }
    let (right, wrong) = (error(&pack), error(&scaled));
    assert!(right < 1e-4 && wrong > 0.05, "{right} {wrong}");
}

/// Reflected light of a pack under light from `incoming`, over cells of the grid.
fn cell_albedo(decoder: &WaveletDecoder, incoming: Vector, level: f32) -> f64 {
    let n = decoder.header().grid();
    let angle = |k: usize| -> f64 { PI * k as f64 / n as f64 };
    let of_row =
        |r: usize| 0.5 * (angle(r + 1) - angle(r)) - 0.25 * ((2.0 * angle(r + 1)).sin() - (2.0 * angle(r)).sin());
    let of_cell = |cell: usize| {
        let (column, row) = (cell % n, cell / n);
        let weight = (angle(column).cos() - angle(column + 1).cos()) * of_row(row);
        let pair = DirectionPair::new(incoming, cell_centre(column, row, n));
        weight * f64::from(decoder.eval(pair, level, Filter::Slices)[1])
    };
    (0..n * n).map(of_cell).sum()
}

/// White furnace at every level of detail: an energy-preserving pack reflects as much as all of its details, between levels
/// at most that. With few slices this holds for the levels whose coefficients are all stored. A plain pack gets darker.
#[test]
fn energy_preserving_levels_have_the_same_albedo() {
    for address in ["synth:lambert?kd=1", "synth:ggx?kd=0.05&f0=0.9&alpha=0.15", "synth:ward?ax=0.15&ay=0.5"] {
        let packed = |is_preserving: bool, ratio: f64| {
            let set =
                |r: &mut Recipe| (r.energy_preserving, r.bits, r.target) = (is_preserving, 16, Target::Ratio(ratio));
            WaveletDecoder::new(&encoded(source(address).as_ref(), tangent_pole(4), set).pack)
        };
        let (whole, preserving, plain) = (packed(true, 1.0), packed(true, 16.0), packed(false, 1.0));
        let mut lost: f64 = 0.0;
        for incoming in [cell_centre(7, 8, 16), cell_centre(4, 6, 16), cell_centre(12, 12, 16)] {
            let expected = cell_albedo(&whole, incoming, 4.0);
            let share = |decoder: &WaveletDecoder, level: f32| cell_albedo(decoder, incoming, level) / expected;
            for level in [0.0, 1.0, 2.0, 3.0] {
                let found = share(&whole, level);
                assert!((found - 1.0).abs() < 2e-3, "{address}, level {level}: {found}");
                lost = lost.max(1.0 - share(&plain, level));
            }
            for level in [0.0, 1.0, 2.0] {
                let found = share(&preserving, level);
                assert!((found - 1.0).abs() < 2e-3, "{address}, few slices, level {level}: {found}");
            }
            for level in [0.4, 1.5, 2.7, 3.5] {
                let found = share(&whole, level);
                assert!(found < 1.002 && found > 0.5, "{address}, level {level}: {found}");
            }
            assert!(!address.contains("lambert") || (expected - 1.0).abs() < 2e-3, "{expected}");
        }
        // Between incoming cells logarithms are filtered, which must not add light.
        let neighbours = [(7, 8), (8, 8), (7, 9), (8, 9)].map(|(column, row)| cell_centre(column, row, 16));
        let most = neighbours.map(|incoming| cell_albedo(&whole, incoming, 4.0)).into_iter().fold(0.0, f64::max);
        let middle = from_tangent_pole([PI * 8.0 / 16.0, PI * 9.0 / 16.0]);
        for level in [0.0, 1.6, 4.0] {
            let found = cell_albedo(&whole, middle, level);
            assert!(found < 1.002 * most, "{address}, level {level}: {found} between cells of {most}");
        }
        assert!(address.contains("lambert") || lost > 0.1, "{address}: {lost}");
    }
}
