//! Inputs with values at positions: polynomial wavelet trees and flat BTFs.

use super::arrays::{Argument, colours};
use super::errors::{problem, wrong};
use super::threads::threads;
use brdfc_readers::scan_csv::TexelQuery;
use brdfc_core::words::format_number;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;

/// A polynomial wavelet tree (one view, or all views of a BTF, under any light) or a flat BTF (any view under any light).
#[pyclass(frozen, module = "brdfc")]
pub struct Relightable {
    inner: brdfc_jobs::pwt::Relightable,
}

impl Relightable {
    /// Wraps an opened input.
    pub fn new(inner: brdfc_jobs::pwt::Relightable) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl Relightable {
    /// Returns linear RGB at positions, 1 is white: float32 of shape (..., 3).
    ///
    /// uv, of shape (..., 2), is 0 to 1, across and down, and may exceed this range. wi (to the light) and wo (to the viewer, only
    /// if there are several views) are unit vectors as in `Material.eval`, of shape (..., 3); shapes are broadcast by the rules of NumPy. lod is
    /// the level of detail: 0, the coarsest, to `levels`, the finest (default: the finest).
    ///
    /// Raises ValueError for other shapes, vectors of other lengths, levels out of range, and a missing wo.
    #[pyo3(signature = (uv, wi, wo = None, lod = None))]
    fn eval<'py>(
        &self,
        py: Python<'py>,
        uv: &Bound<'py, PyAny>,
        wi: &Bound<'py, PyAny>,
        wo: Option<&Bound<'py, PyAny>>,
        lod: Option<f32>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (uv, wi) = (Argument::new("uv", uv, 2)?, Argument::new("wi", wi, 3)?);
        let wo = match (wo, self.has_views()) {
            (Some(wo), true) => Some(Argument::new("wo", wo, 3)?),
            (None, false) => None,
            (None, true) => return Err(problem("wo", "missing; several views need directions to the viewer")),
            (Some(_), false) => return Err(problem("wo", "this polynomial wavelet tree has only one view; omit wo")),
        };
        let all: Vec<&Argument<'_>> = [&uv, &wi].into_iter().chain(&wo).collect();
        let shape = Argument::common_shape(&all)?;
        let (places, incoming) = (uv.rows::<2>(&shape)?, wi.directions(&shape)?);
        let outgoing = match &wo {
            Some(wo) => wo.directions(&shape)?,
            None => vec![[0.0, 0.0, 1.0]; places.len()],
        };
        let finest = self.levels() as f32;
        let level = lod.unwrap_or(finest);
        if !(0.0..=finest).contains(&level) {
            return Err(wrong("lod", format_number(level), format!("0 to {finest}, the available levels")));
        }
        let value = |((uv, incoming), outgoing): ((&[f64; 2], &[f64; 3]), &[f64; 3])| {
            self.inner.value(&TexelQuery { uv: *uv, incoming: *incoming, outgoing: *outgoing }, level)
        };
        let all = || places.par_iter().zip(&incoming).zip(&outgoing).map(value).collect();
        let threads = threads(py)?;
        let values: Vec<_> = py.detach(|| threads.install(all));
        colours(py, values, &shape)
    }

    /// Kind of the pack: pwt, flat-btf or flat-btf-trees.
    #[getter]
    fn kind(&self) -> &'static str {
        match &self.inner {
            brdfc_jobs::pwt::Relightable::Flat(material) => material.decoder().parts().reflectance.kind().name(),
            brdfc_jobs::pwt::Relightable::Pack(_) => "pwt",
        }
    }

    /// True if values depend on the view, so that `eval` needs wo.
    #[getter]
    fn has_views(&self) -> bool {
        self.inner.has_views()
    }

    /// Number of levels of detail coarser than the finest.
    #[getter]
    fn levels(&self) -> u32 {
        self.inner.levels()
    }

    fn __repr__(&self) -> String {
        format!("<brdfc.Relightable {}>", self.kind())
    }
}
