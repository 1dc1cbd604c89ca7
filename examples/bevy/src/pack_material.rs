//! A Bevy material that draws the BRDF packs of `brdfc`: tables and wavelets, under Bevy's point, spot and directional lights.
//!
//! Add [`PackMaterialPlugin`], load a `.ktx2` as a [`PackMaterial`], and put it on a mesh by [`MeshMaterial3d`]. The mesh needs
//! normals, and tangents where the pack tells directions around the normal apart.

use crate::pack_resources::{PackError, features, pack_image, vectors};
use crate::pack_shader::add_shader;
use bevy::asset::io::Reader;
use bevy::asset::{AssetLoader, LoadContext, uuid_handle};
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_resource::{
    AsBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError, WgpuFeatures,
};
use bevy::shader::ShaderRef;
use brdfc_formats::table::shader::{TABLE_BRDF_WGSL, TableBrdfParameters};
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_formats::{FormatError, Pack};
use brdfc_shaders::resources::{self, Contents, Resource};
use serde::{Deserialize, Serialize};

const TABLE_SHADER: Handle<Shader> = uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a01");
const WAVELET_SHADER: Handle<Shader> = uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a02");

/// Vectors of the uniform block: the longer one, of tables.
const VECTORS: usize = TableBrdfParameters::SIZE / 16;

/// The material, its shaders and the loader of packs.
pub struct PackMaterialPlugin;

impl Plugin for PackMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<PackMaterial>::default());
        app.preregister_asset_loader::<PackLoader>(EXTENSIONS);
        for codec in [PackCodec::Table, PackCodec::Wavelet] {
            let (handle, path, texts) = codec.shader();
            add_shader(app, &handle, path, texts, |binding| codec.binding(binding));
        }
    }

    fn finish(&self, app: &mut App) {
        let features = features(app);
        app.register_asset_loader(PackLoader { features });
    }
}

/// How a pack is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum PackCodec {
    Table,
    Wavelet,
}

impl PackCodec {
    /// The shader, what messages call it, and its texts.
    fn shader(self) -> (Handle<Shader>, &'static str, [&'static str; 2]) {
        match self {
            Self::Table => (TABLE_SHADER, "brdfc/table.wgsl", [TABLE_BRDF_WGSL, TABLE_CALLS]),
            Self::Wavelet => (WAVELET_SHADER, "brdfc/wavelet.wgsl", [WAVELET_BRDF_WGSL, WAVELET_CALLS]),
        }
    }

    /// The binding of [`PackMaterial`] for one of the decoder.
    fn binding(self, of_decoder: u32) -> u32 {
        match (self, of_decoder) {
            (Self::Wavelet, 2) => 4,
            (Self::Wavelet, 3) => 2,
            _ => of_decoder,
        }
    }
}

const TABLE_CALLS: &str = "
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    return table_brdf_at(wi, surface.wo, table_brdf_level_of_detail(surface.distance), true) * wi.z;
}
fn pack_level(uv: vec2<f32>) -> f32 {
    return 0.0;
}
";
const WAVELET_CALLS: &str = "
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    return wavelet_brdf(wi, surface.wo, wavelet_brdf_level_of_detail(surface.distance)) * wi.z;
}
fn pack_level(uv: vec2<f32>) -> f32 {
    return 0.0;
}
";

/// A material of measured reflectance.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone)]
#[bind_group_data(PackMaterialKey)]
pub struct PackMaterial {
    #[uniform(0)]
    parameters: [UVec4; VECTORS],
    #[texture(1, dimension = "3d")]
    #[sampler(2)]
    texels: Option<Handle<Image>>,
    /// Of factored tables alone.
    #[texture(3)]
    curve: Option<Handle<Image>>,
    /// Of wavelets alone.
    #[texture(4, filterable = false)]
    index: Option<Handle<Image>>,
    codec: PackCodec,
    needs_tangents: bool,
}

/// What a pipeline is chosen by.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct PackMaterialKey {
    codec: PackCodec,
    needs_tangents: bool,
}

impl From<&PackMaterial> for PackMaterialKey {
    fn from(material: &PackMaterial) -> Self {
        Self { codec: material.codec, needs_tangents: material.needs_tangents }
    }
}

impl Material for PackMaterial {
    fn fragment_shader() -> ShaderRef {
        TABLE_SHADER.into()
    }

    fn specialize(
        _: &MaterialPipeline,
        descriptor: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        key: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        let key = key.bind_group_data;
        if key.needs_tangents {
            // An error that names the attribute, where the mesh has none.
            layout.0.get_layout(&[Mesh::ATTRIBUTE_TANGENT.at_shader_location(4)])?;
        }
        // Shadows and depth have no fragment shader of this material.
        if let Some(fragment) = &mut descriptor.fragment
            && fragment.shader == TABLE_SHADER
            && key.codec == PackCodec::Wavelet
        {
            fragment.shader = WAVELET_SHADER;
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
}

impl Default for PackSettings {
    fn default() -> Self {
        Self { distance_scale: DEFAULT_DISTANCE_SCALE as f32, smooth: true }
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
        let pack = Pack::from_bytes(&bytes, None)?;
        let (codec, needs_tangents, resources) = match &pack {
            Pack::Table(pack) => {
                let anisotropic = pack.header().axes.layers > 1;
                (PackCodec::Table, anisotropic, resources::table(pack, settings.distance_scale))
            }
            Pack::Wavelet(pack) => {
                let filter = if settings.smooth { Filter::Bilinear } else { Filter::Slices };
                (PackCodec::Wavelet, true, resources::wavelet(pack, filter, settings.distance_scale))
            }
            other => return Err(FormatError::whole("pack", other.kind().name(), "a table or wavelet pack").into()),
        };
        let (mut parameters, mut texels, mut curve, mut index) = ([UVec4::ZERO; VECTORS], None, None, None);
        for Resource { binding, contents } in resources {
            let binding = codec.binding(binding);
            match contents {
                Contents::Uniform(bytes) => parameters = vectors(&bytes),
                Contents::Texture(contents) => {
                    let image = pack_image(contents, false, self.features)?;
                    let handle = Some(context.add_labeled_asset(format!("binding{binding}"), image));
                    match binding {
                        1 => texels = handle,
                        3 => curve = handle,
                        _ => index = handle,
                    }
                }
                // It is that of the image at binding 1.
                Contents::Sampler { .. } => {}
            }
        }
        Ok(PackMaterial { parameters, texels, curve, index, codec, needs_tangents })
    }

    fn extensions(&self) -> &[&str] {
        EXTENSIONS
    }
}
