//! Packs for the GPU.
