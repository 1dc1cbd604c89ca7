//! Renderings of polynomial wavelet trees.

use super::arguments::Arguments;
use super::asset::name_of;
use super::materials::Subject;
use super::{gpu, outputs, scene};
use crate::output::{note, remark};
use crate::{Common, Error};
use brdfc::inspect::Kind;
use brdfc::relight::CodeValues;
use brdfc::render::{
    Builtin, DistantPhotographs, FrameBlock, LinearImage, Photograph, PwtDecoder, PwtMaterial, PwtPack, Verification,
    Views, distant_light, draw_photographs, draw_pwt, draw_pwt_on_cpu, image_scene, nearest_photograph,
};
use brdfc::{FormatError, Input};

/// Default pixels of the rendering's longer side.
const LONGER_SIDE: usize = 512;

/// Draws the pack with the shader and on the CPU, and the photographs of its RTI capture if it is given.
pub(super) fn verification(
    arguments: &Arguments,
    common: Common,
    input: &Input,
    subject: &Subject,
    pack: PwtPack,
) -> Result<(Verification, Views), Error> {
    let header = pack.header().clone();
    let size = header.size.map(|side| side as usize);
    let longer = size[0].max(size[1]);
    let side = |side: usize| (side * LONGER_SIDE).div_ceil(longer);
    let of_builtin = |builtin: Builtin, frame: [usize; 2]| match builtin {
        Builtin::Plane => image_scene(size, frame),
        other => other.scene(),
    };
    let start = scene::Start { builtin: Builtin::Plane, size: size.map(side), scene: &of_builtin };
    let mut setup = scene::setup_from(arguments, subject, &start)?;
    let stack =
        arguments.source.as_ref().map(|source| open_capture(source, size, arguments.images.codes)).transpose()?;
    if let (Some(stack), Some(source)) = (&stack, &arguments.source) {
        stack.notes().iter().for_each(|line| note(common, source, line));
    }
    if let Some(stack) = stack.as_ref().filter(|_| setup.builtin == Builtin::Plane) {
        let of_manifest = subject.manifest().is_some_and(|manifest| manifest.render.lights.is_some());
        if !of_manifest {
            // Use the light of a photograph, so that the rendering can be compared with it.
            for light in &mut setup.scene.lights {
                let (nearest, _) = nearest_photograph(stack.capture(), light);
                *light = distant_light(stack.capture().lights()[nearest].map(f64::from));
            }
        }
    }
    let gpu = gpu::open(arguments)?;
    let bytes_on_gpu = pack.gpu_bytes();
    let wrong = |error: FormatError| Error::wrong_usage("--repeat", error.found, error.allowed);
    let material = PwtMaterial::new(PwtDecoder::new(pack), arguments.repeat.unwrap_or(1)).map_err(wrong)?;
    let sampling = if arguments.exact { FrameBlock::exact() } else { FrameBlock::default() };
    let shader = draw_pwt(&gpu, &setup.scene, setup.frame, &material, sampling)?;
    let pack = draw_pwt_on_cpu(&setup.scene, setup.frame, &material);
    let source = match &stack {
        Some(stack) if setup.builtin == Builtin::Plane => {
            Some(of_photographs(&setup, stack, header.repeats, material.repeat(), common)?)
        }
        Some(_) => {
            let why = "not compared with photographs: that requires --scene plane";
            note(common, input, why);
            None
        }
        None => None,
    };
    let views = Views { shader, pack, table: None, source, source_with_noise: None, left_out: 0.0 };
    let verification = setup.verification(&gpu, &views, |_| (name_of(input), bytes_on_gpu));
    outputs::write(arguments, &views, verification.exposure)?;
    Ok((verification, views))
}

/// Opens the photographs to compare a pack with.
fn open_capture(source: &Input, size: [usize; 2], codes: Option<CodeValues>) -> Result<DistantPhotographs, Error> {
    let (Kind::RtiCapture, Some(path)) = (Kind::of(source)?, source.path()) else {
        return Err(Error::wrong_usage("--source", source, "the folder or the .lp of an RTI capture"));
    };
    let photographs = DistantPhotographs::open(path, codes)?;
    let found = photographs.capture().size();
    if found != size {
        let [found, expected] = [found, size].map(|[width, height]| format!("{width} x {height} pixels"));
        let text = format!("--source: {source}: found {found}, expected {expected}, the size of the pack");
        return Err(Error::input(text));
    }
    Ok(photographs)
}

/// Draws the photograph that is nearest to each light.
fn of_photographs(
    setup: &scene::Setup,
    photographs: &DistantPhotographs,
    repeats: bool,
    repeat: u32,
    common: Common,
) -> Result<LinearImage, Error> {
    let mut drawn = Vec::new();
    for light in &setup.scene.lights {
        let (number, angle) = nearest_photograph(photographs.capture(), light);
        let image = photographs.image(number)?;
        let file = photographs
            .capture()
            .file(number)
            .file_name()
            .map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        remark(common, &format!("compared with {file}; its light is {angle:.1}° from the light of the rendering"));
        drawn.push(Photograph::new([image.width, image.height], image.pixels, repeats));
    }
    Ok(draw_photographs(&setup.scene, setup.frame, &drawn, repeat))
}
