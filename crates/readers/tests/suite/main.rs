//! Tests of the pages of measured files, and of files that are only read.

mod spec_dumps;
mod ubo_btf;
