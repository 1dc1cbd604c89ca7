//! Savings of adaptive shading, and accuracy of its predictions (sections 3 to 5 of "Interactive rendering of acquired
//! materials on dynamic geometry using bandwidth prediction", Bagher, Soler, Subr, Belcour and Holzschuch 2012). Runs
//! on the CPU, with the measured values themselves.

mod antialiasing;
mod case;
mod cases;
mod comparison;
mod curve;
mod directions;
mod equal_time;
mod fourier;
mod gaussians;
mod interpolation;
mod least_squares;
mod lit_balls;
mod method;
mod sample_counts;
mod spectrum;
mod split_sum;
mod statistics;
mod summary;
#[cfg(test)]
mod testing;
mod variance;

pub use antialiasing::{AntialiasingRow, AntialiasingStudy, Exponents, Line, antialiasing_study};
pub use case::{Case, Lighting, StudyMaterial, TruthSamples};
pub use cases::{MATERIALS, SIZES, combinations, environments, shapes, training_environments};
pub use comparison::{CAUTIONS, CaseRow, Curve, FETCHES, MAX_SAMPLES, MethodRow, TARGETS, compare};
pub use curve::{Cost, Point, Target, error_within, needed};
pub use directions::{DIRECTIONS, DirectionsRow, DirectionsStudy, directions_study};
pub use equal_time::equal_time_sheet;
pub use fourier::{FourierCheck, FourierRow};
pub use gaussians::Gaussians;
pub use lit_balls::{Light, LitBalls, View};
pub use method::{Budget, Density, LookUps, Method, Prefiltered, Variant, draw};
pub use sample_counts::SampleCounts;
pub use split_sum::{SplitSum, SplitSumMaterial};
pub use statistics::Quantiles;
pub use summary::{MethodSummary, summary};
pub use variance::DeviationRow;
