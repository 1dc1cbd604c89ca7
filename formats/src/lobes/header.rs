//! Lobes and sizes of a pack.

use crate::FormatError;
use crate::container::Extent;
use crate::cursor::{Cursor, block_bytes};

/// Key that identifies a pack of lobes.
pub const LOBES_ENTRY: &str = "brdfc.lobes";

const VERSION: u32 = 2;
/// Maximum number of lobes, that is, of look-ups in an environment.
pub const MAX_LOBES: usize = 32;
/// Maximum number of view angles.
pub const MAX_NODES: u32 = 64;
/// Maximum number of view azimuths.
pub const MAX_AZIMUTHS: u32 = 32;
/// Maximum sharpness of a lobe: that of the largest environment.
pub const MAX_SHARPNESS: f32 = 9.0;
/// Maximum scale of weights; the minimum is its inverse.
pub const MAX_SCALE: f32 = (1u64 << 63) as f32;
/// Maximum size of a tilt.
const MAX_TILT: f32 = 16.0;
/// Bytes before the lobes.
const START: usize = 28;
/// Bytes of a lobe.
const LOBE: usize = 16;

/// Direction that a lobe follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Anchor {
    /// The normal, for diffuse reflection.
    Normal,
    /// The mirror direction, for highlights.
    Mirror,
    /// The direction to the viewer, for retroreflection.
    Viewer,
}

impl Anchor {
    /// All anchors, by their numbers in files.
    pub const ALL: [Self; 3] = [Self::Normal, Self::Mirror, Self::Viewer];

    pub(super) fn code(self) -> u32 {
        self as u32
    }
}

/// A look-up in the environment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lobe {
    /// Direction that the lobe follows.
    pub anchor: Anchor,
    /// Slope in the plane of view and across it: of the direction for [`Anchor::Normal`], of the half vector for the
    /// others. Anisotropic materials have both along tangent and bitangent instead.
    pub tilt: [f32; 2],
    /// Row of its weights. The two lobes of a pair, on either side of the plane of view, share one.
    pub row: u32,
}

/// Sizes and lobes of a pack.
#[derive(Debug, Clone, PartialEq)]
pub struct LobesHeader {
    /// Number of view angles with weights, 2 to [`MAX_NODES`].
    pub nodes: u32,
    /// Number of view azimuths with weights: 1 for isotropic materials, up to [`MAX_AZIMUTHS`] for others.
    pub azimuths: u32,
    /// Number of rows of weights, 1 to [`MAX_LOBES`].
    pub rows: u32,
    /// Factor of all weights, 2⁻⁶³ to 2⁶³.
    pub scale: f32,
    /// Mean and 95th percentile of ΔE (CIE76) of renderings of a ball, against the integral over all directions, 0 or more.
    pub delta_e: [f32; 2],
    /// The lobes, 1 to [`MAX_LOBES`].
    pub lobes: Vec<Lobe>,
}

impl LobesHeader {
    /// Size of the uniform block, bytes.
    pub const UNIFORM_SIZE: usize = 16 + LOBE * MAX_LOBES;

    /// The uniform block `LobesParameters`.
    pub fn uniform(&self) -> [u8; Self::UNIFORM_SIZE] {
        let sizes = [self.lobes.len() as u32, self.nodes, self.azimuths, self.scale.to_bits()];
        block_bytes(sizes.into_iter().chain(self.words()))
    }

    /// Checks all ranges.
    ///
    /// # Errors
    /// Returns an error that names the field that is out of range.
    pub fn check(&self) -> Result<(), FormatError> {
        FormatError::check_range(format!("{LOBES_ENTRY} nodes"), self.nodes, 2..=MAX_NODES)?;
        FormatError::check_range(format!("{LOBES_ENTRY} azimuths"), self.azimuths, 1..=MAX_AZIMUTHS)?;
        FormatError::check_range(format!("{LOBES_ENTRY} lobes"), self.lobes.len(), 1..=MAX_LOBES)?;
        FormatError::check_range(format!("{LOBES_ENTRY} rows"), self.rows, 1..=self.lobes.len() as u32)?;
        FormatError::check_range(format!("{LOBES_ENTRY} scale"), self.scale, 1.0 / MAX_SCALE..=MAX_SCALE)?;
        for error in self.delta_e {
            FormatError::check_range(format!("{LOBES_ENTRY} ΔE"), error, 0.0..=f32::MAX)?;
        }
        for (at, lobe) in self.lobes.iter().enumerate() {
            for tilt in lobe.tilt {
                FormatError::check_range(format!("{LOBES_ENTRY} tilt of lobe {at}"), tilt, -MAX_TILT..=MAX_TILT)?;
            }
            FormatError::check_range(format!("{LOBES_ENTRY} row of lobe {at}"), lobe.row, 0..=self.rows - 1)?;
        }
        Ok(())
    }

    fn words(&self) -> impl Iterator<Item = u32> + '_ {
        let words = |lobe: &Lobe| {
            let [x, y] = lobe.tilt.map(f32::to_bits);
            [x, y, lobe.anchor.code(), lobe.row]
        };
        self.lobes.iter().flat_map(words)
    }

    /// Extent of the texture: view angles, and the azimuths of each row.
    pub(super) fn extent(&self) -> Extent {
        Extent::D2([self.nodes, self.azimuths * self.rows])
    }

    /// True if weights do not depend on the azimuth of the view, and tilts turn with it.
    pub fn is_isotropic(&self) -> bool {
        self.azimuths == 1
    }

    /// Number of weights of a row: one for each view angle and azimuth.
    pub fn views(&self) -> usize {
        (self.nodes * self.azimuths) as usize
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let sizes = [VERSION, self.nodes, self.azimuths, self.rows];
        let [mean, p95] = self.delta_e;
        let numbers = [self.scale, mean, p95].map(f32::to_bits);
        sizes.into_iter().chain(numbers).chain(self.words()).flat_map(u32::to_le_bytes).collect()
    }

    pub(super) fn from_bytes(bytes: &[u8]) -> Result<Self, FormatError> {
        let count = bytes.len().saturating_sub(START) / LOBE;
        if bytes.len() != START + LOBE * count || !(1..=MAX_LOBES).contains(&count) {
            let allowed = format!("{START} bytes and {LOBE} for each of 1 to {MAX_LOBES} lobes");
            return Err(FormatError::whole(LOBES_ENTRY, format!("{} bytes", bytes.len()), allowed));
        }
        let mut cursor = Cursor::new(bytes);
        let version = cursor.u32("version")?;
        if version != VERSION {
            let field = format!("{LOBES_ENTRY} version");
            return Err(FormatError::whole(field, version.to_string(), VERSION.to_string()));
        }
        let (nodes, azimuths, rows) = (cursor.u32("nodes")?, cursor.u32("azimuths")?, cursor.u32("rows")?);
        let scale = f32::from_bits(cursor.u32("scale")?);
        let delta_e = [f32::from_bits(cursor.u32("ΔE")?), f32::from_bits(cursor.u32("ΔE")?)];
        let mut lobe = |at: usize| {
            let tilt = [f32::from_bits(cursor.u32("tilt")?), f32::from_bits(cursor.u32("tilt")?)];
            let (code, row) = (cursor.u32("anchor")?, cursor.u32("row")?);
            let anchor = Anchor::ALL.get(code as usize).copied();
            let anchor = anchor.ok_or_else(|| {
                FormatError::whole(format!("{LOBES_ENTRY} anchor of lobe {at}"), code.to_string(), "0 to 2")
            })?;
            Ok(Lobe { anchor, tilt, row })
        };
        let lobes = (0..count).map(&mut lobe).collect::<Result<_, FormatError>>()?;
        let header = Self { nodes, azimuths, rows, scale, delta_e, lobes };
        header.check()?;
        Ok(header)
    }
}
