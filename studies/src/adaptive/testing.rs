//! Materials in environments, for tests of fits.

use super::{Light, Lighting, LitBalls, StudyMaterial, training_environments};
use brdfc_core::address::parse_synth;
use brdfc_formats::environment::EnvironmentDecoder;
use brdfc_jobs::environment::prefilter_image;

/// Passes balls of a model in two of the environments of fits, a studio and a room, to `run`.
pub(super) fn balls_of(address: &str, run: impl FnOnce(&LitBalls<'_>)) {
    let source = parse_synth(address).unwrap();
    let material = StudyMaterial::new(address.to_owned(), source.as_ref()).unwrap();
    let light = |(name, image)| {
        let filtered = EnvironmentDecoder::new(&prefilter_image(&image, Some(64), &()).unwrap());
        Light { name, lighting: Lighting::new(image).unwrap(), filtered }
    };
    let lights: Vec<Light> = training_environments().into_iter().skip(2).map(light).collect();
    run(&LitBalls::new(&material, &lights));
}
