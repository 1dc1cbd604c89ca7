//! Analytic models against physical laws.

mod physics;
