//! Tables of sources that were made before: another ratio needs no other table.

use brdfc_core::{Source, Tally};
use brdfc_wavelet::table::Grid;
use brdfc_wavelet::tabulated::Tabulated;

/// Where tables of one source are kept.
pub trait TableShelf {
    /// The values of a table, and what was mended in it.
    fn take(&self, grid: Grid) -> Option<(Vec<u8>, Tally)>;
    /// Keeps a table.
    fn put(&self, table: &Tabulated);
}

/// Keeps none.
impl TableShelf for () {
    fn take(&self, _: Grid) -> Option<(Vec<u8>, Tally)> {
        None
    }

    fn put(&self, _: &Tabulated) {}
}

/// The table of a source: from the shelf, or made and kept there.
pub(super) fn tabulated(source: &dyn Source, grid: Grid, shelf: &dyn TableShelf) -> Tabulated {
    let kept = shelf.take(grid).and_then(|(values, tally)| Tabulated::from_bytes(source, grid, &values, tally));
    kept.unwrap_or_else(|| {
        let made = Tabulated::new(source, grid);
        shelf.put(&made);
        made
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::encode_with;
    use crate::encode::recipe::PackRecipe;
    use brdfc_core::Symmetry;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::DirectionPair;
    use brdfc_wavelet::recipe::{Recipe, Target};
    use std::cell::RefCell;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Counts how often it is asked.
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
    struct Memory(RefCell<Vec<(Grid, Vec<u8>, Tally)>>);

    impl TableShelf for Memory {
        fn take(&self, grid: Grid) -> Option<(Vec<u8>, Tally)> {
            let all = self.0.borrow();
            all.iter().find(|(of, ..)| *of == grid).map(|(_, values, tally)| (values.clone(), *tally))
        }

        fn put(&self, table: &Tabulated) {
            self.0.borrow_mut().push((table.table.grid, table.to_bytes(), table.tally));
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
        let shelf = Memory::default();
        let asked = |recipe: &PackRecipe, shelf: &dyn TableShelf| {
            let before = source.1.load(Ordering::Relaxed);
            let made = encode_with(&source, recipe, shelf, &()).expect("a pack");
            (source.1.load(Ordering::Relaxed) - before, made)
        };
        assert!(asked(&recipe(3, 4.0), &shelf).0 > 0);
        let (evaluations, made) = asked(&recipe(3, 8.0), &shelf);
        let (afresh, fresh) = asked(&recipe(3, 8.0), &());
        assert_eq!(evaluations, 0);
        assert!(
            afresh > 0 && made.bytes == fresh.bytes && made.tally == fresh.tally && made.evaluated == fresh.evaluated
        );
        // Another grid is another table; what has not as many values is none.
        assert!(asked(&recipe(2, 8.0), &shelf).0 > 0);
        shelf.0.borrow_mut().iter_mut().for_each(|(_, values, _)| values.truncate(values.len() - 4));
        let (evaluations, made) = asked(&recipe(3, 8.0), &shelf);
        assert!(evaluations == afresh && made.bytes == fresh.bytes);
    }
}
