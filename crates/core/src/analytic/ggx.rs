//! Microfacets with the Trowbridge-Reitz distribution.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, Shorthand, weighted_sum};
use brdfc_formats::direction::{DirectionPair, Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

/// `f_r = kd / π + D G F / (4 cos θi cos θo)`, with `h` the half vector and
///
/// - `D = 1 / (π ax ay ((hx / ax)² + (hy / ay)² + hz²)²)` (Trowbridge and Reitz 1975; anisotropic: Burley 2012),
/// - `G = 1 / (1 + Λ(wi) + Λ(wo))`, `Λ(w) = (sqrt(1 + (ax² wx² + ay² wy²) / wz²) - 1) / 2` (Smith, height-correlated:
///   Heitz 2014),
/// - `F = f0 + (1 - f0) (1 - h·wi)⁵` (Schlick 1994).
///
/// The diffuse part is not reduced by the specular one: energy may exceed 1 for large `kd`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ggx {
    /// Diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
    /// Reflectance of a facet at normal incidence, linear RGB, 0 to 1.
    pub f0: [f64; 3],
    /// Roughness along the tangent, 0.001 to 1.
    pub alpha_x: f64,
    /// Roughness along the bitangent, 0.001 to 1.
    pub alpha_y: f64,
}

const ROUGHNESS: [f64; 2] = [0.001, 1.0];

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "ggx",
    meaning: "diffuse and Trowbridge-Reitz microfacets",
    parameters: &[
        Parameter::colour("kd", 0.2, DIFFUSE),
        Parameter::colour("f0", 0.04, "facet reflectance at normal incidence"),
        Parameter::number("alpha_x", ROUGHNESS, 0.3, "roughness along the tangent"),
        Parameter::number("alpha_y", ROUGHNESS, 0.3, "roughness along the bitangent"),
    ],
    shorthands: &[Shorthand { name: "alpha", stands_for: &["alpha_x", "alpha_y"] }],
    build: |v| Box::new(Ggx { kd: v[0], f0: v[1], alpha_x: v[2][0], alpha_y: v[3][0] }),
};

impl Ggx {
    /// `wz sqrt(1 + (ax² wx² + ay² wy²) / wz²)`.
    fn stretched_length(&self, w: Vector) -> f64 {
        let (x, y) = (self.alpha_x * w[0], self.alpha_y * w[1]);
        (x * x + y * y + w[2] * w[2]).sqrt()
    }
}

impl Analytic for Ggx {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd, self.f0, [self.alpha_x; 3], [self.alpha_y; 3]]
    }

    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3] {
        let (i, o) = (pair.incoming, pair.outgoing);
        let h = half_vector(pair);
        let (x, y) = (h[0] / self.alpha_x, h[1] / self.alpha_y);
        let slope = x * x + y * y + h[2] * h[2];
        let distribution = 1.0 / (PI * self.alpha_x * self.alpha_y * slope * slope);
        // 1 + Λ(wi) + Λ(wo) is half the sum of the two square roots.
        let masked = distribution / (2.0 * (o[2] * self.stretched_length(i) + i[2] * self.stretched_length(o)));
        // h·wi from the length of wi + wo, which is symmetric in the two.
        let sum = [i[0] + o[0], i[1] + o[1], i[2] + o[2]];
        let cosine = (0.5 * (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]).sqrt()).min(1.0);
        let schlick = (1.0 - cosine).powi(5);
        let fresnel = self.f0.map(|f0| f0 + (1.0 - f0) * schlick);
        weighted_sum(self.kd, FRAC_1_PI, fresnel, masked)
    }

    fn is_isotropic(&self) -> bool {
        self.alpha_x == self.alpha_y
    }
}
