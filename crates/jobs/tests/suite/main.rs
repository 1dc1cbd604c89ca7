//! Jobs on files.

mod btf_stack;
mod golden;
mod light_stack;
mod ubo_btf;
