//! Studies that repeat the papers' tables and figures, the papers' own numbers beside ours.

#[cfg(feature = "render")]
pub mod adaptive;
pub mod flat_btf;
#[cfg(feature = "render")]
pub mod images;
#[cfg(feature = "render")]
pub mod level_of_detail;
pub mod rays;
#[cfg(feature = "render")]
pub mod throughput;
mod wavelet;

pub use wavelet::{StudyRow, wavelet_table_1};
