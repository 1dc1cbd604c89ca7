//! Order in which terms of trees of light and view begin at finer levels.

use brdfc_pwt::levels::TermImages;

/// One step of the search: a term that begins at a finer level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct StepUp {
    /// Index of the term.
    pub(super) image: usize,
    /// Level at which it now begins.
    pub(super) base: u32,
    /// Error after this step: weighted squares.
    pub(super) error: f64,
}

/// All steps that reduce the error, in decreasing order of the reduction per byte.
pub(super) fn steps(images: &[TermImages]) -> Vec<StepUp> {
    let mut error: f64 = images.iter().map(|image| image.errors[image.errors.len() - 1]).sum();
    let mut queue: Vec<(f64, usize, u32, f64)> = Vec::new();
    for (index, image) in images.iter().enumerate() {
        // Lower convex hull of error over bytes: each step gains less per byte than the previous one.
        let none = image.errors.len() - 1;
        let bytes = |base: usize| if base == none { 0.0 } else { 0.25f64.powi(base as i32) };
        let mut at = none;
        while at > 0 {
            let gain = |to: &usize| (image.errors[at] - image.errors[*to]) / (bytes(*to) - bytes(at));
            let Some(to) = (0..at).max_by(|a, b| gain(a).total_cmp(&gain(b))).filter(|to| gain(to) > 0.0) else {
                break;
            };
            queue.push((gain(&to), index, to as u32, image.errors[at] - image.errors[to]));
            at = to;
        }
    }
    queue.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)).then(b.2.cmp(&a.2)));
    let step = |(_, image, base, gain): (f64, usize, u32, f64)| {
        error -= gain;
        StepUp { image, base, error: error.max(0.0) }
    };
    queue.into_iter().map(step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_gain_most_per_byte_first() {
        let term =
            |term: usize, errors: &[f64]| TermImages { channel: 0, term, levels: Vec::new(), errors: errors.to_vec() };
        // Level 1 takes a quarter of the bytes. The first term gains 8 for ¼, then 1 for ¾. The second gains 4 for 1 in one
        // step: its level 1, which would gain ½ for ¼, is skipped. The third gains nothing.
        let images = [term(0, &[0.0, 1.0, 9.0]), term(1, &[0.0, 3.5, 4.0]), term(2, &[2.0, 2.0, 2.0])];
        let step = |image, base, error| StepUp { image, base, error };
        assert_eq!(steps(&images), [step(0, 1, 7.0), step(1, 0, 3.0), step(0, 0, 2.0)]);
    }
}
