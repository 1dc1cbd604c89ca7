//! The scene manifest, `scene.toml`: materials, and the uses a scene makes of them.

pub use super::place::{ManifestError, line_of, near_miss};

use super::place::{Place, line_of_key};
use super::render_section::{CAMERA_KEYS, LIGHT_KEYS, RENDER_KEYS, RenderSection};
use super::scene_section::{ENVIRONMENT, SCENE_KEYS, SceneSection};
use crate::encode::options::{EncodeOptions, OptionError};
use crate::keys::keys_of;
use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A manifest as it stands in the file. See `docs/scene.md` for the meaning of each key.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What holds for the whole scene.
    #[serde(default)]
    pub scene: SceneSection,
    /// Options of materials that do not say otherwise.
    #[serde(default)]
    pub defaults: EncodeOptions,
    /// Materials by name.
    #[serde(default)]
    pub materials: BTreeMap<String, Material>,
    /// What the scene shows.
    #[serde(default)]
    pub uses: Vec<Use>,
    /// What `brdfc render` shows.
    #[serde(default)]
    pub render: RenderSection,
}

/// A material. Its keys are checked before, so that `flatten` may stand here.
#[derive(Debug, Clone, Deserialize)]
pub struct Material {
    /// A path, relative to the manifest, or a `synth:` address.
    pub source: String,
    /// How it is encoded.
    #[serde(flatten)]
    pub options: EncodeOptions,
}

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
}

const USE_KEYS: &[&str] = &["object", "material", "nearest"];
const TOP_KEYS: &[&str] = &["scene", "defaults", "materials", "uses", "render"];

impl Manifest {
    /// Parses and checks a manifest.
    ///
    /// # Errors
    /// Text that is no TOML, unknown keys (with the nearest known one), values out of range, uses of materials that
    /// are not there.
    pub fn parse(text: &str) -> Result<Self, ManifestError> {
        let syntax = |error: &toml::de::Error| ManifestError {
            line: line_of(text, error.span()),
            field: "manifest".to_owned(),
            found: error.message().to_owned(),
            allowed: "TOML as docs/scene.md describes it".to_owned(),
            suggestion: None,
        };
        let tree = toml::de::DeTable::parse(text).map_err(|e| syntax(&e))?;
        check_keys(text, tree.get_ref())?;
        let manifest: Self = toml::from_str(text).map_err(|e| syntax(&e))?;
        manifest.check(text, tree.get_ref())?;
        Ok(manifest)
    }

    fn check(&self, text: &str, tree: &toml::de::DeTable<'_>) -> Result<(), ManifestError> {
        let place = Place { text, tree };
        self.scene.check(&place)?;
        self.render.check(&place)?;
        let line = |path: &[&str]| line_of_key(text, tree, path);
        let error = |line, prefix: &str, problem: OptionError| ManifestError {
            line,
            field: format!("{prefix}.{}", problem.field),
            found: problem.found,
            allowed: problem.allowed,
            suggestion: None,
        };
        self.defaults
            .resolve(&EncodeOptions::default())
            .map_err(|p| error(line(&["defaults", p.field]), "defaults", p))?;
        for (name, material) in &self.materials {
            let prefix = format!("materials.{name}");
            // report.json is the whole build's.
            let fine = !name.is_empty()
                && !name.eq_ignore_ascii_case("report")
                && name.chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c));
            if !fine {
                return Err(ManifestError {
                    line: line(&["materials", name]),
                    field: prefix,
                    found: format!("the name \"{name}\""),
                    allowed: "letters, digits, - and _, as packs are files of that name; not \"report\"".to_owned(),
                    suggestion: None,
                });
            }
            if self.scene.environment.is_some() && name.eq_ignore_ascii_case(ENVIRONMENT) {
                let allowed = "another name: the maps of the scene's environment have this one";
                return Err(place.error(&["materials", name], format!("the name \"{name}\""), allowed));
            }
            material
                .options
                .resolve(&self.defaults)
                .map_err(|p| error(line(&["materials", name, p.field]), &prefix, p))?;
        }
        for (number, used) in self.uses.iter().enumerate() {
            let name = used.material.get_ref();
            if !self.materials.contains_key(name) {
                let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
                return Err(ManifestError {
                    line: line_of(text, Some(used.material.span())),
                    field: format!("uses[{number}].material"),
                    found: format!("\"{name}\""),
                    allowed: if known.is_empty() { "a material (there are none)".to_owned() } else { known.join(", ") },
                    suggestion: near_miss(name, &known),
                });
            }
            if let Some(nearest) = &used.nearest
                && !(nearest.get_ref().is_finite() && *nearest.get_ref() >= 0.0)
            {
                return Err(ManifestError {
                    line: line_of(text, Some(nearest.span())),
                    field: format!("uses[{number}].nearest"),
                    found: nearest.get_ref().to_string(),
                    allowed: "a distance, 0 or more".to_owned(),
                    suggestion: None,
                });
            }
        }
        Ok(())
    }
}

fn check_keys(text: &str, tree: &toml::de::DeTable<'_>) -> Result<(), ManifestError> {
    let check = |table: &toml::de::DeTable<'_>, allowed: &[&str], prefix: &str| {
        for key in table.keys() {
            let name: &str = key.get_ref();
            if !allowed.contains(&name) {
                return Err(ManifestError {
                    line: line_of(text, Some(key.span())),
                    field: if prefix.is_empty() { "key".to_owned() } else { format!("key in {prefix}") },
                    found: format!("\"{name}\""),
                    allowed: allowed.join(", "),
                    suggestion: near_miss(name, allowed),
                });
            }
        }
        Ok(())
    };
    let option_keys = keys_of::<EncodeOptions>();
    let material_keys = [&["source"], option_keys].concat();
    check(tree, TOP_KEYS, "")?;
    for (key, allowed) in [("scene", SCENE_KEYS), ("defaults", option_keys), ("render", RENDER_KEYS)] {
        if let Some(table) = tree.get(key).and_then(|v| v.get_ref().as_table()) {
            check(table, allowed, &format!("[{key}]"))?;
        }
    }
    if let Some(materials) = tree.get("materials").and_then(|v| v.get_ref().as_table()) {
        for (name, material) in materials.iter() {
            if let Some(table) = material.get_ref().as_table() {
                check(table, &material_keys, &format!("[materials.{}]", name.get_ref()))?;
            }
        }
    }
    let render = tree.get("render").and_then(|v| v.get_ref().as_table());
    if let Some(camera) = render.and_then(|r| r.get("camera")).and_then(|v| v.get_ref().as_table()) {
        check(camera, CAMERA_KEYS, "[render.camera]")?;
    }
    for (array, allowed, prefix) in [
        (tree.get("uses"), USE_KEYS, "[[uses]]"),
        (render.and_then(|r| r.get("lights")), LIGHT_KEYS, "[[render.lights]]"),
    ] {
        for entry in array.and_then(|v| v.get_ref().as_array()).into_iter().flat_map(|a| a.iter()) {
            if let Some(table) = entry.get_ref().as_table() {
                check(table, allowed, prefix)?;
            }
        }
    }
    Ok(())
}
