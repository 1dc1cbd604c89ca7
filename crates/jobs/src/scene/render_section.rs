//! The `[render]` table of a manifest: what `brdfc render` shows. Names of scenes and parts are the renderer's and are
//! checked there.

use super::place::{ManifestError, Place};
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// Pixels per side at most.
pub const MAX_SIDE: usize = 8192;
/// Samples per pixel and axis at most.
pub const MAX_SAMPLES: usize = 16;

/// What is drawn, and how. What is absent is the scene's own default.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderSection {
    /// Which built-in scene.
    pub scene: Option<Spanned<String>>,
    /// Pixels per row.
    pub width: Option<usize>,
    /// Rows.
    pub height: Option<usize>,
    /// Samples per pixel and axis.
    pub samples: Option<usize>,
    /// Factor from radiance to the display's range.
    pub exposure: Option<f64>,
    /// A latitude-longitude EXR file, relative to the manifest, that mirrors show.
    pub environment: Option<String>,
    /// From where.
    #[serde(default)]
    pub camera: CameraSection,
    /// Point lights; they replace the scene's own.
    pub lights: Option<Vec<LightSection>>,
    /// Material of each part of the scene.
    #[serde(default)]
    pub materials: BTreeMap<Spanned<String>, Spanned<String>>,
}

/// A pinhole camera.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSection {
    /// Where it is.
    pub eye: Option<[f64; 3]>,
    /// What it looks at.
    pub target: Option<[f64; 3]>,
    /// Which way is up.
    pub up: Option<[f64; 3]>,
    /// Vertical angle of view, degrees.
    pub field_of_view: Option<f64>,
}

/// A point light.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSection {
    /// Where it is.
    pub position: [f64; 3],
    /// Radiant intensity, W/sr, linear RGB or grey.
    pub intensity: Intensity,
}

/// One number for all channels, or three.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged, expecting = "a number or three numbers")]
pub enum Intensity {
    /// The same in all channels.
    Grey(f64),
    /// Linear RGB.
    Colour([f64; 3]),
}

impl Intensity {
    /// Linear RGB.
    pub fn colour(self) -> [f64; 3] {
        match self {
            Self::Grey(value) => [value; 3],
            Self::Colour(colour) => colour,
        }
    }
}

/// Keys of `[render]`.
pub(super) const RENDER_KEYS: &[&str] =
    &["scene", "width", "height", "samples", "exposure", "environment", "camera", "lights", "materials"];
/// Keys of `[render.camera]`.
pub(super) const CAMERA_KEYS: &[&str] = &["eye", "target", "up", "field_of_view"];
/// Keys of `[[render.lights]]`.
pub(super) const LIGHT_KEYS: &[&str] = &["position", "intensity"];

impl RenderSection {
    /// Checks ranges.
    pub(super) fn check(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        let wrong = |path: &[&str], found: String, allowed: &str| Err(place.error(path, found, allowed));
        for (key, value, most) in
            [("width", self.width, MAX_SIDE), ("height", self.height, MAX_SIDE), ("samples", self.samples, MAX_SAMPLES)]
        {
            if let Some(value) = value
                && !(1..=most).contains(&value)
            {
                return wrong(&["render", key], value.to_string(), &format!("1 to {most}"));
            }
        }
        if let Some(exposure) = self.exposure
            && !(exposure.is_finite() && exposure > 0.0)
        {
            return wrong(&["render", "exposure"], exposure.to_string(), "a positive number");
        }
        let camera = &self.camera;
        for (key, vector) in [("eye", camera.eye), ("target", camera.target), ("up", camera.up)] {
            if let Some(vector) = vector
                && vector.iter().any(|c| !c.is_finite())
            {
                return wrong(&["render", "camera", key], format!("{vector:?}"), "three finite numbers");
            }
        }
        if let Some(angle) = camera.field_of_view
            && !(1.0..=170.0).contains(&angle)
        {
            return wrong(&["render", "camera", "field_of_view"], angle.to_string(), "1 to 170 degrees");
        }
        for light in self.lights.iter().flatten() {
            let intensity = light.intensity.colour();
            if light.position.iter().chain(&intensity).any(|c| !c.is_finite()) || intensity.iter().any(|c| *c < 0.0) {
                let found = format!("position {:?}, intensity {intensity:?}", light.position);
                return wrong(&["render", "lights"], found, "finite positions, intensities of 0 or more");
            }
        }
        Ok(())
    }
}
