//! Ways to store BTFs beside each other: every one of them of the same texels, views and lights, once of an ordinary BTF and
//! once of a flat one (Hadim et al. 2009), held against the claim of Baril et al. 2008 that polynomial wavelet trees take
//! less than half of the bytes of polynomial texture maps.

mod assets;
mod drawing;
mod errors;
mod factored;
mod joint;
mod lights;
mod per_view;
mod rows;
mod study;

pub use drawing::drawing;
pub use rows::{BtfAsset, BtfClaims, BtfModel, BtfRow, BtfSettings, BtfStudy};
pub use study::{BtfStudyError, PARTS, held_out, study_structure};
