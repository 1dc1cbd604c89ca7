//! The `[render]` table of a manifest: settings of `brdfc render`. The renderer checks the names of scenes and parts.

use super::place::{ManifestError, Place};
use super::scene_section::ENVIRONMENTS;
use super::shapes::{Key, Shape, key, required};
use brdfc_core::words::format_number;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::BTreeMap;
use toml::Spanned;

/// Largest width and height, pixels.
pub const MAX_SIDE: usize = 8192;
/// Largest number of samples per pixel and axis.
pub const MAX_SAMPLES: usize = 16;

/// Settings of a rendering. Absent values are the defaults of the built-in scene.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RenderSection {
    /// Name of the built-in scene.
    pub scene: Option<Spanned<String>>,
    /// Width of the rendering, pixels.
    pub width: Option<usize>,
    /// Height of the rendering, pixels.
    pub height: Option<usize>,
    /// Samples per pixel and axis.
    pub samples: Option<usize>,
    /// Factor from radiance to the range of the display.
    pub exposure: Option<f64>,
    /// Path, relative to the manifest, of a flat BTF or the pack of an RTI capture that covers all parts instead of
    /// materials.
    pub asset: Option<String>,
    /// Path, relative to the manifest, of a latitude-longitude image, a cube map or a prefiltered environment that mirrors
    /// reflect.
    pub environment: Option<String>,
    /// Camera; absent values come from the built-in scene.
    #[serde(default)]
    pub camera: CameraSection,
    /// Point lights, which replace those of the built-in scene.
    pub lights: Option<Vec<LightSection>>,
    /// Material of each part of the scene.
    #[serde(default)]
    pub materials: BTreeMap<Spanned<String>, Spanned<String>>,
}

/// A pinhole camera, in the world space of the scene.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSection {
    /// Position of the pinhole.
    pub eye: Option<[f64; 3]>,
    /// Point in the centre of the rendering.
    pub target: Option<[f64; 3]>,
    /// Up direction in the rendering.
    pub up: Option<[f64; 3]>,
    /// Vertical angle of view, degrees.
    pub field_of_view: Option<f64>,
}

/// A point light, which shines equally in all directions.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LightSection {
    /// Position in world space.
    pub position: [f64; 3],
    /// Radiant intensity, W/sr, linear RGB or grey.
    pub intensity: Intensity,
}

/// One number for all channels, or three.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
pub enum Intensity {
    /// The same in all channels.
    Grey(f64),
    /// One number for each channel, linear RGB.
    Colour([f64; 3]),
}

impl Intensity {
    /// Intensity per channel, linear RGB.
    pub fn colour(self) -> [f64; 3] {
        match self {
            Self::Grey(value) => [value; 3],
            Self::Colour(colour) => colour,
        }
    }
}

/// Keys of `[render]`.
pub(super) const RENDER_KEYS: &[Key] = &[
    key("scene", Shape::Text, "the name of a built-in scene"),
    key("width", Shape::WholeNumber, SIDES),
    key("height", Shape::WholeNumber, SIDES),
    key("samples", Shape::WholeNumber, SAMPLES),
    key("exposure", Shape::Number, "above 0"),
    key("asset", Shape::Text, ASSETS),
    key("environment", Shape::Text, ENVIRONMENTS),
    key("camera", Shape::Table(Cow::Borrowed(CAMERA_KEYS)), ""),
    key("lights", Shape::Tables(LIGHT_KEYS), ""),
    key("materials", Shape::NamedTexts, "part = \"material\""),
];
const CAMERA_KEYS: &[Key] = &[
    key("eye", Shape::Numbers(3), "[x, y, z]"),
    key("target", Shape::Numbers(3), "[x, y, z]"),
    key("up", Shape::Numbers(3), "[x, y, z]"),
    key("field_of_view", Shape::Number, ANGLES),
];
const LIGHT_KEYS: &[Key] = &[
    required("position", Shape::Numbers(3), "[x, y, z]"),
    required("intensity", Shape::NumberOrThree, "W/sr, grey or [r, g, b], 0 or more"),
];
// Ranges, for messages.
const SIDES: &str = "1 to 8192";
const SAMPLES: &str = "1 to 16";
const ANGLES: &str = "1 to 170 degrees";
const ASSETS: &str = "the folder or the .json of a flat BTF, or the pack of an RTI capture";

impl RenderSection {
    /// Checks ranges.
    pub(super) fn check(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        let wrong = |path: &[&str], found: String, allowed: &str| Err(place.error(path, found, allowed));
        for (key, value, most, allowed) in [
            ("width", self.width, MAX_SIDE, SIDES),
            ("height", self.height, MAX_SIDE, SIDES),
            ("samples", self.samples, MAX_SAMPLES, SAMPLES),
        ] {
            if let Some(value) = value
                && !(1..=most).contains(&value)
            {
                return wrong(&["render", key], value.to_string(), allowed);
            }
        }
        if let Some(exposure) = self.exposure
            && !(exposure.is_finite() && exposure > 0.0)
        {
            return wrong(&["render", "exposure"], format_number(exposure), "a positive number");
        }
        if self.asset.as_ref().is_some_and(String::is_empty) {
            return wrong(&["render", "asset"], "\"\"".to_owned(), ASSETS);
        }
        if let Some((part, _)) = self.materials.first_key_value().filter(|_| self.asset.is_some()) {
            let text = format!("{} does not apply with render.asset, which covers all parts", part.get_ref());
            return wrong(&["render", "materials"], String::new(), &text);
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
            return wrong(&["render", "camera", "field_of_view"], format_number(angle), ANGLES);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_have_the_bounds() {
        assert_eq!((SIDES, SAMPLES), (format!("1 to {MAX_SIDE}").as_str(), format!("1 to {MAX_SAMPLES}").as_str()));
    }
}
