//! Bandwidth maps from outside the crate.

mod golden;
