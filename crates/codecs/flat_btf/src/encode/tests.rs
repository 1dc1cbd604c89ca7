//! Views pass through scratch storage unchanged, and storage errors stop the work.

use super::scratch::ScratchViews;
use super::work::visibility_mask;
use super::*;
use crate::factored::{FactoredRecipe, FactoredTarget, factor};
use crate::fill::FillMethod;
use crate::light_field::visible_from_each;
use crate::probes::{Place, Probes, direct_radiance};
use crate::surface::Appearance;
use crate::testing::{Patience, bumps};
use crate::texels::texel_surface;
use brdfc_core::address::parse_synth;
use brdfc_formats::direction::Vector;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::FlatView;

fn recipe() -> FlattenRecipe {
    FlattenRecipe {
        relief: ReliefForm::Layers,
        texels: 8,
        flat_texels: 16,
        views: DirectionSet::grid(2, 4, 60.0).unwrap(),
        lights: DirectionSet::grid(2, 3, 50.0).unwrap(),
        fill: FillMethod::Poisson,
        bounces: 0,
        reflectance: Reflectance::Factors,
        target: FactoredTarget::Components { components: 4, residual: 0 },
    }
}

fn appearance() -> Appearance {
    let source = parse_synth("synth:lewis?kd=0.5&ks=0.1&n=8").unwrap();
    Appearance { sources: vec![source], ..Default::default() }
}

fn made<E: Send>(
    recipe: &FlattenRecipe,
    scratch: &dyn Scratch<Error = E>,
    progress: &dyn Progress,
) -> Result<FlatBtfEncoded, EncodeError<E>> {
    let appearance = appearance();
    let values = ValueSource::Computed(&appearance);
    encode(FlatInput { mesh: bumps(16, 0.5), repairs: None, values }, recipe, scratch, progress)
}

fn whole(recipe: &FlattenRecipe) -> (FlatBtfEncoded, MemoryScratch) {
    let scratch = MemoryScratch::default();
    (made(recipe, &scratch, &()).unwrap(), scratch)
}

/// Scratch storage that corrupts one of the views.
struct Broken<F> {
    inner: MemoryScratch,
    read: F,
}

impl<F: Fn(u32, Vec<u8>) -> Result<Vec<u8>, String> + Sync> Scratch for Broken<F> {
    type Error = String;

    fn write_scratch(&self, view: u32, values: &[u8]) -> Result<(), String> {
        if view == 3 && (self.read)(u32::MAX, Vec::new()).is_err() {
            return Err("no room for view 3".to_owned());
        }
        let Ok(()) = self.inner.write_scratch(view, values);
        Ok(())
    }

    fn read_scratch(&self, view: u32) -> Result<Vec<u8>, String> {
        let Ok(values) = self.inner.read_scratch(view);
        (self.read)(view, values)
    }
}

#[test]
fn factors_are_fitted_to_the_stored_views() {
    let recipe = recipe();
    let (found, scratch) = whole(&recipe);
    let views = ScratchViews::new(recipe.header(0));
    let view = |view| views.read(view, &scratch);
    let texels = found.model.texels(recipe.flat_texels);
    let masks = visible_from_each(&texels, &found.model.caster, &recipe.views.directions(), &()).unwrap();
    let mask = visibility_mask(recipe.flat_texels as u32, &masks).unwrap();
    let coordinates = &found.model.parameterisation.coordinates;
    let surface = texel_surface(&found.model.mesh, coordinates, recipe.flat_texels, |_| Default::default());
    let expected = factor(&FactoredRecipe::new(recipe.target), &surface.normals, &mask, None, view, &()).unwrap();
    assert!(found.decoder.parts().reflectance == expected.asset.into());
    assert_eq!(found.report.factored, Some(expected.facts));
}

/// Known materials need no views: nothing is written to scratch storage.
#[test]
fn known_materials_write_no_scratch() {
    let (known, scratch) = whole(&FlattenRecipe { reflectance: Reflectance::Brdf, ..recipe() });
    let (factors, _) = whole(&recipe());
    let header = known.decoder.parts().reflectance.factors().unwrap().header();
    assert_eq!((header.groups, header.materials, header.views.len()), (0, 1, 0));
    assert!(known.report.seen.is_none() && factors.report.seen.is_some());
    assert_eq!(known.decoder.parts().relief, factors.decoder.parts().relief);
    assert!((0..5).all(|view| scratch.read_scratch(view).is_ok_and(|values| values.is_empty())));
}

/// A Phong lobe is one table over mirror angles: the reflectance alone is exact to a fraction of a ΔE.
#[test]
fn phong_lobes_have_tables_over_mirror_angles() {
    let (made, _) = whole(&FlattenRecipe { reflectance: Reflectance::Brdf, ..recipe() });
    let reflectance = made.decoder.parts().reflectance.factors().unwrap();
    assert_eq!(reflectance.header().axes, 1);
    let errors = made.report.factored.unwrap().errors;
    assert!(errors.seen_mean < 0.1, "{errors:?}");
}

/// Mean radiance of each level, and of the surface without shadows and with them, under low light.
fn brightness(shadows: bool) -> (Vec<f64>, [f64; 2]) {
    let vdim =
        VdimRecipe { polar_angles: 8, azimuth_rows: 13, largest_angle: 75.0, oversampling: 1, shadows, compact: false };
    let recipe = FlattenRecipe {
        relief: ReliefForm::Vdim(vdim),
        texels: 16,
        lights: DirectionSet::grid(5, 12, 80.0).unwrap(),
        reflectance: Reflectance::Brdf,
        ..recipe()
    };
    let (made, _) = whole(&recipe);
    let appearance = appearance();
    let directions = SampledDirections::of(made.decoder.parts()).unwrap();
    let probes = Probes::between(4000, &recipe.views.directions(), &recipe.lights.directions());
    let mean = |value: &dyn Fn(&Place) -> [f32; 3]| {
        probes.places().iter().map(|place| f64::from(value(place)[1])).sum::<f64>() / 4000.0
    };
    let single = |v: Vector| v.map(|c| c as f32);
    let of_level = |level: u32| {
        mean(&|Place { at, view, light }| {
            let at = at.map(|c| c as f32);
            made.decoder.shaded(directions.as_ref(), at, level as f32, single(*view), single(*light))
        })
    };
    let of_surface =
        [false, true].map(|shadows| mean(&|place| direct_radiance(&made.model, &appearance, *place, shadows)));
    ((0..5).map(of_level).collect(), of_surface)
}

/// The control is the same relief with sampled shadows.
#[test]
fn without_shadows_no_level_has_any() {
    let ((none, [bright, dark]), (sampled, _)) = (brightness(false), brightness(true));
    println!("surface {bright} and {dark}, none {none:?}, sampled {sampled:?}");
    assert!(dark < 0.93 * bright, "there are shadows: {dark} {bright}");
    assert!(none.iter().all(|level| (level / bright - 1.0).abs() < 0.04), "{none:?} {bright}");
    assert!(sampled.iter().zip(&none).all(|(with, without)| with < &(0.93 * without)), "{sampled:?} {none:?}");
}

#[test]
fn images_and_bounces_require_factors() {
    let recipe = FlattenRecipe { bounces: 4, reflectance: Reflectance::Brdf, ..recipe() };
    let error = made(&recipe, &MemoryScratch::default(), &()).err().expect("an error").to_string();
    assert_eq!(
        error,
        "reflectance: found brdf, expected materials without bounces; images and bounces require factors"
    );
}

#[test]
fn views_come_back_bit_for_bit() {
    let scratch = MemoryScratch::default();
    let views = ScratchViews::new(FlattenRecipe { flat_texels: 4, ..recipe() }.header(0));
    let texels: Vec<u32> = (0..4 * 4 * 4).map(|k: u32| k.wrapping_mul(0x9e37_79b9)).collect();
    let written: FlatView = views.view(2, texels.clone()).unwrap();
    let Ok(()) = views.write(&written, &scratch);
    let Ok(values) = scratch.read_scratch(2);
    assert_eq!(values, texels.iter().flat_map(|texel| texel.to_le_bytes()).collect::<Vec<u8>>(), "nothing else");
    assert_eq!(views.read(2, &scratch).unwrap(), written);
}

#[test]
fn storage_that_fails_stops_the_work() {
    let error = |read: fn(u32, Vec<u8>) -> Result<Vec<u8>, String>| {
        let scratch = Broken { inner: MemoryScratch::default(), read };
        made(&recipe(), &scratch, &()).err().expect("an error").to_string()
    };
    assert_eq!(
        error(|view, values| if view == u32::MAX { Err(String::new()) } else { Ok(values) }),
        "no room for view 3"
    );
    let unread = |view: u32, values| if view == 4 { Err(format!("lost view {view}")) } else { Ok(values) };
    assert_eq!(error(unread), "lost view 4");
    let cut = |view, mut values: Vec<u8>| {
        values.truncate(if view == 1 { 4093 } else { values.len() });
        Ok(values)
    };
    assert_eq!(error(cut), "scratch storage of view 1: found 4093 bytes, expected the 4096 bytes that were written");
}

#[test]
fn work_stops_between_any_two_steps() {
    let patience = Patience::new(usize::MAX);
    let Ok(_) = made(&recipe(), &MemoryScratch::default(), &patience) else { panic!("not stopped") };
    for most in (1..patience.steps()).step_by(patience.steps() / 12) {
        let stopped = made(&recipe(), &MemoryScratch::default(), &Patience::new(most));
        assert!(matches!(stopped, Err(EncodeError::Cancelled(_))), "{most}");
    }
}
