//! Flat BTFs of committed inputs have the bytes and decoded values in the codec's list; see docs/goldens.md.

use brdfc_flat_btf::encode::{FlattenRecipe, Reflectance, ReliefForm, VdimRecipe};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_jobs::flatten::{FlattenJob, MesoOptions, Surface, run as flatten};
use brdfc_source::Input;
use brdfc_testing::golden::encodes::{Packs, check_encodes};
use brdfc_testing::testdata;

/// The file of a flat BTF.
fn flat_btf(name: &str, options: &MesoOptions, recipe: &FlattenRecipe, supercompress: bool) -> Packs {
    let folder = tempfile::tempdir().expect("a folder for the file");
    let surface = Surface::open(options, None, None, &()).unwrap_or_else(|error| panic!("{error}"));
    let job = FlattenJob { name, folder: folder.path(), recipe, supercompress, surface, images: None, raw: None };
    flatten(job, &()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let file = format!("{name}.ktx2");
    let bytes = std::fs::read(folder.path().join(&file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    [(file, bytes)].into()
}

fn meso(geometry: String, materials: &[(Option<&str>, &str)]) -> MesoOptions {
    let material = |(name, source): &(Option<&str>, &str)| (name.map(str::to_owned), Input::from(*source));
    MesoOptions {
        geometry: Some(Input::from(&geometry)),
        tile: 1.0,
        height_scale: 0.5,
        height_offset: 0.0,
        materials: materials.iter().map(material).collect(),
        colour: None,
        weights: None,
    }
}

/// A small recipe with `azimuths` of the light.
fn flat_recipe(azimuths: usize, reflectance: Reflectance) -> FlattenRecipe {
    let set = |azimuths| DirectionSet::grid(2, azimuths, 70.0).expect("a grid of directions");
    FlattenRecipe {
        relief: ReliefForm::Layers,
        texels: 8,
        flat_texels: 8,
        views: set(3),
        lights: set(azimuths),
        fill: FillMethod::Poisson,
        bounces: 0,
        reflectance,
        target: FactoredTarget::Error(2.0),
    }
}

#[test]
fn flat_btfs() {
    let recipe = flat_recipe(2, Reflectance::Factors);
    // Overhangs hide some of its texels from every view.
    let button = meso("synth:button?resolution=16".to_owned(), &[]);
    let mut packs = flat_btf("button", &button, &recipe, true);
    // A height map with colours from an image, the other method of filling holes, one bounce and no Zstandard.
    let mut relief = meso(testdata("golden/relief.png"), &[(None, "synth:lewis?kd=0.5&ks=0.2&n=12")]);
    relief.colour = Some(Input::from(&testdata("golden/cloth.png")));
    let pushed = FlattenRecipe { fill: FillMethod::PushPull, bounces: 4, ..recipe.clone() };
    packs.extend(flat_btf("relief", &relief, &pushed, false));
    // A mesh with two materials, without views.
    let studs = meso(
        testdata("golden/studs.obj"),
        &[(Some("stud"), "synth:lambert?kd=0.6,0.2,0.1"), (None, "synth:velvet?kd=0.3")],
    );
    packs.extend(flat_btf("studs", &studs, &FlattenRecipe { reflectance: Reflectance::Brdf, ..recipe }, true));
    check_encodes("flat_btf", &packs, |file| file == "button.ktx2");
}

#[test]
fn flat_btfs_of_trees() {
    let recipe = flat_recipe(8, Reflectance::Pwt);
    let button = meso("synth:button?resolution=16".to_owned(), &[]);
    let mut packs = flat_btf("button", &button, &recipe, true);
    // Values with shadows: behind an indirection map, and with light of one bounce.
    let vdim = VdimRecipe {
        polar_angles: 4,
        azimuth_rows: 5,
        largest_angle: 70.0,
        oversampling: 1,
        shadows: true,
        compact: false,
    };
    let sponge = meso("synth:sponge?resolution=16".to_owned(), &[]);
    let map = FlattenRecipe { relief: ReliefForm::Vdim(vdim), target: FactoredTarget::Bytes(6000), ..recipe.clone() };
    packs.extend(flat_btf("map", &sponge, &map, false));
    packs.extend(flat_btf("bounced", &sponge, &FlattenRecipe { bounces: 4, ..recipe }, true));
    check_encodes("flat_btf_trees", &packs, |file| file == "button.ktx2");
}
