//! `brdfc eval`: evaluates a source at given direction pairs.

use super::inputs::refuse_stdin_twice;
use super::output::{as_flag, note_coverage, note_repairs, output_parser, print, refuse_unfit_output, write_file};
use super::reading::{ReadingOptions, checked};
use super::{Common, Error};
use brdfc::evaluate::{Body, Relightable, check_level, open_level, pairs_from_csv, texels_from_bytes, values_at};
use brdfc::{Input, Reading};
use brdfc_terminal::words::format_number;
use clap::Args;
use std::path::{Path, PathBuf};

/// Evaluate a source or pack at direction pairs.
///
/// The CSV has a header with wi_x,wi_y,wi_z,wo_x,wo_y,wo_z: unit vectors in the frame x = tangent, y = bitangent, z =
/// normal. The output has the same columns, followed by f_r,f_g,f_b (1/sr, linear RGB), which replace existing columns
/// of these names. Scans are smoothed at the requested directions, and packs are filtered bilinearly.
///
/// For a polynomial wavelet tree ('brdfc pwt') or a flat BTF, the CSV also has positions: u,v (0 to 1, across and
/// down), wi_x,wi_y,wi_z and, for a flat BTF, wo_x,wo_y,wo_z. The v of a flat BTF is 1 minus the v of its shader. The
/// output columns are r,g,b (linear, 1 is white). Tiles continue beyond 0 to 1.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc eval paint.brdf --directions pairs.csv
  brdfc eval paint.ktx2 --directions pairs.csv --lod 2.5 -o values.csv
  brdfc eval icon.ktx2 --directions texels.csv
  brdfc eval button --directions texels.csv")]
pub struct Arguments {
    /// A path, - for stdin, or synth:MODEL?param=value&...; a flat BTF or its folder.
    input: Input,
    /// CSV of direction pairs or positions, or - for stdin.
    #[arg(long, value_name = "IN.csv")]
    directions: Input,
    /// Output file, or - for stdout (default: stdout).
    #[arg(long, short, value_name = "OUT.csv", value_parser = output_parser())]
    output: Option<PathBuf>,
    /// Level of detail of a pack, from 0 (coarsest) to the number of levels of the pack (default: the finest).
    #[arg(long, value_name = "L")]
    lod: Option<f32>,
    #[command(flatten)]
    reading: ReadingOptions,
}

/// Output columns of reflectance.
const VALUES: [&str; 3] = ["f_r", "f_g", "f_b"];
/// Output columns of colour.
const COLOURS: [&str; 3] = ["r", "g", "b"];

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    check_level(arguments.lod).map_err(as_flag)?;
    let reading = checked(Reading { level: arguments.lod, ..arguments.reading.into() }, &[&arguments.input])?;
    let directions = &arguments.directions;
    refuse_stdin_twice(&[("INPUT", Some(&arguments.input)), ("--directions", Some(directions))])?;
    if let Some(output) = &arguments.output {
        let inputs: Vec<&Path> = [directions, &arguments.input].into_iter().filter_map(Input::path).collect();
        refuse_unfit_output(output, &["csv"], &inputs)?;
    }
    let bytes = directions.read_text()?;
    if let Some(relightable) = Relightable::open(&arguments.input)? {
        return texels(arguments, &relightable, &bytes);
    }
    // First the input: its kind decides about the columns.
    let material = open_level(&arguments.input, reading).map_err(as_flag)?;
    let pairs = pairs_from_csv(directions, &bytes)?;
    note_coverage(common, &arguments.input, material.source());
    let (values, repairs) = values_at(material.source(), &pairs);
    note_repairs(common, &arguments.input, &repairs);
    write(arguments, &bytes, VALUES, values.iter())
}

/// Evaluates positions of an image or a tile.
fn texels(arguments: &Arguments, relightable: &Relightable, bytes: &[u8]) -> Result<(), Error> {
    let directions = &arguments.directions;
    let queries = texels_from_bytes(bytes, relightable.has_views(), relightable.repeats())
        .map_err(|error| Error::input(format!("{directions}: {error}")))?;
    let finest = relightable.levels() as f32;
    let level = arguments.lod.unwrap_or(finest);
    if !(0.0..=finest).contains(&level) {
        let allowed = format!("0 to {finest}, the available levels");
        return Err(Error::wrong_usage("--lod", format_number(level), allowed));
    }
    write(arguments, bytes, COLOURS, relightable.values(&queries, level).iter())
}

fn write<'a, T: ToString + 'a>(
    arguments: &Arguments,
    bytes: &[u8],
    columns: [&str; 3],
    values: impl Iterator<Item = &'a [T; 3]>,
) -> Result<(), Error> {
    let directions = &arguments.directions;
    let text = appended(bytes, columns, values).map_err(|error| Error::input(format!("{directions}: {error}")))?;
    match &arguments.output {
        Some(output) => write_file(output, text.as_bytes()),
        None => print(&text),
    }
}

/// Appends the values to the records of the input.
fn appended<'a, T: ToString + 'a>(
    bytes: &[u8],
    columns: [&str; 3],
    values: impl Iterator<Item = &'a [T; 3]>,
) -> Result<String, csv::Error> {
    let Body { bytes, delimiter, .. } = Body::of(bytes);
    let mut reader = csv::ReaderBuilder::new();
    let mut reader = reader.delimiter(delimiter).trim(csv::Trim::All).comment(Some(b'#')).from_reader(bytes);
    let mut writer = csv::WriterBuilder::new().delimiter(delimiter).from_writer(Vec::new());
    let found = reader.headers()?.clone();
    // Existing value columns come from another source. Readers take the first of two columns with one name, so drop them.
    let retained: Vec<bool> = found.iter().map(|name| !columns.contains(&name)).collect();
    let others = |record: &csv::StringRecord| -> csv::StringRecord {
        record.iter().zip(&retained).filter(|(_, retained)| **retained).map(|(field, _)| field).collect()
    };
    let mut header = others(&found);
    columns.iter().for_each(|name| header.push_field(name));
    writer.write_record(&header)?;
    for (record, value) in reader.records().zip(values) {
        let mut record = others(&record?);
        value.iter().for_each(|channel| record.push_field(&channel.to_string()));
        writer.write_record(&record)?;
    }
    let bytes = writer.into_inner().expect("memory can be written to");
    Ok(String::from_utf8(bytes).expect("the input was checked to be UTF-8"))
}
