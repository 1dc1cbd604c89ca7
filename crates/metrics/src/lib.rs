//! Error norms: distances between reflectance functions.

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
pub mod shown;
pub mod values;
