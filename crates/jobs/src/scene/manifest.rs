//! The scene manifest, `scene.toml`: materials, and the uses a scene makes of them.

pub use super::place::{ManifestError, line_of, near_miss};
pub use super::uses::Use;

use super::gates::Require;
use super::names::{check_name, same_but_for_case};
use super::place::{Place, key_at, line_of_key, snippet};
use super::render_section::{CAMERA_KEYS, LIGHT_KEYS, RENDER_KEYS, RenderSection};
use super::scene_section::{SCENE_KEYS, SceneSection};
use super::uses::USE_KEYS;
use crate::encode::options::{EncodeOptions, OptionError};
use crate::keys::keys_of;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ffi::OsString;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

/// A manifest as it stands in the file. See `docs/scene.md` for the meaning of each key.
#[derive(Debug, Clone, Default)]
pub struct Manifest {
    /// What holds for the whole scene.
    pub scene: SceneSection,
    /// What holds for materials that do not say otherwise.
    pub defaults: Defaults,
    /// Materials by name.
    pub materials: BTreeMap<String, Material>,
    /// What the scene shows.
    pub uses: Vec<Use>,
    /// What `brdfc render` shows.
    pub render: RenderSection,
}

/// The table `defaults`.
#[derive(Debug, Clone, Default)]
pub struct Defaults {
    /// How materials are encoded.
    pub options: EncodeOptions,
    /// What finished packs have to be.
    pub require: Require,
}

/// A material.
#[derive(Debug, Clone, Default)]
pub struct Material {
    /// A path or a pattern, relative to the manifest, or a `synth:` address.
    pub source: OsString,
    /// How it is encoded.
    pub options: EncodeOptions,
    /// What its finished pack has to be.
    pub require: Require,
}

/// The tables whose keys are those of one type.
#[derive(Default, Deserialize)]
struct PlainTables {
    #[serde(default)]
    scene: SceneSection,
    #[serde(default)]
    uses: Vec<Use>,
    #[serde(default)]
    render: RenderSection,
}

const TOP_KEYS: &[&str] = &["scene", "defaults", "materials", "uses", "render"];

impl Manifest {
    /// Parses and checks a manifest.
    ///
    /// # Errors
    /// Text that is no TOML, unknown keys (with the nearest known one), values out of range, uses of materials that
    /// are not there.
    pub fn parse(text: &str) -> Result<Self, ManifestError> {
        let tree = DeTable::parse(text).map_err(|error| ManifestError {
            line: line_of(text, error.span()),
            field: "manifest".to_owned(),
            found: format!("{} in \"{}\"", error.message(), snippet(text, error.span())),
            allowed: "TOML as docs/scene.md describes it".to_owned(),
            suggestion: None,
        })?;
        check_keys(text, tree.get_ref())?;
        let manifest = Self::read(tree.clone()).map_err(|error| ManifestError {
            line: line_of(text, error.span()),
            field: key_at(tree.get_ref(), error.span()).unwrap_or_else(|| "manifest".to_owned()),
            found: in_words(error.message()),
            allowed: "what docs/scene.md describes".to_owned(),
            suggestion: None,
        })?;
        manifest.check(text, tree.get_ref())?;
        Ok(manifest)
    }

    /// Table by table, so that errors know where they are.
    fn read(mut tree: Spanned<DeTable<'_>>) -> Result<Self, toml::de::Error> {
        let root = tree.get_mut();
        let (defaults, materials) = (root.remove("defaults"), root.remove("materials"));
        let mut manifest = Self::default();
        if let Some(table) = defaults {
            let (_, options, require) = with_options(table)?;
            manifest.defaults = Defaults { options, require };
        }
        if let Some(tables) = materials {
            let span = tables.span();
            let tables: BTreeMap<String, Spanned<DeValue<'_>>> = match tables.into_inner() {
                DeValue::Table(tables) => tables.into_iter().map(|(k, v)| (k.into_inner().into_owned(), v)).collect(),
                other => return Err(wrong_type(Spanned::new(span, other))),
            };
            for (name, table) in tables {
                let (source, options, require) = with_options(table)?;
                manifest.materials.insert(name, Material { source: source.into(), options, require });
            }
        }
        let PlainTables { scene, uses, render } = PlainTables::deserialize(Deserializer::from(tree))?;
        Ok(Self { scene, uses, render, ..manifest })
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
        let (options, require) = (&self.defaults.options, &self.defaults.require);
        options.resolve(&EncodeOptions::default()).map_err(|p| error(line(&["defaults", p.field]), "defaults", p))?;
        require
            .resolve(&Require::default())
            .map_err(|p| error(line(&["defaults", "require", p.field]), "defaults.require", p))?;
        if let Some((first, second)) = same_but_for_case(self.materials.keys().map(String::as_str)) {
            let found = format!("the names \"{first}\" and \"{second}\"");
            let allowed = "names that differ in more than case: on some systems both are one file";
            return Err(place.error(&["materials", second], found, allowed));
        }
        for (name, material) in &self.materials {
            let prefix = format!("materials.{name}");
            if let Err(allowed) = check_name(name, self.scene.environment.is_some()) {
                return Err(place.error(&["materials", name], format!("the name \"{name}\""), &allowed));
            }
            if material.source.is_empty() {
                let allowed = "source = \"...\", a file, a pattern or a synth: address";
                return Err(place.error(&["materials", name], "no source".to_owned(), allowed));
            }
            material.options.resolve(options).map_err(|p| error(line(&["materials", name, p.field]), &prefix, p))?;
            let in_require = format!("{prefix}.require");
            material
                .require
                .resolve(require)
                .map_err(|p| error(line(&["materials", name, "require", p.field]), &in_require, p))?;
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
            used.check(number, text, self.scene.environment.is_some())?;
        }
        Ok(())
    }
}

/// A message in which types have the names that people give them.
fn in_words(message: &str) -> String {
    let (found, expected) = message.rsplit_once(", expected ").unwrap_or((message, ""));
    let expected = match expected {
        "" => return message.to_owned(),
        "f64" | "f32" => "a number",
        "u32" | "u64" | "usize" => "a whole number, 0 or more",
        other => other,
    };
    format!("{found}, expected {expected}")
}

/// A table of options with what else stands in it: `source` and the table `require`.
fn with_options(table: Spanned<DeValue<'_>>) -> Result<(String, EncodeOptions, Require), toml::de::Error> {
    let span = table.span();
    let mut table = match table.into_inner() {
        DeValue::Table(table) => table,
        other => return Err(wrong_type(Spanned::new(span, other))),
    };
    let source = table.remove("source").map(one::<String>).transpose()?.unwrap_or_default();
    let require = table.remove("require").map(one::<Require>).transpose()?.unwrap_or_default();
    let options = EncodeOptions::deserialize(Deserializer::from(Spanned::new(span, table)))?;
    Ok((source, options, require))
}

fn one<T: DeserializeOwned>(value: Spanned<DeValue<'_>>) -> Result<T, toml::de::Error> {
    T::deserialize(toml::de::ValueDeserializer::from(value))
}

/// The error of a value that should be a table.
fn wrong_type(value: Spanned<DeValue<'_>>) -> toml::de::Error {
    one::<BTreeMap<String, toml::Value>>(value).expect_err("it is no table")
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
    let default_keys = [option_keys, &["require"]].concat();
    let material_keys = [&["source"], &default_keys[..]].concat();
    let require_keys = keys_of::<Require>();
    check(tree, TOP_KEYS, "")?;
    for (key, allowed) in [("scene", SCENE_KEYS), ("defaults", &default_keys), ("render", RENDER_KEYS)] {
        if let Some(table) = tree.get(key).and_then(|v| v.get_ref().as_table()) {
            check(table, allowed, &format!("[{key}]"))?;
        }
    }
    let check_require = |table: &toml::de::DeTable<'_>, prefix: &str| {
        let require = table.get("require").and_then(|v| v.get_ref().as_table());
        require.map_or(Ok(()), |table| check(table, require_keys, &format!("[{prefix}.require]")))
    };
    if let Some(table) = tree.get("defaults").and_then(|v| v.get_ref().as_table()) {
        check_require(table, "defaults")?;
    }
    if let Some(materials) = tree.get("materials").and_then(|v| v.get_ref().as_table()) {
        for (name, material) in materials.iter() {
            if let Some(table) = material.get_ref().as_table() {
                let prefix = format!("materials.{}", name.get_ref());
                check(table, &material_keys, &format!("[{prefix}]"))?;
                check_require(table, &prefix)?;
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
