//! Arranges terms at their levels as textures of four channels: one fetch per layer.

use crate::levels::{BASES, TermImages, range};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{Component, MAX_COMPONENTS, PwtHeader, PwtPack, TextureHeader};

/// Components per texel.
const CHANNELS: usize = 4;

/// Terms in layers, and the error that they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    /// Number of layers that begin at each level.
    layers: [usize; BASES as usize],
    /// Level and term of each used channel, by level; terms are indices of [`TermImages`].
    terms: Vec<(u32, usize)>,
    /// Error of all terms: weighted squares.
    pub error: f64,
}

/// Limits of arrangements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Columns and rows at full resolution.
    pub extent: [u32; 2],
    /// Coarsest mipmap level.
    pub depth: u32,
    /// Maximum number of layers.
    pub layers: usize,
    /// Maximum bytes on a GPU, all levels included.
    pub bytes: u64,
}

impl Limits {
    /// Bytes of a layer that begins at a level.
    fn layer(&self, level: usize) -> u64 {
        let texels = |level: u32| u64::from(self.extent[0] >> level) * u64::from(self.extent[1] >> level);
        CHANNELS as u64 * (level as u32..=self.depth).map(texels).sum::<u64>()
    }

    fn bytes(&self, layers: &[usize]) -> u64 {
        layers.iter().enumerate().map(|(level, count)| *count as u64 * self.layer(level)).sum()
    }
}

/// Arrangements of increasing size, from none to all that fit the limits. Each adds a layer or begins one at a finer level:
/// the change that reduces the error most per byte.
pub fn arrangements(images: &[TermImages], limits: &Limits) -> Vec<Arrangement> {
    let bases = (BASES.min(limits.depth + 1)) as usize;
    let most = limits.layers.min(MAX_COMPONENTS / CHANNELS).min(images.len().div_ceil(CHANNELS));
    let mut path = vec![Arrangement::of(images, [0; BASES as usize])];
    loop {
        let last = &path[path.len() - 1];
        let mut changes = Vec::new();
        for level in 0..bases {
            let more = |from: Option<usize>| {
                let mut layers = last.layers;
                from.iter().for_each(|from| layers[*from] -= 1);
                layers[level] += 1;
                layers
            };
            if last.layers.iter().sum::<usize>() < most {
                changes.push(more(None));
            }
            changes.extend((level + 1..bases).filter(|from| last.layers[*from] > 0).map(|from| more(Some(from))));
        }
        let before = limits.bytes(&last.layers);
        let fitting = changes.into_iter().filter(|layers| limits.bytes(layers) <= limits.bytes);
        let gains = fitting.map(|layers| {
            let next = Arrangement::of(images, layers);
            ((last.error - next.error) / (limits.bytes(&layers) - before) as f64, next)
        });
        match gains.reduce(|best, other| if other.0 > best.0 { other } else { best }) {
            Some((gain, next)) if gain > 0.0 => path.push(next),
            _ => return path,
        }
    }
}

impl Arrangement {
    /// All terms from one level on.
    pub fn all_from(images: &[TermImages], level: u32) -> Self {
        let mut layers = [0; BASES as usize];
        layers[level as usize] = images.len().div_ceil(CHANNELS);
        let terms = (0..images.len()).map(|image| (level, image)).collect();
        Self { layers, terms, error: images.iter().map(|image| image.errors[level as usize]).sum() }
    }

    /// The terms that profit most from each layer. Terms that are not stored at all lose least.
    fn of(images: &[TermImages], layers: [usize; BASES as usize]) -> Self {
        let used: Vec<usize> = (0..layers.len()).filter(|level| layers[*level] > 0).collect();
        let none = |image: usize| images[image].errors[images[image].errors.len() - 1];
        let mut error: f64 = (0..images.len()).map(none).sum();
        let mut terms: Vec<(u32, usize)> = Vec::new();
        if let Some(coarsest) = used.last() {
            let mut left: Vec<usize> = (0..images.len()).collect();
            let gain = |image: usize, from: Option<usize>, to: usize| {
                from.map_or(none(image), |from| images[image].errors[from]) - images[image].errors[to]
            };
            let sort = |left: &mut Vec<usize>, from: Option<usize>, to: usize| {
                left.sort_by(|a, b| gain(*b, from, to).total_cmp(&gain(*a, from, to)).then(a.cmp(b)));
            };
            sort(&mut left, None, *coarsest);
            left.truncate(CHANNELS * used.iter().map(|level| layers[*level]).sum::<usize>());
            for (k, level) in used.iter().enumerate() {
                sort(&mut left, used.get(k + 1).copied(), *level);
                let rest = left.split_off((CHANNELS * layers[*level]).min(left.len()));
                left.sort_unstable();
                terms.extend(left.into_iter().map(|image| (*level as u32, image)));
                left = rest;
            }
        }
        for (level, image) in &terms {
            error -= none(*image) - images[*image].errors[*level as usize];
        }
        Self { layers, terms, error: error.max(0.0) }
    }

    /// Bytes on a GPU, all levels included.
    pub fn bytes(&self, limits: &Limits) -> u64 {
        limits.bytes(&self.layers)
    }

    /// Builds the pack. Uses all of the header except the textures.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn pack(&self, images: &[TermImages], mut header: PwtHeader) -> Result<PwtPack, FormatError> {
        let mut texels = Vec::new();
        header.textures.clear();
        for (level, count) in (0..).zip(self.layers).filter(|(_, count)| *count > 0) {
            let here = self.terms.iter().filter(|(at, _)| *at == level).map(|(_, image)| Some(*image));
            let mut slots: Vec<Option<usize>> = here.collect();
            slots.resize(CHANNELS * count, None);
            let component = |slot: &Option<usize>| {
                let Some(image) = slot.map(|k| &images[k]) else { return Component::NONE };
                let (low, high) = range(&image.levels[level as usize..]);
                Component { channel: image.channel as u32, term: image.term as u32, scale: high - low, low }
            };
            let components: Vec<Component> = slots.iter().map(component).collect();
            texels.push(texels_of(images, level, &slots, &components));
            header.textures.push(TextureHeader { level, channels: CHANNELS as u32, components });
        }
        if header.textures.is_empty() {
            // No term is worth a byte: the pack shows 0 of the domain, which is black except for logarithms.
            let depth = header.levels;
            header.textures.push(TextureHeader { level: depth, channels: 1, components: vec![Component::NONE] });
            texels.push(vec![0; (header.extent[0] >> depth) as usize * (header.extent[1] >> depth) as usize]);
        }
        PwtPack::new(header, texels)
    }
}

/// Texels of a texture: all mipmap levels, layer by layer.
fn texels_of(images: &[TermImages], level: u32, slots: &[Option<usize>], components: &[Component]) -> Vec<u8> {
    let depth = images.first().map_or(0, |image| image.levels.len());
    let mut texels = Vec::new();
    for own in level as usize..depth {
        for (slots, components) in slots.chunks_exact(CHANNELS).zip(components.chunks_exact(CHANNELS)) {
            let start = texels.len();
            let count = images[0].levels[own].values.len();
            texels.resize(start + count * CHANNELS, 0);
            for (k, (slot, component)) in slots.iter().zip(components).enumerate() {
                let Some(image) = slot.map(|k| &images[k]) else { continue };
                let inverse = if component.scale > 0.0 { 255.0 / component.scale } else { 0.0 };
                let targets = texels[start + k..].iter_mut().step_by(CHANNELS);
                for (target, value) in targets.zip(&image.levels[own].values) {
                    *target = ((value - component.low) * inverse).round() as u8;
                }
            }
        }
    }
    texels
}
