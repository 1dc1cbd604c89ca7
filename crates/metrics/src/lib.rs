//! Error norms: how far one reflectance function is from another.

pub mod by_angle;
pub mod compare;
pub mod fit_error;
pub mod fraction;
pub mod highlight;
pub mod image;
pub mod lab;
pub mod norms;
pub mod rendering;
pub mod sampling;
pub mod values;
