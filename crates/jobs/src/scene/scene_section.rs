//! The `[scene]` table of a manifest.

use super::place::{ManifestError, Place};
use super::shapes::{Key, Shape, key};
use brdfc_core::words::{format_number, quoted};
use serde::Deserialize;
use std::path::Path;

/// Name of the files of the scene's environment, reserved in scenes that have one.
pub const ENVIRONMENT: &str = "environment";

/// Kinds of environments, for messages.
pub(crate) const ENVIRONMENTS: &str = "an .exr, .hdr or .ktx2 file";

/// Returns true if a file has the extension of an environment.
pub(crate) fn is_environment(file: &str) -> bool {
    let extension = Path::new(file).extension().and_then(|e| e.to_str()).unwrap_or("");
    ["exr", "hdr", "ktx2"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// Settings of the whole scene.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SceneSection {
    /// Name of the scene in reports.
    pub name: Option<String>,
    /// `α` of the level of detail `l = N - clamp(log2(α d), 0, N)`, per unit of distance; 0.15 by default.
    pub distance_scale: Option<f64>,
    /// Path, relative to the manifest, of a latitude-longitude image, a cube map or a prefiltered environment that lights
    /// the scene. Absent: no environment lights it.
    pub environment: Option<String>,
}

/// Keys of `[scene]`.
pub(super) const SCENE_KEYS: &[Key] = &[
    key("name", Shape::Text, ""),
    key("distance_scale", Shape::Number, "above 0"),
    key("environment", Shape::Text, ENVIRONMENTS),
];

impl SceneSection {
    /// Checks ranges.
    pub(super) fn check(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        if let Some(scale) = self.distance_scale
            && !(scale.is_finite() && scale > 0.0)
        {
            return Err(place.error(&["scene", "distance_scale"], format_number(scale), "a positive number"));
        }
        if let Some(file) = self.environment.as_ref().filter(|file| !is_environment(file)) {
            return Err(place.error(&["scene", "environment"], quoted(file), ENVIRONMENTS));
        }
        Ok(())
    }
}
