//! What the pages of measured files say, and files that are only read.

mod spec_dumps;
mod ubo_btf;
