//! Rows of the study: a stage, its input, its error and the bound.

use schemars::JsonSchema;
use serde::Serialize;

/// Unit roundoff of f32: the maximum relative error of one rounding.
pub const U: f64 = 0.5 * f32::EPSILON as f64;

/// All bounds.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StressStudy {
    /// One row for each stage and input.
    pub rows: Vec<StressRow>,
}

impl StressStudy {
    /// Rows whose bound does not hold.
    pub fn broken(&self) -> impl Iterator<Item = &StressRow> {
        self.rows.iter().filter(|row| !row.holds)
    }
}

/// The worst error of one stage.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StressRow {
    /// The stage.
    pub stage: String,
    /// Input of the stage.
    pub fed: String,
    /// Number of compared values.
    pub cases: u64,
    /// Unit of the errors.
    pub measure: Measure,
    /// The worst error. NaN and infinities count as the largest f64.
    pub error: f64,
    /// Maximum allowed error.
    pub bound: f64,
    /// Reason for the bound.
    pub why: String,
    /// True if the error is within the bound.
    pub holds: bool,
    /// The same row with a deliberately broken stage; absent if no negative control exceeds the bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub control: Option<BrokenRow>,
}

/// Error of a deliberately broken stage.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BrokenRow {
    /// Change of the stage.
    pub change: String,
    /// The worst error, above the bound.
    pub error: f64,
}

/// Unit of errors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Measure {
    /// The unit of the value.
    Absolute,
    /// Share of the value, or of the quantity that the reason names.
    Relative,
    /// Steps of the texels.
    Steps,
    /// Share of the bound of each case, which the reason gives.
    OfBound,
    /// Number of wrong values.
    Count,
}

/// Maximum of many errors.
#[derive(Debug, Clone, Copy, Default)]
pub struct Worst {
    error: f64,
    cases: u64,
}

impl Worst {
    /// Adds an error; its sign is ignored.
    pub fn add(&mut self, error: f64) {
        let error = error.abs();
        self.error = self.error.max(if error.is_finite() { error } else { f64::MAX });
        self.cases += 1;
    }

    /// Adds a check of a value.
    pub fn check(&mut self, right: bool) {
        self.error += f64::from(u8::from(!right));
        self.cases += 1;
    }

    /// The row of a stage and its input.
    pub fn row(self, [stage, fed]: [&str; 2], measure: Measure, bound: f64, why: &str) -> StressRow {
        let Self { error, cases } = self;
        let (stage, fed, why) = (stage.to_owned(), fed.to_owned(), why.to_owned());
        // A row without comparisons does not hold.
        StressRow { stage, fed, cases, measure, error, bound, why, holds: cases > 0 && error <= bound, control: None }
    }
}
