//! Descriptions of models, and weighted sums that several of them use.

use crate::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use std::f64::consts::FRAC_1_PI;

/// A model with named parameters, mirror symmetric and reciprocal.
pub trait Analytic: Source {
    /// Name, parameters and ranges of the model.
    fn info(&self) -> &'static ModelInfo;

    /// The values of `info().parameters`, in that order; a number fills all three channels.
    fn values(&self) -> Vec<[f64; 3]>;

    /// `f_r` where both directions are above the horizon.
    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3];

    /// Returns true if values do not change when a pair is rotated about the normal.
    fn is_isotropic(&self) -> bool {
        true
    }
}

impl<A: Analytic> Source for A {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if pair.is_above_horizon() { self.above_horizon(pair) } else { [0.0; 3] }
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry { isotropic: self.is_isotropic(), ..Symmetry::FULL }
    }

    fn is_grey(&self) -> bool {
        self.values().iter().all(|[r, g, b]| r == g && g == b)
    }
}

/// Type of a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ParameterKind {
    /// One finite number from the parameter's minimum to its maximum.
    Number,
    /// One whole number from the parameter's minimum to its maximum.
    Integer,
    /// Linear RGB (Rec. 709 primaries): one number for all channels, or three.
    Colour,
}

/// A parameter of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// The name in addresses.
    pub name: &'static str,
    /// Type of the value: a number, a whole number or a colour.
    pub kind: ParameterKind,
    /// Lowest valid value, inclusive.
    pub minimum: f64,
    /// Highest valid value, inclusive.
    pub maximum: f64,
    /// Default value of all channels.
    pub default: f64,
    /// Meaning of the parameter, with its unit, in a few words for help texts.
    pub meaning: &'static str,
}

impl Parameter {
    /// A number in a range.
    pub const fn number(name: &'static str, [minimum, maximum]: [f64; 2], default: f64, meaning: &'static str) -> Self {
        Self { name, kind: ParameterKind::Number, minimum, maximum, default, meaning }
    }

    /// A whole number in a range.
    pub const fn integer(
        name: &'static str,
        [minimum, maximum]: [f64; 2],
        default: f64,
        meaning: &'static str,
    ) -> Self {
        Self { name, kind: ParameterKind::Integer, minimum, maximum, default, meaning }
    }

    /// A colour in `[0, 1]` per channel.
    pub const fn colour(name: &'static str, default: f64, meaning: &'static str) -> Self {
        Self { name, kind: ParameterKind::Colour, minimum: 0.0, maximum: 1.0, default, meaning }
    }
}

/// One name in addresses that sets several parameters to the same value.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shorthand {
    /// The name in addresses.
    pub name: &'static str,
    /// The parameters that it sets.
    pub stands_for: &'static [&'static str],
}

/// A model: its name, parameters, and how to build it.
#[derive(Debug, Clone, Copy)]
pub struct ModelInfo {
    /// The name in addresses.
    pub name: &'static str,
    /// Description of the model in a few words, for help texts.
    pub meaning: &'static str,
    /// Its parameters, in the order of the canonical form.
    pub parameters: &'static [Parameter],
    /// Names that set several of its parameters at once; empty if it has none.
    pub shorthands: &'static [Shorthand],
    /// Builds it from one value per parameter, in order, unchecked; a number is taken from the first channel.
    pub build: fn(&[[f64; 3]]) -> Box<dyn Analytic>,
}

/// Description of every `kd`.
pub(super) const DIFFUSE: &str = "diffuse albedo";

/// `kd diffuse + ks specular`, per channel.
pub(super) fn weighted_sum(kd: [f64; 3], diffuse: f64, ks: [f64; 3], specular: f64) -> [f64; 3] {
    std::array::from_fn(|c| kd[c] * diffuse + ks[c] * specular)
}

/// `kd / π + ks specular`, per channel.
pub(super) fn over_lambert(kd: [f64; 3], ks: [f64; 3], specular: f64) -> [f64; 3] {
    weighted_sum(kd, FRAC_1_PI, ks, specular)
}
