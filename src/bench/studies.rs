//! Which studies there are, and what they report.

use brdfc_studies::StudyRow;
#[cfg(feature = "render")]
use brdfc_studies::adaptive::{AntialiasingRow, DirectionsRow, Exponents};
use clap::ValueEnum;
use serde::Serialize;

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Study {
    /// Table 1 of Claustres et al. 2007: errors of Lewis, Ward and Poulin-Fournier at 4:1, 16:1 and 32:1.
    WaveletBrdf,
    /// Section 4 of Hadim et al. 2009: reconstruction, coherency, sizes and interpolation of flat BTFs. Takes minutes for
    /// each of synth:button, folds, knit and sponge, which are the default.
    FlatBtf,
    /// Rays per second against a repeated structure. With --out: mesh.ply and rays.bin for other programs.
    Rays,
    /// Section 6.3: evaluations per second, shader and CPU decoder.
    Throughput,
    /// Section 6.3, figure 10: a terrain with and without levels of detail, time per level, flicker.
    LevelOfDetail,
    /// Section 6.3, figure 9: colour differences on a cloth, shader against source, 4:1 and 8 bits.
    Images,
    /// Section 5 of Bagher et al. 2012: samples that adaptive and forward shading need for the same error, of every
    /// material on two shapes, on the CPU. Minutes for each material.
    Adaptive,
    /// Figure 12 of Bagher et al. 2012: predicted pixel bandwidth against windowed Fourier transforms, on a sphere.
    PixelBandwidth,
    /// Figure 13 of Bagher et al. 2012: error with bandwidth averaged over 16 to 1024 directions.
    BandwidthDirections,
    /// Figure 10 of Bagher et al. 2012: cost of adaptive shading with 1, 4 and 16 points per pixel.
    Antialiasing,
}

/// What `--json` prints.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    pub(super) version: u32,
    /// The study's figures.
    #[serde(flatten)]
    pub(super) result: StudyResult,
}

/// Figures of a study.
#[derive(Debug, Serialize, schemars::JsonSchema)]
#[serde(tag = "study", rename_all = "kebab-case")]
pub enum StudyResult {
    /// Table 1.
    WaveletBrdf {
        /// Rows of the table.
        rows: Vec<StudyRow>,
    },
    /// Tables 1, 2 and 3 and figure 10 of Hadim et al. 2009.
    FlatBtf {
        /// What was computed.
        settings: brdfc_studies::flat_btf::StudySettings,
        /// One for each model.
        rows: Vec<brdfc_studies::flat_btf::ModelRow>,
    },
    /// Rays per second.
    Rays(brdfc_studies::rays::RayStudy),
    /// Evaluations per second.
    #[cfg(feature = "render")]
    Throughput(brdfc_studies::throughput::Throughput),
    /// The terrain.
    #[cfg(feature = "render")]
    LevelOfDetail(brdfc_studies::level_of_detail::LevelOfDetail),
    /// Colour differences on the cloth.
    #[cfg(feature = "render")]
    Images {
        /// One for each material.
        rows: Vec<brdfc_studies::images::ImageRow>,
    },
    /// Adaptive and forward shading at equal error.
    #[cfg(feature = "render")]
    Adaptive {
        /// One for each material, shape and error.
        rows: Vec<brdfc_studies::adaptive::EqualErrorRow>,
    },
    /// Predicted bandwidth against Fourier transforms.
    #[cfg(feature = "render")]
    PixelBandwidth {
        /// One for each material.
        rows: Vec<brdfc_studies::adaptive::FourierRow>,
    },
    /// Numbers of incident directions.
    #[cfg(feature = "render")]
    BandwidthDirections {
        /// One for each material.
        rows: Vec<DirectionsStudy>,
    },
    /// Points per pixel.
    #[cfg(feature = "render")]
    Antialiasing {
        /// One for each material and shape.
        rows: Vec<AntialiasingStudy>,
    },
}

/// Numbers of directions for one material.
#[cfg(feature = "render")]
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct DirectionsStudy {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// One for each number.
    pub rows: Vec<DirectionsRow>,
}

/// Antialiasing of one material on one shape.
#[cfg(feature = "render")]
#[derive(Debug, Clone, Serialize, schemars::JsonSchema)]
pub struct AntialiasingStudy {
    /// The input.
    pub material: String,
    /// The shape.
    pub shape: String,
    /// 1, 4 and 16 points per pixel.
    pub rows: Vec<AntialiasingRow>,
    /// How cost grows with points.
    pub exponents: Option<Exponents>,
}
