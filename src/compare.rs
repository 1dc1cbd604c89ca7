//! Error of one input compared with another: `brdfc compare`.
//!
//! [`reflectances`] compares materials and packs, [`photographs`] measures packs against photographs, [`btf`] packs of several views
//! against a BTF, [`flat_btfs`] compares flat BTFs; the [kind](Kind::of) of the reference selects one of them.

pub use brdfc_flat_btf::probes::ColourErrors;
pub use brdfc_formats::crop::DirectionRange;
pub use brdfc_jobs::pwt::{
    BtfComparison, PhotographComparison, PhotographErrors, ViewErrors, compare_btf as btf,
    compare_photographs as photographs,
};
pub use brdfc_metrics::compare::Comparison;
pub use brdfc_pwt::measure::StackErrors;

use crate::{DirectionPair, Error, Input, Material};
use brdfc_jobs::flatten::compare_flat;
use brdfc_jobs::pwt::open_flat_material;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_source::Kind;

const SEED: u64 = 2007;

/// Direction pairs of a comparison.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Pairs {
    /// The 65536 pairs of three kinds at which packs are measured.
    #[default]
    OfEncoder,
    /// A number of random pairs, uniform over both hemispheres, with a fixed seed.
    Random(usize),
    /// These pairs, at least one.
    Given(Vec<DirectionPair>),
}

/// Result of a comparison.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Number of direction pairs that were compared.
    pub pairs: usize,
    /// Compared directions: those that both materials contain, or all if pairs are given.
    pub directions: DirectionRange,
    /// Errors of `b` compared with `a`, at these pairs.
    pub comparison: Comparison,
}

/// Compares `b` with `a`, at directions that both contain.
///
/// # Errors
/// Returns an error if packs have no direction in common or there are no pairs.
pub fn reflectances(a: &Material, b: &Material, pairs: Pairs) -> Result<Compared, Error> {
    let [of_a, of_b] = [a, b].map(|material| material.facts().directions());
    let both = of_a
        .common(of_b)
        .ok_or_else(|| Error::check(format!("no directions in common: A covers {of_a}, B covers {of_b}")))?;
    let set = match pairs {
        Pairs::OfEncoder => PairSet::within(both),
        Pairs::Random(count) => PairSet::new(random_pairs(count, SEED)),
        Pairs::Given(pairs) => PairSet::new(pairs),
    };
    if set.pairs.is_empty() {
        return Err(Error::check("no direction pairs: expected at least one"));
    }
    let (comparison, _) = brdfc_metrics::compare::compare(a.source(), b.source(), &set);
    Ok(Compared { pairs: set.pairs.len(), directions: set.directions, comparison })
}

/// Compares two flat BTFs of the same surface at random positions, by ΔE (CIE76).
///
/// # Errors
/// Returns an error if a file cannot be read, is damaged or is not a flat BTF.
pub fn flat_btfs(a: &Input, b: &Input) -> Result<ColourErrors, Error> {
    let open = |input: &Input, allowed: &str| match Kind::of(input)? {
        kind if kind.is_flat_btf() => open_flat_material(input),
        kind => Err(kind.refused(input, allowed)),
    };
    Ok(compare_flat(&open(a, "a flat BTF")?, &open(b, "a flat BTF, because A is one")?))
}
