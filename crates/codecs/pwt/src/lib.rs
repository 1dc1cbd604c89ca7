//! Polynomial wavelet trees.

pub mod design;
pub mod fit;
pub mod image;
pub mod lifting;
pub mod stack;
pub mod tree;
