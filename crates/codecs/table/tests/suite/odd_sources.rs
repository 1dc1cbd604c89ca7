//! Tables of unphysical sources: within their stated error, or counted.

use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::{DirectionPair, half_vector};
use brdfc_table::encode::{Encoded, encode};
use brdfc_table::recipe::TableRecipe;

/// A function of a pair.
struct Odd(fn(DirectionPair) -> f64);

impl Source for Odd {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        tally.evaluations += 1;
        [(self.0)(pair); 3]
    }

    fn symmetry(&self) -> Symmetry {
        Symmetry::FULL
    }

    fn is_grey(&self) -> bool {
        true
    }
}

fn table(f: fn(DirectionPair) -> f64) -> Encoded {
    encode(&Odd(f), &TableRecipe::default(), &()).unwrap()
}

#[test]
fn black_is_black() {
    let encoded = table(|_| 0.0);
    assert_eq!(encoded.off_grid.norms.rms, 0.0);
    assert_eq!(encoded.off_grid.rendering.delta_e.max, 0.0);
}

#[test]
fn negative_values_and_no_numbers_are_raised_and_counted() {
    let encoded = table(|pair| if pair.incoming[0] > 0.5 { -1.0 } else { 0.2 });
    assert!(encoded.tally.negative_raised > 1000, "{:?}", encoded.tally);
    assert!(encoded.off_grid.norms.rms.is_finite());
    let encoded = table(|pair| if pair.incoming[2] < 0.3 { f64::NAN } else { 0.2 });
    assert!(encoded.tally.negative_raised > 1000, "{:?}", encoded.tally);
    // NaN on one side only breaks reciprocity.
    assert!(!encoded.pack.header().symmetry.reciprocal);
    assert!(table(|_| 0.2).tally.negative_raised == 0);
    let huge = table(|pair| if pair.incoming[2] < 0.3 { 1e31 } else { 0.2 });
    assert!(huge.tally.largest_lowered > 1000 && huge.tally.negative_raised == 0, "{:?}", huge.tally);
}

/// A peak that samples may miss: no panic, finite values, and a reported error.
#[test]
fn needles_are_reported() {
    let encoded = table(|pair| if half_vector(pair)[2] > 0.999_999 { 1e6 } else { 0.1 });
    let norms = &encoded.off_grid.norms;
    assert!(norms.rms.is_finite() && norms.relative_max > 0.5, "{norms:?}");
    // The highest value, with all levels of detail, which evaluate the fit of it.
    let spike = Odd(|pair| if half_vector(pair)[2] > 0.999 && pair.incoming[2] < 0.6 { 1e30 } else { 1.0 });
    let encoded = encode(&spike, &TableRecipe { levels: 6, ..TableRecipe::default() }, &()).unwrap();
    assert!(encoded.off_grid.norms.rms.is_finite());
}

/// Below the normal numbers of f32 a material counts as black; values are finite.
#[test]
fn values_next_to_nothing_are_black() {
    for f in [(|_| 1e-42) as fn(DirectionPair) -> f64, |_| 1e-39, |pair| 1e-38 * (1.0 + pair.incoming[0])] {
        for factored in [false, true] {
            let encoded = encode(&Odd(f), &TableRecipe { factored, ..TableRecipe::default() }, &()).unwrap();
            assert!(encoded.pack.values().iter().flatten().all(|v| v.is_finite()));
            assert!(encoded.off_grid.norms.rms < 1e-37);
        }
    }
}

#[test]
fn huge_and_tiny_values_are_held() {
    for (f, value) in [((|_| 1e30) as fn(DirectionPair) -> f64, 1e30), (|_| 1e-30, 1e-30)] {
        let encoded = table(f);
        let norms = &encoded.off_grid.norms;
        assert!(norms.rms <= 1e-4 * value && norms.relative_mean < 1e-4, "{value}: {norms:?}");
    }
}
