//! Ideal diffuse reflection.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, over_lambert};
use brdfc_formats::direction::DirectionPair;

/// `f_r = kd / π` (Lambert 1760, "Photometria").
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lambert {
    /// Diffuse albedo, linear RGB, 0 to 1.
    pub kd: [f64; 3],
}

pub(super) const INFO: ModelInfo = ModelInfo {
    name: "lambert",
    meaning: "ideal diffuse",
    parameters: &[Parameter::colour("kd", 0.5, DIFFUSE)],
    shorthands: &[],
    build: |v| Box::new(Lambert { kd: v[0] }),
};

impl Analytic for Lambert {
    fn info(&self) -> &'static ModelInfo {
        &INFO
    }

    fn values(&self) -> Vec<[f64; 3]> {
        vec![self.kd]
    }

    fn above_horizon(&self, _: DirectionPair) -> [f64; 3] {
        over_lambert(self.kd, [0.0; 3], 0.0)
    }
}
