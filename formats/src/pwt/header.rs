//! What a pack says of itself, in the entry `brdfc.pwt`.

use super::basis::{LightBasis, LightCoordinates, MAX_DEGREE, MAX_TERMS};
use super::domain::Domain;
use crate::FormatError;
use crate::cursor::Cursor;
use crate::error::Place;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// The entry that makes a texture this kind of pack.
pub const PWT_ENTRY: &str = "brdfc.pwt";
/// Most textures of a pack.
pub const MAX_TEXTURES: usize = 4;
/// Most texels per side of the rendering.
pub const MAX_SIDE: u32 = 8192;
/// Most numbers of all layers together.
pub const MAX_COMPONENTS: usize = 128;
/// Most mipmap levels below the finest texels of the rendering.
pub const MAX_LEVEL: u32 = 12;

const VERSION: u32 = 1;
const FIXED_BYTES: usize = 4 * (11 + 1 + 9 + 4);

/// What one number of a texel stands for: `low + scale texel` times the weight of a term is added to a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Which channel, 0 to 2.
    pub channel: u32,
    /// Which term of the light.
    pub term: u32,
    /// What texels of 0 to 1 are multiplied by.
    pub scale: f32,
    /// What is added to that.
    pub low: f32,
}

impl Component {
    /// What fills a layer up.
    pub const NONE: Self = Self { channel: 0, term: 0, scale: 0.0, low: 0.0 };
}

/// What one of a pack's textures holds.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureHeader {
    /// How often the rendering's sides were halved for its finest texels.
    pub level: u32,
    /// Numbers of a texel: 1, 2 or 4.
    pub channels: u32,
    /// What they stand for, layer by layer: a multiple of `channels`.
    pub components: Vec<Component>,
}

impl TextureHeader {
    /// Layers.
    pub fn layers(&self) -> u32 {
        self.components.len() as u32 / self.channels.max(1)
    }
}

/// How wrong a pack is where it was measured: at its finest level, at rows spread over all photographs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct PwtErrors {
    /// Photographs.
    pub lights: u32,
    /// Peak signal-to-noise ratio of sRGB codes against the photographs that were fitted, dB.
    pub psnr: f32,
    /// The same of photographs that a fit did not see, dB: each left out in turn, at 512 texels, before pruning
    /// and rounding; 0 where so few lights do not tell.
    pub held_out_psnr: f32,
    /// Mean ΔE (CIE76) against the photographs that were fitted.
    pub delta_e: f32,
}

/// What a pack says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct PwtHeader {
    /// Columns and rows of the rendering, each 1 to [`MAX_SIDE`].
    pub size: [u32; 2],
    /// Columns and rows of texels at the rendering's own resolution: the rendering and what fills it up to whole texels of
    /// all levels.
    pub extent: [u32; 2],
    /// Whether the rendering is a tile that repeats. Its extent is then its size.
    pub repeats: bool,
    /// The coarsest mipmap level, counted from the rendering's own resolution; each halves all sides exactly.
    pub levels: u32,
    /// Terms of the light.
    pub basis: LightBasis,
    /// In which scale terms are summed.
    pub domain: Domain,
    /// Red, green and blue of each channel.
    pub colour: [[f32; 3]; 3],
    /// What makes terms orthonormal over the lights: weight `k` is `Σ_{j ≤ k} triangle[k (k + 1) / 2 + j] term_j`.
    pub triangle: Vec<f32>,
    /// The textures, from the finest. At least one.
    pub textures: Vec<TextureHeader>,
    /// How wrong it is.
    pub errors: PwtErrors,
}

fn refused(field: &str, found: impl ToString, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("{PWT_ENTRY} {field}"), found.to_string(), allowed.into())
}

fn check_range<T: PartialOrd + Display>(field: &str, found: T, range: RangeInclusive<T>) -> Result<(), FormatError> {
    FormatError::check_range(format!("{PWT_ENTRY} {field}"), found, range)
}

fn finite(field: &str, numbers: impl IntoIterator<Item = f32>) -> Result<(), FormatError> {
    match numbers.into_iter().find(|number| !number.is_finite()) {
        Some(found) => Err(refused(field, found, "finite numbers")),
        None => Ok(()),
    }
}

impl PwtHeader {
    /// Weights of all terms under a light: a unit vector to it.
    pub fn weights(&self, light: [f32; 3]) -> [f32; MAX_TERMS] {
        let terms = self.basis.evaluate(light);
        let mut weights = [0.0; MAX_TERMS];
        let mut row = 0;
        for k in 0..self.basis.terms() {
            for j in 0..=k {
                weights[k] += self.triangle[row + j] * terms[j];
            }
            row += k + 1;
        }
        weights
    }

    /// Numbers of all layers of all textures.
    pub fn components(&self) -> impl Iterator<Item = &Component> {
        self.textures.iter().flat_map(|texture| &texture.components)
    }

    /// Fetches of one texel look-up: one per layer.
    pub fn fetches(&self) -> u32 {
        self.textures.iter().map(TextureHeader::layers).sum()
    }

    /// Columns and rows of a texture's finest level.
    pub fn texture_extent(&self, texture: usize) -> [u32; 2] {
        self.extent.map(|side| side >> self.textures[texture].level)
    }

    /// Checks ranges.
    ///
    /// # Errors
    /// Names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        check_range("levels", self.levels, 0..=MAX_LEVEL)?;
        for (size, extent) in self.size.into_iter().zip(self.extent) {
            check_range("size", size, 1..=MAX_SIDE)?;
            let most = if self.repeats { size } else { (size + (1 << self.levels) - 1).min(MAX_SIDE) };
            check_range("extent", extent, size..=most)?;
        }
        if self.extent.iter().any(|side| side % (1 << self.levels) != 0) {
            let [width, height] = self.extent;
            let allowed = format!("sides that {} divides, as levels says", 1 << self.levels);
            return Err(refused("extent", format!("{width} x {height}"), allowed));
        }
        check_range("degree", self.basis.degree, 0..=MAX_DEGREE)?;
        if let Domain::Logarithm { epsilon } = self.domain
            && !(epsilon.is_normal() && epsilon > 0.0)
        {
            return Err(refused("epsilon", epsilon, "a positive normal number"));
        }
        let terms = self.basis.terms();
        if self.triangle.len() != terms * (terms + 1) / 2 {
            let allowed = format!("{}, as the degree says", terms * (terms + 1) / 2);
            return Err(refused("triangle", format!("{} numbers", self.triangle.len()), allowed));
        }
        finite("triangle", self.triangle.iter().copied())?;
        finite("colour", self.colour.iter().flatten().copied())?;
        let PwtErrors { lights: _, psnr, held_out_psnr, delta_e } = self.errors;
        finite("psnr", [psnr])?;
        finite("held-out psnr", [held_out_psnr])?;
        if !(delta_e.is_finite() && delta_e >= 0.0) {
            return Err(refused("delta E", delta_e, "0 or more"));
        }
        check_range("textures", self.textures.len(), 1..=MAX_TEXTURES)?;
        let mut finest = 0;
        for texture in &self.textures {
            if !(finest..=self.levels).contains(&texture.level) {
                let allowed = format!("{finest} to {}, each coarser than the one before", self.levels);
                return Err(refused("texture level", texture.level, allowed));
            }
            finest = texture.level + 1;
            if ![1, 2, 4].contains(&texture.channels) {
                return Err(refused("texture channels", texture.channels, "1, 2 or 4"));
            }
            let count = texture.components.len();
            if count == 0 || !count.is_multiple_of(texture.channels as usize) {
                return Err(refused("components", count, format!("a positive multiple of {}", texture.channels)));
            }
        }
        let count = self.components().count();
        if count > MAX_COMPONENTS {
            return Err(refused("components", count, format!("at most {MAX_COMPONENTS} in all")));
        }
        for component in self.components() {
            check_range("component channel", component.channel, 0..=2)?;
            if component.term as usize >= terms {
                return Err(refused("component term", component.term, format!("less than {terms}")));
            }
            finite("component scale", [component.scale])?;
            finite("component low", [component.low])?;
        }
        Ok(())
    }

    /// The value of the entry.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let (domain, epsilon) = self.domain.code();
        let coordinates = LightCoordinates::ALL.iter().position(|c| *c == self.basis.coordinates);
        let mut words = vec![
            VERSION,
            self.size[0],
            self.size[1],
            self.extent[0],
            self.extent[1],
            u32::from(self.repeats),
            self.levels,
            coordinates.expect("all of them are listed") as u32,
            self.basis.degree,
            domain,
            self.textures.len() as u32,
            epsilon.to_bits(),
        ];
        words.extend(self.colour.iter().flatten().map(|c| c.to_bits()));
        let PwtErrors { lights, psnr, held_out_psnr, delta_e } = self.errors;
        words.extend([lights, psnr.to_bits(), held_out_psnr.to_bits(), delta_e.to_bits()]);
        words.extend(self.triangle.iter().map(|c| c.to_bits()));
        for texture in &self.textures {
            words.extend([texture.level, texture.channels, texture.components.len() as u32]);
            for Component { channel, term, scale, low } in &texture.components {
                words.extend([*channel, *term, scale.to_bits(), low.to_bits()]);
            }
        }
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    /// Reads the value of the entry.
    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        // Offsets within an entry are none of the file.
        let named = |error: FormatError| match error.place {
            Place::Whole => error,
            _ => refused(&error.field, error.found, error.allowed),
        };
        let header = Self::read(bytes).map_err(named)?;
        header.check()?;
        Ok(header)
    }

    fn read(bytes: &[u8]) -> Result<Self, FormatError> {
        if bytes.len() < FIXED_BYTES {
            return Err(refused("length", format!("{} bytes", bytes.len()), format!("{FIXED_BYTES} bytes or more")));
        }
        let mut cursor = Cursor::new(bytes);
        let version = cursor.u32("version")?;
        if version != VERSION {
            return Err(refused("version", version, VERSION.to_string()));
        }
        let size = [cursor.u32("size")?, cursor.u32("size")?];
        let extent = [cursor.u32("extent")?, cursor.u32("extent")?];
        let repeats = match cursor.u32("repeats")? {
            flag @ (0 | 1) => flag == 1,
            found => return Err(refused("repeats", found, "0 or 1")),
        };
        let levels = cursor.u32("levels")?;
        let coordinates = cursor.u32("coordinates")?;
        let coordinates = *LightCoordinates::ALL
            .get(coordinates as usize)
            .ok_or_else(|| refused("coordinates", coordinates, format!("0 to {}", LightCoordinates::ALL.len() - 1)))?;
        let degree = cursor.u32("degree")?;
        // Before the number of terms is taken from it.
        check_range("degree", degree, 0..=MAX_DEGREE)?;
        let basis = LightBasis { coordinates, degree };
        let domain = cursor.u32("domain")?;
        let textures = cursor.u32("textures")?;
        check_range("textures", textures, 1..=MAX_TEXTURES as u32)?;
        let epsilon = cursor.f32("epsilon")?;
        let domain = Domain::from_code(domain, epsilon).ok_or_else(|| refused("domain", domain, "0 to 3"))?;
        // What is not looked at is written as 0.
        if domain.code().1.to_bits() != epsilon.to_bits() {
            return Err(refused("epsilon", epsilon, format!("0, as the domain is {}", domain.name())));
        }
        let mut colour = [[0.0; 3]; 3];
        for value in colour.iter_mut().flatten() {
            *value = cursor.f32("colour")?;
        }
        let errors = PwtErrors {
            lights: cursor.u32("lights")?,
            psnr: cursor.f32("psnr")?,
            held_out_psnr: cursor.f32("held-out psnr")?,
            delta_e: cursor.f32("delta E")?,
        };
        let terms = basis.terms();
        let triangle = (0..terms * (terms + 1) / 2).map(|_| cursor.f32("triangle")).collect::<Result<_, _>>()?;
        let textures = (0..textures).map(|_| read_texture(&mut cursor)).collect::<Result<_, _>>()?;
        if cursor.remaining() > 0 {
            let allowed = format!("{} bytes, as its fields say", cursor.position());
            return Err(refused("length", format!("{} bytes", bytes.len()), allowed));
        }
        Ok(Self { size, extent, repeats, levels, basis, domain, colour, triangle, textures, errors })
    }
}

fn read_texture(cursor: &mut Cursor<'_>) -> Result<TextureHeader, FormatError> {
    let level = cursor.u32("texture level")?;
    let channels = cursor.u32("texture channels")?;
    let count = cursor.u32("components")?;
    if count as usize > MAX_COMPONENTS {
        return Err(refused("components", count, format!("at most {MAX_COMPONENTS}")));
    }
    let component = |_| {
        Ok(Component {
            channel: cursor.u32("component channel")?,
            term: cursor.u32("component term")?,
            scale: cursor.f32("component scale")?,
            low: cursor.f32("component low")?,
        })
    };
    let components = (0..count).map(component).collect::<Result<_, FormatError>>()?;
    Ok(TextureHeader { level, channels, components })
}
