//! Exposure of photographs: those that are black or white everywhere, and values at the end of the scale.

use brdfc_core::words::{counted_of, percent};
use std::collections::BTreeMap;

/// Values this near to 1 are the end of the scale of integer formats.
const END: f32 = 1e-6;
/// Share of values at the end of the scale above which there is a note.
const MAX_AT_END: f64 = 0.01;

/// Exposure of photographs, by view and light.
#[derive(Debug, Clone, Default)]
pub struct Exposures(BTreeMap<[usize; 2], Exposure>);

/// Exposure of a photograph.
#[derive(Debug, Clone, Copy)]
struct Exposure {
    is_black: bool,
    is_white: bool,
    /// Share of values at the end of the scale.
    at_end: f64,
}

impl Exposures {
    /// Adds a photograph, linear RGB; white is 1.
    pub fn add(&mut self, [view, light]: [usize; 2], pixels: impl Iterator<Item = [f32; 3]>) {
        let mut exposure = Exposure { is_black: true, is_white: true, at_end: 0.0 };
        let (mut at_end, mut count) = (0usize, 0usize);
        for value in pixels.flatten() {
            exposure.is_black &= value <= 0.0;
            exposure.is_white &= value >= 1.0 - END;
            at_end += usize::from((value - 1.0).abs() <= END);
            count += 1;
        }
        exposure.at_end = at_end as f64 / count.max(1) as f64;
        self.0.insert([view, light], exposure);
    }

    /// Adds the exposures of other photographs.
    pub fn merge(&mut self, other: Self) {
        self.0.extend(other.0);
    }

    /// Views and lights of photographs that are black everywhere, and of those that are white everywhere.
    pub fn uniform(&self) -> [(&'static str, Vec<[usize; 2]>); 2] {
        let those = |is: fn(&Exposure) -> bool| {
            self.0.iter().filter(|(_, exposure)| is(exposure)).map(|(place, _)| *place).collect()
        };
        [("black", those(|exposure| exposure.is_black)), ("white", those(|exposure| exposure.is_white))]
    }

    /// Notes about these photographs, and about values at the end of the scale.
    pub fn notes(&self) -> Vec<String> {
        let all = self.0.len();
        let uniform = self.uniform().into_iter().filter(|(_, places)| !places.is_empty());
        let mut notes: Vec<String> = uniform
            .map(|(name, places)| format!("{}: {name} everywhere", counted_of(places.len(), all, "photograph")))
            .collect();
        let at_end = self.0.values().map(|exposure| exposure.at_end).sum::<f64>() / all.max(1) as f64;
        if at_end > MAX_AT_END {
            notes.push(format!(
                "{} of the values are at the end of the scale: the photographs are overexposed there, and brighter light is cut off",
                percent(at_end)
            ));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniform_photographs_and_the_end_of_the_scale_are_noted() {
        let of = |images: &[[f32; 4]]| {
            let mut exposures = Exposures::default();
            for (light, values) in images.iter().enumerate() {
                exposures.add([0, light], values.iter().map(|value| [*value; 3]));
            }
            exposures
        };
        assert!(of(&[[0.0, 0.5, 0.9, 0.2], [0.1, 0.0, 0.0, 0.0]]).notes().is_empty());
        let black = of(&[[0.0; 4], [0.1, 0.2, 0.3, 0.4]]);
        assert_eq!(black.uniform(), [("black", vec![[0, 0]]), ("white", vec![])]);
        assert_eq!(black.notes(), ["1 of 2 photographs: black everywhere"]);
        // Values above 1, as of floats, are not cut off.
        let bright = of(&[[1.0, 0.5, 0.1, 0.1], [7.0, 2.0, 0.1, 0.1]]).notes();
        assert!(
            bright.len() == 1 && bright[0].starts_with("12.500 % of the values are at the end of the scale"),
            "{bright:?}"
        );
    }
}
