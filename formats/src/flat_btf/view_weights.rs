//! Weights of sampled directions in a look-up, and lights below all sampled ones.

/// Three sampled directions and their weights.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewWeights {
    /// Indices of views or lights.
    pub indices: [u32; 3],
    /// Weights with a sum of 1. Directions with weight 0 are not read.
    pub weights: [f32; 3],
}

/// A requested direction and the sampled directions that approximate it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendedDirection {
    /// Unit vector away from the surface.
    pub direction: [f32; 3],
    /// Sampled directions that are blended, with their weights.
    pub samples: ViewWeights,
}

/// Raises a direction to the height `lowest` if it is lower, with the same azimuth.
pub(crate) fn raised([x, y, z]: [f32; 3], lowest: f32) -> [f32; 3] {
    let length = (x * x + y * y).sqrt();
    if z >= lowest || length <= 0.0 {
        return [x, y, z];
    }
    let scale = (1.0 - lowest * lowest).sqrt() / length;
    [x * scale, y * scale, lowest]
}
