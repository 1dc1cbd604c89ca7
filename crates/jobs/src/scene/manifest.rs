//! The scene manifest, `scene.toml`: materials and their uses.

pub use super::place::{ManifestError, line_of, near_miss};
pub use super::uses::Use;

use super::assets::{Asset, AssetKind};
use super::gates::Require;
use super::lobes::{LOBES, LobesLimits, with_hint};
use super::names::{check_name, same_file};
use super::place::{Place, line_of_key, snippet};
use super::render_section::{RENDER_KEYS, RenderSection};
use super::scene_section::{SCENE_KEYS, SceneSection};
use super::shapes::{self, Key, Shape, key};
use super::textures;
use super::uses::USE_KEYS;
use crate::encode::OptionError;
use crate::encode::{EncodeOptions, PackRecipe, codec_names, range_of};
use crate::keys::keys_of;
use crate::pwt::PwtOptions;
use brdfc_core::Smooth;
use brdfc_core::address::is_synth;
use brdfc_core::words::{one_of, quoted};
use brdfc_source::Reading;
use brdfc_source::photograph::CodeValues;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::ffi::OsString;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

/// The contents of a manifest. See `docs/manifest.md` for the meaning of each key.
#[derive(Debug, Clone, Default)]
pub struct Manifest {
    /// Settings of the whole scene.
    pub scene: SceneSection,
    /// Defaults of the materials.
    pub defaults: Defaults,
    /// Materials by the names that uses refer to.
    pub materials: BTreeMap<String, Material>,
    /// RTI captures, BTFs and environments, sorted by name. All are built.
    pub assets: Vec<Asset>,
    /// Uses of the materials.
    pub uses: Vec<Use>,
    /// Settings of `brdfc render`.
    pub render: RenderSection,
}

/// The table `defaults`: options and requirements of all materials without values of their own.
#[derive(Debug, Clone, Default)]
pub struct Defaults {
    /// Settings of reading that a material's own settings override.
    pub reading: Reading,
    /// Encoding options that a material's own options override.
    pub options: EncodeOptions,
    /// Limits that finished packs have to meet.
    pub require: Require,
    /// Limits of lobes.
    pub lobes: LobesLimits,
}

/// A material of the manifest: its source, options and requirements.
#[derive(Debug, Clone, Default)]
pub struct Material {
    /// A path or a pattern, relative to the manifest, or a `synth:` address.
    pub source: OsString,
    /// Line of the source in the manifest, from 1; 0 without a manifest.
    pub line: usize,
    /// Settings of reading the source, which override the defaults.
    pub reading: Reading,
    /// Encoding options of this material, which override the defaults.
    pub options: EncodeOptions,
    /// Limits that its finished pack has to meet.
    pub require: Require,
    /// Limits of its lobes.
    pub lobes: LobesLimits,
}

/// The table of a material or of the defaults.
struct MaterialTable {
    /// Empty in the defaults.
    source: Spanned<String>,
    reading: Reading,
    options: EncodeOptions,
    require: Require,
    lobes: LobesLimits,
}

/// The tables that deserialise directly.
#[derive(Default, Deserialize)]
struct PlainTables {
    #[serde(default)]
    scene: SceneSection,
    #[serde(default)]
    uses: Vec<Use>,
    #[serde(default)]
    render: RenderSection,
}

const SOURCES: &str = "a file, a pattern or a synth: address";

impl Manifest {
    /// Parses and checks a manifest.
    ///
    /// # Errors
    /// Returns an error if the text is not TOML, a key is unknown (with the nearest known one), a value is out of
    /// range, or a use names an unknown material.
    pub fn parse(text: &str) -> Result<Self, ManifestError> {
        let tree = DeTable::parse(text).map_err(|error| {
            let wrong = format!("{} in \"{}\"", error.message(), snippet(text, error.span()));
            let wrong = wrong + "; expected TOML as described in docs/manifest.md";
            ManifestError::without_value(line_of(text, error.span()), "manifest", wrong)
        })?;
        shapes::check(text, tree.get_ref(), &all_keys())?;
        let manifest = Self::read(text, tree.clone()).map_err(|error| {
            let wrong = format!("{} in \"{}\"", error.message(), snippet(text, error.span()));
            let wrong = wrong + "; expected keys and values as in docs/manifest.md";
            ManifestError::without_value(line_of(text, error.span()), "manifest", wrong)
        })?;
        manifest.check(text, tree.get_ref())?;
        Ok(manifest)
    }

    /// Reads a tree whose values have been checked by [`shapes::check`].
    fn read(text: &str, mut tree: Spanned<DeTable<'_>>) -> Result<Self, toml::de::Error> {
        let ends: Vec<usize> = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        let root = tree.get_mut();
        let (defaults, materials) = (root.remove("defaults"), root.remove("materials"));
        let mut manifest = Self::default();
        if let Some(table) = defaults {
            let MaterialTable { reading, options, require, lobes, .. } = material_table(table)?;
            manifest.defaults = Defaults { reading, options, require, lobes };
        }
        if let Some(tables) = materials {
            let tables: BTreeMap<String, Spanned<DeValue<'_>>> = match tables.into_inner() {
                DeValue::Table(tables) => tables.into_iter().map(|(k, v)| (k.into_inner().into_owned(), v)).collect(),
                _ => BTreeMap::new(),
            };
            for (name, table) in tables {
                let MaterialTable { source, reading, options, require, lobes } = material_table(table)?;
                let line = 1 + ends.partition_point(|end| *end < source.span().start);
                let source = source.into_inner().into();
                manifest.materials.insert(name, Material { source, line, reading, options, require, lobes });
            }
        }
        for kind in AssetKind::ALL {
            let Some(DeValue::Table(tables)) = root.remove(kind.heading()).map(Spanned::into_inner) else { continue };
            for (name, table) in tables {
                manifest.assets.push(asset(kind, name.into_inner().into_owned(), table)?);
            }
        }
        manifest.assets.sort_by(|a, b| a.name.cmp(&b.name));
        let PlainTables { scene, uses, render } = PlainTables::deserialize(Deserializer::from(tree))?;
        Ok(Self { scene, uses, render, ..manifest })
    }

    fn check(&self, text: &str, tree: &toml::de::DeTable<'_>) -> Result<(), ManifestError> {
        let place = Place { text, tree };
        self.scene.check(&place)?;
        self.render.check(&place)?;
        let line = |path: &[&str]| line_of_key(text, tree, path);
        let error = |line, prefix: &str, error: OptionError| {
            let OptionError { field, found, allowed } = with_hint(error);
            ManifestError::new(line, format!("{prefix}.{field}"), found, allowed.to_string())
        };
        let Defaults { reading, options, require, lobes } = &self.defaults;
        check_reading(*reading).map_err(|p| error(line(&["defaults", p.field]), "defaults", p))?;
        PackRecipe::from_options(options, &EncodeOptions::default())
            .map_err(|p| error(line(&["defaults", p.field]), "defaults", p))?;
        require
            .resolve(&Require::default())
            .map_err(|p| error(line(&["defaults", "require", p.field]), "defaults.require", p))?;
        lobes
            .resolve(&LobesLimits::default())
            .map_err(|p| error(line(&["defaults", LOBES, p.field]), "defaults.lobes", p))?;
        self.check_names(&place)?;
        self.check_assets(&place)?;
        for (name, material) in &self.materials {
            let prefix = format!("materials.{name}");
            if material.source.is_empty() {
                let wrong = format!("no source; expected source = \"...\", {SOURCES}");
                return Err(place.error(&["materials", name], String::new(), &wrong));
            }
            if material.source == "-" {
                let allowed = format!("{SOURCES}; manifests do not read stdin");
                return Err(place.error(&["materials", name, "source"], "\"-\"".to_owned(), &allowed));
            }
            check_reading(material.reading).map_err(|p| error(line(&["materials", name, p.field]), &prefix, p))?;
            PackRecipe::from_options(&material.options, options)
                .map_err(|p| error(line(&["materials", name, p.field]), &prefix, p))?;
            let in_require = format!("{prefix}.require");
            material
                .require
                .resolve(require)
                .map_err(|p| error(line(&["materials", name, "require", p.field]), &in_require, p))?;
            let in_lobes = format!("{prefix}.{LOBES}");
            material
                .lobes
                .resolve(lobes)
                .map_err(|p| error(line(&["materials", name, LOBES, p.field]), &in_lobes, p))?;
        }
        for (number, used) in self.uses.iter().enumerate() {
            let name = used.material.get_ref();
            if !self.materials.contains_key(name) {
                let known: Vec<&str> = self.materials.keys().map(String::as_str).collect();
                let allowed =
                    if known.is_empty() { "a material; the manifest has none".to_owned() } else { one_of(&known) };
                let line = line_of(text, Some(used.material.span()));
                let error = ManifestError::new(line, format!("uses[{number}].material"), quoted(name), allowed);
                return Err(ManifestError { suggestion: near_miss(name, &known), ..error });
            }
            used.check(number, text, self.scene.environment.is_some())?;
            let earlier = self.uses[..number].iter().position(|other| other.material.get_ref() == name);
            textures::check(used, number, text, earlier.map(|first| (first, &self.uses[first])))?;
        }
        Ok(())
    }

    /// Checks that the names of materials and assets are file names that differ.
    fn check_names(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        let materials = self.materials.keys().map(|name| ("materials", name));
        let assets = self.assets.iter().map(|asset| (asset.kind.heading(), &asset.name));
        let named: Vec<(&str, &String)> = materials.chain(assets).collect();
        for (heading, name) in &named {
            if let Err(allowed) = check_name(name, self.scene.environment.is_some()) {
                return Err(place.error(&[heading, name], format!("the name \"{name}\""), &allowed));
            }
        }
        let Some((first, second)) = same_file(named.iter().map(|(_, name)| name.as_str())) else { return Ok(()) };
        let headings: Vec<&str> =
            named.iter().filter(|(_, name)| *name == second).map(|(heading, _)| *heading).collect();
        let wrong = if first == second {
            format!("[{}.{first}] has this name, too; choose names that differ", headings[0])
        } else {
            format!(
                "\"{first}\" and \"{second}\" are one file on some systems; choose names that differ in more than case \
                 and accent encoding"
            )
        };
        Err(place.error(&[headings[headings.len() - 1], second], String::new(), &wrong))
    }

    /// Checks sources and options of assets.
    fn check_assets(&self, place: &Place<'_>) -> Result<(), ManifestError> {
        for asset in &self.assets {
            let (heading, name) = (asset.kind.heading(), asset.name.as_str());
            if asset.source.is_empty() {
                let wrong = format!("no source; expected source = \"...\", {}", asset.kind.inputs());
                return Err(place.error(&[heading, name], String::new(), &wrong));
            }
            let source = asset.source.to_string_lossy();
            if source == "-" || is_synth(&source) {
                let allowed = asset.kind.inputs();
                return Err(place.error(&[heading, name, "source"], quoted(&source), allowed));
            }
            let error = |within: &str, error: OptionError| {
                let OptionError { field, found, allowed } = error;
                let line = line_of_key(place.text, place.tree, &[heading, name, field]);
                ManifestError::new(line, format!("{heading}.{name}.{within}{field}"), found, allowed.to_string())
            };
            asset.recipe().map_err(|problem| error("", problem))?;
            asset.require.resolve(&Require::default()).map_err(|problem| error("require.", problem))?;
        }
        Ok(())
    }
}

/// Reads the table of an asset.
fn asset(kind: AssetKind, name: String, table: Spanned<DeValue<'_>>) -> Result<Asset, toml::de::Error> {
    let span = table.span();
    let mut table = match table.into_inner() {
        DeValue::Table(table) => table,
        _ => DeTable::new(),
    };
    let source = table.remove("source").map(one::<String>).transpose()?.unwrap_or_default().into();
    let require = table.remove("require").map(one::<Require>).transpose()?.unwrap_or_default();
    let photographs = table.remove("photographs").map(one::<CodeValues>).transpose()?;
    let side = table.remove("side").map(one::<u32>).transpose()?;
    let options = PwtOptions::deserialize(Deserializer::from(Spanned::new(span, table)))?;
    Ok(Asset { name, kind, source, photographs, options, side, require })
}

/// Reads the table of a material or of the defaults: `source`, settings of reading, encoding options, and the tables `require` and `lobes`.
fn material_table(table: Spanned<DeValue<'_>>) -> Result<MaterialTable, toml::de::Error> {
    let span = table.span();
    let mut table = match table.into_inner() {
        DeValue::Table(table) => table,
        _ => DeTable::new(),
    };
    let source = table.remove("source").map(one::<Spanned<String>>).transpose()?;
    let source = source.unwrap_or_else(|| Spanned::new(span.clone(), String::new()));
    let require = table.remove("require").map(one::<Require>).transpose()?.unwrap_or_default();
    let lobes = table.remove(LOBES).map(one::<LobesLimits>).transpose()?.unwrap_or_default();
    let mut of_reading = DeTable::new();
    for key in keys_of::<Reading>() {
        of_reading.extend(table.remove_entry(*key));
    }
    let reading = Reading::deserialize(Deserializer::from(Spanned::new(span.clone(), of_reading)))?;
    let options = EncodeOptions::deserialize(Deserializer::from(Spanned::new(span, table)))?;
    Ok(MaterialTable { source, reading, options, require, lobes })
}

/// Checks the ranges of settings of reading.
fn check_reading(reading: Reading) -> Result<(), OptionError> {
    let keys = keys_of::<Reading>();
    reading.check().map_err(|error| {
        let key = keys.iter().find(|key| **key == error.field).expect("errors name a key");
        OptionError::new(key, error.found, &*error.allowed)
    })
}

fn one<T: DeserializeOwned>(value: Spanned<DeValue<'_>>) -> Result<T, toml::de::Error> {
    T::deserialize(toml::de::ValueDeserializer::from(value))
}

/// All keys of a manifest.
fn all_keys() -> Vec<Key> {
    let require: Vec<Key> = keys_of::<Require>().iter().map(|name| option_key(name)).collect();
    let lobes: Vec<Key> = keys_of::<LobesLimits>().iter().map(|name| option_key(name)).collect();
    let options = [keys_of::<EncodeOptions>(), keys_of::<Reading>()].concat().into_iter().map(option_key);
    let tables = [("require", require), (LOBES, lobes)];
    let tables = tables.map(|(name, keys)| key(name, Shape::Table(keys.into()), ""));
    let defaults: Vec<Key> = options.chain(tables).collect();
    let material = [vec![key("source", Shape::Text, SOURCES)], defaults.clone()].concat();
    vec![
        key("scene", Shape::Table(SCENE_KEYS.into()), ""),
        key("defaults", Shape::Table(defaults.into()), ""),
        key("materials", Shape::NamedTables(material.into()), ""),
        asset_keys(AssetKind::RtiCapture),
        asset_keys(AssetKind::Btf),
        asset_keys(AssetKind::Environment),
        key("uses", Shape::Tables(USE_KEYS), ""),
        key("render", Shape::Table(RENDER_KEYS.into()), ""),
    ]
}

/// Keys of the tables of assets.
fn asset_keys(kind: AssetKind) -> Key {
    let of_kind: Vec<Key> = match kind {
        AssetKind::RtiCapture | AssetKind::Btf => {
            let options = keys_of::<PwtOptions>().iter().map(|name| pwt_key(name));
            options.chain([key("photographs", Shape::Text, "linear or srgb")]).collect()
        }
        AssetKind::Environment => vec![key("side", Shape::WholeNumber, "")],
    };
    let require: Vec<Key> = kind.limits().iter().map(|name| option_key(name)).collect();
    let common = [key("source", Shape::Text, ""), key("require", Shape::Table(require.into()), "")];
    key(kind.heading(), Shape::NamedTables([&common[..], &of_kind].concat().into()), "")
}

/// The key of an option of polynomial wavelet trees.
fn pwt_key(name: &'static str) -> Key {
    let shape = match name {
        "max_bytes" => Shape::Bytes,
        "energy" => Shape::Share,
        "terms" | "domain" | "wavelet" => Shape::Text,
        "degree" | "max_fetches" | "levels" | "packets" => Shape::WholeNumber,
        _ => Shape::Number,
    };
    key(name, shape, "")
}

/// The key of an encoding option or a gate.
fn option_key(name: &'static str) -> Key {
    let shape = match name {
        "codec" | "parameterisation" | "ranking" => Shape::Text,
        "reciprocal" | "plain_levels" | "trust_fit" => Shape::Truth,
        "smooth" => Shape::TruthOrWholeNumber,
        "min_highlight" | "max_error" | "max_fit_error" => Shape::Share,
        "max_bytes" => Shape::Bytes,
        "max_fetches" | "levels" | "grid" | "bits" | "neighbours" => Shape::WholeNumber,
        _ => Shape::Number,
    };
    let range = match name {
        "codec" => codec_names(),
        "neighbours" => Reading::NEIGHBOURS,
        "smooth" => Smooth::ALLOWED,
        _ => range_of(name),
    };
    key(name, shape, range)
}
