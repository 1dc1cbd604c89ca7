//! The program as people and scripts use it.

mod architecture;
mod bad_input;
mod cli;
mod common;
mod determinism;
mod layers;
mod readme;
