//! Tests prefiltered environments against integrals with known results.

mod environment;
mod golden;
