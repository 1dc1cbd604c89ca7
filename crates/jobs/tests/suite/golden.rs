//! Encodes of committed inputs are the bytes, and decode to the values, in the lists of each codec: see docs/goldens.md.

use brdfc_bandwidth::DEFAULT_EPSILON;
use brdfc_bandwidth::map::{brdf_map, environment_map, texture_map};
use brdfc_bandwidth::resolution::Resolution;
use brdfc_bandwidth::texture::Placement;
use brdfc_flat_btf::fill::FillMethod;
use brdfc_formats::container::Texture;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::IndirectionHeader;
use brdfc_importance::{HalfGrid, ImportanceRecipe, importance_samples};
use brdfc_jobs::flatten::{
    FlattenJob, FlattenRecipe, Form, MesoOptions, Values, material_list, open_appearance, open_geometry, run as flatten,
};
use brdfc_source::open::open;
use brdfc_source::radiance_image::open_radiance_image;
use brdfc_source::tile_image::open_tile_image;
use brdfc_testing::golden::corpus::{add, asset_and_part, entries, moved};
use brdfc_testing::golden::lists::encodes;
use brdfc_testing::golden::{Change, blessing, hash};
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::options::EncodeOptions as Options;
use brdfc_wavelet::recipe::Recipe;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Largest file that goes into the corpus of packs that later versions must read.
const CORPUS_BYTES: usize = 12 << 10;

/// Files by name, as `corpus` has them.
type Packs = BTreeMap<String, Vec<u8>>;

fn testdata(relative: &str) -> String {
    brdfc_testing::repository().join("testdata").join(relative).display().to_string()
}

/// Entry of a wavelet pack that does not hold what the encoder stores, but what was measured of it.
const MEASURED: &str = "brdfc.wavelet.errors";

/// What an encoder stores, whatever the container puts around it: format and extent, entries, texels.
fn contents(bytes: &[u8]) -> String {
    let refused = |error| panic!("the container's reader refuses a pack that was just made: {error}");
    let texture = Texture::from_bytes(bytes).unwrap_or_else(refused);
    // vkFormat to layerCount.
    let mut stored = bytes[12..36].to_vec();
    for (key, value) in texture.entries.iter().filter(|(key, _)| *key != MEASURED) {
        stored.extend(format!("{key} {} ", value.len()).into_bytes());
        stored.extend(value);
    }
    stored.extend(&texture.texels);
    hash(&stored)
}

/// Compares what was encoded with a codec's list. Blessing also adds small packs to the corpus, those in `kept`.
fn check(codec: &'static str, packs: &Packs, kept: impl Fn(&str) -> bool) {
    if blessing() {
        for (file, bytes) in packs.iter().filter(|(file, bytes)| kept(file) && bytes.len() <= CORPUS_BYTES) {
            add(codec, file.trim_end_matches(".ktx2"), bytes);
        }
    }
    let mut found = entries(codec, packs);
    for (name, hashes) in &mut found {
        // The entry of a whole asset is of all its parts.
        let parts = packs.iter().filter(|(file, _)| *file == name || file.starts_with(&format!("{name}.")));
        let parts: String = parts.map(|(_, bytes)| contents(bytes)).collect();
        hashes.insert("contents", if packs.contains_key(name) { parts } else { hash(parts.as_bytes()) });
    }
    encodes(codec).check(found, |changes| inverse_in_words(codec, changes));
}

/// Where stored contents moved, their values say nothing about the decoder: committed packs do.
fn inverse_in_words(codec: &'static str, changes: &[Change]) -> String {
    if changes.iter().all(|change| change.column != "contents") {
        return String::new();
    }
    match moved(codec) {
        0 => format!("The inverse half holds: the committed packs of {codec} decode as before."),
        count => format!("The inverse half moved, too: {count} committed packs of {codec} decode otherwise."),
    }
}

/// One wavelet pack with the options of the command line.
fn wavelet(input: &str, options: &Options, change: impl FnOnce(&mut Recipe)) -> Vec<u8> {
    let mut recipe = options.resolve(&Options::default()).expect("options in range");
    change(&mut recipe);
    let opened = open(input, None).unwrap_or_else(|error| panic!("{error}"));
    encode(opened.source.as_ref(), &recipe, &()).unwrap_or_else(|error| panic!("{error}")).bytes
}

#[test]
fn wavelet_packs() {
    let grey = "synth:ward?kd=0.2&ks=0.25&ax=0.2&ay=0.5".to_owned();
    let rgb = testdata("demo/red_plastic.binary");
    let options = |parameterisation: &str, bits: u32| Options {
        grid: Some(8),
        bits: Some(bits),
        parameterisation: Some(parameterisation.to_owned()),
        ratio: Some(8.0),
        ..Options::default()
    };
    let mut packs = Packs::new();
    for parameterisation in ["tangent-pole", "half-difference"] {
        for bits in [8, 16] {
            for (channels, input) in [("grey", &grey), ("rgb", &rgb)] {
                let pack = wavelet(input, &options(parameterisation, bits), |_| {});
                packs.insert(format!("{parameterisation}-{bits}-{channels}.ktx2"), pack);
            }
        }
    }
    // What else decides which slices there are and what is in them.
    let twelve = options("tangent-pole", 12);
    let fabric = "synth:velvet?kd=0.1,0.2,0.4";
    let visible = Options { ratio: None, max_error: Some(0.1), ranking: Some("visible".to_owned()), ..twelve.clone() };
    packs.insert("visible-max-error-12-rgb.ktx2".to_owned(), wavelet(fabric, &visible, |_| {}));
    let smooth = Options { ratio: None, max_bytes: Some(4000), smooth: Some(true), bias: Some(0.001), ..twelve };
    packs.insert("smooth-max-bytes-12-rgb.ktx2".to_owned(), wavelet(fabric, &smooth, |_| {}));
    let coarse = wavelet(&grey, &options("tangent-pole", 8), |recipe| {
        (recipe.stored_levels, recipe.supercompress) = (2, false);
    });
    packs.insert("coarse-8-grey-uncompressed.ktx2".to_owned(), coarse);
    check("wavelet", &packs, |_| true);
}

/// All parts of a flat BTF.
fn flat_btf(name: &str, options: &MesoOptions, recipe: &FlattenRecipe) -> Packs {
    let folder = tempfile::tempdir().expect("a folder for the parts");
    let geometry = open_geometry(options).unwrap_or_else(|error| panic!("{error}"));
    let materials = material_list(options, &geometry).unwrap_or_else(|error| panic!("{error}"));
    let appearance = open_appearance(options, &materials, &()).unwrap_or_else(|error| panic!("{error}"));
    let values = Values::Computed(appearance);
    let job = FlattenJob { name, folder: folder.path(), recipe, geometry, materials, values, images: None };
    let asset = flatten(job, &()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let read = |file: &str| std::fs::read(folder.path().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    asset.parts.values().map(|part| (part.file.clone(), read(&part.file))).collect()
}

fn meso(geometry: String, materials: &[(Option<&str>, &str)]) -> MesoOptions {
    let material = |(name, source): &(Option<&str>, &str)| (name.map(str::to_owned), (*source).to_owned());
    MesoOptions {
        geometry,
        tile: 1.0,
        height_scale: 0.5,
        height_offset: 0.0,
        materials: materials.iter().map(material).collect(),
        colour: None,
        weights: None,
    }
}

#[test]
fn flat_btfs() {
    let set = |azimuths| DirectionSet::grid(2, azimuths, 70.0).expect("a grid of directions");
    let recipe = FlattenRecipe {
        flat_texels: 8,
        indirection: IndirectionHeader { size: 4, zenith_samples: 3, azimuth_samples: 4, largest_angle: 1.25 },
        oversampling: 2,
        views: set(3),
        lights: set(2),
        fill: FillMethod::Poisson,
        bounces: 0,
        rounds: 0,
        form: Form::Full,
        supercompress: true,
    };
    // Overhangs hide some of its texels from every view.
    let button = meso("synth:button?resolution=16".to_owned(), &[]);
    let mut packs = flat_btf("button", &button, &recipe);
    // A height map whose colours are an image, with holes filled the other way, one bounce and no Zstandard.
    let mut relief = meso(testdata("golden/relief.png"), &[(None, "synth:lewis?kd=0.5&ks=0.2&n=12")]);
    relief.colour = Some(testdata("golden/cloth.png"));
    let pushed =
        FlattenRecipe { fill: FillMethod::PushPull, bounces: 4, rounds: 2, supercompress: false, ..recipe.clone() };
    packs.extend(flat_btf("relief", &relief, &pushed));
    // A mesh with two materials, as normals and diffuse colours alone.
    let studs = meso(
        testdata("golden/studs.obj"),
        &[(Some("stud"), "synth:lambert?kd=0.6,0.2,0.1"), (None, "synth:velvet?kd=0.3")],
    );
    packs.extend(flat_btf("studs", &studs, &FlattenRecipe { form: Form::Light, ..recipe }));
    check("flat_btf", &packs, |file| asset_and_part(file).0 == "button");
}

#[test]
fn bandwidth_maps() {
    let material = open("synth:ggx?alpha=0.4", None).unwrap_or_else(|error| panic!("{error}")).source;
    let (brdf, _) = brdf_map(material.as_ref(), Resolution::Fixed(32), DEFAULT_EPSILON).expect("an epsilon in range");
    let path = |relative| PathBuf::from(testdata(relative));
    let sky = open_radiance_image(&path("golden/sky.hdr")).unwrap_or_else(|error| panic!("{error}"));
    let environment = environment_map(&sky.pixels, sky.width, 0.02).expect("an epsilon in range");
    let cloth = open_tile_image(&path("golden/cloth.png")).unwrap_or_else(|error| panic!("{error}"));
    let texture = |metres, tiles| {
        let map = texture_map(&cloth.colours(), cloth.width, Placement { metres, tiles }, DEFAULT_EPSILON);
        map.expect("a placement in range").to_bytes(true)
    };
    let packs = Packs::from([
        ("brdf.ktx2".to_owned(), brdf.to_bytes(true)),
        ("environment.ktx2".to_owned(), environment.to_bytes(true)),
        ("texture-repeats.ktx2".to_owned(), texture([0.3, 0.25], true)),
        // So dense that halves need a scale.
        ("texture-ends.ktx2".to_owned(), texture([1e-5, 2e-5], false)),
    ]);
    check("bandwidth", &packs, |_| true);
}

#[test]
fn importance_sample_packs() {
    let recipe = ImportanceRecipe {
        isotropic_polar: 6,
        anisotropic_polar: 3,
        anisotropic_azimuths: 4,
        samples: 16,
        grid: HalfGrid { polar: 32, azimuths: 16 },
        defensive: 0.1,
    };
    let pack = |input: &str| {
        let source = open(input, None).unwrap_or_else(|error| panic!("{error}")).source;
        importance_samples(source.as_ref(), &recipe).expect("sizes in range").0.to_bytes(true)
    };
    let packs = Packs::from([
        ("isotropic.ktx2".to_owned(), pack(&testdata("demo/red_plastic.binary"))),
        ("anisotropic.ktx2".to_owned(), pack("synth:ward?ax=0.15&ay=0.5")),
    ]);
    check("importance", &packs, |_| true);
}
