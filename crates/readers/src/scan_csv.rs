//! Scattered scans as CSV with RGB columns. Layout: `crates/readers/src/scan_csv.md`.

use super::scan::{self, Row, Scan, number};
use crate::file_kind::{Begins, FileKind, first_line};
use crate::text;
use brdfc_formats::direction::{Vector, dot};
use brdfc_formats::{FormatError, memory};
use std::io::{Read, Write};

/// Scans, or lists of directions, as CSV.
pub static KIND: FileKind = FileKind {
    description: "a scan or a list of directions (.csv)",
    extensions: &["csv"],
    begins: Begins::Text(|text| {
        let after = text.split_once('\n').filter(|(first, _)| separator(first.as_bytes()).is_some());
        let first = first_line(after.map_or(text, |(_, rest)| rest)).to_ascii_lowercase();
        first.contains("wi_x") || first.contains("theta_i")
    }),
};

/// Columns of a scan in angles, radians.
pub const ANGLE_COLUMNS: [&str; 7] = ["theta_i", "phi_i", "theta_o", "phi_o", "r", "g", "b"];
/// Columns of a scan in unit vectors, as `brdfc eval` writes them.
pub const VECTOR_COLUMNS: [&str; 9] = ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z", "f_r", "f_g", "f_b"];
/// Columns of a list of direction pairs.
pub const DIRECTION_COLUMNS: [&str; 6] = ["wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"];
/// Columns of a list of texels under lights; the last of [`DIRECTION_COLUMNS`] are the views.
pub const TEXEL_COLUMNS: [&str; 8] = ["u", "v", "wi_x", "wi_y", "wi_z", "wo_x", "wo_y", "wo_z"];
/// Maximum number of direction pairs of a list.
pub const MAX_DIRECTION_PAIRS: usize = 1 << 24;

/// Parses a CSV scan: a header of [`ANGLE_COLUMNS`] or [`VECTOR_COLUMNS`], then one measurement per record.
pub fn from_bytes(bytes: &[u8]) -> Result<Scan, FormatError> {
    let mut table = Table::open(bytes)?;
    let columns = if table.header.iter().any(|name| name.eq_ignore_ascii_case("theta_i")) {
        table.find(&ANGLE_COLUMNS)?
    } else {
        table.find_or(&VECTOR_COLUMNS, &ANGLE_COLUMNS)?
    };
    let mut scan = Scan::default();
    while let Some((line, n)) = table.next_numbers(&columns)? {
        let value = [n[n.len() - 3], n[n.len() - 2], n[n.len() - 1]];
        for channel in value {
            scan::check_value(channel, line)?;
        }
        let angles = if n.len() == 7 {
            [n[0], n[1], n[2], n[3]]
        } else {
            let (incoming, outgoing) = unit_vectors(&n, line)?;
            let [theta_i, phi_i] = to_polar(incoming);
            let [theta_o, phi_o] = to_polar(outgoing);
            [theta_i, phi_i, theta_o, phi_o]
        };
        scan.push(scan::checked_row(angles, value, line)?, line)?;
    }
    if scan.rows.is_empty() {
        return Err(FormatError::whole("rows", "no measurements", "at least one record after the header").problem());
    }
    Ok(scan)
}

/// Parses a list of direction pairs: a header with [`DIRECTION_COLUMNS`], in any order; other columns are ignored.
///
/// Directions below the horizon are valid here: `f_r` is zero there.
pub fn directions_from_bytes(bytes: &[u8]) -> Result<Vec<(Vector, Vector)>, FormatError> {
    let mut table = Table::open(bytes)?;
    let columns = table.find(&DIRECTION_COLUMNS)?;
    let mut pairs = Vec::new();
    while let Some((line, n)) = table.next_numbers(&columns)? {
        memory::push_within(&mut pairs, unit_vectors(&n, line)?, MAX_DIRECTION_PAIRS, "rows")?;
    }
    Ok(pairs)
}

/// Farthest tile: at greater distances f32 has hardly any digits for the position in a tile.
const MAX_TILES: f64 = 4096.0;

/// A position on an image or a tile with light and view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexelQuery {
    /// Across and down, 0 to 1; images that repeat continue beyond that range.
    pub uv: [f64; 2],
    /// Unit vector to the light.
    pub incoming: Vector,
    /// Unit vector to the viewer; the normal if none is given.
    pub outgoing: Vector,
}

/// Parses a list of texels: a header with [`TEXEL_COLUMNS`], without the last three if there is no view, in any order;
/// other columns are ignored. `repeats` is true for images that continue beyond 0 to 1.
///
/// # Errors
/// Returns an error for missing columns, and for values that are no number or unit vector, or outside the image, with the line.
pub fn texels_from_bytes(bytes: &[u8], with_view: bool, repeats: bool) -> Result<Vec<TexelQuery>, FormatError> {
    let mut table = Table::open(bytes)?;
    let columns = table.find(&TEXEL_COLUMNS[..if with_view { 8 } else { 5 }])?;
    let mut queries = Vec::new();
    while let Some((line, n)) = table.next_numbers(&columns)? {
        for (column, value) in TEXEL_COLUMNS.into_iter().zip(&n[..2]) {
            if value.abs() > MAX_TILES {
                let allowed = format!("-{MAX_TILES} to {MAX_TILES}");
                return Err(FormatError::at_line(line, column, value.to_string(), allowed));
            }
            if !repeats && !(0.0..=1.0).contains(value) {
                return Err(FormatError::at_line(line, column, value.to_string(), "0 to 1: the image does not repeat"));
            }
        }
        let mut directions = n[2..].to_vec();
        if !with_view {
            directions.extend([0.0, 0.0, 1.0]);
        }
        let (incoming, outgoing) = unit_vectors(&directions, line)?;
        let query = TexelQuery { uv: [n[0], n[1]], incoming, outgoing };
        memory::push_within(&mut queries, query, MAX_DIRECTION_PAIRS, "rows")?;
    }
    Ok(queries)
}

/// Writes rows with [`ANGLE_COLUMNS`].
pub fn write(output: &mut impl Write, rows: &[Row]) -> std::io::Result<()> {
    writeln!(output, "{}", ANGLE_COLUMNS.join(","))?;
    for row in rows {
        let [r, g, b] = row.value;
        writeln!(
            output,
            "{:.6},{:.6},{:.6},{:.6},{r:.8e},{g:.8e},{b:.8e}",
            row.theta_i, row.phi_i, row.theta_o, row.phi_o
        )?;
    }
    Ok(())
}

/// A CSV file with named columns of numbers.
pub(crate) struct Table<'a> {
    reader: csv::Reader<Records<'a>>,
    header: Vec<String>,
    /// Number of lines before the first line of the reader.
    skipped: u64,
    /// True if numbers may have a decimal comma, which is the case if the delimiter is a semicolon or a tab.
    has_commas: bool,
    /// True once a number with a decimal point was read, and one with a decimal comma.
    marks: [bool; 2],
}

/// Bytes of a table, in portions of the longest record: a quoted field could be as long as the file.
struct Records<'a> {
    bytes: &'a [u8],
    left: usize,
}

impl Read for Records<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = buffer.len().min(self.left).min(self.bytes.len());
        if count == 0 && !self.bytes.is_empty() {
            return Err(std::io::Error::other(text::too_long("record")));
        }
        let (next, rest) = self.bytes.split_at(count);
        buffer[..count].copy_from_slice(next);
        (self.bytes, self.left) = (rest, self.left - count);
        Ok(count)
    }
}

impl<'a> Table<'a> {
    /// Reads the header.
    pub(crate) fn open(bytes: &'a [u8]) -> Result<Self, FormatError> {
        text::checked_but_comments(bytes)?;
        let Body { bytes, delimiter, skipped } = Body::of(bytes);
        let records = Records { bytes, left: text::MAX_LINE_BYTES };
        let mut reader = csv::ReaderBuilder::new();
        let mut reader = reader.delimiter(delimiter).trim(csv::Trim::All).comment(Some(b'#')).from_reader(records);
        let header = reader.headers().map_err(|error| csv_error(&error, 1, skipped))?;
        let header: Vec<String> = header.iter().map(str::to_owned).collect();
        if header.is_empty() {
            return Err(FormatError::whole("header", "empty file", "a line of column names").problem());
        }
        Ok(Self { reader, header, skipped, has_commas: delimiter != b',', marks: [false; 2] })
    }

    /// Index in the file of each requested column.
    pub(crate) fn find(&self, requested: &[&'static str]) -> Result<Vec<(usize, &'static str)>, FormatError> {
        self.find_or(requested, &[])
    }

    /// Index in the file of each requested column, whose name may have capitals. Errors also list the columns of the other
    /// valid header, if any.
    fn find_or(&self, requested: &[&'static str], others: &[&str]) -> Result<Vec<(usize, &'static str)>, FormatError> {
        let headers = [requested.join(","), others.join(",")];
        let headers = if others.is_empty() { &headers[..1] } else { &headers };
        requested
            .iter()
            .map(|name| {
                let exact = self.header.iter().position(|found| found == name);
                let any_case = || self.header.iter().position(|found| found.eq_ignore_ascii_case(name));
                exact.or_else(any_case).map(|index| (index, *name)).ok_or_else(|| {
                    FormatError::at_line(
                        1 + self.skipped,
                        format!("column {name}"),
                        format!("missing in {}", scan::quoted(&self.header.join(","))),
                        format!("a header with {}", headers.join(" or ")),
                    )
                    .problem()
                })
            })
            .collect()
    }

    /// Line and numbers of the next record; `None` at the end.
    pub(crate) fn next_numbers(
        &mut self,
        columns: &[(usize, &'static str)],
    ) -> Result<Option<(u64, Vec<f64>)>, FormatError> {
        self.reader.get_mut().left = text::MAX_LINE_BYTES;
        let mut record = csv::StringRecord::new();
        let start = self.reader.position().line();
        if !self.reader.read_record(&mut record).map_err(|error| csv_error(&error, start, self.skipped))? {
            return Ok(None);
        }
        let line = self.skipped + record.position().map_or(0, csv::Position::line);
        let numbers = columns
            .iter()
            .map(|(index, name)| {
                let text = record.get(*index).unwrap_or("");
                if !self.has_commas {
                    return number(text, line, name);
                }
                self.marks = [self.marks[0] || text.contains('.'), self.marks[1] || text.contains(',')];
                if self.marks == [true; 2] {
                    let after = match [text.contains('.'), text.contains(',')] {
                        [true, true] => "with a point and a comma",
                        [_, true] => "after numbers with decimal points",
                        _ => "after numbers with decimal commas",
                    };
                    let found = format!("{} {after}", scan::quoted(text));
                    let allowed = "one decimal mark in all numbers, and no separators of thousands";
                    return Err(FormatError::at_line(line, (*name).to_owned(), found, allowed).problem());
                }
                number(&text.replacen(',', ".", 1), line, name)
            })
            .collect::<Result<_, _>>()?;
        Ok(Some((line, numbers)))
    }
}

/// The lines of a table that [`csv`] reads, and their delimiter.
#[derive(Debug, Clone, Copy)]
pub struct Body<'a> {
    /// The table without a line `sep=;`, by which spreadsheets declare the delimiter.
    pub bytes: &'a [u8],
    /// The declared delimiter, or else the most frequent of comma, semicolon and tab in the first line that is not a comment.
    pub delimiter: u8,
    /// Number of skipped lines.
    skipped: u64,
}

impl<'a> Body<'a> {
    /// Finds the lines of a table.
    pub fn of(bytes: &'a [u8]) -> Self {
        let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let end = text.iter().position(|byte| *byte == b'\n').map_or(text.len(), |at| at + 1);
        match separator(&text[..end]) {
            Some(delimiter) => Self { bytes: &text[end..], delimiter, skipped: 1 },
            None => Self { bytes, delimiter: most_frequent(bytes), skipped: 0 },
        }
    }
}

/// The delimiter that a line `sep=;` declares; `None` for other lines.
fn separator(line: &[u8]) -> Option<u8> {
    let line = line.trim_ascii_start();
    let declared = line.strip_prefix(b"\"").unwrap_or(line);
    let (key, rest) = declared.split_at_checked(4)?;
    let delimiter = *rest.first().filter(|_| key.eq_ignore_ascii_case(b"sep="))?;
    let is_alone = rest[1..].iter().all(|byte| byte.is_ascii_whitespace() || *byte == b'"');
    (is_alone && [b',', b';', b'\t'].contains(&delimiter)).then_some(delimiter)
}

fn most_frequent(bytes: &[u8]) -> u8 {
    let is_header = |line: &&[u8]| !line.starts_with(b"#") && !line.trim_ascii().is_empty();
    let header = bytes.split(|byte| *byte == b'\n').find(is_header).unwrap_or_default();
    let count = |delimiter: &u8| header.iter().filter(|byte| *byte == delimiter).count();
    // `max_by_key` returns the last maximum: a comma before a semicolon before a tab.
    [b'\t', b';', b','].into_iter().max_by_key(count).unwrap_or(b',')
}

/// Error of the record that starts at `line`, unless the error has its own line.
fn csv_error(error: &csv::Error, line: u64, skipped: u64) -> FormatError {
    let line = skipped + error.position().map_or(line, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => FormatError::at_line(
            line,
            "record",
            format!("{len} fields"),
            format!("{expected_len}, the number of columns"),
        ),
        csv::ErrorKind::Io(error) => {
            FormatError::at_line(line, "record", error.to_string(), text::allowed_length()).problem()
        }
        _ => FormatError::at_line(line, "record", error.to_string(), "comma-separated numbers").problem(),
    }
}

/// Both directions of a record, normalised; lengths may be off by 1 % (rounded decimals).
fn unit_vectors(n: &[f64], line: u64) -> Result<(Vector, Vector), FormatError> {
    let unit = |v: Vector, field: &'static str| {
        let length = dot(v, v).sqrt();
        if (0.99..=1.01).contains(&length) {
            Ok(v.map(|c| c / length))
        } else {
            Err(FormatError::at_line(line, field, format!("a vector of length {length:.4}"), "unit vectors"))
        }
    };
    Ok((unit([n[0], n[1], n[2]], "wi")?, unit([n[3], n[4], n[5]], "wo")?))
}

fn to_polar(d: Vector) -> [f64; 2] {
    [d[0].hypot(d[1]).atan2(d[2]), d[1].atan2(d[0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_headers_mean_the_same() {
        let angles = "theta_i,phi_i,theta_o,phi_o,r,g,b\n0.5,0.0,0.25,1.0,1,2,3\n";
        let row = from_bytes(angles.as_bytes()).unwrap().rows[0];
        let i = brdfc_formats::direction::from_polar(0.5, 0.0);
        let o = brdfc_formats::direction::from_polar(0.25, 1.0);
        let vectors =
            format!("{}\n{},{},{},{},{},{},1,2,3\n", VECTOR_COLUMNS.join(","), i[0], i[1], i[2], o[0], o[1], o[2]);
        let other = from_bytes(vectors.as_bytes()).unwrap().rows[0];
        assert!((row.theta_o - other.theta_o).abs() < 1e-12 && (row.phi_o - other.phi_o).abs() < 1e-12);
        assert_eq!(row.value, other.value);
    }

    /// Files of programs in languages with a decimal comma.
    #[test]
    fn semicolons_and_tabs_are_delimiters_too() {
        let plain = "# by hand, once\ntheta_i,phi_i,theta_o,phi_o,r,g,b\n0.5,0,0.25,1,1.5,2,3e-1\n";
        let rows = |text: &str| from_bytes(text.as_bytes()).map(|scan| scan.rows);
        let value = rows(plain).unwrap()[0].value;
        assert_eq!(value, [1.5, 2.0, 0.3]);
        for other in [";", "\t"] {
            let points = plain.replace("by hand, once", "by hand").replace(',', other);
            assert_eq!(rows(&points).unwrap()[0].value, value);
            assert_eq!(rows(&points.replace('.', ",")).unwrap()[0].value, value);
            assert!(rows(&points.replace("1.5", "1,5,0")).is_err());
        }
        assert!(rows(&plain.replace("1.5", "\"1,5\"")).is_err(), "with commas as delimiters, numbers have none");
    }

    /// Spreadsheets declare the delimiter; people write names of columns with capitals, and comments in Latin-1.
    #[test]
    fn headers_of_spreadsheets_are_read() {
        let plain = "theta_i,phi_i,theta_o,phi_o,r,g,b\n0.5,0,0.25,1,1.5,2,3e-1\n";
        let expected = from_bytes(plain.as_bytes()).unwrap().rows;
        let capitals = plain.replace("theta_i", "Theta_i").replace(",r,g,b", ",R,G,B");
        let lines = |text: &str| text.replace(',', ";");
        for text in [
            capitals.clone(),
            format!("sep=;\n{}", lines(plain)),
            format!("\u{feff}SEP=;\r\n{}", lines(&capitals)),
            format!("\"sep=;\"\n{}", lines(plain).replace('.', ",")),
            format!("sep=,\n{plain}"),
        ] {
            assert_eq!(from_bytes(text.as_bytes()).map(|scan| scan.rows), Ok(expected.clone()), "{text}");
            assert!(
                KIND.is_of(text.as_bytes(), text.len() as u64, Some(text.trim_start_matches('\u{feff}'))),
                "{text}"
            );
        }
        // The exact name comes first.
        let both = "R,theta_i,phi_i,theta_o,phi_o,r,g,b\n9,0.5,0,0.25,1,1.5,2,3e-1\n";
        assert_eq!(from_bytes(both.as_bytes()).unwrap().rows, expected);
        let latin = [b"# Caf\xe9\n", plain.as_bytes()].concat();
        assert_eq!(from_bytes(&latin).unwrap().rows, expected);
        let message = |text: &str| from_bytes(text.as_bytes()).unwrap_err().to_string();
        assert!(
            message("sep=;\na;b\n").starts_with("line 2, column wi_x: missing in \"a,b\""),
            "{}",
            message("sep=;\na;b\n")
        );
        let wrong = message(&format!("sep=;\n{}", lines(plain).replace("0.25", "x")));
        assert!(wrong.starts_with("line 3, theta_o: found \"x\""), "{wrong}");
        // Another first line is a header.
        assert!(message(&format!("separate=;\n{plain}")).contains("column wi_x: missing"));
    }

    #[test]
    fn texels_with_and_without_a_view() {
        let text = "name,wi_z,wi_x,wi_y,v,u\nx,1,0,0,0.25,-0.5\n";
        let query = texels_from_bytes(text.as_bytes(), false, true).unwrap()[0];
        assert_eq!(query, TexelQuery { uv: [-0.5, 0.25], incoming: [0.0, 0.0, 1.0], outgoing: [0.0, 0.0, 1.0] });
        let error = texels_from_bytes(text.as_bytes(), true, true).unwrap_err().to_string();
        assert!(error.starts_with("line 1, column wo_x: missing in \"name,wi_z,"), "{error}");
        let error = |row: &str, repeats| {
            let read = texels_from_bytes(format!("u,v,wi_x,wi_y,wi_z\n{row}\n").as_bytes(), false, repeats);
            read.err().map(|error| error.to_string()).unwrap_or_default()
        };
        assert!(error("0,0,1,1,1", true).starts_with("line 2, wi: found a vector of length 1.7321"));
        assert_eq!(error("1.5,0,0,0,1", false), "line 2, u: found 1.5, expected 0 to 1: the image does not repeat");
        assert_eq!(error("0,-1,0,0,1", false), "line 2, v: found -1, expected 0 to 1: the image does not repeat");
        assert_eq!([error("0,1,0,0,1", false), error("1.5,-1,0,0,1", true)], ["", ""]);
        assert_eq!(error("0,1e5,0,0,1", true), "line 2, v: found 100000, expected -4096 to 4096");
    }

    #[test]
    fn scans_round_trip() {
        let row = Row { theta_i: 0.25, phi_i: 0.5, theta_o: 0.75, phi_o: -1.0, value: [0.5, 0.25, -0.125] };
        let mut bytes = Vec::new();
        write(&mut bytes, &[row]).unwrap();
        assert_eq!(from_bytes(&bytes).unwrap().rows, [row]);
    }

    #[test]
    fn errors_name_line_and_column() {
        let text = |s: &str| from_bytes(s.as_bytes()).unwrap_err().to_string();
        assert!(text("").contains("header"));
        assert!(text("theta_i,phi_i\n").contains("column theta_o"));
        assert!(text("a,b\n").contains("column wi_x"));
        let head = "theta_i,phi_i,theta_o,phi_o,r,g,b\n";
        assert!(text(head).contains("no measurements"));
        assert!(text(&format!("{head}0,0,0,0,1,1\n")).contains("line 2, record: found 6 fields, expected 7"));
        assert!(text(&format!("{head}0,0,0,0,1,1,x\n")).contains("line 2, b: found \"x\""));
        assert!(text(&format!("{head}0,0,0,0,1,1,inf\n")).contains("a finite number"));
        assert!(text(&format!("{head}60,0,0,0,1,1,1\n")).contains("degrees"));
        let vectors = format!("{}\n0,0,2,0,0,1,1,1,1\n", VECTOR_COLUMNS.join(","));
        assert!(text(&vectors).contains("wi: found a vector of length 2.0000"));
        assert!(from_bytes(b"\xc3\x28").unwrap_err().to_string().contains("UTF-8"));
    }

    #[test]
    fn directions_may_be_below_the_horizon() {
        let text = "id,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n7,0,0,1,0,0,-1\n";
        assert_eq!(directions_from_bytes(text.as_bytes()).unwrap(), [([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])]);
    }
}
