//! Opens, recognises and checks input files: sources of reflectance, images and surfaces.

pub mod btf_stack;
pub mod environment;
mod error;
pub mod flat_btf;
mod format;
mod image_file;
mod input;
pub mod input_files;
pub mod json;
pub mod kind;
mod merl;
pub mod meso;
mod misnamed;
pub mod open;
pub mod ordinary_btf;
pub mod pack;
pub mod photograph;
pub mod ptm;
pub mod radiance_image;
pub mod read;
pub mod rgl;
pub mod rti;
pub mod rti_capture;
pub mod scan;
pub mod simulate;
pub mod smooth;
pub mod tile_image;
pub mod ubo_btf;
pub mod viewer_file;

pub use error::InputError;
pub use input::{Input, Reading, StandardInput};
pub use kind::Kind;
pub use merl::MerlSource;
pub use rgl::RglSource;
pub use scan::ScanSource;
