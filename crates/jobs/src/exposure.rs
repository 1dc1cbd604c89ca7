//! Exposure of images: those that are black or white everywhere, and values at the end of the scale.

use brdfc_core::words::{counted_of, percent};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Linear values this near to 1 are the end of the scale of integers, also of 12 bits that are shifted to 16.
const END: f32 = 6e-4;
/// Largest value of the scale of integers, with the rounding of a conversion.
const LARGEST: f32 = 1.0 + 1e-6;
/// Share of values at the end of the scale above which there is a note.
const MAX_AT_END: f64 = 0.01;

/// Exposures of images, by view and light.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Exposures(BTreeMap<[usize; 2], Exposure>);

/// Exposure of an image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Exposure {
    is_black: bool,
    is_white: bool,
    /// Share of values at the end of the scale.
    at_end: f64,
}

impl Exposure {
    /// Exposure of an image, linear RGB; white is 1.
    pub fn of(pixels: impl Iterator<Item = [f32; 3]>) -> Self {
        let (mut is_black, mut is_white, mut at_end, mut count) = (true, true, 0usize, 0usize);
        for value in pixels.flatten() {
            is_black &= value <= 0.0;
            is_white &= value >= 1.0;
            at_end += usize::from((1.0 - END..=LARGEST).contains(&value));
            count += 1;
        }
        Self { is_black, is_white, at_end: at_end as f64 / count.max(1) as f64 }
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
    /// Share of all values at the end of the scale of integers, where brighter light is cut off.
    pub at_end: f64,
}

impl Exposures {
    /// Adds an image of a view under a light.
    pub fn add(&mut self, place: [usize; 2], exposure: Exposure) {
        self.0.insert(place, exposure);
    }

    /// Returns true for an image that was added.
    pub fn has(&self, place: [usize; 2]) -> bool {
        self.0.contains_key(&place)
    }

    /// Exposures without those of some lights.
    pub fn without(mut self, lights: &[usize]) -> Self {
        self.0.retain(|[_, light], _| !lights.contains(light));
        self
    }

    /// Views and lights of images that are black everywhere, and of those that are white everywhere.
    pub fn uniform(&self) -> [(&'static str, Vec<[usize; 2]>); 2] {
        let those = |is: fn(&Exposure) -> bool| {
            self.0.iter().filter(|(_, exposure)| is(exposure)).map(|(place, _)| *place).collect()
        };
        [("black", those(|exposure| exposure.is_black)), ("white", those(|exposure| exposure.is_white))]
    }

    /// Counts, and the share of values at the end of the scale.
    pub fn facts(&self) -> ExposureFacts {
        let [(_, black), (_, white)] = self.uniform();
        let at_end = self.0.values().map(|exposure| exposure.at_end).sum::<f64>() / self.0.len().max(1) as f64;
        ExposureFacts { images: self.0.len(), black: black.len(), white: white.len(), at_end }
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
            notes.push(format!(
                "{share} of the values are at the end of the scale: brighter light is cut off, images are overexposed"
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
        // Values above 1, as of floats, are not cut off; white of 12 bits that are shifted to 16 is.
        for white in [1.0, 0.999_5] {
            let bright = of(&[[white, 0.5, 0.1, 0.1], [7.0, 2.0, 0.1, 0.1]]).facts().notes();
            assert!(bright.len() == 1 && bright[0].starts_with("12.500 % of the values are at the end"), "{bright:?}");
        }
    }
}
