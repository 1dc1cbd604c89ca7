//! Which decoders there are, what they are made of, and what engines call.

use brdfc_formats::PackKind;
use brdfc_formats::bandwidth::shader::BANDWIDTH_WGSL;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_formats::importance::IMPORTANCE_WGSL;
use brdfc_formats::pwt::shader::PWT_WGSL;
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;

/// The decoder of a kind of pack.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Decoder {
    /// Table packs of BRDFs, factored ones included.
    Table,
    /// Wavelet packs of BRDFs.
    Wavelet,
    /// Flat BTFs of any form.
    FlatBtf,
    /// Polynomial wavelet trees: pictures under any light.
    Pwt,
    /// Bandwidth maps.
    Bandwidth,
    /// Importance samples.
    Importance,
}

impl Decoder {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Table, Self::Wavelet, Self::FlatBtf, Self::Pwt, Self::Bandwidth, Self::Importance];

    /// What it is called on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Table => "table",
            Self::Wavelet => "wavelet",
            Self::FlatBtf => "flat-btf",
            Self::Pwt => "pwt",
            Self::Bandwidth => "bandwidth",
            Self::Importance => "importance",
        }
    }

    /// The decoder of this [`Self::name`].
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|decoder| decoder.name() == name)
    }

    /// What decodes a kind of pack.
    pub fn of(kind: PackKind) -> Self {
        match kind {
            PackKind::Table => Self::Table,
            PackKind::Wavelet => Self::Wavelet,
            PackKind::FlatBtf => Self::FlatBtf,
            PackKind::Pwt => Self::Pwt,
            PackKind::Bandwidth => Self::Bandwidth,
            PackKind::Importance => Self::Importance,
        }
    }

    /// What it decodes, for people.
    pub fn title(self) -> &'static str {
        match self {
            Self::Table => "table packs",
            Self::Wavelet => "wavelet packs",
            Self::FlatBtf => "flat BTFs",
            Self::Pwt => "polynomial wavelet trees",
            Self::Bandwidth => "bandwidth maps",
            Self::Importance => "importance samples",
        }
    }

    /// The page that describes the files.
    pub fn specification(self) -> &'static str {
        match self {
            Self::Table => "formats/src/table/spec.md",
            Self::Wavelet => "formats/src/wavelet/spec.md",
            Self::FlatBtf => "formats/src/flat_btf/spec.md",
            Self::Pwt => "formats/src/pwt/spec.md",
            Self::Bandwidth => "formats/src/bandwidth/spec.md",
            Self::Importance => "formats/src/importance/spec.md",
        }
    }

    /// The WGSL that everything else is translated from: it has no entry point.
    pub fn wgsl(self) -> String {
        match self {
            Self::Table => TABLE_BRDF_WGSL.to_owned(),
            Self::Wavelet => WAVELET_BRDF_WGSL.to_owned(),
            Self::FlatBtf => flat_btf_value_wgsl(),
            Self::Pwt => PWT_WGSL.to_owned(),
            Self::Bandwidth => BANDWIDTH_WGSL.to_owned(),
            Self::Importance => IMPORTANCE_WGSL.to_owned(),
        }
    }

    /// What engines call, the first one foremost.
    pub fn functions(self) -> &'static [&'static str] {
        match self {
            Self::Table => &["table_brdf", "table_brdf_exact", "table_brdf_at", "table_brdf_level_of_detail"],
            Self::Wavelet => &["wavelet_brdf", "wavelet_brdf_exact", "wavelet_brdf_level_of_detail"],
            Self::FlatBtf => {
                &["flat_btf_value", "flat_btf_light_form", "flat_btf_indirection", "factored_mipmap_level"]
            }
            Self::Pwt => &["pwt_value", "pwt_mipmap_level"],
            Self::Bandwidth => &["bandwidth_brdf", "bandwidth_environment", "bandwidth_texture"],
            Self::Importance => &["importance_sample"],
        }
    }

    /// What a query of three groups of four numbers, `a`, `b` and `c`, is answered with: the body of the compute shader that
    /// SPIR-V has in place of a piece to paste.
    pub fn answer(self) -> Answer {
        match self {
            Self::Table => Answer {
                takes: "a: wi and the level of detail; b: wo and 1 where the sampler filters, else 0",
                gives: "f_r",
                body: "vec4<f32>(table_brdf_at(a.xyz, b.xyz, a.w, b.w == 1.0), 0.0)",
            },
            Self::Wavelet => Answer {
                takes: "a: wi and the level of detail; b: wo and 1 where the sampler filters, else 0",
                gives: "f_r",
                body: "vec4<f32>(select(wavelet_brdf_exact(a.xyz, b.xyz, a.w), wavelet_brdf(a.xyz, b.xyz, a.w), \
                       b.w == 1.0), 0.0)",
            },
            Self::FlatBtf => Answer {
                takes: "a: uv and the level of detail; b: view; c: light",
                gives: "radiance divided by that of a white diffuser",
                body: "vec4<f32>(flat_btf_value(a.xy, a.z, b.xyz, c.xyz), 0.0)",
            },
            Self::Pwt => Answer {
                takes: "a: uv and the level of detail; b: wi",
                gives: "linear RGB",
                body: "vec4<f32>(pwt_value(a.xy, a.z, b.xyz), 0.0)",
            },
            Self::Bandwidth => Answer {
                takes: "a: wi; b: wo; c: uv",
                gives: "bandwidths of the lobe, of the environment at wi, of the texture at uv",
                body: "vec4<f32>(bandwidth_brdf(a.xyz, b.xyz), bandwidth_environment(a.xyz), \
                       bandwidth_texture(c.xy), 0.0)",
            },
            Self::Importance => Answer {
                takes: "a: wo and the index of the sample",
                gives: "wi and 1 / density",
                body: "answer_of(importance_sample(a.xyz, u32(a.w)))",
            },
        }
    }
}

/// How a query is answered.
#[derive(Debug, Clone, Copy)]
pub struct Answer {
    /// What the groups of a query hold, in words.
    pub takes: &'static str,
    /// What an answer holds, in words.
    pub gives: &'static str,
    /// A WGSL expression.
    pub body: &'static str,
}
