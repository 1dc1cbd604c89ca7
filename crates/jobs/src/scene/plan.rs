//! Build plans: the materials of a scene with their sources and recipes.

use super::assets::{Asset, AssetJob, files_of};
use super::batch::address_of;
use super::gates::{Gates, Require};
use super::lobes::{LOBES, with_hint};
use super::manifest::Manifest;
use super::maps::{ENVIRONMENT_PARTS, PARTS, RequestedMaps, TEXTURE, part_name, requested_parts};
use super::needs::{self, Needs, needs};
use super::scene_section::ENVIRONMENT;
use super::textures::TextureJob;
use super::uses::Use;
use crate::encode::{ErrorLimits, OptionError, PackRecipe, options_over};
use crate::error::Error;
use brdfc_core::Smooth;
use brdfc_formats::wavelet::DEFAULT_DISTANCE_SCALE;
use brdfc_lobes::LobesRecipe;
use brdfc_source::Kind;
use brdfc_source::{Input, Reading};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The job that makes one material.
#[derive(Debug, Clone)]
pub struct Job {
    /// Name of the material.
    pub name: String,
    /// Path or address as written in the manifest.
    pub declared: String,
    /// Path or address, resolved against the manifest's folder.
    pub input: Input,
    /// Settings of reading the input.
    pub reading: Reading,
    /// The recipe from its options, before the needs limit it.
    pub asked: PackRecipe,
    /// The recipe, limited by the needs.
    pub recipe: PackRecipe,
    /// The recipe of its lobes; `None` if it needs none.
    pub lobes: Option<LobesRecipe>,
    /// The maps for adaptive shading that it needs.
    pub maps: RequestedMaps,
    /// The texture whose bandwidth map it needs; `None` if it needs none.
    pub texture: Option<TextureJob>,
    /// Limits that the finished pack has to meet.
    pub gates: Gates,
    /// Needs of the scene.
    pub needs: Needs,
    /// The uses that refer to it, with their names.
    pub uses: Vec<(String, Use)>,
}

impl Job {
    /// Returns true if both jobs have the same source, settings, recipes and maps.
    pub(super) fn is_same_work(&self, other: &Self) -> bool {
        let of = |job: &Self| (job.reading, job.lobes, job.maps);
        self.input == other.input
            && self.recipe == other.recipe
            && of(self) == of(other)
            && self.texture == other.texture
    }

    /// Names of its lobes and maps among its parts, in the order of its files.
    pub fn lighting_parts(&self) -> impl Iterator<Item = &'static str> {
        let texture = self.texture.iter().map(|_| TEXTURE);
        self.lobes.map(|_| LOBES).into_iter().chain(requested_parts(PARTS, self.maps)).chain(texture)
    }

    /// Returns true if it needs any of the maps for adaptive shading.
    pub(super) fn has_maps(&self) -> bool {
        self.maps != [false; 2]
    }
}

/// The job that makes the maps of the environment.
#[derive(Debug, Clone)]
pub struct EnvironmentJob {
    /// Path as written in the manifest.
    pub declared: String,
    /// Path, resolved against the manifest's folder.
    pub path: PathBuf,
    /// The maps that the scene needs.
    pub maps: RequestedMaps,
}

impl EnvironmentJob {
    /// Names of the files that it makes.
    pub fn files(&self) -> impl Iterator<Item = String> {
        requested_parts(ENVIRONMENT_PARTS, self.maps).map(|part| part_name(ENVIRONMENT, part))
    }
}

/// Jobs that a build of a scene runs.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Name of the scene.
    pub scene: String,
    /// Jobs of the materials, sorted by name.
    pub jobs: Vec<Job>,
    /// Jobs of the assets that are no materials, sorted by name.
    pub assets: Vec<AssetJob>,
    /// Job of the environment; `None` if the scene needs none of its maps.
    pub environment: Option<EnvironmentJob>,
    /// True if the scene has an environment, even if its maps are not needed.
    pub has_environment: bool,
    /// Materials that no use refers to. They are not opened.
    pub skipped: Vec<String>,
}

impl Plan {
    /// Returns true if there is nothing to make.
    pub fn is_empty(&self) -> bool {
        self.jobs.is_empty() && self.assets.is_empty() && self.environment.is_none()
    }

    /// The job of a material.
    pub fn job(&self, name: &str) -> Option<&Job> {
        self.jobs.binary_search_by(|job| job.name.as_str().cmp(name)).ok().map(|at| &self.jobs[at])
    }

    /// The job of an asset.
    pub fn asset(&self, name: &str) -> Option<&AssetJob> {
        self.assets.iter().find(|job| job.name == name)
    }

    /// Paths of all sources that are files.
    pub fn sources(&self) -> impl Iterator<Item = &Path> {
        let environment = self.environment.iter().map(|job| job.path.as_path());
        let textures = self.jobs.iter().filter_map(|job| Some(job.texture.as_ref()?.path.as_path()));
        let assets = self.assets.iter().flat_map(|job| &job.files).map(PathBuf::as_path);
        self.jobs.iter().filter_map(|job| job.input.path()).chain(textures).chain(environment).chain(assets)
    }

    /// Names of the files that a build writes into its output folder.
    pub fn files(&self) -> impl Iterator<Item = String> {
        let environment = self.environment.iter().flat_map(EnvironmentJob::files);
        let of_job = |job: &Job| {
            let maps = job.lighting_parts().map(|part| part_name(&job.name, part));
            [pack_name(&job.name), list_name(&job.name)].into_iter().chain(maps).collect::<Vec<_>>()
        };
        let assets = self.assets.iter().map(AssetJob::file);
        self.jobs.iter().flat_map(of_job).chain(assets).chain(environment).chain([REPORT.to_owned()])
    }
}

/// File name of the build report in the output folder.
pub const REPORT: &str = brdfc_source::kind::BUILD_REPORT;

/// Name of the file that lists the parts of a material.
pub fn list_name(material: &str) -> String {
    format!("{material}.json")
}

/// File name of the pack of a material.
pub fn pack_name(material: &str) -> String {
    part_name(material, "brdf")
}

/// The job of an asset that is no material.
fn asset_job(asset: &Asset, folder: &Path) -> Result<AssetJob, OptionError> {
    let path = folder.join(&asset.source);
    Ok(AssetJob {
        name: asset.name.clone(),
        kind: asset.kind,
        declared: asset.source.display().to_string(),
        files: files_of(&path),
        path,
        recipe: asset.recipe()?,
        required: asset.require.resolve(&Require::default())?,
    })
}

fn uses_by_material(manifest: &Manifest) -> BTreeMap<&str, Vec<(String, Use)>> {
    let mut all: BTreeMap<&str, Vec<(String, Use)>> = BTreeMap::new();
    for (number, used) in manifest.uses.iter().enumerate() {
        all.entry(used.material.get_ref()).or_default().push((used.name(number), used.clone()));
    }
    all
}

/// Plans a build. Patterns in the manifest must have been expanded. Paths are relative to `folder`.
///
/// # Errors
/// Returns an error if options of a material conflict with the defaults. [`Manifest::parse`] has already rejected such
/// manifests.
pub fn plan(manifest: &Manifest, folder: &Path) -> Result<Plan, Error> {
    let needed = needs(manifest);
    let mut uses = uses_by_material(manifest);
    let scale = manifest.scene.distance_scale.unwrap_or(DEFAULT_DISTANCE_SCALE);
    let environment = needs::environment(manifest, &needed).map(|(declared, maps)| EnvironmentJob {
        declared: declared.to_owned(),
        path: folder.join(declared),
        maps,
    });
    let scene = manifest.scene.name.clone().unwrap_or_else(|| "scene".to_owned());
    let mut plan = Plan {
        scene,
        jobs: Vec::new(),
        assets: manifest.assets.iter().map(|asset| asset_job(asset, folder)).collect::<Result<_, _>>()?,
        environment,
        has_environment: manifest.scene.environment.is_some(),
        skipped: Vec::new(),
    };
    let defaults = &manifest.defaults;
    for (name, material) in &manifest.materials {
        let Some(need) = needed.get(name.as_str()) else {
            plan.skipped.push(name.clone());
            continue;
        };
        let wrong = |error: OptionError| Error::from(with_hint(error)).prefixed(name);
        let mut recipe = PackRecipe::from_options(&material.options, &defaults.options).map_err(wrong)?;
        let asked = recipe.clone();
        let required = material.require.resolve(&defaults.require).map_err(wrong)?;
        let lobes = material.lobes.resolve(&defaults.lobes).map_err(wrong)?;
        let fit = options_over(&material.options, &defaults.options).fit_limits().map_err(wrong)?;
        let of_lobes = material.lobes.max_delta_e.or(defaults.lobes.max_delta_e);
        let gates = Gates {
            required,
            fit,
            errors: recipe.asked_errors().and((&required).into()),
            lobes: ErrorLimits { delta_e: of_lobes, relative: None },
        };
        recipe.limit_levels(&|levels| need.stored_levels(levels, scale));
        recipe.limit_coarser_levels(need.coarser_levels(scale));
        recipe.limit_directions(need.directions);
        let input = match address_of(&material.source) {
            Some(address) => Input::Address(address.to_owned()),
            None => Input::File(folder.join(&material.source)),
        };
        let mut reading = material.reading.over(defaults.reading);
        // Scans have no radius. A material's own one is an error.
        if material.reading.smooth.is_none()
            && matches!(reading.smooth, Some(Smooth::Radius(_)))
            && Kind::of(&input)? == Kind::Scan
        {
            reading.smooth = None;
        }
        let uses = uses.remove(name.as_str()).unwrap_or_default();
        let texture = uses.iter().find_map(|(_, used)| TextureJob::of(used, folder)).filter(|_| need.texture);
        plan.jobs.push(Job {
            name: name.clone(),
            declared: material.source.display().to_string(),
            input,
            reading,
            asked,
            recipe,
            lobes: need.lobes.then_some(lobes),
            maps: [need.bandwidth, need.samples],
            texture,
            gates,
            needs: *need,
            uses,
        });
    }
    Ok(plan)
}
