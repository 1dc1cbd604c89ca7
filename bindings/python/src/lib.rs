//! The module `brdfc` of Python: any source or pack as a function of direction pairs, in arrays of NumPy.
//!
//! It calls the same functions as `brdfc eval`, so values are identical bit for bit. `brdfc.pyi` is the public documentation.

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

    /// Opens a measured file, a pack or an address such as `synth:ggx?alpha=0.3`.
    ///
    /// Returns a `Material`, which has values at direction pairs, or for flat BTFs and polynomial wavelet trees a `Relightable`, which
    /// has values at positions. Raises OSError if the file cannot be read, and ValueError if it does not follow its layout.
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
