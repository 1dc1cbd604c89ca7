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
