//! Velvet: upright fibres with shiny sides.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, over_lambert};
use brdfc_formats::direction::{DirectionPair, half_vector};
use std::f64::consts::PI;

/// `f_r = kd / π + ks D(h) / (4 (cos θi + cos θo - cos θi cos θo))` with the inverted Gaussian
/// `D = (1 + 4 exp(-cot² θh (cos² φh / sx² + sin² φh / sy²))) / (π (1 + 4 sx sy))`, `h` the half vector.
///
/// The distribution follows the velvet of Ashikhmin, Premože and Shirley 2000, "A microfacet-based BRDF generator",
/// with a width for each axis. The denominator follows Neubelt and Pettineo 2013, "Crafting a next-gen material
/// pipeline for The Order: 1886", which stays finite at the horizon.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velvet {
    /// Diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
    /// Sheen, linear RGB, 0 to 1.
    pub ks: [f64; 3],
    /// Spread of the fibres along the tangent, `sx`, 0.01 to 2.
    pub spread_x: f64,
    /// Spread of the fibres along the bitangent, `sy`, 0.01 to 2.
    pub spread_y: f64,
}

const SPREADS: [f64; 2] = [0.01, 2.0];
/// Height of the inverted lobe above the floor of the distribution.
const HEIGHT: f64 = 4.0;

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "velvet",
    meaning: "diffuse and the sheen of upright fibres, anisotropic",
    parameters: &[
        Parameter::colour("kd", 0.05, DIFFUSE),
        Parameter::colour("ks", 0.4, "sheen"),
        Parameter::number("sx", SPREADS, 0.7, "spread of fibres along the tangent"),
        Parameter::number("sy", SPREADS, 0.3, "spread of fibres along the bitangent"),
    ],
    shorthands: &[],
    build: |v| Box::new(Velvet { kd: v[0], ks: v[1], spread_x: v[2][0], spread_y: v[3][0] }),
};

impl Analytic for Velvet {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd, self.ks, [self.spread_x; 3], [self.spread_y; 3]]
    }

    fn above_horizon(&self, pair: DirectionPair) -> [f64; 3] {
        let [x, y, z] = half_vector(pair);
        let (i, o) = (pair.incoming[2], pair.outgoing[2]);
        // cot² θh cos² φh = (z x / (x² + y²))²; infinite at the normal, where the lobe has its hole.
        let across = x * x + y * y;
        let lobe = if across > 0.0 {
            let (a, b) = (z * x / across / self.spread_x, z * y / across / self.spread_y);
            (-(a * a + b * b)).exp()
        } else {
            0.0
        };
        let distribution = (1.0 + HEIGHT * lobe) / (PI * (1.0 + HEIGHT * self.spread_x * self.spread_y));
        over_lambert(self.kd, self.ks, distribution / (4.0 * (i + o - i * o)))
    }

    fn is_isotropic(&self) -> bool {
        self.spread_x == self.spread_y
    }
}
