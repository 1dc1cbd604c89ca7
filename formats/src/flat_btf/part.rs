//! The parts of a flat BTF, and how their files are named: `NAME.PART.ktx2`.

/// One file of a flat BTF.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FlatPart {
    /// The surface point of each texel.
    Position,
    /// Shading normals.
    Normal,
    /// Parameters of what is seen through each texel of the reference plane.
    Reference,
    /// Reflectance of a Lambertian surface.
    Diffuse,
    /// Which texels are seen in which view.
    Mask,
    /// The view-dependent indirection map.
    Indirection,
    /// The same in fewer bytes.
    Displacement,
    /// The values of one view, for all lights.
    View,
    /// What blends the sampled views and lights.
    Directions,
    /// Of a factored flat BTF: the components in each view under each light.
    Basis,
    /// The weights of the components.
    Weights,
    /// How much of each light arrives.
    Shadow,
}

/// What the name of every part's file ends with.
pub const PART_EXTENSION: &str = ".ktx2";
/// What the name of the part of a view begins with; a point and its number follow.
const VIEW: &str = "flat";

impl FlatPart {
    /// The parts that stand once in an asset.
    pub const SINGLE: [Self; 11] = [
        Self::Position,
        Self::Normal,
        Self::Reference,
        Self::Diffuse,
        Self::Mask,
        Self::Indirection,
        Self::Displacement,
        Self::Directions,
        Self::Basis,
        Self::Weights,
        Self::Shadow,
    ];

    /// The name of the part; of views what stands before their number.
    pub fn name(self) -> &'static str {
        match self {
            Self::Position => "position",
            Self::Normal => "normal",
            Self::Reference => "reference",
            Self::Diffuse => "diffuse",
            Self::Mask => "mask",
            Self::Indirection => "indirection",
            Self::Displacement => "displacement",
            Self::View => VIEW,
            Self::Directions => "directions",
            Self::Basis => "basis",
            Self::Weights => "weights",
            Self::Shadow => "shadow",
        }
    }

    /// The part of a name such as `diffuse` or `flat.003`.
    pub fn from_name(name: &str) -> Option<Self> {
        let is_view = || name.split_once('.').is_some_and(|(view, number)| view == VIEW && is_view_number(number));
        Self::SINGLE.into_iter().find(|part| part.name() == name).or_else(|| is_view().then_some(Self::View))
    }

    /// Whether every asset has it, whatever its form.
    pub fn is_in_every_asset(self) -> bool {
        matches!(self, Self::Position | Self::Normal | Self::Reference | Self::Diffuse | Self::Mask)
    }

    /// Whether a shader reads it: the others are there for tools.
    pub fn is_drawn(self) -> bool {
        !matches!(self, Self::Position | Self::Mask)
    }
}

/// Asset, part and the part's name of a file `NAME.PART.ktx2`: of `knit.blue.flat.003.ktx2` these are `knit.blue`, a view
/// and `flat.003`.
pub fn split_part_name(file: &str) -> Option<(&str, FlatPart, &str)> {
    let stem = file.strip_suffix(PART_EXTENSION)?;
    let (asset, last) = stem.rsplit_once('.')?;
    if let Some(part) = FlatPart::SINGLE.into_iter().find(|part| part.name() == last) {
        return Some((asset, part, last));
    }
    let asset = asset.strip_suffix(VIEW)?.strip_suffix('.').filter(|_| is_view_number(last))?;
    Some((asset, FlatPart::View, &stem[asset.len() + 1..]))
}

fn is_view_number(text: &str) -> bool {
    text.len() >= 3 && text.bytes().all(|digit| digit.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_files() {
        for (file, expected) in [
            ("knit.diffuse.ktx2", Some(("knit", FlatPart::Diffuse, "diffuse"))),
            ("knit.blue.flat.003.ktx2", Some(("knit.blue", FlatPart::View, "flat.003"))),
            ("knit.shadow.ktx2", Some(("knit", FlatPart::Shadow, "shadow"))),
            ("a.flat.1000.ktx2", Some(("a", FlatPart::View, "flat.1000"))),
            ("knit.flat.03.ktx2", None),
            ("knit.flat.ktx2", None),
            ("flat.003.ktx2", None),
            ("diffuse.ktx2", None),
            ("knit.diffuse.png", None),
            ("knit.brdf.ktx2", None),
        ] {
            assert_eq!(split_part_name(file), expected, "{file}");
        }
        for name in ["position", "flat.000", "flat.1234"] {
            assert!(FlatPart::from_name(name).is_some(), "{name}");
        }
        for name in ["flat", "flat.x", "samples", "flat.001.2"] {
            assert_eq!(FlatPart::from_name(name), None, "{name}");
        }
    }
}
