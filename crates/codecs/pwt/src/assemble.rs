//! Arranges terms at their levels as textures of 8 bits.

use crate::levels::{BASES, StepUp, TermImages, range};
use brdfc_formats::FormatError;
use brdfc_formats::pwt::{Component, PwtHeader, PwtPack, TextureHeader};

/// Share of all bytes that may be spent on padding texels to four channels, which saves fetches.
const SPENT_ON_FETCHES: f64 = 0.05;

/// Terms that begin at each level, as indices of [`TermImages`], and the number of channels per texel.
#[derive(Debug, Clone, PartialEq)]
pub struct Arrangement {
    textures: Vec<(u32, u32, Vec<Option<usize>>)>,
}

/// Arranges the result of the first `count` steps. Texels have 1, 2 or 4 channels; channels that would be empty hold
/// the terms that would come next.
pub fn arrange(images: &[TermImages], steps: &[StepUp], count: usize) -> Arrangement {
    let mut bases: Vec<Option<u32>> = vec![None; images.len()];
    steps[..count].iter().for_each(|step| bases[step.image] = Some(step.base));
    let size = |base: u32| 0.25f64.powi(base as i32);
    let total: f64 = bases.iter().flatten().map(|base| size(*base)).sum();
    let mut textures = Vec::new();
    for level in 0..BASES {
        let mut here: Vec<usize> = (0..images.len()).filter(|k| bases[*k] == Some(level)).collect();
        if here.is_empty() {
            continue;
        }
        let spare = |channels: usize| here.len().next_multiple_of(channels) - here.len();
        let fits = |channels: &usize| spare(*channels) as f64 * size(level) <= SPENT_ON_FETCHES * total;
        let channels = [4, 2].into_iter().find(fits).unwrap_or(1);
        let mut free = spare(channels);
        // Move coarser terms up, first the term that reduces the error most.
        while free > 0 {
            let gain = |k: &usize| {
                let errors = &images[*k].errors;
                errors[bases[*k].map_or(errors.len() - 1, |base| base as usize)] - errors[level as usize]
            };
            let coarser = (0..images.len()).filter(|k| {
                (level as usize) < images[*k].errors.len() - 1 && bases[*k].is_none_or(|base| base > level)
            });
            let Some(next) = coarser.max_by(|a, b| gain(a).total_cmp(&gain(b)).then(b.cmp(a))) else { break };
            if gain(&next) <= 0.0 {
                break;
            }
            bases[next] = Some(level);
            here.push(next);
            free -= 1;
        }
        here.sort_by_key(|k| (images[*k].channel, images[*k].term));
        let mut slots: Vec<Option<usize>> = here.into_iter().map(Some).collect();
        slots.resize(slots.len().next_multiple_of(channels), None);
        textures.push((level, channels as u32, slots));
    }
    Arrangement { textures }
}

impl Arrangement {
    /// All terms from one level on, in four channels per texel.
    pub fn all_from(images: &[TermImages], level: u32) -> Self {
        let mut slots: Vec<Option<usize>> = (0..images.len()).map(Some).collect();
        slots.resize(slots.len().next_multiple_of(4), None);
        Self { textures: vec![(level, 4, slots)] }
    }

    /// Bytes on a GPU for an image of these sides, all levels included.
    pub fn bytes(&self, extent: [u32; 2], depth: u32) -> u64 {
        let texels = |level: u32| u64::from(extent[0] >> level) * u64::from(extent[1] >> level);
        let of = |(level, _, slots): &(u32, u32, Vec<Option<usize>>)| {
            slots.len() as u64 * (*level..=depth).map(texels).sum::<u64>()
        };
        self.textures.iter().map(of).sum()
    }

    /// Builds the pack. Uses all of the header except the textures.
    ///
    /// # Errors
    /// Returns an error if the header is out of range.
    pub fn pack(&self, images: &[TermImages], mut header: PwtHeader) -> Result<PwtPack, FormatError> {
        let mut texels = Vec::new();
        header.textures.clear();
        for (level, channels, slots) in &self.textures {
            let components: Vec<Component> = slots
                .iter()
                .map(|slot| {
                    let Some(image) = slot.map(|k| &images[k]) else { return Component::NONE };
                    let (low, high) = range(&image.levels[*level as usize..]);
                    Component { channel: image.channel as u32, term: image.term as u32, scale: high - low, low }
                })
                .collect();
            texels.push(texels_of(images, *level, *channels as usize, slots, &components));
            header.textures.push(TextureHeader { level: *level, channels: *channels, components });
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
