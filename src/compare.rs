//! The error of one input against another: `brdfc compare`.

pub use brdfc_flat_btf::probes::ColourErrors;
pub use brdfc_formats::crop::DirectionRange;
pub use brdfc_jobs::flatten::FlatComparison;
pub use brdfc_jobs::pwt::{PhotographComparison, PhotographErrors, compare_photographs as photographs};
pub use brdfc_metrics::compare::Comparison;
pub use brdfc_pwt::measure::StackErrors;

use crate::{DirectionPair, Error, Input, Material};
use brdfc_jobs::flatten::compare_flat;
use brdfc_jobs::pwt::open_flat_material;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_source::flat_btf::flat_btf_file;
use brdfc_source::rti_capture::is_rti_capture;

const SEED: u64 = 2007;

/// What an input is compared as.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// By [`photographs`].
    RtiCapture,
    /// By [`flat_btfs`].
    FlatBtf,
    /// By [`reflectances`].
    Reflectance,
}

impl Kind {
    /// What the reference is compared as.
    ///
    /// # Errors
    /// A folder that cannot be read, or holds several flat BTFs.
    pub fn of(reference: &Input) -> Result<Self, Error> {
        Ok(match reference.path() {
            Some(path) if is_rti_capture(path) => Self::RtiCapture,
            Some(path) if flat_btf_file(path)?.is_some() => Self::FlatBtf,
            _ => Self::Reflectance,
        })
    }
}

/// Where reflectances are compared.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Pairs {
    /// At the pairs at which packs are measured, 65536 of three kinds.
    #[default]
    OfEncoder,
    /// At so many random pairs, uniform over both hemispheres, with a fixed seed.
    Random(usize),
    /// At these pairs.
    Given(Vec<DirectionPair>),
}

/// How far one material is from another.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Direction pairs.
    pub pairs: usize,
    /// Directions that are compared: those that both materials hold, or all where pairs are given.
    pub directions: DirectionRange,
    /// What was measured.
    pub comparison: Comparison,
}

/// Measures `b` against `a`. Directions that only one of two packs holds are left out.
///
/// # Errors
/// Packs without a direction in common; no pairs.
pub fn reflectances(a: &Material, b: &Material, pairs: Pairs) -> Result<Compared, Error> {
    let [of_a, of_b] = [a, b].map(|material| material.facts().directions());
    let both = of_a.common(of_b).ok_or_else(|| {
        let allowed = "packs that have some in common";
        Error::check(format!("directions: found a pack for {of_a}, and one for {of_b}, expected {allowed}"))
    })?;
    let set = match pairs {
        Pairs::OfEncoder => PairSet::within(both),
        Pairs::Random(count) => PairSet::new(random_pairs(count, SEED)),
        Pairs::Given(pairs) => PairSet::new(pairs),
    };
    if set.pairs.is_empty() {
        return Err(Error::check("pairs: found none, expected one or more"));
    }
    let (comparison, _) = brdfc_metrics::compare::compare(a.source(), b.source(), &set);
    Ok(Compared { pairs: set.pairs.len(), directions: set.directions, comparison })
}

/// Measures a flat BTF against another of the same surface, at random places, by ΔE (CIE76).
///
/// # Errors
/// Files that cannot be read, are broken or are no flat BTF; one without values for views.
pub fn flat_btfs(a: &Input, b: &Input) -> Result<FlatComparison, Error> {
    let open = |name: &str, input: &Input| {
        let no_flat_btf = || Error::wrong_usage(name, input, "a flat BTF, as A is one");
        open_flat_material(input)?.ok_or_else(no_flat_btf)
    };
    compare_flat(&open("A", a)?, &open("B", b)?).ok_or_else(|| Error::wrong_input(a, "the light form", "the full form"))
}
