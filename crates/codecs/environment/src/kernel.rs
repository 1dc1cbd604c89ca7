//! Kernels on the sphere. They need not be normalised.

use std::f64::consts::FRAC_PI_2;

/// A kernel around a direction.
pub trait Kernel: Sync {
    /// Angle beyond which the kernel is 0, radians.
    fn radius(&self) -> f64;

    /// Value at an angle, given by its cosine, within the radius.
    fn at(&self, cosine: f64) -> f64;
}

/// The kernel of irradiance.
pub struct Cosine;

impl Kernel for Cosine {
    fn radius(&self) -> f64 {
        FRAC_PI_2
    }

    fn at(&self, cosine: f64) -> f64 {
        cosine.max(0.0)
    }
}

/// A Gaussian on the sphere, `exp((cos γ - 1) / σ²)` (the density of von Mises and Fisher).
pub struct Gaussian {
    concentration: f64,
    radius: f64,
}

impl Gaussian {
    /// Deviations at which the kernel is cut off: it has fallen to 1e-4.
    const CUT: f64 = 4.3;

    /// The kernel of a standard deviation, radians, for sums over means of texels: the variance of a texel of faces
    /// with `side` texels is subtracted.
    pub fn new(deviation: f64, side: usize) -> Self {
        let texel = FRAC_PI_2 / side as f64;
        let variance = deviation * deviation - texel * texel / 12.0;
        Self { concentration: 1.0 / variance, radius: Self::CUT * variance.sqrt() }
    }
}

impl Kernel for Gaussian {
    fn radius(&self) -> f64 {
        self.radius
    }

    fn at(&self, cosine: f64) -> f64 {
        (self.concentration * (cosine - 1.0)).exp()
    }
}
