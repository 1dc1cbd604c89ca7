//! Wavelet packs against known answers and the laws of reflectance.

mod crop;
mod golden;
mod known_answers;
mod physics_packs;
