//! The study of flat BTFs of images.

use super::arguments::Arguments;
use super::remarks::Remarks;
use super::structures::{short_name, structures};
use brdfc_studies::StudyResult;
use brdfc_studies::measured_btf::{MeasuredBtfError, MeasuredBtfRow, measured_btf_study, steps};
use brdfc_terminal::directions::{default_set, direction_set};
use brdfc_terminal::table::{bytes, plain};
use brdfc_terminal::{Common, Error};

/// Texels per side.
const TEXELS: usize = 32;
const MAX_TEXELS: usize = 256;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let texels = arguments.power_of_two_texels(TEXELS, MAX_TEXELS)?;
    let set = direction_set("directions", arguments.directions.as_ref().unwrap_or(&default_set()))?;
    let structures = structures(arguments)?;
    let remarks = Remarks::new(common, steps(&set) * structures.len());
    let mut rows = Vec::new();
    for (input, address) in structures {
        let made = measured_btf_study(&address, texels, &set, &|| remarks.done(1));
        rows.extend(made.map_err(|error| match error {
            MeasuredBtfError::Address(error) => Error::input(format!("{input}: {error}")),
            MeasuredBtfError::Encode(error) => Error::input(format!("{input}: {error}")),
            MeasuredBtfError::Format(error) => Error::usage(format!("--directions: {error}")),
        })?);
    }
    Ok(StudyResult::MeasuredBtf { rows })
}

pub(super) fn text(rows: &[MeasuredBtfRow]) -> String {
    let count = rows.first().map_or(0, |row| row.images);
    let texels = rows.first().map_or(0, |row| row.texels);
    let cells = |row: &MeasuredBtfRow| {
        let [psnr, delta_e] = [format!("{:.1}", row.psnr), format!("{:.2}", row.delta_e)];
        vec![short_name(&row.model), row.from.to_owned(), bytes(row.gpu_bytes), bytes(row.file_bytes), psnr, delta_e]
    };
    let table = plain(&["structure", "from", "on a GPU", "file", "PSNR, dB", "ΔE"], rows.iter().map(cells));
    format!(
        "{count} images of {texels} x {texels} pixels per structure. PSNR of sRGB-encoded values and mean ΔE over all \
         pixels of all images.\n\n{table}"
    )
}
