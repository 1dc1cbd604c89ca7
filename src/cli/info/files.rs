//! `brdfc info --files`: metadata of the KTX2 files of a pack.

use crate::output::{json_or, print};
use crate::table;
use crate::{Common, Error};
use brdfc::Input;
pub(super) use brdfc::inspect::device_needs;
use brdfc::inspect::{PackFile, files};
use serde::Serialize;
use std::collections::BTreeMap;

/// Report of `--files --json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct FilesReport {
    /// Layout of this report.
    version: u32,
    /// 'files'.
    kind: &'static str,
    /// Textures by file name; textures embedded in metadata are named NAME#KEY.
    files: BTreeMap<String, PackFile>,
}

/// Prints the files of a pack.
pub(super) fn run(input: &Input, common: Common) -> Result<(), Error> {
    let files = files(input)?;
    let line = |(name, file): (&String, &PackFile)| {
        let [width, height, depth] = file.size;
        let entries = file.entries.keys().cloned().collect::<Vec<_>>().join(" ");
        let size =
            if file.dimension == "2d" { format!("{width}x{height}") } else { format!("{width}x{height}x{depth}") };
        [name.clone(), file.texel_format.to_owned(), file.dimension.to_owned(), size, file.levels.to_string(), entries]
    };
    let text = table::words(&["file", "texels", "dimension", "size", "levels", "entries"], files.iter().map(line));
    print(&json_or(common, &FilesReport { version: 1, kind: "files", files }, text))
}
