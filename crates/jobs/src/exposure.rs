//! Exposure of images: those that are black or white everywhere, and values at the end of the scale.

use brdfc_core::words::{counted_of, percent};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Linear values this near to 1 are the end of the scale of integers, also of 12 bits that are shifted to 16.
const END: f32 = 6e-4;
/// Largest value of the scale of integers, with the rounding of a conversion.
const LARGEST: f32 = 1.0 + 1e-6;
/// Relative difference of values that are equal but for rounding.
const EQUAL: f32 = 1e-4;
/// Share of values at the end of the scale above which there is a note.
const MAX_AT_END: f64 = 0.01;
/// Values from which an image is white, by its darkest one.
const WHITE: f32 = 0.96;
/// Minimum number of images whose largest values are equal if they are cut off below 1.
const MIN_CUT: usize = 3;
/// Depth of the values below those that are cut off below 1, relative.
const NEAR: f32 = 0.03;
/// Ratio of their number and the number of those: light that is not cut off has about as many or more, and images of few colours none.
const BELOW_CUT: std::ops::Range<f64> = 0.01..0.4;
/// Mean of a black image, with noise, as a share of the median of all.
const BLACK: f64 = 0.005;

/// Exposures of images, by view and light.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Exposures {
    images: BTreeMap<[usize; 2], Exposure>,
    /// Pixels at the end of the scale in all images of each view: a mask, or a white background. One bit for each.
    masked: BTreeMap<usize, Vec<u64>>,
}

/// Exposure of an image.
#[derive(Debug, Clone, PartialEq)]
pub struct Exposure {
    pixels: usize,
    mean: f64,
    is_white: bool,
    largest: f32,
    /// Share of values that equal the largest one.
    at_largest: f64,
    /// Share of values below these, within [`NEAR`].
    near_largest: f64,
    /// Share of values at the end of the scale.
    at_end: f64,
    /// Pixels at the end of the scale in all channels.
    masked: Vec<u64>,
}

impl Exposure {
    /// Exposure of an image, linear RGB; white is 1.
    pub fn of(pixels: impl Iterator<Item = [f32; 3]> + Clone) -> Self {
        let largest = pixels.clone().flatten().fold(0.0, f32::max);
        let (mut sum, mut is_white) = (0.0, true);
        let (mut at_end, mut at_largest, mut near_largest, mut count) = (0usize, 0usize, 0usize, 0usize);
        let mut masked = Vec::new();
        for (number, pixel) in pixels.enumerate() {
            let is_at_end = pixel.map(|value| (1.0 - END..=LARGEST).contains(&value));
            for value in pixel {
                sum += f64::from(value);
                is_white &= value >= WHITE;
                at_largest += usize::from(value >= largest * (1.0 - EQUAL));
                near_largest += usize::from(value >= largest * (1.0 - NEAR));
            }
            at_end += is_at_end.into_iter().filter(|is| *is).count();
            if number % 64 == 0 {
                masked.push(0);
            }
            masked[number / 64] |= u64::from(is_at_end == [true; 3]) << (number % 64);
            count += 3;
        }
        let share = |part: usize| part as f64 / count.max(1) as f64;
        let mean = sum / count.max(1) as f64;
        Self {
            pixels: count / 3,
            mean,
            is_white,
            largest,
            at_largest: share(at_largest),
            near_largest: share(near_largest - at_largest),
            at_end: share(at_end),
            masked,
        }
    }
}

/// Exposures of all images of an asset.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct ExposureFacts {
    /// Number of images.
    pub images: usize,
    /// Number of images that are black everywhere.
    pub black: usize,
    /// Number of images that are white everywhere.
    pub white: usize,
    /// Value at which brighter light is cut off: 1, or the largest one if it is that of several images.
    pub end: f64,
    /// Share of all values at this end, without pixels that are at it in all images.
    pub at_end: f64,
}

impl Exposures {
    /// Adds an image of a view under a light.
    pub fn add(&mut self, [view, light]: [usize; 2], mut exposure: Exposure) {
        let masked = std::mem::take(&mut exposure.masked);
        match self.masked.get_mut(&view) {
            Some(all) => all.iter_mut().zip(masked).for_each(|(all, one)| *all &= one),
            None => drop(self.masked.insert(view, masked)),
        }
        self.images.insert([view, light], exposure);
    }

    /// Returns true for an image that was added.
    pub fn has(&self, place: [usize; 2]) -> bool {
        self.images.contains_key(&place)
    }

    /// Exposures without those of some lights.
    pub fn without(mut self, lights: &[usize]) -> Self {
        self.images.retain(|[_, light], _| !lights.contains(light));
        self
    }

    /// Views and lights of images that are black everywhere, but for noise, and of those that are white everywhere.
    pub fn uniform(&self) -> [(&'static str, Vec<[usize; 2]>); 2] {
        let mut means: Vec<f64> = self.images.values().map(|exposure| exposure.mean).collect();
        means.sort_by(f64::total_cmp);
        let black = means.get(means.len() / 2).map_or(0.0, |median| BLACK * median);
        let those = |is: &dyn Fn(&Exposure) -> bool| {
            self.images.iter().filter(|(_, exposure)| is(exposure)).map(|(place, _)| *place).collect()
        };
        let white = |exposure: &Exposure| exposure.is_white;
        [("black", those(&|exposure| exposure.mean <= black)), ("white", those(&white))]
    }

    /// Counts, and the share of values at the end of the scale.
    pub fn facts(&self) -> ExposureFacts {
        let [(_, black), (_, white)] = self.uniform();
        let largest = self.images.values().map(|exposure| exposure.largest).fold(0.0, f32::max);
        let cut: Vec<&Exposure> =
            self.images.values().filter(|exposure| exposure.largest >= largest * (1.0 - EQUAL)).collect();
        let is_cut_below = largest < 1.0 - END && cut.len() >= MIN_CUT;
        let sum = |share: fn(&Exposure) -> f64| self.images.values().map(share).sum::<f64>();
        let all = self.images.len().max(1) as f64;
        let of_cut = |share: fn(&Exposure) -> f64| cut.iter().map(|exposure| share(exposure)).sum::<f64>() / all;
        let [equal, near] = [of_cut(|exposure| exposure.at_largest), of_cut(|exposure| exposure.near_largest)];
        let (end, at_end) = match is_cut_below && BELOW_CUT.contains(&(near / equal)) {
            true => (f64::from(largest), equal),
            false => (1.0, (sum(|exposure| exposure.at_end) - self.masked()) / all),
        };
        ExposureFacts { images: self.images.len(), black: black.len(), white: white.len(), end, at_end }
    }

    /// Sum over images of the share of pixels that are at the end of the scale in all images of their view.
    fn masked(&self) -> f64 {
        let of_image = |([view, _], exposure): (&[usize; 2], &Exposure)| {
            let masked = self.masked.get(view).map_or(0, |bits| bits.iter().map(|bits| bits.count_ones()).sum());
            f64::from(masked) / exposure.pixels.max(1) as f64
        };
        self.images.iter().map(of_image).sum()
    }
}

impl ExposureFacts {
    /// Notes about these images, and about values at the end of the scale.
    pub fn notes(&self) -> Vec<String> {
        let uniform = [("black", self.black), ("white", self.white)].into_iter().filter(|(_, count)| *count > 0);
        let mut notes: Vec<String> = uniform
            .map(|(name, count)| format!("{}: {name} everywhere", counted_of(count, self.images, "image")))
            .collect();
        if self.at_end > MAX_AT_END {
            let share = percent(self.at_end);
            let end = if self.end < 1.0 { format!(", {:.2}", self.end) } else { String::new() };
            notes.push(format!(
                "{share} of the values are at the end of the scale{end}: brighter light is cut off, images are overexposed"
            ));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_images_and_the_end_of_the_scale_are_noted() {
        let of = |images: &[[f32; 4]]| {
            let mut exposures = Exposures::default();
            for (light, values) in images.iter().enumerate() {
                exposures.add([0, light], Exposure::of(values.iter().map(|value| [*value; 3])));
            }
            exposures
        };
        assert!(of(&[[0.0, 0.5, 0.9, 0.2], [0.1, 0.0, 0.0, 0.0]]).facts().notes().is_empty());
        let black = of(&[[0.0; 4], [0.1, 0.2, 0.3, 0.4]]);
        assert_eq!(black.uniform(), [("black", vec![[0, 0]]), ("white", vec![])]);
        assert_eq!(black.facts().notes(), ["1 of 2 images: black everywhere"]);
        assert!(black.without(&[0]).facts().notes().is_empty());
        // With noise.
        let dim = of(&[[0.0003, 0.0, 0.0, 0.0], [0.1, 0.2, 0.3, 0.4], [0.2; 4]]);
        assert_eq!(dim.facts().notes(), ["1 of 3 images: black everywhere"]);
        // A mask, and light that is cut off below the end of the scale.
        assert!(of(&[[1.0, 0.5, 0.1, 0.1], [1.0, 0.1, 0.1, 0.1]]).facts().notes().is_empty());
        let cut = of(&[[0.9, 0.5, 0.9, 0.1], [0.5, 0.9, 0.1, 0.89], [0.5, 0.1, 0.9, 0.1]]).facts().notes();
        assert_eq!(cut.len(), 1);
        assert!(cut[0].starts_with("33.333 % of the values are at the end of the scale, 0.90:"), "{cut:?}");
        // Few colours, and light that is not cut off.
        assert!(of(&[[0.9, 0.5, 0.9, 0.1]; 3]).facts().notes().is_empty());
        assert!(of(&[[0.9, 0.88, 0.89, 0.1]; 3]).facts().notes().is_empty());
        // Values above 1, as of floats, are not cut off; white of 12 bits that are shifted to 16 is.
        for white in [1.0, 0.999_5] {
            let bright = of(&[[white, 0.5, 0.1, 0.1], [7.0, 2.0, 0.2, 0.1]]).facts().notes();
            assert!(bright.len() == 1 && bright[0].starts_with("12.500 % of the values are at the end"), "{bright:?}");
        }
    }
}
