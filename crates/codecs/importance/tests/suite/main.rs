//! Tests importance samples against the integrals that they estimate.

mod golden;
mod importance;
