//! Data of a page, as its script reads it.

use super::environment::ViewEnvironment;
use super::item::ViewItem;
use super::mesh::PackedMesh;
use super::packed::packed;
use super::photographs::Photograph;
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use brdfc_formats::PackKind;
use brdfc_formats::bindings::{Binding, FrameBlock, Resource, Texels};
use brdfc_formats::container::TexelFormat;
use brdfc_render::scene::{Camera, PointLight};
use brdfc_shaders::Program;
use serde::Serialize;
use std::collections::BTreeMap;

/// All data of a page.
#[derive(Debug, Serialize)]
pub(super) struct PageData {
    /// [`Programs`], packed.
    pub programs: String,
    pub scenes: Vec<PageScene>,
    /// The environment, if one of the items needs it.
    pub environment: Option<PageEnvironment>,
    pub items: Vec<PageItem>,
}

/// Shader programs.
#[derive(Debug, Serialize)]
pub(super) struct Programs {
    /// Programs by decoder; the suffix `, exact` marks filtering in the shader. That of environments draws the background.
    pub of: BTreeMap<String, Program>,
    /// The program that displays renderings.
    pub show: Program,
}

impl Programs {
    /// Compressed JSON of the programs.
    pub(super) fn packed(&self) -> String {
        packed(&serde_json::to_vec(self).expect("programs are plain"))
    }
}

/// A scene.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PageScene {
    pub name: String,
    pub camera: Camera,
    pub lights: Vec<PointLight>,
    pub background: [f32; 3],
    pub mesh: PackedMesh,
    /// Halves of the width and height of an image, the larger 1; `None` on other surfaces. Lights of images are distant.
    pub half_sides: Option<[f64; 2]>,
}

/// An environment. Its name, facts and decoder are as in [`PageItem`].
#[derive(Debug, Serialize)]
pub(super) struct PageEnvironment {
    name: String,
    facts: String,
    decoder: &'static str,
    resources: Vec<PageResource>,
}

impl PageEnvironment {
    pub(super) fn new(environment: &ViewEnvironment) -> Self {
        Self {
            name: environment.name.clone(),
            facts: environment.facts(),
            decoder: PackKind::Environment.name(),
            resources: environment.pack.bindings().all.into_iter().map(PageResource::new).collect(),
        }
    }

    /// Bytes of its data in the page.
    pub(super) fn bytes(&self) -> usize {
        self.resources.iter().map(PageResource::bytes).sum()
    }
}

/// A material.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct PageItem {
    pub(super) name: String,
    facts: String,
    decoder: &'static str,
    /// Its own resources; shaders of items that need the environment also bind those of the environment.
    resources: Vec<PageResource>,
    /// Images instead of resources: photographs with their lights, or normals.
    photographs: Vec<PagePhotograph>,
    needs_environment: bool,
    /// Names of scenes.
    scenes: Vec<String>,
    /// Tiles per unit of uv, by scene.
    repeats: BTreeMap<String, u32>,
    /// Meshes of scenes that the relief of a flat BTF covers, by scene.
    reliefs: BTreeMap<String, PackedMesh>,
    /// Sines of the elevations that it covers: the viewer's lowest and highest, then the lights'.
    sines: [f64; 4],
    /// Number of levels coarser than the finest.
    levels: u32,
    /// The finest level.
    finest: u32,
    /// True if its texels are 32-bit floats for which a sampler is declared.
    pub(super) wide: bool,
}

impl PageItem {
    pub(super) fn new(item: &ViewItem) -> Self {
        let bindings = item.bindings();
        let is_wide = |texels: &Texels<'_>| matches!(texels.format, TexelFormat::R16Unorm | TexelFormat::Rgba16Unorm);
        let wide = bindings.textures().any(|(_, texels)| is_wide(texels));
        let directions = item.directions();
        let ([from, to], [low, high]) = (directions.view.sines(), directions.light.sines());
        let (levels, finest) = item.levels();
        let scenes = item.scenes();
        Self {
            name: item.name.clone(),
            facts: item.facts.clone(),
            decoder: item.decoder_name(),
            resources: bindings.all.into_iter().map(PageResource::new).collect(),
            photographs: item.photographs().iter().flat_map(|it| &it.all).map(PagePhotograph::new).collect(),
            needs_environment: item.needs_environment(),
            scenes: scenes.iter().map(|scene| scene.name()).collect(),
            repeats: scenes.iter().map(|scene| (scene.name(), item.repeat(*scene))).collect(),
            reliefs: scenes.iter().filter_map(|scene| Some((scene.name(), item.relief(*scene)?))).collect(),
            sines: [from, to, low, high],
            levels,
            finest,
            wide,
        }
    }

    /// Bytes of its textures as uploaded.
    pub(super) fn texel_bytes(&self) -> u64 {
        self.resources.iter().map(|resource| resource.texel_bytes).sum()
    }

    /// Bytes of its data in the page.
    pub(super) fn bytes(&self) -> usize {
        let reliefs: usize = self.reliefs.values().map(PackedMesh::bytes).sum();
        let photographs: usize = self.photographs.iter().map(|photograph| photograph.data.len()).sum();
        reliefs + photographs + self.resources.iter().map(|resource| resource.bytes()).sum::<usize>()
    }
}

/// A photograph under a known light, or an image that does not depend on the light.
#[derive(Debug, Serialize)]
struct PagePhotograph {
    name: String,
    light: Option<[f32; 3]>,
    /// A JPEG file as Base64.
    data: String,
}

impl PagePhotograph {
    fn new(photograph: &Photograph) -> Self {
        let Photograph { name, light, jpeg } = photograph;
        Self { name: name.clone(), light: *light, data: STANDARD.encode(jpeg) }
    }
}

/// A bound resource.
#[derive(Debug, Serialize)]
struct PageResource {
    binding: u32,
    #[serde(skip)]
    texel_bytes: u64,
    #[serde(flatten)]
    contents: PageContents,
}

#[derive(Debug, Serialize)]
#[serde(tag = "kind", rename_all = "camelCase", rename_all_fields = "camelCase")]
enum PageContents {
    Uniform {
        data: String,
    },
    Sampler {
        repeats: bool,
    },
    Texture {
        format: &'static str,
        dimension: &'static str,
        size: [u32; 3],
        texel_bytes: usize,
        levels: u32,
        data: String,
    },
}

impl PageResource {
    fn new(binding: Binding<'_>) -> Self {
        let mut texel_bytes = 0;
        let contents = match binding.resource {
            // The default block lets samplers filter.
            Resource::Frame => PageContents::Uniform { data: packed(&FrameBlock::default().to_bytes()) },
            Resource::Uniform(bytes) => PageContents::Uniform { data: packed(&bytes) },
            Resource::Sampler { repeats } => PageContents::Sampler { repeats },
            Resource::Texture(texels) => {
                let texels = texels.widened();
                texel_bytes = texels.bytes.len() as u64;
                PageContents::Texture {
                    format: texels.format.name(),
                    dimension: texels.extent.dimension(),
                    size: texels.extent.size(),
                    texel_bytes: texels.format.texel_bytes(),
                    levels: texels.levels,
                    data: packed(&texels.bytes),
                }
            }
        };
        Self { binding: binding.slot, texel_bytes, contents }
    }

    fn bytes(&self) -> usize {
        match &self.contents {
            PageContents::Uniform { data } | PageContents::Texture { data, .. } => data.len(),
            PageContents::Sampler { .. } => 0,
        }
    }
}
