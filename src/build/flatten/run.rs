//! Makes the packs of a flat BTF and writes them as they are finished.

use super::asset::{AssetErrors, AssetFile, AssetReport, PartFile};
use super::input::Geometry;
use super::recipe::{FlattenRecipe, Form};
use crate::btf::diffuse::DiffuseFit;
use crate::btf::fill::{FillMethod, PushPull};
use crate::btf::flatten::{ComputedField, FlatView as Flattened, Guide, Holes, LightField, from_above, visible};
use crate::btf::indirection::indirection;
use crate::btf::measured::{MeasuredField, ViewImages};
use crate::btf::model::MesoModel;
use crate::btf::parameterise::{ParameteriseError, steps};
use crate::btf::probes::{ColourErrors, Directions, Probes, shown};
use crate::btf::rebuild::ViewImage;
use crate::btf::surface::Appearance;
use crate::btf::texels::TexelMap;
use crate::btf::tile_image::TileImage;
use crate::build::btf_stack::{StackFormat, write_image};
use crate::build::write::write_atomic;
use crate::source::btf_stack::BtfStack;
use crate::source::open::InputError;
use brdfc_formats::FormatError;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::measured::btf_stack::ImageAngles;
use brdfc_formats::pack::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatHeader, FlatView, IndirectionMap, NormalMap, PositionMap,
    ReferenceMap, VisibilityMask, view_part,
};
use brdfc_formats::pack::rgb9e5;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::{Path, PathBuf};

/// Why a flat BTF cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FlattenError {
    /// The surface cannot be laid flat.
    #[error(transparent)]
    Parameterise(ParameteriseError),
    /// A pack cannot hold it.
    #[error("{0}")]
    Pack(#[from] FormatError),
    /// An image cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file cannot be written.
    #[error("{path}: cannot write: {error}")]
    Write {
        /// Which.
        path: String,
        /// What the system says.
        error: std::io::Error,
    },
    /// Stopped by the watcher.
    #[error("cancelled")]
    Cancelled,
}

impl From<ParameteriseError> for FlattenError {
    fn from(error: ParameteriseError) -> Self {
        if error == ParameteriseError::Cancelled { Self::Cancelled } else { Self::Parameterise(error) }
    }
}

impl From<Infallible> for FlattenError {
    fn from(never: Infallible) -> Self {
        match never {}
    }
}

/// What is told while it runs. Calls come from several threads.
pub trait FlattenWatcher: Sync {
    /// A stage of so many steps starts. Returning `false` cancels.
    fn stage(&self, name: &'static str, steps: usize) -> bool;
    /// A step is done. Returning `false` cancels.
    fn step(&self) -> bool;
}

/// Where the values of texels come from.
pub enum Values {
    /// Materials of the surface.
    Computed(Appearance),
    /// Images of an ordinary BTF.
    Measured(BtfStack),
}

/// What is made, and where.
pub struct FlattenJob<'a> {
    /// The asset's name.
    pub name: &'a str,
    /// The folder of its files.
    pub folder: &'a Path,
    /// How it is made.
    pub recipe: &'a FlattenRecipe,
    /// The surface.
    pub geometry: Geometry,
    /// The materials' sources.
    pub materials: Vec<String>,
    /// Where values come from.
    pub values: Values,
    /// Folder and kind of the images of an ordinary BTF to write besides, computed directly.
    pub images: Option<(&'a Path, StackFormat)>,
}

/// Look-ups that errors are measured with.
const PROBES: usize = 4096;
/// Most views in memory at once.
const MOST_VIEWS_AT_ONCE: usize = 8;

/// Makes all parts, writes each as it is finished and `NAME.json` last.
///
/// # Errors
/// A surface that cannot be laid flat, images that cannot be read, files that cannot be written.
pub fn run(job: FlattenJob<'_>, watcher: &dyn FlattenWatcher) -> Result<AssetFile, FlattenError> {
    let recipe = job.recipe;
    let mut parts = Parts { job: job.name, folder: job.folder, files: BTreeMap::new() };
    let listing = parts.path(&format!("{}.json", job.name));
    // Until it is whole again there is no asset of this name.
    let _ = std::fs::remove_file(&listing);

    begin(watcher, "parameterise", steps(recipe.rounds))?;
    let model = MesoModel::watched(job.geometry.mesh, recipe.rounds, &|| watcher.step())?;
    let texels = model.texels(recipe.flat_texels);
    let size = recipe.flat_texels as u32;
    let single = |v: Vector| v.map(|c| c as f32);
    parts.write(
        "position",
        16,
        |z| Ok(PositionMap::new(size, texels.points.iter().map(|p| single(p.position)).collect())?.to_bytes(z)),
        recipe,
    )?;
    let normal = NormalMap::new(size, texels.points.iter().map(|p| single(p.normal)).collect())?;
    parts.write("normal", 8, |z| Ok(normal.to_bytes(z)), recipe)?;

    let header = recipe.indirection;
    header.check()?;
    begin(watcher, "indirection", header.size as usize)?;
    let found = indirection(&model, header, recipe.oversampling, &|| {
        watcher.step();
    });
    let reference = ReferenceMap::new(header.size, found.reference)?;
    let mut displacements = found.displacements.into_iter();
    let map = IndirectionMap::from_displacements(header, |_, _, _| displacements.next().expect("one for each view"))?;
    parts.write("reference", 8, |z| Ok(reference.to_bytes(z)), recipe)?;
    parts.write("indirection", 8, |z| Ok(map.to_bytes(z)), recipe)?;
    // Colours come last; the decoder is asked for indirections before.
    let black = DiffuseMap::new(size, vec![0; texels.points.len()])?;
    let decoder =
        FlatBtfDecoder::new(FlatBtfParts { reference, indirection: map, normal, diffuse: black, views: Vec::new() })?;

    begin(watcher, "visibility", 1)?;
    let (views, lights) = (recipe.views.directions(), recipe.lights.directions());
    let masks: Vec<Vec<bool>> = views.iter().map(|view| visible(&texels, &model.caster, *view)).collect();
    let bytes = masks.iter().flatten().map(|seen| if *seen { 255 } else { 0 }).collect();
    parts.write("mask", 1, |z| Ok(VisibilityMask::new(size, views.len() as u32, bytes)?.to_bytes(z)), recipe)?;

    let pass = Pass { recipe, model: &model, texels: &texels, views: &views, lights: &lights, masks: &masks };
    let (diffuse, errors) = match &job.values {
        Values::Computed(appearance) => {
            begin(watcher, "shadows", 1)?;
            let field =
                ComputedField::new(&model.mesh, &texels, &model.caster, appearance, &views, &lights, recipe.bounces);
            let mut probes = computed_probes(&pass, &decoder, appearance)?;
            let lit = |light: usize, texel: usize| field.lit(light)[texel];
            let diffuse = pass.run(&field, &lit, &mut probes.each(), &mut parts, watcher)?;
            if let Some((folder, format)) = job.images {
                pass.write_images(appearance, folder, format, watcher)?;
            }
            (diffuse, probes)
        }
        Values::Measured(stack) => {
            begin(watcher, "shadows", 1)?;
            let lit: Vec<Vec<bool>> = lights.iter().map(|light| visible(&texels, &model.caster, *light)).collect();
            let images = StackImages(stack);
            let field = MeasuredField { images: &images, texels: &texels, views: &views };
            let truth = |view: usize, light: usize, at: [f64; 2]| -> Result<[f32; 3], FlattenError> {
                Ok(images.image(view, light)?.at(at[0], at[1]))
            };
            let mut probes = AllProbes {
                at_samples: Some(Probes::at_samples(PROBES / 8, &decoder, &views, &lights, truth)?),
                between: None,
            };
            let lit = |light: usize, texel: usize| lit[light][texel];
            let diffuse = pass.run(&field, &lit, &mut probes.each(), &mut parts, watcher)?;
            (diffuse, probes)
        }
    };
    parts.write("diffuse", 4, |z| Ok(diffuse.to_bytes(z)), recipe)?;
    let decoder = FlatBtfDecoder::new(FlatBtfParts { diffuse, ..decoder.into_parts() })?;

    let seen = masks.iter().flatten().filter(|seen| **seen).count() as f64;
    let never_seen = (0..texels.points.len()).filter(|texel| !masks.iter().any(|mask| mask[*texel])).count();
    let report = AssetReport {
        mended: job.geometry.weld,
        parameterisation: model.parameterisation.report,
        heights: model.mesh.height_range(),
        seen: seen / (views.len() * texels.points.len()) as f64,
        never_seen,
        errors: errors.measure(&decoder, recipe.form),
    };
    let asset = AssetFile {
        version: 1,
        name: job.name.to_owned(),
        source: job.geometry.name,
        materials: job.materials,
        images_over_the_tile: match &job.values {
            Values::Computed(appearance) => appearance.colour.is_some() || appearance.weights.is_some(),
            Values::Measured(_) => false,
        },
        settings: recipe.settings(),
        parts: parts.files.clone(),
        report,
    };
    parts.remove_stale();
    let text = serde_json::to_string_pretty(&asset).expect("plain data") + "\n";
    write(&listing, text.as_bytes())?;
    Ok(asset)
}

fn begin(watcher: &dyn FlattenWatcher, name: &'static str, steps: usize) -> Result<(), FlattenError> {
    if watcher.stage(name, steps) { Ok(()) } else { Err(FlattenError::Cancelled) }
}

/// What a pass over all views needs.
struct Pass<'a> {
    recipe: &'a FlattenRecipe,
    model: &'a MesoModel,
    texels: &'a TexelMap,
    views: &'a [Vector],
    lights: &'a [Vector],
    masks: &'a [Vec<bool>],
}

impl Pass<'_> {
    /// Makes and writes the views, a few at a time, and fits the diffuse colours on the way.
    fn run<F: LightField>(
        &self,
        field: &F,
        lit: &(impl Fn(usize, usize) -> bool + Sync),
        probes: &mut [&mut Probes],
        parts: &mut Parts<'_>,
        watcher: &dyn FlattenWatcher,
    ) -> Result<DiffuseMap, FlattenError>
    where
        FlattenError: From<F::Error>,
    {
        let full = self.recipe.form == Form::Full;
        let guide = match self.recipe.fill {
            FillMethod::Poisson if full => {
                begin(watcher, "guide", 1)?;
                Some(Guide::new(field, self.masks, &from_above(self.views), self.lights.len())?)
            }
            _ => None,
        };
        begin(watcher, "views", self.views.len())?;
        let mut fit = DiffuseFit::new(self.texels.points.len());
        let at_once = rayon::current_num_threads().clamp(1, MOST_VIEWS_AT_ONCE);
        let count = self.views.len() as u32;
        for batch in (0..self.views.len()).collect::<Vec<_>>().chunks(at_once) {
            let made: Vec<_> = batch
                .par_iter()
                .map(|view| {
                    let pack = self.view(field, *view, guide.as_ref())?;
                    let bytes = full.then(|| pack.to_bytes(self.recipe.supercompress));
                    Ok::<_, FlattenError>((pack, bytes))
                })
                .collect::<Result<_, _>>()?;
            for (view, (pack, bytes)) in batch.iter().zip(made) {
                let value = |light: usize, texel: usize| rgb9e5::decode(pack.light(light as u32)[texel]);
                fit.add_view(self.texels, &self.masks[*view], self.lights, lit, value);
                if let Some(bytes) = bytes {
                    probes.iter_mut().for_each(|probes| probes.add_view(&pack));
                    parts.add(&view_part(*view as u32, count), bytes, 4 * pack.texels().len() as u64)?;
                }
                if !watcher.step() {
                    return Err(FlattenError::Cancelled);
                }
            }
        }
        let found = fit.reflectances();
        let known: Vec<bool> = found.iter().map(Option::is_some).collect();
        let mut colours: Vec<[f32; 3]> = found.into_iter().map(Option::unwrap_or_default).collect();
        PushPull::new(&known).fill(&mut colours);
        Ok(DiffuseMap::from_colours(self.recipe.flat_texels as u32, &colours)?)
    }

    /// One view with all its lights.
    fn view<F: LightField>(&self, field: &F, view: usize, guide: Option<&Guide>) -> Result<FlatView, FlattenError>
    where
        FlattenError: From<F::Error>,
    {
        let holes = match (self.recipe.form, guide) {
            (Form::Light, _) => Holes::Black,
            (Form::Full, Some(guide)) => Holes::Poisson(guide),
            (Form::Full, None) => Holes::PushPull,
        };
        let flattened = Flattened::new(field, view, &self.masks[view], holes)?;
        let layer = |light: usize| -> Result<Vec<u32>, F::Error> {
            Ok(flattened.image(light)?.into_iter().map(rgb9e5::encode).collect())
        };
        let layers: Vec<Vec<u32>> = (0..self.lights.len()).into_par_iter().map(layer).collect::<Result<_, _>>()?;
        let header = FlatHeader {
            size: self.recipe.flat_texels as u32,
            view: view as u32,
            views: angles(&self.recipe.views),
            lights: angles(&self.recipe.lights),
        };
        Ok(FlatView::new(header, layers.concat())?)
    }
}

impl Pass<'_> {
    /// Writes the images of the ordinary BTF, as many texels per side as the reference plane has.
    fn write_images(
        &self,
        appearance: &Appearance,
        folder: &Path,
        format: StackFormat,
        watcher: &dyn FlattenWatcher,
    ) -> Result<(), FlattenError> {
        begin(watcher, "images", self.views.len())?;
        let size = self.recipe.indirection.size as usize;
        for (view, direction) in self.views.iter().enumerate() {
            let seen = ViewImage::new(self.model, *direction, size, self.recipe.oversampling);
            let write = |light: usize| {
                let image = seen.direct(self.model, appearance, self.lights[light]);
                // Row 0 of a picture is its top.
                let rows: Vec<[f32; 3]> = image.chunks_exact(size).rev().flatten().copied().collect();
                let angles =
                    ImageAngles { light: self.recipe.lights.angles[light], view: self.recipe.views.angles[view] };
                write_image(folder, light * self.views.len() + view, angles, &rows, [size; 2], format)
                    .map_err(|error| FlattenError::Write { path: folder.display().to_string(), error })
            };
            (0..self.lights.len()).into_par_iter().try_for_each(|light| write(light).map(drop))?;
            if !watcher.step() {
                return Err(FlattenError::Cancelled);
            }
        }
        Ok(())
    }
}

/// Polar angles and azimuths in radians.
fn angles(set: &DirectionSet) -> Vec<[f32; 2]> {
    set.angles.iter().map(|a| a.map(|degrees| degrees.to_radians() as f32)).collect()
}

/// Look-ups of both kinds.
struct AllProbes {
    at_samples: Option<Probes>,
    between: Option<Probes>,
}

impl AllProbes {
    fn each(&mut self) -> Vec<&mut Probes> {
        self.at_samples.iter_mut().chain(self.between.iter_mut()).collect()
    }

    fn measure(&self, decoder: &FlatBtfDecoder, form: Form) -> AssetErrors {
        let full = |probes: &Option<Probes>| -> Option<ColourErrors> {
            probes.as_ref().filter(|_| form == Form::Full).map(Probes::full)
        };
        let light = self.between.as_ref().or(self.at_samples.as_ref());
        AssetErrors {
            at_samples: full(&self.at_samples),
            between_samples: full(&self.between),
            light_form: light.map(|probes| probes.light_form(decoder)),
        }
    }
}

fn computed_probes(
    pass: &Pass<'_>,
    decoder: &FlatBtfDecoder,
    appearance: &Appearance,
) -> Result<AllProbes, FlattenError> {
    if pass.recipe.bounces > 0 {
        return Ok(AllProbes { at_samples: None, between: None });
    }
    let truth = |view: usize, light: usize, at: [f64; 2]| -> Result<[f32; 3], FlattenError> {
        Ok(shown(pass.model, appearance, at, pass.views[view], pass.lights[light]))
    };
    let at_samples = Probes::at_samples(PROBES, decoder, pass.views, pass.lights, truth)?;
    let (view_mesh, light_mesh) = (DirectionMesh::new(&pass.recipe.views)?, DirectionMesh::new(&pass.recipe.lights)?);
    let views = Directions { all: pass.views, mesh: &view_mesh };
    let lights = Directions { all: pass.lights, mesh: &light_mesh };
    let between = Probes::between_samples(PROBES, decoder, &views, &lights, pass.model, appearance);
    Ok(AllProbes { at_samples: Some(at_samples), between: Some(between) })
}

/// Images of a stack.
struct StackImages<'a>(&'a BtfStack);

impl ViewImages for StackImages<'_> {
    type Error = InputError;

    fn image(&self, view: usize, light: usize) -> Result<TileImage<3>, InputError> {
        let image = self.0.view(view, light)?;
        Ok(TileImage { width: image.width, height: image.height, pixels: image.pixels })
    }
}

/// The files of an asset.
struct Parts<'a> {
    job: &'a str,
    folder: &'a Path,
    files: BTreeMap<String, PartFile>,
}

impl Parts<'_> {
    fn path(&self, file: &str) -> PathBuf {
        self.folder.join(file)
    }

    /// Writes a square part of `texel_bytes` for each texel of what `bytes` makes.
    fn write(
        &mut self,
        part: &str,
        texel_bytes: u64,
        bytes: impl FnOnce(bool) -> Result<Vec<u8>, FlattenError>,
        recipe: &FlattenRecipe,
    ) -> Result<(), FlattenError> {
        let flat = (recipe.flat_texels * recipe.flat_texels) as u64;
        let [width, height] = recipe.indirection.extent().map(u64::from);
        let texels = match part {
            "indirection" => width * height,
            "reference" => u64::from(recipe.indirection.size).pow(2),
            "mask" => flat * recipe.views.len() as u64,
            _ => flat,
        };
        self.add(part, bytes(recipe.supercompress)?, texels * texel_bytes)
    }

    fn add(&mut self, part: &str, bytes: Vec<u8>, gpu_bytes: u64) -> Result<(), FlattenError> {
        let file = format!("{}.{part}.ktx2", self.job);
        write(&self.path(&file), &bytes)?;
        self.files.insert(part.to_owned(), PartFile { file, bytes: bytes.len() as u64, gpu_bytes });
        Ok(())
    }

    /// Views of an earlier asset of the same name that had more of them.
    fn remove_stale(&self) {
        let prefix = format!("{}.flat.", self.job);
        let Ok(entries) = std::fs::read_dir(self.folder) else { return };
        for entry in entries.flatten() {
            let name = entry.file_name();
            let Some(name) = name.to_str() else { continue };
            let is_view =
                name.strip_prefix(&prefix).and_then(|rest| rest.strip_suffix(".ktx2")).is_some_and(|number| {
                    (3..=4).contains(&number.len()) && number.bytes().all(|byte| byte.is_ascii_digit())
                });
            if is_view && !self.files.values().any(|part| part.file == name) {
                let _ = std::fs::remove_file(entry.path());
            }
        }
    }
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), FlattenError> {
    write_atomic(path, bytes).map_err(|error| FlattenError::Write { path: path.display().to_string(), error })
}
