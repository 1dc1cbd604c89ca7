//! Light of an environment, which lobes look up.

use super::arguments::Arguments;
use super::materials::{Prepared, Subject, distinct};
use super::scene::{Setup, is_cube_map};
use crate::output::{note, note_repairs, remark};
use crate::progress::Materials;
use crate::{Common, Error};
use brdfc::encode::encode as encode_pack;
use brdfc::environment::{self, EnvironmentPack};
use brdfc::inspect::AnyPack as Pack;
use brdfc::lobes::{LobesPack, LobesRecipe, encode};
use brdfc::render::{
    Decoding, Environment, Gpu, LinearImage, Material, PrefilteredLight, Scene, Tabulated, Views, converged_integral,
    draw_integral, integral_material, lobes_views, tabulated, views,
};
use brdfc::scene::EnvironmentJob;
use brdfc::{Input, PackRecipe, Progress as _, Source};
use std::fmt::Display;

/// An environment that lights a scene.
pub(super) struct Light {
    prefiltered: PrefilteredLight,
    /// Its radiance, for the reference.
    image: Environment,
}

impl Light {
    /// Resolves the light of the command line, or else of the manifest's scene, or else the sky of the scene. Mirrors of the
    /// scene reflect what the command line selects.
    pub(super) fn of(
        arguments: &Arguments,
        subject: &Subject,
        scene: &mut Scene,
        common: Common,
    ) -> Result<Self, Error> {
        let progress = Materials::new(1, false, common);
        let part = progress.part("environment");
        if let Some(input) = &arguments.adaptive.environment {
            // An image is the environment of the scene already.
            if is_cube_map(input)? {
                let (pack, image) = environment::open_with_image(input, part.as_ref())?;
                scene.environment = image.clone();
                return Ok(Self { prefiltered: PrefilteredLight::new(pack), image });
            }
        } else if let Some(file) = subject.environment() {
            let surroundings = environment::open_surroundings(&Input::from(file.as_path()))?;
            let pack = match built(subject)? {
                Some(pack) => pack,
                None => surroundings.prefilter(None, part.as_ref())?,
            };
            return Ok(Self { prefiltered: PrefilteredLight::new(pack), image: surroundings.into_image() });
        }
        let pack = environment::prefilter(&scene.environment, None, part.as_ref())?;
        Ok(Self { prefiltered: PrefilteredLight::new(pack), image: scene.environment.clone() })
    }

    /// Bytes on a GPU.
    pub(super) fn gpu_bytes(&self) -> u64 {
        self.prefiltered.pack().gpu_bytes()
    }

    /// Resolves the light of a scene, if it lights one of the drawn materials by its lobes.
    pub(super) fn of_scene(
        arguments: &Arguments,
        subject: &Subject,
        names: &[String],
        scene: &mut Scene,
        common: Common,
    ) -> Result<Option<Self>, Error> {
        let given = arguments.adaptive.environment.as_ref().filter(|_| arguments.by_lobes());
        let is_lit = subject.has_lobes(names);
        if is_lit || (given.is_none() && subject.environment().is_some()) {
            for name in distinct(names).into_iter().filter(|name| subject.lacks_lobes(name)) {
                note(common, name, "the environment does not light it: maps of its uses have no lobes");
            }
        }
        if !is_lit {
            if let Some(input) = given {
                note(common, input, "lights no material: their uses are lit by points, or have no lobes (maps)");
                // Mirrors reflect it. An image is the environment of the scene already.
                if is_cube_map(input)? {
                    scene.environment = environment::open_image(input)?;
                }
            }
            return Ok(None);
        }
        Self::of(arguments, subject, scene, common).map(Some)
    }

    /// Draws what this light adds to a scene. `of_parts` are the numbers of the parts' materials. The reference is the integral
    /// over all directions, if every material with lobes has a source.
    pub(super) fn views(
        &self,
        arguments: &Arguments,
        setup: &Setup,
        gpu: &Gpu,
        (materials, of_parts): (&[Lit<'_>], &[usize]),
        common: Common,
    ) -> Result<Views, Error> {
        let lobes: Vec<Option<&LobesPack>> = of_parts.iter().map(|part| materials[*part].lobes).collect();
        let lit = || materials.iter().filter(|material| material.lobes.is_some());
        if !lit().all(|material| material.source.is_some()) {
            return Ok(lobes_views(gpu, &setup.scene, setup.frame, &self.prefiltered, &lobes, |_| None)?);
        }
        // The integral looks the source up far too often for a scan.
        let tables = materials.iter().map(|material| material.tabulated(common)).collect::<Result<Vec<_>, _>>()?;
        let sources = materials.iter().zip(&tables).map(|(material, table)| match table {
            Some(table) => Some(&table.source as &dyn Source),
            None => material.lit_source(),
        });
        let integrals = sources.map(|source| source.map(integral_material).transpose());
        let integrals = integrals.collect::<Result<Vec<_>, _>>()?;
        let integrals: Vec<_> = of_parts.iter().map(|part| integrals[*part].as_ref()).collect();
        let integral = |shader: &LinearImage| {
            remark(common, "the integral over the environment, on the CPU");
            let scene = Scene { environment: self.image.clone(), ..setup.scene.clone() };
            Some(match arguments.adaptive.truth {
                Some(directions) => draw_integral(&scene, setup.frame, &integrals, directions),
                None => converged_integral(&scene, setup.frame, &integrals, shader),
            })
        };
        Ok(lobes_views(gpu, &setup.scene, setup.frame, &self.prefiltered, &lobes, integral)?)
    }
}

/// Draws materials under the point lights of a scene, and adds the light of an environment. `of_parts` are the numbers of the
/// parts' materials.
pub(super) fn lit_views(
    arguments: &Arguments,
    subject: &Subject,
    setup: &Setup,
    gpu: &Gpu,
    (prepared, of_parts, decoding): (&[Prepared], &[usize], Decoding),
    light: Option<&Light>,
    common: Common,
) -> Result<Views, Error> {
    let is_dark = |part: &&usize| !subject.is_lit_by_points(&prepared[**part].name);
    let black = of_parts.iter().find(is_dark).map(|_| black()).transpose()?;
    let under_points = |part: &usize| match &black {
        Some(black) if is_dark(&part) => black.material(),
        _ => prepared[*part].material(),
    };
    let materials: Vec<Material<'_>> = of_parts.iter().map(under_points).collect();
    let mut views = views(gpu, &setup.scene, setup.frame, &materials, decoding)?;
    let lit: Vec<Lit<'_>> = prepared.iter().map(Prepared::lit).collect();
    if let Some(light) = light.filter(|_| lit.iter().any(|material| material.lobes.is_some())) {
        views.add_light(&light.views(arguments, setup, gpu, (&lit, of_parts), common)?);
    }
    Ok(views)
}

/// A material that reflects nothing, for parts that no point light lights.
fn black() -> Result<Prepared, Error> {
    let source = brdfc::inspect::open("synth:lambert?kd=0", None)?.source;
    let pack = encode_pack(source.as_ref(), &PackRecipe::default().without_measuring(), &())?.pack;
    Ok(Prepared { name: "black".to_owned(), pack, source: Some(source), table: None, lobes: None, maps: Vec::new() })
}

/// Lobes and source of a material, if available.
#[derive(Clone, Copy)]
pub(super) struct Lit<'a> {
    pub(super) name: &'a str,
    pub(super) lobes: Option<&'a LobesPack>,
    pub(super) source: Option<&'a dyn Source>,
}

impl<'a> Lit<'a> {
    /// Source for the integral over an environment; `None` without lobes.
    fn lit_source(&self) -> Option<&'a dyn Source> {
        self.source.filter(|_| self.lobes.is_some())
    }

    /// Table that replaces a scan in the integral.
    fn tabulated(&self, common: Common) -> Result<Option<Tabulated>, Error> {
        let table = self.lit_source().map(|source| tabulated(source, &())).transpose()?.flatten();
        if let Some(table) = &table {
            note(common, &self.name, &format!("in the reference, {}", table.summary()));
        }
        Ok(table)
    }
}

/// The prefiltered environment of a folder of packs.
fn built(subject: &Subject) -> Result<Option<EnvironmentPack>, Error> {
    let Subject::Scene { packs: Some(packs), environment: Some(job), .. } = subject else { return Ok(None) };
    let job = EnvironmentJob { maps: [true, false], ..job.clone() };
    match packs.environment(&job, &())?.pop() {
        Some(Pack::Environment(pack)) => Ok(Some(pack)),
        _ => Err(Error::internal("the store contains no prefiltered environment")),
    }
}

/// Fits lobes to a material, and reports limits that they miss.
pub(super) fn fitted(
    name: &impl Display,
    source: &dyn Source,
    recipe: &LobesRecipe,
    common: Common,
) -> Result<LobesPack, Error> {
    let progress = Materials::new(1, false, common);
    let encoded = encode(source, recipe, progress.part(&name.to_string()).as_ref());
    let encoded = encoded.map_err(|error| error.prefixed(name))?;
    note_repairs(common, name, &encoded.tally);
    if let Some(missed) = brdfc::lobes::missed(&encoded, recipe) {
        note(common, name, &format!("lobes: {missed}"));
    }
    Ok(encoded.best().pack.clone())
}
