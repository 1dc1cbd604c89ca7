//! Reciprocal, energy-conserving Phong lobe.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, over_lambert};
use brdfc_formats::direction::DirectionPair;
use std::f64::consts::TAU;

/// `f_r = kd / π + ks (n + 2) / 2π max(cos α, 0)^n`, α the angle between the outgoing direction and the mirror direction
/// of the incoming one (Lewis 1993, "Making shaders more physically plausible"). Energy is conserved where
/// `kd + ks <= 1`; that is not enforced.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lewis {
    /// Diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
    /// Specular albedo at normal incidence, linear RGB, 0 to 1.
    pub ks: [f64; 3],
    /// Exponent `n` of the lobe, 0 to 10000.
    pub exponent: f64,
}

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "lewis",
    meaning: "diffuse and a reciprocal Phong lobe",
    parameters: &[
        Parameter::colour("kd", 0.6, DIFFUSE),
        Parameter::colour("ks", 0.3, "specular albedo at normal incidence"),
        Parameter::number("n", [0.0, 10_000.0], 20.0, "exponent of the lobe"),
    ],
    shorthands: &[],
    build: |v| Box::new(Lewis { kd: v[0], ks: v[1], exponent: v[2][0] }),
};

impl Analytic for Lewis {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd, self.ks, [self.exponent; 3]]
    }

    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3] {
        let (i, o) = (pair.incoming, pair.outgoing);
        let cos_alpha = i[2] * o[2] - i[0] * o[0] - i[1] * o[1];
        let lobe = if cos_alpha > 0.0 { cos_alpha.powf(self.exponent) } else { 0.0 };
        over_lambert(self.kd, self.ks, (self.exponent + 2.0) / TAU * lobe)
    }
}
