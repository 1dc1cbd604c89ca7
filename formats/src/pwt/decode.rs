//! CPU decoder, the reference for shaders: f32 operations in a fixed order without fused operations.

use super::header::Weights;
use super::pack::PwtPack;
use crate::tap::Tap;
use std::ops::Range;

/// Decoder of one pack.
#[derive(Debug, Clone)]
pub struct PwtDecoder {
    pack: PwtPack,
}

impl PwtDecoder {
    /// Decoder of a pack.
    pub fn new(pack: PwtPack) -> Self {
        Self { pack }
    }

    /// The pack that the decoder evaluates.
    pub fn pack(&self) -> &PwtPack {
        &self.pack
    }

    /// Converts the decoder back to the pack.
    pub fn into_pack(self) -> PwtPack {
        self.pack
    }

    /// Linear RGB at a point of the image under a light, 0 or more; black if the light is not above the horizon. Values of
    /// up to three views are blended.
    ///
    /// `uv` is 0 to 1 across the image, down from its top. Outside, tiles repeat and other images are clamped to their
    /// border. `level` is the mipmap level, 0 at the full resolution of the image; fractions blend two levels. `view` and
    /// `light` are unit vectors; a pack of one view ignores `view`.
    pub fn value(&self, uv: [f32; 2], level: f32, view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        if light[2] <= 0.0 {
            return [0.0; 3];
        }
        let header = self.pack.header();
        let (weights, (views, shares)) = (header.weights(light), header.seen(view));
        let mut value = [0.0; 3];
        for (view, share) in views.into_iter().zip(shares).filter(|(_, share)| *share > 0.0) {
            let mut sum = self.sum(uv, level, view, &weights);
            header.domain.decode_each(&mut sum);
            (0..3).for_each(|c| value[c] += share * sum[c]);
        }
        value
    }

    /// RGB of a view at a point, in the domain of the pack: the sum over terms with weights from
    /// [`super::PwtHeader::weights`].
    ///
    /// # Panics
    /// Panics if the view does not exist.
    pub fn sum(&self, uv: [f32; 2], level: f32, view: u32, weights: &Weights) -> [f32; 3] {
        let header = self.pack.header();
        let mut uv = uv;
        for axis in 0..2 {
            uv[axis] = if header.repeats { uv[axis] - uv[axis].floor() } else { uv[axis].clamp(0.0, 1.0) };
            uv[axis] *= header.size[axis] as f32 / header.extent[axis] as f32;
        }
        let mut sum = header.constant(weights);
        let mut weights = header.component_weights(weights);
        for (index, texture) in header.textures.iter().enumerate() {
            let last = (self.pack.levels_of(index) - 1) as f32;
            let own = (level - texture.level as f32).clamp(0.0, last);
            let finer = own.floor();
            let blend = own - finer;
            let fine = self.taps(index, finer as u32, uv);
            let coarse = (blend > 0.0).then(|| self.taps(index, finer as u32 + 1, uv));
            for (k, component) in texture.components.iter().enumerate() {
                let mut texel = self.sample(index, (k, view), finer as u32, fine);
                if let Some(coarse) = coarse {
                    texel += blend * (self.sample(index, (k, view), finer as u32 + 1, coarse) - texel);
                }
                let value = component.low + component.scale * texel;
                let weight = weights.next().expect("one for each component");
                (0..3).for_each(|c| sum[c] += weight[c] * value);
            }
        }
        sum
    }

    /// Memory that [`Self::unpacked`] needs, bytes. Small files can need much: an image of 8192 x 8192 texels with a
    /// single coarse texture.
    pub fn unpacked_bytes(&self, level: u32) -> u64 {
        let header = self.pack.header();
        let texels: u64 =
            header.size.map(|side| u64::from(side.div_ceil(1 << level.min(header.levels)))).iter().product();
        4 * texels * header.components().count() as u64
    }

    /// Decompresses a mipmap level of the image of a view, 0 to [`super::PwtHeader::levels`], with all terms at its resolution,
    /// for drawing whole images. Larger levels give the coarsest. Values equal [`Self::sum`] at texel centres.
    ///
    /// # Panics
    /// Panics if the view does not exist.
    pub fn unpacked(&self, view: u32, level: u32) -> UnpackedLevel<'_> {
        let height = self.pack.header().size[1].div_ceil(1 << level.min(self.pack.header().levels));
        self.unpacked_rows(view, level, 0..height as usize)
    }

    /// Decompresses only some rows of [`Self::unpacked`], for images that are too large to hold as a whole.
    ///
    /// # Panics
    /// Panics if the view or the rows do not exist.
    pub fn unpacked_rows(&self, view: u32, level: u32, rows: Range<usize>) -> UnpackedLevel<'_> {
        let header = self.pack.header();
        let level = level.min(header.levels);
        let extent = header.extent.map(|side| side >> level);
        let size = header.size.map(|side| side.div_ceil(1 << level));
        assert!(rows.end <= size[1] as usize, "rows {rows:?} of {}", size[1]);
        let (left_out, first) = (rows.start, rows.start as u32);
        let size = [size[0], rows.len() as u32];
        let mut planes = Vec::new();
        for (index, texture) in header.textures.iter().enumerate() {
            let own = level.saturating_sub(texture.level).min(self.pack.levels_of(index) - 1);
            let (_, sides) = self.pack.level_of(index, own);
            let axis = |axis: usize, first: u32| -> Vec<Tap> {
                let scale = sides[axis] as f32 / extent[axis] as f32;
                let tap = |k: u32| Tap::new((k as f32 + 0.5) * scale, sides[axis], header.repeats);
                (first..first + size[axis]).map(tap).collect()
            };
            let (columns, rows) = (axis(0, 0), axis(1, first));
            for (k, component) in texture.components.iter().enumerate() {
                let filtered = self.filtered(index, (k, view), own, &columns, &rows);
                let values = filtered.into_iter().map(|texel| component.low + component.scale * texel).collect();
                planes.push(values);
            }
        }
        UnpackedLevel { decoder: self, left_out, size: size.map(|side| side as usize), planes }
    }

    /// [`Self::sample`] for all rows and columns; each row of texels is filtered once.
    fn filtered(
        &self,
        texture: usize,
        (component, view): (usize, u32),
        level: u32,
        columns: &[Tap],
        rows: &[Tap],
    ) -> Vec<f32> {
        let channels = self.pack.header().textures[texture].channels as usize;
        let (first, sides) = self.pack.level_of(texture, level);
        let [width, height] = sides.map(|side| side as usize);
        let layer = self.layer(texture, component, view) * width * height * channels;
        let layer = &self.pack.texels(texture)[first..][layer..];
        let along = |row: u32| -> Vec<f32> {
            let texels = layer[row as usize * width * channels..][..width * channels].iter();
            let texels: Vec<f32> =
                texels.skip(component % channels).step_by(channels).map(|t| f32::from(*t) * (1.0 / 255.0)).collect();
            let filter = |tap: &Tap| {
                let [left, right] = tap.samples.map(|x| texels[x as usize]);
                left + tap.weight * (right - left)
            };
            columns.iter().map(filter).collect()
        };
        let mut cached: [(u32, Vec<f32>); 2] = [(u32::MAX, Vec::new()), (u32::MAX, Vec::new())];
        let mut values = Vec::with_capacity(columns.len() * rows.len());
        for tap in rows {
            for (slot, row) in tap.samples.into_iter().enumerate() {
                if cached[slot].0 != row {
                    // The previous lower row is now the upper one.
                    let other = 1 - slot;
                    let line = if cached[other].0 == row { cached[other].1.clone() } else { along(row) };
                    cached[slot] = (row, line);
                }
            }
            let [(_, upper), (_, lower)] = &cached;
            values.extend(upper.iter().zip(lower).map(|(upper, lower)| upper + tap.weight * (lower - upper)));
        }
        values
    }

    fn taps(&self, texture: usize, level: u32, uv: [f32; 2]) -> [Tap; 2] {
        let (_, sides) = self.pack.level_of(texture, level);
        [0, 1].map(|axis| Tap::new(uv[axis] * sides[axis] as f32, sides[axis], self.pack.header().repeats))
    }

    /// Layer of a component of a view.
    fn layer(&self, texture: usize, component: usize, view: u32) -> usize {
        let header = self.pack.header();
        assert!(view < header.view_count(), "view {view} of {}", header.view_count());
        component / header.textures[texture].channels as usize * header.view_count() as usize + view as usize
    }

    /// Number of the texels of a level, 0 to 1, filtered along columns first.
    fn sample(&self, texture: usize, (component, view): (usize, u32), level: u32, [column, row]: [Tap; 2]) -> f32 {
        let channels = self.pack.header().textures[texture].channels as usize;
        let (first, [width, height]) = self.pack.level_of(texture, level);
        let layer = self.layer(texture, component, view) * (width * height) as usize;
        let texels = &self.pack.texels(texture)[first..];
        let at = |x: u32, y: u32| {
            let index = (layer + (y * width + x) as usize) * channels + component % channels;
            f32::from(texels[index]) * (1.0 / 255.0)
        };
        let along = |y: u32| {
            let [left, right] = column.samples.map(|x| at(x, y));
            left + column.weight * (right - left)
        };
        let [upper, lower] = row.samples.map(along);
        upper + row.weight * (lower - upper)
    }
}

/// A mipmap level of an image, decompressed for evaluation under many lights.
#[derive(Debug, Clone)]
pub struct UnpackedLevel<'a> {
    decoder: &'a PwtDecoder,
    /// Number of rows before the first that is held.
    left_out: usize,
    /// Columns, and rows that are held.
    size: [usize; 2],
    /// For each component, a value per texel of the image.
    planes: Vec<Vec<f32>>,
}

impl UnpackedLevel<'_> {
    /// Columns, and rows that are held.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Linear RGB of some rows of the level under the light of these weights.
    ///
    /// # Panics
    /// Panics if the rows are not held.
    pub fn rows(&self, rows: Range<usize>, weights: &Weights) -> Vec<[f32; 3]> {
        let header = self.decoder.pack.header();
        let width = self.size[0];
        let (constant, weights) = (header.constant(weights), header.component_weights(weights).collect::<Vec<_>>());
        let mut rendering = Vec::with_capacity(rows.len() * width);
        let mut sums = [vec![0.0f32; width], vec![0.0; width], vec![0.0; width]];
        for row in rows.start - self.left_out..rows.end - self.left_out {
            sums.iter_mut().zip(constant).for_each(|(sum, constant)| sum.fill(constant));
            for (values, weight) in self.planes.iter().zip(&weights) {
                let values = &values[row * width..][..width];
                for (sums, weight) in sums.iter_mut().zip(weight).filter(|(_, weight)| **weight != 0.0) {
                    sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
                }
            }
            sums.iter_mut().for_each(|sums| header.domain.decode_each(sums));
            rendering.extend((0..width).map(|x| [sums[0][x], sums[1][x], sums[2][x]]));
        }
        rendering
    }
}
