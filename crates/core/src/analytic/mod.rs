//! Analytic reflectance models, for validation and for known answers.
//!
//! Each model is a plain struct with a [`crate::Source`] implementation in f64. The structs do not check their fields:
//! [`ModelInfo`] holds the ranges, and [`parse_model`](super::address::parse_model) checks them. Every `eval` is mirror
//! symmetric and reciprocal, and zero where a direction is not above the horizon.

mod ggx;
mod lambert;
mod lewis;
mod model;
mod poulin;
mod quadrature;
mod velvet;
mod ward;

pub use ggx::Ggx;
pub use lambert::Lambert;
pub use lewis::Lewis;
pub use model::{Analytic, ModelInfo, Parameter, ParameterKind, Shorthand};
pub use poulin::Poulin;
pub use velvet::Velvet;
pub use ward::Ward;

/// All analytic models, for addresses and for lists of models.
pub const MODELS: [&ModelInfo; 6] =
    [&lambert::INFO, &lewis::INFO, &ward::INFO, &poulin::INFO, &ggx::INFO, &velvet::INFO];
