//! Importance samples against what they must estimate.

mod importance;
