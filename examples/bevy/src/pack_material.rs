//! A Bevy material that draws the packs of `brdfc`: BRDFs and flat BTFs under Bevy's point, spot and directional lights, lobes in a
//! prefiltered environment, both in one, and an environment as the background.
//!
//! Add [`PackMaterialPlugin`], load a `.ktx2` as a [`PackMaterial`], and put it on a mesh with [`MeshMaterial3d`]. The mesh needs
//! normals, tangents if a pack is anisotropic, and uv for flat BTFs. [`PackSettings::packs`] names further packs of the material.

use crate::pack_resources::upload;
use crate::pack_shader::add_shader;
use bevy::asset::io::Reader;
use bevy::asset::uuid::Uuid;
use bevy::asset::{AssetLoader, LoadContext, ReadAssetBytesError};
use bevy::ecs::system::SystemParamItem;
use bevy::mesh::MeshVertexBufferLayoutRef;
use bevy::pbr::{MaterialPipeline, MaterialPipelineKey};
use bevy::prelude::*;
use bevy::reflect::TypePath;
use bevy::render::render_resource::{
    AsBindGroup, AsBindGroupError, BindGroup, BindGroupLayout, BindGroupLayoutDescriptor, BindGroupLayoutEntry,
    BindingResources, PipelineCache, PreparedBindGroup, RenderPipelineDescriptor, SpecializedMeshPipelineError,
    UnpreparedBindGroup,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::shader::{ShaderDefVal, ShaderRef};
use brdfc_formats::bindings::{Binding, Bindings, FrameBlock, PackFile, Resource};
use brdfc_formats::environment::ENVIRONMENT_WGSL;
use brdfc_formats::lobes::LOBES_WGSL;
use brdfc_formats::wavelet::{DEFAULT_DISTANCE_SCALE, Filter};
use brdfc_formats::{BrdfShader, FormatError, PackKind};
use serde::{Deserialize, Serialize};
use std::marker::PhantomData;
use std::sync::LazyLock;

/// Functions that the material calls in a decoder, and the attributes that a mesh must have.
struct PackDecoder {
    kind: PackKind,
    shader: Handle<Shader>,
    calls: String,
    needs_uv: bool,
}

/// Decoders of all BRDFs and of flat BTFs; lobes without a pack for lights, and environments as backgrounds.
static DECODERS: LazyLock<Vec<PackDecoder>> =
    LazyLock::new(|| PackKind::ALL.into_iter().filter_map(PackDecoder::of).collect());

impl PackDecoder {
    fn of(kind: PackKind) -> Option<Self> {
        let needs_uv = matches!(kind, PackKind::FlatBtf | PackKind::FlatBtfTrees);
        let calls = match kind.descriptor().brdf {
            Some(BrdfShader { level_of_detail, filtered, .. }) => format!(
                "
fn pack_level(uv: vec2<f32>) -> f32 {{
    return 0.0;
}}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {{
    let wo = surface.wo;
    let distance = surface.distance;
    let level = {level_of_detail};
    return {filtered} * wi.z;
}}
"
            ),
            None if kind == PackKind::FlatBtf => of_tiles("factored_mipmap_level", "flat_btf_value"),
            None if kind == PackKind::FlatBtfTrees => of_tiles("flat_trees_mipmap_level", "flat_trees_value"),
            None if [PackKind::Lobes, PackKind::Environment].contains(&kind) => UNLIT_WGSL.to_owned(),
            None => return None,
        };
        let uuid = Uuid::from_u128(0x0a6f2f6e_6f0e_4b43_9a5c_6f3c2f5d1a01 + kind as u128);
        Some(Self { kind, shader: Handle::Uuid(uuid, PhantomData), calls, needs_uv })
    }
}

/// Calls of a flat BTF. For tiles, v follows the bitangent, opposite to the v of textures.
fn of_tiles(level: &str, value: &str) -> String {
    format!(
        "
fn pack_level(uv: vec2<f32>) -> f32 {{
    return {level}(dpdx(uv * pack_settings.repeat), dpdy(uv * pack_settings.repeat));
}}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {{
    let tiles = vec2<f32>(surface.uv.x, -surface.uv.y) * pack_settings.repeat;
    return {value}(tiles, surface.level, surface.wo, wi) / 3.14159274;
}}
"
    )
}

/// Returns true if a pack is anisotropic: all are, except environments, tables of one layer and lobes of one azimuth.
fn is_anisotropic(bindings: &Bindings<'_>) -> bool {
    let counts = [("table_brdf_parameters", 3), ("lobes_parameters", 2)].map(|(block, at)| word(bindings, block, at));
    bindings.decoder != PackKind::Environment.name() && !counts.contains(&Some(1))
}

/// Settings, before each decoder's calls. The slot must be free in the packs, so pipelines define it.
const SETTINGS_WGSL: &str = "
struct PackSettings {
    repeat: vec2<f32>,  // tiles per unit of uv
    turn: vec2<f32>,    // cosine and sine of the environment's turn
    intensity: f32,     // factor of the environment
    reserved_0: f32,
    reserved_1: f32,
    reserved_2: f32,
}
@group(1) @binding(#{PACK_SETTINGS_SLOT}) var<uniform> pack_settings: PackSettings;
";
/// Calls without a pack for lights.
const UNLIT_WGSL: &str = "
fn pack_level(uv: vec2<f32>) -> f32 {
    return 0.0;
}
fn pack_reflected(surface: PackSurface, wi: vec3<f32>) -> vec3<f32> {
    return vec3<f32>(0.0);
}
";
/// Name of layouts, including the empty one that the material's pipelines have until their pack is known.
const LABEL: &str = "brdfc_pack";

/// Reads a word of a uniform block, if the pack has that block.
fn word(bindings: &Bindings<'_>, block: &str, index: usize) -> Option<u32> {
    let found = bindings.all.iter().find(|binding| binding.name == block).map(|binding| &binding.resource);
    let Some(Resource::Uniform(bytes)) = found else { return None };
    bytes.as_chunks::<4>().0.get(index).map(|word| u32::from_le_bytes(*word))
}

/// Registers the material, its shaders and the loader of packs.
pub struct PackMaterialPlugin;

impl Plugin for PackMaterialPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(MaterialPlugin::<PackMaterial>::default());
        app.preregister_asset_loader::<PackLoader>(EXTENSIONS);
        for PackDecoder { kind, shader, calls, .. } in DECODERS.iter() {
            // Any material may have lobes and an environment.
            let lit = [ENVIRONMENT_WGSL, LOBES_WGSL].concat();
            let own = if calls == UNLIT_WGSL { String::new() } else { (kind.descriptor().wgsl)() };
            let texts = [&lit, &own, "\n", SETTINGS_WGSL, calls];
            add_shader(app, shader, &format!("brdfc/{}.wgsl", kind.name()), &texts);
        }
    }

    fn finish(&self, app: &mut App) {
        let world = app.world();
        let device = (world.get_resource::<RenderDevice>(), world.get_resource::<RenderQueue>());
        if let (Some(device), Some(queue)) = device {
            let loader = PackLoader { device: device.clone(), queue: queue.clone() };
            app.register_asset_loader(loader);
        }
    }
}

/// Material of packs that are already on the GPU.
#[derive(Asset, TypePath, Debug, Clone)]
pub struct PackMaterial {
    group: BindGroup,
    key: PackMaterialKey,
}

/// Key of a pipeline.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct PackMaterialKey {
    layout: Vec<BindGroupLayoutEntry>,
    /// Index in [`DECODERS`].
    decoder: usize,
    settings_slot: u32,
    needs_tangents: bool,
    has_lobes: bool,
}

/// Each pack has a layout of its own, so its bind group is made when it is loaded.
impl AsBindGroup for PackMaterial {
    type Data = PackMaterialKey;
    type Param = ();

    fn label() -> &'static str {
        LABEL
    }

    fn as_bind_group(
        &self,
        _: &BindGroupLayoutDescriptor,
        _: &RenderDevice,
        _: &PipelineCache,
        (): &mut SystemParamItem<'_, '_, Self::Param>,
    ) -> Result<PreparedBindGroup, AsBindGroupError> {
        // The group itself keeps its resources alive.
        Ok(PreparedBindGroup { bindings: BindingResources(Vec::new()), bind_group: self.group.clone() })
    }

    fn bind_group_data(&self) -> PackMaterialKey {
        self.key.clone()
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
        let PackMaterialKey { layout: entries, decoder, settings_slot, needs_tangents, has_lobes } =
            key.bind_group_data;
        // The mesh reports an error with the name of a missing attribute.
        if DECODERS[decoder].needs_uv {
            layout.0.get_layout(&[Mesh::ATTRIBUTE_UV_0.at_shader_location(2)])?;
        }
        if needs_tangents {
            layout.0.get_layout(&[Mesh::ATTRIBUTE_TANGENT.at_shader_location(4)])?;
        }
        for group in descriptor.layout.iter_mut().filter(|group| group.label == LABEL) {
            group.entries.clone_from(&entries);
        }
        // The passes for shadows and depth have no fragment shader of this material.
        if let Some(fragment) = &mut descriptor.fragment
            && fragment.shader == DECODERS[0].shader
        {
            fragment.shader = DECODERS[decoder].shader.clone();
            let is_background = DECODERS[decoder].kind == PackKind::Environment;
            fragment.shader_defs.push(ShaderDefVal::UInt("PACK_SETTINGS_SLOT".to_owned(), settings_slot));
            let defined = [("PACK_LOBES", has_lobes), ("PACK_BACKGROUND", is_background)];
            let defined = defined.into_iter().filter_map(|(name, is_defined)| is_defined.then(|| name.into()));
            fragment.shader_defs.extend(defined);
            // Backgrounds are seen from inside.
            if is_background {
                descriptor.primitive.cull_mode = None;
            }
        }
        Ok(())
    }
}

/// Settings of a pack's material.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct PackSettings {
    /// `α` of the level of detail: packs with levels are drawn coarser from the distance 1 / α.
    pub distance_scale: f32,
    /// Also filters wavelet packs over incoming directions, which takes four times as many fetches.
    pub smooth: bool,
    /// Tiles of a flat BTF per unit of uv.
    pub repeat: Vec2,
    /// Asset paths of further packs of the material: lobes and the prefiltered environment that lights them, in any order.
    pub packs: Vec<String>,
    /// Turn of the environment about +y, radians.
    pub environment_turn: f32,
    /// Factor of the environment's radiance.
    pub environment_intensity: f32,
}

impl Default for PackSettings {
    fn default() -> Self {
        Self {
            distance_scale: DEFAULT_DISTANCE_SCALE as f32,
            smooth: true,
            repeat: Vec2::ONE,
            packs: Vec::new(),
            environment_turn: 0.0,
            environment_intensity: 1.0,
        }
    }
}

/// Finds the decoder of a pack in [`DECODERS`].
///
/// # Errors
/// Returns an error if the material does not have the decoder, or has another version of it.
fn decoder_of(bindings: &Bindings<'_>) -> Result<usize, FormatError> {
    let name = &*bindings.decoder;
    let Some(decoder) = DECODERS.iter().position(|decoder| decoder.kind.name() == name) else {
        let allowed: Vec<&str> = DECODERS.iter().map(|decoder| decoder.kind.name()).collect();
        return Err(FormatError::whole("decoder", name, allowed.join(", ")));
    };
    let version = DECODERS[decoder].kind.descriptor().version;
    if bindings.version != version {
        let field = format!("version of the decoder {name}");
        return Err(FormatError::whole(field, bindings.version.to_string(), version.to_string()));
    }
    Ok(decoder)
}

/// Sorts the packs of a material: the pack for lights first, then lobes, then the environment.
///
/// # Errors
/// Returns an error for other packs than one for lights, lobes with an environment, both, or an environment alone.
fn sorted(mut packs: Vec<Bindings<'static>>) -> Result<Vec<Bindings<'static>>, FormatError> {
    let last = [PackKind::Lobes, PackKind::Environment].map(PackKind::name);
    let rank = |pack: &Bindings<'_>| last.iter().position(|name| pack.decoder == *name).map_or(0, |at| at + 1);
    packs.sort_by_key(rank);
    match packs.iter().map(rank).collect::<Vec<_>>()[..] {
        [0] | [1, 2] | [0, 1, 2] | [2] => Ok(packs),
        _ => {
            let found: Vec<&str> = packs.iter().map(|pack| &*pack.decoder).collect();
            let allowed = "a pack of a BRDF or a flat BTF, lobes with an environment, both, or an environment alone";
            Err(FormatError::whole("packs", found.join(", "), allowed))
        }
    }
}

/// Returns the lowest slot that packs leave free.
fn free_slot(all: &[Binding<'_>]) -> u32 {
    let is_free = |slot: &u32| all.iter().all(|binding| binding.slot != *slot);
    (0..).find(is_free).expect("packs have few slots")
}

/// Reads the bindings of a pack for one of [`DECODERS`].
fn bindings_of(bytes: &[u8]) -> Result<Bindings<'static>, FormatError> {
    let PackFile { bindings, .. } = PackFile::from_bytes(bytes)?;
    decoder_of(&bindings)?;
    Ok(bindings)
}

/// Error of loading a pack.
#[derive(Debug, thiserror::Error)]
pub enum PackError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// Another pack of the material cannot be read.
    #[error(transparent)]
    Pack(#[from] ReadAssetBytesError),
    /// A file is not a pack, or a pack that this material or this device does not support.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The same for another pack of the material.
    #[error("{0}: {1}")]
    OtherFormat(String, FormatError),
}

const EXTENSIONS: &[&str] = &["ktx2"];

/// Loads packs as materials, with `asset_server.load::<PackMaterial>("paint.ktx2")`, if there is a device to upload them to.
#[derive(TypePath)]
pub struct PackLoader {
    device: RenderDevice,
    queue: RenderQueue,
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
        let mut packs = vec![bindings_of(&bytes)?];
        for path in &settings.packs {
            let bytes = context.read_asset_bytes(path).await?;
            packs.push(bindings_of(&bytes).map_err(|error| PackError::OtherFormat(path.clone(), error))?);
        }
        let packs = sorted(packs)?;
        let decoder = decoder_of(&packs[0])?;
        let needs_tangents = packs.iter().any(is_anisotropic);
        let has_lobes = packs.len() > 1;
        let mut all: Vec<Binding<'_>> = packs.into_iter().flat_map(|pack| pack.all).collect();
        let settings_slot = free_slot(&all);
        let [repeat_x, repeat_y] = settings.repeat.to_array();
        let (sine, cosine) = settings.environment_turn.sin_cos();
        let words = [repeat_x, repeat_y, cosine, sine, settings.environment_intensity, 0.0, 0.0, 0.0];
        all.push(Binding::uniform(settings_slot, "pack_settings", words.map(f32::to_le_bytes).concat()));
        let blend = if settings.smooth { Filter::Bilinear } else { Filter::Slices };
        let frame = FrameBlock { distance_scale: settings.distance_scale, sampler_filters: true, blend };
        let (layout, group) = upload(all, frame, &self.device, &self.queue)?;
        Ok(PackMaterial { group, key: PackMaterialKey { layout, decoder, settings_slot, needs_tangents, has_lobes } })
    }

    fn extensions(&self) -> &[&str] {
        EXTENSIONS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn packs_for_other_decoders_are_refused() {
        for (decoder, PackDecoder { kind, .. }) in DECODERS.iter().enumerate() {
            let mut bindings = Bindings::new(kind.name(), kind.descriptor().version, []);
            assert_eq!(decoder_of(&bindings), Ok(decoder));
            bindings.version += 1;
            let (found, allowed) = (bindings.version, bindings.version - 1);
            let expected = format!("version of the decoder {}: found {found}, expected {allowed}", kind.name());
            assert_eq!(decoder_of(&bindings).unwrap_err().to_string(), expected);
        }
        let error = decoder_of(&Bindings::new("pwt", 1, [])).unwrap_err().to_string();
        assert!(error.starts_with("decoder: found pwt, expected table, ") && error.contains(", flat-btf"), "{error}");
    }

    #[test]
    fn lights_and_an_environment_share_a_material() {
        let order = |names: &[&'static str]| {
            let packs = names.iter().map(|name| Bindings::new(name, 1, [])).collect();
            let sorted = sorted(packs).map_err(|error| error.to_string())?;
            Ok::<_, String>(sorted.iter().map(|pack| pack.decoder.to_string()).collect::<Vec<_>>().join(" "))
        };
        for (names, expected) in [
            (&["table"][..], "table"),
            (&["environment", "lobes"], "lobes environment"),
            (&["lobes", "environment", "flat-btf"], "flat-btf lobes environment"),
            (&["environment"], "environment"),
        ] {
            assert_eq!(order(names).as_deref(), Ok(expected));
        }
        for names in
            [&["lobes"][..], &["table", "lobes"], &["table", "environment"], &["table", "wavelet"], &["lobes", "lobes"]]
        {
            let error = order(names).unwrap_err();
            assert!(error.starts_with("packs: found ") && error.ends_with("or an environment alone"), "{error}");
        }
    }

    #[test]
    fn settings_get_a_slot_that_the_packs_leave_free() {
        let free = |slots: &[u32]| {
            free_slot(&slots.iter().map(|slot| Binding::sampler(*slot, "s", false)).collect::<Vec<_>>())
        };
        assert_eq!([free(&[]), free(&[0, 1, 2]), free(&[0, 2, 3]), free(&[1, 999])], [0, 3, 1, 0]);
    }
}
