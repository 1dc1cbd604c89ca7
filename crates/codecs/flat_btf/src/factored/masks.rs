//! Bit masks of the views that see each texel: texels with equal masks share the products of the basis.

use brdfc_formats::flat_btf::VisibilityMask;

/// Weight of a filled value, in a view that does not see the texel.
pub(super) const UNSEEN_WEIGHT: f32 = 0.1;

/// Bits of each texel.
#[derive(Debug, Clone)]
pub(super) struct Masks {
    words: usize,
    bits: Vec<u64>,
}

impl Masks {
    /// Masks of some texels, each at `row T + column`.
    pub(super) fn new(mask: &VisibilityMask, texels: &[usize]) -> Self {
        let (size, views) = (mask.size() as usize, mask.views() as usize);
        let words = views.div_ceil(64);
        let mut bits = vec![0; words * texels.len()];
        for (texel, bits) in texels.iter().zip(bits.chunks_exact_mut(words)) {
            let at = [(texel % size) as u32, (texel / size) as u32];
            for view in (0..views).filter(|view| mask.is_seen(*view as u32, at)) {
                bits[view / 64] |= 1 << (view % 64);
            }
        }
        Self { words, bits }
    }

    /// Masks of texels that all views see.
    pub(super) fn all(views: usize, texels: usize) -> Self {
        let words = views.div_ceil(64);
        Self { words, bits: vec![u64::MAX; words * texels] }
    }

    /// Masks of the first texels alone.
    pub(super) fn first(&self, texels: usize) -> Self {
        Self { words: self.words, bits: self.bits[..texels * self.words].to_vec() }
    }

    /// The bits of a texel, by its index in this set.
    pub(super) fn of(&self, texel: usize) -> &[u64] {
        &self.bits[texel * self.words..][..self.words]
    }

    /// Returns true if a view sees a texel.
    pub(super) fn is_seen(&self, texel: usize, view: usize) -> bool {
        self.bits[texel * self.words + view / 64] >> (view % 64) & 1 == 1
    }

    /// Weight of a value.
    pub(super) fn weight(&self, texel: usize, view: usize) -> f32 {
        if self.is_seen(texel, view) { 1.0 } else { UNSEEN_WEIGHT }
    }

    /// Groups texels with equal masks, in the order of masks, then of texels.
    pub(super) fn groups(&self) -> Vec<Vec<usize>> {
        let count = self.bits.len() / self.words;
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|texel| self.of(*texel));
        order.chunk_by(|a, b| self.of(*a) == self.of(*b)).map(<[usize]>::to_vec).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_with_equal_masks_are_together() {
        let seen = |view: u32, texel: u32| texel == 3 || (view + texel).is_multiple_of(2);
        let bytes = (0..70 * 4).map(|k| if seen(k / 4, k % 4) { 255 } else { 0 });
        let mask = VisibilityMask::new(2, 70, bytes.collect()).unwrap();
        let masks = Masks::new(&mask, &[0, 1, 2, 3]);
        for texel in 0..4 {
            for view in 0..70 {
                assert_eq!(masks.is_seen(texel, view), seen(view as u32, texel as u32), "{texel}, {view}");
            }
        }
        let groups = masks.groups();
        assert_eq!(groups.iter().filter(|group| **group == [0, 2]).count(), 1);
        assert_eq!((groups.len(), masks.weight(0, 1)), (3, UNSEEN_WEIGHT));
        assert_eq!(Masks::new(&mask, &[3, 0]).of(1), masks.of(0));
    }
}
