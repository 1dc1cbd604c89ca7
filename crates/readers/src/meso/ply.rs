//! Reader and writer of PLY, ascii and binary in either byte order. Layout: `crates/readers/src/meso/spec.md`.

mod header;

use super::{MAX_COORDINATE, MAX_TRIANGLES, MAX_VERTICES, TriangleMesh, is_coordinate};
use crate::colour::decode_srgb;
use crate::file_kind::{Begins, FileKind};
use crate::scan::quoted;
use brdfc_formats::FormatError;
use brdfc_formats::cursor::Cursor;
use brdfc_formats::memory::{push_within, reserved};
use header::{Element, Encoding, Header, Kind, Scalar};
use std::io::Write;

/// Meshes as PLY: the first line is `ply`.
pub static KIND: FileKind =
    FileKind { description: "a mesh (.ply)", extensions: &["ply"], begins: Begins::With(&[b"ply\n", b"ply\r"]) };

/// Parses a PLY.
///
/// # Errors
/// Returns an error for headers that violate the layout, no `vertex` with x, y and z, no `face` with a list of
/// vertices, fewer or more data than the header declares, numbers and indices out of range, no faces, and more than
/// [`MAX_VERTICES`] or [`MAX_TRIANGLES`].
pub fn from_bytes(bytes: &[u8]) -> Result<TriangleMesh, FormatError> {
    let header = Header::from_bytes(bytes)?;
    let layout = VertexLayout::find(header.element("vertex")?)?;
    let list = find_list(header.element("face")?)?;
    let mut values = Values::start(bytes, &header)?;
    let mut mesh = TriangleMesh::default();
    for element in &header.elements {
        let most = values.check_room(element)?;
        match element.name.as_str() {
            "vertex" => read_vertices(&mut values, element, &layout, most, &mut mesh)?,
            "face" => read_faces(&mut values, element, list, header.element("vertex")?.count, &mut mesh)?,
            _ => skip(&mut values, element)?,
        }
    }
    values.finish()?;
    if mesh.triangles.is_empty() {
        let found = format!("no faces, and {} vertices", mesh.positions.len());
        return Err(FormatError::whole("faces", found, "at least one face").problem());
    }
    Ok(mesh)
}

/// Names of the properties of a colour.
const COLOURS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

fn listed([r, g, b]: &[&str; 3]) -> String {
    format!("{r}, {g} and {b}")
}

/// Indices of the properties of a vertex.
struct VertexLayout {
    position: [usize; 3],
    colour: Option<[usize; 3]>,
    encoded: bool,
}

impl VertexLayout {
    fn find(element: &Element) -> Result<Self, FormatError> {
        let scalar =
            |name: &str| element.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::Scalar(_)));
        let [x, y, z] = ["x", "y", "z"].map(scalar);
        let (Some(x), Some(y), Some(z)) = (x, y, z) else {
            let found = element.properties.iter().map(|p| p.name.as_str()).collect::<Vec<_>>().join(" ");
            let wrong =
                |found: String| FormatError::at_line(element.line, "vertex", found, "scalar properties x, y and z");
            return Err(match found.is_empty() {
                true => wrong("no properties".to_owned()).problem(),
                false => wrong(quoted(&found)),
            });
        };
        let mut layout = Self { position: [x, y, z], colour: None, encoded: false };
        let complete = |names: &[&'static str; 3]| names.iter().all(|name| scalar(name).is_some());
        let partial = |names: &&[&'static str; 3]| names.iter().any(|name| scalar(name).is_some());
        if let Some(names) = COLOURS.iter().find(|names| complete(names)) {
            let [r, g, b] = names.map(|name| scalar(name).unwrap_or_default());
            layout.colour = Some([r, g, b]);
            let kinds = [r, g, b].map(|k| element.properties[k].kind);
            layout.encoded = kinds == [Kind::Scalar(Scalar::U8); 3];
            let float = |kind| matches!(kind, Kind::Scalar(Scalar::F32 | Scalar::F64));
            if !layout.encoded && !kinds.into_iter().all(float) {
                let line = element.properties[r].line;
                let found = format!("{} have other types", listed(names));
                let allowed = "all three uchar, or all float or double";
                return Err(FormatError::at_line(line, "colour", found, allowed).problem());
            }
        } else if let Some(names) = COLOURS.iter().find(partial) {
            let found = format!("only some of {}", listed(names));
            return Err(FormatError::at_line(element.line, "vertex", found, "all three or none").problem());
        }
        Ok(layout)
    }
}

/// Finds the property of a face that lists its vertices.
fn find_list(element: &Element) -> Result<usize, FormatError> {
    let found = element.properties.iter().position(|p| ["vertex_indices", "vertex_index"].contains(&p.name.as_str()));
    let property = found.map(|index| &element.properties[index]);
    match property.map(|p| p.kind) {
        Some(Kind::List(count, item)) if count.is_integer() && item.is_integer() => Ok(found.unwrap_or_default()),
        kind => Err(FormatError::at_line(
            property.map_or(element.line, |p| p.line),
            "face",
            if kind.is_some() { "vertex indices have another type" } else { "no list of vertices" },
            "property list TYPE TYPE vertex_indices, of integer types",
        )
        .problem()),
    }
}

fn read_vertices(
    values: &mut Values<'_>,
    element: &Element,
    layout: &VertexLayout,
    most: usize,
    mesh: &mut TriangleMesh,
) -> Result<(), FormatError> {
    if most > MAX_VERTICES {
        let allowed = format!("at most {MAX_VERTICES}");
        return Err(FormatError::at_line(element.line, "vertices", most.to_string(), allowed));
    }
    mesh.positions = reserved("vertices", most)?;
    let mut row = vec![0.0; element.properties.len()];
    for _ in 0..element.count {
        for (slot, property) in row.iter_mut().zip(&element.properties) {
            match property.kind {
                Kind::Scalar(scalar) => *slot = values.scalar(scalar, "vertex")?,
                Kind::List(count, item) => values.skip_list(count, item)?,
            }
        }
        let position = layout.position.map(|k| row[k]);
        if let Some(wrong) = position.iter().find(|c| !is_coordinate(**c)) {
            let allowed = format!("-{MAX_COORDINATE:e} to {MAX_COORDINATE:e}");
            return Err(values.error("coordinate", wrong.to_string(), allowed));
        }
        mesh.positions.push(position);
        if let Some(colour) = layout.colour {
            let colour = colour.map(|k| row[k]);
            if layout.encoded {
                mesh.colours.push(colour.map(|c| decode_srgb(c / 255.0).clamp(0.0, 1.0) as f32));
            } else if let Some(wrong) = colour.iter().find(|c| !(0.0..=1.0).contains(*c)) {
                return Err(values.error("colour", wrong.to_string(), "0 to 1"));
            } else {
                mesh.colours.push(colour.map(|c| c as f32));
            }
        }
    }
    Ok(())
}

fn read_faces(
    values: &mut Values<'_>,
    element: &Element,
    list: usize,
    vertices: u64,
    mesh: &mut TriangleMesh,
) -> Result<(), FormatError> {
    for _ in 0..element.count {
        for (index, property) in element.properties.iter().enumerate() {
            match property.kind {
                Kind::Scalar(scalar) => drop(values.scalar(scalar, "face")?),
                Kind::List(count, item) if index == list => {
                    let corners = values.list_length(count, item)?;
                    if corners < 3 {
                        return Err(values.error("face", format!("{corners} corners"), "3 or more"));
                    }
                    let mut vertex = || {
                        let index = values.scalar(item, "vertex index")?;
                        if index >= 0.0 && index < vertices as f64 {
                            return Ok(index as u32);
                        }
                        let allowed = format!("0 or more, below {vertices}, the number of vertices");
                        Err(values.error("vertex index", index.to_string(), allowed))
                    };
                    let (first, mut last) = (vertex()?, vertex()?);
                    for _ in 2..corners {
                        let next = vertex()?;
                        push_within(&mut mesh.triangles, [first, last, next], MAX_TRIANGLES, "triangles")?;
                        last = next;
                    }
                }
                Kind::List(count, item) => values.skip_list(count, item)?,
            }
        }
    }
    Ok(())
}

fn skip(values: &mut Values<'_>, element: &Element) -> Result<(), FormatError> {
    // Rows without properties have no data, for any number of rows.
    if element.properties.is_empty() {
        return Ok(());
    }
    for _ in 0..element.count {
        for property in &element.properties {
            match property.kind {
                Kind::Scalar(scalar) => drop(values.scalar(scalar, "element")?),
                Kind::List(count, item) => values.skip_list(count, item)?,
            }
        }
    }
    Ok(())
}

/// Reader of the numbers after the header.
enum Values<'a> {
    Ascii { lines: std::str::Lines<'a>, tokens: std::str::SplitAsciiWhitespace<'a>, line: u64, left: usize },
    Binary { cursor: Cursor<'a>, big_endian: bool },
}

impl<'a> Values<'a> {
    fn start(bytes: &'a [u8], header: &Header) -> Result<Self, FormatError> {
        if let Encoding::Binary { big_endian } = header.encoding {
            let mut cursor = Cursor::new(bytes);
            cursor.take(header.length, "header")?;
            return Ok(Self::Binary { cursor, big_endian });
        }
        let body = &bytes[header.length..];
        let text = std::str::from_utf8(body).map_err(|error| {
            let good = &body[..error.valid_up_to()];
            let line = header.lines + 1 + good.iter().filter(|byte| **byte == b'\n').count() as u64;
            FormatError::at_line(line, "text", format!("byte {:#04x}", body[error.valid_up_to()]), "UTF-8")
        })?;
        let tokens = "".split_ascii_whitespace();
        Ok(Self::Ascii { lines: text.lines(), tokens, line: header.lines, left: text.len() })
    }

    /// Creates an error at the current position.
    fn error(&self, field: &'static str, found: impl Into<String>, allowed: impl Into<String>) -> FormatError {
        match self {
            Self::Ascii { line, .. } => FormatError::at_line(*line, field, found, allowed),
            Self::Binary { cursor, .. } => FormatError::at_byte(cursor.position(), field, found, allowed),
        }
    }

    /// Number of rows of an element, checked against the remaining data.
    fn check_room(&self, element: &Element) -> Result<usize, FormatError> {
        let (row, left) = match self {
            // At least a digit and a space each.
            Self::Ascii { left, .. } => (2 * element.properties.len() as u64, *left as u64 + 1),
            Self::Binary { cursor, .. } => {
                (element.properties.iter().map(|p| p.least_bytes()).sum(), cursor.remaining() as u64)
            }
        };
        if row == 0 || element.count <= left / row {
            return Ok(element.count as usize);
        }
        let found = format!("{} rows of {} or more", element.count, element.name);
        Err(self.error("element count", found, format!("at most {}, limited by the remaining data", left / row)))
    }

    fn scalar(&mut self, scalar: Scalar, field: &'static str) -> Result<f64, FormatError> {
        match self {
            Self::Binary { cursor, big_endian } => {
                let size = scalar.size();
                let mut bytes = [0; 8];
                bytes[..size].copy_from_slice(cursor.take(size, field)?);
                if *big_endian {
                    bytes[..size].reverse();
                }
                Ok(scalar.decode(bytes))
            }
            Self::Ascii { lines, tokens, line, left } => {
                let token = loop {
                    if let Some(token) = tokens.next() {
                        break token;
                    }
                    let Some(next) = lines.next() else {
                        return Err(FormatError::at_line(*line, field, "end of data", "a number").problem());
                    };
                    *line += 1;
                    *tokens = next.split_ascii_whitespace();
                };
                *left = left.saturating_sub(token.len() + 1);
                let value = token.parse::<f64>().ok().filter(|value| scalar.holds(*value));
                value.ok_or_else(|| FormatError::at_line(*line, field, quoted(token), scalar.allowed()))
            }
        }
    }

    /// Length of a list, checked against the remaining data.
    fn list_length(&mut self, count: Scalar, item: Scalar) -> Result<u64, FormatError> {
        let length = self.scalar(count, "list length")?;
        let room = match self {
            Self::Binary { cursor, .. } => cursor.remaining() / item.size(),
            Self::Ascii { .. } => u32::MAX as usize,
        };
        if length >= 0.0 && length <= room as f64 && length.fract() == 0.0 {
            return Ok(length as u64);
        }
        Err(self.error("list length", length.to_string(), format!("0 to {room}, limited by the remaining data")))
    }

    fn skip_list(&mut self, count: Scalar, item: Scalar) -> Result<(), FormatError> {
        let length = self.list_length(count, item)?;
        if let Self::Binary { cursor, .. } = self {
            cursor.take(length as usize * item.size(), "list")?;
            return Ok(());
        }
        (0..length).try_for_each(|_| self.scalar(item, "list").map(drop))
    }

    fn finish(mut self) -> Result<(), FormatError> {
        let found = match &mut self {
            Self::Binary { cursor, .. } => (cursor.remaining() > 0).then(|| format!("{} bytes", cursor.remaining())),
            Self::Ascii { lines, tokens, .. } => {
                tokens.next().or_else(|| lines.flat_map(str::split_ascii_whitespace).next()).map(quoted)
            }
        };
        match found {
            Some(found) => Err(self.error("end of data", found, "nothing after the last element")),
            None => Ok(()),
        }
    }
}

/// Writes a mesh as little-endian binary with double coordinates and linear float colours, without materials.
///
/// # Errors
/// Returns errors of `output`.
pub fn write(output: &mut impl Write, mesh: &TriangleMesh) -> std::io::Result<()> {
    let coloured = !mesh.colours.is_empty();
    writeln!(output, "ply\nformat binary_little_endian 1.0\nelement vertex {}", mesh.positions.len())?;
    ["x", "y", "z"].iter().try_for_each(|name| writeln!(output, "property double {name}"))?;
    if coloured {
        ["red", "green", "blue"].iter().try_for_each(|name| writeln!(output, "property float {name}"))?;
    }
    writeln!(output, "element face {}", mesh.triangles.len())?;
    writeln!(output, "property list uchar uint vertex_indices\nend_header")?;
    for (index, position) in mesh.positions.iter().enumerate() {
        position.iter().try_for_each(|c| output.write_all(&c.to_le_bytes()))?;
        if coloured {
            mesh.colours[index].iter().try_for_each(|c| output.write_all(&c.to_le_bytes()))?;
        }
    }
    for triangle in &mesh.triangles {
        output.write_all(&[3])?;
        triangle.iter().try_for_each(|v| output.write_all(&v.to_le_bytes()))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
