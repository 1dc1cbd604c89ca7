//! Rows of a scan whose azimuth of incidence differs from that of the others are reported and measured; their azimuth
//! is ignored.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::scan::{Row, Scan};
use brdfc_readers::scan_csv;
use brdfc_source::ScanSource;
use brdfc_source::simulate::{ScanPlan, scan};

const PAINT: &str = "synth:ggx?kd=0.2,0.1,0.1&alpha=0.4";
const BRUSHED: &str = "synth:ward?kd=0.01&ks=0.4&ax=0.1&ay=0.6";

fn simulated(model: &str, rows: usize, azimuths: usize) -> Vec<Row> {
    let model = brdfc_source::open::open(model, None).unwrap().source;
    let plan =
        ScanPlan { rows, incidences: 5, azimuths: Some(azimuths), noise: 0.0, gaps: 0.0, duplicates: 0.0, seed: 5 };
    scan(model.as_ref(), &plan)
}

/// The same measurement with a rotated sample.
fn turned(row: Row, by: f64) -> Row {
    Row { phi_i: row.phi_i + by, phi_o: row.phi_o + by, ..row }
}

fn source(rows: Vec<Row>) -> ScanSource {
    ScanSource::new(&Scan { rows, ..Scan::default() }).unwrap()
}

#[test]
fn a_few_rows_do_not_make_a_scan_anisotropic() {
    let mut rows = simulated(PAINT, 76, 1);
    let whole = source(rows.clone());
    assert_eq!(whole.summary().strays, None);
    for row in [30, 50] {
        rows[row] = turned(rows[row], 12.5f64.to_radians());
    }
    let found = source(rows.clone());
    let strays = found.summary().strays.unwrap();
    assert!(found.summary().isotropic && found.symmetry().isotropic && found.symmetry().mirror);
    assert_eq!((strays.rows, strays.of, strays.line, strays.azimuth.round()), (2, 76, None, 13.0));
    // They are of the same material, so that rotating them back recovers their values.
    assert!(strays.difference < 0.1, "{strays:?}");
    for (theta_i, theta_o, phi_o) in [(0.3, 0.4, 3.0), (0.8, 1.1, 2.0), (1.2, 0.2, 0.5)] {
        let at = |source: &ScanSource| {
            source.eval(DirectionPair::from_angles(theta_i, 0.0, theta_o, phi_o), &mut Tally::default())[0]
        };
        let (value, expected) = (at(&found), at(&whole));
        assert!((value - expected).abs() < 1e-9 * expected, "{value} {expected}");
    }
    // Rows of another material have a large difference.
    for row in [30, 50] {
        rows[row].value = rows[row].value.map(|v| 5.0 * v);
    }
    let other = source(rows).summary().strays.unwrap().difference;
    assert!((0.75..0.85).contains(&other), "{other}");
}

#[test]
fn anisotropic_scans_stay_so() {
    let two: Vec<Row> = simulated(BRUSHED, 40, 8).into_iter().filter(|row| row.phi_i < 1.0).collect();
    assert_eq!(two.len(), 10);
    // A tenth of the rows makes a scan anisotropic.
    let mut tenth = simulated(PAINT, 80, 1);
    tenth.iter_mut().take(8).for_each(|row| *row = turned(*row, 1.0));
    for rows in [two, simulated(BRUSHED, 16, 8), simulated(BRUSHED, 400, 8), simulated(BRUSHED, 60, 2), tenth] {
        let found = source(rows);
        assert!(!found.summary().isotropic && !found.symmetry().isotropic, "{:?}", found.summary());
        assert_eq!(found.summary().strays, None);
    }
}

/// Cost of a wrong decision: a scan of brushed metal that is taken as isotropic is another material.
#[test]
fn strays_from_brushed_metal_differ() {
    let mut rows = simulated(BRUSHED, 100, 1);
    let across = simulated(BRUSHED, 400, 4).into_iter().filter(|row| row.phi_i > 1.0 && row.phi_i < 2.0);
    rows.extend(across.take(4));
    let strays = source(rows).summary().strays.unwrap();
    assert!(strays.rows == 4 && strays.difference > 0.2, "{strays:?}");
}

#[test]
fn the_first_line_is_reported() {
    let mut rows = simulated(PAINT, 77, 1);
    rows[29] = turned(rows[29], 12.5f64.to_radians());
    rows[40] = turned(rows[40], 1.0);
    let mut bytes = Vec::new();
    scan_csv::write(&mut bytes, &rows).unwrap();
    let strays = ScanSource::new(&scan_csv::from_bytes(&bytes).unwrap()).unwrap().summary().strays.unwrap();
    let words = strays.summary();
    let expected = "2 of 77 rows have another azimuth of incidence (the first on line 31, 12.5°); the material is \
                    taken as isotropic, although these rows differ from the others by ";
    assert!(words.starts_with(expected) && words.ends_with(" %"), "{words}");
}
