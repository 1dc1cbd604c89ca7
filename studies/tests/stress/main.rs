//! Numerical stress: every stage at the ends of its range, in single precision against double, or against what must come out.
//! Each row has the worst error that was found, the bound that it must hold, and why that bound.

mod decode;
mod directions;
mod encode;
mod fed;
mod logarithms;
mod neighbourhoods;
mod pack;
mod propagation;
mod row;
mod run;
mod stages;
mod tables;
mod tests;
mod texels;
mod transforms;
