//! Resolves flags and manifest to a scene: the command line overrides the manifest, which overrides the scene's defaults.

use super::arguments::Arguments;
use super::materials::Subject;
use super::outputs;
use crate::Error;
use brdfc::render::{Builtin, Frame, Gpu, PartMaterial, PointLight, Scene, Verification, Views};
use brdfc::scene::{LightSection, MAX_SIDE, ManifestError, RenderSection, line_of, near_miss};
use brdfc::{Input, environment};
use brdfc_terminal::words::{self, one_of};
use std::path::Path;
use toml::Spanned;

/// Default pixels per side.
const DEFAULT_SIDE: usize = 512;
/// Default pixels per side of each rendering of a contact sheet.
const CONTACT_SIDE: usize = 160;
/// Maximum samples of an image; each takes about 50 bytes of memory.
const MAX_ALL_SAMPLES: u64 = 1 << 25;
/// Default samples per pixel and axis.
const DEFAULT_SAMPLES: usize = 2;

/// Scene, frame and materials.
pub(super) struct Setup {
    pub(super) builtin: Builtin,
    pub(super) scene: Scene,
    pub(super) frame: Frame,
    pub(super) exposure: Option<f64>,
    /// Name of each part's material.
    pub(super) names: Vec<String>,
}

impl Setup {
    /// Lists the parts with the name and the bytes of their materials; `material` returns both by the number of the part.
    pub(super) fn parts(&self, material: impl Fn(usize) -> (String, u64)) -> Vec<PartMaterial> {
        let listed = self.scene.parts.iter().enumerate().map(|(number, part)| {
            let (material, bytes_on_gpu) = material(number);
            PartMaterial { part: part.name.to_owned(), material, bytes_on_gpu }
        });
        listed.collect()
    }

    /// Compares the renderings of parts with these materials.
    pub(super) fn verification(
        &self,
        gpu: &Gpu,
        views: &Views,
        material: impl Fn(usize) -> (String, u64),
    ) -> Verification {
        let parts = self.parts(material);
        Verification::new(self.builtin.name(), self.frame, views, self.exposure, gpu.description(), parts)
    }
}

/// Defaults for settings that neither flags nor a manifest set.
pub(super) struct Start<'a> {
    pub(super) builtin: Builtin,
    /// Width and height in pixels.
    pub(super) size: [usize; 2],
    /// Makes a scene with its own camera and lights, for renderings of this size.
    pub(super) scene: &'a dyn Fn(Builtin, [usize; 2]) -> Scene,
}

/// Resolves everything except the materials' values.
pub(super) fn setup(arguments: &Arguments, subject: &Subject) -> Result<Setup, Error> {
    let side = if arguments.contact.is_some() { CONTACT_SIDE } else { DEFAULT_SIDE };
    setup_from(
        arguments,
        subject,
        &Start { builtin: Builtin::Sphere, size: [side; 2], scene: &|builtin: Builtin, _| builtin.scene() },
    )
}

/// Resolves everything except the materials' values, with other defaults.
pub(super) fn setup_from(arguments: &Arguments, subject: &Subject, start: &Start<'_>) -> Result<Setup, Error> {
    let absent = RenderSection::default();
    // The [render] table of a manifest applies to its own scene.
    let shown = subject.manifest().filter(|_| arguments.contact.is_none());
    let section = shown.map_or(&absent, |manifest| &manifest.render);
    let builtin = builtin(arguments, subject, section, start.builtin)?;
    let (width, height) = match &arguments.size {
        Some(text) => size(text)?,
        None => (section.width.unwrap_or(start.size[0]), section.height.unwrap_or(start.size[1])),
    };
    let mut scene = (start.scene)(builtin, [width, height]);
    let camera = &section.camera;
    scene.camera.eye = camera.eye.unwrap_or(scene.camera.eye);
    scene.camera.target = camera.target.unwrap_or(scene.camera.target);
    scene.camera.up = camera.up.unwrap_or(scene.camera.up);
    scene.camera.field_of_view = camera.field_of_view.unwrap_or(scene.camera.field_of_view);
    if !scene.camera.is_valid() {
        let camera = scene.camera;
        return Err(Error::input(format!(
            "{}: render.camera: found eye {:?}, target {:?}, up {:?}, expected vectors that span a view",
            arguments.input, camera.eye, camera.target, camera.up
        )));
    }
    if let Some(lights) = &section.lights {
        let light = |l: &LightSection| PointLight { position: l.position, intensity: l.intensity.colour() };
        scene.lights = lights.iter().map(light).collect();
    }
    if let Some(input) = environment_input(arguments, subject, section) {
        if let Some(path) = input.path() {
            outputs::check_not_over(arguments, path)?;
        }
        // Lobes look cube maps up as they are, and prefiltered.
        if !(arguments.by_lobes() && is_cube_map(&input)?) {
            scene.environment = environment::open_image(&input)?;
        }
    }
    let samples = match arguments.adaptive.adaptive {
        true => arguments.adaptive.points_per_axis(),
        false => arguments.samples.or(section.samples).unwrap_or(DEFAULT_SAMPLES),
    };
    let count = width as u64 * height as u64 * (samples * samples) as u64;
    if count > MAX_ALL_SAMPLES {
        return Err(Error::usage(format!(
            "--size and --samples: found {width} x {height} pixels of {} samples, expected at most {MAX_ALL_SAMPLES}",
            samples * samples
        )));
    }
    if let Some(exposure) = arguments.exposure
        && !(exposure > 0.0 && exposure.is_finite())
    {
        return Err(Error::wrong_usage("--exposure", words::format_number(exposure), "a positive number"));
    }
    let exposure = arguments.exposure.or(section.exposure);
    let names = names(arguments, subject, builtin)?;
    Ok(Setup { builtin, scene, frame: Frame { width, height, samples }, exposure, names })
}

fn size(text: &str) -> Result<(usize, usize), Error> {
    let side = |part: &str| part.parse::<usize>().ok().filter(|side| (1..=MAX_SIDE).contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| Error::wrong_usage("--size", words::quoted(text), format!("WIDTHxHEIGHT, each 1 to {MAX_SIDE}")))
}

fn builtin(
    arguments: &Arguments,
    subject: &Subject,
    section: &RenderSection,
    default: Builtin,
) -> Result<Builtin, Error> {
    if let Some(name) = arguments.scene {
        return Ok(name);
    }
    let Some(name) = &section.scene else { return Ok(default) };
    let known = Builtin::NAMES.map(|(name, _)| name);
    Builtin::NAMES
        .into_iter()
        .find(|(text, _)| text == name.get_ref())
        .map(|(_, builtin)| builtin)
        .ok_or_else(|| at(subject, name, "render.scene", &known))
}

/// Returns the material of each part: from the manifest, or else its materials in turn.
fn names(arguments: &Arguments, subject: &Subject, builtin: Builtin) -> Result<Vec<String>, Error> {
    let turn = materials_in_turn(arguments, subject)?;
    let Subject::Scene { manifest, .. } = subject else {
        return Ok(vec![turn[0].clone(); builtin.parts().len()]);
    };
    let materials: Vec<&str> = manifest.materials.keys().map(String::as_str).collect();
    let given = &manifest.render.materials;
    for (part, material) in given {
        // The manifest may name parts of another scene than --scene.
        let known: Vec<&str> = Builtin::NAMES.iter().flat_map(|(_, scene)| scene.parts()).copied().collect();
        if !known.contains(&part.get_ref().as_str()) {
            return Err(at(subject, part, "part in [render.materials]", builtin.parts()));
        }
        if !materials.contains(&material.get_ref().as_str()) {
            return Err(at(subject, material, &format!("render.materials.{}", part.get_ref()), &materials));
        }
    }
    let mut next = turn.iter().cycle();
    let of_part = |part: &&str| match given.iter().find(|(name, _)| name.get_ref() == part) {
        Some((_, material)) => material.get_ref().clone(),
        None => next.next().expect("there are materials").clone(),
    };
    Ok(builtin.parts().iter().map(of_part).collect())
}

/// Returns the materials that the scene uses, or all if no use is listed; without a manifest, the input.
pub(super) fn materials_in_turn(arguments: &Arguments, subject: &Subject) -> Result<Vec<String>, Error> {
    let Some(manifest) = subject.manifest() else { return Ok(vec![arguments.input.to_string()]) };
    if let Some(asset) = &manifest.render.asset {
        return Ok(vec![asset.clone()]);
    }
    let is_used = |name: &&String| manifest.uses.iter().any(|used| used.material.get_ref() == *name);
    let used: Vec<String> = manifest.materials.keys().filter(is_used).cloned().collect();
    let all = if used.is_empty() { manifest.materials.keys().cloned().collect() } else { used };
    if all.is_empty() {
        let text = format!("{}: no materials to draw; add [materials.NAME] with source = \"...\"", arguments.input);
        return Err(Error::input(text));
    }
    Ok(all)
}

fn at(subject: &Subject, name: &Spanned<String>, field: &str, known: &[&str]) -> Error {
    let Subject::Scene { path, text, .. } = subject else {
        return Error::internal("only manifests have spans");
    };
    let error = ManifestError {
        line: line_of(text, Some(name.span())),
        field: field.to_owned(),
        found: words::quoted(name.get_ref()),
        allowed: one_of(known),
        suggestion: near_miss(name.get_ref(), known),
    };
    Error::input(format!("{}: {error}", path.display()))
}

/// Selects the image of the surroundings: of the light with --adaptive, else of the reflections in mirrors.
fn environment_input(arguments: &Arguments, subject: &Subject, section: &RenderSection) -> Option<Input> {
    if let Some(input) = &arguments.adaptive.environment {
        return Some(input.clone());
    }
    let Subject::Scene { path, .. } = subject else { return None };
    let mirrored = section.environment.as_ref().map(|file| path.parent().unwrap_or(Path::new("")).join(file));
    let lights = subject.environment();
    let file = if arguments.adaptive.adaptive { lights.or(mirrored) } else { mirrored.or(lights) };
    file.map(|file| Input::from(file.as_path()))
}

/// Returns true for a cube map or a prefiltered environment, and false for an image.
pub(super) fn is_cube_map(input: &Input) -> Result<bool, Error> {
    Ok(input.extension()? == "ktx2")
}
