//! Analytic reflectance models.
