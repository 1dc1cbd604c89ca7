//! Analytic models against the laws they must obey.

mod physics;
