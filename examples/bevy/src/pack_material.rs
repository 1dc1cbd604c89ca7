//! A Bevy material that draws the packs of `brdfc`: tables, wavelets and flat BTFs, under Bevy's point, spot and directional lights.
//!
//! Add [`PackMaterialPlugin`], load a `.ktx2` as a [`PackMaterial`], and put it on a mesh by [`MeshMaterial3d`]. The mesh needs
//! normals, tangents where the pack tells directions around the normal apart, and uv for flat BTFs.

use crate::pack_resources::{PackError, PackResources, features};
use crate::pack_shader::add_shader;
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, uuid_handle};
use bevy::ecs::system::SystemParamItem;
use bevy::ecs::system::lifetimeless::SRes;
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{
    AsBindGroup, AsBindGroupError, BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry, PipelineCache,
    PreparedBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError, UnpreparedBindGroup, WgpuFeatures,
};
use bevy::render::renderer::RenderDevice;
use bevy::render::texture::GpuImage;
use bevy::shader::ShaderRef;
use brdfc_formats::FormatError;
use brdfc_formats::bindings::{Binding, Bindings, FrameBlock, MAX_SLOTS, PackFile, Resource};
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use serde::{Deserialize, Serialize};

/// What differs between decoders: which of their functions the material calls, and what a mesh has to have.
struct PackDecoder {
    name: &'static str,
    shader: Handle<Shader>,
    wgsl: fn() -> String,
    calls: &'static str,
    needs_uv: bool,
    /// Whether it tells directions around the normal apart.
    is_anisotropic: fn(&Bindings<'_>) -> bool,
}

const DECODERS: [PackDecoder; 3] = [
    PackDecoder {
        name: "table",
        shader: uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a01"),
        wgsl: || TABLE_BRDF_WGSL.to_owned(),
        calls: "
fn pack_level(uv: vec2<f32>) -> f32 {
    return 0.0;
}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    return table_brdf_at(wi, surface.wo, table_brdf_level_of_detail(surface.distance), true) * wi.z;
}
",
        needs_uv: false,
        // The word `layers` of its block.
        is_anisotropic: |bindings| word(bindings, "table_brdf_parameters", 3) > 1,
    },
    PackDecoder {
        name: "wavelet",
        shader: uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a02"),
        wgsl: || WAVELET_BRDF_WGSL.to_owned(),
        calls: "
fn pack_level(uv: vec2<f32>) -> f32 {
    return 0.0;
}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    return wavelet_brdf(wi, surface.wo, wavelet_brdf_level_of_detail(surface.distance)) * wi.z;
}
",
        needs_uv: false,
        is_anisotropic: |_| true,
    },
    PackDecoder {
        name: "flat-btf",
        shader: uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a03"),
        wgsl: flat_btf_value_wgsl,
        // Of tiles, v goes along the bitangent, against that of textures.
        calls: "
fn pack_level(uv: vec2<f32>) -> f32 {
    return factored_mipmap_level(dpdx(uv * pack_repeat.xy), dpdy(uv * pack_repeat.xy));
}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    let tiles = vec2<f32>(surface.uv.x, -surface.uv.y) * pack_repeat.xy;
    return flat_btf_value(tiles, surface.level, surface.wo, wi) / 3.14159274;
}
",
        needs_uv: true,
        is_anisotropic: |_| true,
    },
];

/// Where tiles per unit of uv are bound: the last slot, which no pack has so far.
const REPEAT_SLOT: u32 = MAX_SLOTS - 1;
/// What layouts are called, also the empty one that the material's pipelines have until they know their pack.
const LABEL: &str = "brdfc_pack";

/// A word of a uniform block; 0 where there is none.
fn word(bindings: &Bindings<'_>, block: &str, index: usize) -> u32 {
    let found = bindings.all.iter().find(|binding| binding.name == block).map(|binding| &binding.resource);
    let Some(Resource::Uniform(bytes)) = found else { return 0 };
    bytes.as_chunks::<4>().0.get(index).map_or(0, |word| u32::from_le_bytes(*word))
}

/// The material, its shaders and the loader of packs.
pub struct PackMaterialPlugin;

impl Plugin for PackMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<PackMaterial>::default());
        app.preregister_asset_loader::<PackLoader>(EXTENSIONS);
        let repeat = format!("@group(1) @binding({REPEAT_SLOT}) var<uniform> pack_repeat: vec4<f32>;\n");
        for PackDecoder { name, shader, wgsl, calls, .. } in DECODERS {
            add_shader(app, &shader, &format!("brdfc/{name}.wgsl"), &[&wgsl(), "\n", &repeat, calls]);
        }
    }

    fn finish(&self, app: &mut App) {
        let features = features(app);
        app.register_asset_loader(PackLoader { features });
    }
}

/// A material of a pack.
#[derive(Asset, TypePath, Debug, Clone)]
pub struct PackMaterial {
    #[dependency]
    resources: PackResources,
    /// Of [`DECODERS`].
    decoder: usize,
    needs_tangents: bool,
}

/// What a pipeline is chosen by.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PackMaterialKey {
    layout: Vec<BindGroupLayoutEntry>,
    decoder: usize,
    needs_tangents: bool,
}

/// Each pack has a layout of its own, so the material makes its groups itself.
impl AsBindGroup for PackMaterial {
    type Data = PackMaterialKey;
    type Param = SRes<RenderAssets<GpuImage>>;

    fn label() -> &'static str {
        LABEL
    }

    fn as_bind_group(
        &self,
        _: &BindGroupLayoutDescriptor,
        device: &RenderDevice,
        cache: &PipelineCache,
        images: &mut SystemParamItem<'_, '_, Self::Param>,
    ) -> Result<PreparedBindGroup, AsBindGroupError> {
        let layout = cache.get_bind_group_layout(&BindGroupLayoutDescriptor::new(LABEL, &self.resources.layout()));
        self.resources.bind(LABEL, &layout, device, images)
    }

    fn bind_group_data(&self) -> PackMaterialKey {
        let Self { resources, decoder, needs_tangents } = self;
        PackMaterialKey { layout: resources.layout(), decoder: *decoder, needs_tangents: *needs_tangents }
    }

    fn unprepared_bind_group(
        &self,
        _: &BindGroupLayout,
        _: &RenderDevice,
        _: &mut SystemParamItem<'_, '_, Self::Param>,
        _: bool,
    ) -> Result<UnpreparedBindGroup, AsBindGroupError> {
        Err(AsBindGroupError::CreateBindGroupDirectly)
    }

    fn bind_group_layout_entries(_: &RenderDevice, _: bool) -> Vec<BindGroupLayoutEntry> {
        Vec::new()
    }
}

impl Material for PackMaterial {
    fn fragment_shader() -> ShaderRef {
        DECODERS[0].shader.clone().into()
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let PackMaterialKey { layout: entries, decoder, needs_tangents } = key.bind_group_data;
        // An error that names the attribute, where the mesh has none.
        if DECODERS[decoder].needs_uv {
            layout.0.get_layout(&[Mesh::ATTRIBUTE_UV_0.at_shader_location(2)])?;
        }
        if needs_tangents {
            layout.0.get_layout(&[Mesh::ATTRIBUTE_TANGENT.at_shader_location(4)])?;
        }
        for group in descriptor.layout.iter_mut().filter(|group| group.label == LABEL) {
            group.entries.clone_from(&entries);
        }
        // Shadows and depth have no fragment shader of this material.
        if let Some(fragment) = &mut descriptor.fragment
            && fragment.shader == DECODERS[0].shader
        {
            fragment.shader = DECODERS[decoder].shader.clone();
        }
        Ok(())
    }
}

/// How a pack is drawn.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PackSettings {
    /// `α` of the level of detail: from the distance 1 / α on, packs that have levels are drawn coarser.
    pub distance_scale: f32,
    /// Whether wavelet packs are filtered over incoming directions, too: that takes four times as many fetches.
    pub smooth: bool,
    /// Tiles of a flat BTF per unit of uv.
    pub repeat: Vec2,
}

impl Default for PackSettings {
    fn default() -> Self {
        Self { distance_scale: DEFAULT_DISTANCE_SCALE as f32, smooth: true, repeat: Vec2::ONE }
    }
}

const EXTENSIONS: &[&str] = &["ktx2"];

/// Loads packs as materials, by `asset_server.load::<PackMaterial>("paint.ktx2")`.
#[derive(Debug, TypePath)]
pub struct PackLoader {
    features: WgpuFeatures,
}

impl AssetLoader for PackLoader {
    type Asset = PackMaterial;
    type Settings = PackSettings;
    type Error = PackError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &PackSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<PackMaterial, PackError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let PackFile { mut bindings, .. } = PackFile::from_bytes(&bytes)?;
        let decoder = DECODERS.iter().position(|decoder| decoder.name == bindings.decoder).ok_or_else(|| {
            let names = DECODERS.map(|decoder| decoder.name).join(", ");
            FormatError::whole("decoder", bindings.decoder.clone().into_owned(), names)
        })?;
        let needs_tangents = (DECODERS[decoder].is_anisotropic)(&bindings);
        let [x, y] = settings.repeat.to_array().map(f32::to_le_bytes);
        let repeat = [x, y, [0; 4], [0; 4]].concat();
        bindings.all.push(Binding::uniform(REPEAT_SLOT, "pack_repeat", repeat));
        let blend = if settings.smooth { Filter::Bilinear } else { Filter::Slices };
        let frame = FrameBlock { distance_scale: settings.distance_scale, sampler_filters: true, blend };
        let resources = PackResources::load(bindings, frame, self.features, context)?;
        Ok(PackMaterial { resources, decoder, needs_tangents })
    }

    fn extensions(&self) -> &[&str] {
        EXTENSIONS
    }
}
