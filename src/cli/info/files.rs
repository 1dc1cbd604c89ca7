//! `brdfc info --files`: what the KTX2 files of a pack hold besides texels.

use crate::output::{print, print_json};
use crate::table;
use crate::{Common, Error};
use brdfc_formats::FormatError;
use brdfc_jobs::pack_files::{PackFile, pack_files};
use brdfc_shaders::DeviceNeeds;
use brdfc_source::read::MAX_FILE_BYTES;
use brdfc_source::{Input, InputError};
use serde::Serialize;
use std::collections::BTreeMap;
use std::fs::File;

/// What `--files --json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct FilesReport {
    /// Layout of this report.
    version: u32,
    /// 'files'.
    kind: &'static str,
    /// Textures by the name of the file, those that its entries hold as NAME#ENTRY.
    files: BTreeMap<String, PackFile>,
}

/// Of a pack.
pub(super) fn run(input: &Input, common: Common) -> Result<(), Error> {
    let files = of_pack(input)?;
    if common.json {
        return print_json(&FilesReport { version: 1, kind: "files", files });
    }
    let line = |(name, file): (&String, &PackFile)| {
        let [width, height, depth] = file.size;
        let entries = file.entries.keys().cloned().collect::<Vec<_>>().join(" ");
        let size =
            if file.dimension == "2d" { format!("{width}x{height}") } else { format!("{width}x{height}x{depth}") };
        vec![
            name.clone(),
            file.texel_format.to_owned(),
            file.dimension.to_owned(),
            size,
            file.levels.to_string(),
            entries,
        ]
    };
    let rows: Vec<Vec<String>> = files.iter().map(line).collect();
    print(&table::words(&["file", "texels", "dimension", "size", "levels", "entries"], &rows))
}

/// What the textures of a pack ask of a device.
pub(super) fn device_needs(input: &Input) -> Result<DeviceNeeds, Error> {
    Ok(of_pack(input)?.into_values().fold(DeviceNeeds::default(), |all, file| all.with(file.device)))
}

fn of_pack(input: &Input) -> Result<BTreeMap<String, PackFile>, Error> {
    if input.extension()? != "ktx2" {
        // What cannot be read says so first.
        if let Some(path) = input.path() {
            File::open(path).map_err(|error| InputError::Io { name: input.to_string(), error })?;
        }
        let error = FormatError::whole("input", "no pack", "a pack");
        return Err(InputError::Format { name: input.to_string(), error }.into());
    }
    let name = match input.path() {
        Some(path) => path.file_name().unwrap_or_default().to_string_lossy().into_owned(),
        None => input.to_string(),
    };
    let wrong = |error| InputError::Format { name: input.to_string(), error };
    Ok(pack_files(&name, &input.read(MAX_FILE_BYTES)?).map_err(wrong)?)
}
