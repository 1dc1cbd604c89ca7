//! Encodes images of one view under known lights as a pack. Each step has its own file; this one sequences them.

use crate::assemble::{Arrangement, arrange};
use crate::choose::{Candidate, choose, to_srgb};
use crate::degrees::{SubbandDegree, degrees};
use crate::design::Design;
use crate::fit;
use crate::image::Plane;
use crate::levels::{StepUp, TermImages, steps, term_images};
use crate::lifting::Border;
use crate::measure::{StackErrors, stack_errors};
use crate::recipe::{DomainName, PwtRecipe, Target};
use crate::stack::LightSamples;
use crate::tree::{PacketTree, Transform};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{Domain, LightBasis, PwtDecoder, PwtErrors, PwtHeader, PwtPack};
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Number of colours from which the colour axes are computed.
const VALUES: usize = 1 << 16;
/// Default levels of a tree, if the sides allow them.
const DEPTH: u32 = 5;
/// Approximate number of texels of all photographs that are compared at the end.
const COMPARED: usize = 1 << 21;
/// Planes, of lower terms, by which packets are chosen.
const GUIDES: usize = 4;
/// Maximum number of packs that a search for a measured target builds.
const TRIALS: usize = 8;

/// A pack, and the results of its encoding.
#[derive(Debug, Clone)]
pub struct PwtEncoded {
    /// The pack in memory.
    pub pack: PwtPack,
    /// The best of each pair of domain and coordinates; the first was used.
    pub candidates: Vec<Candidate>,
    /// Condition number of the normal equations.
    pub condition: f64,
    /// Degrees of the subbands of each channel.
    pub subbands: [Vec<SubbandDegree>; 3],
    /// Errors of the pack at rows spread over the photographs, about two million texels in all.
    pub errors: StackErrors,
    /// True if the pack meets its target.
    pub met: bool,
}

/// Encodes images of one view.
///
/// # Errors
/// Returns an error if images or recipe are out of range, or if the sides of a tile cannot be halved for the requested
/// number of levels.
pub fn encode(samples: &LightSamples, recipe: &PwtRecipe) -> Result<PwtEncoded, FormatError> {
    samples.check()?;
    recipe.check()?;
    let depth = depth(samples, recipe)?;
    let candidates = choose(samples, recipe);
    let candidate = candidates[0];
    let domain = candidate.domain();
    let design = Design::new(candidate.basis(), &samples.lights, candidate.ridge);

    let extent = samples.size.map(|side| if samples.repeats { side } else { side.next_multiple_of(1 << depth) });
    let colour = colour_axes(samples, domain);
    let channels = channels(samples, domain, &colour, extent);
    let weights = texel_weights(samples, domain, extent);
    let coefficients = channels.each_ref().map(|values| fit::coefficients(&design, values));
    let plane = |values: Vec<f32>| Plane { size: extent, values };
    let mut coefficients = coefficients.map(|terms| terms.into_iter().map(plane).collect::<Vec<_>>());

    let border = if samples.repeats { Border::Periodic } else { Border::Mirrored };
    let transform = Transform { wavelet: recipe.wavelet, border, depth };
    let guides = &coefficients[0][..GUIDES.min(coefficients[0].len())];
    let tree = PacketTree::best(transform, guides, guide_step(guides), recipe.packets);
    let defined = defined_plane(samples, extent);
    let subbands =
        channels.map(|values| degrees(&design, &tree, values.into_iter().map(plane).collect(), defined.as_ref()));
    for (terms, subbands) in coefficients.iter_mut().zip(&subbands) {
        terms.par_iter_mut().enumerate().for_each(|(term, plane)| {
            tree.analyse(plane);
            let needed = design.basis.degree_of(term);
            for subband in subbands.iter().filter(|s| s.degree.is_none_or(|degree| degree < needed)) {
                plane.clear(subband.subband.rectangle);
            }
        });
    }
    let images = term_images(&tree, &coefficients, &weights, samples.repeats);
    drop(coefficients);

    let header = header(samples, &design, domain, colour, extent, depth);
    let search = Search { samples, images: &images, steps: steps(&images), header, candidate };
    let (pack, errors, met) = search.run(recipe.target)?;
    Ok(PwtEncoded { pack, candidates, condition: design.condition, subbands, errors, met })
}

/// Encodes all terms of a basis for red, green and blue, from one level on, fitted to sRGB-encoded values and rounded
/// to 8 bits: a pack without trees, such as hemispherical harmonics of order 3, for comparison. The ridge is chosen as
/// in [`encode`].
///
/// # Errors
/// Returns an error if images are out of range, or if the sides do not have this level.
pub fn plain(samples: &LightSamples, basis: LightBasis, level: u32) -> Result<PwtPack, FormatError> {
    samples.check()?;
    let recipe = PwtRecipe {
        coordinates: Some(basis.coordinates),
        degree: Some(basis.degree),
        domain: Some(DomainName::Display),
        depth: None,
        packets: 0,
        ..PwtRecipe::default()
    };
    let depth = depth(samples, &recipe)?;
    FormatError::check_range("level", level, 0..=depth)?;
    let candidate = choose(samples, &recipe)[0];
    let design = Design::new(basis, &samples.lights, candidate.ridge);
    let extent = samples.size.map(|side| if samples.repeats { side } else { side.next_multiple_of(1 << depth) });
    let colour = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let border = if samples.repeats { Border::Periodic } else { Border::Mirrored };
    let tree = PacketTree::pyramid(Transform { wavelet: recipe.wavelet, border, depth }, extent);
    let coefficients = channels(samples, Domain::Display, &colour, extent).map(|values| {
        let terms = fit::coefficients(&design, &values).into_iter();
        let mut planes: Vec<Plane> = terms.map(|values| Plane { size: extent, values }).collect();
        planes.par_iter_mut().for_each(|plane| tree.analyse(plane));
        planes
    });
    let images = term_images(&tree, &coefficients, &Plane::zeros(extent), samples.repeats);
    Arrangement::all_from(&images, level)
        .pack(&images, header(samples, &design, Domain::Display, colour, extent, depth))
}

/// Builds a header without textures and errors.
fn header(
    samples: &LightSamples,
    design: &Design,
    domain: Domain,
    colour: [[f32; 3]; 3],
    extent: [usize; 2],
    depth: u32,
) -> PwtHeader {
    PwtHeader {
        size: samples.size.map(|side| side as u32),
        extent: extent.map(|side| side as u32),
        repeats: samples.repeats,
        levels: depth,
        basis: design.basis,
        domain,
        colour,
        triangle: design.triangle.iter().map(|c| *c as f32).collect(),
        textures: Vec::new(),
        errors: PwtErrors { lights: 0, psnr: 0.0, held_out_psnr: 0.0, delta_e: 0.0 },
    }
}

fn depth(samples: &LightSamples, recipe: &PwtRecipe) -> Result<u32, FormatError> {
    let [width, height] = samples.size;
    let most =
        if samples.repeats { width.trailing_zeros().min(height.trailing_zeros()) } else { width.min(height).ilog2() };
    match recipe.depth {
        Some(depth) if depth > most => {
            let why = if samples.repeats { ", because the sides of a tile are halved exactly" } else { "" };
            let allowed = format!("0 to {most} for {width} x {height}{why}");
            Err(FormatError::whole("levels", depth.to_string(), allowed))
        }
        Some(depth) => Ok(depth),
        None => Ok(most.min(DEPTH)),
    }
}

/// Some texels of all photographs, in a domain.
fn some_values(samples: &LightSamples, domain: Domain) -> impl Iterator<Item = [f32; 3]> {
    let texels = samples.spread_texels(VALUES.div_ceil(samples.lights.len()));
    let values = samples.images.iter().flat_map(move |rendering| texels.clone().into_iter().map(|at| rendering[at]));
    values.map(move |value| value.map(|c| domain.encode(c)))
}

/// Principal axes of the colours: red, green and blue of three uncorrelated channels, the strongest first.
fn colour_axes(samples: &LightSamples, domain: Domain) -> [[f32; 3]; 3] {
    let mut moments = Matrix3::<f64>::zeros();
    let mut sum = nalgebra::Vector3::<f64>::zeros();
    let mut count = 0.0;
    for value in some_values(samples, domain) {
        let v = nalgebra::Vector3::from(value.map(f64::from));
        moments += v * v.transpose();
        sum += v;
        count += 1.0;
    }
    let covariance = moments / count - (sum / count) * (sum / count).transpose();
    // Grey, if colours do not vary.
    let grey = nalgebra::Vector3::repeat(1.0 / 3.0f64.sqrt());
    let eigen = (covariance + grey * grey.transpose() * 1e-12).symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    order.map(|k| {
        let axis = eigen.eigenvectors.column(k);
        let sign = if axis[axis.iamax()] < 0.0 { -1.0 } else { 1.0 };
        [0, 1, 2].map(|c| (sign * axis[c]) as f32)
    })
}

/// Channels of every photograph, padded to the extent of the pack by mirroring.
fn channels(samples: &LightSamples, domain: Domain, colour: &[[f32; 3]; 3], extent: [usize; 2]) -> [Vec<Vec<f32>>; 3] {
    let [width, height] = samples.size;
    let mirrored = |k: usize, side: usize| {
        let at = k % (2 * side);
        if at < side { at } else { 2 * side - 1 - at }
    };
    let of_rendering = |rendering: &Vec<[f32; 3]>| -> [Vec<f32>; 3] {
        let mut planes = [0, 1, 2].map(|_| Vec::with_capacity(extent[0] * extent[1]));
        for y in 0..extent[1] {
            let row = &rendering[mirrored(y, height) * width..][..width];
            let mut encoded = row.to_vec();
            domain.encode_each(encoded.as_flattened_mut());
            for (plane, axis) in planes.iter_mut().zip(colour) {
                let project = |v: &[f32; 3]| v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2];
                plane.extend((0..extent[0]).map(|x| project(&encoded[mirrored(x, width)])));
            }
        }
        planes
    };
    let all: Vec<[Vec<f32>; 3]> = samples.images.par_iter().map(of_rendering).collect();
    let mut channels = [Vec::new(), Vec::new(), Vec::new()];
    for planes in all {
        channels.iter_mut().zip(planes).for_each(|(channel, plane)| channel.push(plane));
    }
    channels
}

/// Perceptual weight of an error of each texel: the mean square of the derivative of sRGB-encoded values by values of
/// the domain; 0 where texels are not defined.
fn texel_weights(samples: &LightSamples, domain: Domain, extent: [usize; 2]) -> Plane {
    const STEP: f32 = 1e-3;
    const IMAGES: usize = 8;
    let [width, height] = samples.size;
    let stride = samples.images.len().div_ceil(IMAGES);
    let some: Vec<&Vec<[f32; 3]>> = samples.images.iter().step_by(stride).collect();
    let mut weights = Plane::zeros(extent);
    weights.values.par_chunks_exact_mut(extent[0]).take(height).enumerate().for_each(|(y, weights)| {
        for rendering in &some {
            // The middle channel, which is nearly luminance.
            let row = &rendering[y * width..][..width];
            let mut encoded: Vec<f32> = row.iter().map(|value| value[1].clamp(0.0, 1.0)).collect();
            domain.encode_each(&mut encoded);
            let stepped = encoded.iter().map(|value| value + STEP).collect();
            for ((weight, a), b) in weights.iter_mut().zip(to_srgb(domain, encoded)).zip(to_srgb(domain, stepped)) {
                *weight += ((b - a) / STEP).powi(2) / some.len() as f32;
            }
        }
        let undefined = |(x, _): &(usize, &mut f32)| !samples.is_defined(y * width + x);
        weights.iter_mut().take(width).enumerate().filter(undefined).for_each(|(_, weight)| *weight = 0.0);
    });
    weights
}

/// 1 for defined texels, 0 for others and for padding; `None` if all are defined.
fn defined_plane(samples: &LightSamples, extent: [usize; 2]) -> Option<Plane> {
    let mask = samples.defined.as_ref()?;
    let mut plane = Plane::zeros(extent);
    for (row, defined) in plane.values.chunks_exact_mut(extent[0]).zip(mask.chunks_exact(samples.size[0])) {
        row.iter_mut().zip(defined).for_each(|(value, defined)| *value = f32::from(*defined));
    }
    Some(plane)
}

/// Quantisation step for choosing packets: a hundredth of the spread of the first term.
fn guide_step(guides: &[Plane]) -> f32 {
    let Some(first) = guides.first() else { return 1.0 };
    let mean_of = |values: &dyn Fn(f64) -> f64| {
        first.values.iter().map(|v| values(f64::from(*v))).sum::<f64>() / first.values.len() as f64
    };
    let mean = mean_of(&|value| value);
    let variance = mean_of(&|value| (value - mean).powi(2));
    (0.01 * variance.sqrt()).max(1e-9) as f32
}

/// Search for the smallest pack that meets a target.
struct Search<'a> {
    samples: &'a LightSamples,
    images: &'a [TermImages],
    steps: Vec<StepUp>,
    header: PwtHeader,
    candidate: Candidate,
}

impl Search<'_> {
    fn run(self, target: Target) -> Result<(PwtPack, StackErrors, bool), FormatError> {
        let last = self.steps.len();
        match target {
            Target::Bytes(bytes) => {
                let fits = |count: usize| self.bytes(&self.arranged(count)) <= bytes;
                let (mut low, mut high) = (0, last + 1);
                while high - low > 1 {
                    let middle = low.midpoint(high);
                    if fits(middle) { low = middle } else { high = middle }
                }
                let count = low;
                let (pack, errors) = self.made(count)?;
                let met = pack.gpu_bytes() <= bytes;
                Ok((pack, errors, met))
            }
            Target::Energy(share) => {
                let none = self.left(0);
                let count = (0..=last).find(|count| self.left(*count) <= (1.0 - share) * none);
                let (pack, errors) = self.made(count.unwrap_or(last))?;
                Ok((pack, errors, count.is_some()))
            }
            Target::Loss(loss) => {
                // Truncation adds to the error at held-out lights.
                let unseen = self.candidate.held_out_psnr.unwrap_or(self.candidate.psnr);
                let unseen = 10f64.powf(-unseen / 10.0);
                let numbers = (3 * self.samples.defined_texels() * self.samples.lights.len()) as f64;
                let allowed = (10f64.powf(loss / 10.0) - 1.0) * unseen * numbers + self.left(last);
                let count = (0..=last).find(|count| self.left(*count) <= allowed).unwrap_or(last);
                let (pack, errors) = self.made(count)?;
                Ok((pack, errors, true))
            }
            Target::Quality(psnr) => self.measured(|errors| errors.psnr >= psnr),
            Target::DeltaE(delta_e) => self.measured(|errors| errors.delta_e <= delta_e),
        }
    }

    /// Finds approximately the fewest steps whose pack passes, by bisection with up to [`TRIALS`] packs; all steps if
    /// none passes.
    fn measured(&self, passes: impl Fn(&StackErrors) -> bool) -> Result<(PwtPack, StackErrors, bool), FormatError> {
        let (mut low, mut high) = (0, self.steps.len());
        let mut best = self.made(high)?;
        if !passes(&best.1) {
            return Ok((best.0, best.1, false));
        }
        for _ in 0..TRIALS {
            if high - low <= 1 {
                break;
            }
            let middle = low + (high - low).div_ceil(2);
            let made = self.made(middle)?;
            if passes(&made.1) {
                (high, best) = (middle, made);
            } else {
                low = middle;
            }
        }
        Ok((best.0, best.1, true))
    }

    /// Weighted error after some steps.
    fn left(&self, count: usize) -> f64 {
        match count.checked_sub(1) {
            Some(step) => self.steps[step].error,
            None => self.images.iter().map(|image| image.errors[image.errors.len() - 1]).sum(),
        }
    }

    fn arranged(&self, count: usize) -> Arrangement {
        arrange(self.images, &self.steps, count)
    }

    fn bytes(&self, arrangement: &Arrangement) -> u64 {
        arrangement.bytes(self.header.extent, self.header.levels)
    }

    /// Builds and measures the pack of some steps.
    fn made(&self, count: usize) -> Result<(PwtPack, StackErrors), FormatError> {
        let pack = self.arranged(count).pack(self.images, self.header.clone())?;
        let decoder = PwtDecoder::new(pack);
        let all = self.samples.size[0] * self.samples.size[1] * self.samples.lights.len();
        let errors = stack_errors(&decoder, self.samples, all.div_ceil(COMPARED));
        let measured = PwtErrors {
            lights: errors.lights as u32,
            psnr: errors.psnr as f32,
            held_out_psnr: self.candidate.held_out_psnr.unwrap_or(0.0) as f32,
            delta_e: errors.delta_e as f32,
        };
        Ok((decoder.into_pack().with_errors(measured), errors))
    }
}
