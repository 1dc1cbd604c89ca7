//! The two matrix factors of a channel.

use brdfc_formats::container::half;
use brdfc_formats::{FormatError, memory};

/// Type of the numbers of a matrix in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    /// IEEE 754 half, 2 bytes.
    Half,
    /// Single, 4 bytes.
    Single,
    /// Double, 8 bytes; stored as single in memory.
    Double,
}

impl Scalar {
    /// The type with this many bytes.
    pub(super) fn of_size(bytes: u8) -> Option<Self> {
        [Self::Half, Self::Single, Self::Double].into_iter().find(|scalar| scalar.size() == u64::from(bytes))
    }

    /// Size of a number, bytes.
    pub fn size(self) -> u64 {
        match self {
            Self::Half => 2,
            Self::Single => 4,
            Self::Double => 8,
        }
    }
}

/// Numbers in memory: halves stay halves.
#[derive(Debug, Clone, PartialEq)]
enum Numbers {
    Half(Vec<u16>),
    Single(Vec<f32>),
}

/// A matrix of finite numbers, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Matrix {
    numbers: Numbers,
    columns: usize,
}

impl Matrix {
    /// Allocates memory for `count` numbers.
    pub(super) fn reserved(scalar: Scalar, count: usize, columns: usize) -> Result<Self, FormatError> {
        let numbers = match scalar {
            Scalar::Half => Numbers::Half(memory::reserved("matrix", count)?),
            Scalar::Single | Scalar::Double => Numbers::Single(memory::reserved("matrix", count)?),
        };
        Ok(Self { numbers, columns })
    }

    /// Appends the numbers in `bytes`, a whole number of them. Returns the index and value of the first number that is
    /// not finite as an error.
    pub(super) fn append(&mut self, scalar: Scalar, bytes: &[u8]) -> Result<(), (usize, f64)> {
        let check = |index: usize, value: f64| if value.is_finite() { Ok(()) } else { Err((index, value)) };
        match (&mut self.numbers, scalar) {
            (Numbers::Half(numbers), _) => {
                for (index, bits) in bytes.as_chunks().0.iter().enumerate() {
                    let bits = u16::from_le_bytes(*bits);
                    check(index, half::decode(bits).into())?;
                    numbers.push(bits);
                }
            }
            (Numbers::Single(numbers), Scalar::Double) => {
                for (index, bits) in bytes.as_chunks().0.iter().enumerate() {
                    let value = f64::from_le_bytes(*bits);
                    check(index, f64::from(value as f32))?;
                    numbers.push(value as f32);
                }
            }
            (Numbers::Single(numbers), _) => {
                for (index, bits) in bytes.as_chunks().0.iter().enumerate() {
                    let value = f32::from_le_bytes(*bits);
                    check(index, value.into())?;
                    numbers.push(value);
                }
            }
        }
        Ok(())
    }

    /// Number of rows: pairs of directions, or texels.
    pub fn rows(&self) -> usize {
        match &self.numbers {
            Numbers::Half(numbers) => numbers.len() / self.columns,
            Numbers::Single(numbers) => numbers.len() / self.columns,
        }
    }

    /// Size of its numbers, bytes.
    pub fn memory_bytes(&self) -> u64 {
        match &self.numbers {
            Numbers::Half(numbers) => 2 * numbers.len() as u64,
            Numbers::Single(numbers) => 4 * numbers.len() as u64,
        }
    }

    /// The numbers of a row.
    pub fn row(&self, row: usize) -> Vec<f32> {
        let range = row * self.columns..(row + 1) * self.columns;
        match &self.numbers {
            Numbers::Half(numbers) => numbers[range].iter().map(|bits| half::decode(*bits)).collect(),
            Numbers::Single(numbers) => numbers[range].to_vec(),
        }
    }

    /// Scalar product with a row, without a copy of it; the order of its sums depends on the length alone.
    pub(super) fn dot(&self, row: usize, with: &[f32]) -> f32 {
        let range = row * self.columns..(row + 1) * self.columns;
        match &self.numbers {
            Numbers::Half(numbers) => dot_of(&numbers[range], with, half::decode),
            Numbers::Single(numbers) => dot_of(&numbers[range], with, |value| value),
        }
    }
}

/// Number of parallel sums, so that they become vector code.
const LANES: usize = 16;

/// Scalar product of two rows of the same length; the order of its sums depends on the length alone.
#[inline]
fn dot_of<T: Copy>(a: &[T], b: &[f32], decode: impl Fn(T) -> f32) -> f32 {
    let (a, rest) = a.as_chunks::<LANES>();
    let (b, other) = b.as_chunks::<LANES>();
    let mut sums = [0.0f32; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += decode(a[k]) * b[k];
        }
    }
    let tail: f32 = rest.iter().zip(other).map(|(a, b)| decode(*a) * b).sum();
    sums.iter().sum::<f32>() + tail
}

/// A channel: `value(pair, texel) = Σ_k pairs[pair][k] texels[texel][k]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    pairs: Matrix,
    texels: Matrix,
}

impl Channel {
    /// Creates a channel of `components` columns from numbers in row order; halves are rounded.
    ///
    /// # Errors
    /// Returns an error for no components, incomplete rows, and numbers that are not finite or become so.
    pub fn new(components: usize, pairs: &[f32], texels: &[f32], scalar: Scalar) -> Result<Self, FormatError> {
        let matrix = |numbers: &[f32]| {
            if components == 0 || numbers.is_empty() || !numbers.len().is_multiple_of(components) {
                let found = format!("{} numbers in rows of {components}", numbers.len());
                return Err(FormatError::whole("matrix", found, "one whole row or more"));
            }
            let numbers = match scalar {
                Scalar::Half => Numbers::Half(numbers.iter().map(|value| half::encode(*value)).collect()),
                Scalar::Single | Scalar::Double => Numbers::Single(numbers.to_vec()),
            };
            let matrix = Matrix { numbers, columns: components };
            if (0..matrix.rows()).all(|row| matrix.row(row).iter().all(|value| value.is_finite())) {
                return Ok(matrix);
            }
            Err(FormatError::whole("matrix", "a number is not finite", "finite numbers").problem())
        };
        Ok(Self { pairs: matrix(pairs)?, texels: matrix(texels)? })
    }

    pub(super) fn of(pairs: Matrix, texels: Matrix) -> Self {
        Self { pairs, texels }
    }

    /// Number of columns of both matrices.
    pub fn components(&self) -> usize {
        self.pairs.columns
    }

    /// Matrix with a row for each pair of a view and a light.
    pub fn pairs(&self) -> &Matrix {
        &self.pairs
    }

    /// Matrix with a row for each texel.
    pub fn texels(&self) -> &Matrix {
        &self.texels
    }
}
