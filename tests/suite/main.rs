//! The program as people and scripts use it.

mod architecture;
mod bad_input;
mod cli;
mod common;
mod dependencies;
mod determinism;
mod layers;
mod library;
mod packages;
mod prose;
mod readme;
mod scan_truths;
mod unbelievable;
