//! Error of one input compared with another: `brdfc compare`.
//!
//! [`reflectances`] compares materials and packs, [`photographs`] measures packs against photographs, [`btf`] packs of several views against a BTF, [`flat_btfs`]
//! compares flat BTFs; [`Kind::of`] selects one of them by the reference.

pub use brdfc_flat_btf::probes::ColourErrors;
pub use brdfc_formats::crop::DirectionRange;
pub use brdfc_jobs::pwt::{
    BtfComparison, PhotographComparison, PhotographErrors, ViewErrors, compare_btf as btf,
    compare_photographs as photographs,
};
pub use brdfc_metrics::compare::Comparison;
pub use brdfc_pwt::measure::StackErrors;

use crate::{DirectionPair, Error, Input, InputError, Material};
use brdfc_jobs::flatten::compare_flat;
use brdfc_jobs::pwt::open_flat_material;
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_source::btf_stack::has_images;
use brdfc_source::flat_btf::flat_btf_file;
use brdfc_source::ordinary_btf::OrdinaryBtf;
use brdfc_source::pack::open_pack;
use brdfc_source::rti_capture::is_rti_capture;
use std::fs::File;

const SEED: u64 = 2007;

/// Kind of comparison, which selects the function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Photographs of an RTI capture, compared by [`photographs`].
    RtiCapture,
    /// A flat BTF, compared by [`flat_btfs`].
    FlatBtf,
    /// An ordinary BTF, compared by [`btf`].
    Btf,
    /// A material or a pack, compared by [`reflectances`].
    Reflectance,
}

impl Kind {
    /// Selects the comparison by the kind of the reference.
    ///
    /// # Errors
    /// Returns an error if a folder cannot be read or contains several flat BTFs.
    pub fn of(reference: &Input) -> Result<Self, Error> {
        Ok(match reference.path() {
            Some(path) if is_rti_capture(path) => Self::RtiCapture,
            Some(path) if flat_btf_file(path)?.is_some() => Self::FlatBtf,
            Some(path) if OrdinaryBtf::is_one(path) && (path.is_file() || has_images(path)) => Self::Btf,
            _ => Self::Reflectance,
        })
    }
}

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
    let open = |name: &str, input: &Input| {
        if let Some(material) = open_flat_material(input)? {
            return Ok(material);
        }
        // A file that is missing or damaged, first.
        if let Some(file) = input.path().filter(|path| !path.is_dir()) {
            let opened = file.metadata().and_then(|metadata| match metadata.is_file() {
                true => File::open(file).map(drop),
                false => Ok(()),
            });
            opened.map_err(|error| InputError::Io { name: input.to_string(), error })?;
            if input.extension()? == "ktx2" {
                open_pack(input)?;
            }
        }
        Err(Error::wrong_usage(name, input, "a flat BTF, because A is one"))
    };
    Ok(compare_flat(&open("A", a)?, &open("B", b)?))
}
