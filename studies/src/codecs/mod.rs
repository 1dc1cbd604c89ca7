//! Packs compared with alternatives: general compressors of dense tables, block compression, a fitted model, a network.

mod blocks;
mod drawing;
mod measure;
mod neural;
mod peers;
mod volume;

pub use drawing::drawing;
pub use measure::{CodecStudyError, codec_study};
pub use neural::{NETWORK_WEIGHTS, NeuralBrdf};
pub use peers::{Compress, Compressed, DenseTable, Peers};

use brdfc_gpu::AdapterDescription;
use schemars::JsonSchema;
use serde::Serialize;

/// Results of the study.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CodecStudy {
    /// Adapter that ran the shaders.
    pub adapter: AdapterDescription,
    /// Alternatives that were not measured, each with the reason.
    pub left_out: Vec<String>,
    /// One entry for each material.
    pub materials: Vec<CodecMaterial>,
}

/// One material.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CodecMaterial {
    /// Name of the material.
    pub material: String,
    /// One row for each codec and size.
    pub rows: Vec<CodecRow>,
}

/// One codec at one size.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CodecRow {
    /// `table`, `factored`, `wavelet`, `zfp`, `sz3`, `bc6h`, `bc7`, `ggx` or `neural`.
    pub codec: String,
    /// Nodes, ratio, tolerance, parameters or layers.
    pub setting: String,
    /// For zfp and SZ3: true if they compress a dense table, false for the nodes that were fitted for a pack.
    pub dense: bool,
    /// True if a GPU can sample it as it is stored.
    pub sampled: bool,
    /// Bytes on a GPU. Data that it cannot sample is decompressed to halves.
    pub bytes_on_gpu: u64,
    /// Bytes of the file, or of the compressed data if there is no file format.
    pub bytes_on_disk: u64,
    /// Filtered fetches per look-up.
    pub fetches: Option<u32>,
    /// Seconds from the opened source to the bytes, without measuring errors.
    pub encode_seconds: f64,
    /// Evaluations per second of one CPU thread.
    pub cpu: Option<f64>,
    /// Evaluations per second of the shader.
    pub shader: Option<f64>,
    /// `ε_r` at independent test directions, a fraction.
    pub relative_error: f64,
    /// Mean ΔE (CIE76) of renderings.
    pub delta_e: f64,
    /// Its 95th percentile.
    pub delta_e_p95: f64,
}

impl CodecMaterial {
    /// The least bytes on disk with which a codec, of a dense table or not, has at most this ΔE, between its measured sizes on
    /// straight lines of the logarithms; `None` if it does not reach it.
    pub fn bytes_at(&self, codec: &str, dense: bool, delta_e: f64) -> Option<f64> {
        let of_codec = self.rows.iter().filter(|row| row.codec == codec && row.dense == dense);
        let points = envelope(of_codec.map(|row| (row.bytes_on_disk as f64, row.delta_e)).collect());
        let found = points.iter().position(|(_, error)| *error <= delta_e)?;
        let (bytes, error) = points[found];
        let Some((smaller, larger_error)) = found.checked_sub(1).map(|before| points[before]) else {
            return Some(bytes);
        };
        let share = (larger_error / delta_e).ln() / (larger_error / error).ln();
        Some(smaller * (bytes / smaller).powf(share))
    }
}

/// The lower envelope of points of bytes and error, sorted by bytes: those without a smaller point of less error.
fn envelope(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    points.retain(|(_, error)| {
        let better = *error < least;
        least = least.min(*error);
        better
    });
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_lie_between_sizes() {
        let row = |codec: &str, bytes_on_disk: u64, delta_e: f64| CodecRow {
            codec: codec.to_owned(),
            setting: String::new(),
            dense: false,
            sampled: true,
            bytes_on_gpu: 0,
            bytes_on_disk,
            fetches: None,
            encode_seconds: 0.0,
            cpu: None,
            shader: None,
            relative_error: 0.0,
            delta_e,
            delta_e_p95: 0.0,
        };
        let rows = vec![row("a", 100, 4.0), row("a", 400, 1.0), row("a", 300, 9.0), row("b", 10, 0.5)];
        let material = CodecMaterial { material: String::new(), rows };
        assert!((material.bytes_at("a", false, 2.0).unwrap() - 200.0).abs() < 1e-9);
        assert_eq!(material.bytes_at("a", false, 5.0), Some(100.0));
        assert_eq!(material.bytes_at("a", false, 0.9), None);
        assert_eq!(material.bytes_at("b", false, 0.9), Some(10.0));
        assert_eq!(material.bytes_at("b", true, 0.9), None);
    }
}
