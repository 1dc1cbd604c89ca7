//! What a page draws.

use brdfc_formats::BrdfPack;
use brdfc_formats::PackKind;
use brdfc_formats::bindings::Bindings;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_formats::flat_btf::{FlatBtfDecoder, FlatValues, SampledDirections};
use brdfc_formats::pwt::PwtPack;
use brdfc_render::scenes::Builtin;

/// Scenes of BRDFs, the first one foremost.
const OF_BRDFS: [Builtin; 4] = [Builtin::Sphere, Builtin::Cloth, Builtin::Teapot, Builtin::Plane];
/// Scenes of flat BTFs, likewise.
const OF_FLAT_BTFS: [Builtin; 4] = [Builtin::Plane, Builtin::Teapot, Builtin::Cloth, Builtin::Sphere];

/// A material of a page.
#[derive(Debug, Clone)]
pub struct ViewItem {
    /// What it is called.
    pub name: String,
    /// What is worth knowing of it, in a few words.
    pub facts: String,
    /// What is drawn.
    pub drawn: Drawn,
}

/// What is drawn.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant)]
pub enum Drawn {
    /// A pack of a BRDF.
    Brdf(BrdfPack),
    /// A flat BTF, and what blends its views and lights.
    FlatBtf(Box<FlatBtfDecoder>, Option<SampledDirections>),
    /// A polynomial wavelet tree.
    Pwt(Box<PwtPack>),
}

impl ViewItem {
    /// What decodes it.
    pub fn decoder(&self) -> PackKind {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.kind(),
            Drawn::FlatBtf(..) => PackKind::FlatBtf,
            Drawn::Pwt(_) => PackKind::Pwt,
        }
    }

    /// What is bound for it.
    pub fn bindings(&self) -> Bindings<'_> {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.bindings(),
            Drawn::FlatBtf(decoder, directions) => decoder.bindings(true, directions.as_ref()),
            Drawn::Pwt(pack) => pack.bindings(),
        }
    }

    /// Bytes of its textures on a GPU.
    pub fn gpu_bytes(&self) -> u64 {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.gpu_bytes(),
            Drawn::FlatBtf(decoder, _) => decoder.parts().gpu_bytes(),
            Drawn::Pwt(pack) => pack.gpu_bytes(),
        }
    }

    /// How much coarser than the finest it can be, and which level the finest is.
    pub(super) fn levels(&self) -> (u32, u32) {
        let of_mipmaps = |levels: u32| (levels.saturating_sub(1), 0);
        match &self.drawn {
            Drawn::Brdf(pack) => (pack.levels(), pack.levels()),
            Drawn::FlatBtf(decoder, _) => match &decoder.parts().values {
                FlatValues::Factored(asset) => of_mipmaps(asset.weights().levels()),
                FlatValues::Views(_) | FlatValues::None => (0, 0),
            },
            Drawn::Pwt(pack) => {
                let textures = pack.header().textures.len();
                of_mipmaps((0..textures).map(|index| pack.levels_of(index)).max().unwrap_or(1))
            }
        }
    }

    /// Directions that it is for.
    pub(super) fn directions(&self) -> DirectionRange {
        match &self.drawn {
            Drawn::Brdf(pack) => pack.directions(),
            Drawn::FlatBtf(..) | Drawn::Pwt(_) => DirectionRange { light: Elevations::ALL, view: Elevations::ALL },
        }
    }

    /// Scenes that it goes onto, the first one foremost; a rendering goes onto a plane of its own shape.
    pub(super) fn scenes(&self) -> Vec<ItemScene> {
        match &self.drawn {
            Drawn::Brdf(_) => OF_BRDFS.map(ItemScene::Builtin).to_vec(),
            Drawn::FlatBtf(..) => OF_FLAT_BTFS.map(ItemScene::Builtin).to_vec(),
            Drawn::Pwt(pack) => vec![ItemScene::Rendering(pack.header().size)],
        }
    }

    /// Tiles per unit of uv on a scene: as `brdfc render` has them.
    pub(super) fn repeat(&self, scene: ItemScene) -> u32 {
        match (&self.drawn, scene) {
            (Drawn::FlatBtf(..), ItemScene::Builtin(builtin)) => builtin.tiles(),
            _ => 1,
        }
    }
}

/// A scene of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ItemScene {
    /// One of the renderer's.
    Builtin(Builtin),
    /// A rendering of so many pixels on the ground, seen from above.
    Rendering([u32; 2]),
}

impl ItemScene {
    /// What it is called.
    pub(super) fn name(self) -> String {
        match self {
            Self::Builtin(builtin) => builtin.name().to_owned(),
            Self::Rendering([width, height]) => format!("rendering {width} x {height}"),
        }
    }
}
