//! Importance samples against what they must estimate.

mod golden;
mod importance;
