//! The `[scene]` table of a manifest.

use super::place::{ManifestError, Place};
use super::shapes::{Key, Shape, key};
use brdfc_core::words::format_number;
use serde::Deserialize;
use std::path::Path;

/// Name of the files of the scene's environment. No material of a scene that has one may be called so.
pub const ENVIRONMENT: &str = "environment";

/// What holds for the whole scene.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSection {
    /// A name for reports.
    pub name: Option<String>,
    /// `α` of the level of detail `l = N - clamp(log2(α d), 0, N)`, per unit of distance; 0.15 by default.
    pub distance_scale: Option<f64>,
    /// A latitude-longitude image, relative to the manifest, that lights the scene. Absent: it is lit otherwise.
    pub environment: Option<String>,
}

/// Keys of `[scene]`.
pub(super) const SCENE_KEYS: &[Key] = &[
    key("name", Shape::Text, ""),
    key("distance_scale", Shape::Number, "above 0"),
    key("environment", Shape::Text, "a file .exr or .hdr"),
];

impl SceneSection {
    /// Checks ranges.
    pub(super) fn check(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        if let Some(scale) = self.distance_scale
            && !(scale.is_finite() && scale > 0.0)
        {
            return Err(place.error(&["scene", "distance_scale"], format_number(scale), "a positive number"));
        }
        if let Some(file) = &self.environment {
            let extension = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or("");
            if !["exr", "hdr"].iter().any(|known| extension.eq_ignore_ascii_case(known)) {
                let found = format!("\"{file}\"");
                return Err(place.error(&["scene", "environment"], found, "a file .exr or .hdr"));
            }
        }
        Ok(())
    }
}
