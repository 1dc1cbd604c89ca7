//! Textures of materials for `brdfc render --adaptive`: from the command line for all parts, or else from the uses of a
//! manifest.

use super::arguments::Arguments;
use super::materials::{Prepared, Subject, job_of};
use super::outputs;
use super::scene::Setup;
use crate::Error;
use crate::bandwidth::texture_size;
use crate::table::significant;
use brdfc::Input;
use brdfc::bandwidth::BandwidthMap;
use brdfc::inspect::AnyPack;
use brdfc::render::{AdaptiveMaterial, PartTexture, PartTextureReport, Texture, repeats, texture};

/// Textures of a scene, and the one of each part.
pub(super) struct Textures {
    all: Vec<(Input, Texture)>,
    of_parts: Vec<Option<Placed>>,
}

/// Size of the texture of the command line, if it has one.
pub(super) fn metres(arguments: &Arguments) -> Result<Option<[f64; 2]>, Error> {
    let size = || texture_size("--texture-size", arguments.adaptive.texture_size.as_deref());
    arguments.adaptive.texture.as_ref().map(|_| size()).transpose()
}

/// The texture of a part: its index, and its repetitions per unit of uv.
#[derive(Clone, Copy)]
struct Placed {
    texture: usize,
    repeats: [f32; 2],
}

impl Textures {
    /// Opens the textures of a scene. `metres` is the size of the command line's, `prepared` are its materials, `of_parts` the number of each part's material.
    pub(super) fn open(
        (arguments, metres): (&Arguments, Option<[f64; 2]>),
        subject: &Subject,
        setup: &Setup,
        (prepared, of_parts): (&[Prepared], &[usize]),
    ) -> Result<Self, Error> {
        let (mut all, mut of_materials) = (Vec::new(), vec![None; prepared.len()]);
        if let (Some(input), Some(metres)) = (&arguments.adaptive.texture, metres) {
            all.push((input.clone(), texture(input, metres, None)?));
            of_materials.fill(Some(0));
        } else {
            for (material, of_material) in prepared.iter().zip(&mut of_materials) {
                let Some(job) = subject.texture(&material.name) else { continue };
                outputs::check_not_over(arguments, &job.path)?;
                let input = Input::from(job.path.as_path());
                *of_material = Some(all.len());
                all.push((input.clone(), texture(&input, job.metres, built(material))?));
            }
        }
        let place = |(part, material): (usize, &usize)| {
            let Some(number) = of_materials[*material] else { return Ok(None) };
            placed(setup, part, number, &all[number]).map(Some)
        };
        let of_parts = of_parts.iter().enumerate().map(place).collect::<Result<_, Error>>()?;
        Ok(Self { all, of_parts })
    }

    /// The materials of all parts with their textures.
    pub(super) fn on<'a>(&'a self, materials: &[AdaptiveMaterial<'a>]) -> Vec<AdaptiveMaterial<'a>> {
        let of_part = |placed: &Option<Placed>| {
            let Placed { texture, repeats } = (*placed)?;
            let Texture { colours, bandwidth } = &self.all[texture].1;
            Some(PartTexture { colours, bandwidth, repeats })
        };
        let textures = self.of_parts.iter().map(of_part);
        materials.iter().zip(textures).map(|(material, texture)| AdaptiveMaterial { texture, ..*material }).collect()
    }

    /// Copies of the textures' maps without bandwidth, for comparisons; `None` without textures.
    pub(super) fn without_bandwidth(&self) -> Option<Self> {
        if self.of_parts.iter().all(Option::is_none) {
            return None;
        }
        let plain = |(input, texture): &(Input, Texture)| (input.clone(), texture.without_bandwidth());
        Some(Self { all: self.all.iter().map(plain).collect(), of_parts: self.of_parts.clone() })
    }

    /// Parts with textures, for the report.
    pub(super) fn report(&self, setup: &Setup) -> Vec<PartTextureReport> {
        let of_part = |(part, placed): (usize, &Option<Placed>)| {
            let Placed { texture, repeats } = (*placed)?;
            let (input, texture) = &self.all[texture];
            Some(PartTextureReport {
                part: setup.scene.parts[part].name.to_owned(),
                texture: input.to_string(),
                metres: texture.bandwidth.metres()?,
                repeats,
            })
        };
        self.of_parts.iter().enumerate().filter_map(of_part).collect()
    }
}

/// The map of a texture from a build.
fn built(material: &Prepared) -> Option<BandwidthMap> {
    material.maps.iter().find_map(|map| match map {
        AnyPack::Bandwidth(map) if map.metres().is_some() => Some(map.clone()),
        _ => None,
    })
}

fn placed(setup: &Setup, part: usize, number: usize, (input, texture): &(Input, Texture)) -> Result<Placed, Error> {
    let (part, metres) = (&setup.scene.parts[part], texture.bandwidth.metres().unwrap_or([1.0; 2]));
    let refuse = |[least, most]: [[f64; 2]; 2]| {
        let shown = |[width, height]: [f64; 2]| format!("{} x {} m", significant(width), significant(height));
        Error::usage(format!(
            "size of the texture {input}: found {}, expected {} to {} on the part {}",
            shown(metres.map(f64::from)),
            shown(least),
            shown(most),
            part.name
        ))
    };
    let repeats = repeats(&part.mesh, metres.map(f64::from)).map_err(refuse)?;
    Ok(Placed { texture: number, repeats })
}

impl Subject {
    /// The texture of a material in a manifest.
    fn texture(&self, name: &str) -> Option<brdfc::scene::TextureJob> {
        let Self::Scene { path, jobs, .. } = self else { return None };
        let folder = path.parent().unwrap_or(std::path::Path::new(""));
        job_of(jobs, name).uses.iter().find_map(|(_, used)| brdfc::scene::TextureJob::of(used, folder))
    }
}
