//! Jobs on files.

mod btf_stack;
mod golden;
mod rti_capture;
mod ubo_btf;
