//! Materials with values at direction pairs.

use super::arrays::{Argument, colours};
use super::errors::{problem, wrong};
use super::fields;
use super::threads::threads;
use brdfc_formats::{BrdfDecoder, BrdfPack};
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_source::open::{Facts, Opened, open, opened};
use brdfc_source::pack::open_brdf_pack;
use brdfc_core::words::format_number;
use brdfc_core::{Source, Tally};
use brdfc_source::{Input, InputError};
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;

/// Pairs per task of a thread.
const CHUNK: usize = 256;

/// A measured file, a model or a pack: f_r at direction pairs.
#[pyclass(frozen, module = "brdfc")]
pub struct Material {
    name: String,
    source: Box<dyn Source>,
    facts: Facts,
    /// The pack and its decoder, if the material is a pack.
    decoded: Option<(BrdfPack, Box<dyn BrdfDecoder>)>,
}

impl Material {
    /// Opens a material.
    ///
    /// # Errors
    /// Returns an error if the input cannot be read or does not follow its layout.
    pub fn open(input: &Input) -> Result<Self, InputError> {
        let name = input.to_string();
        if input.extension()? != "ktx2" {
            let Opened { source, facts } = open(input, None)?;
            return Ok(Self { name, source, facts, decoded: None });
        }
        let pack = open_brdf_pack(input)?;
        let Opened { source, facts } = opened(&pack, None);
        let decoder = pack.decoder();
        Ok(Self { name, source, facts, decoded: Some((pack, decoder)) })
    }

    /// Resolves the level of detail.
    fn level(&self, lod: Option<f32>) -> PyResult<f32> {
        let finest = self.levels() as f32;
        match (lod, &self.decoded) {
            (None, _) => Ok(finest),
            (Some(_), None) => Err(problem("lod", "only packs have levels of detail; omit lod")),
            (Some(level), _) if (0.0..=finest).contains(&level) => Ok(level),
            (Some(level), _) => Err(wrong("lod", format_number(level), format!("0 to {finest}, the pack's levels"))),
        }
    }

    fn value(&self, pair: DirectionPair, level: f32, tally: &mut Tally) -> [f32; 3] {
        match &self.decoded {
            Some((_, decoder)) => decoder.eval(pair, level, Filter::Bilinear),
            None => self.source.eval(pair, tally).map(|channel| channel as f32),
        }
    }
}

#[pymethods]
impl Material {
    /// Returns f_r at direction pairs, in 1/sr, linear RGB (Rec. 709): float32 of shape (..., 3).
    ///
    /// wi (to the light) and wo (to the viewer) are unit vectors in the frame x = tangent, y = bitangent, z = normal, of
    /// shape (..., 3); shapes are broadcast by the rules of NumPy. Lengths may be off by 1 %. Values are 0 if a direction is at or
    /// below the horizon; values of measurements may be slightly negative. lod is the level of detail of a pack: 0, the coarsest,
    /// to `levels`, the finest (default: the finest).
    ///
    /// Raises ValueError for other shapes, vectors of other lengths, and levels out of range.
    #[pyo3(signature = (wi, wo, lod = None))]
    fn eval<'py>(
        &self,
        py: Python<'py>,
        wi: &Bound<'py, PyAny>,
        wo: &Bound<'py, PyAny>,
        lod: Option<f32>,
    ) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
        let (wi, wo) = (Argument::new("wi", wi, 3)?, Argument::new("wo", wo, 3)?);
        let shape = Argument::common_shape(&[&wi, &wo])?;
        let (incoming, outgoing) = (wi.directions(&shape)?, wo.directions(&shape)?);
        let level = self.level(lod)?;
        let of_chunk = |(incoming, outgoing): (&[_], &[_])| {
            let mut tally = Tally::default();
            let pairs = incoming.iter().zip(outgoing).map(|(i, o)| DirectionPair::new(*i, *o));
            pairs.map(|pair| self.value(pair, level, &mut tally)).collect::<Vec<_>>()
        };
        let all = || incoming.par_chunks(CHUNK).zip(outgoing.par_chunks(CHUNK)).flat_map_iter(of_chunk).collect();
        let threads = threads(py)?;
        let values: Vec<_> = py.detach(|| threads.install(all));
        colours(py, values, &shape)
    }

    /// Kind of the material, as in `brdfc info --json`: merl, table-pack and so on.
    #[getter]
    fn kind(&self) -> String {
        let facts = serde_json::to_value(&self.facts).unwrap_or_default();
        facts["kind"].as_str().unwrap_or_default().to_owned()
    }

    /// True if the material is known to be isotropic. False for all wavelet packs, which do not store it.
    #[getter]
    fn isotropic(&self) -> bool {
        self.source.symmetry().isotropic
    }

    /// True if the material is known to be reciprocal.
    #[getter]
    fn reciprocal(&self) -> bool {
        self.source.symmetry().reciprocal
    }

    /// True if the three channels are equal everywhere.
    #[getter]
    fn grey(&self) -> bool {
        self.source.is_grey()
    }

    /// Number of levels of detail coarser than the finest; 0 for materials that are not packs.
    #[getter]
    fn levels(&self) -> u32 {
        self.facts.levels().unwrap_or(0)
    }

    /// The facts of `brdfc info --json`, as a dict.
    #[getter]
    fn facts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let text = serde_json::to_string(&self.facts).map_err(|error| wrong("facts", error.to_string(), "JSON"))?;
        py.import("json")?.call_method1("loads", (text,))
    }

    /// Header and texels of a pack, for other decoders: a dict with the fields of the layout's specification.
    ///
    /// Raises ValueError if the material is not a pack.
    fn pack<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match &self.decoded {
            Some((pack, _)) => fields::of_pack(py, pack),
            None => Err(wrong("pack", format!("{} ({})", self.name, self.kind()), "a pack of a BRDF")),
        }
    }

    fn __repr__(&self) -> String {
        format!("<brdfc.Material {}: {}>", self.kind(), self.name)
    }
}
