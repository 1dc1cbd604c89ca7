//! The header of a PLY.

use crate::scan::quoted;
use brdfc_formats::FormatError;

/// Maximum size of a header, bytes.
const MAX_BYTES: usize = 1 << 20;
/// Maximum number of properties of an element, and of elements.
const MAX_COUNT: usize = 1024;
const KEYWORDS: &str = "format ENCODING 1.0, comment, obj_info, element, property or end_header";
const TYPES: &str = "char, uchar, short, ushort, int, uint, float, double, or int8 to float64";

/// Type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn parse(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// Smallest and largest integer.
    fn range(self) -> [f64; 2] {
        match self {
            Self::I8 => [i8::MIN.into(), i8::MAX.into()],
            Self::U8 => [0.0, u8::MAX.into()],
            Self::I16 => [i16::MIN.into(), i16::MAX.into()],
            Self::U16 => [0.0, u16::MAX.into()],
            Self::I32 => [i32::MIN.into(), i32::MAX.into()],
            Self::U32 => [0.0, u32::MAX.into()],
            Self::F32 | Self::F64 => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// Returns true if a number in text is valid for this type.
    pub fn holds(self, value: f64) -> bool {
        let [lowest, highest] = self.range();
        !self.is_integer() || (value.fract() == 0.0 && (lowest..=highest).contains(&value))
    }

    pub fn allowed(self) -> String {
        let [lowest, highest] = self.range();
        if self.is_integer() { format!("an integer, {lowest} to {highest}") } else { "a number".to_owned() }
    }

    /// Decodes the number in the first [`size`](Self::size) bytes, little-endian.
    pub fn decode(self, [a, b, c, d, e, f, g, h]: [u8; 8]) -> f64 {
        match self {
            Self::I8 => i8::from_le_bytes([a]).into(),
            Self::U8 => a.into(),
            Self::I16 => i16::from_le_bytes([a, b]).into(),
            Self::U16 => u16::from_le_bytes([a, b]).into(),
            Self::I32 => i32::from_le_bytes([a, b, c, d]).into(),
            Self::U32 => u32::from_le_bytes([a, b, c, d]).into(),
            Self::F32 => f32::from_le_bytes([a, b, c, d]).into(),
            Self::F64 => f64::from_le_bytes([a, b, c, d, e, f, g, h]),
        }
    }
}

/// Contents of a property in each row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    Scalar(Scalar),
    /// A list: types of its length and of its items.
    List(Scalar, Scalar),
}

#[derive(Debug)]
pub struct Property {
    pub name: String,
    pub kind: Kind,
    pub line: u64,
}

impl Property {
    /// Minimum number of bytes of a row.
    pub fn least_bytes(&self) -> u64 {
        match self.kind {
            Kind::Scalar(scalar) | Kind::List(scalar, _) => scalar.size() as u64,
        }
    }
}

#[derive(Debug)]
pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    pub line: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Encoding {
    Ascii,
    Binary { big_endian: bool },
}

#[derive(Debug)]
pub struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Number of bytes before the data.
    pub length: usize,
    /// Number of lines before the data.
    pub lines: u64,
}

impl Header {
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        let mut length = 0;
        for (line, content) in (1u64..).zip(bytes.split_inclusive(|byte| *byte == b'\n')) {
            length += content.len();
            if length > MAX_BYTES {
                let found = format!("no end_header in {MAX_BYTES} bytes");
                return Err(FormatError::at_line(line, "header", found, "a shorter header").problem());
            }
            let wrong = |field: &'static str, found: &str, allowed: &str| {
                Err(FormatError::at_line(line, field, quoted(found), allowed))
            };
            if !content.ends_with(b"\n") {
                return wrong("header", &String::from_utf8_lossy(content), "end_header, and a line feed after it");
            }
            let text = String::from_utf8_lossy(content);
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            match words[..] {
                ["ply"] if line == 1 => {}
                _ if line == 1 => return wrong("first line", text.trim_end(), "ply"),
                ["format", name, version] if encoding.is_none() => {
                    encoding = Some(match (name, version) {
                        ("ascii", "1.0") => Encoding::Ascii,
                        ("binary_little_endian", "1.0") => Encoding::Binary { big_endian: false },
                        ("binary_big_endian", "1.0") => Encoding::Binary { big_endian: true },
                        _ => {
                            let allowed = "ascii, binary_little_endian or binary_big_endian, and 1.0";
                            return wrong("format", &format!("{name} {version}"), allowed);
                        }
                    });
                }
                [] | ["comment" | "obj_info", ..] => {}
                ["element", name, count] => {
                    let Ok(count) = count.parse::<u64>() else {
                        return wrong("element count", count, "an integer of 0 or more");
                    };
                    if elements.iter().any(|element| element.name == name) {
                        return wrong("element", name, "each name once");
                    }
                    if elements.len() == MAX_COUNT {
                        return wrong("element", name, &format!("at most {MAX_COUNT} elements"));
                    }
                    elements.push(Element { name: name.to_owned(), count, properties: Vec::new(), line });
                }
                ["property", .., name] if words.len() == 3 || (words.len() == 5 && words[1] == "list") => {
                    let types: Vec<_> = words[if words.len() == 3 { 1..2 } else { 2..4 }].iter().collect();
                    let parsed: Vec<Option<Scalar>> = types.iter().map(|name| Scalar::parse(name)).collect();
                    let kind = match parsed[..] {
                        [Some(scalar)] => Kind::Scalar(scalar),
                        [Some(count), Some(item)] => Kind::List(count, item),
                        _ => return wrong("property", text.trim_end(), TYPES),
                    };
                    let Some(element) = elements.last_mut() else {
                        return wrong("property", text.trim_end(), "an element before it");
                    };
                    if element.properties.iter().any(|property| property.name == name) {
                        return wrong("property", name, "each name once");
                    }
                    if element.properties.len() == MAX_COUNT {
                        return wrong("property", name, &format!("at most {MAX_COUNT} properties of an element"));
                    }
                    element.properties.push(Property { name: name.to_owned(), kind, line });
                }
                ["end_header"] => {
                    let Some(encoding) = encoding else {
                        return wrong("header", "end_header", "a line format ENCODING 1.0 before it");
                    };
                    return Ok(Self { encoding, elements, length, lines: line });
                }
                _ => return wrong("header", text.trim_end(), KEYWORDS),
            }
        }
        Err(FormatError::whole("header", format!("end of data after {length} bytes"), "end_header").problem())
    }

    pub fn element(&self, name: &'static str) -> Result<&Element, FormatError> {
        self.elements.iter().find(|element| element.name == name).ok_or_else(|| {
            let found: Vec<&str> = self.elements.iter().map(|element| element.name.as_str()).collect();
            FormatError::at_line(self.lines, "elements", quoted(&found.join(" ")), format!("an element {name}"))
        })
    }
}
