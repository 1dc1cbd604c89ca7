//! Scans of anisotropic materials with rows at the mirror direction, where half and difference angles have a pole.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_readers::scan::{Row, Scan};
use brdfc_source::ScanSource;
use std::f64::consts::{PI, TAU};

/// A highlight whose height depends on the azimuth of the light, over a diffuse part.
fn truth(theta_i: f64, phi_i: f64, theta_o: f64, phi_o: f64) -> f64 {
    let pair = DirectionPair::from_angles(theta_i, phi_i, theta_o, phi_o);
    let half = [0, 1, 2].map(|axis| pair.incoming[axis] + pair.outgoing[axis]);
    let off = half[0].hypot(half[1]).atan2(half[2]);
    0.1 + (2.0 + (2.0 * phi_i).cos()) / (1.0 + (off / 0.15).powi(2)).powi(2)
}

/// Rows over 8 polar angles and `azimuths` azimuths of the light: at the mirror direction, and around it.
fn rows(azimuths: usize) -> Vec<Row> {
    let mut rows = Vec::new();
    for (theta_i, phi_i) in (1..9).flat_map(|i| (0..azimuths).map(move |a| (i, a))) {
        let (theta_i, phi_i) = (0.17 * theta_i as f64, TAU * phi_i as f64 / azimuths as f64);
        let mut add = |theta_o: f64, turned: f64| {
            let phi_o = phi_i + PI + turned;
            let value = [truth(theta_i, phi_i, theta_o, phi_o); 3];
            rows.push(Row { theta_i, phi_i, theta_o, phi_o: phi_o % TAU, value });
        };
        add(theta_i, 0.0);
        for theta_o in (0..8).map(|o| 0.1 + 0.2 * f64::from(o)) {
            (0..6).for_each(|turn| add(theta_o, 0.05 + TAU * f64::from(turn) / 6.0));
        }
    }
    rows
}

fn completed(rows: Vec<Row>) -> ScanSource {
    ScanSource::new(&Scan { rows, ..Scan::default() }).expect("a scan")
}

/// Mean relative error at mirror directions of lights at this azimuth from the measured ones, in units of their step.
fn mirror_error(source: &ScanSource, azimuths: usize, offset: f64) -> f64 {
    let mut sum = 0.0;
    for (theta_i, phi_i) in (1..9).flat_map(|i| (0..azimuths).map(move |a| (i, a))) {
        let (theta_i, phi_i) = (0.17 * theta_i as f64, TAU * (phi_i as f64 + offset) / azimuths as f64);
        let pair = DirectionPair::from_angles(theta_i, phi_i, theta_i, phi_i + PI);
        let expected = truth(theta_i, phi_i, theta_i, phi_i + PI);
        sum += (source.eval(pair, &mut Tally::default())[0] - expected).abs() / expected;
    }
    sum / (8 * azimuths) as f64
}

#[test]
fn rows_at_the_mirror_direction_keep_their_azimuth() {
    let all = rows(16);
    let source = completed(all.clone());
    let summary = source.summary();
    assert!(!summary.isotropic);
    assert_eq!((summary.distinct, summary.largest_disagreement), (all.len(), 0.0));
    // Without the azimuth the error is that of the mean, a third.
    let [at_rows, between] = [0.0, 0.5].map(|offset| mirror_error(&source, 16, offset));
    println!("at rows {at_rows:.4}, between {between:.4}");
    assert!(at_rows < 0.1 && between < 0.1, "{at_rows} {between}");
}

#[test]
fn eight_mirror_rows_of_eight_azimuths_are_distinct() {
    let row = |azimuth: u32| {
        let phi_i = TAU * f64::from(azimuth) / 16.0;
        Row { theta_i: 1.4, phi_i, theta_o: 1.4, phi_o: phi_i + PI, value: [1.0 + f64::from(azimuth); 3] }
    };
    let source = completed((0..8).map(row).collect());
    assert_eq!(source.summary().distinct, 8);
    assert_eq!(source.summary().largest_disagreement, 0.0);
    // Rows of one azimuth are isotropic, and so are their repetitions.
    let rotated = |azimuth: u32| Row { phi_i: 0.0, phi_o: PI, ..row(azimuth) };
    let refused = ScanSource::new(&Scan { rows: (0..8).map(rotated).collect(), ..Scan::default() });
    assert!(refused.expect_err("one pair").to_string().contains("1 distinct direction pair in 8 rows"));
}

/// Repeated anisotropic rows are still one pair, at the mirror direction and elsewhere.
#[test]
fn repeated_rows_are_one_pair() {
    let all = rows(16);
    let repeats = all.iter().step_by(7).map(|row| Row { value: row.value.map(|v| 1.5 * v), ..*row });
    let source = completed(all.iter().copied().chain(repeats).collect());
    let summary = source.summary();
    assert_eq!(summary.distinct, all.len());
    assert!((summary.largest_disagreement - 1.0 / 3.0).abs() < 1e-9, "{summary:?}");
    assert_eq!(source.symmetry(), Symmetry { isotropic: false, mirror: false, reciprocal: false });
}
