//! Learned terms as plain images, for formats without a tree.

use crate::candidates::Texels;
use crate::choose_learned::{MAX_LIGHTS, tried};
use crate::encoded::Padded;
use crate::project;
use crate::recipe::{DomainName, PwtRecipe};
use crate::stack::LightSamples;
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{LightCoordinates, LightMap};

/// Learned terms of photographs.
pub struct LearnedTerms {
    /// Terms of the light, the mean first.
    pub map: LightMap,
    /// Coefficients of each further term, row by row from the top.
    pub planes: Vec<Vec<f32>>,
}

/// Learns at most `count` terms of sRGB-encoded values, without the mean.
///
/// # Errors
/// Returns an error if images or `count` are out of range.
pub fn learned_terms(samples: &LightSamples, count: u32) -> Result<LearnedTerms, FormatError> {
    let recipe = PwtRecipe {
        coordinates: Some(LightCoordinates::Learned),
        degree: Some(count),
        domain: Some(DomainName::Display),
        ..PwtRecipe::default()
    };
    samples.check()?;
    let samples = &*samples.at_most(MAX_LIGHTS);
    recipe.check()?;
    let (candidate, _) = tried(&Texels::new(samples), samples, &recipe);
    let (learned, domain) = (candidate.learn(samples), candidate.candidate().domain());
    let planes = project::coefficients(&learned, &Padded::new(samples, domain, samples.size));
    Ok(LearnedTerms { map: learned.map, planes })
}
