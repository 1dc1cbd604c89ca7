//! Translated decoders: what they say of themselves, what other compilers say of them, and what they compute.

mod browser;
mod compilers;
mod needs;
mod package;
mod texts;
