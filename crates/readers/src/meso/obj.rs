//! Reader and writer of polygons in Wavefront OBJ. Layout: `crates/readers/src/meso/spec.md`.

use super::{MAX_COORDINATE, MAX_TRIANGLES, MAX_VERTICES, TriangleMesh, is_coordinate};
use crate::colour::{decode_srgb, encode_srgb};
use crate::file_kind::{Begins, FileKind, begins_with, first_line};
use crate::scan::{number, quoted};
use crate::text;
use brdfc_formats::FormatError;
use brdfc_formats::memory::push_within;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;

/// Meshes as OBJ: text whose first line is a statement of OBJ.
pub static KIND: FileKind = FileKind {
    description: "a mesh (.obj)",
    extensions: &["obj"],
    begins: Begins::Text(|text| begins_with(first_line(text), &["v ", "vn ", "vt ", "o ", "g ", "mtllib ", "usemtl "])),
};

/// Name of the material of faces before the first `usemtl`, if other faces have one.
pub const DEFAULT_MATERIAL: &str = "default";

/// Keywords whose lines do not change the surface.
const IGNORED: [&str; 19] = [
    "vt",
    "vn",
    "vp",
    "g",
    "o",
    "s",
    "mg",
    "mtllib",
    "maplib",
    "usemap",
    "l",
    "p",
    "lod",
    "bevel",
    "c_interp",
    "d_interp",
    "shadow_obj",
    "trace_obj",
    "csh",
];

/// Parses an OBJ.
///
/// # Errors
/// Returns an error for invalid text, unknown keywords (including free-form surfaces), numbers that do not parse or are
/// out of range, indices without a vertex, faces with fewer than three corners, no faces, colours at some vertices
/// only, and more than [`MAX_VERTICES`] or [`MAX_TRIANGLES`].
pub fn from_bytes(bytes: &[u8]) -> Result<TriangleMesh, FormatError> {
    let mut reader = Reader::default();
    let mut lines = (1u64..).zip(text::checked(bytes)?.lines());
    while let Some((line, content)) = lines.next() {
        let mut content = Cow::Borrowed(content);
        // A backslash at the end joins a line to the next one.
        while content.ends_with('\\') && !content.starts_with('#') {
            let joined = content.to_mut();
            joined.pop();
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, next)| next));
            if joined.len() > text::MAX_LINE_BYTES {
                return Err(text::too_long_at(line));
            }
        }
        reader.line(line, content.trim())?;
    }
    reader.finish()
}

#[derive(Default)]
struct Reader {
    mesh: TriangleMesh,
    /// Indices into the names; faces without one have [`DEFAULT_MATERIAL`].
    names: BTreeMap<String, u32>,
    /// Material of the last `usemtl`.
    current: Option<String>,
    named: bool,
    /// Highest index of a vertex that is not defined yet, counted from 1, and its line.
    ahead: (u64, u64),
    corners: Vec<u32>,
}

impl Reader {
    fn line(&mut self, line: u64, content: &str) -> Result<(), FormatError> {
        let (keyword, rest) = content.split_once(|c: char| c.is_ascii_whitespace()).unwrap_or((content, ""));
        match keyword {
            "v" => self.vertex(line, without_comment(rest)),
            "f" | "fo" => self.face(line, without_comment(rest)),
            "usemtl" => {
                let name = rest.trim();
                self.current = (!name.is_empty()).then(|| name.to_owned());
                Ok(())
            }
            _ if keyword.is_empty() || keyword.starts_with('#') || IGNORED.contains(&keyword) => Ok(()),
            _ => Err(FormatError::at_line(
                line,
                "keyword",
                quoted(keyword),
                format!("v, f, usemtl; skipped: {}", IGNORED.join(", ")),
            )),
        }
    }

    fn vertex(&mut self, line: u64, rest: &str) -> Result<(), FormatError> {
        let mut numbers = [0.0; 7];
        let mut count = 0;
        for token in rest.split_ascii_whitespace() {
            let value = number(token, line, if count < 3 { "coordinate" } else { "colour" })?;
            if let Some(slot) = numbers.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        if ![3, 4, 6, 7].contains(&count) {
            let allowed = "3 (x y z), 4 (x y z w), 6 (x y z r g b) or 7 (x y z r g b a)";
            return Err(FormatError::at_line(line, "vertex", format!("{count} numbers"), allowed));
        }
        // The opacity does not count.
        let [x, y, z, r, g, b, _] = numbers;
        if let Some(wrong) = [x, y, z].iter().find(|c| !is_coordinate(**c)) {
            let allowed = format!("-{MAX_COORDINATE:e} to {MAX_COORDINATE:e}");
            return Err(FormatError::at_line(line, "coordinate", wrong.to_string(), allowed));
        }
        let coloured = count >= 6;
        if !self.mesh.positions.is_empty() && coloured == self.mesh.colours.is_empty() {
            let found =
                if coloured { "colour after vertices without colours" } else { "no colour after coloured vertices" };
            return Err(FormatError::at_line(line, "vertex", found, "colours at all vertices or at none").problem());
        }
        if coloured {
            if let Some(wrong) = [r, g, b].iter().find(|c| !(0.0..=1.0).contains(*c)) {
                return Err(FormatError::at_line(line, "colour", wrong.to_string(), "0 to 1"));
            }
            self.mesh.colours.push([r, g, b].map(|c| decode_srgb(c).clamp(0.0, 1.0) as f32));
        }
        push_within(&mut self.mesh.positions, [x, y, z], MAX_VERTICES, "vertices")
    }

    fn face(&mut self, line: u64, rest: &str) -> Result<(), FormatError> {
        self.corners.clear();
        for token in rest.split_ascii_whitespace() {
            let corner = self.corner(line, token)?;
            self.corners.push(corner);
        }
        if self.corners.len() < 3 {
            return Err(FormatError::at_line(line, "face", format!("{} corners", self.corners.len()), "3 or more"));
        }
        self.named |= self.current.is_some();
        let name = self.current.as_deref().unwrap_or(DEFAULT_MATERIAL);
        let material = match self.names.get(name) {
            Some(index) => *index,
            None => {
                let index = self.mesh.materials.len() as u32;
                self.names.insert(name.to_owned(), index);
                self.mesh.materials.push(name.to_owned());
                index
            }
        };
        for pair in self.corners[1..].windows(2) {
            push_within(&mut self.mesh.triangles, [self.corners[0], pair[0], pair[1]], MAX_TRIANGLES, "triangles")?;
            push_within(&mut self.mesh.triangle_materials, material, MAX_TRIANGLES, "triangles")?;
        }
        Ok(())
    }

    /// Index of the vertex in `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, line: u64, token: &str) -> Result<u32, FormatError> {
        let known = self.mesh.positions.len() as i64;
        let index = token.split('/').next().and_then(|v| v.parse::<i64>().ok());
        let place = match index {
            Some(index) if index > 0 => index - 1,
            Some(index) if (-known..0).contains(&index) => known + index,
            _ => {
                let allowed = match index {
                    Some(index) if index < 0 => format!("-1 to -{known}, counted back from the last vertex"),
                    _ => "a number of a vertex, counted from 1".to_owned(),
                };
                return Err(FormatError::at_line(line, "face", quoted(token), allowed));
            }
        };
        if place >= known && place as u64 >= self.ahead.0 {
            self.ahead = (place as u64 + 1, line);
        }
        // An index that does not fit exceeds the number of vertices, and is rejected at the end.
        Ok(place as u32)
    }

    fn finish(mut self) -> Result<TriangleMesh, FormatError> {
        let vertices = self.mesh.positions.len();
        let (highest, line) = self.ahead;
        if highest > vertices as u64 {
            let allowed = format!("1 to {vertices}, the number of vertices");
            return Err(FormatError::at_line(line, "face", format!("vertex {highest}"), allowed));
        }
        if self.mesh.triangles.is_empty() {
            let found = format!("no faces, and {vertices} vertices");
            return Err(FormatError::whole("faces", found, "at least one face").problem());
        }
        if !self.named {
            self.mesh.materials.clear();
            self.mesh.triangle_materials.clear();
        }
        Ok(self.mesh)
    }
}

fn without_comment(text: &str) -> &str {
    text.split('#').next().unwrap_or("")
}

/// Writes a mesh. Positions round-trip exactly, colours up to rounding. Names of materials must be single words.
///
/// # Errors
/// Returns errors of `output`.
///
/// # Panics
/// May panic if the mesh does not pass [`TriangleMesh::check`].
pub fn write(output: &mut impl Write, mesh: &TriangleMesh) -> std::io::Result<()> {
    for (index, [x, y, z]) in mesh.positions.iter().enumerate() {
        write!(output, "v {x:?} {y:?} {z:?}")?;
        if let Some(colour) = mesh.colours.get(index) {
            let [r, g, b] = colour.map(|c| encode_srgb(f64::from(c)));
            write!(output, " {r:.7} {g:.7} {b:.7}")?;
        }
        writeln!(output)?;
    }
    let mut current = None;
    for (index, triangle) in mesh.triangles.iter().enumerate() {
        let material = mesh.triangle_materials.get(index);
        if material != current {
            current = material;
            writeln!(output, "usemtl {}", current.map_or("", |m| &mesh.materials[*m as usize]))?;
        }
        let [a, b, c] = triangle.map(|v| u64::from(v) + 1);
        writeln!(output, "f {a} {b} {c}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meso::testing::{meshes, mutate};
    use proptest::prelude::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\n";

    fn read(text: &str) -> TriangleMesh {
        from_bytes(text.as_bytes()).unwrap()
    }

    fn message(text: &str) -> String {
        from_bytes(text.as_bytes()).unwrap_err().to_string()
    }

    #[test]
    fn a_polygon_becomes_a_fan() {
        let mesh = read(&format!("# made by hand\n{SQUARE}f 1 2 3 4\n"));
        assert_eq!(mesh.positions[3], [0.0, 1.0, 0.5]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh.materials.is_empty() && mesh.triangle_materials.is_empty() && mesh.colours.is_empty());
    }

    #[test]
    fn all_ways_to_write_a_face_are_one() {
        for face in [
            "f 1 2 3",
            "f 1/1 2/2 3/3",
            "f 1//1 2//1 3//1",
            "f 1/1/1 2/2/2 3/3/3",
            "f -4 -3 -2",
            "f 1 2 \\\n 3 # last",
            "fo 1 2 3",
            "vt 0 0\nvn 0 0 1\ng a b\no x\ns off\nmtllib x.mtl\nl 1 2\n\n\tf 1 2 3",
        ] {
            assert_eq!(read(&format!("{SQUARE}{face}\n")).triangles, [[0, 1, 2]], "{face}");
        }
        let before = format!("f 1 2 3\n{SQUARE}");
        assert_eq!(read(&before).triangles, [[0, 1, 2]], "faces may come first");
        assert_eq!(read(&before.replace('\n', "\r\n")).triangles, [[0, 1, 2]]);
    }

    #[test]
    fn a_comment_ends_with_its_line() {
        assert_eq!(read(&format!("{SQUARE}# C:\\meshes\\\nf 1 2 3")).triangles.len(), 1);
        assert_eq!(read(&format!("{SQUARE}f 1 2 \\\n\\\n3 \\")).triangles.len(), 1, "other lines go on");
    }

    #[test]
    fn materials_are_listed_as_faces_use_them() {
        let mesh = read(&format!(
            "{SQUARE}usemtl none uses this\nusemtl red wool\nf 1 2 3\nusemtl b\nf 1 2 3 4\nusemtl red wool\nf 1 2 3"
        ));
        assert_eq!(mesh.materials, ["red wool", "b"]);
        assert_eq!(mesh.triangle_materials, [0, 1, 1, 0]);
        let mesh = read(&format!("{SQUARE}f 1 2 3\nusemtl b\nf 1 2 3"));
        assert_eq!(mesh.materials, [DEFAULT_MATERIAL, "b"]);
    }

    /// Some scanners write an opacity after the colour.
    #[test]
    fn opacities_are_ignored() {
        let rows = |more: &str| format!("v 0 0 0 0 0.5 1{more}\nv 1 0 0 0 0 0{more}\nv 0 1 0 1 1 1{more}\nf 1 2 3\n");
        let [plain, with] = ["", " 0.25"].map(|more| from_bytes(rows(more).as_bytes()).unwrap());
        assert_eq!((plain.positions, plain.colours), (with.positions, with.colours));
        assert!(from_bytes(rows(" 1 1").as_bytes()).is_err());
    }

    #[test]
    fn colours_become_linear() {
        let mesh = read("v 0 0 0 0 0.5 1\nv 0 0 0 0 0 0\nf 1 2 1");
        assert_eq!((mesh.colours[0][0], mesh.colours[0][2]), (0.0, 1.0));
        assert!((mesh.colours[0][1] - 0.214_041).abs() < 1e-6);
        assert_eq!(read("v 0 0 0 2\nf 1 1 1").colours.len(), 0, "a weight is no colour");
    }

    #[test]
    fn errors_name_the_line() {
        assert_eq!(message(""), "faces: no faces, and 0 vertices; expected at least one face");
        assert!(message(SQUARE).contains("no faces, and 4 vertices"));
        assert_eq!(
            message("v 0 0\n"),
            "line 1, vertex: found 2 numbers, expected 3 (x y z), 4 (x y z w), 6 (x y z r g b) or 7 (x y z r g b a)"
        );
        assert!(message("\nv 0 nan 0\n").starts_with("line 2, coordinate: found \"nan\", expected a finite number"));
        assert!(message("v 0 inf 0\n").contains("line 1, coordinate: found \"inf\""));
        assert!(message("v 0 1e13 0\n").contains("-1e12 to 1e12"));
        assert!(message("v 0 0 0 0 0 256\n").contains("line 1, colour: found 256, expected 0 to 1"));
        assert!(message("v 0 0 0\nv 0 0 0 0 0 0\n").contains("line 2, vertex: colour after"));
        assert!(message("v 0 0 0 0 0 0\nv 0 0 0\n").contains("line 2, vertex: no colour after"));
        assert_eq!(
            message(&format!("{SQUARE}f 1 2 3\nf 1 7 3\nf 1 5 3")),
            "line 6, face: found vertex 7, expected 1 to 4, the number of vertices"
        );
        assert!(
            message(&format!("{SQUARE}f 1 0 3")).contains("line 5, face: found \"0\", expected a number of a vertex")
        );
        assert!(message(&format!("{SQUARE}f 1 -5 3")).contains("found \"-5\", expected -1 to -4"));
        assert!(message(&format!("{SQUARE}f 1 x 3")).contains("found \"x\""));
        assert!(message(&format!("{SQUARE}f 1 2")).contains("line 5, face: found 2 corners, expected 3 or more"));
        assert!(message(&format!("{SQUARE}f 1 2 99999999999")).contains("vertex 99999999999"));
        assert!(message(&format!("{SQUARE}f 1 2 99999999999999999999")).contains("found \"99999999999999999999\""));
        assert!(message("cstype bezier\n").starts_with("line 1, keyword: found \"cstype\", expected v, f, usemtl"));
        assert!(from_bytes(b"v 0 0 0\n# \xff").unwrap_err().to_string().starts_with("line 2, text: found byte 0xff"));
    }

    #[test]
    fn no_change_of_bytes_panics() {
        let text =
            "v 0 0 0 0 0.5 1\nv 1 0 0 0 0 0\nv -1.5e3 1 0 1 1 1\nusemtl a\nf 1 2 3 1\nusemtl b\nf -1/1 -2//3 1\n";
        mutate(text.as_bytes(), from_bytes);
    }

    proptest! {
        #[test]
        fn meshes_round_trip(mesh in meshes(), materials in prop::collection::vec(0u32..3, 30)) {
            let mut mesh = mesh;
            // Names are numbered as triangles use them.
            let mut order = Vec::new();
            for material in &materials[..mesh.triangles.len()] {
                let index = order.iter().position(|m| m == material).unwrap_or_else(|| {
                    order.push(*material);
                    mesh.materials.push(format!("m{material}"));
                    order.len() - 1
                });
                mesh.triangle_materials.push(index as u32);
            }
            let mut bytes = Vec::new();
            write(&mut bytes, &mesh).unwrap();
            let read = from_bytes(&bytes).unwrap();
            prop_assert_eq!(&read.positions, &mesh.positions);
            prop_assert_eq!(&read.triangles, &mesh.triangles);
            prop_assert_eq!((&read.materials, &read.triangle_materials), (&mesh.materials, &mesh.triangle_materials));
            prop_assert_eq!(read.colours.len(), mesh.colours.len());
            for (read, written) in read.colours.iter().flatten().zip(mesh.colours.iter().flatten()) {
                prop_assert!((read - written).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn joined_lines_have_an_end() {
        let text = format!("v 0 0 \\\n{}0\n", " \\\n".repeat(9 << 20));
        let error = from_bytes(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(error, "line 1, text: line of more than 16.00 MiB; expected at most 16777216 bytes");
    }
}
