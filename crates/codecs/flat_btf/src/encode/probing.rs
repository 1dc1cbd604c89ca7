//! Probes the finished maps to measure errors.

use super::pass::Pass;
use super::report::AssetErrors;
use crate::measured::ViewImages;
use crate::probes::{Directions, Probes, direct_radiance};
use crate::surface::Appearance;
use brdfc_formats::FormatError;
use brdfc_formats::direction_mesh::DirectionMesh;
use brdfc_formats::flat_btf::FlatBtfDecoder;
use std::convert::Infallible;

/// Probes of each kind. Measured BTFs use an eighth of them, because each reads an image.
const PROBES: usize = 4096;

/// Probes of both kinds.
pub(super) struct AllProbes {
    at_samples: Option<Probes>,
    between: Option<Probes>,
}

impl AllProbes {
    pub(super) fn each(&mut self) -> Vec<&mut Probes> {
        self.at_samples.iter_mut().chain(self.between.iter_mut()).collect()
    }

    /// Errors of the decoded asset, and of the views that its factors replace.
    pub(super) fn measure(&self, decoder: &FlatBtfDecoder) -> AssetErrors {
        let asset = decoder.parts().values.factored();
        let stored = |probes: &Option<Probes>| Some(probes.as_ref()?.factored(asset?));
        let views = |probes: &Option<Probes>| probes.as_ref().filter(|_| asset.is_some()).map(Probes::full);
        let light = self.between.as_ref().or(self.at_samples.as_ref());
        AssetErrors {
            at_samples: stored(&self.at_samples),
            between_samples: stored(&self.between),
            light_form: light.map(|probes| probes.light_form(decoder)),
            views_at_samples: views(&self.at_samples),
            views_between_samples: views(&self.between),
        }
    }
}

pub(super) fn computed_probes(
    pass: &Pass<'_>,
    decoder: &FlatBtfDecoder,
    appearance: &Appearance,
) -> Result<AllProbes, FormatError> {
    if pass.recipe.bounces > 0 {
        return Ok(AllProbes { at_samples: None, between: None });
    }
    let truth = |view: usize, light: usize, at: [f64; 2]| -> Result<[f32; 3], Infallible> {
        Ok(direct_radiance(pass.model, appearance, at, pass.views[view], pass.lights[light]))
    };
    let Ok(at_samples) = Probes::at_samples(PROBES, decoder, pass.views, pass.lights, truth);
    let (view_mesh, light_mesh) = (DirectionMesh::new(&pass.recipe.views)?, DirectionMesh::new(&pass.recipe.lights)?);
    let views = Directions { all: pass.views, mesh: &view_mesh };
    let lights = Directions { all: pass.lights, mesh: &light_mesh };
    let between = Probes::between_samples(PROBES, decoder, &views, &lights, pass.model, appearance);
    Ok(AllProbes { at_samples: Some(at_samples), between: Some(between) })
}

/// Probes that compare with the input images.
pub(super) fn measured_probes<E: Send>(
    pass: &Pass<'_>,
    decoder: &FlatBtfDecoder,
    images: &dyn ViewImages<Error = E>,
) -> Result<AllProbes, E> {
    let truth = |view: usize, light: usize, at: [f64; 2]| Ok(images.image(view, light)?.at(at[0], at[1]));
    let at_samples = Probes::at_samples(PROBES / 8, decoder, pass.views, pass.lights, truth)?;
    Ok(AllProbes { at_samples: Some(at_samples), between: None })
}
