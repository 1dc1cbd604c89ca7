//! Packs of several views.

use super::stacks::{lambert, spiral};
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::pwt::{MAX_ARRAY_LAYERS, PwtDecoder};
use brdfc_pwt::measure::{image_errors, images_at, stack_errors};
use brdfc_pwt::{LightSamples, PwtRecipe, Target, Views, Wavelet, encode};

const SIZE: [usize; 2] = [16, 8];

/// Tiles of Lambert's law; view `v` is darker than view 0, and shifted by `v` columns.
fn samples(count: usize) -> LightSamples {
    let angles = (0..count).map(|k| [60.0 * k as f64 / count as f64, 137.5 * k as f64 % 360.0]).collect();
    let one = lambert(SIZE, spiral(24), true);
    let view = |image: &[[f32; 3]], view: usize| -> Vec<[f32; 3]> {
        let shifted = |at: usize| at / SIZE[0] * SIZE[0] + (at + view) % SIZE[0];
        (0..image.len()).map(|at| image[shifted(at)].map(|c| c * (1.0 - 0.5 * view as f32 / count as f32))).collect()
    };
    let images = one.clone().into_linear();
    let stacked = images.iter().map(|image| (0..count).flat_map(|k| view(image, k)).collect::<Vec<_>>()).collect();
    let views = Views::new(DirectionSet::new("some", angles).unwrap()).unwrap();
    let size = [SIZE[0], SIZE[1] * count];
    LightSamples { repeats: true, views: Some(views), ..LightSamples::new(size, one.lights, stacked) }
}

/// Each view at its own direction is the view's image; a view shown as another is not. The target is below the limit of the relief,
/// which `common_terms_are_as_good_as_those_of_one_view` measures.
#[test]
fn every_view_is_reconstructed() {
    let samples = samples(5);
    let made = encode(&samples, &PwtRecipe { target: Target::Quality(30.0), ..PwtRecipe::default() }).unwrap();
    assert!(made.met && made.errors.psnr >= 30.0, "{:?}", made.errors);
    let decoder = PwtDecoder::new(made.pack);
    let (header, views) = (decoder.pack().header(), samples.views.as_ref().unwrap());
    assert_eq!((header.size, header.view_count()), ([16, 8], 5));
    for view in 0..5 {
        let seen = |direction| {
            let images = images_at(&decoder, direction, 0, &samples.lights);
            let shown = LightSamples::new(SIZE, samples.lights.clone(), images);
            let cut = |image: &brdfc_readers::pixels::Pixels| image.linear(samples.pixels_of_view(view)).into_owned();
            let truth = LightSamples::new(SIZE, samples.lights.clone(), samples.images.iter().map(cut).collect());
            image_errors(&shown, &truth).psnr
        };
        assert!(seen(views.direction(view)) > 26.0, "{view}: {}", seen(views.direction(view)));
        assert!(seen(views.direction((view + 1) % 5)) < 23.0, "{view}");
    }
    assert_eq!(stack_errors(&decoder, &samples, 1).lights, 24);
}

/// A target of bytes counts all views, the light map and the mesh, and layers stay within the limit.
#[test]
fn bytes_and_layers_are_within_their_limits() {
    for count in [2, 90] {
        let samples = samples(count);
        for bytes in [6000 * count as u64, 1200 * count as u64] {
            let recipe = PwtRecipe { target: Target::Bytes(bytes), ..PwtRecipe::default() };
            let made = encode(&samples, &recipe).unwrap();
            assert!(made.met && made.pack.gpu_bytes() <= bytes, "{count}: {}", made.pack.gpu_bytes());
            let header = made.pack.header();
            assert!(header.textures.iter().all(|texture| texture.layers() * count as u32 <= MAX_ARRAY_LAYERS));
            let read = brdfc_formats::pwt::PwtPack::from_bytes(&made.pack.to_bytes(true)).unwrap();
            assert_eq!(read, made.pack);
        }
    }
}

#[test]
fn some_views_are_selected_and_wrong_stacks_rejected() {
    let all = samples(5);
    let some = all.only_views(&[3, 1]).unwrap();
    assert_eq!((some.size, some.view_count(), some.view_size()), ([16, 16], 2, SIZE));
    let pixels = |samples: &LightSamples, view| samples.images[7].linear(samples.pixels_of_view(view)).into_owned();
    assert_eq!((pixels(&some, 0), pixels(&some, 1)), (pixels(&all, 3), pixels(&all, 1)));
    assert_eq!(some.views.as_ref().unwrap().direction(0), all.views.as_ref().unwrap().direction(3));
    let error = |samples: &LightSamples| encode(samples, &PwtRecipe::default()).unwrap_err().to_string();
    assert_eq!(all.only_views(&[2]).unwrap_err().to_string(), "views: found 1, expected 2 or more");
    let clamped = LightSamples { repeats: false, ..all.clone() };
    assert!(error(&clamped).starts_with("images of several views: no tiles"), "{}", error(&clamped));
    let cut = LightSamples { size: [16, 39], ..all.clone() };
    assert_eq!(error(&cut), "rows of all views: found 39, expected a multiple of 5, the number of views");
    let recipe = PwtRecipe { wavelet: Wavelet::Cdf97, ..PwtRecipe::default() };
    let error = encode(&all, &recipe).unwrap_err().to_string();
    assert_eq!(error, "wavelet: found cdf97, expected haar for several views");
}

/// Terms in common cost little: all five views together are as good as one view alone at its best. Shadows that end within the 24
/// lights limit both, to 31.9 dB for this relief.
#[test]
fn common_terms_are_as_good_as_those_of_one_view() {
    let best = PwtRecipe { target: Target::Quality(60.0), ..PwtRecipe::default() };
    let all = encode(&samples(5), &best).unwrap().errors.psnr;
    let one = encode(&lambert(SIZE, spiral(24), true), &best).unwrap().errors.psnr;
    assert!(all > one - 0.3 && one < 33.0, "{all} {one}");
}
