//! Comparison of methods to store BTFs, all with the same texels, views and lights, for an ordinary BTF and for a flat
//! one (Hadim et al. 2009). Tests the claim of Baril et al. 2008 that polynomial wavelet trees take less than half of
//! the bytes of polynomial texture maps.

mod assets;
mod drawing;
mod errors;
mod factored;
mod joint;
mod lights;
mod per_view;
mod rows;
mod steps;
mod study;
mod whole;

pub use drawing::drawing;
pub use rows::{BtfAsset, BtfClaims, BtfModel, BtfRow, BtfSettings, BtfStudy, MipmapRow, WholeBtf, WholeRow};
pub use study::{BtfStudyError, PARTS, held_out, held_out_views, study_structure};
