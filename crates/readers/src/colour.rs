//! Conversion of spectra to linear RGB.
//!
//! A reflectance spectrum `s(λ)` under equal energy light has the tristimulus values `X = ∫ s x̄ dλ / ∫ x̄ dλ` (and
//! likewise Y, Z) of the CIE 1931 2-degree observer. The white of equal energy light, `(1, 1, 1)`, is adapted to D65,
//! the white of Rec. 709, by the linear Bradford transform, so that a flat spectrum is grey. Everything is linear in
//! `s`: one weight per wavelength and channel, which [`rgb_weights`] computes.

use brdfc_formats::FormatError;

/// Lowest and highest wavelength that [`rgb_weights`] accepts, nm.
pub const WAVELENGTH_RANGE_NM: [f64; 2] = [100.0, 3000.0];

/// First and last wavelength of the tabulated observer, nm.
pub const VISIBLE_RANGE_NM: [f64; 2] = [380.0, 780.0];

const OBSERVER_STEP_NM: f64 = 5.0;

type Matrix = [[f64; 3]; 3];

/// Bradford's cone responses of XYZ (Lam 1985; also Lindbloom, "Chromatic adaptation").
const BRADFORD: Matrix = [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]];

/// Chromaticities x, y of the red, green and blue primaries (ITU-R BT.709, item 1.3).
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// Chromaticity x, y of the white D65 (ITU-R BT.709, item 1.4).
const WHITE: [f64; 2] = [0.3127, 0.3290];

/// Weights that convert a sampled spectrum to linear RGB (Rec. 709 primaries): channel `c` is `Σ_k s[k] weights[k][c]`.
///
/// `wavelengths_nm`: strictly increasing, in [`WAVELENGTH_RANGE_NM`], any spacing. The spectrum is linear between the
/// samples and constant outside them, and is integrated exactly against the observer, which is linear between its
/// tabulated points. Returns one `[r, g, b]` per wavelength; each channel sums to 1, so that a flat spectrum of value
/// `v` becomes `[v, v, v]` up to rounding, and a single wavelength is grey. Saturated spectra may have channels outside
/// `[0, 1]`: they are outside the gamut.
///
/// # Errors
///
/// Returns an error for no wavelength, wavelengths that are not finite, out of range or not increasing, and a sampled
/// range outside [`VISIBLE_RANGE_NM`].
pub fn rgb_weights(wavelengths_nm: &[f64]) -> Result<Vec<[f64; 3]>, FormatError> {
    check(wavelengths_nm)?;
    let mut xyz = vec![[0.0; 3]; wavelengths_nm.len()];
    for span in integration_points(wavelengths_nm).windows(2) {
        let (start, end) = (span[0], span[1]);
        let middle = 0.5 * (start + end);
        let hat = Hat::around(wavelengths_nm, middle);
        // Both factors are linear in the span: Simpson's rule is exact.
        for (at, simpson) in [(start, 1.0), (middle, 4.0), (end, 1.0)] {
            let observer = observer_at(at);
            for (k, share) in hat.shares(at) {
                for c in 0..3 {
                    xyz[k][c] += simpson / 6.0 * (end - start) * share * observer[c];
                }
            }
        }
    }
    scale_columns_to_one(&mut xyz);
    let to_rgb = xyz_equal_energy_to_rgb();
    let mut rgb: Vec<[f64; 3]> = xyz.iter().map(|&v| transform(&to_rgb, v)).collect();
    scale_columns_to_one(&mut rgb);
    Ok(rgb)
}

fn check(wavelengths_nm: &[f64]) -> Result<(), FormatError> {
    let [lowest, highest] = WAVELENGTH_RANGE_NM;
    let (Some(&first), Some(&last)) = (wavelengths_nm.first(), wavelengths_nm.last()) else {
        return Err(FormatError::whole("wavelengths", "no wavelengths", "at least one").problem());
    };
    for (k, &at) in wavelengths_nm.iter().enumerate() {
        if !(lowest..=highest).contains(&at) {
            let allowed = format!("{lowest} to {highest} nm");
            return Err(FormatError::whole(format!("wavelength {}", k + 1), format!("{at} nm"), allowed));
        }
        if k > 0 && at <= wavelengths_nm[k - 1] {
            let allowed = format!("more than the {} nm before", wavelengths_nm[k - 1]);
            return Err(FormatError::whole(format!("wavelength {}", k + 1), format!("{at} nm"), allowed));
        }
    }
    let [start, end] = VISIBLE_RANGE_NM;
    if last < start || first > end {
        let allowed = format!("an overlap with {start} to {end} nm");
        return Err(FormatError::whole("wavelengths", format!("{first} to {last} nm"), allowed));
    }
    Ok(())
}

/// Ends of the intervals in which spectrum and observer are both linear, increasing.
fn integration_points(wavelengths_nm: &[f64]) -> Vec<f64> {
    let [start, end] = VISIBLE_RANGE_NM;
    let mut points: Vec<f64> = (0..OBSERVER.len()).map(|k| start + OBSERVER_STEP_NM * k as f64).collect();
    points.extend(wavelengths_nm.iter().copied().filter(|w| (start..=end).contains(w)));
    points.sort_by(f64::total_cmp);
    points.dedup();
    points
}

/// Samples that determine the value at a wavelength.
enum Hat {
    /// Outside the sampled range: the end sample only.
    End(usize),
    /// Between sample `left`, at `from` nm, and the next, `width` nm on.
    Between { left: usize, from: f64, width: f64 },
}

impl Hat {
    fn around(wavelengths_nm: &[f64], at: f64) -> Self {
        let after = wavelengths_nm.partition_point(|&w| w <= at);
        if after == 0 {
            return Self::End(0);
        }
        let left = after - 1;
        if after == wavelengths_nm.len() {
            return Self::End(left);
        }
        Self::Between { left, from: wavelengths_nm[left], width: wavelengths_nm[after] - wavelengths_nm[left] }
    }

    fn shares(&self, at: f64) -> [(usize, f64); 2] {
        match *self {
            Self::End(k) => [(k, 1.0), (k, 0.0)],
            Self::Between { left, from, width } => {
                let t = (at - from) / width;
                [(left, 1.0 - t), (left + 1, t)]
            }
        }
    }
}

fn observer_at(wavelength_nm: f64) -> [f64; 3] {
    let position = (wavelength_nm - VISIBLE_RANGE_NM[0]) / OBSERVER_STEP_NM;
    let k = (position as usize).min(OBSERVER.len() - 2);
    let t = position - k as f64;
    std::array::from_fn(|c| OBSERVER[k][c] * (1.0 - t) + OBSERVER[k + 1][c] * t)
}

fn scale_columns_to_one(rows: &mut [[f64; 3]]) {
    for c in 0..3 {
        let sum: f64 = rows.iter().map(|row| row[c]).sum();
        for row in rows.iter_mut() {
            row[c] /= sum;
        }
    }
}

/// Converts XYZ relative to the white `(1, 1, 1)` to linear RGB: Bradford adaptation to D65, then the inverse of the
/// primaries' matrix (Lindbloom, "RGB/XYZ matrices").
fn xyz_equal_energy_to_rgb() -> Matrix {
    let white = xyz_of_chromaticity(WHITE);
    let cones_source = transform(&BRADFORD, [1.0; 3]);
    let cones_target = transform(&BRADFORD, white);
    let mut scaled = BRADFORD;
    for c in 0..3 {
        scaled[c] = scaled[c].map(|v| v * cones_target[c] / cones_source[c]);
    }
    let adaptation = multiply(&inverse(&BRADFORD), &scaled);

    let columns = PRIMARIES.map(xyz_of_chromaticity);
    let unscaled: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| columns[c][r]));
    let luminances = transform(&inverse(&unscaled), white);
    let rgb_to_xyz: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| unscaled[r][c] * luminances[c]));
    multiply(&inverse(&rgb_to_xyz), &adaptation)
}

fn xyz_of_chromaticity([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn transform(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|r| m[r][0] * v[0] + m[r][1] * v[1] + m[r][2] * v[2])
}

fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|k| a[r][k] * b[k][c]).sum()))
}

/// Inverse by cofactors; the matrices here are well conditioned.
fn inverse(m: &Matrix) -> Matrix {
    let minor = |r: usize, c: usize| {
        let ([r1, r2], [c1, c2]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant))
}

/// Colour matching functions x̄, ȳ, z̄ of the CIE 1931 2-degree standard observer, from 380 to 780 nm in steps of 5 nm
/// (CIE 15:2004; values as tabulated by the Python package `colour-science` 0.4.7, to 6 decimals).
const OBSERVER: [[f64; 3]; 81] = [
    [0.001368, 0.000039, 0.00645],
    [0.002236, 0.000064, 0.01055],
    [0.004243, 0.00012, 0.02005],
    [0.00765, 0.000217, 0.03621],
    [0.01431, 0.000396, 0.06785],
    [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074],
    [0.07763, 0.00218, 0.3713],
    [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.03905],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706],
    [0.34806, 0.0298, 1.7826],
    [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764],
    [0.1421, 0.1126, 1.0419],
    [0.09564, 0.13902, 0.81295],
    [0.05795, 0.1693, 0.6162],
    [0.03201, 0.20802, 0.46518],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.06327, 0.71, 0.07825],
    [0.1096, 0.7932, 0.05725],
    [0.1655, 0.862, 0.04216],
    [0.22575, 0.91485, 0.02984],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.43345, 0.99495, 0.00875],
    [0.51205, 1.0, 0.00575],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.00275],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.00165],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.00034],
    [0.9384, 0.4412, 0.00024],
    [0.85445, 0.381, 0.00019],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 0.00005],
    [0.5419, 0.217, 0.00003],
    [0.4479, 0.175, 0.00002],
    [0.3608, 0.1382, 0.00001],
    [0.2835, 0.107, -0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0],
    [0.0329, 0.01192, 0.0],
    [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0],
    [0.011359, 0.004102, 0.0],
    [0.008111, 0.002929, 0.0],
    [0.00579, 0.002091, 0.0],
    [0.004109, 0.001484, 0.0],
    [0.002899, 0.001047, 0.0],
    [0.002049, 0.00074, 0.0],
    [0.00144, 0.00052, 0.0],
    [0.001, 0.000361, 0.0],
    [0.00069, 0.000249, 0.0],
    [0.000476, 0.000172, 0.0],
    [0.000332, 0.00012, 0.0],
    [0.000235, 0.000085, 0.0],
    [0.000166, 0.00006, 0.0],
    [0.000117, 0.000042, 0.0],
    [0.000083, 0.00003, 0.0],
    [0.000059, 0.000021, 0.0],
    [0.000042, 0.000015, 0.0],
];

/// sRGB value, 0 to 1, of a linear value by the transfer function of IEC 61966-2-1. Clipped to 0 to 1; NaN becomes 0.
pub fn encode_srgb(linear: f64) -> f64 {
    let linear = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Linear value of an sRGB value, both 0 to 1: the inverse of [`encode_srgb`].
pub fn decode_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// The nearest 8-bit sRGB level.
pub fn encode_srgb_byte(linear: f64) -> u8 {
    (255.0 * encode_srgb(linear)).round() as u8
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn rgb(wavelengths_nm: &[f64], spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
        let weights = rgb_weights(wavelengths_nm).unwrap();
        std::array::from_fn(|c| wavelengths_nm.iter().zip(&weights).map(|(&w, k)| spectrum(w) * k[c]).sum())
    }

    fn steps(first: u32, last: u32, step: usize) -> Vec<f64> {
        (first..=last).step_by(step).map(f64::from).collect()
    }

    fn close(a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
        (0..3).all(|c| (a[c] - b[c]).abs() <= tolerance)
    }

    #[test]
    fn srgb_values_round_trip() {
        for code in 0..=255u8 {
            assert_eq!(encode_srgb_byte(decode_srgb(f64::from(code) / 255.0)), code);
        }
        assert!((decode_srgb(0.5) - 0.214_041_140_482_232_55).abs() < 1e-12);
        assert_eq!([encode_srgb(f64::NAN), encode_srgb(-1.0), encode_srgb(0.0)], [0.0; 3]);
        assert!((encode_srgb(7.0) - 1.0).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn flat_spectra_are_grey(gaps in prop::collection::vec(0.01f64..60.0, 1..60), first in 100.0f64..700.0,
                                 value in 0.0f64..10.0) {
            let mut at = first;
            let mut wavelengths = vec![at];
            for gap in gaps {
                at += gap;
                wavelengths.push(at);
            }
            wavelengths.retain(|&w| w <= 3000.0);
            prop_assume!(wavelengths[wavelengths.len() - 1] >= 380.0);
            prop_assert!(close(rgb(&wavelengths, |_| value), [value; 3], 1e-12 * value.max(1.0)));
        }

        #[test]
        fn samples_on_a_line_between_others_change_nothing(extra in 401.0f64..699.0, slope in -1.0f64..1.0) {
            let plain = [400.0, 700.0];
            let line = |w: f64| 1.0 + slope * (w - 400.0) / 300.0;
            prop_assert!(close(rgb(&plain, line), rgb(&[400.0, extra, 700.0], line), 1e-12));
        }
    }

    #[test]
    fn bumps_have_the_right_dominant_channel() {
        let wavelengths = steps(400, 700, 10);
        for (centre, channel) in [(620.0, 0), (540.0, 1), (450.0, 2)] {
            let c = rgb(&wavelengths, |w| if w == centre { 1.0 } else { 0.0 });
            assert!((0..3).all(|k| k == channel || c[k] < 0.5 * c[channel]), "{centre} nm: {c:?}");
        }
    }

    #[test]
    fn a_single_wavelength_is_grey() {
        assert!(close(rgb(&[550.0], |_| 0.3), [0.3; 3], 1e-15));
    }

    /// The reference was computed by `colour-science` 0.4.7: the 17 values, interpolated linearly at 1 nm from 380 to
    /// 780 nm with constant ends; `sd_to_XYZ(method="Integration")` under equal energy with the CIE 1931 2-degree
    /// observer; `chromatic_adaptation` ("Von Kries", "Bradford") from the XYZ of a flat spectrum to D65 (0.3127,
    /// 0.3290); derived matrix of "ITU-R BT.709". Once with the observer interpolated from 5 nm, as here, and once with
    /// the one at 1 nm.
    #[test]
    fn agrees_with_an_independent_computation() {
        let wavelengths = steps(400, 720, 20);
        let values = [
            0.204602, 0.259301, 0.413245, 0.413671, 0.261157, 0.210383, 0.217321, 0.248887, 0.323832, 0.45, 0.576168,
            0.651114, 0.682777, 0.694196, 0.698074, 0.699364, 0.699791,
        ];
        let spectrum = |w: f64| values[((w - 400.0) / 20.0).round() as usize];
        let found = rgb(&wavelengths, spectrum);
        assert!(close(found, [0.749405, 0.268947, 0.349894], 5e-5), "{found:?}");
        assert!(close(found, [0.749751, 0.268698, 0.350293], 6e-4), "{found:?}");
        // Negative control: the same spectrum without adaptation.
        assert!(!close(found, [0.839121, 0.251852, 0.317636], 1e-2), "{found:?}");
    }

    #[test]
    fn errors_name_the_wavelength() {
        for (wavelengths, text) in [
            (vec![], "wavelengths: no wavelengths; expected at least one"),
            (vec![500.0, 500.0], "wavelength 2: found 500 nm, expected more than the 500 nm before"),
            (vec![f64::NAN], "wavelength 1: found NaN nm, expected 100 to 3000 nm"),
            (vec![500.0, f64::INFINITY], "wavelength 2: found inf nm, expected 100 to 3000 nm"),
            (vec![0.5, 0.6], "wavelength 1: found 0.5 nm, expected 100 to 3000 nm"),
            (vec![800.0, 900.0], "wavelengths: found 800 to 900 nm, expected an overlap with 380 to 780 nm"),
        ] {
            assert_eq!(rgb_weights(&wavelengths).unwrap_err().to_string(), text);
        }
    }
}
