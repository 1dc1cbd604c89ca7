//! Readers of measured data: bytes to typed and checked structs, one file per layout.
//!
//! Each layout has a normative page beside its reader. Readers check every length against the data at hand before they
//! ask for memory, and say where, what was found and what is allowed when a file does not follow its layout.

pub mod alta;
pub mod btf_stack;
pub mod light_stack;
pub mod merl;
pub mod ptm;
pub mod rgl;
pub mod scan;
pub mod scan_csv;
pub mod tensor;
pub mod ubo_btf;
