//! `[[uses]]` of a manifest: what shows a material, from where and how lit.

use super::place::{ManifestError, line_of};
use super::shapes::{Key, Shape, key, required};
use brdfc_core::words::format_number;
use brdfc_formats::crop::Elevations;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;

/// One object that shows a material.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Use {
    /// A name for people.
    pub object: Option<String>,
    /// Which material.
    pub material: Spanned<String>,
    /// Nearest distance at which it is seen; finer levels of detail than that asks for are not stored. Absent: any.
    pub nearest: Option<Spanned<f64>>,
    /// Farthest distance at which it is seen; coarser levels of table packs than that asks for are not stored. Absent: any.
    pub farthest: Option<Spanned<f64>>,
    /// Elevations of lights above the surface, degrees, `[from, to]`. Absent: all.
    pub light_elevation: Option<Spanned<[f32; 2]>>,
    /// Elevations of viewers, likewise.
    pub view_elevation: Option<Spanned<[f32; 2]>>,
    /// What lights it: `points`, `environment`. Absent: points, and the environment of a scene that has one.
    pub lighting: Option<Spanned<Vec<String>>>,
    /// Which maps are wanted where an environment lights it: `bandwidth`, `samples`. Absent: both.
    pub maps: Option<Spanned<Vec<String>>>,
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
    key("maps", Shape::Texts, "bandwidth, samples"),
];
/// What is allowed, in words.
const DISTANCES: &str = "a distance, 0 or more";
const ELEVATIONS: &str = "[from, to], 0 to 90 degrees above the surface, 5 apart or more";
const LIGHTING: [&str; 2] = ["points", "environment"];
const MAPS: [&str; 2] = ["bandwidth", "samples"];
/// Elevations of a range are so far apart at least, degrees.
const NARROWEST: f32 = 5.0;

impl Use {
    /// A use of which nothing is known.
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
        }
    }

    /// What it is called: the object, or its number from 0.
    pub fn name(&self, number: usize) -> String {
        self.object.clone().unwrap_or_else(|| format!("uses[{number}]"))
    }

    /// Elevations of lights.
    pub fn light(&self) -> Elevations {
        elevations(self.light_elevation.as_ref())
    }

    /// Elevations of viewers.
    pub fn view(&self) -> Elevations {
        elevations(self.view_elevation.as_ref())
    }

    /// Whether the environment of a scene that has one lights it.
    pub fn is_lit_by_environment(&self) -> bool {
        self.lighting.as_ref().is_none_or(|lighting| lighting.get_ref().iter().any(|kind| kind == LIGHTING[1]))
    }

    /// Whether the maps of bandwidth and of samples are wanted of what an environment lights.
    pub fn wants_maps(&self) -> [bool; 2] {
        MAPS.map(|map| self.maps.as_ref().is_none_or(|wanted| wanted.get_ref().iter().any(|name| name == map)))
    }

    /// Checks ranges. `has_environment`: of the scene.
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
            let allowed = format!("{} or more, which is the nearest", format_number(*nearest.get_ref()));
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
        for (key, list, known) in [("lighting", &self.lighting, LIGHTING), ("maps", &self.maps, MAPS)] {
            let Some(list) = list else { continue };
            if let Some(name) = list.get_ref().iter().find(|name| !known.contains(&name.as_str())) {
                return wrong(key, list.span(), format!("\"{name}\""), &known.join(", "));
            }
        }
        if let Some(lighting) = &self.lighting {
            let found = || format!("{:?}", lighting.get_ref());
            if lighting.get_ref().is_empty() {
                return wrong("lighting", lighting.span(), found(), "one or both of points, environment");
            }
            if !has_environment && self.is_lit_by_environment() {
                return wrong("lighting", lighting.span(), found(), "[\"points\"]: the scene has no environment");
            }
        }
        let lit_by_environment = has_environment && self.is_lit_by_environment();
        if let (Some(range), true) = (&self.light_elevation, lit_by_environment) {
            let found = format!("{:?} under an environment", range.get_ref());
            let allowed = "it beside lighting = [\"points\"]: an environment lights from everywhere";
            return wrong("light_elevation", range.span(), found, allowed);
        }
        if let (Some(maps), false) = (&self.maps, lit_by_environment) {
            let found = format!("{:?} without an environment", maps.get_ref());
            return wrong("maps", maps.span(), found, "it where an environment lights the object");
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
    fn words_are_the_bounds() {
        assert!(ELEVATIONS.ends_with(&format!(", {NARROWEST} apart or more")));
        let range = |name: &str| USE_KEYS.iter().find(|key| key.name == name).unwrap().range;
        assert_eq!((range("lighting"), range("maps")), (LIGHTING.join(", ").as_str(), MAPS.join(", ").as_str()));
    }
}
