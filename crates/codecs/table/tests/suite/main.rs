//! Tests of tables against known properties.

mod crop;
mod golden;
mod kept_angles;
mod known_answers;
mod levels;
mod odd_sources;
mod rounding;
mod search;
mod search_within;
