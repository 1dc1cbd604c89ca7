//! Which files an input is read from.

use crate::btf_stack::images_of;
use crate::flat_btf::flat_btf_file;
use crate::rti_capture::{files_of_stack, is_rti_capture};
use std::path::{Path, PathBuf};

/// The files behind a path: itself, and of what stands in several files each of them, such as the photographs of an RTI capture.
///
/// Nothing is an error here: what cannot be read has no files.
pub fn files_behind(path: &Path) -> Vec<PathBuf> {
    let mut files = vec![path.to_owned()];
    if is_rti_capture(path) {
        files.extend(files_of_stack(path));
    }
    if path.is_dir() {
        files.extend(flat_btf_file(path).ok().flatten());
        files.extend(images_of(path));
    }
    files
}
