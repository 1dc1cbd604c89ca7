//! An experimental method that is measured but not shipped: one polynomial wavelet tree of the whole BTF, whose terms
//! are the products of harmonics of the light and of the view. Both are fitted by least squares, one after the other.
//! Each term is stored in 8 bits from the level determined by the error per byte.

use super::assets::Asset;
use super::errors::{Errors, Truth};
use super::lights::Lights;
use super::rows::Tally;
use super::steps::{StepUp, steps};
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates};
use brdfc_pwt::candidates::Candidate;
use brdfc_pwt::design::Design;
use brdfc_pwt::image::Plane;
use brdfc_pwt::levels::{BASES, Borders, TermImages, magnified, range, term_images};
use brdfc_pwt::tree::{PacketTree, Transform};
use brdfc_pwt::{Border, DomainName, Wavelet, fit};
use rayon::prelude::*;
use std::time::Instant;

/// Deepest level of detail.
const DEPTH: u32 = 5;
/// Orthonormal channels: grey, and two of chrominance.
const CHANNELS: [[f32; 3]; 3] = [
    [0.577_350_3, 0.577_350_3, 0.577_350_3],
    [std::f32::consts::FRAC_1_SQRT_2, 0.0, -std::f32::consts::FRAC_1_SQRT_2],
    [0.408_248_3, -0.816_496_6, 0.408_248_3],
];
/// Stride of the views that are evaluated in the search for the fewest terms.
const LOOKED_AT: usize = 5;

/// All terms of a BTF.
pub(super) struct Joint<'a> {
    asset: &'a Asset,
    lights: &'a Lights,
    domain: Domain,
    /// Design of both the light and the view, which have the same directions.
    light: Design,
    view: Design,
    /// Term `j n + i` of a channel is term j of the view times term i of the n of the light.
    images: Vec<TermImages>,
    steps: Vec<StepUp>,
    depth: u32,
    seconds: f64,
}

/// Finest level of each term; `None` if it is left out.
type Bases = Vec<Option<u32>>;

/// The choice of most views: a domain, and medians of its offset and of the ridge.
fn prevalent(chosen: &[Candidate]) -> (Domain, f64) {
    let count = |name: DomainName| chosen.iter().filter(|candidate| candidate.domain == name).count();
    let name = DomainName::ALL.into_iter().max_by_key(|name| count(*name)).unwrap_or(DomainName::CubeRoot);
    let mut of_name: Vec<Candidate> = chosen.iter().filter(|candidate| candidate.domain == name).copied().collect();
    of_name.sort_by(|a, b| a.epsilon.total_cmp(&b.epsilon));
    let middle = of_name[of_name.len() / 2];
    let mut ridges: Vec<f64> = chosen.iter().map(|candidate| candidate.ridge).collect();
    ridges.sort_by(f64::total_cmp);
    (middle.domain(), ridges[ridges.len() / 2])
}

/// Weights of the terms of a design in any direction.
fn weights(design: &Design, direction: [f32; 3]) -> Vec<f32> {
    let terms = design.basis.evaluate(direction);
    let row = |k: usize| &design.triangle[k * (k + 1) / 2..][..=k];
    let weight = |k: usize| row(k).iter().zip(terms).map(|(c, term)| c * f64::from(term)).sum::<f64>() as f32;
    (0..design.terms()).map(weight).collect()
}

/// Weighted sum of planes.
fn mixed<'a>(planes: impl Iterator<Item = (&'a [f32], f32)>, texels: usize) -> Vec<f32> {
    let mut sum = vec![0.0; texels];
    for (plane, weight) in planes {
        sum.iter_mut().zip(plane).for_each(|(sum, value)| *sum += weight * value);
    }
    sum
}

impl<'a> Joint<'a> {
    /// Fits all terms, harmonics of light and view up to a degree, one view after the other. `chosen` are the
    /// candidates of the trees of the views. Calls `view_done` after each view.
    pub(super) fn fit(
        asset: &'a Asset,
        lights: &'a Lights,
        (chosen, degree): (&[Candidate], u32),
        view_done: &dyn Fn(),
    ) -> Self {
        let start = Instant::now();
        let (domain, ridge) = prevalent(chosen);
        let basis = LightBasis { coordinates: LightCoordinates::Hemisphere, degree };
        let light = Design::new(basis, &lights.fitted_directions(), ridge);
        let view = Design::new(basis, &lights.directions, ridge);
        let texels = asset.size * asset.size;
        let extent = [asset.size; 2];
        let mut coefficients: [Vec<Plane>; 3] =
            [0, 1, 2].map(|_| vec![Plane::zeros(extent); light.terms() * view.terms()]);
        for number in 0..asset.views() {
            let mut renderings = asset.renderings(number, lights);
            renderings.par_iter_mut().for_each(|rendering| domain.encode_each(rendering.as_flattened_mut()));
            for (channel, planes) in CHANNELS.iter().zip(&mut coefficients) {
                let project = |value: &[f32; 3]| (0..3).map(|k| channel[k] * value[k]).sum();
                let values = |light: &usize| renderings[*light].iter().map(project).collect();
                let values: Vec<Vec<f32>> = lights.fitted.par_iter().map(values).collect();
                let of_light = fit::coefficients(&light, &values);
                planes.par_iter_mut().enumerate().for_each(|(term, plane)| {
                    let weight = view.row(number)[term / light.terms()] as f32;
                    let added = &of_light[term % light.terms()];
                    plane.values.iter_mut().zip(added).for_each(|(sum, value)| *sum += weight * value);
                });
            }
            view_done();
        }
        let depth = asset.size.ilog2().min(DEPTH);
        let transform = Transform { wavelet: Wavelet::Haar, border: Border::Periodic, depth };
        let tree = PacketTree::pyramid(transform, extent);
        coefficients.iter_mut().flatten().collect::<Vec<_>>().into_par_iter().for_each(|plane| tree.analyse(plane));
        // The weight of a texel is the number of views that see it.
        let mut counts = Plane { size: extent, values: vec![1.0; texels] };
        if let Some(masks) = &asset.masks {
            let share = |texel: usize| masks.iter().filter(|mask| mask[texel]).count() as f32 / masks.len() as f32;
            counts.values = (0..texels).map(share).collect();
        }
        let images = term_images(&tree, &coefficients, &counts, Borders::of_one(true));
        let steps = steps(&images);
        Self { asset, lights, domain, light, view, images, steps, depth, seconds: start.elapsed().as_secs_f64() }
    }

    /// All terms that reduce the error.
    pub(super) fn all(&self, view_done: &dyn Fn()) -> Tally {
        self.tally(self.steps.len(), view_done)
    }

    /// Approximately the fewest bytes for a mean ΔE at the fitted lights, or all terms if they do not reach it. Calls
    /// `view_done` once per view.
    pub(super) fn at_error(&self, delta_e: f64, view_done: &dyn Fn()) -> Tally {
        let start = Instant::now();
        let all = self.steps.len();
        let (mut low, mut high) = (0, all);
        let error = |count: usize| self.errors(&self.bases(count), LOOKED_AT, &|| ()).fitted.delta_e();
        if error(high) <= delta_e {
            while high - low > high.div_ceil(100).max(1) {
                let middle = low + (high - low).div_ceil(2);
                if error(middle) <= delta_e { high = middle } else { low = middle }
            }
        }
        let mut found = self.tally(high, view_done);
        // The other views may need a few more terms.
        while found.errors.fitted.delta_e() > delta_e && high < all {
            high = all.min(high + high.div_ceil(20));
            found = self.tally(high, &|| ());
        }
        Tally { seconds: found.seconds + start.elapsed().as_secs_f64(), ..found }
    }

    fn tally(&self, count: usize, view_done: &dyn Fn()) -> Tally {
        let bases = self.bases(count);
        let errors = self.errors(&bases, 1, view_done);
        let begin_at = |level: u32| bases.iter().flatten().filter(|base| **base == level).count().div_ceil(4);
        let texels = |level: u32| ((self.asset.size >> level) as u64).pow(2);
        let bytes = |level: u32| 4 * begin_at(level) as u64 * (level..=self.depth).map(texels).sum::<u64>();
        Tally {
            bytes: (0..BASES).map(bytes).sum(),
            fetches: (0..BASES).map(begin_at).sum::<usize>() as f64,
            seconds: self.seconds,
            errors,
        }
    }

    fn bases(&self, count: usize) -> Bases {
        let mut bases = vec![None; self.images.len()];
        self.steps[..count].iter().for_each(|step| bases[step.image] = Some(step.base));
        bases
    }

    /// Errors of every `stride`-th view.
    fn errors(&self, bases: &Bases, stride: usize, view_done: &dyn Fn()) -> Errors {
        let planes: Vec<Option<Plane>> =
            self.images.par_iter().zip(bases).map(|(image, base)| base.map(|base| stored(image, base))).collect();
        let mut errors = Errors::default();
        for view in (0..self.asset.views()).step_by(stride) {
            let truth = Truth::new(&self.asset.renderings(view, self.lights), self.asset.mask(view));
            errors.add(truth.errors(&self.images_of(&planes, view), self.lights));
            view_done();
        }
        errors
    }

    /// Renderings of a view under all lights.
    fn images_of(&self, planes: &[Option<Plane>], view: usize) -> Vec<Vec<[f32; 3]>> {
        let texels = self.asset.size * self.asset.size;
        let (of_view, terms) = (weights(&self.view, self.lights.directions[view]), self.light.terms());
        let at_view = |at: usize| {
            let (channel, term) = (at / terms, at % terms);
            let plane = |j: usize| planes[(channel * of_view.len() + j) * terms + term].as_ref();
            let selected = (0..of_view.len()).filter_map(|j| Some((&plane(j)?.values[..], of_view[j])));
            mixed(selected, texels)
        };
        let at_view: Vec<Vec<f32>> = (0..3 * terms).into_par_iter().map(at_view).collect();
        let rendering = |direction: &[f32; 3]| -> Vec<[f32; 3]> {
            let of_light = weights(&self.light, *direction);
            let channels = [0, 1, 2].map(|channel: usize| {
                let planes = at_view[channel * terms..][..terms].iter().map(Vec::as_slice);
                mixed(planes.zip(of_light.iter().copied()), texels)
            });
            let colour = |k: usize| [0, 1, 2].map(|c| (0..3).map(|n| CHANNELS[n][c] * channels[n][k]).sum());
            let mut rendering: Vec<[f32; 3]> = (0..texels).map(colour).collect();
            self.domain.decode_each(rendering.as_flattened_mut());
            rendering
        };
        self.lights.directions.par_iter().map(rendering).collect()
    }
}

/// A term as a sampler returns it if it starts at a level: 8 bits between the smallest and largest value of its levels.
fn stored(image: &TermImages, base: u32) -> Plane {
    let levels = &image.levels[base as usize..];
    let (low, high) = range(levels);
    let scale = (high - low) / 255.0;
    let inverse = if scale > 0.0 { 1.0 / scale } else { 0.0 };
    let rounded = |value: &f32| low + scale * ((value - low) * inverse).round();
    let plane = Plane { size: levels[0].size, values: levels[0].values.iter().map(rounded).collect() };
    magnified(&plane, base, Borders::of_one(true))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::container::rgb9e5;
    use brdfc_formats::direction_set::DirectionSet;

    fn candidate(domain: DomainName, epsilon: f32, ridge: f64) -> Candidate {
        let coordinates = LightCoordinates::Hemisphere;
        Candidate { domain, epsilon, coordinates, degree: 3, ridge, psnr: 0.0, held_out_psnr: None }
    }

    #[test]
    fn most_views_decide() {
        let log = |epsilon, ridge| candidate(DomainName::Log, epsilon, ridge);
        let chosen = [log(0.1, 1e-3), candidate(DomainName::CubeRoot, 0.0, 1e-6), log(0.3, 1e-4), log(0.2, 1e-5)];
        assert_eq!(prevalent(&chosen), (Domain::Logarithm { epsilon: 0.2 }, 1e-4));
    }

    /// Known answer: a BTF whose cube roots are a product of a harmonic of the light and one of the view is
    /// reconstructed from few terms, also at held-out lights. Another BTF keeps its error.
    #[test]
    fn products_are_reconstructed() {
        let set = DirectionSet::grid(4, 9, 70.0).unwrap();
        let lights = Lights::new(&set, &[5, 12]).unwrap();
        let tilt = |at: usize| lights.directions[at][2];
        let asset = |rough: f32| {
            let value = |view: usize, light: usize, texel: usize| {
                let noise = ((view * 31 + light * 17 + texel * 7) % 13) as f32 / 13.0;
                let bright = 0.5 + 0.25 * (texel % 16 / 8) as f32;
                (bright * (0.5 + 0.5 * tilt(view)) * tilt(light) + rough * noise).powi(3)
            };
            let count = set.len();
            let word = move |view, k: usize| rgb9e5::encode([value(view, k / 256, k % 256); 3]);
            let words = (0..count).map(|view| (0..count * 256).map(|k| word(view, k)).collect()).collect();
            Asset { size: 16, words, masks: None, normals: vec![[0.0, 0.0, 1.0]; 256] }
        };
        let smooth = asset(0.0);
        let chosen = [candidate(DomainName::CubeRoot, 0.0, 1e-8)];
        let joint = Joint::fit(&smooth, &lights, (&chosen, 3), &|| ());
        let all = joint.all(&|| ());
        let few = joint.at_error(1.0, &|| ());
        assert!(all.errors.fitted.delta_e() < 0.7 && all.errors.held_out.delta_e() < 0.7, "{all:?}");
        assert!(few.errors.fitted.delta_e() < 1.2 && few.bytes <= all.bytes && few.fetches <= 4.0, "{few:?} {all:?}");
        let rough = asset(0.5);
        let found = Joint::fit(&rough, &lights, (&chosen, 3), &|| ()).all(&|| ());
        assert!(found.errors.fitted.delta_e() > 5.0, "{found:?}");
    }
}
