//! Jobs of the commands: builds from scene manifests, encodings, flat BTFs, reports, viewer pages and verification. Builds open,
//! compute and write only what the uses of a scene require.

pub mod btf_stack;
pub mod build;
pub mod convert;
pub mod depfile;
pub mod encode;
pub mod environment;
mod error;
pub mod exposure;
pub mod file_events;
pub mod file_name;
pub mod flatten;
mod keys;
pub mod lobes;
pub mod output_folder;
pub mod outputs;
pub mod pack_files;
pub mod pwt;
pub mod report;
pub mod rti_capture;
pub mod scene;
pub mod stage_clock;
pub mod store;
pub mod tabulated;
pub mod verify;
pub mod view;
pub mod write;

pub use error::{Error, ErrorKind};
