//! What the pages of measured files say.

mod spec_dumps;
