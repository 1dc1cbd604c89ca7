//! The two forms of relief: layers, through which rays march, and an indirection map with sampled views. The two forms of
//! reflectance.

use super::factored::FactoredFlatBtf;
use super::layers::LayerMap;
use super::shadows::ShadowMap;
use super::vdim::Vdim;
use super::vdim_header::VDIM;
use crate::FormatError;
use crate::PackKind;
use crate::flat_btf_trees::FlatTrees;

/// Relief of a flat BTF: what leads from a point of the reference plane to the parameters of the visible point, and to its
/// shadow.
#[derive(Debug, Clone, PartialEq)]
pub enum Relief {
    /// Layers of the surface, through which rays of sight and of light march.
    Layers(LayerMap),
    /// A view-dependent indirection map, and sampled shadows; without them every light above a texel's normal reaches it.
    Vdim(Vdim, Option<ShadowMap>),
}

impl Relief {
    /// An indirection map with shadows, if its header has lights.
    ///
    /// # Errors
    /// Returns an error if the number of lights differs from the header.
    pub fn sampled(map: Vdim, shadows: Option<ShadowMap>) -> Result<Self, FormatError> {
        let found = shadows.as_ref().map_or(0, |shadows| shadows.lights().len());
        if found != map.header().lights as usize {
            let allowed = format!("{found}, as the shadows have");
            return Err(FormatError::whole(format!("{VDIM} lights"), map.header().lights.to_string(), allowed));
        }
        Ok(Self::Vdim(map, shadows))
    }

    /// The layers, unless the relief is an indirection map.
    pub fn layers(&self) -> Option<&LayerMap> {
        match self {
            Self::Layers(layers) => Some(layers),
            Self::Vdim(..) => None,
        }
    }

    /// Sampled shadows, if there are any.
    pub fn shadows(&self) -> Option<&ShadowMap> {
        match self {
            Self::Vdim(_, shadows) => shadows.as_ref(),
            Self::Layers(_) => None,
        }
    }

    /// True if the relief shadows itself: rays through layers, or sampled shadows.
    pub fn casts_shadows(&self) -> bool {
        self.layers().is_some() || self.shadows().is_some()
    }

    /// Texels of the reference plane per side.
    pub fn size(&self) -> u32 {
        match self {
            Self::Layers(layers) => layers.header().size,
            Self::Vdim(map, _) => map.header().size,
        }
    }

    /// Lowest and highest height of the outline, in tiles, between which a curved mesh is drawn; `None` if the relief has no
    /// outline of its own.
    pub fn outline(&self) -> Option<[f32; 2]> {
        self.layers().map(|layers| layers.header().heights)
    }
}

impl From<LayerMap> for Relief {
    fn from(layers: LayerMap) -> Self {
        Self::Layers(layers)
    }
}

/// Reflectance of a flat BTF.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant)]
pub enum StoredReflectance {
    /// A base of each texel, and components of sampled views and lights.
    Factors(FactoredFlatBtf),
    /// Polynomial wavelet trees of sampled views.
    Trees(FlatTrees),
}

impl StoredReflectance {
    /// `T`, texels of the flat BTF per side.
    pub fn size(&self) -> u32 {
        match self {
            Self::Factors(factors) => factors.header().size,
            Self::Trees(trees) => trees.size(),
        }
    }

    /// Number of mipmap levels.
    pub fn levels(&self) -> u32 {
        match self {
            Self::Factors(factors) => factors.header().levels,
            Self::Trees(trees) => trees.levels(),
        }
    }

    /// Kind of a pack with this form.
    pub fn kind(&self) -> PackKind {
        match self {
            Self::Factors(_) => PackKind::FlatBtf,
            Self::Trees(_) => PackKind::FlatBtfTrees,
        }
    }

    /// Form in words: `brdf` without components, `factors` or `pwt`.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Factors(factors) if factors.header().groups == 0 => "brdf",
            Self::Factors(_) => "factors",
            Self::Trees(_) => "pwt",
        }
    }

    /// The base and the components, if this is their form.
    pub fn factors(&self) -> Option<&FactoredFlatBtf> {
        match self {
            Self::Factors(factors) => Some(factors),
            Self::Trees(_) => None,
        }
    }

    /// The trees, if this is their form.
    pub fn trees(&self) -> Option<&FlatTrees> {
        match self {
            Self::Factors(_) => None,
            Self::Trees(trees) => Some(trees),
        }
    }
}

impl From<FactoredFlatBtf> for StoredReflectance {
    fn from(factors: FactoredFlatBtf) -> Self {
        Self::Factors(factors)
    }
}

impl From<FlatTrees> for StoredReflectance {
    fn from(trees: FlatTrees) -> Self {
        Self::Trees(trees)
    }
}

/// Parts of one asset that a decoder reads.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfParts {
    /// Heights of the relief and its parameters, or what sampled views see of it.
    pub relief: Relief,
    /// Reflectance of the surface over its parameters.
    pub reflectance: StoredReflectance,
}

impl FlatBtfParts {
    /// Parts of an asset.
    pub fn new(relief: impl Into<Relief>, reflectance: impl Into<StoredReflectance>) -> Self {
        Self { relief: relief.into(), reflectance: reflectance.into() }
    }
}
