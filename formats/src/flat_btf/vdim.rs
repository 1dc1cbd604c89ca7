//! View-dependent indirection maps (VDIM): the parameters that sampled views see through each texel of the reference plane,
//! packed so that a sampler blends views and never texels (sections 3.4 and 3.5 of Hadim et al. 2009).

use super::compact::CompactSamples;
use super::layout::{check_image, half_pair_bytes, half_pairs, rounded_pairs, word};
use super::vdim_header::{COMPACT, VDIM, VDIM_PART, VdimHeader};
use super::{MAX_DISPLACEMENT, MAX_HEIGHT};
use crate::FormatError;
use crate::container::entries::{entry, sized};
use crate::container::{TexelFormat, Texture, half};
use crate::cursor::Cursor;
use crate::direction::polynomial_atan2;
use crate::tap::{Tap, footprint, wrap};
use std::borrow::Cow;
use std::f32::consts::TAU;

const VERSION: u32 = 1;
const BYTES: usize = 24;
/// Part that holds `R`.
const REFERENCE_PART: &str = "reference";
/// Largest difference of the length of a direction from 1: rounding to halves.
const UNIT_TOLERANCE: f32 = 1.0 / 512.0;

/// Checks each texel, the pole and the seam of each block.
fn check_blocks(header: &VdimHeader, packed: &[[u16; 4]]) -> Result<(), FormatError> {
    let (polar, rows) = (header.polar_angles as usize, header.azimuth_rows as usize);
    let mut left = packed;
    for level in 0..header.levels {
        let side = header.side(level) as usize;
        let width = side * polar;
        let (texels, rest) = left.split_at(width * side * rows);
        left = rest;
        for (row, line) in texels.chunks_exact(width).enumerate() {
            for (column, texel) in line.iter().enumerate() {
                let next = line[if column % polar == 0 { column + 1 } else { column }];
                let first = texels[row / rows * rows * width + column];
                let same_as = if row % rows == rows - 1 { first } else { *texel };
                if let Some(allowed) = problem(*texel, column % polar == 0, next, same_as) {
                    let field = format!("{VDIM_PART} texel ({column}, {row}) of level {level}");
                    return Err(FormatError::whole(field, format!("{:?}", texel.map(half::decode)), allowed));
                }
            }
        }
    }
    Ok(())
}

/// The point that one view sees through a texel of the reference plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenPoint {
    /// Displacement `Δ_v` of its parameters from the reference, in tiles, not wrapped.
    pub displacement: [f32; 2],
    /// Height above the reference plane, in tiles.
    pub height: f32,
}

/// A view-dependent indirection map: equation 2, `VDIM_v(i, j) = R(i, j) + Δ_v(i, j)`, with the displacement
/// `Δ_v = d_v δ_v` of equation 3 as distance and unit direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Vdim {
    header: VdimHeader,
    /// `R` of all levels, row by row: parameters that the view along the normal sees less the centre of the texel, in tiles.
    /// Exactly halves.
    reference: Vec<[f32; 2]>,
    samples: VdimSamples,
}

/// Samples of an indirection map, on all its levels.
#[derive(Debug, Clone, PartialEq)]
pub enum VdimSamples {
    /// Halves `(δ_x, δ_y, d, z)`, row by row of the packed map.
    Halves(Vec<[u16; 4]>),
    /// Two bytes for a block of texels.
    Compact(CompactSamples),
}

impl Vdim {
    /// Creates a map from all levels of both images. The reference is rounded to halves.
    ///
    /// # Errors
    /// Returns an error if the header is out of range, lengths do not match it, or texels violate
    /// `formats/src/flat_btf/spec.md`.
    pub fn new(header: VdimHeader, reference: Vec<[f32; 2]>, samples: VdimSamples) -> Result<Self, FormatError> {
        header.check()?;
        header.check_length(REFERENCE_PART, reference.len(), header.reference_extent())?;
        let reference = rounded_pairs(reference, |at| format!("texel {at} of the part {REFERENCE_PART}"))?;
        let samples = match samples {
            VdimSamples::Halves(packed) => {
                header.check_length(VDIM_PART, packed.len(), header.packed_extent())?;
                check_blocks(&header, &packed)?;
                VdimSamples::Halves(packed)
            }
            VdimSamples::Compact(samples) => VdimSamples::Compact(samples.check(&header)?),
        };
        Ok(Self { header, reference, samples })
    }

    /// Creates a map of one level. `reference` has the parameters that the view along the normal sees less the centre of
    /// each texel, row by row; `seen([i, j], k, a)` is what view `(k, a)` sees through texel `(i, j)`, for `a` below
    /// `R - 1`, and its displacement at the pole, `k = 0`, is ignored.
    ///
    /// # Errors
    /// Same as [`Self::new`].
    pub fn of_views(
        header: VdimHeader,
        reference: Vec<[f32; 2]>,
        seen: impl Fn([u32; 2], u32, u32) -> SeenPoint,
    ) -> Result<Self, FormatError> {
        header.check()?;
        let width = (header.size * header.polar_angles) as usize;
        let mut packed = Vec::with_capacity(width * (header.size * header.azimuth_rows) as usize);
        for j in 0..header.size {
            let first = packed.len();
            for a in 0..header.azimuth_rows - 1 {
                for i in 0..header.size {
                    let pole = packed.len();
                    packed.extend((0..header.polar_angles).map(|k| encode(seen([i, j], k, a))));
                    // With the direction of the next sample, blending the two changes only the distance.
                    let [x, y, ..] = packed[pole + 1];
                    packed[pole] = [x, y, 0, packed[pole][3]];
                }
            }
            packed.extend_from_within(first..first + width);
        }
        Self::new(VdimHeader { levels: 1, ..header }, reference, VdimSamples::Halves(packed))
    }

    /// Joins maps of one level each, every one half as large as the one before.
    ///
    /// # Errors
    /// Returns an error if the sizes are others, or if some samples are compact and others are not.
    pub fn of_levels(levels: Vec<Self>) -> Result<Self, FormatError> {
        let count = levels.len() as u32;
        let mut levels = levels.into_iter();
        let Some(mut joined) = levels.next() else {
            return Err(FormatError::whole("levels of a map", "0", "1 or more"));
        };
        for level in levels {
            joined.reference.extend(level.reference);
            match (&mut joined.samples, level.samples) {
                (VdimSamples::Halves(packed), VdimSamples::Halves(more)) => packed.extend(more),
                (VdimSamples::Compact(samples), VdimSamples::Compact(more)) => {
                    samples.ranges.extend(more.ranges);
                    samples.packed.extend(more.packed);
                    samples.heights.extend(more.heights);
                }
                _ => return Err(FormatError::whole("levels of a map", "two forms of samples", "one form")),
            }
        }
        Self::new(VdimHeader { levels: count, ..joined.header }, joined.reference, joined.samples)
    }

    /// Sizes of the map, and the views of its samples.
    pub fn header(&self) -> &VdimHeader {
        &self.header
    }

    /// Texels of the reference in GPU layout.
    pub fn reference_bytes(&self) -> Vec<u8> {
        half_pair_bytes(&self.reference)
    }

    /// Texels of the packed map in GPU layout.
    pub fn packed_bytes(&self) -> Cow<'_, [u8]> {
        match &self.samples {
            VdimSamples::Halves(packed) => packed.iter().flatten().flat_map(|half| half.to_le_bytes()).collect(),
            VdimSamples::Compact(samples) => Cow::Borrowed(samples.packed.as_flattened()),
        }
    }

    /// Samples of the views.
    pub fn samples(&self) -> &VdimSamples {
        &self.samples
    }

    /// `R(i, j)` less the centre of the texel, in tiles.
    ///
    /// # Panics
    /// Panics if there is no such texel or level.
    pub fn reference(&self, [i, j]: [u32; 2], level: u32) -> [f32; 2] {
        let first = self.header.reference_extent().texels_of_levels(level) as usize;
        self.reference[first + (j * self.header.side(level) + i) as usize]
    }

    /// Index of sample `(k, a)` of a block in the packed map.
    fn index(&self, [i, j]: [u32; 2], k: u32, a: u32, level: u32) -> usize {
        let VdimHeader { block, polar_angles, azimuth_rows, .. } = self.header;
        let first = self.header.packed_extent().texels_of_levels(level) as usize;
        let (column, row) = (i * polar_angles + k, j * azimuth_rows + a);
        first + (row * (self.header.side(level) / block * polar_angles) + column) as usize
    }

    /// Parameters, not wrapped, and height in tiles of the surface point that `view` sees behind the point `uv` of the
    /// reference plane. `uv` is in tiles and unbounded, `view` a unit vector in the frame along u and v. `detail` is the level
    /// of the map, 0 the finest.
    ///
    /// The texel at `uv` and the four views around `view` count: directions are blended over the azimuth and normalised,
    /// distances are blended linearly (equation 3). Compact samples are blended in the frame of the view. The parameters
    /// move with `uv` within a texel.
    pub fn seen(&self, uv: [f32; 2], view: [f32; 3], detail: f32) -> ([f32; 2], f32) {
        let level = self.header.level(detail);
        let side = self.header.side(level);
        let texel = uv.map(|c| ((wrap(c) * side as f32) as u32).min(side - 1));
        let block = texel.map(|at| at / self.header.block);
        let [u, v] = self.reference(texel, level);
        let at = |[x, y]: [f32; 2]| [uv[0] + (u + x), uv[1] + (v + y)];
        match &self.samples {
            VdimSamples::Halves(packed) => {
                let [x, y, distance, height] =
                    self.blended(view, |k, a| packed[self.index(block, k, a, level)].map(half::decode));
                let length = (x * x + y * y).sqrt();
                let scale = if length > 0.0 { distance / length } else { 0.0 };
                (at([scale * x, scale * y]), height)
            }
            VdimSamples::Compact(samples) => {
                let blended = self.blended(view, |k, a| samples.sample(self.index(block, k, a, level)));
                let parameters = at(samples.displacement(&self.header, block, level, blended, view));
                (parameters, samples.height(&self.header, parameters, detail))
            }
        }
    }

    /// Blends the four samples `(k, a)` around a view.
    fn blended<const N: usize>(&self, view: [f32; 3], sample: impl Fn(u32, u32) -> [f32; N]) -> [f32; N] {
        let [polar, azimuth] = self.position(view);
        let mut blended = [0.0f32; N];
        for ([k, a], weight) in
            footprint(between(polar, self.header.polar_angles - 1), between(azimuth, self.header.azimuth_rows - 1))
        {
            let sample = sample(k, a);
            (0..N).for_each(|c| blended[c] += weight * sample[c]);
        }
        blended
    }

    /// Parameters, in [0, 1), that `view` sees through the centre of each texel of the finest level, row by row.
    pub fn parameters(&self, view: [f32; 3]) -> Vec<[f32; 2]> {
        let size = self.header.size;
        let centre = |at: u32| (at as f32 + 0.5) / size as f32;
        let seen = |at: u32| self.seen([centre(at % size), centre(at / size)], view, 0.0).0.map(wrap);
        (0..size * size).map(seen).collect()
    }

    /// Position of a view among the samples of a block: the polar angle in columns, the azimuth in rows.
    fn position(&self, [x, y, z]: [f32; 3]) -> [f32; 2] {
        let VdimHeader { polar_angles, azimuth_rows, largest_angle, .. } = self.header;
        let polar = polynomial_atan2((x * x + y * y).sqrt(), z).min(largest_angle);
        let half_turn = polynomial_atan2(y.abs(), x);
        let azimuth = if y < 0.0 { TAU - half_turn } else { half_turn };
        [polar / largest_angle * (polar_angles - 1) as f32, azimuth / TAU * (azimuth_rows - 1) as f32]
    }

    /// Keys and values of the headers.
    pub(super) fn entries(&self) -> Vec<(String, Vec<u8>)> {
        let VdimHeader { size, polar_angles, azimuth_rows, largest_angle, lights, .. } = self.header;
        let words = [VERSION, size, polar_angles, azimuth_rows, largest_angle.to_bits(), lights];
        let mut entries = vec![(VDIM.to_owned(), words.into_iter().flat_map(u32::to_le_bytes).collect())];
        if let VdimSamples::Compact(samples) = &self.samples {
            entries.push(samples.entry(&self.header));
        }
        entries
    }

    /// Reads and validates the images of a file. The packed map has the headers. `others` reads heights and ranges, which
    /// compact samples require.
    pub(super) fn from_textures(
        packed: &Texture,
        reference: &Texture,
        others: impl FnOnce() -> Result<[Texture; 2], FormatError>,
    ) -> Result<Self, FormatError> {
        let bytes = sized(entry(packed, VDIM, "an indirection map of a flat BTF")?, VDIM, BYTES)?;
        let mut cursor = Cursor::new(bytes);
        word(&mut cursor, VDIM, "version", VERSION..=VERSION)?;
        let mut header = VdimHeader {
            size: cursor.u32("size")?,
            block: 1,
            polar_angles: cursor.u32("polar angles")?,
            azimuth_rows: cursor.u32("azimuth rows")?,
            largest_angle: cursor.f32("largest angle")?,
            lights: cursor.u32("lights")?,
            levels: packed.levels,
        };
        let compact = packed.entries.contains_key(COMPACT).then(|| CompactSamples::read_header(packed)).transpose()?;
        header.block = compact.map_or(1, |(block, _)| block);
        header.check()?;
        let format = if compact.is_some() { TexelFormat::Rg8Unorm } else { TexelFormat::Rgba16Float };
        for (part, texture, format, extent) in [
            (VDIM_PART, packed, format, header.packed_extent()),
            (REFERENCE_PART, reference, TexelFormat::Rg16Float, header.reference_extent()),
        ] {
            check_image(texture, part, (format, extent, header.levels), VDIM)?;
        }
        let samples = match compact {
            Some((_, range)) => VdimSamples::Compact(CompactSamples::from_textures(&header, range, packed, others()?)?),
            None => {
                let quads = packed.texels.as_chunks::<2>().0.as_chunks::<4>().0;
                VdimSamples::Halves(quads.iter().map(|quad| quad.map(u16::from_le_bytes)).collect())
            }
        };
        Self::new(header, half_pairs(&reference.texels), samples)
    }
}

/// Splits a displacement into direction and length, as halves.
fn encode(SeenPoint { displacement, height }: SeenPoint) -> [u16; 4] {
    let [x, y] = displacement.map(f64::from);
    let distance = x.hypot(y);
    let rounded = half::encode(distance as f32);
    let direction = if rounded == 0 { [0.0; 2] } else { [x / distance, y / distance] };
    let [x, y] = direction.map(|c| half::encode(c as f32));
    [x, y, rounded, half::encode(height)]
}

/// The values that are allowed instead of a texel, unless it is valid. `next` is the texel after a pole; `same_as` must have the same bits.
fn problem(texel: [u16; 4], is_pole: bool, next: [u16; 4], same_as: [u16; 4]) -> Option<String> {
    let [x, y, distance, height] = texel.map(half::decode);
    if !((0.0..=MAX_DISPLACEMENT).contains(&distance) && height.abs() <= MAX_HEIGHT) {
        return Some(format!("a distance of 0 to {MAX_DISPLACEMENT} and a height of -{MAX_HEIGHT} to {MAX_HEIGHT}"));
    }
    let is_unit = (x * x + y * y - 1.0).abs() <= 2.0 * UNIT_TOLERANCE;
    if !(is_unit || [x, y, distance] == [0.0; 3]) {
        return Some("a unit direction, or 0 with a distance of 0".to_owned());
    }
    if is_pole && (distance != 0.0 || texel[..2] != next[..2]) {
        return Some("a distance of 0 and the direction of the next sample, at the pole".to_owned());
    }
    (texel != same_as).then(|| "in the last row of a block, the value of its first row".to_owned())
}

/// Samples around a position of 0 to `last`.
fn between(position: f32, last: u32) -> Tap {
    let lower = (position as u32).min(last - 1);
    Tap { samples: [lower, lower + 1], weight: position - lower as f32 }
}
