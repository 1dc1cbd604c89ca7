//! General compressors: they work on dense tables, and a GPU has to have their output unpacked.

/// A dense table, one channel after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct DenseTable {
    /// Numbers along each axis, the slowest first.
    pub shape: Vec<usize>,
    /// Numbers of each channel.
    pub channels: [Vec<f32>; 3],
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
    pub channels: [Vec<f32>; 3],
}

/// Compresses a table at several tolerances with every compressor there is.
pub type Compress<'a> = dyn Fn(&DenseTable) -> Result<Vec<Compressed>, String> + 'a;

impl DenseTable {
    /// Of nodes in the order of a table.
    pub(super) fn new(shape: Vec<usize>, nodes: &[[f32; 3]]) -> Self {
        Self { shape, channels: std::array::from_fn(|c| nodes.iter().map(|node| node[c]).collect()) }
    }
}

impl Compressed {
    /// In the order of a table.
    pub(super) fn nodes(&self) -> Vec<[f32; 3]> {
        let [red, green, blue] = &self.channels;
        red.iter().zip(green).zip(blue).map(|((r, g), b)| [*r, *g, *b]).collect()
    }
}
