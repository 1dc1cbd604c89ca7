//! Measure of what an image shows: its share of colours between black and white, and their contrast.

/// Minimum linear value, of any channel, of a colour that is not black: a sixteenth of white in sRGB.
const BLACK: f64 = 0.005;
/// Minimum share of colours that are neither black nor white. It is small because a mirror under a point light has few.
pub const MIN_SHOWN: f64 = 1e-3;
/// Minimum ratio of the brightest to the darkest of these colours.
pub const MIN_CONTRAST: f64 = 1.02;

/// Colours of an image that are neither black nor white. White is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shown {
    /// Number of all colours.
    pub of: usize,
    /// Number of colours that are neither black nor white.
    pub count: usize,
    /// Smallest and largest sum of channels among these colours.
    range: [f64; 2],
}

impl Default for Shown {
    fn default() -> Self {
        Self { of: 0, count: 0, range: [f64::INFINITY, 0.0] }
    }
}

impl Shown {
    /// Counts a colour, linear RGB, and returns true if it is neither black nor white. Negative values count as 0.
    pub fn add(&mut self, colour: [f64; 3]) -> bool {
        self.of += 1;
        let is_shown = colour.iter().any(|value| *value > BLACK) && colour.iter().any(|value| *value < 1.0);
        if is_shown {
            let sum = colour.iter().map(|value| value.max(0.0)).sum::<f64>();
            self.count += 1;
            self.range = [self.range[0].min(sum), self.range[1].max(sum)];
        }
        is_shown
    }

    /// Share of the colours that are neither black nor white; 0 without any colour.
    pub fn share(&self) -> f64 {
        self.count as f64 / self.of.max(1) as f64
    }

    /// Ratio of the brightest to the darkest of these colours; 1 without any.
    pub fn contrast(&self) -> f64 {
        if self.count > 0 { self.range[1] / self.range[0] } else { 1.0 }
    }

    /// Number of colours that must be neither black nor white.
    pub fn needed(&self) -> usize {
        needed(self.of)
    }
}

/// Number of `of` colours that must be neither black nor white, at least one.
pub fn needed(of: usize) -> usize {
    ((MIN_SHOWN * of as f64).ceil() as usize).max(1)
}

impl std::ops::AddAssign for Shown {
    fn add_assign(&mut self, other: Self) {
        self.of += other.of;
        self.count += other.count;
        self.range = [self.range[0].min(other.range[0]), self.range[1].max(other.range[1])];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(colours: &[[f64; 3]]) -> Shown {
        let mut shown = Shown::default();
        for colour in colours {
            shown.add(*colour);
        }
        shown
    }

    #[test]
    fn black_white_and_flat_images_show_nothing() {
        for colour in [[0.0; 3], [-1.0; 3], [0.004; 3], [1.0; 3], [50.0; 3]] {
            assert_eq!((shown(&[colour; 9]).count, shown(&[colour; 9]).of), (0, 9), "{colour:?}");
        }
        let grey = shown(&[[0.5; 3]; 9]);
        assert!(grey.share() == 1.0 && grey.contrast() < MIN_CONTRAST);
        let mut both = shown(&[[0.5; 3]]);
        both += shown(&[[0.6, 0.5, 0.4], [0.0; 3], [0.7; 3]]);
        assert!(both.contrast() > MIN_CONTRAST && both.count == 3 && both.of == 4);
        assert!(both == shown(&[[0.5; 3], [0.6, 0.5, 0.4], [0.0; 3], [0.7; 3]]));
        assert_eq!((shown(&[]).share(), shown(&[]).contrast()), (0.0, 1.0));
    }

    #[test]
    fn one_colour_in_a_thousand_is_enough() {
        let few = [vec![[0.0; 3]; 1999], vec![[0.5; 3]]].concat();
        let enough = [vec![[0.0; 3]; 998], vec![[0.5; 3]]].concat();
        assert!(shown(&few).count < shown(&few).needed() && shown(&enough).count >= shown(&enough).needed());
    }
}
