//! Azimuths of incidence. The material of a scan with a single azimuth is taken as isotropic. Few rows with other
//! azimuths do not make a scan anisotropic: it would be fitted over one more angle, without data along it.

use brdfc_readers::scan::Row;
use std::f64::consts::TAU;

/// Azimuths closer than this are equal, radians: 0.3 degrees, more than goniometers are off or files are rounded. Also the polar angle
/// below which the azimuth is undefined.
const SAME_AZIMUTH: f64 = 5e-3;
/// Largest share of rows with an azimuth that may differ from the common one; a single row always may.
const STRAY_SHARE: f64 = 0.05;

/// Azimuths of incidence of a scan.
#[derive(Debug, Clone, PartialEq)]
pub enum Incidence {
    /// A single azimuth, with the indices of the rows that differ from it.
    One(Vec<usize>),
    /// A large share of the rows has other azimuths.
    Several,
}

impl Incidence {
    /// Classifies all rows. There is no azimuth at normal incidence.
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

/// The most common azimuth of a sorted circle.
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
            // A goniometer that is off by less than a third of a degree.
            (&[(40, -2e-3), (40, 0.0), (40, 2e-3)], Some(0)),
            (&[(40, -2e-2), (40, 0.0), (40, 2e-2)], None),
            // The circle is continuous where the angle wraps.
            (&[(40, TAU - 4e-5), (40, 4e-5), (40, -3e-5), (1, 1.0)], Some(1)),
        ] {
            assert_eq!(strays(azimuths), expected, "{azimuths:?}");
        }
        assert_eq!(Incidence::of(&rows(&[(1, 0.2), (30, 0.0), (1, 0.4)])), Incidence::Several);
        assert_eq!(Incidence::of(&rows(&[(1, 0.2), (40, 0.0), (1, 0.4)])), Incidence::One(vec![0, 41]));
    }

    #[test]
    fn scans_with_several_azimuths_stay_so() {
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
        // They do not change the share of the other rows.
        scan.extend(rows(&[(3, 1.0)]));
        assert_eq!(Incidence::of(&scan), Incidence::Several);
    }
}
