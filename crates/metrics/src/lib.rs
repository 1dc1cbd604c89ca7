//! Error norms: how far one reflectance function is from another.

pub mod compare;
pub mod image;
pub mod lab;
pub mod norms;
pub mod sampling;
pub mod vector_math;
