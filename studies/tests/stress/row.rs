//! One bound: a stage, what it is fed, how far off it is, and how far it may be.

/// Unit roundoff of f32: what one rounding may change, as a share.
pub const U: f64 = 0.5 * f32::EPSILON as f64;

/// All bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct StressStudy {
    /// One for each stage and what it is fed.
    pub rows: Vec<StressRow>,
}

impl StressStudy {
    /// Rows whose bound does not hold.
    pub fn broken(&self) -> impl Iterator<Item = &StressRow> {
        self.rows.iter().filter(|row| !row.holds)
    }
}

/// The worst of one stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StressRow {
    /// The stage.
    pub stage: String,
    /// What it is fed.
    pub fed: String,
    /// Values that were compared.
    pub cases: u64,
    /// What errors are counted in.
    pub measure: Measure,
    /// The worst error. What is no number, or not finite, counts as the largest f64.
    pub error: f64,
    /// The largest that is allowed.
    pub bound: f64,
    /// Why that.
    pub why: String,
    /// Whether the error is within the bound.
    pub holds: bool,
}

/// What errors are counted in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Measure {
    /// The unit of the value.
    Absolute,
    /// A share of the value, or of what the reason names.
    Relative,
    /// Steps of the texels.
    Steps,
    /// A share of the bound of each case, which the reason gives.
    OfBound,
    /// Values that are not as they must be.
    Count,
}

/// Finds the worst of many errors.
#[derive(Debug, Clone, Copy, Default)]
pub struct Worst {
    error: f64,
    cases: u64,
}

impl Worst {
    /// One error; its sign does not matter.
    pub fn add(&mut self, error: f64) {
        let error = error.abs();
        self.error = self.error.max(if error.is_finite() { error } else { f64::MAX });
        self.cases += 1;
    }

    /// One value that is as it must be, or not.
    pub fn check(&mut self, right: bool) {
        self.error += f64::from(u8::from(!right));
        self.cases += 1;
    }

    pub fn row(self, [stage, fed]: [&str; 2], measure: Measure, bound: f64, why: &str) -> StressRow {
        let Self { error, cases } = self;
        let (stage, fed, why) = (stage.to_owned(), fed.to_owned(), why.to_owned());
        // Nothing compared is nothing known.
        StressRow { stage, fed, cases, measure, error, bound, why, holds: cases > 0 && error <= bound }
    }
}
