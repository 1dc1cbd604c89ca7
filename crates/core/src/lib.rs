//! Shared base of all stages, without files: reflectance as a function of direction pairs, tallies of repairs, progress
//! and cancellation, and formatted numbers.

pub mod address;
pub mod analytic;
pub mod byte_count;
mod describe;
pub mod half_difference;
mod luminance;
mod pack_source;
pub mod pair_list;
pub mod progress;
mod smooth;
pub mod source;
mod stray_rows;
mod tally;
pub mod whole_number;
pub mod words;

pub use brdfc_formats::Symmetry;
pub use describe::{Darkest, Describe};
pub use luminance::{LUMINANCE_WEIGHTS, luminance};
pub use pack_source::PackSource;
pub use smooth::Smooth;
pub use source::Source;
pub use stray_rows::StrayRows;
pub use tally::Tally;
