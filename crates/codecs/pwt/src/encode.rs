//! Encodes images of one view, or of all views of a BTF, under known lights as a pack. Each step has its own file; this one sequences them.

use crate::assemble::Arrangement;
use crate::candidates::{Candidate, SquaredSlopes};
use crate::choose::choose;
use crate::choose_learned::LearnedCandidate;
use crate::degrees::{SubbandDegree, degrees};
use crate::design::Design;
use crate::encoded::Padded;
use crate::fit;
use crate::image::Plane;
use crate::levels::{Borders, TermImages, term_images};
use crate::lifting::{Border, Wavelet};
use crate::measure::StackErrors;
use crate::project;
use crate::recipe::{DomainName, PwtRecipe};
use crate::search::{Found, Search};
use crate::stack::LightSamples;
use crate::tree::{PacketTree, Transform};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{Domain, LightBasis, LightCoordinates, LightMap, PwtErrors, PwtHeader, PwtPack};
use brdfc_readers::pixels::Pixels;
use nalgebra::Matrix3;
use rayon::prelude::*;

/// Number of colours from which the colour axes are computed.
const VALUES: usize = 1 << 16;
/// Default levels of a tree, if the sides allow them.
const DEPTH: u32 = 5;
/// Planes, of lower terms, by which packets are chosen.
const GUIDES: usize = 4;

/// A pack, and the results of its encoding.
#[derive(Debug, Clone)]
pub struct PwtEncoded {
    /// The pack in memory.
    pub pack: PwtPack,
    /// The best of each pair of domain and coordinates; the first was used.
    pub candidates: Vec<Candidate>,
    /// Condition number of the normal equations of polynomials; `None` for learned terms.
    pub condition: Option<f64>,
    /// Degrees of the subbands of each channel; empty for learned terms.
    pub subbands: [Vec<SubbandDegree>; 3],
    /// Errors of the pack at rows spread over the photographs, about two million texels in all.
    pub errors: StackErrors,
    /// True if the pack meets its target.
    pub met: bool,
}

/// Encodes images of one view, or of several views, which have all terms of the light in common. Images of near lights are
/// converted to distant lights.
///
/// # Errors
/// Returns an error if images or recipe are out of range, if the sides of a tile cannot be halved for the requested
/// number of levels, or for several views with another wavelet than Haar's.
pub fn encode(samples: &LightSamples, recipe: &PwtRecipe) -> Result<PwtEncoded, FormatError> {
    samples.check()?;
    recipe.check()?;
    check_wavelet(samples, recipe)?;
    let samples = &*samples.distant()?;
    let depth = depth(samples, recipe)?;
    let choice = choose(samples, recipe)?;
    let candidate = choice.candidates[0];
    let domain = candidate.domain();
    let extent = samples.size.map(|side| if samples.repeats { side } else { side.next_multiple_of(1 << depth) });
    let border = if samples.repeats { Border::Periodic } else { Border::Mirrored };
    let transform = Transform { wavelet: recipe.wavelet, border, depth };
    let fitted = match &choice.learned {
        Some((learned, few)) => fit_learned(few, learned, transform, extent),
        None => fit_polynomials(samples, candidate, transform, recipe.packets, extent),
    };
    let header = fitted.header(samples, domain, extent, depth);
    let (lights, by_terms) = match &choice.learned {
        Some((learned, few)) => (few.lights.len(), &learned.by_terms[..]),
        None => (samples.lights.len(), &choice.candidates[..1]),
    };
    let search = Search::new(samples, lights, &fitted.images, header, by_terms, recipe);
    let Found { pack, errors, candidate, met } = search.run(recipe.target)?;
    let mut candidates = choice.candidates;
    candidates[0] = candidate;
    let Fitted { condition, subbands, .. } = fitted;
    Ok(PwtEncoded { pack, candidates, condition, subbands, errors, met })
}

fn borders(samples: &LightSamples) -> Borders {
    Borders { repeats: samples.repeats, views: samples.view_count() }
}

/// Terms fitted to photographs.
struct Fitted {
    images: Vec<TermImages>,
    basis: LightBasis,
    colour: [[f32; 3]; 3],
    triangle: Vec<f32>,
    light_map: Option<LightMap>,
    condition: Option<f64>,
    subbands: [Vec<SubbandDegree>; 3],
}

/// Fits polynomials to principal colours.
fn fit_polynomials(
    samples: &LightSamples,
    candidate: Candidate,
    transform: Transform,
    packets: u32,
    extent: [usize; 2],
) -> Fitted {
    let domain = candidate.domain();
    let weights = texel_weights(samples, domain, extent, |_| 1.0);
    let design = Design::new(candidate.basis(), &samples.lights, candidate.ridge);
    let colour = colour_axes(samples, domain);
    let channels = channels(samples, domain, &colour, extent);
    let coefficients = channels.each_ref().map(|values| fit::coefficients(&design, values));
    let plane = |values: Vec<f32>| Plane { size: extent, values };
    let mut coefficients = coefficients.map(|terms| terms.into_iter().map(plane).collect::<Vec<_>>());
    let guides = &coefficients[0][..GUIDES.min(coefficients[0].len())];
    let tree = PacketTree::best(transform, guides, guide_step(guides), packets);
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
    let images = term_images(&tree, &coefficients, &weights, borders(samples));
    let triangle = design.triangle.iter().map(|c| *c as f32).collect();
    Fitted {
        images,
        basis: design.basis,
        colour,
        triangle,
        light_map: None,
        condition: Some(design.condition),
        subbands,
    }
}

/// Learns terms, and projects photographs on them.
fn fit_learned(
    samples: &LightSamples,
    candidate: &LearnedCandidate,
    transform: Transform,
    extent: [usize; 2],
) -> Fitted {
    let learned = candidate.learn(samples);
    let domain = candidate.candidate().domain();
    let weights = texel_weights(samples, domain, extent, |light| learned.weights[light]);
    let planes = project::coefficients(&learned, &Padded::new(samples, domain, extent));
    let image = |(k, values): (usize, Vec<f32>)| {
        let plane = Plane { size: extent, values };
        TermImages::of_plane((0, k + 1), transform, plane, &weights, borders(samples))
    };
    let images = planes.into_par_iter().enumerate().map(image).collect();
    let degree = learned.map.terms() as u32 - 1;
    Fitted {
        images,
        basis: LightBasis { coordinates: LightCoordinates::Learned, degree },
        colour: [[1.0; 3], [0.0; 3], [0.0; 3]],
        triangle: Vec::new(),
        light_map: Some(learned.map),
        condition: None,
        subbands: [const { Vec::new() }; 3],
    }
}

impl Fitted {
    /// Header without textures and errors.
    fn header(&self, samples: &LightSamples, domain: Domain, extent: [usize; 2], levels: u32) -> PwtHeader {
        let [width, height] = extent;
        PwtHeader {
            size: samples.view_size().map(|side| side as u32),
            extent: [width, height / samples.view_count()].map(|side| side as u32),
            repeats: samples.repeats,
            levels,
            basis: self.basis,
            views: samples.views.as_ref().map(|views| views.mesh().clone()),
            domain,
            colour: self.colour,
            triangle: self.triangle.clone(),
            light_map: self.light_map.clone(),
            textures: Vec::new(),
            errors: PwtErrors { lights: 0, psnr: 0.0, held_out_psnr: 0.0, delta_e: 0.0 },
        }
    }
}

/// Red, green and blue as colours of channels.
const RGB: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

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
    let candidate = choose(samples, &recipe)?.candidates[0];
    let design = Design::new(basis, &samples.lights, candidate.ridge);
    let extent = samples.size.map(|side| if samples.repeats { side } else { side.next_multiple_of(1 << depth) });
    let border = if samples.repeats { Border::Periodic } else { Border::Mirrored };
    let tree = PacketTree::pyramid(Transform { wavelet: recipe.wavelet, border, depth }, extent);
    let coefficients = channels(samples, Domain::Display, &RGB, extent).map(|values| {
        let terms = fit::coefficients(&design, &values).into_iter();
        let mut planes: Vec<Plane> = terms.map(|values| Plane { size: extent, values }).collect();
        planes.par_iter_mut().for_each(|plane| tree.analyse(plane));
        planes
    });
    let images = term_images(&tree, &coefficients, &Plane::zeros(extent), Borders::of_one(samples.repeats));
    let fitted = Fitted {
        images,
        basis: design.basis,
        colour: RGB,
        triangle: design.triangle.iter().map(|c| *c as f32).collect(),
        light_map: None,
        condition: Some(design.condition),
        subbands: [const { Vec::new() }; 3],
    };
    Arrangement::all_from(&fitted.images, level)
        .pack(&fitted.images, fitted.header(samples, Domain::Display, extent, depth))
}

/// Rejects wavelets that would cross the borders between stacked views.
fn check_wavelet(samples: &LightSamples, recipe: &PwtRecipe) -> Result<(), FormatError> {
    if samples.views.is_none() || recipe.wavelet == Wavelet::Haar {
        return Ok(());
    }
    let allowed = format!("{} for several views", Wavelet::Haar.name());
    Err(FormatError::whole("wavelet", recipe.wavelet.name(), allowed))
}

fn depth(samples: &LightSamples, recipe: &PwtRecipe) -> Result<u32, FormatError> {
    let [width, height] = samples.view_size();
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
    let values = samples.images.iter().flat_map(move |image| texels.clone().into_iter().map(|at| image.pixel(at)));
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

/// Channels of every photograph, padded to the extent of the pack, channel by channel.
fn channels(samples: &LightSamples, domain: Domain, colour: &[[f32; 3]; 3], extent: [usize; 2]) -> [Vec<Vec<f32>>; 3] {
    let padded = Padded::new(samples, domain, extent);
    let of_light = |light: usize| {
        let mut planes = [0, 1, 2].map(|_| Vec::with_capacity(extent[0] * extent[1]));
        for row in (0..extent[1]).map(|row| padded.row(light, row)) {
            for (plane, axis) in planes.iter_mut().zip(colour) {
                plane.extend(row.iter().map(|v| v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2]));
            }
        }
        planes
    };
    let all: Vec<[Vec<f32>; 3]> = (0..samples.lights.len()).into_par_iter().map(of_light).collect();
    let mut channels = [Vec::new(), Vec::new(), Vec::new()];
    for planes in all {
        channels.iter_mut().zip(planes).for_each(|(channel, plane)| channel.push(plane));
    }
    channels
}

/// Perceptual weight of an error of each texel: the mean square of the slope of sRGB-encoded values over values of the domain,
/// relative to the weight that each light has in the fit; 0 where texels are not defined.
fn texel_weights(
    samples: &LightSamples,
    domain: Domain,
    extent: [usize; 2],
    weight_of_light: impl Fn(usize) -> f32,
) -> Plane {
    const IMAGES: usize = 8;
    let [width, height] = samples.size;
    let stride = samples.images.len().div_ceil(IMAGES);
    let lights = (0..samples.images.len()).step_by(stride);
    let some: Vec<(&Pixels, f32)> = lights.map(|light| (&samples.images[light], weight_of_light(light))).collect();
    let slopes = SquaredSlopes::new(domain);
    let mut weights = Plane::zeros(extent);
    weights.values.par_chunks_exact_mut(extent[0]).take(height).enumerate().for_each(|(y, weights)| {
        for (image, weight_of_light) in &some {
            // The middle channel, which is nearly luminance.
            let row = image.linear(y * width..(y + 1) * width);
            let mut encoded: Vec<f32> = row.iter().map(|value| value[1]).collect();
            domain.encode_each(&mut encoded);
            for (weight, value) in weights.iter_mut().zip(encoded) {
                *weight += slopes.at(value) / (weight_of_light.powi(2) * some.len() as f32);
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Known answers: squared slopes of the sRGB curve, half of them at black and white, whose other side is clipped.
    #[test]
    fn weights_of_texels_are_squared_slopes() {
        let values: Vec<[f32; 3]> = [0.0, 0.5, 1.0, 3.0].map(|value| [9.0, value, 9.0]).to_vec();
        let samples = LightSamples::new([2, 2], vec![[0.0, 0.0, 1.0]; 2], vec![values.clone(), values]);
        let slope = |value: f32| 1.055 / 2.4 * value.powf(1.0 / 2.4 - 1.0);
        let expected = [0.5 * 12.92f32.powi(2), slope(0.5).powi(2), 0.5 * slope(1.0).powi(2), 0.5 * slope(1.0).powi(2)];
        let found = texel_weights(&samples, Domain::Linear, [4, 2], |_| 2.0);
        for (texel, expected) in [0, 1, 4, 5].into_iter().zip(expected) {
            let found = 4.0 * found.values[texel];
            assert!((found / expected - 1.0).abs() < 0.01, "{texel}: {found} {expected}");
        }
        assert_eq!(found.values[2], 0.0);
        // Errors of sRGB values count alike, except at the ends.
        let display = texel_weights(&samples, Domain::Display, [2, 2], |_| 1.0);
        assert!((display.values[1] - 1.0).abs() < 1e-3, "{:?}", display.values);
    }
}
