//! The real program, command by command. One binary for all of them, because each test binary is linked separately.

mod bandwidth;
mod build_assets;
mod build_scene;
mod compare;
mod convert;
mod encode;
mod encode_lobes;
mod environment;
mod eval;
mod flatten;
mod generate;
mod help;
mod info;
mod kinds;
mod many_machines;
mod names;
mod needs;
mod nothing;
mod output;
mod output_folder;
mod pwt;
mod pwt_images;
mod pwt_maps;
mod pwt_views;
#[cfg(feature = "render")]
mod render;
#[cfg(feature = "render")]
mod render_adaptive;
#[cfg(feature = "render")]
mod render_assets;
#[cfg(feature = "render")]
mod render_lobes;
#[cfg(feature = "render")]
mod render_packs;
#[cfg(feature = "render")]
mod render_textures;
mod report;
mod samples;
mod schemas;
mod shader;
mod smoothing;
mod synth;
mod tables;
mod verify;
mod view;
#[cfg(unix)]
mod watch;
#[cfg(feature = "render")]
mod web;
#[cfg(feature = "render")]
mod web_errors;
