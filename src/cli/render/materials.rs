//! Materials to draw, with their sources and packs.

use super::arguments::Arguments;
use super::light::{Lit, fitted};
use crate::options::flag_of;
use crate::output::{note, note_gaps, refuse_flags, remark};
use crate::reading::{checked, first_flag};
use crate::{Common, Error};
use brdfc::encode::encode;
use brdfc::encode::encoders::wavelet::recipe::Target;
use brdfc::inspect::{AnyPack as Pack, Kind, PackKind, open};
use brdfc::lobes::LobesPack;
use brdfc::render::{Material, open_brdf_pack};
use brdfc::scene::{EnvironmentJob, Job, LOBES, Manifest, PackFolder, Use, part_name, plan, read_manifest};
use brdfc::{BrdfPack, FitLimits, Input, PackRecipe, Source, WaveletRecipe as Recipe};
use std::path::{Path, PathBuf};

/// Finest grid with slices that all fit into a 3D texture.
const MAX_TABLE_LEVELS: u32 = 5;

/// Input of the command line.
pub(super) enum Subject {
    /// A manifest.
    Scene {
        /// Path.
        path: PathBuf,
        /// Text, for line numbers in errors.
        text: String,
        /// Parsed manifest.
        manifest: Box<Manifest>,
        /// Jobs of all materials, because a rendering may show one that no use refers to.
        jobs: Vec<Job>,
        /// Job of the environment's files, if the scene needs them.
        environment: Option<EnvironmentJob>,
        /// Folder of the packs, if they were built.
        packs: Option<Box<PackFolder>>,
    },
    /// A pack.
    Pack,
    /// Any input that can be encoded.
    Source(Box<PackRecipe>),
}

impl Subject {
    pub(super) fn manifest(&self) -> Option<&Manifest> {
        match self {
            Self::Scene { manifest, .. } => Some(manifest),
            _ => None,
        }
    }

    /// Returns true if an environment lights one of these materials by its lobes.
    pub(super) fn has_lobes(&self, names: &[String]) -> bool {
        let Self::Scene { jobs, .. } = self else { return false };
        names.iter().any(|name| job_of(jobs, name).lobes.is_some())
    }

    /// Returns true if point lights light a material.
    pub(super) fn is_lit_by_points(&self, name: &str) -> bool {
        let Self::Scene { jobs, .. } = self else { return true };
        job_of(jobs, name).uses.iter().any(|(_, used)| used.is_lit_by_points())
    }

    /// Returns true if the environment lights a material, but its lobes are not requested.
    pub(super) fn lacks_lobes(&self, name: &str) -> bool {
        let Self::Scene { jobs, .. } = self else { return false };
        let job = job_of(jobs, name);
        job.needs.lit_by_environment && job.lobes.is_none()
    }

    /// Path of the environment of the manifest's scene.
    pub(super) fn environment(&self) -> Option<PathBuf> {
        let Self::Scene { path, manifest, .. } = self else { return None };
        let file = manifest.scene.environment.as_ref()?;
        Some(path.parent().unwrap_or(Path::new("")).join(file))
    }

    pub(super) fn distance_scale(&self) -> Option<f64> {
        self.manifest().and_then(|manifest| manifest.scene.distance_scale)
    }
}

/// A material that is ready to draw.
pub(super) struct Prepared {
    pub(super) name: String,
    pub(super) pack: BrdfPack,
    pub(super) source: Option<Box<dyn Source>>,
    pub(super) table: Option<BrdfPack>,
    /// Lobes, if the scene has an environment that lights the material.
    pub(super) lobes: Option<LobesPack>,
    /// Bandwidth map and importance samples, if a folder of packs has them.
    pub(super) maps: Vec<Pack>,
}

impl Prepared {
    pub(super) fn material(&self) -> Material<'_> {
        let source = self.source.as_deref().map(|source| source as &dyn Source);
        Material { pack: &self.pack, source, table: self.table.as_ref() }
    }

    pub(super) fn lit(&self) -> Lit<'_> {
        let source = self.source.as_deref().map(|source| source as &dyn Source);
        Lit { name: &self.name, lobes: self.lobes.as_ref(), source }
    }

    /// Bytes of pack and lobes on a GPU.
    pub(super) fn gpu_bytes(&self) -> u64 {
        self.pack.gpu_bytes() + self.lobes.as_ref().map_or(0, LobesPack::gpu_bytes)
    }
}

/// Reads the manifest, if the input is one, and checks which flags apply to the input.
pub(super) fn subject(arguments: &Arguments) -> Result<Subject, Error> {
    let input = &arguments.input;
    let kind = Kind::of(input)?;
    let (is_scene, is_pack) = (kind == Kind::Manifest, kind.is_ktx2());
    let of_encoded = "inputs that are encoded (a scene sets them in its manifest)";
    let option = arguments.options.first().map(pack_flag);
    let read = first_flag(arguments.reading);
    let flags = [
        (!is_scene && arguments.packs.is_some(), "--packs", "manifests"),
        (!is_pack && arguments.source.is_some(), "--source", "packs"),
        ((is_pack || is_scene) && option.is_some(), option.as_deref().unwrap_or_default(), of_encoded),
        (is_scene && read.is_some(), read.unwrap_or_default(), of_encoded),
        (is_pack && arguments.source.is_none() && read.is_some(), read.unwrap_or_default(), "packs with a --source"),
        (is_pack && arguments.table && arguments.source.is_none(), "--table", "packs with a --source"),
    ];
    refuse_flags(input, &flags)?;
    match kind {
        Kind::Manifest => {
            let Some(path) = input.path().map(Path::to_owned) else {
                let text = format!("{input}: manifests are not read from stdin; name the file");
                return Err(Error::usage(text));
            };
            let (text, manifest) = read_manifest(&path)?;
            let folder = path.parent().unwrap_or(Path::new(""));
            let mut all = with_all_uses(&manifest);
            // Needs depend on whether there is an environment; this one is opened by its own path.
            if let Some(environment) = arguments.adaptive.environment.as_ref().filter(|_| arguments.by_lobes()) {
                all.scene.environment = Some(environment.to_string());
            }
            let plan = plan(&all, folder)?;
            // Adaptive shading looks maps up, and other renderings lobes.
            let drawn = |job: Job| match arguments.adaptive.adaptive {
                true => Job { lobes: None, ..job },
                false => Job { maps: [false; 2], texture: None, ..job },
            };
            let (jobs, environment) = (plan.jobs.into_iter().map(drawn).collect(), plan.environment);
            let packs = pack_folder(arguments)?.map(Box::new);
            Ok(Subject::Scene { path, text, manifest: Box::new(manifest), jobs, environment, packs })
        }
        _ if is_pack => Ok(Subject::Pack),
        _ => {
            let (recipe, fit) = arguments.options.request().map_err(pack_flags)?;
            if fit != FitLimits::default() {
                let flags = "--trust-fit, --max-fit-error";
                return Err(Error::usage(format!("{flags} do not apply to render, only to encode and build")));
            }
            Ok(Subject::Source(Box::new(recipe)))
        }
    }
}

/// Names options by their flags of `render`.
fn pack_flags(error: impl Into<Error>) -> Error {
    error.into().name_options(pack_flag)
}

/// The flag of an encoding option's key in `render`.
pub(super) fn pack_flag(key: &str) -> String {
    if key == "max_delta_e" { "--pack-delta-e".to_owned() } else { flag_of(key) }
}

/// Opens the given folder of packs, or the default folder of a build.
fn pack_folder(arguments: &Arguments) -> Result<Option<PackFolder>, Error> {
    let default = Path::new(brdfc::Build::DEFAULT_FOLDER);
    let folder = match &arguments.packs {
        Some(folder) if !folder.is_dir() => {
            let text = "cannot read: not a folder; expected a folder that 'brdfc build' filled";
            return Err(Error::io(format!("{}: {text}", folder.display())));
        }
        Some(folder) => folder,
        None if PackFolder::is_one(default) => default,
        None => return Ok(None),
    };
    PackFolder::open(folder).map(Some)
}

/// Returns the manifest with a use for each material, so that the plan has a job for each.
fn with_all_uses(manifest: &Manifest) -> Manifest {
    let mut all = manifest.clone();
    let used: Vec<String> = all.uses.iter().map(|used| used.material.get_ref().clone()).collect();
    for name in manifest.materials.keys().filter(|name| !used.contains(name)) {
        let material = toml::Spanned::new(0..0, name.clone());
        all.uses.push(Use::of(material));
    }
    all
}

/// Names without repetitions, in order of their first occurrence. Several parts of a scene may have one material.
pub(super) fn distinct(names: &[String]) -> Vec<&String> {
    let is_first = |(at, name): &(usize, &String)| !names[..*at].contains(name);
    names.iter().enumerate().filter(is_first).map(|(_, name)| name).collect()
}

/// Opens and encodes the named materials, each once.
pub(super) fn prepare(
    arguments: &Arguments,
    subject: &Subject,
    names: &[String],
    common: Common,
) -> Result<Vec<Prepared>, Error> {
    let distinct = distinct(names);
    distinct
        .iter()
        .enumerate()
        .map(|(number, name)| {
            let (prepared, notes) = prepare_one(arguments, subject, name, common)?;
            for line in notes {
                note(common, name, &line);
            }
            if distinct.len() > 1 {
                remark(common, &format!("{} of {}: {name} ready", number + 1, distinct.len()));
            }
            Ok(prepared)
        })
        .collect()
}

/// Rejects a check of packs that are not the files of the folder.
fn refuse_unchecked(arguments: &Arguments, stale: &[String], missing: &[String]) -> Result<(), Error> {
    let limits = [arguments.max_delta_e, arguments.max_delta_e_p95, arguments.max_flip, arguments.adaptive.min_psnr];
    if arguments.packs.is_none() || limits.iter().all(Option::is_none) {
        return Ok(());
    }
    match (stale.first(), missing.first()) {
        (Some(file), _) => Err(Error::check(format!(
            "{file}: damaged, or made from another source or with other options; run 'brdfc build'"
        ))),
        (None, Some(file)) => Err(Error::check(format!("{file}: missing; run 'brdfc build'"))),
        (None, None) => Ok(()),
    }
}

/// Prepares a material, and collects notes about it.
fn prepare_one(
    arguments: &Arguments,
    subject: &Subject,
    name: &str,
    common: Common,
) -> Result<(Prepared, Vec<String>), Error> {
    let read = |input: &Input| Ok::<_, Error>(open(input, checked(arguments.reading, &[input])?)?);
    let (opened, recipe) = match subject {
        Subject::Pack => (arguments.source.as_ref().map(read).transpose()?, PackRecipe::default()),
        Subject::Source(recipe) => (Some(read(&arguments.input)?), (**recipe).clone()),
        Subject::Scene { jobs, .. } => {
            let job = job_of(jobs, name);
            (Some(open(&job.input, job.reading)?), job.recipe.clone())
        }
    };
    let source = opened.map(|opened| opened.source);
    if let Some(source) = &source {
        note_gaps(common, &name, source.as_ref());
    }
    if arguments.table && !matches!((subject, recipe.kind()), (Subject::Pack, _) | (_, PackKind::Wavelet)) {
        return Err(no_table(recipe.kind()));
    }
    let (pack, lobes, maps, notes) = match (subject, &source) {
        (Subject::Scene { jobs, packs: Some(packs), .. }, _) => {
            let current = packs.material(job_of(jobs, name), &())?;
            // A build makes no lobes for an environment of the command line.
            let is_fitted = |file: &String| arguments.by_lobes() && *file == part_name(name, LOBES);
            let missing: Vec<String> = current.missing.into_iter().filter(|file| !is_fitted(file)).collect();
            refuse_unchecked(arguments, &current.stale, &missing)?;
            let stale = current.stale.iter().map(|file| {
                format!("{file} is out of date, so the material was encoded again; run 'brdfc build' to update it")
            });
            let missing = missing.iter().filter(|_| arguments.packs.is_some());
            let missing = missing.map(|file| format!("{file} is not in the folder: made for the rendering"));
            let closed = current.gates.iter().filter(|gate| !gate.passed).map(ToString::to_string);
            let notes = stale.chain(missing).chain(closed).chain(current.missed).collect();
            let mut parts = current.parts.into_iter();
            let pack = parts.next().and_then(|pack| BrdfPack::try_from(pack).ok());
            let pack = pack.ok_or_else(|| Error::internal(format!("{name}: the store contains no pack")))?;
            let mut parts = parts.peekable();
            let lobes = match parts.next_if(|part| matches!(part, Pack::Lobes(_))) {
                Some(Pack::Lobes(lobes)) => Some(lobes),
                _ => None,
            };
            (pack, lobes, parts.collect(), notes)
        }
        (Subject::Pack, _) => (open_brdf_pack(&arguments.input)?, None, Vec::new(), Vec::new()),
        (_, Some(source)) => {
            let named = |error| match subject {
                Subject::Source(_) => pack_flags(error).prefixed(&arguments.input),
                _ => Error::from(error).prefixed(name),
            };
            let made = encode(source.as_ref(), &recipe.clone().without_measuring(), &()).map_err(named)?;
            let recipe = match subject {
                Subject::Scene { jobs, .. } => job_of(jobs, name).lobes,
                _ => None,
            };
            let fit = |recipe| fitted(&name, source.as_ref(), &recipe, common);
            let lobes = recipe.map(fit).transpose()?;
            (made.pack, lobes, Vec::new(), made.missed.into_iter().collect())
        }
        (_, None) => return Err(Error::internal("nothing to draw")),
    };
    let table = match &source {
        Some(source) if arguments.table => {
            let BrdfPack::Wavelet(wavelet) = &pack else { return Err(no_table(pack.kind())) };
            let levels = wavelet.header.levels;
            if levels > MAX_TABLE_LEVELS {
                let text =
                    "--table: found a grid of 64, expected at most 32, because all slices must fit into one texture";
                return Err(Error::usage(text));
            }
            let whole = Recipe {
                parameterisation: wavelet.header.parameterisation,
                levels,
                stored_levels: levels,
                target: Target::Ratio(1.0),
                bits: 16,
                ..bias_of(&recipe)
            };
            Some(encode(source.as_ref(), &PackRecipe::Wavelet(whole).without_measuring(), &())?.pack)
        }
        _ => None,
    };
    if arguments.lod.is_some() && pack.levels() == 0 {
        let found = pack.kind().summary();
        return Err(Error::usage(format!(
            "--lod does not apply to {found} of one level, only to packs with levels of detail (--levels)"
        )));
    }
    Ok((Prepared { name: name.to_owned(), pack, source, table, lobes, maps }, notes))
}

pub(super) fn job_of<'a>(jobs: &'a [Job], name: &str) -> &'a Job {
    jobs.iter().find(|job| job.name == name).expect("names are materials of the manifest")
}

/// Recipe of a whole table with the bias of the pack.
fn bias_of(recipe: &PackRecipe) -> Recipe {
    match recipe {
        PackRecipe::Wavelet(recipe) => recipe.clone(),
        _ => Recipe::default(),
    }
}

fn no_table(kind: PackKind) -> Error {
    let (found, allowed) = (kind.summary(), "wavelet packs (--codec wavelet)");
    Error::usage(format!("--table does not apply to {found}, only to {allowed}"))
}
