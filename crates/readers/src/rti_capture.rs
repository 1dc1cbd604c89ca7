//! Lists of light directions of photographs of one view, `.lp`. Layout: `crates/readers/src/rti_capture.md`.

use super::scan::{number, quoted};
use crate::file_kind::{Begins, FileKind};
use crate::text;
use brdfc_formats::FormatError;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Lists of the lights of an RTI capture.
pub static KIND: FileKind =
    FileKind { description: "the lights of an RTI capture (.lp)", extensions: &["lp"], begins: Begins::Text(is_list) };

/// Maximum number of lights of a capture.
pub const MAX_LIGHTS: usize = 4096;

/// The images of a capture with the directions to their lights, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct LightPositions {
    /// Name of each image as in the file.
    pub names: Vec<String>,
    /// Unit vectors to the lights, z > 0: x to the right of the images, y up, z to the viewer.
    pub directions: Vec<[f32; 3]>,
    /// Line of each light, counted from 1.
    pub lines: Vec<u64>,
}

impl LightPositions {
    /// Parses a file.
    ///
    /// # Errors
    /// Returns an error for text that [`Self::parse`] rejects, NUL bytes, and invalid UTF-8.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::parse(text::checked(bytes)?)
    }

    /// Parses the text of a file: the number of lights, then a line `NAME X Y Z` for each.
    ///
    /// # Errors
    /// Returns an error for no lights, more than [`MAX_LIGHTS`], another number than declared, a line that is not a
    /// name and three finite numbers, vectors of length 0 or at or below the horizon, and an image that is named twice.
    pub fn parse(text: &str) -> Result<Self, FormatError> {
        let mut lines = (1u64..).zip(text.lines()).filter(|(_, content)| !content.trim().is_empty());
        let (first, stated) = lines.next().ok_or_else(|| {
            let allowed = "the number of lights, then a line for each light";
            FormatError::whole("number of lights", "empty file", allowed).problem()
        })?;
        let count = light_count(stated.trim(), first)?;
        let (mut names, mut directions, mut numbers) = (Vec::new(), Vec::new(), Vec::new());
        let mut seen = BTreeMap::new();
        for (line, content) in lines.by_ref().take(count) {
            let (name, direction) = light(content, line)?;
            // Names may contain either separator.
            if let Some(before) = seen.insert(name.replace('\\', "/"), line) {
                let found = format!("{} is already on line {before}", quoted(name));
                return Err(FormatError::at_line(line, "image", found, "each image once").problem());
            }
            names.push(name.to_owned());
            directions.push(direction);
            numbers.push(line);
        }
        let found = directions.len() + lines.count();
        if found != count {
            let allowed = format!("{found}, the number of lines that follow");
            return Err(FormatError::at_line(first, "number of lights", count.to_string(), allowed));
        }
        Ok(Self { names, directions, lines: numbers })
    }

    /// Formats a list of these names and directions; its `lines` are not needed.
    pub fn to_text(names: &[String], directions: &[[f32; 3]]) -> String {
        let mut text = format!("{}\n", directions.len());
        for (name, [x, y, z]) in names.iter().zip(directions) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name} {x} {y} {z}");
        }
        text
    }
}

fn light_count(word: &str, line: u64) -> Result<usize, FormatError> {
    let allowed = || format!("1 to {MAX_LIGHTS}, alone on the first line");
    let wrong = |found: String| FormatError::at_line(line, "number of lights", found, allowed());
    let digits = !word.is_empty() && word.bytes().all(|byte| byte.is_ascii_digit());
    let count = if digits { word.parse::<usize>().ok() } else { None };
    match count {
        Some(count) if (1..=MAX_LIGHTS).contains(&count) => Ok(count),
        _ if digits => Err(wrong(if word.len() > 20 { quoted(word) } else { word.to_owned() })),
        _ => Err(wrong(quoted(word))),
    }
}

/// Name and unit vector of a line. The name is everything before the last three words.
fn light(content: &str, line: u64) -> Result<(&str, [f32; 3]), FormatError> {
    let mut rest = content.trim();
    let mut tokens = [""; 3];
    for slot in tokens.iter_mut().rev() {
        let Some((before, last)) = rest.rsplit_once(|c: char| c.is_whitespace()) else {
            return Err(FormatError::at_line(
                line,
                "light",
                quoted(content.trim()),
                "the name of an image, then x y z",
            ));
        };
        (rest, *slot) = (before.trim_end(), last);
    }
    let mut vector = [0.0; 3];
    for ((component, word), field) in vector.iter_mut().zip(tokens).zip(["x", "y", "z"]) {
        *component = number(word, line, field)?;
    }
    Ok((rest, unit(vector, line)?))
}

fn unit(vector: [f64; 3], line: u64) -> Result<[f32; 3], FormatError> {
    let wrong = |found: &str, allowed| Err(FormatError::at_line(line, "direction", found, allowed).problem());
    let largest = vector.iter().fold(0.0f64, |largest, c| largest.max(c.abs()));
    if largest == 0.0 {
        return wrong("vector of length 0", "any other length");
    }
    // Squares of unscaled vectors may overflow or underflow.
    let scaled = vector.map(|c| c / largest);
    let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
    let direction = scaled.map(|c| (c / length) as f32);
    if direction[2] > 0.0 {
        return Ok(direction);
    }
    wrong(&format!("{} {} {} is at or below the horizon", vector[0], vector[1], vector[2]), "z greater than 0")
}

/// Returns true if text begins like a list of lights: a number alone, then a name and three numbers.
fn is_list(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let (first, second) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
    let words: Vec<bool> = second.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
    first.parse::<u32>().is_ok() && words.len() > 3 && !words[0] && words.ends_with(&[true; 3])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn message(text: &str) -> String {
        LightPositions::parse(text).unwrap_err().to_string()
    }

    #[test]
    fn names_directions_and_lines() {
        let text = "\r\n 3 \r\n\r\na photo 1.jpg 0 0 2\r\n\tfolder\\b.png  3e0 0 4 \r\nc.exr\t-0.6\t0\t+0.8";
        let found = LightPositions::parse(text).unwrap();
        assert_eq!(found.names, ["a photo 1.jpg", "folder\\b.png", "c.exr"]);
        assert_eq!(found.directions, [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.6, 0.0, 0.8]]);
        assert_eq!(found.lines, [4, 5, 6]);
        assert_eq!(LightPositions::from_bytes(format!("\u{feff}{text}").as_bytes()), Ok(found));
    }

    #[test]
    fn lengths_of_vectors_do_not_matter() {
        for scale in ["e-320", "e-200", "", "e200", "e307"] {
            let found = LightPositions::parse(&format!("1\na 3{scale} 0{scale} 4{scale}\n")).unwrap();
            let [x, y, z] = found.directions[0];
            assert!((x - 0.6).abs() < 1e-3 && y == 0.0 && (z - 0.8).abs() < 1e-3, "{scale}: {:?}", found.directions);
        }
        // Coplanar and equal lights are valid here.
        assert!(LightPositions::parse("3\na 0 0 1\nb 0 0.5 1\nc 0 0 1").is_ok());
    }

    #[test]
    fn errors_name_the_line() {
        for (text, expected) in [
            ("", "number of lights: empty file"),
            (" \n\r\n", "number of lights: empty file"),
            ("0\n", "line 1, number of lights: found 0, expected 1 to 4096"),
            ("4097\n", "line 1, number of lights: found 4097, expected 1 to 4096"),
            ("99999999999999999999999999\n", "line 1, number of lights: found \"99999999999999999999999999\""),
            ("-1\n", "line 1, number of lights: found \"-1\""),
            ("+1\na 0 0 1", "line 1, number of lights: found \"+1\""),
            ("1.0\na 0 0 1", "line 1, number of lights: found \"1.0\""),
            ("a.jpg 0 0 1\n", "line 1, number of lights: found \"a.jpg 0 0 1\""),
            ("2\na 0 0 1\n\n", "line 1, number of lights: found 2, expected 1, the number of lines that follow"),
            (
                "\n1\na 0 0 1\nb 0 0 1\nc",
                "line 2, number of lights: found 1, expected 3, the number of lines that follow",
            ),
            ("1\n0 0 1\n", "line 2, light: found \"0 0 1\", expected the name of an image, then x y z"),
            ("1\na 0 zero 1\n", "line 2, y: found \"zero\", expected a finite number"),
            ("1\na 0 0 inf\n", "line 2, z: found \"inf\""),
            ("1\na NaN 0 1\n", "line 2, x: found \"NaN\""),
            ("1\n\na 0 -0 0\n", "line 3, direction: vector of length 0"),
            ("1\na 0 1 0\n", "line 2, direction: 0 1 0 is at or below the horizon; expected z greater than 0"),
            ("1\na 0 1 -0.1\n", "line 2, direction: 0 1 -0.1 is at or below"),
            ("1\na 0 1 1e-50\n", "line 2, direction: 0 1 0.0000"),
            ("2\na 0 0 1\n a 0 1 1\n", "line 3, image: \"a\" is already on line 2; expected each image once"),
            ("2\na\\b.c 0 0 1\na/b.c 0 1 1\n", "line 3, image: \"a/b.c\" is already on line 2"),
        ] {
            assert!(message(text).starts_with(expected), "{text:?}: {}", message(text));
        }
        let message_of = |bytes: &[u8]| LightPositions::from_bytes(bytes).unwrap_err().to_string();
        assert!(message_of(b"1\n\xff\xd8 0 0 1").starts_with("line 2, text: found byte 0xff"));
        assert!(message_of(b"1\n\0").starts_with("line 2, text: NUL byte"));
        let most = (0..MAX_LIGHTS).fold(format!("{MAX_LIGHTS}\n"), |text, k| text + &format!("{k} 0 {k} 1\n"));
        assert_eq!(LightPositions::parse(&most).unwrap().names.len(), MAX_LIGHTS);
    }

    proptest! {
        #[test]
        fn lists_round_trip(
            lights in prop::collection::vec(("[a-z ./\\\\]{0,8}[a-z]", -1e3f64..1e3, -1e3f64..1e3, 1e-3f64..1e3), 1..20),
        ) {
            let names: Vec<String> = (0..).zip(&lights).map(|(k, (name, ..))| format!("{k}{name}")).collect();
            let directions: Vec<[f32; 3]> = lights.iter().map(|(_, x, y, z)| unit([*x, *y, *z], 1).unwrap()).collect();
            let read = LightPositions::parse(&LightPositions::to_text(&names, &directions)).unwrap();
            prop_assert_eq!(&read.names, &names);
            for (read, written) in read.directions.iter().flatten().zip(directions.iter().flatten()) {
                prop_assert!((read - written).abs() <= f32::EPSILON, "{} {}", read, written);
            }
        }

        #[test]
        fn nothing_panics(text in "[0-9a. \n-]{0,60}") {
            if let Ok(read) = LightPositions::parse(&text) {
                prop_assert!(read.directions.iter().all(|d| d[2] > 0.0));
            }
        }
    }
}
