//! Materials of a page.

use super::mesh::PackedMesh;
use super::photographs::Photographs;
use brdfc_formats::BrdfPack;
use brdfc_formats::PackKind;
use brdfc_formats::bindings::Bindings;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_formats::flat_btf::{FlatBtfDecoder, SampledDirections};
use brdfc_formats::lobes::LobesPack;
use brdfc_formats::pwt::PwtPack;
use brdfc_render::flat::covered;
use brdfc_render::scenes::Builtin;

/// Name of the shader that draws photographs.
pub(super) const PHOTOGRAPHS: &str = "photographs";

/// Default scene of BRDFs.
pub(super) const DEFAULT_SCENE: Builtin = Builtin::Sphere;
/// Scenes of BRDFs and lobes; the first is the default. All have the same sky.
const BRDF_SCENES: [Builtin; 4] = [DEFAULT_SCENE, Builtin::Cloth, Builtin::Teapot, Builtin::Plane];
/// Scenes of flat BTFs; the first is the default.
const FLAT_BTF_SCENES: [Builtin; 4] = [Builtin::Plane, Builtin::Teapot, Builtin::Cloth, Builtin::Sphere];

/// A material of a page.
#[derive(Debug, Clone)]
pub struct ViewItem {
    /// Name of the material on the page.
    pub name: String,
    /// Description in one line: sizes and, if known, errors against the source.
    pub facts: String,
    /// The pack that is drawn.
    pub drawn: Drawn,
}

/// A pack that pages draw.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)]
pub enum Drawn {
    /// A pack of a BRDF.
    Brdf(BrdfPack),
    /// A flat BTF, and the directions between which its views and lights are blended.
    FlatBtf(Box<FlatBtfDecoder>, Option<SampledDirections>),
    /// Lobes, which the environment of the page lights.
    Lobes(LobesPack),
    /// A polynomial wavelet tree.
    Pwt(Box<PwtPack>),
    /// Photographs under known lights, or normals.
    Photographs(Photographs),
}

impl ViewItem {
    /// Name of its decoder in `brdfc shader`; `photographs` for those, which have none.
    pub fn decoder_name(&self) -> &'static str {
        self.decoder().map_or(PHOTOGRAPHS, PackKind::name)
    }

    /// Kind of its pack; `None` for photographs.
    pub fn decoder(&self) -> Option<PackKind> {
        Some(match &self.drawn {
            Drawn::Brdf(pack) => pack.kind(),
            Drawn::FlatBtf(decoder, _) => decoder.parts().reflectance.kind(),
            Drawn::Lobes(_) => PackKind::Lobes,
            Drawn::Pwt(_) => PackKind::Pwt,
            Drawn::Photographs(_) => return None,
        })
    }

    /// Bindings of its shader.
    pub fn bindings(&self) -> Bindings<'_> {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.bindings(),
            Drawn::FlatBtf(decoder, directions) => decoder.bindings(directions.as_ref()),
            Drawn::Lobes(pack) => pack.bindings(),
            Drawn::Pwt(pack) => pack.bindings(),
            Drawn::Photographs(_) => Bindings { decoder: PHOTOGRAPHS.into(), version: 1, all: Vec::new() },
        }
    }

    /// Bytes of its textures on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.gpu_bytes(),
            Drawn::FlatBtf(..) => self.bindings().gpu_bytes(),
            Drawn::Lobes(pack) => pack.gpu_bytes(),
            Drawn::Pwt(pack) => pack.gpu_bytes(),
            // One photograph with mipmaps.
            Drawn::Photographs(them) => (them.size[0] * them.size[1]) as u64 * 4 * 4 / 3,
        }
    }

    /// Its photographs, if it has them instead of a pack.
    pub fn photographs(&self) -> Option<&Photographs> {
        if let Drawn::Photographs(them) = &self.drawn { Some(them) } else { None }
    }

    /// True if the environment of the page lights it; point lights light the others.
    pub fn needs_environment(&self) -> bool {
        matches!(self.drawn, Drawn::Lobes(_))
    }

    /// True if the page compares both: on a common surface, under the same kind of light. Same as `comparable` of the page.
    pub fn is_comparable(&self, other: &Self) -> bool {
        let theirs = other.scenes();
        self.needs_environment() == other.needs_environment()
            && self.scenes().iter().any(|scene| theirs.contains(scene))
    }

    /// Number of levels coarser than the finest, and the number of the finest level.
    pub(super) fn levels(&self) -> (u32, u32) {
        let of_mipmaps = |levels: u32| (levels.saturating_sub(1), 0);
        match &self.drawn {
            Drawn::Brdf(pack) => (pack.levels(), pack.levels()),
            Drawn::FlatBtf(decoder, _) => of_mipmaps(decoder.parts().reflectance.levels()),
            Drawn::Lobes(_) | Drawn::Photographs(_) => (0, 0),
            Drawn::Pwt(pack) => {
                let textures = pack.header().textures.len();
                of_mipmaps((0..textures).map(|index| pack.levels_of(index)).max().unwrap_or(1))
            }
        }
    }

    /// Directions that it covers.
    pub(super) fn directions(&self) -> DirectionRange {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.directions(),
            Drawn::FlatBtf(..) | Drawn::Lobes(_) | Drawn::Pwt(_) | Drawn::Photographs(_) => {
                DirectionRange { light: Elevations::ALL, view: Elevations::ALL }
            }
        }
    }

    /// Scenes on which it can be drawn, the default first. Polynomial wavelet trees are drawn on a plane of their image's shape.
    pub(super) fn scenes(&self) -> Vec<ItemScene> {
        match &self.drawn {
            Drawn::Brdf(_) | Drawn::Lobes(_) => BRDF_SCENES.map(ItemScene::Builtin).to_vec(),
            Drawn::FlatBtf(..) => FLAT_BTF_SCENES.map(ItemScene::Builtin).to_vec(),
            Drawn::Pwt(pack) => vec![ItemScene::Image(pack.header().size)],
            Drawn::Photographs(them) => vec![ItemScene::Image(them.full_size.map(|side| side as u32))],
        }
    }

    /// Tiles per unit of uv on a scene, as in `brdfc render`.
    pub(super) fn repeat(&self, scene: ItemScene) -> u32 {
        match (&self.drawn, scene) {
            (Drawn::FlatBtf(..), ItemScene::Builtin(builtin)) => builtin.tiles(),
            _ => 1,
        }
    }

    /// The mesh of a scene that its relief covers; `None` if it is drawn on the mesh of the scene.
    pub(super) fn relief(&self, scene: ItemScene) -> Option<PackedMesh> {
        match (&self.drawn, scene) {
            (Drawn::FlatBtf(decoder, _), ItemScene::Builtin(builtin)) => {
                let scene = builtin.scene();
                let covered = covered(&scene, builtin.tiles(), decoder.parts().relief.outline()?);
                (covered.parts[0].mesh != scene.parts[0].mesh).then(|| PackedMesh::new(&covered.parts[0].mesh))
            }
            _ => None,
        }
    }
}

/// A scene of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ItemScene {
    /// A built-in scene of the renderer.
    Builtin(Builtin),
    /// An image of this width and height in pixels on the ground, seen from above.
    Image([u32; 2]),
}

impl ItemScene {
    /// Name of the scene.
    pub(super) fn name(self) -> String {
        match self {
            Self::Builtin(builtin) => builtin.name().to_owned(),
            Self::Image([width, height]) => format!("image {width} x {height}"),
        }
    }
}
