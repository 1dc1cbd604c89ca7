//! Header and texels of packs as dicts.

use brdfc_formats::BrdfPack;
use brdfc_formats::container::TexelFormat;
use brdfc_formats::crop::Window;
use brdfc_formats::table::TablePack;
use brdfc_formats::wavelet::WaveletPack;
use numpy::{PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Fields of all packs, and fields of a codec that decoders in Python read.
pub fn of_pack<'py>(py: Python<'py>, pack: &BrdfPack) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kind", pack.kind().name())?;
    dict.set_item("channels", pack.channels())?;
    dict.set_item("mean", pack.mean())?;
    if let BrdfPack::Table(pack) = pack {
        add_table(&dict, pack)?;
    } else if let BrdfPack::Wavelet(pack) = pack {
        add_wavelet(&dict, pack)?;
    }
    Ok(dict)
}

/// Bits of a table's symmetry are coded as in its header.
fn add_table(dict: &Bound<'_, PyDict>, pack: &TablePack) -> PyResult<()> {
    let (py, header) = (dict.py(), pack.header());
    let (axes, [columns, rows, depth]) = (header.axes, pack.extent().map(|n| n as usize));
    let layers = axes.layers as usize;
    dict.set_item("symmetry", header.symmetry.bits())?;
    dict.set_item("nodes", (axes.half, axes.difference, axes.azimuth, axes.layers))?;
    set_window(dict, pack.window())?;
    dict.set_item("bias", header.bias)?;
    dict.set_item("low", PyArray1::from_slice(py, &header.low))?;
    dict.set_item("span", PyArray1::from_slice(py, &header.span))?;
    dict.set_item("slope", header.slope)?;
    dict.set_item("knots", PyArray1::from_slice(py, &header.knots))?;
    let values = PyArray1::from_vec(py, pack.values().into_flattened());
    dict.set_item("values", values.reshape([layers, depth / layers, rows, columns, 3])?)?;
    match pack.curve() {
        Some(curve) => {
            let values = PyArray1::from_vec(py, curve.values().into_flattened());
            dict.set_item("curve", values.reshape([curve.levels() as usize + 1, curve.nodes(), 3])?)?;
        }
        None => dict.set_item("curve", py.None())?,
    }
    Ok(())
}

/// Texels are the stored integers.
fn add_wavelet(dict: &Bound<'_, PyDict>, pack: &WaveletPack) -> PyResult<()> {
    let (py, header) = (dict.py(), &pack.header);
    dict.set_item("parameterisation", header.parameterisation.name())?;
    dict.set_item("levels", header.levels)?;
    dict.set_item("stored_levels", header.stored_levels)?;
    dict.set_item("bits", header.bits)?;
    set_window(dict, pack.window())?;
    dict.set_item("bias", header.bias)?;
    dict.set_item("index", PyArray1::from_slice(py, &pack.index))?;
    let scales: Vec<f32> = pack.scales.iter().flat_map(|scale| [scale.scale, scale.offset]).collect();
    dict.set_item("scales", PyArray1::from_vec(py, scales).reshape([pack.slices(), 2])?)?;
    let [columns, rows, slices] = pack.extent().map(|n| n as usize);
    let format = header.texel_format();
    let shape = [slices, rows, columns, format.components()];
    match format {
        TexelFormat::R8Unorm | TexelFormat::Rgba8Unorm => {
            dict.set_item("texels", PyArray1::from_slice(py, &pack.texels).reshape(shape)?)?;
        }
        _ => {
            let words = pack.texels.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes));
            dict.set_item("texels", PyArray1::from_vec(py, words.collect()).reshape(shape)?)?;
        }
    }
    dict.set_item("energy_preserving", header.energy_preserving)?;
    Ok(())
}

fn set_window(dict: &Bound<'_, PyDict>, window: Window) -> PyResult<()> {
    dict.set_item("first", (window.first[0], window.first[1]))?;
    dict.set_item("size", (window.size[0], window.size[1]))
}
