//! Files of an input.

use crate::btf_stack::images_of;
use crate::flat_btf::flat_btf_in;
use crate::rti_capture::{files_of_stack, is_rti_capture};
use std::path::{Path, PathBuf};

/// Files of a path: the path itself, or each file of an input that consists of several, such as the photographs of an
/// RTI capture.
///
/// Never fails: inputs that cannot be read have no files.
pub fn files_behind(path: &Path) -> Vec<PathBuf> {
    let mut files = vec![path.to_owned()];
    if is_rti_capture(path) {
        files.extend(files_of_stack(path));
    }
    if path.is_dir() {
        files.extend(flat_btf_in(path).ok().flatten());
        files.extend(images_of(path));
    }
    files
}
