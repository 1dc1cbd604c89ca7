//! Tables against what they must hold.

mod crop;
mod golden;
mod known_answers;
mod levels;
mod odd_sources;
