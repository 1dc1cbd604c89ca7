//! Run time against error: codecs, sizes, bits and smoothing swept over materials, and what no other setting beats.

mod drawing;
mod settings;
mod sweep;

pub use drawing::drawing;
pub use settings::{WaveletSetting, settings};
pub use sweep::pareto;

use schemars::JsonSchema;
use serde::Serialize;

/// The study's figures.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoStudy {
    /// Threads that encoded. Decoding is measured on one.
    pub threads: usize,
    /// One for each material.
    pub materials: Vec<ParetoMaterial>,
}

/// One material.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoMaterial {
    /// What it is called.
    pub material: String,
    /// One for each setting.
    pub rows: Vec<ParetoRow>,
}

/// One setting of one codec.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoRow {
    /// The variant of its codec, as `--codec` takes it.
    pub codec: String,
    /// Nodes of a table; of wavelets what was asked for, in words.
    pub setting: String,
    /// What was asked for of a wavelet pack.
    pub wavelet: Option<WaveletSetting>,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Texture fetches of a look-up.
    pub fetches: u32,
    /// Seconds from the opened source to the bytes of the file, errors off the grid not measured; the shortest of `runs`.
    pub encode_seconds: f64,
    /// How often it was encoded: once, but for what takes less than half a second.
    pub runs: usize,
    /// Evaluations per second of the CPU decoder on one thread, at the finest level of detail; the fastest of three runs.
    pub decode_rate: f64,
    /// Mean ΔE*ab of renderings.
    pub delta_e: f64,
    /// Its 95th percentile.
    pub delta_e_p95: f64,
    /// `ε_r` off the grid, a fraction.
    pub relative_error: f64,
    /// Whether no other row is as small on a GPU and as close, and better in one of both.
    pub on_bytes_front: bool,
    /// Likewise by the seconds of encoding.
    pub on_seconds_front: bool,
}

impl ParetoMaterial {
    /// Marks the rows that no other beats.
    pub(crate) fn marked(material: &str, mut rows: Vec<ParetoRow>) -> Self {
        let bytes = front(&rows.iter().map(|row| [row.bytes_on_gpu as f64, row.delta_e]).collect::<Vec<_>>());
        let seconds = front(&rows.iter().map(|row| [row.encode_seconds, row.delta_e]).collect::<Vec<_>>());
        for (row, (bytes, seconds)) in rows.iter_mut().zip(bytes.into_iter().zip(seconds)) {
            (row.on_bytes_front, row.on_seconds_front) = (bytes, seconds);
        }
        Self { material: material.to_owned(), rows }
    }
}

/// Which of the points no other beats: is at most as large in both numbers, and smaller in one. Of equal ones all are kept.
pub fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_no_other_beats() {
        let points = [[1.0, 5.0], [2.0, 3.0], [2.0, 4.0], [3.0, 3.0], [4.0, 1.0], [4.0, 1.0], [9.0, 9.0]];
        assert_eq!(front(&points), [true, true, false, false, true, true, false]);
        assert_eq!(front(&[]), [false; 0]);
    }
}
