//! GPU layout of uncompressed flat values: a 2D array with one layer per view, in which each light is a tile, so that a
//! shader binds a single texture. Specified in `formats/src/flat_btf/spec.md`.

use super::flat_view::FlatView;

/// Layout of the lights of a view in their layer: tiles of `T x T` texels in rows of `columns = ceil(sqrt(lights))`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Atlas {
    /// `T`, texels per side of a tile.
    pub size: u32,
    /// Number of tiles in use.
    pub lights: u32,
}

impl Atlas {
    /// Atlas for `lights` lights.
    pub fn new(size: u32, lights: u32) -> Self {
        Self { size, lights }
    }

    /// Number of tiles in a row.
    pub fn columns(self) -> u32 {
        let root = self.lights.isqrt();
        root + u32::from(root * root < self.lights)
    }

    /// Number of rows of tiles.
    pub fn rows(self) -> u32 {
        self.lights.div_ceil(self.columns().max(1))
    }

    /// Width and height of a layer, texels. May exceed the limits of an adapter.
    pub fn extent(self) -> [u32; 2] {
        [self.columns() * self.size, self.rows() * self.size]
    }

    /// Number of texels of a layer, including tiles without a light.
    pub fn texels(self) -> u64 {
        self.extent().into_iter().map(u64::from).product()
    }

    /// First texel, `(column, row)`, of a light's tile.
    pub fn origin(self, light: u32) -> [u32; 2] {
        let columns = self.columns();
        [light % columns * self.size, light / columns * self.size]
    }

    /// Layer of a view: packed texels, row by row; 0 in unused tiles.
    pub fn layer(self, view: &FlatView) -> Vec<u32> {
        let [width, height] = self.extent().map(|n| n as usize);
        let size = self.size as usize;
        let mut layer = vec![0; width * height];
        for light in 0..self.lights {
            let [column, row] = self.origin(light).map(|n| n as usize);
            for (k, line) in view.light(light).chunks_exact(size).enumerate() {
                layer[(row + k) * width + column..][..size].copy_from_slice(line);
            }
        }
        layer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_do_not_overlap_and_stay_inside() {
        for lights in 1..200 {
            let atlas = Atlas::new(3, lights);
            let columns = atlas.columns();
            assert!(columns * columns >= lights && (columns - 1) * (columns - 1) < lights, "{lights}");
            let [width, height] = atlas.extent();
            let mut origins: Vec<[u32; 2]> = (0..lights).map(|light| atlas.origin(light)).collect();
            for [column, row] in &origins {
                assert!(column % 3 == 0 && row % 3 == 0 && column + 3 <= width && row + 3 <= height, "{lights}");
            }
            origins.sort_unstable();
            origins.dedup();
            assert_eq!(origins.len(), lights as usize);
        }
        assert_eq!((Atlas::new(2, 5).extent(), Atlas::new(2, 5).origin(4)), ([6, 4], [2, 2]));
    }
}
