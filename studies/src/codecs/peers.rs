//! General compressors: they work on dense tables, and a GPU has to have their output unpacked.

/// A dense table, one channel after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseTable {
    /// Numbers along each axis, the slowest first.
    pub shape: Vec<usize>,
    /// Numbers of each channel: one of grey materials, otherwise three.
    pub channels: Vec<Vec<f32>>,
}

/// What a compressor made of one, at one tolerance.
#[derive(Debug, Clone, PartialEq)]
pub struct Compressed {
    /// `zfp` or `sz3`.
    pub codec: String,
    /// Largest difference that it was allowed, of logarithms.
    pub tolerance: f64,
    /// Compressed bytes.
    pub bytes: u64,
    /// Seconds that compressing took.
    pub seconds: f64,
    /// Numbers of each channel, decompressed.
    pub channels: Vec<Vec<f32>>,
}

/// Compresses a table at several tolerances with every compressor there is.
pub type Compress<'a> = dyn Fn(&DenseTable) -> Result<Vec<Compressed>, String> + 'a;

impl DenseTable {
    /// Of nodes in the order of a table.
    pub(super) fn new(shape: Vec<usize>, nodes: &[[f32; 3]], grey: bool) -> Self {
        let channel = |c: usize| nodes.iter().map(|node| node[c]).collect();
        Self { shape, channels: (0..if grey { 1 } else { 3 }).map(channel).collect() }
    }
}

impl Compressed {
    /// In the order of a table.
    pub(super) fn nodes(&self) -> Vec<[f32; 3]> {
        let last = self.channels.len() - 1;
        let node = |k: usize| std::array::from_fn(|c| self.channels[c.min(last)][k]);
        (0..self.channels[0].len()).map(node).collect()
    }
}
