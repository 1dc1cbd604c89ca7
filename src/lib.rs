//! Compiler for measured appearance; see the README.

pub mod source;
