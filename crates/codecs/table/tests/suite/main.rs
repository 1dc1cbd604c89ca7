//! Tables against what they must hold.

mod golden;
mod known_answers;
mod odd_sources;
