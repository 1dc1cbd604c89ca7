//! Jobs on files.

mod btf_stack;
mod golden;
mod ubo_btf;
