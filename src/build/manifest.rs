//! The scene manifest, `scene.toml`: materials, and the uses a scene makes of them.

use super::needs::ENVIRONMENT;
use super::render_section::{CAMERA_KEYS, LIGHT_KEYS, RENDER_KEYS, RenderSection};
use super::scene_section::{SCENE_KEYS, Scene};
use crate::brdf::encode::{Ranking, Recipe, Target};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::pack::wavelet::MAX_LEVELS;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::ops::Range;
use toml::Spanned;

/// A manifest as it stands in the file. See `docs/scene.md` for the meaning of each key.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// What holds for the whole scene.
    #[serde(default)]
    pub scene: Scene,
    /// Options of materials that do not say otherwise.
    #[serde(default)]
    pub defaults: Options,
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
    pub options: Options,
}

/// Options of an encoding; what is absent is left open.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// Cells per axis and hemisphere.
    pub grid: Option<usize>,
    /// Bits per component.
    pub bits: Option<u32>,
    /// Parameterisation by name.
    pub parameterisation: Option<String>,
    /// Compression ratio.
    pub ratio: Option<f64>,
    /// Error budget: `ε_r` on the grid, a fraction.
    pub max_error: Option<f64>,
    /// Byte budget on a GPU.
    pub max_bytes: Option<u64>,
    /// Whether the table is smoothed.
    pub smooth: Option<bool>,
    /// `ε` of the log encoding.
    pub bias: Option<f64>,
    /// Which slices are kept, by name.
    pub ranking: Option<String>,
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

/// A manifest that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, {field}: found {found}; allowed {allowed}{}", suggestion.as_ref().map_or(String::new(), |s| format!(" (did you mean {s}?)")))]
pub struct ManifestError {
    /// Line, from 1.
    pub line: usize,
    /// Key, with the tables it is in.
    pub field: String,
    /// What stands there.
    pub found: String,
    /// What may stand there.
    pub allowed: String,
    /// A near miss.
    pub suggestion: Option<String>,
}

const OPTION_KEYS: &[&str] =
    &["grid", "bits", "parameterisation", "ratio", "max_error", "max_bytes", "smooth", "bias", "ranking"];
const MATERIAL_KEYS: &[&str] =
    &["source", "grid", "bits", "parameterisation", "ratio", "max_error", "max_bytes", "smooth", "bias", "ranking"];
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
        self.defaults.resolve(&Options::default()).map_err(|p| error(line(&["defaults", p.field]), "defaults", p))?;
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

/// Where keys of a manifest stand.
pub(super) struct Place<'a> {
    text: &'a str,
    tree: &'a toml::de::DeTable<'a>,
}

impl Place<'_> {
    /// An error at the deepest key of `path` that is there.
    pub(super) fn error(&self, path: &[&str], found: String, allowed: &str) -> ManifestError {
        ManifestError {
            line: line_of_key(self.text, self.tree, path),
            field: path.join("."),
            found,
            allowed: allowed.to_owned(),
            suggestion: None,
        }
    }
}

/// An option out of range.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{field}: found {found}; allowed {allowed}")]
pub struct OptionError {
    /// Which.
    pub field: &'static str,
    /// What it is.
    pub found: String,
    /// What it may be.
    pub allowed: String,
}

impl Options {
    /// The recipe of these options; what they leave open comes from `defaults`, then from [`Recipe::default`].
    ///
    /// # Errors
    /// Values out of range; more than one of ratio, error and byte budget.
    pub fn resolve(&self, defaults: &Self) -> Result<Recipe, OptionError> {
        let problem = |field, found: String, allowed: &str| OptionError { field, found, allowed: allowed.to_owned() };
        let mut recipe = Recipe::default();
        if let Some(grid) = self.grid.or(defaults.grid) {
            if !grid.is_power_of_two() || !(2..=1 << MAX_LEVELS).contains(&grid) {
                return Err(problem("grid", grid.to_string(), "2, 4, 8, 16, 32 or 64"));
            }
            recipe.levels = grid.ilog2();
            recipe.stored_levels = recipe.levels;
        }
        if let Some(bits) = self.bits.or(defaults.bits) {
            if bits != 8 && !(10..=16).contains(&bits) {
                return Err(problem("bits", bits.to_string(), "8, or 10 to 16"));
            }
            recipe.bits = bits;
        }
        if let Some(name) = self.parameterisation.as_ref().or(defaults.parameterisation.as_ref()) {
            let known = Parameterisation::NAMES.map(|(name, _)| name);
            if !known.contains(&name.as_str()) {
                return Err(problem("parameterisation", format!("\"{name}\""), &known.join(" or ")));
            }
            recipe.parameterisation.clone_from(name);
        }
        if let Some(smooth) = self.smooth.or(defaults.smooth) {
            recipe.smooth = smooth;
        }
        if let Some(bias) = self.bias.or(defaults.bias) {
            if !(1e-6..=1.0).contains(&bias) {
                return Err(problem("bias", bias.to_string(), "1e-6 to 1"));
            }
            recipe.bias = bias;
        }
        if let Some(name) = self.ranking.as_ref().or(defaults.ranking.as_ref()) {
            let known = Ranking::NAMES.into_iter().find(|(text, _)| text == name);
            let Some((_, ranking)) = known else {
                return Err(problem(
                    "ranking",
                    format!("\"{name}\""),
                    &Ranking::NAMES.map(|(name, _)| name).join(" or "),
                ));
            };
            recipe.ranking = ranking;
        }
        if let Some(target) = self.target()?.or(defaults.target()?) {
            recipe.target = target;
        }
        Ok(recipe)
    }

    fn target(&self) -> Result<Option<Target>, OptionError> {
        let problem = |field, found: String, allowed: &str| OptionError { field, found, allowed: allowed.to_owned() };
        let given = [self.ratio.is_some(), self.max_error.is_some(), self.max_bytes.is_some()];
        if given.iter().filter(|g| **g).count() > 1 {
            return Err(problem(
                if self.ratio.is_some() { "ratio" } else { "max_error" },
                "more than one target".to_owned(),
                "one of ratio, max_error and max_bytes",
            ));
        }
        if let Some(ratio) = self.ratio {
            if !(1.0..=4096.0).contains(&ratio) {
                return Err(problem("ratio", ratio.to_string(), "1 to 4096"));
            }
            return Ok(Some(Target::Ratio(ratio)));
        }
        if let Some(error) = self.max_error {
            if !(error > 0.0 && error.is_finite()) {
                return Err(problem("max_error", error.to_string(), "a positive fraction, such as 0.02 for 2 %"));
            }
            return Ok(Some(Target::MaxError(error)));
        }
        if self.max_bytes == Some(0) {
            return Err(problem("max_bytes", "0".to_owned(), "1 or more"));
        }
        Ok(self.max_bytes.map(Target::MaxBytes))
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
    check(tree, TOP_KEYS, "")?;
    for (key, allowed) in [("scene", SCENE_KEYS), ("defaults", OPTION_KEYS), ("render", RENDER_KEYS)] {
        if let Some(table) = tree.get(key).and_then(|v| v.get_ref().as_table()) {
            check(table, allowed, &format!("[{key}]"))?;
        }
    }
    if let Some(materials) = tree.get("materials").and_then(|v| v.get_ref().as_table()) {
        for (name, material) in materials.iter() {
            if let Some(table) = material.get_ref().as_table() {
                check(table, MATERIAL_KEYS, &format!("[materials.{}]", name.get_ref()))?;
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

/// The known name that is most like `name`, if any is.
pub fn near_miss(name: &str, known: &[&str]) -> Option<String> {
    known
        .iter()
        .map(|k| (strsim::damerau_levenshtein(name, k), *k))
        .filter(|(distance, k)| *distance <= 1 + k.len() / 4)
        .min()
        .map(|(_, k)| k.to_owned())
}

/// The line, from 1, where a span of a manifest starts.
pub fn line_of(text: &str, span: Option<Range<usize>>) -> usize {
    let end = span.map_or(0, |s| s.start.min(text.len()));
    1 + text.as_bytes()[..end].iter().filter(|byte| **byte == b'\n').count()
}

/// Line of the deepest key of `path` that is there.
fn line_of_key(text: &str, tree: &toml::de::DeTable<'_>, path: &[&str]) -> usize {
    let mut line = 1;
    let mut table = Some(tree);
    for name in path {
        let Some((key, value)) = table.and_then(|t| t.iter().find(|(k, _)| k.get_ref() == name)) else { break };
        line = line_of(text, Some(key.span()));
        table = value.get_ref().as_table();
    }
    line
}
