//! Jobs on files.

mod btf_stack;
mod golden;
