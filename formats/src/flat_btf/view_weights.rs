//! Which of the sampled directions a look-up blends.

/// Three of the sampled directions and how much each of them counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewWeights {
    /// Which of the views, or of the lights.
    pub indices: [u32; 3],
    /// Their weights, with a sum of 1. What has a weight of 0 is not looked at.
    pub weights: [f32; 3],
}

/// A direction that is asked for, and the sampled ones that stand for it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlendedDirection {
    /// Unit vector away from the surface.
    pub direction: [f32; 3],
    /// Sampled ones.
    pub samples: ViewWeights,
}
