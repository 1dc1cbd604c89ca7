//! A Bevy material that draws flat BTFs of `brdfc`: surfaces with relief, under Bevy's point, spot and directional lights.
//!
//! Add [`FlatBtfMaterialPlugin`], load the `.json` of a flat BTF as a [`FlatBtfMaterial`], and put it on a mesh by
//! [`MeshMaterial3d`]. The mesh needs normals, tangents and uv.

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
use brdfc_formats::flat_btf::factored::FactoredFlatBtf;
use brdfc_formats::flat_btf::factored::shader::FactoredParameters;
use brdfc_formats::flat_btf::shader::{FlatBtfParameters, flat_btf_value_wgsl};
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatBtfParts, FlatPart, FlatValues};
use brdfc_formats::{FormatError, Pack};
use brdfc_shaders::resources::{self, Contents, Resource};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

const SHADER: Handle<Shader> = uuid_handle!("0a6f2f6e-6f0e-4b43-9a5c-6f3c2f5d1a03");
const EXTENSIONS: &[&str] = &["json"];

/// Vectors of the uniform blocks.
const VECTORS: usize = FlatBtfParameters::SIZE / 16;
const FACTORED_VECTORS: usize = FactoredParameters::SIZE / 16;

/// Of tiles, v goes along the bitangent, against that of textures.
const CALLS: &str = "
@group(#{MATERIAL_BIND_GROUP}) @binding(14) var<uniform> flat_btf_repeat: vec2<f32>;

fn pack_level(uv: vec2<f32>) -> f32 {
    return factored_mipmap_level(dpdx(uv * flat_btf_repeat), dpdy(uv * flat_btf_repeat));
}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    let tiles = vec2<f32>(surface.uv.x, -surface.uv.y) * flat_btf_repeat;
    return flat_btf_value(tiles, surface.level, surface.wo, wi) / 3.14159274;
}
";

/// The material, its shader and the loader of flat BTFs.
pub struct FlatBtfMaterialPlugin;

impl Plugin for FlatBtfMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<FlatBtfMaterial>::default());
        app.preregister_asset_loader::<FlatBtfLoader>(EXTENSIONS);
        add_shader(app, &SHADER, "brdfc/flat_btf.wgsl", [&flat_btf_value_wgsl(), CALLS], |binding| binding);
    }

    fn finish(&self, app: &mut App) {
        let features = features(app);
        app.register_asset_loader(FlatBtfLoader { features });
    }
}

/// A material of relief. Its fields have the bindings of the decoder.
#[derive(Asset, AsBindGroup, TypePath, Debug, Clone)]
pub struct FlatBtfMaterial {
    #[uniform(0)]
    parameters: [UVec4; VECTORS],
    #[texture(1, filterable = false)]
    reference: Option<Handle<Image>>,
    #[texture(2)]
    #[sampler(3)]
    indirection: Option<Handle<Image>>,
    #[texture(4)]
    normal: Option<Handle<Image>>,
    #[texture(5)]
    diffuse: Option<Handle<Image>>,
    #[texture(6, dimension = "2d_array")]
    values: Option<Handle<Image>>,
    #[texture(7)]
    ranges: Option<Handle<Image>>,
    #[uniform(8)]
    factored: [UVec4; FACTORED_VECTORS],
    #[texture(9, dimension = "2d_array")]
    #[sampler(12)]
    weights: Option<Handle<Image>>,
    #[texture(10, dimension = "2d_array")]
    shadow: Option<Handle<Image>>,
    #[texture(11, sample_type = "u_int")]
    basis: Option<Handle<Image>>,
    #[texture(13, sample_type = "u_int")]
    directions: Option<Handle<Image>>,
    /// Tiles per unit of uv.
    #[uniform(14)]
    pub repeat: Vec2,
}

impl Material for FlatBtfMaterial {
    fn fragment_shader() -> ShaderRef {
        SHADER.into()
    }

    fn specialize(
        _: &MaterialPipeline,
        _: &mut RenderPipelineDescriptor,
        layout: &MeshVertexBufferLayoutRef,
        _: MaterialPipelineKey<Self>,
    ) -> Result<(), SpecializedMeshPipelineError> {
        // An error that names the attribute, where the mesh has none.
        let needed = [Mesh::ATTRIBUTE_UV_0.at_shader_location(2), Mesh::ATTRIBUTE_TANGENT.at_shader_location(4)];
        layout.0.get_layout(&needed)?;
        Ok(())
    }
}

/// How a flat BTF is laid out.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct FlatBtfSettings {
    /// Tiles per unit of uv.
    pub repeat: Vec2,
}

impl Default for FlatBtfSettings {
    fn default() -> Self {
        Self { repeat: Vec2::ONE }
    }
}

/// Loads flat BTFs as materials, by `asset_server.load::<FlatBtfMaterial>("button/button.json")`.
#[derive(Debug, TypePath)]
pub struct FlatBtfLoader {
    features: WgpuFeatures,
}

/// What is read of the list of parts.
#[derive(Debug, Deserialize)]
struct Listing {
    parts: BTreeMap<String, Listed>,
}

/// A file of a part.
#[derive(Debug, Deserialize)]
struct Listed {
    file: String,
}

impl AssetLoader for FlatBtfLoader {
    type Asset = FlatBtfMaterial;
    type Settings = FlatBtfSettings;
    type Error = PackError;

    async fn load(
        &self,
        reader: &mut dyn Reader,
        settings: &FlatBtfSettings,
        context: &mut LoadContext<'_>,
    ) -> Result<FlatBtfMaterial, PackError> {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).await?;
        let wrong = |error: serde_json::Error| {
            FormatError::whole("list of parts", error.to_string(), "the .json that 'brdfc flatten' wrote")
        };
        let listing: Listing = serde_json::from_slice(&bytes).map_err(wrong)?;
        let mut packs = Packs::default();
        for (part, Listed { file }) in &listing.parts {
            match FlatPart::from_name(part) {
                Some(FlatPart::View) => {
                    return Err(FormatError::whole("flat BTF", "one of all views", "a factored one").into());
                }
                // These are not drawn.
                None | Some(FlatPart::Position | FlatPart::Mask) => continue,
                Some(_) => {}
            }
            let path = context.path().resolve_embed_str(file).map_err(|error| {
                FormatError::whole(format!("file of the part {part}"), error.to_string(), "the name of a file")
            })?;
            let bytes = context.read_asset_bytes(path).await?;
            packs.0.insert(part.clone(), Pack::from_bytes(&bytes, Some(file))?);
        }
        let directions = match packs.0.remove("directions") {
            Some(Pack::Directions(directions)) => Some(directions),
            _ => None,
        };
        let decoder = FlatBtfDecoder::new(packs.into_parts()?)?;
        if directions.is_none() && decoder.parts().values.factored().is_some() {
            return Err(missing("directions").into());
        }
        self.material(resources::flat_btf(&decoder, directions.as_ref(), true), settings.repeat, context)
    }

    fn extensions(&self) -> &[&str] {
        EXTENSIONS
    }
}

impl FlatBtfLoader {
    fn material(
        &self,
        resources: Vec<Resource>,
        repeat: Vec2,
        context: &mut LoadContext<'_>,
    ) -> Result<FlatBtfMaterial, PackError> {
        let (mut parameters, mut factored) = ([UVec4::ZERO; VECTORS], [UVec4::ZERO; FACTORED_VECTORS]);
        let mut images = BTreeMap::new();
        for Resource { binding, contents } in resources {
            match (contents, binding) {
                (Contents::Uniform(bytes), 8) => factored = vectors(&bytes),
                (Contents::Uniform(bytes), _) => parameters = vectors(&bytes),
                (Contents::Texture(texels), _) => {
                    // The layers of weights have the sampler that repeats.
                    let image = pack_image(texels, binding == 9, self.features)?;
                    images.insert(binding, context.add_labeled_asset(format!("binding{binding}"), image));
                }
                // They are those of images.
                (Contents::Sampler { .. }, _) => {}
            }
        }
        let mut image = |binding| images.remove(&binding);
        Ok(FlatBtfMaterial {
            parameters,
            reference: image(1),
            indirection: image(2),
            normal: image(4),
            diffuse: image(5),
            values: image(6),
            ranges: image(7),
            factored,
            weights: image(9),
            shadow: image(10),
            basis: image(11),
            directions: image(13),
            repeat,
        })
    }
}

/// The parts of one asset, by name.
#[derive(Default)]
struct Packs(BTreeMap<String, Pack>);

impl Packs {
    fn into_parts(mut self) -> Result<FlatBtfParts, FormatError> {
        let mut take = |part: &'static str| self.0.remove(part);
        let Some(Pack::Reference(reference)) = take("reference") else { return Err(missing("reference")) };
        let indirection = match (take("displacement"), take("indirection")) {
            (Some(Pack::Displacement(map)), _) => map.into(),
            (_, Some(Pack::Indirection(map))) => map.into(),
            _ => return Err(missing("displacement")),
        };
        let Some(Pack::Normal(normal)) = take("normal") else { return Err(missing("normal")) };
        let Some(Pack::Diffuse(diffuse)) = take("diffuse") else { return Err(missing("diffuse")) };
        let shadow = match take("shadow") {
            Some(Pack::Shadow(shadow)) => Some(shadow),
            _ => None,
        };
        let values = match (take("basis"), take("weights")) {
            (Some(Pack::Basis(basis)), Some(Pack::Weights(weights))) => {
                FlatValues::Factored(Box::new(FactoredFlatBtf::new(basis, weights, shadow)?))
            }
            (None, None) => FlatValues::None,
            (basis, _) => return Err(missing(if basis.is_none() { "basis" } else { "weights" })),
        };
        Ok(FlatBtfParts { reference, indirection, normal, diffuse, values })
    }
}

fn missing(part: &str) -> FormatError {
    FormatError::whole(format!("part {part}"), "none, or another pack", "that of the flat BTF")
}
