use super::row::{Measure, StressRow, StressStudy, Worst};
use super::run::stress;
use super::stages::Stages;
use super::{decode, directions, logarithms, neighbourhoods, pack, propagation, tables, texels, transforms};
use brdfc_formats::bandwidth::propagation::Bandwidth;

/// Rows of one kind of stage, and a change that breaks a stage of that kind.
type Broken = (fn(&Stages, bool) -> Vec<StressRow>, &'static str, fn(&mut Stages));

#[test]
fn every_bound_holds() {
    let small = std::env::var_os("BRDFC_ENGINES").is_none();
    if small {
        println!("skipped: grids of 32 and 64 and most cases: half a minute, with BRDFC_ENGINES set");
    }
    let study = stress(&Stages::default(), small);
    for row in &study.rows {
        println!("{}: {}: {:.2e} {:?} of {:.2e}: {}", row.stage, row.fed, row.error, row.measure, row.bound, row.why);
    }
    let broken: Vec<&StressRow> = study.broken().collect();
    assert!(study.rows.len() > 40 && broken.is_empty(), "{broken:#?}");
    assert!(study.rows.iter().all(|row| row.error.is_finite() && row.cases > 0 && !row.why.is_empty()));
}

#[test]
fn a_bound_that_is_too_tight_is_broken() {
    let row = |error: f64, bound: f64| {
        let mut worst = Worst::default();
        worst.add(error);
        worst.row(["stage", "fed"], Measure::Relative, bound, "why")
    };
    assert!(row(-1e-7, 1e-7).holds);
    for (error, bound) in [(1.1e-7, 1e-7), (f64::NAN, 1e300), (f64::INFINITY, 1e300)] {
        let row = row(error, bound);
        assert!(!row.holds && row.error.is_finite(), "{row:?}");
        assert_eq!(StressStudy { rows: vec![row] }.broken().count(), 1);
    }
    assert!(!Worst::default().row(["stage", "fed"], Measure::Count, 0.0, "why").holds, "nothing was compared");
    // For every row that is not exact: a bound below the observed error.
    let study = stress(&Stages::default(), true);
    let tightened = study.rows.into_iter().filter(|row| row.error > 0.0).map(holds_below);
    assert!(tightened.clone().count() > 20);
    tightened.for_each(|holds| assert!(!holds));
}

fn holds_below(row: StressRow) -> bool {
    let mut worst = Worst::default();
    worst.add(row.error);
    worst.row([&row.stage, &row.fed], row.measure, 0.99 * row.error, &row.why).holds
}

/// Negative control: each stage is deliberately broken, some only by a few roundings, and its row must detect it.
#[test]
fn broken_stages_are_detected() {
    let cases: [Broken; 26] = [
        (directions::rows, "tangent-pole grid, f64", |s| {
            s.to_tangent_pole = |d| [f64::from(d[2].atan2(d[0]) as f32), d[1].acos()];
        }),
        (directions::rows, "half and difference vectors, f64", |s| {
            s.to_half_difference = |pair| {
                let (h, d) = (Stages::default().to_half_difference)(pair);
                (h, d.map(|c| f64::from(c as f32)))
            };
        }),
        (directions::rows, "angles of decoders, f32", |s| s.atan2 = |y, x| y.atan2(x) * 1.000_000_5),
        (directions::rows, "angles of tables, f32", |s| {
            s.angles = |pair| {
                let mut angles = (Stages::default().angles)(pair);
                angles.ratio *= 1.0 + 1e-5;
                angles
            };
        }),
        (logarithms::rows, "ln, f32", |s| s.ln = |y| y.ln() * (1.0 + 1e-6)),
        (logarithms::rows, "exp, f32", |s| s.exp = |x| (x * (1.0 + 1e-7)).exp()),
        (logarithms::rows, "rise of energy-preserving packs, f32", |s| s.rise = |h, _| h.cosh().ln()),
        (logarithms::rows, "log encoding, f32", |s| {
            s.log_encode = |table, encoding| {
                let mut encoded = table.clone();
                // Without the bias denormals and zeros have no logarithm.
                encoded.values.iter_mut().for_each(|v| *v = (f64::from(*v) / encoding.mean).ln() as f32);
                encoded
            };
        }),
        (logarithms::rows, "log decoding, f32", |s| {
            s.from_log = |decoder, v| decoder.header().mean * (v.exp() - decoder.header().bias)
        }),
        (transforms::rows, "Haar, f32", |s| {
            s.haar = |samples, n, lift| {
                (Stages::default().haar)(samples, n, lift).iter().map(|c| c * (1.0 + 1e-5)).collect()
            };
        }),
        (transforms::rows, "Haar and back, f32", |s| {
            s.haar_inverse =
                |c, n, lift| (Stages::default().haar_inverse)(c, n, lift).iter().map(|c| c + 1e-3).collect();
        }),
        (transforms::rows, "energy-preserving Haar, f32", |s| {
            s.haar = |samples, n, _| (Stages::default().haar)(samples, n, None)
        }),
        (transforms::rows, "energy-preserving Haar and back, f32", |s| {
            s.haar_inverse = |c, n, _| (Stages::default().haar_inverse)(c, n, None)
        }),
        (transforms::rows, "Daubechies and back, f32", |s| {
            s.daubechies = |image, _| image.iter().rev().copied().collect()
        }),
        (transforms::rows, "smoothing, f32", |s| {
            s.smooth = |table| {
                let mut smoothed = (Stages::default().smooth)(table);
                smoothed.values.iter_mut().for_each(|v| *v *= 1.0 + 1e-5);
                smoothed
            };
        }),
        (texels::rows, "threshold", |s| {
            // Ties by number from the end.
            s.threshold = |energies, _, count| {
                let mut ranked: Vec<u32> = (1..energies.len() as u32).rev().collect();
                ranked.sort_by(|a, b| energies[*b as usize].total_cmp(&energies[*a as usize]));
                ranked.insert(0, 0);
                let mut selected = ranked[..count.clamp(1, ranked.len())].to_vec();
                selected.sort_unstable();
                selected
            };
        }),
        (texels::rows, "rounding to texels", |s| {
            s.quantise = |table, selected, header| {
                let mut quantised = (Stages::default().quantise)(table, selected, header);
                quantised.texels.iter_mut().for_each(|byte| *byte = byte.saturating_add(1));
                quantised
            };
        }),
        (pack::rows, "packs written and read", |s| {
            // Indices of a single byte.
            s.read = |bytes| {
                let mut pack = (Stages::default().read)(bytes)?;
                pack.index.iter_mut().for_each(|slice| *slice &= 255);
                Ok(pack)
            };
        }),
        (pack::rows, "limit of slices", |s| {
            s.read = |_| Ok(pack::pack(2, 1, 8, false, 1));
            s.write = |_| Vec::new();
        }),
        (decode::rows, "decoding wavelets, f32", |s| {
            s.decode = |decoder, pair, level| (Stages::default().decode)(decoder, pair, level.floor());
        }),
        (tables::rows, "decoding tables, f32", |s| {
            s.decode_table = |decoder, pair| (Stages::default().decode_table)(decoder, pair).map(|v| v * (1.0 + 1e-4));
        }),
        (tables::rows, "fitting tables, f32", |s| s.solve = |equations, x| equations.solve(x, 1)),
        (tables::rows, "rounding tables", |s| {
            s.table_pack = |prepared, recipe| {
                // The nodes of another fit.
                let other = brdfc_table::recipe::TableRecipe { factored: true, ..recipe.clone() };
                (Stages::default().table_pack)(prepared, &other)
            };
        }),
        (neighbourhoods::rows, "moving least squares, f64", |s| {
            s.local_fit = |basis, weights, residuals| {
                let rounded: Vec<f64> = weights.iter().map(|w| f64::from(*w as f32)).collect();
                (Stages::default().local_fit)(basis, &rounded, residuals).map(|v| v * (1.0 + 1e-5))
            };
        }),
        (propagation::rows, "bandwidth over a reflection, f32", |s| {
            // A flight forgotten.
            s.one_bounce = |from: Bandwidth, light, surface, _| from.one_bounce(light, surface, 0.0);
        }),
        (propagation::rows, "level of the pyramid", |s| {
            s.pyramid_level = |bandwidth, coarsest| ((-(2.0 * bandwidth).log2()).floor() as i32).min(coarsest);
        }),
    ];
    for (rows, stage, break_it) in cases {
        let mut stages = Stages::default();
        break_it(&mut stages);
        let detected = rows(&stages, true).into_iter().any(|row| row.stage == stage && !row.holds);
        assert!(detected, "{stage}: broken, but not detected");
    }
}
