//! Readers of measured data and meshes: bytes to typed and checked structs, one file per layout.
//!
//! Each layout has a normative page beside its reader. Readers check every length against the data at hand before they
//! ask for memory, and say where, what was found and what is allowed when a file does not follow its layout.

pub mod alta;
pub mod btf_stack;
pub mod colour;
pub mod direction_list;
pub mod file_kind;
pub mod merl;
pub mod meso;
pub mod ptm;
pub mod recognise;
pub mod rgl;
pub mod rti_capture;
pub mod scan;
pub mod scan_csv;
pub mod tensor;
mod text;
pub mod ubo_btf;
