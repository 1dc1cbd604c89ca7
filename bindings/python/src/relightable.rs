//! Whatever has values at places of a picture: polynomial wavelet trees and flat BTFs.

use super::arrays::{check_rows, colours, directions, rows};
use super::errors::wrong;
use brdfc_formats::measured::scan_csv::TexelQuery;
use brdfc_source::words::shown;
use numpy::PyArray2;
use pyo3::prelude::*;
use rayon::prelude::*;

/// A picture under any light, or a surface with relief under any light and seen from anywhere.
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
    /// Linear RGB, 1 is white, at N places: float32 of shape (N, 3).
    ///
    /// uv, of shape (N, 2), is 0 to 1, across and down, and goes on beyond. wi (to the light) and wo (to the viewer, for
    /// flat BTFs alone) are unit vectors as those of `Material.eval`, of shape (N, 3). lod is the level of detail: 0, the
    /// coarsest, to `levels`, the finest, which is taken without it.
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
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let (places, incoming) = (rows::<2>("uv", uv)?, directions("wi", wi)?);
        check_rows("wi", incoming.len(), "uv", places.len())?;
        let outgoing = match (wo, self.has_views()) {
            (Some(wo), true) => directions("wo", wo)?,
            (None, false) => vec![[0.0, 0.0, 1.0]; places.len()],
            (None, true) => return Err(wrong("wo", "nothing", "directions to the viewer, of a flat BTF")),
            (Some(_), false) => return Err(wrong("wo", "directions", "none: it is a picture of one view")),
        };
        check_rows("wo", outgoing.len(), "uv", places.len())?;
        let finest = self.levels() as f32;
        let level = lod.unwrap_or(finest);
        if !(0.0..=finest).contains(&level) {
            return Err(wrong("lod", shown(level), format!("0 to {finest}, the levels that there are")));
        }
        let value = |((uv, incoming), outgoing): ((&[f64; 2], &[f64; 3]), &[f64; 3])| {
            self.inner.value(&TexelQuery { uv: *uv, incoming: *incoming, outgoing: *outgoing }, level)
        };
        let values = py.detach(|| places.par_iter().zip(&incoming).zip(&outgoing).map(value).collect::<Vec<_>>());
        colours(py, values)
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
