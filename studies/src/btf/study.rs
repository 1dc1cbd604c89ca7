//! All methods for one structure.

use super::assets::{Asset, Surface};
use super::factored::factored;
use super::joint::Joint;
use super::lights::Lights;
use super::per_view::{FIRST, View};
use super::rows::{BtfAsset, BtfClaims, BtfModel, BtfRow, BtfSettings, Tally};
use super::whole::Whole;
use brdfc_core::address::AddressError;
use brdfc_flat_btf::factored::{FactoredTarget, max_cells};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::parameterise::ParameteriseError;
use brdfc_flat_btf::structures::Structure;
use brdfc_formats::FormatError;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_jobs::pwt::permutation;
use brdfc_pwt::candidates::Candidate;

/// Number of held-out lights of sets that have enough of them, and the seed of the permutation that selects them.
const HELD_OUT: usize = 8;
const SEED: u64 = 0;
/// Orders of the harmonics of light and view.
const JOINT_DEGREES: [u32; 2] = [3, 5];
/// Components of a factored BTF of good quality, and cells of its residual of shadows.
const COMPONENTS: u32 = 32;
const CELLS: u32 = 4;
/// Maximum share of the compared bytes that polynomial wavelet trees should take.
const MAX_SHARE: f64 = 0.5;
/// Mean ΔE at which the methods are compared: about the default of `brdfc flatten`.
const GOOD: f64 = 1.0;

/// Units of progress per view of one structure, about proportional to seconds.
pub const PARTS: usize = WHOLE + 2 * (MAKE + FIRST_PASS + AT_ERROR + 2 * JOINT_DEGREES.len() * JOINT + 3 * FACTORED);
const WHOLE: usize = 12;
const MAKE: usize = 1;
const FIRST_PASS: usize = 12;
const AT_ERROR: usize = 10;
const JOINT: usize = 1;
const FACTORED: usize = 3;

/// Errors of studying a structure.
#[derive(Debug, thiserror::Error)]
pub enum BtfStudyError {
    /// The address is wrong.
    #[error(transparent)]
    Address(#[from] AddressError),
    /// The surface cannot be parameterised.
    #[error(transparent)]
    Parameterise(#[from] ParameteriseError),
    /// A size or the directions are out of range.
    #[error(transparent)]
    Format(#[from] FormatError),
}

/// Indices of the held-out lights of a set of `count`, ascending: 8, or a fifth if that is fewer.
///
/// # Errors
/// Returns an error for fewer than five.
pub fn held_out(count: usize) -> Result<Vec<usize>, FormatError> {
    held_out_by(count, SEED)
}

/// Indices of the held-out views, likewise.
///
/// # Errors
/// Returns an error for fewer than five.
pub fn held_out_views(count: usize) -> Result<Vec<usize>, FormatError> {
    held_out_by(count, SEED + 1)
}

fn held_out_by(count: usize, seed: u64) -> Result<Vec<usize>, FormatError> {
    if count < 5 {
        return Err(FormatError::whole("directions", count.to_string(), "5 or more"));
    }
    let mut lights = permutation(count, seed);
    lights.truncate(HELD_OUT.min(count / 5));
    lights.sort_unstable();
    Ok(lights)
}

/// Studies one structure. Calls `done` with the number of finished units of progress, [`PARTS`] for each direction in
/// total.
///
/// # Errors
/// Returns an error for a wrong address, a surface that cannot be parameterised, or sizes or directions that a method
/// does not support.
pub fn study_structure(
    address: &str,
    settings: &BtfSettings,
    set: &DirectionSet,
    done: &dyn Fn(usize),
) -> Result<BtfModel, BtfStudyError> {
    let structure = Structure::parse(address)?;
    let appearance = structure.appearance();
    let model = MesoModel::new(structure.mesh(), 0, &())?;
    let directions = set.directions();
    let lights = Lights::new(set, &settings.held_out)?;
    let surface = Surface { model: &model, appearance: &appearance, directions: &directions, size: settings.texels };
    let ordinary = surface.classic(&|| done(MAKE));
    let views = Lights::new(set, &settings.held_out_views)?;
    let whole = Whole { asset: &ordinary, set, views, lights: &lights }.study()?;
    done(WHOLE * set.len());
    let classic = ways(&ordinary, (set, &lights), None, done)?;
    let maps = classic.row(FIRST[MAP]).map(|row| row.delta_e);
    let flat = ways(&surface.flat(&|| done(MAKE)), (set, &lights), maps, done)?;
    let claims = BtfClaims::of(&classic, &flat);
    Ok(BtfModel { model: structure.canonical(), classic, flat, whole, claims })
}

/// Index in the first pass of the method that others are compared with.
const MAP: usize = 1;
const AT_MAP_ERROR: &str = "PWT at PTM's ΔE";

/// Results of every method to store a BTF. For a flat BTF, `ordinary` is the mean ΔE of the maps of the ordinary one.
fn ways(
    asset: &Asset,
    (set, lights): (&DirectionSet, &Lights),
    ordinary: Option<f64>,
    done: &dyn Fn(usize),
) -> Result<BtfAsset, FormatError> {
    let mut tallies = [Tally::default(); FIRST.len()];
    let mut chosen: Vec<Candidate> = Vec::new();
    for view in 0..asset.views() {
        let found = View::new(asset, view, lights).first()?;
        tallies.iter_mut().zip(found.tallies).for_each(|(sum, view)| sum.add(view));
        chosen.push(found.chosen);
        done(FIRST_PASS);
    }
    let mut rows: Vec<BtfRow> =
        FIRST.iter().zip(tallies).map(|(name, tally)| tally.of_views(asset.views()).row(name)).collect();
    let tree = rows.pop();
    let map_error = rows[MAP].delta_e;
    let within = |row: BtfRow, error: f64| BtfRow { met: Some(row.delta_e <= error), ..row };

    let mut at_error = [Tally::default(); 3];
    for (view, chosen) in chosen.iter().enumerate() {
        let ready = View::new(asset, view, lights);
        for (sum, target) in at_error.iter_mut().zip([Some(map_error), Some(GOOD), ordinary]) {
            if let Some(target) = target {
                sum.add(ready.at_error(*chosen, target)?);
            }
        }
        done(AT_ERROR);
    }
    let mut joint_rows = Vec::new();
    let targets = [("PWT of light and view at PTM's ΔE", map_error), ("PWT of light and view at ΔE 1", GOOD)];
    let mut joint_at_error: [Option<BtfRow>; 2] = [None, None];
    for degree in JOINT_DEGREES {
        let joint = Joint::fit(asset, lights, (&chosen, degree), &|| done(JOINT));
        joint_rows.push(joint.all(&|| done(JOINT)).row(&format!("PWT of light and view, order {degree}")));
        // Use the lower order if it is sufficient.
        for (found, (name, error)) in joint_at_error.iter_mut().zip(targets) {
            if found.as_ref().is_none_or(|row| row.met == Some(false)) {
                *found = Some(within(joint.at_error(error, &|| ()).row(name), error));
            }
        }
    }
    let factor = |name: &str, target| factored(name, target, asset, (set, lights), &|| done(FACTORED));
    let residual = CELLS.min(max_cells(asset.size as u32));
    let components = FactoredTarget::Components { components: COMPONENTS, residual };
    let [at_error, at_good, at_ordinary] = at_error.map(|sum| sum.of_views(asset.views()));
    rows.push(within(at_error.row(AT_MAP_ERROR), map_error));
    if let Some(error) = ordinary {
        rows.push(within(at_ordinary.row("PWT at the ordinary BTF's PTM ΔE"), error));
    }
    rows.push(within(at_good.row("PWT at ΔE 1"), GOOD));
    rows.extend(tree);
    rows.extend(joint_at_error.into_iter().flatten());
    rows.extend(joint_rows);
    rows.push(within(factor("factored at PTM's ΔE", FactoredTarget::Error(map_error))?, map_error));
    rows.push(within(factor("factored at ΔE 1", FactoredTarget::Error(GOOD))?, GOOD));
    rows.push(factor(&format!("factored, {COMPONENTS} components"), components)?);
    let of = rows[MAP].bytes as f64;
    rows.iter_mut().for_each(|row| row.share = row.bytes as f64 / of);
    Ok(BtfAsset { seen: asset.seen(), rows })
}

impl BtfAsset {
    /// The row of a method.
    fn row(&self, method: &str) -> Option<&BtfRow> {
        self.rows.iter().find(|row| row.method == method)
    }
}

impl BtfClaims {
    fn of(classic: &BtfAsset, flat: &BtfAsset) -> Self {
        // Share of the maps, bytes, whether the error is met.
        let found = |asset: &BtfAsset| {
            let row = asset.row(AT_MAP_ERROR);
            row.map_or((f64::NAN, f64::NAN, false), |row| (row.share, row.bytes as f64, row.met == Some(true)))
        };
        let ((maps, of_classic, classic_met), (_, of_flat, flat_met)) = (found(classic), found(flat));
        let flat_share = of_flat / of_classic;
        Self {
            classic_share: maps,
            classic_met: classic_met && maps <= MAX_SHARE,
            flat_share,
            flat_met: flat_met && flat_share <= MAX_SHARE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_held_out_of_sets_that_have_enough() {
        let of = |count| held_out(count).unwrap();
        assert_eq!((of(81).len(), of(151).len(), of(13).len(), of(5).len()), (8, 8, 2, 1));
        assert!(of(81).is_sorted() && of(81)[7] < 81);
        assert!(held_out(4).unwrap_err().to_string().contains("5 or more"));
    }
}
