//! Run time and error of codecs, sizes and bits over materials, and their Pareto fronts.

mod drawing;
mod settings;
mod sweep;

pub use drawing::drawing;
pub use settings::{WaveletSetting, settings};
pub use sweep::pareto;

use schemars::JsonSchema;
use serde::Serialize;

/// Results of the study.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoStudy {
    /// Number of threads of encoding. Decoding is measured on one.
    pub threads: usize,
    /// One entry for each material.
    pub materials: Vec<ParetoMaterial>,
}

/// One material.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoMaterial {
    /// Name of the material.
    pub material: String,
    /// One row for each setting.
    pub rows: Vec<ParetoRow>,
}

/// One setting of one codec.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ParetoRow {
    /// The variant of its codec, as in `--codec`.
    pub codec: String,
    /// Nodes of a table, or a summary of the wavelet settings.
    pub setting: String,
    /// Settings of a wavelet pack.
    pub wavelet: Option<WaveletSetting>,
    /// Bytes on a GPU.
    pub bytes_on_gpu: u64,
    /// Bytes of the file.
    pub bytes_on_disk: u64,
    /// Texture fetches per look-up.
    pub fetches: u32,
    /// Seconds from the opened source to the bytes of the file, without measuring errors; the shortest of `runs`.
    pub encode_seconds: f64,
    /// Number of encodes: one, or more if it takes less than half a second.
    pub runs: usize,
    /// Evaluations per second of the CPU decoder on one thread, at the finest level of detail; the fastest of three runs.
    pub decode_rate: f64,
    /// Mean ΔE (CIE76) of renderings.
    pub delta_e: f64,
    /// 95th percentile of ΔE (CIE76).
    pub delta_e_p95: f64,
    /// `ε_r` at independent test directions, a fraction.
    pub relative_error: f64,
    /// True if no other row is at least as good in bytes on a GPU and mean ΔE, and better in one of them.
    pub on_bytes_front: bool,
    /// True if no other row is at least as good in seconds of encoding and mean ΔE, and better in one of them.
    pub on_seconds_front: bool,
}

impl ParetoMaterial {
    /// Marks the rows on the fronts.
    pub(crate) fn marked(material: &str, mut rows: Vec<ParetoRow>) -> Self {
        let bytes = front(&rows.iter().map(|row| [row.bytes_on_gpu as f64, row.delta_e]).collect::<Vec<_>>());
        let seconds = front(&rows.iter().map(|row| [row.encode_seconds, row.delta_e]).collect::<Vec<_>>());
        for (row, (bytes, seconds)) in rows.iter_mut().zip(bytes.into_iter().zip(seconds)) {
            (row.on_bytes_front, row.on_seconds_front) = (bytes, seconds);
        }
        Self { material: material.to_owned(), rows }
    }
}

/// For each point, true if no other point is at most as large in both numbers and smaller in one. Equal points are all
/// included.
pub fn front(points: &[[f64; 2]]) -> Vec<bool> {
    let beats = |a: &[f64; 2], b: &[f64; 2]| a[0] <= b[0] && a[1] <= b[1] && (a[0] < b[0] || a[1] < b[1]);
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_has_no_dominated_points() {
        let points = [[1.0, 5.0], [2.0, 3.0], [2.0, 4.0], [3.0, 3.0], [4.0, 1.0], [4.0, 1.0], [9.0, 9.0]];
        assert_eq!(front(&points), [true, true, false, false, true, true, false]);
        assert_eq!(front(&[]), [false; 0]);
    }
}
