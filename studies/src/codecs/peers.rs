//! Alternatives that are made outside this crate: general compressors of dense tables, whose output must be decompressed
//! for a GPU, and networks that others have trained.

use super::neural::NeuralBrdf;

/// A dense table, one channel after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseTable {
    /// Numbers along each axis, the slowest first.
    pub shape: Vec<usize>,
    /// Numbers of each channel: one for grey materials, otherwise three.
    pub channels: Vec<Vec<f32>>,
}

/// Output of a compressor at one tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Compressed {
    /// `zfp` or `sz3`.
    pub codec: String,
    /// Maximum difference of logarithms.
    pub tolerance: f64,
    /// Compressed bytes.
    pub bytes: u64,
    /// Seconds to compress.
    pub seconds: f64,
    /// Numbers of each channel, decompressed.
    pub channels: Vec<Vec<f32>>,
}

/// Compresses a table at several tolerances with every available compressor.
pub type Compress<'a> = dyn Fn(&DenseTable) -> Result<Vec<Compressed>, String> + 'a;

/// Alternatives to measure on a material.
#[derive(Default)]
pub struct Peers<'a> {
    /// Runs zfp and SZ3.
    pub compress: Option<&'a Compress<'a>>,
    /// A network that was trained on the material.
    pub network: Option<NeuralBrdf>,
}

impl DenseTable {
    /// Makes a table from nodes in its order.
    pub(super) fn new(shape: Vec<usize>, nodes: &[[f32; 3]], grey: bool) -> Self {
        let channel = |c: usize| nodes.iter().map(|node| node[c]).collect();
        Self { shape, channels: (0..if grey { 1 } else { 3 }).map(channel).collect() }
    }
}

impl Compressed {
    /// Nodes in the order of the table.
    pub(super) fn nodes(&self) -> Vec<[f32; 3]> {
        let last = self.channels.len() - 1;
        let node = |k: usize| std::array::from_fn(|c| self.channels[c.min(last)][k]);
        (0..self.channels[0].len()).map(node).collect()
    }
}
