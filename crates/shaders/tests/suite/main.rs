//! Translated decoders: their headers, their acceptance by other compilers, and their values.

mod browser;
mod compilers;
mod needs;
mod package;
mod texts;
