//! Numerical stress: every stage at the ends of its range, in single precision compared with double, or with the
//! required result. Each row has the worst observed error, its bound, and the reason for the bound.

mod controls;
mod decode;
mod directions;
mod encode;
mod fed;
mod logarithms;
mod neighbourhoods;
mod pack;
mod propagation;
mod row;
mod run;
mod stages;
mod tables;
mod texels;
mod transforms;

pub use controls::{CONTROLS, Control};
pub use row::{BrokenRow, Measure, StressRow, StressStudy, Worst};
pub use run::{stress, stress_with_controls};
pub use stages::{LocalFit, Stages};
