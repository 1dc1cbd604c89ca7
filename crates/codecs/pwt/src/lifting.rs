//! One-dimensional wavelets as lifting steps (Sweldens 1996; factorisations after Daubechies and Sweldens 1998). Each
//! step is invertible for any extension beyond the borders, so that reconstruction is perfect for all wavelets.

/// Wavelet that transforms the images of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Wavelet {
    /// Haar: orthonormal, 2 taps.
    Haar,
    /// Daubechies of 4 taps: orthonormal within the borders.
    Daubechies4,
    /// Cohen, Daubechies and Feauveau, 5 and 3 taps: biorthogonal, symmetric.
    Cdf53,
    /// Cohen, Daubechies and Feauveau, 9 and 7 taps: biorthogonal, symmetric, nearly orthonormal.
    Cdf97,
}

impl Wavelet {
    /// All wavelets.
    pub const ALL: [Self; 4] = [Self::Haar, Self::Daubechies4, Self::Cdf53, Self::Cdf97];

    /// Name in scripts.
    pub fn name(self) -> &'static str {
        match self {
            Self::Haar => "haar",
            Self::Daubechies4 => "daubechies4",
            Self::Cdf53 => "cdf53",
            Self::Cdf97 => "cdf97",
        }
    }

    /// The steps in the order of analysis, and the final factors of low and high coefficients. The low coefficients of
    /// a constant are larger by the square root of 2.
    fn steps(self) -> (&'static [Step], [f32; 2]) {
        use std::f32::consts::{FRAC_1_SQRT_2, SQRT_2};
        match self {
            Self::Haar => (HAAR, [SQRT_2, FRAC_1_SQRT_2]),
            Self::Daubechies4 => (DAUBECHIES_4, [(SQRT_3 - 1.0) / SQRT_2, (SQRT_3 + 1.0) / SQRT_2]),
            Self::Cdf53 => (CDF_53, [SQRT_2, FRAC_1_SQRT_2]),
            Self::Cdf97 => (CDF_97, [1.149_604_4, 0.869_864_5]),
        }
    }
}

const SQRT_3: f32 = 1.732_050_8;
const HAAR: &[Step] = &[Step::to_odd(0, &[-1.0]), Step::to_even(0, &[0.5])];
const DAUBECHIES_4: &[Step] =
    &[Step::to_even(0, &[SQRT_3]), Step::to_odd(-1, &[(2.0 - SQRT_3) / 4.0, -SQRT_3 / 4.0]), Step::to_even(1, &[-1.0])];
const CDF_53: &[Step] = &[Step::to_odd(0, &[-0.5, -0.5]), Step::to_even(-1, &[0.25, 0.25])];
const CDF_97: &[Step] = &[
    Step::to_odd(0, &[-1.586_134_3, -1.586_134_3]),
    Step::to_even(-1, &[-0.052_980_12, -0.052_980_12]),
    Step::to_odd(0, &[0.882_911_1, 0.882_911_1]),
    Step::to_even(-1, &[0.443_506_85, 0.443_506_85]),
];

/// Extension of an image beyond its borders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Border {
    /// Mirrored, for images that end.
    Mirrored,
    /// Periodic, for tiles.
    Periodic,
}

/// `target[n] += Σ_k factors[k] other[n + first + k]`.
#[derive(Debug, Clone, Copy)]
struct Step {
    odd: bool,
    first: i32,
    factors: &'static [f32],
}

impl Step {
    const fn to_odd(first: i32, factors: &'static [f32]) -> Self {
        Self { odd: true, first, factors }
    }

    const fn to_even(first: i32, factors: &'static [f32]) -> Self {
        Self { odd: false, first, factors }
    }

    /// Index into the other half, of `count` elements, for an index that may be beyond it.
    fn index(self, at: i32, count: usize, border: Border) -> usize {
        let count = count as i32;
        match border {
            Border::Periodic => at.rem_euclid(count) as usize,
            // Even samples are mirrored at the first sample, odd ones at the last sample of the image.
            Border::Mirrored => {
                let (below, above) = if self.odd { (-at, 2 * count - 1 - at) } else { (-1 - at, 2 * count - 2 - at) };
                let at = if at < 0 {
                    below
                } else if at >= count {
                    above
                } else {
                    at
                };
                at.clamp(0, count - 1) as usize
            }
        }
    }
}

/// Elements of a lifting step: numbers, or whole rows of numbers.
pub(crate) trait Lines {
    /// `target += factor source`, of the lines of one half and the other.
    fn add(&mut self, odd: bool, target: usize, source: usize, factor: f32);
    /// Multiplies a line by `factor`.
    fn scale(&mut self, odd: bool, line: usize, factor: f32);
    /// Number of lines of each half.
    fn half(&self) -> usize;
}

/// Analyses one level: the even lines become low, the odd ones high coefficients.
pub(crate) fn forward(wavelet: Wavelet, border: Border, lines: &mut impl Lines) {
    let (steps, [low, high]) = wavelet.steps();
    for step in steps {
        lift(*step, border, lines, 1.0);
    }
    for line in 0..lines.half() {
        lines.scale(false, line, low);
        lines.scale(true, line, high);
    }
}

/// Undoes [`forward`].
pub(crate) fn inverse(wavelet: Wavelet, border: Border, lines: &mut impl Lines) {
    let (steps, [low, high]) = wavelet.steps();
    for line in 0..lines.half() {
        lines.scale(false, line, 1.0 / low);
        lines.scale(true, line, 1.0 / high);
    }
    for step in steps.iter().rev() {
        lift(*step, border, lines, -1.0);
    }
}

fn lift(step: Step, border: Border, lines: &mut impl Lines, sign: f32) {
    let half = lines.half();
    for target in 0..half {
        for (k, factor) in step.factors.iter().enumerate() {
            let source = step.index(target as i32 + step.first + k as i32, half, border);
            lines.add(step.odd, target, source, sign * factor);
        }
    }
}
