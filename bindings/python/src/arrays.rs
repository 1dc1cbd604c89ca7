//! Arrays of NumPy as vectors, and back.

use super::errors::wrong;
use brdfc_formats::direction::{Vector, dot};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;

/// Rows of `K` numbers from whatever NumPy makes an array of: float32 is widened, integers become float64.
///
/// # Errors
/// ValueError: no real numbers, another shape than (N, K), numbers that are not finite.
pub fn rows<const K: usize>(name: &str, numbers: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; K]>> {
    let array = numbers.py().import("numpy")?.call_method1("asarray", (numbers,))?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !["f", "i", "u"].contains(&kind.as_str()) {
        return Err(wrong(name, format!("an array of {dtype}"), "real numbers"));
    }
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    if shape.len() != 2 || shape[1] != K {
        let axes: Vec<String> = shape.iter().map(usize::to_string).collect();
        return Err(wrong(name, format!("an array of shape ({})", axes.join(", ")), format!("(N, {K})")));
    }
    let rows: Vec<[f64; K]> = if let Ok(single) = array.extract::<PyReadonlyArray2<'_, f32>>() {
        single.as_array().rows().into_iter().map(|row| std::array::from_fn(|k| f64::from(row[k]))).collect()
    } else {
        let array = array.call_method1("astype", ("float64",))?;
        let double = array.extract::<PyReadonlyArray2<'_, f64>>()?;
        double.as_array().rows().into_iter().map(|row| std::array::from_fn(|k| row[k])).collect()
    };
    match rows.iter().enumerate().find(|(_, row)| row.iter().any(|number| !number.is_finite())) {
        Some((at, row)) => Err(wrong(format!("{name}, row {at}"), format!("{row:?}"), "finite numbers")),
        None => Ok(rows),
    }
}

/// Directions of an array of shape (N, 3), brought to length 1. Lengths may be off by 1 %, as those of the lists that
/// `brdfc eval` reads.
///
/// # Errors
/// As [`rows`]; ValueError of other lengths, with the row.
pub fn directions(name: &str, numbers: &Bound<'_, PyAny>) -> PyResult<Vec<Vector>> {
    let unit = |(row, v): (usize, Vector)| {
        let length = dot(v, v).sqrt();
        if (0.99..=1.01).contains(&length) {
            return Ok(v.map(|c| c / length));
        }
        Err(wrong(format!("{name}, row {row}"), format!("a vector of length {length:.4}"), "unit vectors"))
    };
    rows(name, numbers)?.into_iter().enumerate().map(unit).collect()
}

/// Holds the number of rows of an argument against that of another.
///
/// # Errors
/// ValueError where they differ.
pub fn check_rows(name: &str, found: usize, other: &str, allowed: usize) -> PyResult<()> {
    if found == allowed {
        return Ok(());
    }
    Err(wrong(name, format!("{found} rows"), format!("{allowed}, as {other} has")))
}

/// An array of shape (N, 3).
pub fn colours<'py>(py: Python<'py>, values: Vec<[f32; 3]>) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let count = values.len();
    PyArray1::from_vec(py, values.into_flattened()).reshape([count, 3])
}
