//! Reader of the layout. Besides its result, the reader holds one block of the file at a time.

use super::btf::{CHANNELS, Description, MAX_SIZE, NAME_BYTES, SIGNATURE, UboBtf, VERSIONS, versions};
use super::colour::ColourModel;
use super::matrix::{Channel, Matrix, Scalar};
use brdfc_formats::direction::{Vector, dot, from_polar, subtract};
use brdfc_formats::direction_set::{DirectionSet, MAX_DIRECTIONS, SAME_DIRECTION, wrong_angle};
use brdfc_formats::{FormatError, Place, memory};
use std::io::{Cursor, Read, Seek, SeekFrom};

/// Number of bytes of a matrix that are read at once; a multiple of every number's size.
const BLOCK_BYTES: usize = 1 << 16;
/// Angles in a file represent a multiple of this fraction of a degree if that is the nearest f32.
const STEPS_PER_DEGREE: f64 = 1e4;
/// Other layouts of the database with a similar signature.
const OTHER_SIGNATURES: [(&[u8], &str); 4] = [
    (b"!FMF", "FMF (the codec without decorrelated colours)"),
    (b"!PVF", "PVF (the codec with a factorisation for each view)"),
    (b"!BDIF", "BDI (uncompressed values)"),
    (b"!DFMF", "another version of DFMF"),
];

/// Error of reading a file.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file violates its layout.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The system cannot read it.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

impl UboBtf {
    /// Reads a file in memory.
    ///
    /// # Errors
    /// Returns an error for violations of the layout. Every length is checked against the rest of the file before
    /// memory is allocated.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        Self::from_reader(Cursor::new(bytes)).map_err(|error| match error {
            ReadError::Format(error) => error,
            ReadError::Io(error) => FormatError::whole("bytes", error.to_string(), "readable bytes").problem(),
        })
    }

    /// Reads a file from its start to its end, a block at a time, with memory for the result only.
    ///
    /// # Errors
    /// Same as [`Self::from_bytes`]. Also returns an error if the file cannot be read.
    pub fn from_reader(mut file: impl Read + Seek) -> Result<Self, ReadError> {
        let length = file.seek(SeekFrom::End(0))?;
        file.seek(SeekFrom::Start(0))?;
        Reader { file, length, position: 0 }.btf()
    }
}

struct Reader<R> {
    file: R,
    length: u64,
    position: u64,
}

impl<R: Read + Seek> Reader<R> {
    fn btf(mut self) -> Result<UboBtf, ReadError> {
        self.signature()?;
        let header = self.header()?;
        let (views, lights) = self.directions()?;
        let size = [self.side("width")?, self.side("height")?];
        let at = self.position;
        let rotations = self.word("rotations")?;
        if rotations != 0 {
            let allowed = "0, because rotated frames of texels are not supported";
            return Err(FormatError::at_byte(at, "rotations", rotations.to_string(), allowed).into());
        }
        // Number of components of the channel with the most; each channel repeats its own.
        self.word("components")?;
        let at = self.position;
        let code = i32::from_le_bytes(self.array("colour model")?);
        let mean = self.singles("colour mean")?;
        let transform =
            [self.singles("colour transform")?, self.singles("colour transform")?, self.singles("colour transform")?];
        let colour_model = ColourModel::from_code(code, mean, transform, at)?;
        let pairs = (views.len() * lights.len()) as u64;
        let texels = size[0] as u64 * size[1] as u64;
        let mut channels = Vec::with_capacity(CHANNELS);
        for _ in 0..CHANNELS {
            channels.push(self.channel(pairs, texels)?);
        }
        if self.left() > 0 {
            let found = format!("{} more bytes", self.left());
            return Err(FormatError::at_byte(self.position, "end", found, "the end of the file").into());
        }
        let description = Description { views, lights, size, colour_model, ..header };
        let channels = <[Channel; CHANNELS]>::try_from(channels).expect("as many were read");
        Ok(UboBtf::new(description, channels)?)
    }

    fn signature(&mut self) -> Result<(), ReadError> {
        let mut start = vec![0; SIGNATURE.len().min(self.length as usize)];
        self.file.read_exact(&mut start)?;
        if start == SIGNATURE {
            self.position = SIGNATURE.len() as u64;
            return Ok(());
        }
        let other = OTHER_SIGNATURES.iter().find(|(begin, _)| start.starts_with(begin)).map(|(_, name)| *name);
        let found = other.map_or_else(|| format!("\"{}\"", start.escape_ascii()), str::to_owned);
        Err(FormatError::at_byte(0, "signature", found, format!("\"{}\"", SIGNATURE.escape_ascii())).into())
    }

    /// Reads the header up to the directions, without the directions, the size and the colour model.
    fn header(&mut self) -> Result<Description, ReadError> {
        let start = self.position;
        let size = self.word("header size")?;
        let at = self.position;
        let version = self.word("version")?;
        if !VERSIONS.contains(&version) {
            return Err(FormatError::at_byte(at, "version", version.to_string(), versions()).into());
        }
        let devices = [self.name("measurement setup")?, self.name("image sensor")?, self.name("light source")?];
        let [texels_per_millimetre] = self.singles("texels per millimetre")?;
        let rgb_factors = self.singles("factors of red, green and blue")?;
        let has_cosine = version > 1 && self.word("cosine flag")? != 0;
        let mut xml_bytes = 0;
        if version > 2 {
            xml_bytes = self.word("XML length")?;
            self.skip(xml_bytes.into(), "XML")?;
        }
        if version > 3 {
            let at = self.position;
            let channels = self.word("channels")?;
            if channels != CHANNELS as u32 {
                return Err(FormatError::at_byte(at, "channels", channels.to_string(), CHANNELS.to_string()).into());
            }
            for _ in 0..channels {
                let length = self.word("length of a channel's name")?;
                self.skip(length.into(), "name of a channel")?;
            }
        }
        let read = self.position - start;
        if u64::from(size) != read {
            return Err(FormatError::at_byte(
                start,
                "header size",
                size.to_string(),
                format!("{read}, its size in bytes"),
            )
            .into());
        }
        let none = || DirectionSet { name: String::new(), angles: Vec::new() };
        Ok(Description {
            version,
            devices,
            texels_per_millimetre,
            rgb_factors,
            has_cosine,
            xml_bytes,
            views: none(),
            lights: none(),
            size: [0; 2],
            colour_model: ColourModel::Rgb,
        })
    }

    /// Reads each view followed by its lights; all views have the same lights.
    fn directions(&mut self) -> Result<(DirectionSet, DirectionSet), ReadError> {
        let start = self.position;
        let count = self.count("views")?;
        // At least a direction, a number of lights and one light.
        self.room(count as u64 * 20, "views")?;
        let mut views = memory::reserved("views", count)?;
        let mut lights: Vec<[f64; 2]> = Vec::new();
        let mut vectors: Vec<Vector> = Vec::new();
        let mut lights_start = 0;
        for view in 0..count {
            views.push(self.angles()?);
            let at = self.position;
            let found = self.count("lights of a view")?;
            self.room(found as u64 * 8, "lights of a view")?;
            if view == 0 {
                lights_start = at;
                lights = memory::reserved("lights", found)?;
                for _ in 0..found {
                    lights.push(self.angles()?);
                }
                vectors = lights.iter().map(vector).collect();
                continue;
            }
            if found != lights.len() {
                let allowed = format!("{}, as for the first view", lights.len());
                return Err(FormatError::at_byte(at, "lights of a view", found.to_string(), allowed).into());
            }
            for (light, expected) in vectors.iter().enumerate() {
                let at = self.position;
                let angles = self.angles()?;
                let difference = subtract(vector(&angles), *expected);
                if dot(difference, difference) >= SAME_DIRECTION * SAME_DIRECTION {
                    let found = format!("{angles:?} degrees of view {view}");
                    let allowed = format!("{:?}, as for the first view", lights[light]);
                    return Err(FormatError::at_byte(at, "light", found, allowed).into());
                }
            }
        }
        let set = |angles, at| {
            DirectionSet::new("of the file", angles).map_err(|error| FormatError { place: Place::Byte(at), ..error })
        };
        Ok((set(views, start)?, set(lights, lights_start)?))
    }

    fn channel(&mut self, pairs: u64, texels: u64) -> Result<Channel, ReadError> {
        let at = self.position;
        let [size] = self.array("bytes of a number")?;
        let Some(scalar) = Scalar::of_size(size) else {
            return Err(FormatError::at_byte(at, "bytes of a number", size.to_string(), "2, 4 or 8").into());
        };
        let at = self.position;
        let components = self.word("components of a channel")?;
        let rows_at = self.position;
        let first = u64::from(self.word("rows of the first matrix")?);
        let second_at = self.position;
        let second = u64::from(self.word("rows of the second matrix")?);
        // The columns may be images instead of apparent BRDFs; columns of square matrices are apparent BRDFs.
        let is_transposed = first == texels && first != pairs;
        let expected = if is_transposed { [texels, pairs] } else { [pairs, texels] };
        for (at, field, found, expected) in [
            (rows_at, "rows of the first matrix", first, expected[0]),
            (second_at, "rows of the second matrix", second, expected[1]),
        ] {
            if found != expected {
                let other = if is_transposed { String::new() } else { format!(" ({texels} if they are exchanged)") };
                let allowed = if at == rows_at { format!("{expected}{other}") } else { expected.to_string() };
                return Err(FormatError::at_byte(at, field, found.to_string(), allowed).into());
            }
        }
        let row = u64::from(components) * scalar.size();
        // 2048 * 2048 + 4096 * 4096 + 1 rows of less than 2^35 bytes fit.
        let needed = row * (1 + first + second);
        if components == 0 || needed > self.left() {
            let most = self.left() / (scalar.size() * (1 + first + second));
            let allowed = format!("1 to {most}, limited by the remaining {} bytes", self.left());
            return Err(FormatError::at_byte(at, "components of a channel", components.to_string(), allowed).into());
        }
        self.skip(row, "singular values")?;
        let first = self.matrix(scalar, first, components, "first matrix")?;
        let second = self.matrix(scalar, second, components, "second matrix")?;
        Ok(if is_transposed { Channel::of(second, first) } else { Channel::of(first, second) })
    }

    fn matrix(&mut self, scalar: Scalar, rows: u64, columns: u32, field: &'static str) -> Result<Matrix, ReadError> {
        let count = usize::try_from(rows * u64::from(columns));
        let count = count
            .map_err(|_| FormatError::whole(field, "more numbers than addresses", "a smaller matrix").problem())?;
        let mut matrix = Matrix::reserved(scalar, count, columns as usize)?;
        let mut left = count as u64 * scalar.size();
        let mut block = vec![0; BLOCK_BYTES.min(left as usize)];
        while left > 0 {
            let block = &mut block[..(BLOCK_BYTES as u64).min(left) as usize];
            let at = self.position;
            self.bytes(block, field)?;
            matrix.append(scalar, block).map_err(|(index, value)| {
                FormatError::at_byte(at + index as u64 * scalar.size(), field, value.to_string(), "finite numbers")
            })?;
            left -= block.len() as u64;
        }
        Ok(matrix)
    }

    fn left(&self) -> u64 {
        self.length.saturating_sub(self.position)
    }

    /// Returns an error unless `bytes` remain.
    fn room(&self, bytes: u64, field: &'static str) -> Result<(), FormatError> {
        if bytes <= self.left() {
            return Ok(());
        }
        let found = format!("end of data after {} of {bytes} bytes", self.left());
        Err(FormatError::at_byte(self.position, field, found, format!("{bytes} bytes")).problem())
    }

    fn bytes(&mut self, bytes: &mut [u8], field: &'static str) -> Result<(), ReadError> {
        self.room(bytes.len() as u64, field)?;
        self.file.read_exact(bytes)?;
        self.position += bytes.len() as u64;
        Ok(())
    }

    fn skip(&mut self, bytes: u64, field: &'static str) -> Result<(), ReadError> {
        self.room(bytes, field)?;
        self.position += bytes;
        self.file.seek(SeekFrom::Start(self.position))?;
        Ok(())
    }

    fn array<const N: usize>(&mut self, field: &'static str) -> Result<[u8; N], ReadError> {
        let mut array = [0; N];
        self.bytes(&mut array, field)?;
        Ok(array)
    }

    fn word(&mut self, field: &'static str) -> Result<u32, ReadError> {
        Ok(u32::from_le_bytes(self.array(field)?))
    }

    fn singles<const N: usize>(&mut self, field: &'static str) -> Result<[f32; N], ReadError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = f32::from_le_bytes(self.array(field)?);
        }
        Ok(values)
    }

    fn name(&mut self, field: &'static str) -> Result<String, ReadError> {
        let bytes: [u8; NAME_BYTES] = self.array(field)?;
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(NAME_BYTES);
        Ok(String::from_utf8_lossy(&bytes[..end]).into_owned())
    }

    fn count(&mut self, field: &'static str) -> Result<usize, ReadError> {
        self.within(field, MAX_DIRECTIONS as u32)
    }

    fn side(&mut self, field: &'static str) -> Result<usize, ReadError> {
        self.within(field, MAX_SIZE)
    }

    fn within(&mut self, field: &'static str, most: u32) -> Result<usize, ReadError> {
        let at = self.position;
        let found = self.word(field)?;
        if (1..=most).contains(&found) {
            return Ok(found as usize);
        }
        Err(FormatError::at_byte(at, field, found.to_string(), format!("1 to {most}")).into())
    }

    /// Reads a polar angle and an azimuth, radians in the file, and converts them to degrees.
    fn angles(&mut self) -> Result<[f64; 2], ReadError> {
        let at = self.position;
        let angles = self.singles::<2>("angles of a direction")?.map(degrees);
        match wrong_angle(angles) {
            Some((field, found, allowed)) => Err(FormatError::at_byte(at, field, found.to_string(), allowed).into()),
            None => Ok(angles),
        }
    }
}

/// The round number of degrees whose f32 the file has, or the exact value.
fn degrees(radians: f32) -> f64 {
    let exact = f64::from(radians).to_degrees();
    let round = (exact * STEPS_PER_DEGREE).round() / STEPS_PER_DEGREE;
    if round.to_radians() as f32 == radians { round } else { exact }
}

fn vector([theta, phi]: &[f64; 2]) -> Vector {
    from_polar(theta.to_radians(), phi.to_radians())
}
