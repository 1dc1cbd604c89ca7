//! Which materials are drawn, from where, and as which packs.

use super::arguments::Arguments;
use crate::inputs::refuse_stdin_twice;
use crate::output::{note, remark};
use crate::{CliError, Common};
use brdfc_formats::BrdfPack;
use brdfc_jobs::encode::encode;
use brdfc_jobs::encode::recipe::PackRecipe;
use brdfc_jobs::scene::manifest::Manifest;
use brdfc_jobs::scene::run::{Job, pack_name, plan};
use brdfc_source::open::open;
use brdfc_source::pack::open_brdf_pack;
use brdfc_source::{Input, Source};
use brdfc_wavelet::recipe::{Recipe, Target};
use std::path::{Path, PathBuf};

/// Finest grid whose slices all fit into a 3D texture.
const MAX_TABLE_LEVELS: u32 = 5;

/// What the command line names.
pub(super) enum Subject {
    /// A manifest.
    Scene {
        /// Where it is.
        path: PathBuf,
        /// Its text, for lines in errors.
        text: String,
        /// What it says.
        manifest: Box<Manifest>,
        /// Its materials, all of them: a picture may show what no use refers to.
        jobs: Vec<Job>,
    },
    /// A pack.
    Pack,
    /// Anything that can be encoded.
    Source(Box<PackRecipe>),
}

impl Subject {
    pub(super) fn manifest(&self) -> Option<&Manifest> {
        match self {
            Self::Scene { manifest, .. } => Some(manifest),
            _ => None,
        }
    }

    pub(super) fn distance_scale(&self) -> Option<f64> {
        self.manifest().and_then(|manifest| manifest.scene.distance_scale)
    }
}

/// A material that is ready to be drawn.
pub(super) struct Prepared {
    pub(super) name: String,
    pub(super) pack: BrdfPack,
    pub(super) source: Option<Box<dyn Source>>,
    pub(super) table: Option<BrdfPack>,
}

/// Reads the manifest, if the input is one, and checks which flags go with the input.
pub(super) fn subject(arguments: &Arguments) -> Result<Subject, CliError> {
    let input = &arguments.input;
    let kind = input.extension()?;
    refuse_stdin_twice(&[("INPUT", Some(input)), ("--source", arguments.source.as_ref())])?;
    let misplaced = |flag: &str, goes_with: &str| {
        Err(CliError::Usage(format!("{flag}: found with {input}; allowed with {goes_with}")))
    };
    if kind != "toml" && arguments.packs.is_some() {
        return misplaced("--packs", "a manifest");
    }
    if kind != "ktx2" && arguments.source.is_some() {
        return misplaced("--source", "a pack");
    }
    if (kind == "ktx2" || kind == "toml") && arguments.options.any() {
        return misplaced("encoding options", "an input that is encoded; those of a scene stand in its manifest");
    }
    if kind == "ktx2" && arguments.table && arguments.source.is_none() {
        return misplaced("--table", "a source: name it with --source");
    }
    match kind.as_str() {
        "toml" => {
            let Some(path) = input.path().map(Path::to_owned) else {
                let allowed = "a file: its paths start at its folder";
                return Err(CliError::Usage(format!("SCENE.toml: found {input}; allowed {allowed}")));
            };
            let (text, manifest) = crate::build_scene::read_manifest(&path)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let jobs = plan(&shown(&manifest), folder).jobs;
            Ok(Subject::Scene { path, text, manifest: Box::new(manifest), jobs })
        }
        "ktx2" => Ok(Subject::Pack),
        _ => Ok(Subject::Source(Box::new(arguments.options.recipe()?))),
    }
}

/// The manifest with a use of each material, so that the plan has a job for it.
fn shown(manifest: &Manifest) -> Manifest {
    let mut all = manifest.clone();
    let used: Vec<String> = all.uses.iter().map(|used| used.material.get_ref().clone()).collect();
    for name in manifest.materials.keys().filter(|name| !used.contains(name)) {
        let material = toml::Spanned::new(0..0, name.clone());
        all.uses.push(brdfc_jobs::scene::manifest::Use { object: None, material, nearest: None });
    }
    all
}

/// Opens and encodes the materials of these names, each once.
pub(super) fn prepare(
    arguments: &Arguments,
    subject: &Subject,
    names: &[String],
    common: Common,
) -> Result<Vec<Prepared>, CliError> {
    let mut wanted: Vec<&String> = Vec::new();
    for name in names {
        if !wanted.contains(&name) {
            wanted.push(name);
        }
    }
    wanted
        .iter()
        .enumerate()
        .map(|(number, name)| {
            let (prepared, missed) = prepare_one(arguments, subject, name)?;
            if let Some(missed) = missed {
                note(common, name, &missed);
            }
            if wanted.len() > 1 {
                remark(common, &format!("{} of {}: {name} ready", number + 1, wanted.len()));
            }
            Ok(prepared)
        })
        .collect()
}

/// A material, and what its pack misses of its budget.
fn prepare_one(arguments: &Arguments, subject: &Subject, name: &str) -> Result<(Prepared, Option<String>), CliError> {
    let (source, recipe, pack_file) = match subject {
        Subject::Pack => (arguments.source.clone(), PackRecipe::default(), Some(arguments.input.clone())),
        Subject::Source(recipe) => (Some(arguments.input.clone()), (**recipe).clone(), None),
        Subject::Scene { jobs, .. } => {
            let job = jobs.iter().find(|job| job.name == name).expect("names are materials of the manifest");
            let pack = arguments.packs.as_ref().map(|folder| Input::File(folder.join(pack_name(name))));
            (Some(Input::from(&job.source)), job.recipe.clone(), pack)
        }
    };
    let source = source.map(|input| open(&input, None)).transpose()?.map(|opened| opened.source);
    if arguments.table && pack_file.is_none() && !matches!(recipe, PackRecipe::Wavelet(_)) {
        return Err(no_table());
    }
    let (pack, missed) = match (&pack_file, &source) {
        (Some(file), _) => (open_brdf_pack(file)?, None),
        (None, Some(source)) => {
            let made = encode(source.as_ref(), &recipe.clone().without_measuring(), &())?;
            (made.pack, made.missed)
        }
        (None, None) => return Err(CliError::Internal("nothing to draw".to_owned())),
    };
    let table = match &source {
        Some(source) if arguments.table => {
            let BrdfPack::Wavelet(wavelet) = &pack else { return Err(no_table()) };
            let levels = wavelet.header.levels;
            if levels > MAX_TABLE_LEVELS {
                let text = "--table: found a grid of 64; allowed up to 32, whose slices all fit into a texture";
                return Err(CliError::Usage(text.to_owned()));
            }
            let whole = Recipe {
                parameterisation: wavelet.header.parameterisation,
                levels,
                stored_levels: levels,
                target: Target::Ratio(1.0),
                bits: 16,
                ..bias_and_smoothing(&recipe)
            };
            Some(encode(source.as_ref(), &PackRecipe::Wavelet(whole).without_measuring(), &())?.pack)
        }
        _ => None,
    };
    if let (Some(_), BrdfPack::Table(table)) = (arguments.lod, &pack)
        && table.levels() == 0
    {
        let text = "--lod: found with a table pack of one level; allowed with packs that have levels of detail";
        return Err(CliError::Usage(format!("{text} (--levels)")));
    }
    Ok((Prepared { name: name.to_owned(), pack, source, table }, missed))
}

/// What a whole table has in common with the pack.
fn bias_and_smoothing(recipe: &PackRecipe) -> Recipe {
    match recipe {
        PackRecipe::Wavelet(recipe) => recipe.clone(),
        PackRecipe::Auto(_) | PackRecipe::Table(_) => Recipe::default(),
    }
}

fn no_table() -> CliError {
    let text = "--table: found a table pack; allowed wavelet packs (--codec wavelet), whose grid it shows the error of";
    CliError::Usage(text.to_owned())
}
