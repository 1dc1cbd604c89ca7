//! Layouts, decoders and shaders of every pack.

mod bandwidth;
mod bandwidth_shaders;
mod bindings_corrupt;
mod container_corrupt;
mod cube_maps;
mod decoder;
mod decoder_equations;
mod direction_mesh_shader;
mod direction_weights;
mod environment;
mod factored;
mod factored_corrupt;
mod flat_btf;
mod flat_btf_corrupt;
mod golden;
mod importance;
mod ktx2_rules;
mod ktx_parse;
mod lobes;
mod pack_corrupt;
mod pwt;
mod pwt_corrupt;
mod pwt_shader;
mod shader;
mod spec_dumps;
mod table_corrupt;
