//! Tests of wavelet packs against known answers and physical laws.

mod crop;
mod golden;
mod known_answers;
mod physics_packs;
