//! Azimuths of incidence: a scan of one is of a material that is taken as isotropic. Few rows that stray from it do not
//! make a measurement of another: they would have the scan fitted over one angle more, with nothing to fit it to.

use brdfc_readers::scan::Row;
use std::f64::consts::TAU;

/// Azimuths closer than this are one, radians. It is also the polar angle below which there is none.
const SAME_AZIMUTH: f64 = 1e-4;
/// Largest share of rows with an azimuth that may stray from the common one; one row always may.
const STRAY_SHARE: f64 = 0.05;

/// What the azimuths of incidence of a scan say.
#[derive(Debug, Clone, PartialEq)]
pub enum Incidence {
    /// There is one, or there are several and rows that stray from it, whose numbers these are.
    One(Vec<usize>),
    /// A considerable part of the rows has others.
    Several,
}

impl Incidence {
    /// Looks at all rows. At normal incidence there is no azimuth.
    pub fn of(rows: &[Row]) -> Self {
        let mut azimuths: Vec<f64> =
            rows.iter().filter(|row| has_azimuth(row)).map(|row| row.phi_i.rem_euclid(TAU)).collect();
        azimuths.sort_unstable_by(f64::total_cmp);
        let Some(common) = most_common(&azimuths) else { return Self::One(Vec::new()) };
        let strays: Vec<usize> =
            (0..rows.len()).filter(|row| has_azimuth(&rows[*row]) && !same(rows[*row].phi_i, common)).collect();
        let most = (STRAY_SHARE * azimuths.len() as f64).max(1.0);
        if strays.len() as f64 <= most { Self::One(strays) } else { Self::Several }
    }
}

fn has_azimuth(row: &Row) -> bool {
    row.theta_i >= SAME_AZIMUTH
}

fn same(a: f64, b: f64) -> bool {
    let turns = (a - b) / TAU;
    (turns - turns.round()).abs() * TAU < SAME_AZIMUTH
}

/// The azimuth that most are the same as, of a sorted circle.
fn most_common(azimuths: &[f64]) -> Option<f64> {
    let count = azimuths.len();
    let turned = |k: usize| azimuths[k % count] + if k < count { 0.0 } else { TAU };
    let (mut end, mut best, mut common) = (0, 0, None);
    for (start, first) in azimuths.iter().enumerate() {
        while end < start + count && turned(end) - first < SAME_AZIMUTH {
            end += 1;
        }
        if end - start > best {
            (best, common) = (end - start, Some(azimuths[(start + (end - start) / 2) % count]));
        }
    }
    common
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(azimuths: &[(usize, f64)]) -> Vec<Row> {
        let row = |phi_i| Row { theta_i: 0.5, phi_i, theta_o: 0.3, phi_o: 1.0, value: [1.0; 3] };
        azimuths.iter().flat_map(|(count, phi_i)| vec![row(*phi_i); *count]).collect()
    }

    fn strays(azimuths: &[(usize, f64)]) -> Option<usize> {
        match Incidence::of(&rows(azimuths)) {
            Incidence::One(strays) => Some(strays.len()),
            Incidence::Several => None,
        }
    }

    #[test]
    fn few_rows_stray() {
        for (azimuths, expected) in [
            (&[][..], Some(0)),
            (&[(40, 0.3)], Some(0)),
            (&[(74, 0.0), (1, 0.2)], Some(1)),
            (&[(75, 0.0), (1, 0.2), (1, 3.0)], Some(2)),
            (&[(7, 0.0), (1, 0.2)], Some(1)),
            (&[(95, 0.0), (5, 0.2)], Some(5)),
            // Where it is cut open a circle is whole.
            (&[(40, TAU - 4e-5), (40, 4e-5), (40, -3e-5), (1, 1.0)], Some(1)),
        ] {
            assert_eq!(strays(azimuths), expected, "{azimuths:?}");
        }
        assert_eq!(Incidence::of(&rows(&[(1, 0.2), (30, 0.0), (1, 0.4)])), Incidence::Several);
        assert_eq!(Incidence::of(&rows(&[(1, 0.2), (40, 0.0), (1, 0.4)])), Incidence::One(vec![0, 41]));
    }

    #[test]
    fn what_is_measured_at_several_stays_so() {
        let ring: Vec<(usize, f64)> = (0..8).map(|k| (2, 0.7 * f64::from(k))).collect();
        let singles: Vec<(usize, f64)> = (0..8).map(|k| (1, 0.7 * f64::from(k))).collect();
        for azimuths in [&[(6, 0.0), (6, 1.5)][..], &[(94, 0.0), (6, 1.5)], &[(6, 0.0), (2, 1.5)], &ring, &singles] {
            assert_eq!(strays(azimuths), None, "{azimuths:?}");
        }
    }

    #[test]
    fn normal_incidence_has_no_azimuth() {
        let mut scan = rows(&[(30, 0.0), (30, 0.5)]);
        scan[30..].iter_mut().for_each(|row| row.theta_i = 0.0);
        assert_eq!(Incidence::of(&scan), Incidence::One(Vec::new()));
        // They do not make the others a small part.
        scan.extend(rows(&[(3, 1.0)]));
        assert_eq!(Incidence::of(&scan), Incidence::Several);
    }
}
