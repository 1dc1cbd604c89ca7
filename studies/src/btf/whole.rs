//! All views of a BTF in one asset: views and lights that were held out of every method, at equal bytes.

use super::assets::Asset;
use super::errors::{Errors, Truth};
use super::factored::factors;
use super::lights::Lights;
use super::per_view::texels_with_mipmaps;
use super::rows::{MipmapRow, WholeBtf, WholeRow};
use brdfc_flat_btf::factored::FactoredTarget;
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{BlendedDirection, ViewWeights};
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_pwt::candidates::decibels;
use brdfc_pwt::measure::{images_at, images_of_pack};
use brdfc_pwt::ptm::{MapModel, fit_map, images_of};
use brdfc_pwt::{LightSamples, PwtRecipe, Target, Views, encode};
use rayon::prelude::*;

/// Linear RGB of texels.
type Image = Vec<[f32; 3]>;
/// Images of a view under all lights.
type ViewImages = Vec<Image>;

/// A BTF with fitted and held-out views and lights. Views and lights are the same set of directions.
pub(super) struct Whole<'a> {
    pub(super) asset: &'a Asset,
    pub(super) set: &'a DirectionSet,
    pub(super) views: Lights,
    pub(super) lights: &'a Lights,
}

impl Whole<'_> {
    /// Measures every method at the bytes of polynomial texture maps in RGB, and at half of them.
    ///
    /// # Errors
    /// Returns an error for sizes or directions that a method does not support.
    pub(super) fn study(&self) -> Result<WholeBtf, FormatError> {
        let mut rows = Vec::new();
        let mut mipmaps = Vec::new();
        for (model, name) in [(MapModel::Rgb, "PTM"), (MapModel::Lrgb, "PTM, LRGB")] {
            let (bytes, maps) = self.maps(model)?;
            rows.push(self.row(name, (bytes, bytes), &maps));
            let (pack, trees) = self.trees(bytes)?;
            rows.push(self.row("trees, common terms", (bytes, pack.gpu_bytes()), &trees));
            let (found, trees) = self.separate_trees(bytes)?;
            rows.push(self.row("trees, terms of each view", (bytes, found), &trees));
            let (found, factored) = self.factored(bytes)?;
            rows.push(self.row("factored", (bytes, found), &factored));
            if mipmaps.is_empty() {
                mipmaps = self.mipmaps(&PwtDecoder::new(pack));
            }
        }
        Ok(WholeBtf { held_out_views: self.views.held_out.clone(), rows, mipmaps })
    }

    /// The fitted images of a view.
    fn samples(&self, view: usize) -> LightSamples {
        self.asset.samples(view, &self.asset.renderings(view, self.lights), self.lights)
    }

    /// Images of the fitted views, and of the others blended from their three neighbours.
    fn completed(&self, fitted: Vec<ViewImages>) -> Vec<ViewImages> {
        let texels = self.asset.size * self.asset.size;
        let joined = fitted.into_iter().map(|images| images.concat()).collect();
        let split = |images: Image| images.chunks_exact(texels).map(<[_]>::to_vec).collect();
        self.views.completed(joined).into_iter().map(split).collect()
    }

    fn maps(&self, model: MapModel) -> Result<(u64, Vec<ViewImages>), FormatError> {
        let of_view = |view: &usize| -> Result<ViewImages, FormatError> {
            let map = fit_map(&self.samples(*view), model)?;
            Ok(images_of(&map, self.lights.directions.clone()).into_linear())
        };
        let fitted = self.views.fitted.iter().map(of_view).collect::<Result<_, _>>()?;
        let of_texel = if model == MapModel::Rgb { 18 } else { 9 };
        let bytes = of_texel * texels_with_mipmaps(self.asset.size) * self.views.fitted.len() as u64;
        Ok((bytes, self.completed(fitted)))
    }

    /// One pack of all fitted views.
    fn trees(&self, bytes: u64) -> Result<(PwtPack, Vec<ViewImages>), FormatError> {
        let angles = self.views.fitted.iter().map(|view| self.set.angles[*view]).collect();
        let views = Views::new(DirectionSet::new("fitted views", angles)?)?;
        let all: Vec<LightSamples> = self.views.fitted.iter().map(|view| self.samples(*view)).collect();
        let image = |light: usize| -> Image {
            all.iter().flat_map(|view| view.images[light].linear(0..view.images[light].len()).into_owned()).collect()
        };
        let images: Vec<Image> = (0..self.lights.fitted.len()).map(image).collect();
        let size = [self.asset.size, self.asset.size * views.len()];
        let samples = LightSamples::new(size, self.lights.fitted_directions(), images);
        let samples = LightSamples { repeats: true, views: Some(views), ..samples };
        let pack = encode(&samples, &PwtRecipe { target: Target::Bytes(bytes), ..PwtRecipe::default() })?.pack;
        let decoder = PwtDecoder::new(pack);
        let seen = |view: &[f32; 3]| images_at(&decoder, *view, 0, &self.lights.directions);
        let images = self.views.directions.iter().map(seen).collect();
        Ok((decoder.into_pack(), images))
    }

    /// A pack of each fitted view, with its own terms and its share of the bytes.
    fn separate_trees(&self, bytes: u64) -> Result<(u64, Vec<ViewImages>), FormatError> {
        let target = Target::Bytes(bytes / self.views.fitted.len() as u64);
        let of_view = |view: &usize| -> Result<(u64, ViewImages), FormatError> {
            let pack = encode(&self.samples(*view), &PwtRecipe { target, ..PwtRecipe::default() })?.pack;
            let found = pack.gpu_bytes();
            let images = images_of_pack(&PwtDecoder::new(pack), [0.0, 0.0, 1.0], self.lights.directions.clone());
            Ok((found, images.into_linear()))
        };
        let made = self.views.fitted.iter().map(of_view).collect::<Result<Vec<_>, _>>()?;
        let (bytes, fitted): (Vec<u64>, Vec<ViewImages>) = made.into_iter().unzip();
        Ok((bytes.into_iter().sum(), self.completed(fitted)))
    }

    /// Factors of all fitted views, blended as by a renderer of flat BTFs.
    fn factored(&self, bytes: u64) -> Result<(u64, Vec<ViewImages>), FormatError> {
        let made = factors(FactoredTarget::Bytes(bytes), self.asset, (self.set, &self.views.fitted), self.lights)?;
        let size = made.asset.header().size;
        let [views, lights] = [&self.views, self.lights].map(Lights::blended);
        let of_texel = |at: u32, view: BlendedDirection| -> Image {
            let texel = made.asset.texel([at % size, at / size]);
            lights.iter().map(|light| texel.shadowed(texel.blended(view, *light), light.samples, 1.0)).collect()
        };
        let of_view = |view: &BlendedDirection| -> ViewImages {
            let texels: Vec<Image> = (0..size * size).into_par_iter().map(|at| of_texel(at, *view)).collect();
            (0..lights.len()).map(|light| texels.iter().map(|texel| texel[light]).collect()).collect()
        };
        Ok((made.facts.gpu_bytes, views.iter().map(of_view).collect()))
    }

    fn row(&self, method: &str, (budget, bytes): (u64, u64), images: &[ViewImages]) -> WholeRow {
        let [mut fitted, mut unseen] = [Errors::default(); 2];
        for (view, images) in images.iter().enumerate() {
            let truth = Truth::new(&self.asset.renderings(view, self.lights), None);
            let errors = truth.errors(images, self.lights);
            if self.views.held_out.contains(&view) { unseen.add(errors) } else { fitted.add(errors) }
        }
        WholeRow {
            method: method.to_owned(),
            budget,
            bytes,
            psnr: fitted.fitted.psnr(),
            held_out_lights_psnr: fitted.held_out.psnr(),
            held_out_views_psnr: unseen.fitted.psnr(),
            held_out_both_psnr: unseen.held_out.psnr(),
            held_out_both_delta_e: unseen.held_out.delta_e(),
        }
    }

    /// Levels of the trees against means of the images over the texels of each level, at fitted views and lights.
    fn mipmaps(&self, decoder: &PwtDecoder) -> Vec<MipmapRow> {
        let lights = self.lights.fitted_directions();
        let levels = 1..=decoder.pack().header().levels;
        let level = |level: u32| {
            let mut sums = [0.0; 2];
            let mut count = 0.0;
            for view in &self.views.fitted {
                let direction = self.views.directions[*view];
                let renderings = self.asset.renderings(*view, self.lights);
                let expected: Vec<Image> = self.lights.fitted.iter().map(|light| renderings[*light].clone()).collect();
                let [found, whole] = [level, 0].map(|level| images_at(decoder, direction, level, &lights));
                for ((found, whole), expected) in found.iter().zip(&whole).zip(&expected) {
                    let [whole, expected] = [whole, expected].map(|image| means(image, self.asset.size, level));
                    sums[0] += difference(found, &expected);
                    sums[1] += difference(&whole, &expected);
                    count += 3.0 * expected.len() as f64;
                }
            }
            let [psnr, box_psnr] = sums.map(|sum| decibels(sum / count));
            MipmapRow { level, psnr, box_psnr }
        };
        levels.map(level).collect()
    }
}

/// Means of squares of `2^level` texels per side.
fn means(image: &[[f32; 3]], size: usize, level: u32) -> Image {
    let (side, block) = (size >> level, 1 << level);
    let mean = |at: usize| {
        let (x, y) = (at % side * block, at / side * block);
        let texels = (0..block * block).map(|k| image[(y + k / block) * size + x + k % block]);
        let sum = texels.fold([0.0; 3], |sum: [f32; 3], texel| [0, 1, 2].map(|c| sum[c] + texel[c]));
        sum.map(|c| c / (block * block) as f32)
    };
    (0..side * side).map(mean).collect()
}

/// Sum of squared differences of sRGB values.
fn difference(found: &[[f32; 3]], expected: &[[f32; 3]]) -> f64 {
    let [found, expected] = [found, expected].map(|image| super::errors::codes(image.to_vec()));
    let pairs = found.as_flattened().iter().zip(expected.as_flattened());
    pairs.map(|(a, b)| f64::from((a - b) * (a - b))).sum()
}

impl Lights {
    /// All directions, in terms of the fitted ones.
    fn blended(&self) -> Vec<BlendedDirection> {
        let mut all: Vec<BlendedDirection> = self
            .directions
            .iter()
            .map(|direction| BlendedDirection {
                direction: *direction,
                samples: ViewWeights { indices: [0; 3], weights: [1.0, 0.0, 0.0] },
            })
            .collect();
        for (index, at) in self.fitted.iter().enumerate() {
            all[*at].samples.indices = [index as u32; 3];
        }
        for (at, (indices, weights)) in self.held_out.iter().zip(&self.blends) {
            all[*at].samples = ViewWeights { indices: *indices, weights: *weights };
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_known_texels() {
        let image: Image = (0..16).map(|k| [k as f32; 3]).collect();
        assert_eq!(means(&image, 4, 1).iter().map(|texel| texel[0]).collect::<Vec<_>>(), [2.5, 4.5, 10.5, 12.5]);
        assert_eq!(means(&image, 4, 2), [[7.5; 3]]);
    }

    /// Known answer: images that are equal to the BTF have no error at fitted views and lights, and blended ones have at the others.
    #[test]
    fn unseen_views_and_lights_are_measured_apart() {
        let set = DirectionSet::grid(3, 6, 60.0).unwrap();
        let lights = Lights::new(&set, &[2]).unwrap();
        let views = Lights::new(&set, &[4, 9]).unwrap();
        let word = |view: usize, k: usize| {
            let bright = 0.2 + 0.03 * (view % 5) as f32 + 0.02 * (k / 4 % 7) as f32;
            brdfc_formats::container::rgb9e5::encode([bright; 3])
        };
        let words = (0..13).map(|view| (0..13 * 4).map(|k| word(view, k)).collect()).collect();
        let asset = Asset { size: 2, words, masks: None, normals: vec![[0.0, 0.0, 1.0]; 4] };
        let whole = Whole { asset: &asset, set: &set, views, lights: &lights };
        let fitted = whole.views.fitted.iter().map(|view| asset.renderings(*view, &lights)).collect();
        let row = whole.row("blended", (1, 1), &whole.completed(fitted));
        assert!(row.psnr > 90.0 && row.held_out_lights_psnr > 90.0, "{row:?}");
        assert!(row.held_out_views_psnr < 40.0 && row.held_out_both_psnr < 40.0, "{row:?}");
    }
}
