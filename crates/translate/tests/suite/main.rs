//! Translated shaders.

mod golden;
mod program;
