//! Measures every codec on one material.

use super::blocks::{Blocks, whole_blocks};
use super::neural::NeuralBrdf;
use super::peers::{Compress, DenseTable, Peers};
use super::volume::{Meaning, Volume};
use super::{CodecMaterial, CodecRow};
use crate::fitted_ggx::fitted_ggx;
use crate::rates::Rates;
use brdfc_core::PackSource;
use brdfc_core::analytic::Ggx;
use brdfc_core::{Source, Tally};
use brdfc_formats::BrdfPack;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::wavelet::Filter;
use brdfc_gpu::{Gpu, GpuError, SliceFilter};
use brdfc_jobs::encode::EncodeError;
use brdfc_jobs::encode::PackRecipe;
use brdfc_jobs::encode::encode;
use brdfc_metrics::compare::{Comparison, Reference};
use brdfc_metrics::sampling::{PairSet, random_pairs};
use brdfc_probe::{EVALUATE_ENTRY_WGSL, Evaluated, Evaluator};
use brdfc_table::encode::{Prepared, samples_for};
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_wavelet::recipe::{Recipe, Target};
use std::time::Instant;

/// Tables, plain and factored, in KiB on a GPU.
const SIZES: [u64; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
/// Tables whose nodes are compressed, in KiB of ten bits a channel.
const FOR_PEERS: [u64; 4] = [16, 64, 256, 1024];
/// Tables whose slices become blocks, in KiB of ten bits a channel; blocks take a quarter.
const FOR_BLOCKS: [u64; 4] = [4, 16, 64, 256];
const RATIOS: [f64; 3] = [64.0, 16.0, 4.0];
const GGX_WGSL: &str = include_str!("ggx.wgsl");
/// Pairs at which the shader of a model in closed form is compared with the model.
const CHECKED_PAIRS: usize = 1024;
const SEED: u64 = 8;
/// Two colours and two numbers.
const GGX_BYTES: u64 = 32;

/// Errors of a study.
#[derive(Debug, thiserror::Error)]
pub enum CodecStudyError {
    /// The driver reported an error.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A pack could not be made.
    #[error(transparent)]
    Pack(#[from] EncodeError),
    /// A compressor reported an error.
    #[error("{0}")]
    Peer(String),
}

/// Measures every codec and the given alternatives on one material.
///
/// # Errors
/// Returns errors of drivers and compressors, or of encoding the source.
pub fn codec_study(
    gpu: &Gpu,
    name: &str,
    source: &dyn Source,
    peers: &Peers<'_>,
) -> Result<CodecMaterial, CodecStudyError> {
    let mut study = Study {
        gpu,
        source,
        rates: Rates::new(gpu)?,
        reference: Reference::new(source, PairSet::comparison()),
        rows: Vec::new(),
    };
    let shares_of_network = peers.network.iter().flat_map(|_| [NeuralBrdf::bytes() / 2, NeuralBrdf::bytes()]);
    let first = study.packs(&SIZES.iter().map(|kib| kib << 10).chain(shares_of_network).collect::<Vec<_>>())?;
    study.blocks()?;
    if let Some(compress) = peers.compress {
        study.compressors(compress)?;
    }
    study.ggx(&first)?;
    if let Some(network) = &peers.network {
        study.network(network, &first)?;
    }
    Ok(CodecMaterial { material: name.to_owned(), rows: study.rows })
}

struct Study<'a> {
    gpu: &'a Gpu,
    source: &'a dyn Source,
    rates: Rates<'a>,
    reference: Reference,
    rows: Vec<CodecRow>,
}

impl Study<'_> {
    /// Measures tables and factored tables of these bytes on a GPU, and wavelets, in their file formats. Returns the first of
    /// the packs.
    fn packs(&mut self, sizes: &[u64]) -> Result<BrdfPack, CodecStudyError> {
        let table = |factored, bytes: u64| {
            PackRecipe::Table(TableRecipe { size: Size::Bytes(bytes), factored, ..TableRecipe::default() }.into())
        };
        let tables =
            [false, true].into_iter().flat_map(|factored| sizes.iter().map(move |bytes| table(factored, *bytes)));
        let wavelets =
            RATIOS.map(|ratio| PackRecipe::Wavelet(Recipe { target: Target::Ratio(ratio), ..Recipe::visible() }));
        let mut first = None;
        for recipe in tables.chain(wavelets) {
            let start = Instant::now();
            let made = encode(self.source, &recipe.without_measuring(), &())?;
            let encode_seconds = start.elapsed().as_secs_f64();
            let error = self.reference.compare(&PackSource::new(&*made.pack, None));
            let decoder = made.pack.decoder();
            let level = decoder.levels() as f32;
            let cpu = self.rates.cpu(false, |pair| decoder.eval(pair, level, Filter::Bilinear)[0]);
            let shader = self.rates.shader(&made.pack, Filter::Bilinear, level, SliceFilter::Hardware)?;
            self.rows.push(CodecRow {
                sampled: true,
                bytes_on_gpu: made.pack.gpu_bytes(),
                bytes_on_disk: made.bytes.len() as u64,
                fetches: Some(made.pack.fetches()),
                encode_seconds,
                cpu: Some(cpu),
                shader: Some(shader),
                ..row(made.codec.variant(), made.codec.size(), &error)
            });
            first.get_or_insert(made.pack);
        }
        Ok(first.expect("packs were made"))
    }

    /// The fitted nodes of a table of a size.
    fn nodes(&self, size: Size) -> Result<(Volume, f64), CodecStudyError> {
        let start = Instant::now();
        let recipe = TableRecipe { size, ..TableRecipe::default() };
        let samples = samples_for(size, self.source.is_grey());
        let prepared = Prepared::new(self.source, &recipe, samples, &()).map_err(EncodeError::from)?;
        let (header, nodes) = prepared.nodes(size, &())?;
        Ok((Volume { header, nodes, meaning: Meaning::Logarithm }, start.elapsed().as_secs_f64()))
    }

    fn blocks(&mut self) -> Result<(), CodecStudyError> {
        for kib in FOR_BLOCKS {
            let (volume, choosing) = self.nodes(Size::Bytes(kib << 10))?;
            let (volume, seconds) = self.nodes(Size::Nodes(whole_blocks(volume.header.axes)))?;
            let size = volume.header.axes;
            for blocks in Blocks::ALL {
                let start = Instant::now();
                let (bytes, coded) = blocks.coded(&volume);
                let encode_seconds = choosing + seconds + start.elapsed().as_secs_f64();
                let error = self.reference.compare(&coded);
                let (name, of) = blocks.name();
                self.rows.push(CodecRow {
                    sampled: true,
                    bytes_on_gpu: bytes,
                    bytes_on_disk: bytes,
                    fetches: Some(if volume.header.isotropic() { 1 } else { 2 }),
                    encode_seconds,
                    ..row(name, format!("{of}, {size}"), &error)
                });
            }
        }
        Ok(())
    }

    fn compressors(&mut self, compress: &Compress<'_>) -> Result<(), CodecStudyError> {
        let fitted = FOR_PEERS
            .map(|kib| self.nodes(Size::Bytes(kib << 10)))
            .into_iter()
            .collect::<Result<Vec<_>, CodecStudyError>>()?;
        let mut volumes: Vec<_> = fitted.into_iter().map(|(volume, seconds)| (volume, seconds, false)).collect();
        if self.source.symmetry().isotropic {
            let header = volumes[0].0.header;
            let start = Instant::now();
            let dense = Volume::dense(self.source, header.symmetry, header.mean, header.bias);
            volumes.push((dense, start.elapsed().as_secs_f64(), true));
        }
        for (volume, seconds, dense) in volumes {
            let axes = volume.header.axes;
            let shape = [axes.layers, axes.azimuth, axes.difference, axes.half].map(|n| n as usize);
            let shape = shape[usize::from(axes.layers == 1)..].to_vec();
            let made = compress(&DenseTable::new(shape, &volume.nodes, self.source.is_grey()))
                .map_err(CodecStudyError::Peer)?;
            for compressed in made {
                let decoded = Volume { nodes: compressed.nodes(), ..volume.clone() };
                let error = self.reference.compare(&decoded);
                self.rows.push(CodecRow {
                    dense,
                    bytes_on_gpu: volume.header.texels() as u64 * if self.source.is_grey() { 2 } else { 8 },
                    bytes_on_disk: compressed.bytes,
                    encode_seconds: seconds + compressed.seconds,
                    ..row(&compressed.codec, format!("{axes}, {}", compressed.tolerance), &error)
                });
            }
        }
        Ok(())
    }

    /// Measures the fitted model. `any` is a pack for the bindings that its shader does not use.
    fn ggx(&mut self, any: &BrdfPack) -> Result<(), CodecStudyError> {
        let start = Instant::now();
        let ggx = fitted_ggx(self.source, self.reference.exposure());
        let fitted = Closed {
            codec: "ggx",
            setting: parameters(&ggx),
            bytes: GGX_BYTES,
            encode_seconds: start.elapsed().as_secs_f64(),
            shader: ggx_source(&ggx),
        };
        self.closed(&ggx, fitted, any)
    }

    /// Measures a network, whose training is not timed.
    fn network(&mut self, network: &NeuralBrdf, any: &BrdfPack) -> Result<(), CodecStudyError> {
        let trained = Closed {
            codec: "neural",
            setting: NeuralBrdf::setting(),
            bytes: NeuralBrdf::bytes(),
            encode_seconds: 0.0,
            shader: network.shader(),
        };
        self.closed(network, trained, any)
    }

    /// Measures a model without textures.
    fn closed(&mut self, model: &dyn Source, closed: Closed, any: &BrdfPack) -> Result<(), CodecStudyError> {
        let error = self.reference.compare(model);
        let cpu = self.rates.cpu(false, |pair| model.eval(pair, &mut Tally::default())[0] as f32);
        let evaluator = Evaluator::with_shaders(self.gpu, &closed.shader, EVALUATE_ENTRY_WGSL)?;
        let loaded = evaluator.load(any, Filter::Bilinear)?;
        let pairs = random_pairs(CHECKED_PAIRS, SEED);
        let found = evaluator.eval(&loaded, &pairs, 0.0, SliceFilter::Hardware)?;
        let is_equal = |(pair, found): (&DirectionPair, Evaluated)| {
            let exact = model.eval(*pair, &mut Tally::default());
            found.f_r.iter().zip(exact).all(|(found, exact)| (f64::from(*found) - exact).abs() < 0.01 * exact + 1e-3)
        };
        if !pairs.iter().zip(found).all(is_equal) {
            return Err(CodecStudyError::Peer(format!("{}: the shader differs from the model", closed.codec)));
        }
        let shader = self.rates.shader_of(&evaluator, &loaded, 0.0, SliceFilter::Hardware)?;
        self.rows.push(CodecRow {
            sampled: true,
            bytes_on_gpu: closed.bytes,
            bytes_on_disk: closed.bytes,
            fetches: Some(0),
            encode_seconds: closed.encode_seconds,
            cpu: Some(cpu),
            shader: Some(shader),
            ..row(closed.codec, closed.setting, &error)
        });
        Ok(())
    }
}

/// A model in closed form.
struct Closed {
    codec: &'static str,
    setting: String,
    bytes: u64,
    encode_seconds: f64,
    shader: String,
}

/// The common values of a row; others are absent.
fn row(codec: &str, setting: String, error: &Comparison) -> CodecRow {
    CodecRow {
        codec: codec.to_owned(),
        setting,
        dense: false,
        sampled: false,
        bytes_on_gpu: 0,
        bytes_on_disk: 0,
        fetches: None,
        encode_seconds: 0.0,
        cpu: None,
        shader: None,
        relative_error: error.norms.relative_mean,
        delta_e: error.rendering.delta_e.mean,
        delta_e_p95: error.rendering.delta_e.p95,
    }
}

fn parameters(ggx: &Ggx) -> String {
    let colour = |c: [f64; 3]| c.map(|v| format!("{v:.3}")).join(",");
    let alpha = if ggx.alpha_x == ggx.alpha_y {
        format!("alpha={:.3}", ggx.alpha_x)
    } else {
        format!("alpha_x={:.3}&alpha_y={:.3}", ggx.alpha_x, ggx.alpha_y)
    };
    format!("kd={}&f0={}&{alpha}", colour(ggx.kd), colour(ggx.f0))
}

fn ggx_source(ggx: &Ggx) -> String {
    let vector = |c: [f64; 3]| format!("vec3<f32>({:.7}, {:.7}, {:.7})", c[0], c[1], c[2]);
    format!(
        "const KD = {};\nconst F0 = {};\nconst ALPHA = vec2<f32>({:.7}, {:.7});\n{GGX_WGSL}",
        vector(ggx.kd),
        vector(ggx.f0),
        ggx.alpha_x,
        ggx.alpha_y
    )
}
