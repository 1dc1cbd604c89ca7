//! Readers of measured data and meshes, from bytes to typed and checked structs; one file per layout.
//!
//! Each layout has a normative page next to its reader. Readers check every length against the data before they
//! allocate memory. Errors state where the file violates its layout, what is wrong and what is valid.

pub mod alta;
pub mod btf_stack;
pub mod colour;
pub mod cube_map;
pub mod direction_list;
pub mod file_kind;
pub mod merl;
pub mod meso;
pub mod near_lights;
pub mod pixels;
pub mod ptm;
pub mod recognise;
pub mod rgl;
pub mod rti;
pub mod rti_capture;
pub mod scan;
pub mod scan_csv;
pub mod tensor;
mod text;
pub mod ubo_btf;
pub mod viewer_file;
mod words;
