//! Savings of adaptive shading, and accuracy of its predictions (sections 3 to 5 of "Interactive rendering of acquired
//! materials on dynamic geometry using bandwidth prediction", Bagher, Soler, Subr, Belcour and Holzschuch 2012). Runs
//! on the CPU, with the measured values themselves.

mod antialiasing;
mod case;
mod curve;
mod directions;
mod equal_error;
mod fourier;
mod spectrum;

pub use antialiasing::{AntialiasingRow, AntialiasingStudy, Exponents, antialiasing_study, exponents};
pub use case::{Case, Lighting, StudyMaterial};
pub use directions::{DIRECTIONS, DirectionsRow, DirectionsStudy, directions_study};
pub use equal_error::{AdaptivePoint, EqualErrorRow, equal_error};
pub use fourier::{FourierRow, Quantiles, fourier_check};
