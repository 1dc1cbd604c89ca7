//! RGL materials against values of Mitsuba 3.9.1 `measured` for the same files.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::rgl::Rgl;
use brdfc_source::rgl::RglSource;

const MATERIALS: [&str; 4] =
    ["cc_ibiza_sunset_rgb", "colodur_napoli_4f_rgb", "paper_white_rgb", "vch_golden_yellow_rgb"];
const RELATIVE: f64 = 1e-3;
const ABSOLUTE: f64 = 1e-5;
const AGREEMENT: f64 = 0.999;

fn rgb_only(_: &[f64]) -> Result<Vec<[f64; 3]>, brdfc_formats::FormatError> {
    panic!("an RGB file needs no weights");
}

fn load(name: &str) -> Option<(Rgl, Vec<[f64; 9]>)> {
    let file = brdfc_testing::shared_data(&format!("rgl/{name}.bsdf"))?;
    let oracle = brdfc_testing::shared_data(&format!("oracles/oracle_{name}.csv"))?;
    let rgl = Rgl::from_bytes(&std::fs::read(file).unwrap()).unwrap();
    let rows = csv::Reader::from_path(oracle).unwrap().into_deserialize().collect::<Result<_, _>>().unwrap();
    Some((rgl, rows))
}

/// Share of the rows in which all three channels agree.
fn agreement(rgl: Rgl, rows: &[[f64; 9]]) -> f64 {
    let source = RglSource::new(rgl, rgb_only).unwrap();
    let agrees = |row: &&[f64; 9]| {
        let pair = DirectionPair::new([row[0], row[1], row[2]], [row[3], row[4], row[5]]);
        let value = source.eval(pair, &mut Tally::default());
        (0..3).all(|k| (value[k] - row[6 + k]).abs() <= (RELATIVE * row[6 + k].abs()).max(ABSOLUTE))
    };
    rows.iter().filter(agrees).count() as f64 / rows.len() as f64
}

#[test]
fn values_agree_with_the_oracle() {
    for name in MATERIALS {
        let Some((rgl, rows)) = load(name) else { return };
        assert_eq!(rows.len(), 4000);
        let share = agreement(rgl, &rows);
        println!("{name}: {:.2} % of {} rows agree", 100.0 * share, rows.len());
        assert!(share >= AGREEMENT, "{name}: {share}");
    }
}

#[test]
fn one_broken_factor_breaks_the_agreement() {
    for name in MATERIALS {
        let Some((rgl, rows)) = load(name) else { return };
        let without_jacobian = Rgl { jacobian: false, ..rgl.clone() };
        let flat = Rgl { vndf: vec![1.0; rgl.vndf.len()], ..rgl.clone() };
        let exchanged: Vec<_> = rows.iter().map(|&[a, b, c, d, e, f, r, g, bl]| [d, e, f, a, b, c, r, g, bl]).collect();
        for (what, share) in [
            ("no jacobian", agreement(without_jacobian, &rows)),
            ("no warp", agreement(flat, &rows)),
            ("directions exchanged", agreement(rgl, &exchanged)),
        ] {
            println!("{name}, {what}: {:.2} %", 100.0 * share);
            assert!(share < 0.5, "{name}, {what}: {share}");
        }
    }
}

#[test]
fn isotropic_files_are_isotropic_and_coloured() {
    for name in MATERIALS {
        let Some((rgl, rows)) = load(name) else { return };
        let source = RglSource::new(rgl, rgb_only).unwrap();
        assert!(source.symmetry().isotropic && !source.symmetry().reciprocal && !source.is_grey());
        let (sin, cos) = 1.234f64.sin_cos();
        let turn = |x: f64, y: f64, z: f64| [x * cos - y * sin, x * sin + y * cos, z];
        let mut tally = Tally::default();
        for row in rows.iter().step_by(40) {
            let pair = DirectionPair::new([row[0], row[1], row[2]], [row[3], row[4], row[5]]);
            let turned = DirectionPair::new(turn(row[0], row[1], row[2]), turn(row[3], row[4], row[5]));
            let (a, b) = (source.eval(pair, &mut tally), source.eval(turned, &mut tally));
            assert!((0..3).all(|k| (a[k] - b[k]).abs() <= 1e-9 * a[k].abs().max(1.0)), "{name}: {a:?} {b:?}");
        }
        assert_eq!(tally, Tally { evaluations: 200, ..Tally::default() });
    }
}
