//! Whatever has values at places of a rendering: polynomial wavelet trees and flat BTFs.

use super::arrays::{Argument, colours};
use super::errors::wrong;
use super::threads::threads;
use brdfc_readers::scan_csv::TexelQuery;
use brdfc_core::words::format_number;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use rayon::prelude::*;

/// A rendering under any light, or a surface with relief under any light and seen from anywhere.
#[pyclass(frozen, module = "brdfc")]
pub struct Relightable {
    inner: brdfc_jobs::pwt::Relightable,
}

impl Relightable {
    /// What was opened.
    pub fn new(inner: brdfc_jobs::pwt::Relightable) -> Self {
        Self { inner }
    }
}

#[pymethods]
impl Relightable {
    /// Linear RGB, 1 is white, at places: float32 of shape (..., 3).
    ///
    /// uv, of shape (..., 2), is 0 to 1, across and down, and goes on beyond. wi (to the light) and wo (to the viewer, for
    /// flat BTFs alone) are unit vectors as those of `Material.eval`, of shape (..., 3); shapes are brought together as by
    /// NumPy's own functions. lod is the level of detail: 0, the coarsest, to `levels`, the finest, which is taken without
    /// it.
    ///
    /// Raises ValueError for other shapes, vectors of other lengths, levels that there are not, and where wo is missing.
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
            (None, true) => return Err(wrong("wo", "nothing", "directions to the viewer, of a flat BTF")),
            (Some(_), false) => return Err(wrong("wo", "directions", "none: it is a rendering of one view")),
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
            return Err(wrong("lod", format_number(level), format!("0 to {finest}, the levels that there are")));
        }
        let value = |((uv, incoming), outgoing): ((&[f64; 2], &[f64; 3]), &[f64; 3])| {
            self.inner.value(&TexelQuery { uv: *uv, incoming: *incoming, outgoing: *outgoing }, level)
        };
        let all = || places.par_iter().zip(&incoming).zip(&outgoing).map(value).collect();
        let threads = threads(py)?;
        let values: Vec<_> = py.detach(|| threads.install(all));
        colours(py, values, &shape)
    }

    /// What it is: pwt or flat-btf.
    #[getter]
    fn kind(&self) -> &'static str {
        if self.has_views() { "flat-btf" } else { "pwt" }
    }

    /// Whether values depend on where they are seen from, so that `eval` needs wo.
    #[getter]
    fn has_views(&self) -> bool {
        self.inner.has_views()
    }

    /// Levels of detail besides the finest.
    #[getter]
    fn levels(&self) -> u32 {
        self.inner.levels()
    }

    fn __repr__(&self) -> String {
        format!("<brdfc.Relightable {}>", self.kind())
    }
}
