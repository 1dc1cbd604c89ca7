//! Ideal diffuse reflection.

use super::model::{Analytic, DIFFUSE, ModelInfo, Parameter, is_equal_in_all_channels, over_lambert};
use crate::{Source, Symmetry, Tally};
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
}

impl Source for Lambert {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        if pair.is_above_horizon() { over_lambert(self.kd, [0.0; 3], 0.0) } else { [0.0; 3] }
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::FULL
    }

    fn is_grey(&self) -> bool {
        is_equal_in_all_channels(self.kd)
    }
}
