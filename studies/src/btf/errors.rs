//! Errors of renderings of a view.

use super::lights::Lights;
use brdfc_formats::pwt::Domain;
use brdfc_metrics::lab::{distance_squared, lab};
use brdfc_pwt::candidates::decibels;
use rayon::prelude::*;

/// Sums over texels and lights.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sums {
    /// Sum of squared differences of sRGB values, 0 to 1.
    squares: f64,
    /// Sum of ΔE.
    distances: f64,
    /// Number of texels under lights.
    count: f64,
}

impl Sums {
    fn add(&mut self, other: Self) {
        self.squares += other.squares;
        self.distances += other.distances;
        self.count += other.count;
    }

    pub(super) fn delta_e(&self) -> f64 {
        self.distances / self.count.max(1.0)
    }

    pub(super) fn psnr(&self) -> f64 {
        decibels(self.squares / (3.0 * self.count.max(1.0)))
    }
}

/// Errors at fitted and held-out lights.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Errors {
    pub(super) fitted: Sums,
    pub(super) held_out: Sums,
}

impl Errors {
    pub(super) fn add(&mut self, other: Self) {
        self.fitted.add(other.fitted);
        self.held_out.add(other.held_out);
    }
}

/// A view under all lights, prepared for comparison: sRGB and L*a*b* values of the texels that count.
pub(super) struct Truth {
    texels: Vec<usize>,
    lights: Vec<Compared>,
}

/// The view under one light.
struct Compared {
    codes: Vec<[f32; 3]>,
    labs: Vec<[f32; 3]>,
}

pub(super) fn codes(mut colours: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    let values = colours.as_flattened_mut();
    values.iter_mut().for_each(|value| *value = value.clamp(0.0, 1.0));
    Domain::Display.encode_each(values);
    colours
}

impl Truth {
    /// Prepares linear RGB under each light. With a mask, only its texels count.
    pub(super) fn new(renderings: &[Vec<[f32; 3]>], mask: Option<&[bool]>) -> Self {
        let all = renderings.first().map_or(0, Vec::len);
        let texels: Vec<usize> = (0..all).filter(|texel| mask.is_none_or(|mask| mask[*texel])).collect();
        let light = |rendering: &Vec<[f32; 3]>| {
            let colours: Vec<[f32; 3]> = texels.iter().map(|texel| rendering[*texel]).collect();
            let labs = colours.iter().map(|colour| lab(*colour)).collect();
            Compared { codes: codes(colours), labs }
        };
        let lights = renderings.par_iter().map(light).collect();
        Self { texels, lights }
    }

    /// Errors of renderings under the same lights.
    pub(super) fn errors(&self, renderings: &[Vec<[f32; 3]>], lights: &Lights) -> Errors {
        let light = |(rendering, expected): (&Vec<[f32; 3]>, &Compared)| {
            let colours: Vec<[f32; 3]> = self.texels.iter().map(|texel| rendering[*texel]).collect();
            let distance =
                |(colour, expected): (&[f32; 3], &[f32; 3])| distance_squared(lab(*colour), *expected).sqrt();
            let distances = colours.iter().zip(&expected.labs).map(distance).map(f64::from).sum();
            let found = codes(colours);
            let pairs = found.as_flattened().iter().zip(expected.codes.as_flattened());
            let squares = pairs.map(|(a, b)| f64::from((a - b) * (a - b))).sum();
            Sums { squares, distances, count: self.texels.len() as f64 }
        };
        let sums: Vec<Sums> = renderings.par_iter().zip(&self.lights).map(light).collect();
        let mut errors = Errors::default();
        lights.fitted.iter().for_each(|light| errors.fitted.add(sums[*light]));
        lights.held_out.iter().for_each(|light| errors.held_out.add(sums[*light]));
        errors
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::direction_set::DirectionSet;

    #[test]
    fn errors_of_known_renderings() {
        let lights = Lights::new(&DirectionSet::grid(3, 4, 60.0).unwrap(), &[4]).unwrap();
        let rendering = |value: f32| vec![[value; 3]; 4];
        let truth: Vec<_> = (0..9).map(|_| rendering(0.5)).collect();
        let found: Vec<_> = (0..9).map(|light| rendering(if light == 4 { 0.0 } else { 0.5 })).collect();
        let errors = Truth::new(&truth, None).errors(&found, &lights);
        assert_eq!((errors.fitted.delta_e(), errors.fitted.count), (0.0, 32.0));
        // L* of half of white's luminance.
        assert!((errors.held_out.delta_e() - 76.07).abs() < 0.05, "{errors:?}");
        // The sRGB value of one half is 0.735.
        assert!((errors.held_out.psnr() + 20.0 * 0.7354f64.log10()).abs() < 0.01, "{errors:?}");
        // Texels outside the mask do not count.
        let mut off = truth.clone();
        off.iter_mut().for_each(|rendering| rendering[2] = [1.0; 3]);
        assert!(Truth::new(&truth, None).errors(&off, &lights).fitted.delta_e() > 1.0);
        let masked = Truth::new(&truth, Some(&[true, true, false, true])).errors(&off, &lights);
        assert_eq!((masked.fitted.delta_e(), masked.fitted.count), (0.0, 24.0));
    }
}
