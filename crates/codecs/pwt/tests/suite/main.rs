//! Tests encodes of generated RTI captures with known answers.

mod assemble;
mod choose;
mod encode;
mod golden;
mod measure;
mod near;
mod stacks;
mod views;
