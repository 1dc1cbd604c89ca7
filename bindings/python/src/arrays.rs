//! Conversion of NumPy arrays to vectors and back.

use super::errors::{problem, wrong};
use brdfc_formats::direction::{Vector, dot};
use numpy::{PyArray1, PyArrayDyn, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// An argument of vectors of `axes` numbers each: an array of shape (..., `axes`); a single vector has shape (`axes`).
pub struct Argument<'py> {
    name: &'static str,
    array: Bound<'py, PyAny>,
    axes: usize,
    /// Shape without the last axis.
    shape: Vec<usize>,
}

impl<'py> Argument<'py> {
    /// Converts an argument to an array of NumPy.
    ///
    /// # Errors
    /// Returns ValueError for anything but real numbers, for masked numbers, and for another last axis.
    pub fn new(name: &'static str, numbers: &Bound<'py, PyAny>, axes: usize) -> PyResult<Self> {
        let numpy = numbers.py().import("numpy")?;
        let masked = numpy.getattr("ma")?;
        if numbers.is_instance(&masked.getattr("MaskedArray")?)?
            && masked.call_method1("is_masked", (numbers,))?.is_truthy()?
        {
            return Err(problem(name, "masked numbers; fill or remove them"));
        }
        let array = numpy.call_method1("asarray", (numbers,))?;
        let dtype = array.getattr("dtype")?;
        let kind: String = dtype.getattr("kind")?.extract()?;
        if !["f", "i", "u"].contains(&kind.as_str()) {
            return Err(wrong(name, format!("an array of {dtype}"), "real numbers"));
        }
        let mut shape: Vec<usize> = array.getattr("shape")?.extract()?;
        if shape.pop() != Some(axes) {
            let found = array.getattr("shape")?;
            return Err(wrong(name, format!("an array of shape {found}"), format!("(..., {axes})")));
        }
        Ok(Self { name, array, axes, shape })
    }

    /// Broadcasts the shapes of all arguments by the rules of NumPy, without the last axis.
    ///
    /// # Errors
    /// Returns ValueError if a shape is incompatible with those before it.
    pub fn common_shape(all: &[&Self]) -> PyResult<Vec<usize>> {
        let mut common: Vec<usize> = Vec::new();
        for (number, argument) in all.iter().enumerate() {
            let (shape, count) = (&argument.shape, common.len().max(argument.shape.len()));
            // Axes are counted from the last one; missing axes are 1.
            let side = |sides: &[usize], k: usize| (k + sides.len()).checked_sub(count).map_or(1, |at| sides[at]);
            let together = (0..count).map(|k| match (side(&common, k), side(shape, k)) {
                (a, 1) => Some(a),
                (1, b) => Some(b),
                (a, b) => (a == b).then_some(a),
            });
            common = together.collect::<Option<_>>().ok_or_else(|| {
                let others: Vec<String> = all[..number].iter().map(|other| other.named_shape()).collect();
                let allowed = format!("a shape compatible with {}", others.join(" and "));
                wrong(argument.name, format!("an array of shape {}", argument.shape_text()), allowed)
            })?;
        }
        Ok(common)
    }

    /// Returns the vectors, broadcast to a common shape; float32 is widened, integers become float64.
    ///
    /// # Errors
    /// Returns ValueError for numbers that are not finite.
    pub fn rows<const K: usize>(&self, common: &[usize]) -> PyResult<Vec<[f64; K]>> {
        let numpy = self.array.py().import("numpy")?;
        let whole: Vec<usize> = common.iter().copied().chain([K]).collect();
        let spread = numpy.call_method1("broadcast_to", (&self.array, whole))?;
        // The count is given because -1 is not allowed for arrays without elements.
        let flat = spread.call_method1("reshape", ((common.iter().product::<usize>(), K),))?;
        let rows: Vec<[f64; K]> = if let Ok(single) = flat.extract::<PyReadonlyArray2<'_, f32>>() {
            single.as_array().rows().into_iter().map(|row| std::array::from_fn(|k| f64::from(row[k]))).collect()
        } else {
            let flat = flat.call_method1("astype", ("float64",))?;
            let double = flat.extract::<PyReadonlyArray2<'_, f64>>()?;
            double.as_array().rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect()
        };
        match rows.iter().enumerate().find(|(_, row)| row.iter().any(|number| !number.is_finite())) {
            Some((at, row)) => Err(wrong(self.row(at), format!("{row:?}"), "finite numbers")),
            None => Ok(rows),
        }
    }

    /// Returns the vectors as normalised directions. Lengths may be off by 1 %, as in the lists that `brdfc eval` reads.
    ///
    /// # Errors
    /// Returns the errors of [`Self::rows`], and ValueError with the row for other lengths.
    pub fn directions(&self, common: &[usize]) -> PyResult<Vec<Vector>> {
        let unit = |(row, v): (usize, Vector)| {
            let length = dot(v, v).sqrt();
            if (0.99..=1.01).contains(&length) {
                return Ok(v.map(|c| c / length));
            }
            Err(wrong(self.row(row), format!("a vector of length {length:.4}"), "unit vectors"))
        };
        self.rows(common)?.into_iter().enumerate().map(unit).collect()
    }

    fn row(&self, at: usize) -> String {
        format!("{}, row {at}", self.name)
    }

    fn named_shape(&self) -> String {
        format!("{} of {}", self.shape_text(), self.name)
    }

    fn shape_text(&self) -> String {
        let sides: Vec<String> = self.shape.iter().chain([&self.axes]).map(usize::to_string).collect();
        if sides.len() == 1 { format!("({},)", sides[0]) } else { format!("({})", sides.join(", ")) }
    }
}

/// Makes an array of these vectors, of shape (..., 3).
pub fn colours<'py>(
    py: Python<'py>,
    values: Vec<[f32; 3]>,
    common: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let shape: Vec<usize> = common.iter().copied().chain([3]).collect();
    PyArray1::from_vec(py, values.into_flattened()).reshape(shape)
}
