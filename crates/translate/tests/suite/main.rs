//! Translated shaders.

mod golden;
