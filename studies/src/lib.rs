//! Studies that reproduce the papers' tables and figures, and list the papers' own numbers next to ours.

#[cfg(feature = "render")]
pub mod adaptive;
pub mod btf;
#[cfg(feature = "render")]
pub mod codecs;
#[cfg(feature = "render")]
mod fitted_ggx;
pub mod flat_btf;
#[cfg(feature = "render")]
pub mod frame_time;
#[cfg(feature = "render")]
pub mod images;
#[cfg(feature = "render")]
pub mod level_of_detail;
pub mod measured_btf;
pub mod pareto;
#[cfg(feature = "render")]
mod rates;
pub mod rays;
pub mod relief;
pub mod relighting;
pub mod stress;
#[cfg(feature = "render")]
pub mod throughput;
mod timing;
mod wavelet;

pub use wavelet::{StudyRow, wavelet_table_1};

use serde::Serialize;

/// The studies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Study {
    /// Table 1 of Claustres et al. 2007: errors of Lewis, Ward and Poulin-Fournier at 4:1, 16:1 and 32:1.
    WaveletBrdf,
    /// Section 4 of Hadim et al. 2009: reconstruction, coherency, sizes and interpolation of flat BTFs. Takes minutes
    /// for each of synth:button, folds, knit and sponge (the default).
    FlatBtf,
    /// Methods to show a relief, compared with the surface itself: layers, a height field, a normal map, sampled indirections and
    /// shadows, and bounds; by polar angle, in motion, far away, on curved objects. Takes minutes for each of
    /// synth:button, folds, knit and sponge (the default).
    Relief,
    /// Flat BTFs of images and the surface that explains their parallax, and of materials: PSNR over all views and
    /// lights, and bytes, to compare with neural BTFs. Takes minutes for each of synth:button, folds, knit and sponge (the default).
    MeasuredBtf,
    /// Figure 1 (b) of Baril et al. 2008: photographs under known lights as polynomial texture maps, hemispherical harmonics,
    /// interpolated principal components and polynomial wavelet trees, at fitted and at held-out lights. Inputs are captures, or
    /// folders with a Dome to fit and a Test. With --out: relighting.png.
    Relighting,
    /// Methods to store the BTF of a structure, ordinary and flat: polynomial texture maps, hemispherical harmonics,
    /// polynomial wavelet trees, factors; bytes, fetches, errors at fitted and at held-out lights. Takes minutes for
    /// each of synth:button, folds, knit and sponge (the default). With --out: btf.svg.
    Btf,
    /// Rays per second against a repeated structure. With --out: mesh.ply and rays.bin for other programs.
    Rays,
    /// Section 6.3: evaluations per second of shader and CPU decoder.
    Throughput,
    /// Packs compared with zfp, SZ3, BC6H and BC7, and a fitted GGX: bytes, times, errors. Takes minutes. With --out:
    /// codecs.svg.
    Codecs,
    /// Run time and error: sweeps codecs, sizes, grids and bits, and prints the Pareto fronts. Takes minutes
    /// for each material. With --out: pareto.svg.
    Pareto,
    /// Section 6.3, figure 10: a terrain with and without levels of detail, time per level, flicker.
    LevelOfDetail,
    /// Section 6.3, figure 9: colour differences on a cloth, shader against source, 4:1 and 8 bits. With --out figure 8 (b):
    /// the pack, and its source lit at each pixel and at each vertex.
    Images,
    /// Numerical stability: every stage at the ends of its range, its worst error, the bound, and the error of a deliberately
    /// broken stage. Takes a minute.
    Stress,
    /// Time of a frame under point lights, and in an environment by lobes and by forward shading; and with each form of relief of
    /// flat BTFs.
    FrameTime,
    /// Section 5 of Bagher et al. 2012: samples and time for the same PSNR, and for the same FLIP, under an environment, on
    /// the CPU: forward shading, filtered importance sampling, half and quarter resolution, the split sum of engines,
    /// spherical Gaussians, lobes, adaptive shading; five materials, four shapes, three environments, three sizes. Also figures
    /// 14 and 15: errors at equal time. Takes 20 minutes without options. With --out: a contact sheet of each case at equal time.
    Adaptive,
    /// Figure 12 of Bagher et al. 2012: predicted pixel bandwidth against windowed Fourier transforms, and predicted variance
    /// against that of samples, on a sphere. With --out: maps of all.
    PixelBandwidth,
    /// Figure 13 of Bagher et al. 2012: error with bandwidth averaged over 16 to 1024 directions.
    BandwidthDirections,
    /// Figure 10 of Bagher et al. 2012: cost of adaptive shading with 1, 4 and 16 points per pixel, and time by the number of
    /// samples.
    Antialiasing,
}

/// Results of a study.
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
        /// Settings of the study.
        settings: flat_btf::StudySettings,
        /// One row for each model.
        rows: Vec<flat_btf::ModelRow>,
    },
    /// Methods to show a relief.
    Relief {
        /// Settings of the study.
        settings: relief::ReliefSettings,
        /// One row for each structure.
        rows: Vec<relief::ReliefRow>,
    },
    /// Flat BTFs of images.
    MeasuredBtf {
        /// Two rows for each structure.
        rows: Vec<measured_btf::MeasuredBtfRow>,
    },
    /// Methods to store photographs under known lights.
    Relighting(relighting::RelightingStudy),
    /// Methods to store BTFs.
    Btf(btf::BtfStudy),
    /// Rays per second.
    Rays(rays::RayStudy),
    /// Errors and bounds of every stage.
    Stress(stress::StressStudy),
    /// Run time and error.
    Pareto(pareto::ParetoStudy),
    /// Evaluations per second.
    #[cfg(feature = "render")]
    Throughput(throughput::Throughput),
    /// Packs compared with alternatives.
    #[cfg(feature = "render")]
    Codecs(codecs::CodecStudy),
    /// The terrain with and without levels of detail.
    #[cfg(feature = "render")]
    LevelOfDetail(level_of_detail::LevelOfDetail),
    /// Colour differences on the cloth.
    #[cfg(feature = "render")]
    Images {
        /// One for each material.
        rows: Vec<images::ImageRow>,
    },
    /// Times of a frame.
    #[cfg(feature = "render")]
    FrameTime {
        /// A scene with packs of materials.
        #[serde(flatten)]
        times: frame_time::FrameTimes,
        /// A plane with flat BTFs.
        reliefs: relief::ReliefFrames,
    },
    /// Methods of shading under an environment at equal error.
    #[cfg(feature = "render")]
    Adaptive {
        /// Targets, in the order of costs.
        targets: Vec<adaptive::Target>,
        /// One for each case.
        rows: Vec<adaptive::CaseRow>,
        /// One for each method.
        summary: Vec<adaptive::MethodSummary>,
    },
    /// Predicted bandwidth against Fourier transforms.
    #[cfg(feature = "render")]
    PixelBandwidth {
        /// One for each material.
        rows: Vec<adaptive::FourierRow>,
    },
    /// Numbers of incident directions.
    #[cfg(feature = "render")]
    BandwidthDirections {
        /// One for each material.
        rows: Vec<adaptive::DirectionsStudy>,
    },
    /// Points per pixel.
    #[cfg(feature = "render")]
    Antialiasing {
        /// One for each material and shape.
        rows: Vec<adaptive::AntialiasingStudy>,
    },
}
