//! One level of a wavelet transform of a rectangle of an image, in place.

use crate::lifting::{Border, Lines, Wavelet, forward, inverse};

/// One channel, row by row from the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Values.
    pub values: Vec<f32>,
}

/// A rectangle of a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rectangle {
    /// First column and row.
    pub first: [usize; 2],
    /// Columns and rows.
    pub size: [usize; 2],
}

impl Rectangle {
    /// The quarters after one level: low, then high along columns, rows and both.
    pub fn quarters(self) -> [Self; 4] {
        let size = self.size.map(|side| side / 2);
        let [x, y] = self.first;
        [[x, y], [x + size[0], y], [x, y + size[1]], [x + size[0], y + size[1]]].map(|first| Self { first, size })
    }
}

/// Even and odd numbers of a row.
struct Row<'a> {
    even: &'a mut [f32],
    odd: &'a mut [f32],
}

impl Lines for Row<'_> {
    fn add(&mut self, odd: bool, target: usize, source: usize, factor: f32) {
        if odd {
            self.odd[target] += factor * self.even[source];
        } else {
            self.even[target] += factor * self.odd[source];
        }
    }

    fn scale(&mut self, odd: bool, line: usize, factor: f32) {
        let half = if odd { &mut self.odd } else { &mut self.even };
        half[line] *= factor;
    }

    fn half(&self) -> usize {
        self.even.len()
    }
}

/// Rows of a rectangle, with even and odd ones in separate parts of a buffer.
struct Rows<'a> {
    even: &'a mut [f32],
    odd: &'a mut [f32],
    width: usize,
}

impl Lines for Rows<'_> {
    fn add(&mut self, odd: bool, target: usize, source: usize, factor: f32) {
        let (to, from) = if odd { (&mut *self.odd, &*self.even) } else { (&mut *self.even, &*self.odd) };
        let to = &mut to[target * self.width..][..self.width];
        for (to, from) in to.iter_mut().zip(&from[source * self.width..][..self.width]) {
            *to += factor * from;
        }
    }

    fn scale(&mut self, odd: bool, line: usize, factor: f32) {
        let half = if odd { &mut *self.odd } else { &mut *self.even };
        half[line * self.width..][..self.width].iter_mut().for_each(|value| *value *= factor);
    }

    fn half(&self) -> usize {
        self.even.len() / self.width
    }
}

impl Plane {
    /// Creates a plane of zeros.
    pub fn zeros(size: [usize; 2]) -> Self {
        Self { size, values: vec![0.0; size[0] * size[1]] }
    }

    /// The whole plane as a rectangle.
    pub fn rectangle(&self) -> Rectangle {
        Rectangle { first: [0, 0], size: self.size }
    }

    /// Numbers of a row of a rectangle.
    pub fn row(&self, rectangle: Rectangle, row: usize) -> &[f32] {
        &self.values[(rectangle.first[1] + row) * self.size[0] + rectangle.first[0]..][..rectangle.size[0]]
    }

    pub(crate) fn row_mut(&mut self, rectangle: Rectangle, row: usize) -> &mut [f32] {
        &mut self.values[(rectangle.first[1] + row) * self.size[0] + rectangle.first[0]..][..rectangle.size[0]]
    }

    /// Sets a rectangle to 0.
    pub fn clear(&mut self, rectangle: Rectangle) {
        (0..rectangle.size[1]).for_each(|y| self.row_mut(rectangle, y).fill(0.0));
    }

    /// Analyses one level: a rectangle with even sides becomes its four quarters.
    pub fn split(&mut self, rectangle: Rectangle, wavelet: Wavelet, border: Border) {
        let [width, height] = rectangle.size;
        let mut buffer = vec![0.0; width * height];
        let (top, bottom) = buffer.split_at_mut(width * height / 2);
        let mut halves = vec![0.0; width];
        for y in 0..height {
            let target = if y % 2 == 0 { &mut *top } else { &mut *bottom };
            let target = &mut target[y / 2 * width..][..width];
            let (even, odd) = halves.split_at_mut(width / 2);
            for (k, pair) in self.row(rectangle, y).chunks_exact(2).enumerate() {
                (even[k], odd[k]) = (pair[0], pair[1]);
            }
            forward(wavelet, border, &mut Row { even, odd });
            target.copy_from_slice(&halves);
        }
        forward(wavelet, border, &mut Rows { even: top, odd: bottom, width });
        for (y, row) in buffer.chunks_exact(width).enumerate() {
            self.row_mut(rectangle, y).copy_from_slice(row);
        }
    }

    /// Undoes [`Self::split`].
    pub fn join(&mut self, rectangle: Rectangle, wavelet: Wavelet, border: Border) {
        let [width, height] = rectangle.size;
        let mut buffer: Vec<f32> = (0..height).flat_map(|y| self.row(rectangle, y).to_vec()).collect();
        let (top, bottom) = buffer.split_at_mut(width * height / 2);
        inverse(wavelet, border, &mut Rows { even: &mut *top, odd: &mut *bottom, width });
        for y in 0..height {
            let source = if y % 2 == 0 { &mut *top } else { &mut *bottom };
            let (even, odd) = source[y / 2 * width..][..width].split_at_mut(width / 2);
            inverse(wavelet, border, &mut Row { even: &mut *even, odd: &mut *odd });
            for (pair, (even, odd)) in self.row_mut(rectangle, y).chunks_exact_mut(2).zip(even.iter().zip(odd.iter())) {
                (pair[0], pair[1]) = (*even, *odd);
            }
        }
    }

    /// Means of squares of `2^levels` texels per side.
    pub fn means(&self, levels: u32) -> Self {
        let side = 1 << levels;
        let size = self.size.map(|n| n >> levels);
        let mut means = Self::zeros(size);
        for (y, row) in self.values.chunks_exact(self.size[0]).enumerate().take(size[1] * side) {
            let target = &mut means.values[y / side * size[0]..][..size[0]];
            for (sum, texels) in target.iter_mut().zip(row.chunks_exact(side)) {
                *sum += texels.iter().sum::<f32>();
            }
        }
        let share = 1.0 / (side * side) as f32;
        means.values.iter_mut().for_each(|value| *value *= share);
        means
    }
}
