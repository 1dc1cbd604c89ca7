//! Header of a pack, the value of the key `brdfc.pwt`.

use super::basis::{LightBasis, LightCoordinates, MAX_TERMS};
use super::domain::Domain;
use super::light_map::{LightMap, MAP_SIDES};
use crate::FormatError;
use crate::cursor::Cursor;
use crate::direction_mesh::DirectionMesh;
use crate::error::Place;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Key that identifies a polynomial wavelet tree.
pub const PWT_ENTRY: &str = "brdfc.pwt";
/// Maximum number of textures of a pack.
pub const MAX_TEXTURES: usize = 8;
/// Maximum number of views of a pack.
pub const MAX_VIEWS: u32 = MAX_ARRAY_LAYERS;
/// Maximum layers of a texture over all views: the default limit of WebGPU.
pub const MAX_ARRAY_LAYERS: u32 = 256;
/// Maximum texels per side of the image.
pub const MAX_SIDE: u32 = 8192;
/// Maximum number of components over all layers.
pub const MAX_COMPONENTS: usize = 128;
/// Maximum number of mipmap levels below full resolution.
pub const MAX_LEVEL: u32 = 12;

const VERSION: u32 = 2;
const FIXED_BYTES: usize = 4 * (11 + 1 + 9 + 4 + 1 + 1);

/// Weight of each term under a light, in red, green and blue; 0 after the last one.
pub type Weights = [[f32; 3]; MAX_TERMS];

/// Meaning of one texel component: `low + scale texel`, multiplied by the weight of a term, is added to a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Component {
    /// Channel, 0 to 2.
    pub channel: u32,
    /// Term of the light.
    pub term: u32,
    /// Factor of texel values from 0 to 1.
    pub scale: f32,
    /// Value of a texel of 0.
    pub low: f32,
}

impl Component {
    /// Unused component that pads a layer.
    pub const NONE: Self = Self { channel: 0, term: 0, scale: 0.0, low: 0.0 };
}

/// Header of one texture.
#[derive(Debug, Clone, PartialEq)]
pub struct TextureHeader {
    /// Number of times that the image was halved to get the finest level of this texture.
    pub level: u32,
    /// Components per texel: 1, 2 or 4.
    pub channels: u32,
    /// Meaning of the components, layer by layer. The length is a multiple of `channels`.
    pub components: Vec<Component>,
}

impl TextureHeader {
    /// Number of layers of each view: `components` over `channels`.
    pub fn layers(&self) -> u32 {
        self.components.len() as u32 / self.channels.max(1)
    }
}

/// Light map of a file, by its side and number of terms.
pub(super) type MapReader<'a> = &'a mut dyn FnMut(u32, usize) -> Result<LightMap, FormatError>;
/// Mesh of views of a file, by their number.
pub(super) type MeshReader<'a> = &'a mut dyn FnMut(u32) -> Result<DirectionMesh, FormatError>;

/// Errors measured at the finest level, at rows spread over all photographs.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize, schemars::JsonSchema))]
pub struct PwtErrors {
    /// Number of photographs that the errors are over.
    pub lights: u32,
    /// PSNR of sRGB-encoded values against the fitted photographs, dB.
    pub psnr: f32,
    /// PSNR of cross-validation, dB: each photograph is held out in turn, at 512 texels, before
    /// pruning and rounding. For learned terms an estimate, because their components have seen the photograph. 0 if there are too
    /// few lights.
    pub held_out_psnr: f32,
    /// Mean ΔE (CIE76) against the fitted photographs.
    pub delta_e: f32,
}

/// Header of a polynomial wavelet tree.
#[derive(Debug, Clone, PartialEq)]
pub struct PwtHeader {
    /// Columns and rows of the image of each view, each 1 to [`MAX_SIDE`].
    pub size: [u32; 2],
    /// Columns and rows of texels at full resolution: the image padded to whole texels of all levels.
    pub extent: [u32; 2],
    /// True if the image is a repeating tile. Its extent then equals its size.
    pub repeats: bool,
    /// Coarsest mipmap level, counted from full resolution; each level halves all sides exactly.
    pub levels: u32,
    /// Terms of the light.
    pub basis: LightBasis,
    /// Directions to the viewer of two or more views; `None` for a single view of any direction.
    pub views: Option<DirectionMesh>,
    /// Scale in which terms are summed.
    pub domain: Domain,
    /// Red, green and blue of each channel.
    pub colour: [[f32; 3]; 3],
    /// Orthonormalises polynomials over the lights: weight `k` is `Σ_{j ≤ k} triangle[k (k + 1) / 2 + j] term_j`. Empty for
    /// learned terms.
    pub triangle: Vec<f32>,
    /// Learned terms; `None` for polynomials. Term 0 has the value 1 in every texel and needs no component.
    pub light_map: Option<LightMap>,
    /// Textures, the finest first. At least one.
    pub textures: Vec<TextureHeader>,
    /// Errors measured by the encoder.
    pub errors: PwtErrors,
}

fn rejected(field: &str, found: impl ToString, allowed: impl Into<String>) -> FormatError {
    FormatError::whole(format!("{PWT_ENTRY} {field}"), found.to_string(), allowed.into())
}

fn check_range<T: PartialOrd + Display>(field: &str, found: T, range: RangeInclusive<T>) -> Result<(), FormatError> {
    FormatError::check_range(format!("{PWT_ENTRY} {field}"), found, range)
}

fn finite(field: &str, numbers: impl IntoIterator<Item = f32>) -> Result<(), FormatError> {
    match numbers.into_iter().find(|number| !number.is_finite()) {
        Some(found) => Err(rejected(field, found, "finite numbers")),
        None => Ok(()),
    }
}

impl PwtHeader {
    /// Weights of all terms for a light. `light` is a unit vector to it.
    pub fn weights(&self, light: [f32; 3]) -> Weights {
        let mut weights = [[0.0; 3]; MAX_TERMS];
        if let Some(map) = &self.light_map {
            weights.iter_mut().take(map.terms()).enumerate().for_each(|(k, weight)| *weight = map.value(k, light));
            return weights;
        }
        let terms = self.basis.evaluate(light);
        let mut row = 0;
        for k in 0..self.basis.terms() {
            let weight: f32 = (0..=k).map(|j| self.triangle[row + j] * terms[j]).sum();
            weights[k] = [weight; 3];
            row += k + 1;
        }
        weights
    }

    /// Number of views, 1 or more.
    pub fn view_count(&self) -> u32 {
        self.views.as_ref().map_or(1, |views| views.directions() as u32)
    }

    /// Indices of three views and their weights for a unit vector to the viewer, as [`DirectionMesh::weights`]; the only
    /// view for any vector.
    pub fn seen(&self, view: [f32; 3]) -> ([u32; 3], [f32; 3]) {
        self.views.as_ref().map_or(([0; 3], [1.0, 0.0, 0.0]), |views| views.weights(view))
    }

    /// Weight of every component, in red, green and blue: that of its term, times the colour of its channel.
    pub fn component_weights<'a>(&'a self, weights: &'a Weights) -> impl Iterator<Item = [f32; 3]> + 'a {
        self.components().map(|component| {
            let (colour, weight) = (self.colour[component.channel as usize], weights[component.term as usize]);
            [0, 1, 2].map(|c| colour[c] * weight[c])
        })
    }

    /// Value of a texel whose components are all 0, in the domain.
    pub fn constant(&self, weights: &Weights) -> [f32; 3] {
        if self.light_map.is_some() { weights[0] } else { [0.0; 3] }
    }

    /// Components of all layers of all textures.
    pub fn components(&self) -> impl Iterator<Item = &Component> {
        self.textures.iter().flat_map(|texture| &texture.components)
    }

    /// Texture fetches of one look-up of a view, one per layer; a look-up between views takes up to three times as many.
    /// Learned terms take as many more as the basis has terms, including the mean, for each light.
    pub fn fetches(&self) -> u32 {
        self.textures.iter().map(TextureHeader::layers).sum()
    }

    /// Columns and rows of a texture's finest level.
    pub fn texture_extent(&self, texture: usize) -> [u32; 2] {
        self.extent.map(|side| side >> self.textures[texture].level)
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        check_range("levels", self.levels, 0..=MAX_LEVEL)?;
        for (size, extent) in self.size.into_iter().zip(self.extent) {
            check_range("size", size, 1..=MAX_SIDE)?;
            let most = if self.repeats { size } else { (size + (1 << self.levels) - 1).min(MAX_SIDE) };
            check_range("extent", extent, size..=most)?;
        }
        if self.extent.iter().any(|side| side % (1 << self.levels) != 0) {
            let [width, height] = self.extent;
            let allowed = format!("multiples of {}, as levels requires", 1 << self.levels);
            return Err(rejected("extent", format!("{width} x {height}"), allowed));
        }
        if self.views.is_some() {
            check_range("views", self.view_count(), 2..=MAX_VIEWS)?;
        }
        check_range("degree", self.basis.degree, 0..=self.basis.coordinates.max_degree())?;
        if let Domain::Logarithm { epsilon } = self.domain
            && !(epsilon.is_normal() && epsilon > 0.0)
        {
            return Err(rejected("epsilon", epsilon, "a positive normal number"));
        }
        let terms = self.basis.terms();
        let numbers = triangle_numbers(self.basis);
        if self.triangle.len() != numbers {
            let allowed = format!("{numbers}, as degree requires");
            return Err(rejected("triangle", format!("{} numbers", self.triangle.len()), allowed));
        }
        let expected = if self.basis.coordinates == LightCoordinates::Learned { terms } else { 0 };
        let found = self.light_map.as_ref().map_or(0, LightMap::terms);
        if found != expected {
            let allowed = format!("{expected}, as coordinates and degree require");
            return Err(rejected("terms of the light map", found, allowed));
        }
        finite("triangle", self.triangle.iter().copied())?;
        finite("colour", self.colour.iter().flatten().copied())?;
        let PwtErrors { lights: _, psnr, held_out_psnr, delta_e } = self.errors;
        finite("psnr", [psnr])?;
        finite("held-out psnr", [held_out_psnr])?;
        if !(delta_e.is_finite() && delta_e >= 0.0) {
            return Err(rejected("delta E", delta_e, "0 or more"));
        }
        check_range("textures", self.textures.len(), 1..=MAX_TEXTURES)?;
        let mut finest = 0;
        for texture in &self.textures {
            if !(finest..=self.levels).contains(&texture.level) {
                let allowed = format!("{finest} to {}, none finer than the level before", self.levels);
                return Err(rejected("texture level", texture.level, allowed));
            }
            finest = texture.level;
            if ![1, 2, 4].contains(&texture.channels) {
                return Err(rejected("texture channels", texture.channels, "1, 2 or 4"));
            }
            let count = texture.components.len();
            if count == 0 || !count.is_multiple_of(texture.channels as usize) {
                return Err(rejected("components", count, format!("a positive multiple of {}", texture.channels)));
            }
            let (layers, views) = (texture.layers(), self.view_count());
            if layers.saturating_mul(views) > MAX_ARRAY_LAYERS {
                let allowed = format!("at most {MAX_ARRAY_LAYERS} in all");
                return Err(rejected("layers of a texture", format!("{layers} for each of {views} views"), allowed));
            }
        }
        let count = self.components().count();
        if count > MAX_COMPONENTS {
            return Err(rejected("components", count, format!("at most {MAX_COMPONENTS} in all")));
        }
        for component in self.components() {
            check_range("component channel", component.channel, 0..=2)?;
            if component.term as usize >= terms {
                return Err(rejected("component term", component.term, format!("less than {terms}")));
            }
            finite("component scale", [component.scale])?;
            finite("component low", [component.low])?;
        }
        Ok(())
    }

    /// Value for [`PWT_ENTRY`].
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
        words.push(self.light_map.as_ref().map_or(0, LightMap::side));
        words.push(self.view_count());
        words.extend(self.triangle.iter().map(|c| c.to_bits()));
        for texture in &self.textures {
            words.extend([texture.level, texture.channels, texture.components.len() as u32]);
            for Component { channel, term, scale, low } in &texture.components {
                words.extend([*channel, *term, scale.to_bits(), low.to_bits()]);
            }
        }
        words.into_iter().flat_map(u32::to_le_bytes).collect()
    }

    /// Reads the value of [`PWT_ENTRY`].
    pub(super) fn from_bytes(bytes: &[u8], map: MapReader<'_>, mesh: MeshReader<'_>) -> Result<Self, FormatError> {
        // Offsets within a value are not offsets in the file.
        let named = |error: FormatError| match error.place {
            Place::Whole => error,
            _ => FormatError { place: Place::Whole, field: format!("{PWT_ENTRY} {}", error.field).into(), ..error },
        };
        let (mut header, side, views) = Self::read(bytes).map_err(named)?;
        check_range("views", views, 1..=MAX_VIEWS)?;
        if views > 1 {
            header.views = Some(mesh(views)?);
        }
        let is_learned = header.basis.coordinates == LightCoordinates::Learned;
        if is_learned {
            check_range("side of the light map", side, MAP_SIDES)?;
            header.light_map = Some(map(side, header.basis.terms())?);
        } else if side != 0 {
            return Err(rejected("side of the light map", side, "0 without learned terms"));
        }
        header.check()?;
        Ok(header)
    }

    /// Header without its light map and views, the side of the map and the number of views.
    fn read(bytes: &[u8]) -> Result<(Self, u32, u32), FormatError> {
        if bytes.len() < FIXED_BYTES {
            return Err(rejected("length", format!("{} bytes", bytes.len()), format!("{FIXED_BYTES} bytes or more")));
        }
        let mut cursor = Cursor::new(bytes);
        let version = cursor.u32("version")?;
        if version != VERSION {
            return Err(rejected("version", version, VERSION.to_string()));
        }
        let size = [cursor.u32("size")?, cursor.u32("size")?];
        let extent = [cursor.u32("extent")?, cursor.u32("extent")?];
        let repeats = match cursor.u32("repeats")? {
            flag @ (0 | 1) => flag == 1,
            found => return Err(rejected("repeats", found, "0 or 1")),
        };
        let levels = cursor.u32("levels")?;
        let coordinates = cursor.u32("coordinates")?;
        let coordinates = *LightCoordinates::ALL
            .get(coordinates as usize)
            .ok_or_else(|| rejected("coordinates", coordinates, format!("0 to {}", LightCoordinates::ALL.len() - 1)))?;
        let degree = cursor.u32("degree")?;
        // Checked before the number of terms is derived from it.
        check_range("degree", degree, 0..=coordinates.max_degree())?;
        let basis = LightBasis { coordinates, degree };
        let domain = cursor.u32("domain")?;
        let textures = cursor.u32("textures")?;
        check_range("textures", textures, 1..=MAX_TEXTURES as u32)?;
        let epsilon = cursor.f32("epsilon")?;
        let domain = Domain::from_code(domain, epsilon).ok_or_else(|| rejected("domain", domain, "0 to 3"))?;
        // Unused fields must be 0.
        if domain.code().1.to_bits() != epsilon.to_bits() {
            return Err(rejected("epsilon", epsilon, format!("0, because the domain is {}", domain.name())));
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
        let side = cursor.u32("side of the light map")?;
        let views = cursor.u32("views")?;
        let triangle = (0..triangle_numbers(basis)).map(|_| cursor.f32("triangle")).collect::<Result<_, _>>()?;
        let textures = (0..textures).map(|_| read_texture(&mut cursor)).collect::<Result<_, _>>()?;
        if cursor.remaining() > 0 {
            let allowed = format!("{} bytes, as its fields say", cursor.position());
            return Err(rejected("length", format!("{} bytes", bytes.len()), allowed));
        }
        let header = Self {
            size,
            extent,
            repeats,
            levels,
            basis,
            views: None,
            domain,
            colour,
            triangle,
            light_map: None,
            textures,
            errors,
        };
        Ok((header, side, views))
    }
}

/// Numbers of the triangle of a basis.
fn triangle_numbers(basis: LightBasis) -> usize {
    if basis.coordinates == LightCoordinates::Learned { 0 } else { basis.terms() * (basis.terms() + 1) / 2 }
}

fn read_texture(cursor: &mut Cursor<'_>) -> Result<TextureHeader, FormatError> {
    let level = cursor.u32("texture level")?;
    let channels = cursor.u32("texture channels")?;
    let count = cursor.u32("components")?;
    if count as usize > MAX_COMPONENTS {
        return Err(rejected("components", count, format!("at most {MAX_COMPONENTS}")));
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
