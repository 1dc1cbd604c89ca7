//! Encoder of polynomial wavelet trees: converts photographs of one view, or of the views of a BTF, under known lights to a pack
//! (`formats/src/pwt`). Each step has its own file; `encode.rs` sequences them.
//!
//! Baril, Boubekeur, Gioia and Schlick 2008, "Polynomial wavelet trees for bidirectional texture functions".

pub mod assemble;
pub mod candidates;
pub mod choose;
mod choose_learned;
pub mod components;
pub mod degrees;
pub mod design;
mod encode;
mod encoded;
mod facts;
pub mod fit;
pub mod image;
mod kriging;
mod learned;
pub mod levels;
mod lifting;
pub mod measure;
pub mod near;
pub mod normals;
mod project;
pub mod ptm;
mod recipe;
mod search;
mod stack;
pub mod terms;
pub mod tree;
mod view_stack;
mod views;
pub mod web;

pub use encode::{PwtEncoded, encode, plain};
pub use facts::{PwtFacts, PwtTextureFacts};
pub use lifting::{Border, Wavelet};
pub use recipe::{DomainName, PwtRecipe, Target};
pub use stack::{LIGHTS, LightSamples};
pub use views::Views;
