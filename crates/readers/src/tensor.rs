//! The tensor container of the RGL material database: named arrays after a table of headers.
//!
//! Layout: `crates/readers/src/rgl.md`, section "Container".

use std::collections::HashSet;

use brdfc_formats::cursor::Cursor;
use brdfc_formats::{FormatError, memory};

/// First 12 bytes of every container.
pub const MAGIC: &[u8; 12] = b"tensor_file\0";

/// Major and minor version, after the magic bytes.
pub const VERSION: [u8; 2] = [1, 0];

/// Type of the elements of a tensor, with its code in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum ElementKind {
    /// Unsigned, 1 byte.
    U8 = 1,
    /// Signed, 1 byte.
    I8 = 2,
    /// Unsigned, 2 bytes.
    U16 = 3,
    /// Signed, 2 bytes.
    I16 = 4,
    /// Unsigned, 4 bytes.
    U32 = 5,
    /// Signed, 4 bytes.
    I32 = 6,
    /// Unsigned, 8 bytes.
    U64 = 7,
    /// Signed, 8 bytes.
    I64 = 8,
    /// IEEE 754 half, 2 bytes.
    F16 = 9,
    /// IEEE 754 single, 4 bytes.
    F32 = 10,
    /// IEEE 754 double, 8 bytes.
    F64 = 11,
}

impl ElementKind {
    const ALL: [Self; 11] = [
        Self::U8,
        Self::I8,
        Self::U16,
        Self::I16,
        Self::U32,
        Self::I32,
        Self::U64,
        Self::I64,
        Self::F16,
        Self::F32,
        Self::F64,
    ];

    /// The type with this code, 1 to 11.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| *kind as u8 == code)
    }

    /// Bytes per element.
    pub fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }
}

/// A named array with its bytes in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tensor<'a> {
    /// Name, unique in the file.
    pub name: &'a str,
    /// Type of the elements.
    pub kind: ElementKind,
    /// Extent along each axis, slowest first. Empty for a scalar. An extent may be zero.
    pub shape: Vec<usize>,
    /// Byte offset of the header of this tensor (of its name length).
    pub header_offset: u64,
    /// Byte offset of the first element.
    pub data_offset: u64,
    /// The elements, row-major, little-endian: product of the shape times the element size.
    pub data: &'a [u8],
}

impl<'a> Tensor<'a> {
    /// Returns an error for any other element type.
    pub fn expect_kind(&self, kind: ElementKind) -> Result<(), FormatError> {
        if self.kind == kind {
            return Ok(());
        }
        Err(self.header_error("element type", format!("{:?}", self.kind), format!("{kind:?}")))
    }

    /// The elements as bytes. Returns an error for any other type.
    pub fn bytes(&self) -> Result<&'a [u8], FormatError> {
        self.expect_kind(ElementKind::U8)?;
        Ok(self.data)
    }

    /// The elements as single-precision values. Returns an error for any other type, and for a value that is not finite
    /// or outside `minimum..=maximum`.
    pub fn floats(&self, minimum: f32, maximum: f32) -> Result<Vec<f32>, FormatError> {
        self.expect_kind(ElementKind::F32)?;
        let (chunks, _) = self.data.as_chunks::<4>();
        let mut values = memory::reserved("tensor", chunks.len())?;
        for (index, chunk) in chunks.iter().enumerate() {
            let value = f32::from_le_bytes(*chunk);
            if !(value.is_finite() && value >= minimum && value <= maximum) {
                let allowed = match (minimum > f32::MIN, maximum < f32::MAX) {
                    (true, true) => format!("{minimum} to {maximum}"),
                    (true, false) => format!("finite, at least {minimum}"),
                    (false, true) => format!("finite, at most {maximum}"),
                    (false, false) => "a finite number".to_owned(),
                };
                return Err(self.element_error(index, value.to_string(), allowed));
            }
            values.push(value);
        }
        Ok(values)
    }

    /// Creates an error about this tensor's header.
    pub fn header_error(&self, what: &str, found: impl Into<String>, allowed: impl Into<String>) -> FormatError {
        FormatError::at_byte(self.header_offset, format!("{} {what}", self.name), found, allowed)
    }

    /// Creates an error about the element at `index`, counted from 0 in storage order.
    pub fn element_error(&self, index: usize, found: impl Into<String>, allowed: impl Into<String>) -> FormatError {
        let offset = self.data_offset + (index * self.kind.size()) as u64;
        FormatError::at_byte(offset, format!("{} element {index}", self.name), found, allowed)
    }
}

/// A container with checked headers: every tensor is inside the file, after the headers.
#[derive(Debug, Clone)]
pub struct TensorFile<'a> {
    tensors: Vec<Tensor<'a>>,
}

impl<'a> TensorFile<'a> {
    /// Reads the headers; the elements stay in `bytes`.
    ///
    /// Returns an error for a wrong magic or version, a truncated header, a name that is not UTF-8 or not unique, an
    /// unknown element code, extents whose product overflows, and elements that overlap the headers or reach past the
    /// end of the file. Allocated memory is at most proportional to the length of `bytes`.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, FormatError> {
        let mut cursor = Cursor::new(bytes);
        let magic = cursor.take(MAGIC.len(), "magic")?;
        if magic != MAGIC {
            return Err(FormatError::at_byte(
                0,
                "magic",
                format!("{:?}", magic.escape_ascii().to_string()),
                "tensor_file\\0",
            ));
        }
        let version = [cursor.u8("version")?, cursor.u8("version")?];
        if version != VERSION {
            return Err(FormatError::at_byte(12, "version", format!("{}.{}", version[0], version[1]), "1.0"));
        }
        let count = cursor.u32("field count")?;
        let mut tensors = Vec::new();
        let mut names = HashSet::new();
        // No reservation by `count`, which only the following reads can verify.
        for _ in 0..count {
            let tensor = read_header(&mut cursor, bytes)?;
            if !names.insert(tensor.name) {
                return Err(tensor.header_error("name", "duplicate field name", "unique names").problem());
            }
            tensors.push(tensor);
        }
        let header_end = cursor.position();
        if let Some(tensor) = tensors.iter().find(|t| t.data_offset < header_end) {
            return Err(tensor.header_error(
                "data offset",
                tensor.data_offset.to_string(),
                format!("at least {header_end}, the end of the headers"),
            ));
        }
        Ok(Self { tensors })
    }

    /// All tensors, in file order.
    pub fn tensors(&self) -> &[Tensor<'a>] {
        &self.tensors
    }

    /// Finds a tensor by name.
    pub fn get(&self, name: &str) -> Option<&Tensor<'a>> {
        self.tensors.iter().find(|tensor| tensor.name == name)
    }

    /// Finds a tensor by name. Returns an error if there is none.
    pub fn require(&self, name: &'static str) -> Result<&Tensor<'a>, FormatError> {
        self.get(name).ok_or_else(|| FormatError::whole(name, "missing", "a field of this name").problem())
    }
}

fn read_header<'a>(cursor: &mut Cursor<'a>, bytes: &'a [u8]) -> Result<Tensor<'a>, FormatError> {
    let header_offset = cursor.position();
    let name_length = cursor.u16("name length")?;
    let name_offset = cursor.position();
    let name_bytes = cursor.take(usize::from(name_length), "name")?;
    let name = std::str::from_utf8(name_bytes).map_err(|error| {
        FormatError::at_byte(
            name_offset + error.valid_up_to() as u64,
            "name",
            format!("\"{}\"", name_bytes.escape_ascii()),
            "UTF-8",
        )
    })?;
    let rank = usize::from(cursor.u16("number of axes")?);
    let code_offset = cursor.position();
    let code = cursor.u8("element type")?;
    let kind = ElementKind::from_code(code).ok_or_else(|| {
        FormatError::at_byte(code_offset, format!("{name} element type"), code.to_string(), "1 to 11")
    })?;
    let data_offset = cursor.u64("data offset")?;
    let shape_offset = cursor.position();
    // The whole shape is read before memory for it is allocated.
    let (extents, _) = cursor.take(8 * rank, "shape")?.as_chunks::<8>();
    let too_big = |found: String| {
        FormatError::at_byte(
            shape_offset,
            format!("{name} shape"),
            found,
            format!("elements inside the file of {} bytes", bytes.len()),
        )
    };
    let mut shape = Vec::with_capacity(rank);
    let mut length = Some(kind.size());
    for extent in extents {
        let extent = u64::from_le_bytes(*extent);
        let Ok(extent) = usize::try_from(extent) else { return Err(too_big(format!("an extent of {extent}"))) };
        // A zero extent must not hide an overflow of the others.
        length = length.and_then(|length| length.checked_mul(extent.max(1)));
        shape.push(extent);
    }
    let Some(length) = length else { return Err(too_big(format!("{shape:?}"))) };
    let length = if shape.contains(&0) { 0 } else { length };
    let data = usize::try_from(data_offset)
        .ok()
        .and_then(|start| bytes.get(start..start.checked_add(length)?))
        .ok_or_else(|| too_big(format!("{shape:?} of {kind:?} from byte {data_offset}")))?;
    Ok(Tensor { name, kind, shape, header_offset, data_offset, data })
}

/// Elements of a field.
#[derive(Debug, Clone, Copy)]
pub enum Elements<'a> {
    /// Bytes, `u8`.
    Bytes(&'a [u8]),
    /// Floats, `f32`.
    Floats(&'a [f32]),
}

/// Bytes of a file of these fields: names, extents with the slowest axis first, elements. Each starts at a multiple of
/// 8 bytes.
pub fn to_bytes(fields: &[(&str, Vec<usize>, Elements<'_>)]) -> Vec<u8> {
    let headers: usize = fields.iter().map(|(name, shape, _)| 2 + name.len() + 2 + 1 + 8 + 8 * shape.len()).sum();
    let mut offset = MAGIC.len() + 2 + 4 + headers;
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION);
    bytes.extend((fields.len() as u32).to_le_bytes());
    for (name, shape, elements) in fields {
        offset = offset.next_multiple_of(8);
        let (code, length) = match elements {
            Elements::Bytes(values) => (ElementKind::U8 as u8, values.len()),
            Elements::Floats(values) => (ElementKind::F32 as u8, 4 * values.len()),
        };
        bytes.extend((name.len() as u16).to_le_bytes());
        bytes.extend(name.as_bytes());
        bytes.extend((shape.len() as u16).to_le_bytes());
        bytes.push(code);
        bytes.extend((offset as u64).to_le_bytes());
        bytes.extend(shape.iter().flat_map(|extent| (*extent as u64).to_le_bytes()));
        offset += length;
    }
    for (.., elements) in fields {
        bytes.resize(bytes.len().next_multiple_of(8), 0);
        match elements {
            Elements::Bytes(values) => bytes.extend(*values),
            Elements::Floats(values) => bytes.extend(values.iter().flat_map(|value| value.to_le_bytes())),
        }
    }
    bytes
}
