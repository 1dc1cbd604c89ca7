//! The `[[uses]]` tables of a manifest: objects with a material, their distances, directions and lighting.

use super::maps::TEXTURE;
use super::place::{ManifestError, line_of};
use super::shapes::{Key, Shape, key, required};
use brdfc_core::words::{format_number, one_of, quoted};
use brdfc_formats::crop::Elevations;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// One use of a material by an object.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Use {
    /// Name of the object, for messages.
    pub object: Option<String>,
    /// Name of the material.
    pub material: Spanned<String>,
    /// Nearest viewing distance. Finer levels of detail are not stored. Absent: no limit.
    pub nearest: Option<Spanned<f64>>,
    /// Farthest viewing distance. Coarser levels of table packs are not stored. Absent: no limit.
    pub farthest: Option<Spanned<f64>>,
    /// Elevations of lights above the surface, degrees, `[from, to]`. Absent: all.
    pub light_elevation: Option<Spanned<[f32; 2]>>,
    /// Elevations of viewers above the surface, degrees, `[from, to]`. Absent: all.
    pub view_elevation: Option<Spanned<[f32; 2]>>,
    /// Light sources: `points`, `environment`. Absent: points, and the environment if the scene has one.
    pub lighting: Option<Spanned<Vec<String>>>,
    /// Requested maps if an environment lights the object: `lobes`, `bandwidth`, `samples`. Absent: lobes.
    pub maps: Option<Spanned<Vec<String>>>,
    /// Image by which the material is multiplied, a PNG or JPEG that repeats. All uses of a material have the same one.
    pub texture: Option<Spanned<String>>,
    /// Width and height of the texture in metres.
    pub texture_size: Option<Spanned<[f64; 2]>>,
}

/// Keys of `[[uses]]`.
pub(super) const USE_KEYS: &[Key] = &[
    key("object", Shape::Text, ""),
    required("material", Shape::Text, "the name of a material"),
    key("nearest", Shape::Number, DISTANCES),
    key("farthest", Shape::Number, DISTANCES),
    key("light_elevation", Shape::Numbers(2), ELEVATIONS),
    key("view_elevation", Shape::Numbers(2), ELEVATIONS),
    key("lighting", Shape::Texts, "points, environment"),
    key("maps", Shape::Texts, "lobes, bandwidth, samples"),
    key(TEXTURE, Shape::Text, "a .png or .jpg"),
    key("texture_size", Shape::Numbers(2), TEXTURE_SIZES),
];
// Ranges, for messages.
const DISTANCES: &str = "a distance, 0 or more";
const ELEVATIONS: &str = "[from, to], 0 to 90 degrees above the surface, 5 apart or more";
/// Range of a texture's size, for messages.
pub(super) const TEXTURE_SIZES: &str = "[width, height] of the texture in metres, 1e-6 to 1e6";
const LIGHTING: [&str; 2] = ["points", "environment"];
const MAPS: [&str; 3] = ["lobes", "bandwidth", "samples"];
/// Requested maps by default. The others are for adaptive shading.
pub(super) const DEFAULT_MAPS: [bool; 3] = [true, false, false];
/// Smallest width of a range of elevations, degrees.
const NARROWEST: f32 = 5.0;

impl Use {
    /// A use without limits.
    pub fn of(material: Spanned<String>) -> Self {
        Self {
            object: None,
            material,
            nearest: None,
            farthest: None,
            light_elevation: None,
            view_elevation: None,
            lighting: None,
            maps: None,
            texture: None,
            texture_size: None,
        }
    }

    /// Name for messages: the object, or `uses[number]` with a number from 0.
    pub fn name(&self, number: usize) -> String {
        self.object.clone().unwrap_or_else(|| format!("uses[{number}]"))
    }

    /// Range of the elevations of lights.
    pub fn light(&self) -> Elevations {
        elevations(self.light_elevation.as_ref())
    }

    /// Range of the elevations of viewers.
    pub fn view(&self) -> Elevations {
        elevations(self.view_elevation.as_ref())
    }

    /// Returns true if point lights light the object.
    pub fn is_lit_by_points(&self) -> bool {
        self.is_lit_by(LIGHTING[0])
    }

    /// Returns true if the environment of the scene, if any, lights the object.
    pub fn is_lit_by_environment(&self) -> bool {
        self.is_lit_by(LIGHTING[1])
    }

    fn is_lit_by(&self, source: &str) -> bool {
        self.lighting.as_ref().is_none_or(|lighting| lighting.get_ref().iter().any(|kind| kind == source))
    }

    /// Requested maps: one flag each for lobes, bandwidth and samples.
    pub fn requested_maps(&self) -> [bool; 3] {
        let Some(requested) = &self.maps else { return DEFAULT_MAPS };
        MAPS.map(|map| requested.get_ref().iter().any(|name| name == map))
    }

    /// Checks ranges. `has_environment` is true if the scene has an environment.
    pub(super) fn check(&self, number: usize, text: &str, has_environment: bool) -> Result<(), ManifestError> {
        let wrong = |key: &str, span: Range<usize>, found: String, allowed: &str| {
            Err(ManifestError::new(line_of(text, Some(span)), format!("uses[{number}].{key}"), found, allowed))
        };
        for (key, distance) in [("nearest", &self.nearest), ("farthest", &self.farthest)] {
            if let Some(distance) = distance
                && !(distance.get_ref().is_finite() && *distance.get_ref() >= 0.0)
            {
                return wrong(key, distance.span(), format_number(*distance.get_ref()), DISTANCES);
            }
        }
        if let (Some(nearest), Some(farthest)) = (&self.nearest, &self.farthest)
            && farthest.get_ref() < nearest.get_ref()
        {
            let allowed = format!("at least {}, the value of nearest", format_number(*nearest.get_ref()));
            return wrong("farthest", farthest.span(), format_number(*farthest.get_ref()), &allowed);
        }
        for (key, range) in [("light_elevation", &self.light_elevation), ("view_elevation", &self.view_elevation)] {
            let Some(range) = range else { continue };
            let [from, to] = *range.get_ref();
            if !(0.0 <= from && from + NARROWEST <= to && to <= 90.0) {
                let found = format!("[{}, {}]", format_number(from), format_number(to));
                return wrong(key, range.span(), found, ELEVATIONS);
            }
        }
        for (key, list, known) in [("lighting", &self.lighting, &LIGHTING[..]), ("maps", &self.maps, &MAPS)] {
            let Some(list) = list else { continue };
            if let Some(name) = list.get_ref().iter().find(|name| !known.contains(&name.as_str())) {
                return wrong(key, list.span(), quoted(name), &one_of(known));
            }
        }
        if let Some(lighting) = &self.lighting {
            let found = || format!("{:?}", lighting.get_ref());
            if lighting.get_ref().is_empty() {
                return wrong("lighting", lighting.span(), found(), "one or both of points, environment");
            }
            if !has_environment && self.is_lit_by_environment() {
                return wrong("lighting", lighting.span(), found(), "[\"points\"], as the scene has no environment");
            }
        }
        let lit_by_environment = has_environment && self.is_lit_by_environment();
        if let (Some(range), true) = (&self.light_elevation, lit_by_environment) {
            let text = "does not apply under an environment, which lights from all directions; \
                        add lighting = [\"points\"]";
            return wrong("light_elevation", range.span(), String::new(), text);
        }
        if let (Some(maps), false) = (&self.maps, lit_by_environment) {
            let text = "needs an environment that lights the object; see scene.environment and lighting";
            return wrong("maps", maps.span(), String::new(), text);
        }
        Ok(())
    }
}

fn elevations(range: Option<&Spanned<[f32; 2]>>) -> Elevations {
    range.map_or(Elevations::ALL, |range| {
        let [from, to] = *range.get_ref();
        Elevations { from, to }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_bounds() {
        assert!(ELEVATIONS.ends_with(&format!(", {NARROWEST} apart or more")));
        let range = |name: &str| USE_KEYS.iter().find(|key| key.name == name).unwrap().range;
        assert_eq!((range("lighting"), range("maps")), (LIGHTING.join(", ").as_str(), MAPS.join(", ").as_str()));
    }
}
