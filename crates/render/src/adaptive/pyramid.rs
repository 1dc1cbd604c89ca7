//! Levels of a buffer: each pixel of a level covers 2 x 2 of the finer one, fewer at the right and lower border.

/// A buffer and its coarser levels, finest first.
#[derive(Debug, Clone, PartialEq)]
pub struct Pyramid<T> {
    /// Width, height and values of each level.
    pub levels: Vec<(usize, usize, Vec<T>)>,
}

impl<T: Copy> Pyramid<T> {
    /// Makes `coarsest + 1` levels. `merge` combines the values of a finer level in pairs.
    pub fn new(width: usize, height: usize, values: Vec<T>, coarsest: usize, merge: impl Fn(T, T) -> T) -> Self {
        let mut levels = vec![(width, height, values)];
        for _ in 0..coarsest {
            let (w, h, finer) = &levels[levels.len() - 1];
            let (w2, h2) = (w.div_ceil(2), h.div_ceil(2));
            let value = |index: usize| {
                let (x, y) = (2 * (index % w2), 2 * (index / w2));
                let (right, below) = ((x + 1).min(w - 1), (y + 1).min(h - 1));
                let at = |x: usize, y: usize| finer[y * w + x];
                merge(merge(at(x, y), at(right, y)), merge(at(x, below), at(right, below)))
            };
            let coarser = (0..w2 * h2).map(value).collect();
            levels.push((w2, h2, coarser));
        }
        Self { levels }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_pixel_has_the_extreme_of_its_finer_pixels() {
        let values: Vec<i32> = (0..35).map(|i| (i * 13) % 31).collect();
        for (merge, fold) in [
            (i32::min as fn(i32, i32) -> i32, i32::min as fn(i32, i32) -> i32),
            (i32::max as fn(i32, i32) -> i32, i32::max as fn(i32, i32) -> i32),
        ] {
            let pyramid = Pyramid::new(7, 5, values.clone(), 3, merge);
            let sizes: Vec<(usize, usize)> = pyramid.levels.iter().map(|(w, h, _)| (*w, *h)).collect();
            assert_eq!(sizes, [(7, 5), (4, 3), (2, 2), (1, 1)]);
            for (level, (w, h, coarse)) in pyramid.levels.iter().enumerate() {
                for (x, y) in (0..*h).flat_map(|y| (0..*w).map(move |x| (x, y))) {
                    let covered = (0..35).filter(|i| (i % 7) >> level == x && (i / 7) >> level == y);
                    let expected = covered.map(|i| values[i]).reduce(fold).unwrap();
                    assert_eq!(coarse[y * w + x], expected, "level {level} {x} {y}");
                }
            }
        }
    }
}
