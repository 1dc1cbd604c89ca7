//! Arranges terms at their levels as textures: one fetch per layer of one, two or four channels.

use crate::levels::{BASES, TermImages, range};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{
    Component, MAX_ARRAY_LAYERS, MAX_COMPONENTS, MAX_TEXTURES, PwtHeader, PwtPack, TextureHeader,
};

/// Maximum components per texel.
pub const CHANNELS: usize = 4;

/// Number of channels that begin at each level: 0, 1, 2 or whole layers of four.
type Slots = [usize; BASES as usize];

/// Terms in layers, and the error that they leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    slots: Slots,
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
    /// Number of views.
    pub views: u32,
    /// Maximum number of layers of a view.
    pub layers: usize,
    /// Maximum bytes on a GPU, all levels included.
    pub bytes: u64,
}

impl Limits {
    /// Bytes of a channel that begins at a level.
    fn channel(&self, level: usize) -> u64 {
        let texels = |level: u32| u64::from(self.extent[0] >> level) * u64::from(self.extent[1] >> level);
        u64::from(self.views) * (level as u32..=self.depth).map(texels).sum::<u64>()
    }

    /// Returns true if a number of channels at each level is within the limits.
    fn allow(&self, slots: &Slots) -> bool {
        let textures = slots.iter().map(|count| count.div_ceil(channels_of_texture(self.views))).sum::<usize>();
        layers(slots) <= self.layers && textures <= MAX_TEXTURES && self.bytes(slots) <= self.bytes
    }

    fn bytes(&self, slots: &Slots) -> u64 {
        slots.iter().enumerate().map(|(level, count)| *count as u64 * self.channel(level)).sum()
    }
}

/// Maximum number of channels of a texture with so many views.
fn channels_of_texture(views: u32) -> usize {
    CHANNELS * (MAX_ARRAY_LAYERS / views) as usize
}

/// Number of layers: fetches.
fn layers(slots: &Slots) -> usize {
    slots.iter().map(|count| count.div_ceil(CHANNELS)).sum()
}

/// Larger numbers of channels at a level: the next one, and a layer more if that is another.
fn more(count: usize) -> impl Iterator<Item = usize> {
    let next = if count < CHANNELS { (2 * count).max(1) } else { count + CHANNELS };
    [next, CHANNELS].into_iter().take(if next < CHANNELS { 2 } else { 1 })
}

/// Smaller numbers of channels: the next one, and a layer less if that is another.
fn fewer(count: usize) -> impl Iterator<Item = usize> {
    let next = if count <= CHANNELS { count / 2 } else { count - CHANNELS };
    [next, 0].into_iter().take(if (1..CHANNELS).contains(&next) { 2 } else { 1 })
}

/// Arrangements of decreasing error, from none to all that fit the limits. Each adds channels or begins some at a finer level:
/// the change that reduces the error most per byte.
pub fn arrangements(images: &[TermImages], limits: &Limits) -> Vec<Arrangement> {
    let bases = (BASES.min(limits.depth + 1)) as usize;
    // Small layers take no more fetches than whole ones.
    let layers = limits.layers.min(MAX_COMPONENTS / CHANNELS).min(images.len().div_ceil(CHANNELS));
    let limits = &Limits { layers, ..*limits };
    let mut path = vec![Arrangement::of(images, [0; BASES as usize])];
    loop {
        let last = &path[path.len() - 1];
        let mut changes = Vec::new();
        for level in 0..bases {
            for count in more(last.slots[level]) {
                let mut slots = last.slots;
                slots[level] = count;
                changes.push(slots);
                for from in (level + 1..bases).filter(|from| last.slots[*from] > 0) {
                    for rest in fewer(last.slots[from]) {
                        slots[from] = rest;
                        changes.push(slots);
                    }
                    slots[from] = last.slots[from];
                }
            }
        }
        let before = limits.bytes(&last.slots);
        let gains = changes.into_iter().filter(|slots| limits.allow(slots)).filter_map(|slots| {
            let next = Arrangement::of(images, slots);
            // Some changes take no more bytes.
            let bytes = limits.bytes(&slots).saturating_sub(before).max(1);
            let gain = last.error - next.error;
            (gain > 0.0).then_some((gain / bytes as f64, next))
        });
        match gains.reduce(|best, other| if other.0 > best.0 { other } else { best }) {
            Some((_, next)) => path.push(next),
            None => return path,
        }
    }
}

impl Arrangement {
    /// All terms from one level on.
    pub fn all_from(images: &[TermImages], level: u32) -> Self {
        let mut slots = [0; BASES as usize];
        slots[level as usize] = images.len().next_multiple_of(CHANNELS);
        let terms = (0..images.len()).map(|image| (level, image)).collect();
        Self { slots, terms, error: images.iter().map(|image| image.errors[level as usize]).sum() }
    }

    /// The terms that profit most from the channels of each level. Terms that are not stored at all lose least.
    fn of(images: &[TermImages], slots: Slots) -> Self {
        let used: Vec<usize> = (0..slots.len()).filter(|level| slots[*level] > 0).collect();
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
            left.truncate(slots.iter().sum());
            for (k, level) in used.iter().enumerate() {
                sort(&mut left, used.get(k + 1).copied(), *level);
                let rest = left.split_off(slots[*level].min(left.len()));
                left.sort_unstable();
                terms.extend(left.into_iter().map(|image| (*level as u32, image)));
                left = rest;
            }
        }
        for (level, image) in &terms {
            error -= none(*image) - images[*image].errors[*level as usize];
        }
        Self { slots, terms, error: if error < 0.0 { 0.0 } else { error } }
    }

    /// Bytes on a GPU, all levels included.
    pub fn bytes(&self, limits: &Limits) -> u64 {
        limits.bytes(&self.slots)
    }

    /// Builds the pack. Uses all of the header except the textures.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn pack(&self, images: &[TermImages], mut header: PwtHeader) -> Result<PwtPack, FormatError> {
        let mut texels = Vec::new();
        header.textures.clear();
        for (level, count) in (0..).zip(self.slots).filter(|(_, count)| *count > 0) {
            let here = self.terms.iter().filter(|(at, _)| *at == level).map(|(_, image)| Some(*image));
            let mut slots: Vec<Option<usize>> = here.collect();
            slots.resize(count, None);
            let component = |slot: &Option<usize>| {
                let Some(image) = slot.map(|k| &images[k]) else { return Component::NONE };
                let (low, high) = range(&image.levels[level as usize..]);
                Component { channel: image.channel as u32, term: image.term as u32, scale: high - low, low }
            };
            let channels = count.min(CHANNELS);
            for slots in slots.chunks(channels_of_texture(header.view_count())) {
                let components: Vec<Component> = slots.iter().map(component).collect();
                texels.push(texels_of(images, level, channels, slots, &components));
                header.textures.push(TextureHeader { level, channels: channels as u32, components });
            }
        }
        if header.textures.is_empty() {
            // No term is worth a byte: the pack shows the mean of learned terms, otherwise 0 of the domain.
            let depth = header.levels;
            header.textures.push(TextureHeader { level: depth, channels: 1, components: vec![Component::NONE] });
            let [width, height] = header.extent.map(|side| (side >> depth) as usize);
            texels.push(vec![0; width * height * header.view_count() as usize]);
        }
        PwtPack::new(header, texels)
    }
}

/// Texels of a texture: all mipmap levels, layer by layer, with the views of each layer in turn.
fn texels_of(
    images: &[TermImages],
    level: u32,
    channels: usize,
    slots: &[Option<usize>],
    components: &[Component],
) -> Vec<u8> {
    let depth = images.first().map_or(0, |image| image.levels.len());
    let mut texels = Vec::new();
    for own in level as usize..depth {
        for (slots, components) in slots.chunks_exact(channels).zip(components.chunks_exact(channels)) {
            let start = texels.len();
            let count = images[0].levels[own].values.len();
            texels.resize(start + count * channels, 0);
            for (k, (slot, component)) in slots.iter().zip(components).enumerate() {
                let Some(image) = slot.map(|k| &images[k]) else { continue };
                let inverse = if component.scale > 0.0 { 255.0 / component.scale } else { 0.0 };
                let targets = texels[start + k..].iter_mut().step_by(channels);
                for (target, value) in targets.zip(&image.levels[own].values) {
                    *target = ((value - component.low) * inverse).round() as u8;
                }
            }
        }
    }
    texels
}
