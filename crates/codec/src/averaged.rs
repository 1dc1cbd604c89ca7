//! Error that symmetrising a material adds.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::DirectionPair;
use brdfc_metrics::compare::Reference;
use serde::{Deserialize, Serialize};

/// Distance of a symmetrised source from the source itself, before anything is packed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct AveragingCost {
    /// Mean ΔE (CIE76) of renderings.
    pub delta_e: f64,
    /// Mean relative error `ε_r`, a fraction.
    pub relative_error: f64,
}

impl AveragingCost {
    /// Measures the error that symmetrising adds to a source. `reference` holds the values of the source.
    pub fn of(source: &dyn Source, reference: &Reference) -> Self {
        let found = reference.compare(&Averaged(source));
        Self { delta_e: found.rendering.delta_e.mean, relative_error: found.norms.relative_mean }
    }
}

/// A symmetrised source: the mean over both orders of the two directions.
struct Averaged<'a>(&'a dyn Source);

impl Source for Averaged<'_> {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        let (there, back) = (self.0.eval(pair, tally), self.0.eval(pair.exchanged(), tally));
        std::array::from_fn(|k| 0.5 * (there[k].max(0.0) + back[k].max(0.0)))
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry { reciprocal: true, ..self.0.symmetry() }
    }

    fn is_grey(&self) -> bool {
        self.0.is_grey()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;
    use brdfc_metrics::sampling::PairSet;

    fn cost(source: &dyn Source) -> AveragingCost {
        AveragingCost::of(source, &Reference::new(source, PairSet::comparison()))
    }

    /// A material whose value is the cosine to the light: symmetrising is off by half the difference of cosines.
    struct OneWay;

    impl Source for OneWay {
        fn eval(&self, pair: DirectionPair, _: &mut Tally) -> [f64; 3] {
            [pair.incoming[2]; 3]
        }

        fn symmetry(&self) -> Symmetry {
            Symmetry::NONE
        }
    }

    #[test]
    fn reciprocal_materials_cost_nothing() {
        let ggx = parse_synth("synth:ggx?alpha=0.3").expect("an address");
        let none = cost(ggx.as_ref());
        assert!(none.delta_e < 1e-6 && none.relative_error < 1e-9, "{none:?}");
        let some = cost(&OneWay);
        assert!(some.delta_e > 1.0 && some.relative_error > 0.1, "{some:?}");
    }
}
