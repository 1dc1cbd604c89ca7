//! Symmetries of reflectance functions.

/// Symmetries of `f_r(incoming, outgoing)`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, schemars::JsonSchema))]
pub struct Symmetry {
    /// True if the value does not change when both directions turn about the normal by the same angle.
    pub isotropic: bool,
    /// True if the value does not change when both directions are mirrored in the plane `x = 0` or in the plane `y =
    /// 0`.
    pub mirror: bool,
    /// True if the value does not change when incoming and outgoing are exchanged (Helmholtz reciprocity).
    pub reciprocal: bool,
}

impl Symmetry {
    /// No known symmetry: the value at each direction pair may differ.
    pub const NONE: Self = Self { isotropic: false, mirror: false, reciprocal: false };
    /// All symmetries: an isotropic, mirror-symmetric and reciprocal material.
    pub const FULL: Self = Self { isotropic: true, mirror: true, reciprocal: true };
}
