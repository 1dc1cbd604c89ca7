//! Lists of directions or positions of lights of photographs of one view, `.lp`. Layout: `crates/readers/src/rti_capture.md`.

use super::scan::{has_decimal_comma, quoted};
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

/// Line of a list whose vectors are positions of near lights.
pub const POSITIONS: &str = "# positions in image widths";

/// The images of a capture with the directions to their lights, in the order of the file.
#[derive(Debug, Clone, PartialEq)]
pub struct LightPositions {
    /// Name of each image as in the file, without quotation marks around it.
    pub names: Vec<String>,
    /// Unit vectors to the lights: x to the right of the images, y up, z to the viewer. Those with z of at most 0 are
    /// behind the plane of the images, but not all are.
    pub directions: Vec<[f32; 3]>,
    /// Line of each light, counted from 1.
    pub lines: Vec<u64>,
    /// Number of lights that the file states, if it does.
    pub stated: Option<usize>,
    /// Names and lines of images whose vector is not finite.
    pub not_finite: Vec<(String, u64)>,
    /// Positions of near lights, if the list has the line [`POSITIONS`]: from the middle of the images, in widths of them.
    pub positions: Option<Vec<[f64; 3]>>,
}

impl LightPositions {
    /// Parses a file.
    ///
    /// # Errors
    /// Returns an error for text that [`Self::parse`] rejects, NUL bytes, and UTF-16.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::parse(&text::of_any_editor(bytes)?)
    }

    /// Parses the text of a file: the number of lights, which may be missing or wrong, then a line `NAME X Y Z` for
    /// each. Comments begin with `#`; one of them may be [`POSITIONS`]. Numbers may have a decimal comma.
    ///
    /// # Errors
    /// Returns an error for no lights with finite numbers, more than [`MAX_LIGHTS`], a line that is not a name and three numbers,
    /// vectors of length 0, no light above the horizon, and an image that is named twice.
    pub fn parse(text: &str) -> Result<Self, FormatError> {
        let mut are_near = false;
        for (line, content) in (1u64..).zip(text.lines()).filter(|(_, content)| is_comment(content)) {
            are_near |= states_positions(content, line)?;
        }
        let is_other = |(_, content): &(u64, &str)| !content.trim().is_empty() && !is_comment(content);
        let mut lines = (1u64..).zip(text.lines()).filter(is_other).peekable();
        let (first, content) = *lines.peek().ok_or_else(|| {
            let allowed = "the number of lights, then a line for each light";
            FormatError::whole("number of lights", "empty file", allowed).problem()
        })?;
        let stated = if is_light(content) { None } else { Some(light_count(content.trim(), first)?) };
        let positions = are_near.then(Vec::new);
        let mut list = Self {
            names: Vec::new(),
            directions: Vec::new(),
            lines: Vec::new(),
            stated,
            not_finite: Vec::new(),
            positions,
        };
        let mut seen = BTreeMap::new();
        for (line, content) in lines.skip(usize::from(stated.is_some())) {
            if list.names.len() + list.not_finite.len() == MAX_LIGHTS {
                let allowed = format!("at most {MAX_LIGHTS} lights");
                return Err(FormatError::at_line(line, "light", "too many lights", allowed).problem());
            }
            let (name, vector) = light(content, line)?;
            // Names may contain either separator.
            if let Some(before) = seen.insert(name.replace('\\', "/"), line) {
                let found = format!("{} is already on line {before}", quoted(name));
                return Err(FormatError::at_line(line, "image", found, "each image once").problem());
            }
            if !vector.iter().all(|c| c.is_finite()) {
                list.not_finite.push((name.to_owned(), line));
                continue;
            }
            list.names.push(name.to_owned());
            list.directions.push(unit(vector, line)?);
            list.positions.iter_mut().for_each(|positions| positions.push(vector));
            list.lines.push(line);
        }
        if let ([], Some((_, line))) = (&list.lines[..], list.not_finite.first()) {
            let found = "no finite vector in the list";
            return Err(FormatError::at_line(*line, "direction", found, "three finite numbers").problem());
        }
        let Some(line) = list.lines.first() else {
            return Err(
                FormatError::at_line(first, "lights", "no lines after the first", "a line for each light").problem()
            );
        };
        if !list.directions.iter().any(is_above) {
            let [x, y, z] = list.directions[0];
            let found = format!("{x} {y} {z} is at or below the horizon, like all lights of the list");
            return Err(FormatError::at_line(*line, "direction", found, "z greater than 0").problem());
        }
        Ok(list)
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

/// Name and vector of a line. The name is everything before the last three words, with or without quotation marks.
fn light(content: &str, line: u64) -> Result<(&str, [f64; 3]), FormatError> {
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
        *component = component_of(word, line, field)?;
    }
    let name = rest.strip_prefix('"').and_then(|name| name.strip_suffix('"')).filter(|name| !name.is_empty());
    Ok((name.unwrap_or(rest), vector))
}

/// A number with a decimal point or a comma.
fn component_of(word: &str, line: u64, field: &'static str) -> Result<f64, FormatError> {
    let wrong = || FormatError::at_line(line, field, quoted(word), "a number");
    let with_point = if has_decimal_comma(word) { word.replacen(',', ".", 1) } else { word.to_owned() };
    with_point.parse().map_err(|_| wrong())
}

/// Returns true if a line is a comment; names of images may begin with the same character.
fn is_comment(content: &str) -> bool {
    content.trim_start().starts_with('#') && !is_light(content)
}

/// Returns true if a comment is [`POSITIONS`].
///
/// # Errors
/// Returns an error for other comments about positions, such as those in other units.
fn states_positions(content: &str, line: u64) -> Result<bool, FormatError> {
    let is_between = |c: char| c.is_whitespace() || c == '#' || c == '.';
    let words = |text: &str| -> Vec<String> {
        text.split(is_between).filter(|word| !word.is_empty()).map(str::to_lowercase).collect()
    };
    let found = words(content);
    if found == words(POSITIONS) {
        return Ok(true);
    }
    if found.first().is_some_and(|word| word == "positions") {
        return Err(FormatError::at_line(line, "positions", quoted(content.trim()), quoted(POSITIONS)));
    }
    Ok(false)
}

/// Returns true if a line ends with three numbers after a name.
fn is_light(content: &str) -> bool {
    let words: Vec<bool> = content.split_whitespace().map(is_number).collect();
    words.len() > 3 && words.ends_with(&[true; 3])
}

/// Returns true for numbers with a decimal point or a comma.
fn is_number(word: &str) -> bool {
    word.parse::<f64>().is_ok() || has_decimal_comma(word)
}

fn unit(vector: [f64; 3], line: u64) -> Result<[f32; 3], FormatError> {
    let largest = vector.iter().fold(0.0f64, |largest, c| largest.max(c.abs()));
    if largest == 0.0 {
        return Err(FormatError::at_line(line, "direction", "vector of length 0", "any other length").problem());
    }
    // Squares of unscaled vectors may overflow or underflow.
    let scaled = vector.map(|c| c / largest);
    let length = scaled.iter().map(|c| c * c).sum::<f64>().sqrt();
    Ok(scaled.map(|c| (c / length) as f32))
}

/// Returns true if a light is in front of the plane of the images.
pub fn is_above(direction: &[f32; 3]) -> bool {
    direction[2] > 0.0
}

/// Returns true if text begins like a list of lights: a number alone, then a name and three numbers.
fn is_list(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty() && !is_comment(line));
    let (first, second) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
    let is_named = second.split_whitespace().next().is_some_and(|word| !is_number(word));
    first.parse::<u32>().is_ok() && is_named && is_light(second)
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
            ("a.jpg 0 0\n", "line 1, number of lights: found \"a.jpg 0 0\""),
            ("2\n\n", "line 1, lights: no lines after the first; expected a line for each light"),
            ("1\na 0 0 1\nb 0 0 1\nc", "line 4, light: found \"c\", expected the name of an image, then x y z"),
            ("1\n0 0 1\n", "line 2, light: found \"0 0 1\", expected the name of an image, then x y z"),
            ("1\na 0 zero 1\n", "line 2, y: found \"zero\", expected a number"),
            ("1\na 0 0,5,1 1\n", "line 2, y: found \"0,5,1\", expected a number"),
            ("a 0 0 0\n", "line 1, direction: vector of length 0"),
            ("1\na 0 0 inf\n", "line 2, direction: no finite vector in the list; expected three finite numbers"),
            ("1\na NaN 0 1\n", "line 2, direction: no finite vector"),
            ("1\n\na 0 -0 0\n", "line 3, direction: vector of length 0"),
            (
                "1\na 0 1 0\n",
                "line 2, direction: 0 1 0 is at or below the horizon, like all lights of the list; expected z greater than 0",
            ),
            ("2\na 0 3 -4\nb 0 1 0", "line 2, direction: 0 0.6 -0.8 is at or below the horizon, like all lights"),
            ("1\na 0 1 1e-50\n", "line 2, direction: 0 1 0 is at or below"),
            ("2\na 0 0 1\n a 0 1 1\n", "line 3, image: \"a\" is already on line 2; expected each image once"),
            ("2\na\\b.c 0 0 1\na/b.c 0 1 1\n", "line 3, image: \"a/b.c\" is already on line 2"),
        ] {
            assert!(message(text).starts_with(expected), "{text:?}: {}", message(text));
        }
        let message_of = |bytes: &[u8]| LightPositions::from_bytes(bytes).unwrap_err().to_string();
        assert!(message_of(b"1\n\0").starts_with("line 2, text: NUL byte"));
        let most = (0..MAX_LIGHTS).fold(format!("{MAX_LIGHTS}\n"), |text, k| text + &format!("{k} 0 {k} 1\n"));
        assert_eq!(LightPositions::parse(&most).unwrap().names.len(), MAX_LIGHTS);
        // Lines without finite numbers count, too.
        let more = (0..MAX_LIGHTS).fold(String::new(), |text, k| text + &format!("{k} 0 nan 1\n")) + "last 0 0 1\n";
        assert!(message(&more).contains("too many lights"), "{}", message(&more));
        let more = format!("{most}one more 0 0 1\n");
        assert!(message(&more).starts_with("line 4098, light: too many lights; expected at most 4096 lights"));
    }

    /// Lists as people have them: another number than stated or none, lights behind the plane, quotation marks.
    #[test]
    fn lists_that_are_not_quite_right() {
        let read = |text: &str| LightPositions::parse(text).unwrap();
        let three = "a.png 0 0 1\nb.png 0.6 0 0.8\nc.png 0 1 -0.0002\n";
        for stated in [Some(2), Some(3), Some(9), None] {
            let text = stated.map_or(String::new(), |count| format!("{count}  \n")) + three;
            let list = read(&text);
            assert_eq!((list.stated, list.names.len()), (stated, 3), "{text}");
            assert_eq!(list.directions.iter().map(is_above).collect::<Vec<_>>(), [true, true, false]);
            assert_eq!(list.lines[0], if stated.is_some() { 2 } else { 1 });
        }
        let commas = read("3\na 0,6 0 0,8\nb 0.6 0 0.8\nc nan 0 1\n");
        assert_eq!(
            (commas.directions.clone(), commas.not_finite),
            (vec![[0.6, 0.0, 0.8]; 2], vec![("c".to_owned(), 4)])
        );
        let list = read("3\n\"a b.png\" 0 0 1\n\" 0 0 1\n\"\" 1 0 1\n");
        assert_eq!(list.names, ["a b.png", "\"", "\"\""]);
    }

    /// Positions of near lights keep their lengths; without the line they are directions.
    #[test]
    fn positions_of_near_lights() {
        let lines = ["2", "a.png 0 0 1.5", "b.png 0.6 0 0.8"];
        assert_eq!(LightPositions::parse(&lines.join("\n")).unwrap().positions, None);
        for at in 0..=3 {
            let mut lines = lines.to_vec();
            lines.insert(at, " # Positions in image widths\r");
            let list = LightPositions::parse(&lines.join("\n")).unwrap();
            assert_eq!(list.positions, Some(vec![[0.0, 0.0, 1.5], [0.6, 0.0, 0.8]]), "{at}");
            assert_eq!((list.stated, list.directions[0], list.lines.len()), (Some(2), [0.0, 0.0, 1.0], 2), "{at}");
        }
        let read = |last: &str| LightPositions::parse(&format!("{}\n{last}", lines.join("\n")));
        assert!(read("#Positions  in image widths.").unwrap().positions.is_some());
        assert_eq!(read("# about positions").unwrap().positions, None);
        let expected = "line 4, positions: found \"# positions in mm\", expected \"# positions in image widths\"";
        assert_eq!(read("# positions in mm").unwrap_err().to_string(), expected);
        // A name.
        assert_eq!(read("# positions 1 0 1").unwrap().names[2], "# positions");
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
                prop_assert!(read.directions.iter().any(is_above));
            }
        }
    }
}
