//! Encoding of one source by a recipe.

use super::{EncodedPack, PackRecipe};
use brdfc_codec::{EncodeError, GridCache};
use brdfc_core::Source;
use brdfc_core::progress::Progress;

/// Encodes a source.
///
/// # Errors
/// Returns an error for recipes that cannot be followed and for cancellation. A missed budget is no error: see
/// [`EncodedPack`]'s `missed`.
pub fn encode(source: &dyn Source, recipe: &PackRecipe, progress: &dyn Progress) -> Result<EncodedPack, EncodeError> {
    encode_cached(source, recipe, &(), progress)
}

/// Encodes a source with cached samples.
pub fn encode_cached(
    source: &dyn Source,
    recipe: &PackRecipe,
    cache: &dyn GridCache,
    progress: &dyn Progress,
) -> Result<EncodedPack, EncodeError> {
    // A source pack for a range of directions says nothing about others.
    let (has, needed) = (source.directions(), recipe.directions());
    let common = has.common(needed).ok_or(EncodeError::OtherDirections { has, needed })?;
    let mut recipe = recipe.clone();
    recipe.limit_directions(common);
    recipe.encode(source, cache, progress)
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;
    use brdfc_core::{Symmetry, Tally};
    use brdfc_formats::direction::DirectionPair;
    use brdfc_wavelet::recipe::{Recipe, Target};
    use std::cell::RefCell;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Source that counts its evaluations.
    struct Counted(Box<dyn Source>, AtomicUsize);

    impl Source for Counted {
        fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
            self.1.fetch_add(1, Ordering::Relaxed);
            self.0.eval(pair, tally)
        }

        fn symmetry(&self) -> Symmetry {
            self.0.symmetry()
        }

        fn is_grey(&self) -> bool {
            self.0.is_grey()
        }
    }

    #[derive(Default)]
    struct Memory(RefCell<Vec<(String, Vec<u8>, Tally)>>);

    impl GridCache for Memory {
        fn take(&self, name: &str) -> Option<(Vec<u8>, Tally)> {
            let all = self.0.borrow();
            all.iter().find(|(of, ..)| of == name).map(|(_, values, tally)| (values.clone(), *tally))
        }

        fn put(&self, name: &str, values: &dyn Fn() -> Vec<u8>, tally: &Tally) {
            self.0.borrow_mut().push((name.to_owned(), values(), *tally));
        }
    }

    #[test]
    fn another_ratio_evaluates_nothing_again() {
        let source =
            Counted(parse_synth("synth:ward?kd=0.3,0.1,0.05&ay=0.5").expect("an address"), AtomicUsize::new(0));
        let recipe = |levels: u32, ratio: f64| {
            let target = Target::Ratio(ratio);
            let recipe = Recipe { levels, stored_levels: levels, target, measure_off_grid: false, ..Recipe::default() };
            PackRecipe::Wavelet(recipe)
        };
        let cache = Memory::default();
        let asked = |recipe: &PackRecipe, cache: &dyn GridCache| {
            let before = source.1.load(Ordering::Relaxed);
            let made = encode_cached(&source, recipe, cache, &()).expect("a pack");
            (source.1.load(Ordering::Relaxed) - before, made)
        };
        assert!(asked(&recipe(3, 4.0), &cache).0 > 0);
        let (evaluations, made) = asked(&recipe(3, 8.0), &cache);
        let (afresh, fresh) = asked(&recipe(3, 8.0), &());
        assert_eq!(evaluations, 0);
        assert!(
            afresh > 0 && made.bytes == fresh.bytes && made.tally == fresh.tally && made.evaluated == fresh.evaluated
        );
        // Another grid needs other samples; cached grids with too few values are ignored.
        assert!(asked(&recipe(2, 8.0), &cache).0 > 0);
        cache.0.borrow_mut().iter_mut().for_each(|(_, values, _)| values.truncate(values.len() - 4));
        let (evaluations, made) = asked(&recipe(3, 8.0), &cache);
        assert!(evaluations == afresh && made.bytes == fresh.bytes);
    }
}
