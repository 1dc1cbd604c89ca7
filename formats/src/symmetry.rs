//! What a reflectance function does not change under.

/// Symmetries of `f_r(incoming, outgoing)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Symmetry {
    /// Unchanged when both directions turn about the normal by the same angle.
    pub isotropic: bool,
    /// Unchanged when both directions are mirrored in the plane `x = 0`, and in the plane `y = 0`.
    pub mirror: bool,
    /// Unchanged when incoming and outgoing change places (Helmholtz).
    pub reciprocal: bool,
}

impl Symmetry {
    /// No symmetry known.
    pub const NONE: Self = Self { isotropic: false, mirror: false, reciprocal: false };
    /// Everything: an isotropic, mirror-symmetric and reciprocal material.
    pub const FULL: Self = Self { isotropic: true, mirror: true, reciprocal: true };
}
