//! Ward's anisotropic Gaussian lobe.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, over_lambert};
use brdfc_formats::direction::{DirectionPair, half_vector};
use std::f64::consts::PI;

/// `f_r = kd / π + ks exp(-((hx / ax)² + (hy / ay)²) / hz²) / (4π ax ay sqrt(cos θi cos θo))`, `h` the half vector (Ward
/// 1992, "Measuring and modeling anisotropic reflection", eq. 5a with the half vector in place of its angles).
///
/// Unbounded as either direction approaches the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ward {
    /// Diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
    /// Specular albedo, approximate at normal incidence for small slopes, linear RGB, 0 to 1.
    pub ks: [f64; 3],
    /// Standard deviation of the surface slope along the tangent, `ax`, 0.001 to 10.
    pub slope_x: f64,
    /// Standard deviation of the surface slope along the bitangent, `ay`, 0.001 to 10.
    pub slope_y: f64,
}

const SLOPES: [f64; 2] = [0.001, 10.0];

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "ward",
    meaning: "diffuse and an anisotropic Gaussian lobe",
    parameters: &[
        Parameter::colour("kd", 0.2, DIFFUSE),
        Parameter::colour("ks", 0.1, "specular albedo"),
        Parameter::number("ax", SLOPES, 0.15, "slope along the tangent"),
        Parameter::number("ay", SLOPES, 0.5, "slope along the bitangent"),
    ],
    shorthands: &[],
    build: |v| Box::new(Ward { kd: v[0], ks: v[1], slope_x: v[2][0], slope_y: v[3][0] }),
};

impl Analytic for Ward {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd, self.ks, [self.slope_x; 3], [self.slope_y; 3]]
    }

    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3] {
        let h = half_vector(pair);
        let (x, y) = (h[0] / self.slope_x, h[1] / self.slope_y);
        let gaussian = (-(x * x + y * y) / (h[2] * h[2])).exp();
        // Two roots, because their product does not underflow where the product of the cosines does.
        let root = pair.incoming[2].sqrt() * pair.outgoing[2].sqrt();
        over_lambert(self.kd, self.ks, gaussian / (4.0 * PI * self.slope_x * self.slope_y * root))
    }

    fn is_isotropic(&self) -> bool {
        self.slope_x == self.slope_y
    }
}
