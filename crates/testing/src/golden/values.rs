//! Hashes of decoded values: every stored value, and look-ups at fixed places.
//!
//! The places are computed without mathematical functions. All hashes except the `reflectances` of wavelet packs depend
//! only on sums, products, quotients and square roots, and the hashes of factored flat BTFs also on sines that are rounded
//! to single precision. They are the same on every machine.

use super::Hashes;
use brdfc_formats::ErrorSummary;

/// Collects numbers as little-endian words.
#[derive(Default)]
pub(crate) struct Values(blake3::Hasher);

impl Values {
    pub(crate) fn add(&mut self, values: impl IntoIterator<Item = f32>) {
        self.words(values.into_iter().map(f32::to_bits));
    }

    pub(crate) fn words(&mut self, words: impl IntoIterator<Item = u32>) {
        for word in words {
            self.0.update(&word.to_le_bytes());
        }
    }

    /// Measured errors.
    pub(crate) fn summary(&mut self, e: &ErrorSummary) {
        self.words([e.samples]);
        self.add([e.rms, e.relative_mean, e.relative_p95, e.relative_p99, e.relative_max]);
        self.add([e.log_rms, e.cosine_log_rms, e.albedo_max_difference, e.reciprocity]);
    }

    fn hash(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }
}

/// Hashes of columns.
pub(crate) fn of_columns<const COUNT: usize>(columns: [(&'static str, Values); COUNT]) -> Hashes {
    columns.into_iter().map(|(name, values)| (name, values.hash())).collect()
}

/// Unit vectors over the hemisphere and some below the horizon, by stereographic projection of a grid.
pub(crate) fn directions() -> impl Iterator<Item = [f64; 3]> + Clone {
    (-2..=2).flat_map(|row| {
        (-2..=2).map(move |column| {
            let [p, q] = [0.43 * f64::from(column) + 0.05, 0.41 * f64::from(row) - 0.03];
            let square = p * p + q * q;
            [2.0 * p, 2.0 * q, 1.0 - square].map(|c| c / (1.0 + square))
        })
    })
}

pub(crate) fn single(v: [f64; 3]) -> [f32; 3] {
    v.map(|c| c as f32)
}

/// Points of a periodic plane, inside the tile and outside.
pub(crate) fn points() -> impl Iterator<Item = [f32; 2]> + Clone {
    (0..40).map(|k| [0.173 * k as f32 - 1.3, 0.311 * k as f32 - 4.2])
}
