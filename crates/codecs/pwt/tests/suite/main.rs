//! Encodes of stacks made here, whose answers are known.

mod assemble;
mod choose;
mod encode;
mod golden;
mod measure;
mod stacks;
