//! Sources against known answers, oracles and broken files.

mod alta;
mod direction_set;
mod flat_btf_files;
mod gonio_held_out;
mod image_files;
mod large_files;
mod mirror_azimuth;
mod noisy_scans;
mod noisy_tables;
mod public_reports;
mod rgl_corrupt;
mod rgl_oracle;
mod rgl_synthetic;
mod strays;
