//! The module `brdfc` of Python: any source or pack as a function of direction pairs, in arrays of NumPy.
//!
//! What is called here is what `brdfc eval` calls, so the values have its bits. What users see is in `brdfc.pyi`.

#![forbid(unsafe_code)]

mod arrays;
mod errors;
mod fields;
mod material;
mod relightable;
mod threads;

use pyo3::pymodule;

/// Measured BRDFs, models and packs as functions of direction pairs.
#[pymodule]
mod brdfc {
    use crate::errors::of_input;
    #[pymodule_export]
    use crate::material::Material;
    #[pymodule_export]
    use crate::relightable::Relightable;
    use crate::threads::threads;
    use brdfc_source::Input;
    use pyo3::prelude::*;
    use std::path::PathBuf;

    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");

    /// Opens a measured file, a pack or an address as in `synth:ggx?alpha=0.3`.
    ///
    /// A `Material` has values at direction pairs; a `Relightable`, of flat BTFs and polynomial wavelet trees, at places
    /// of a rendering. Raises OSError for what cannot be read, ValueError for what breaks its layout.
    #[pyfunction]
    fn open<'py>(py: Python<'py>, input: PathBuf) -> PyResult<Bound<'py, PyAny>> {
        let input = input.to_str().map_or_else(|| Input::from(&input), Input::from);
        let threads = threads(py)?;
        let opened = py.detach(|| threads.install(|| brdfc_jobs::pwt::Relightable::open(&input))).map_err(of_input)?;
        if let Some(relightable) = opened {
            return Ok(Bound::new(py, Relightable::new(relightable))?.into_any());
        }
        let material = py.detach(|| threads.install(|| Material::open(&input))).map_err(of_input)?;
        Ok(Bound::new(py, material)?.into_any())
    }
}
