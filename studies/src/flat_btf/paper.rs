//! Figures of the paper, for its models.

use serde::Serialize;

/// The paper's figures for one of its models; Lab distances and variances.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct PaperModel {
    /// Table 1: average, maximum and variance of the difference.
    pub reconstruction: [f64; 3],
    /// Table 2, average variance: BTF, filled, visible only.
    pub average_variance: [f64; 3],
    /// Table 2, maximal variance: BTF, filled, visible only.
    pub maximal_variance: [f64; 3],
    /// Table 3, kilobytes of PNG: flat and ordinary, texel 1, then texel 2.
    pub png_kilobytes: [[f64; 2]; 2],
    /// Table 3, kilobytes of JPEG of the best quality.
    pub jpeg_kilobytes: [[f64; 2]; 2],
}

/// Our structure, the paper's model, and the paper's figures for it.
pub const PAPER: [(&str, &str, PaperModel); 4] = [
    (
        "sponge",
        "Sponge",
        PaperModel {
            reconstruction: [10.23, 15.10, 0.63],
            average_variance: [39.82, 18.95, 5.19],
            maximal_variance: [41.57, 30.32, 24.8],
            png_kilobytes: [[3.5, 5.6], [1.1, 5.9]],
            jpeg_kilobytes: [[9.2, 14.7], [3.4, 14.8]],
        },
    ),
    (
        "button",
        "Button",
        PaperModel {
            reconstruction: [3.0, 8.17, 0.46],
            average_variance: [35.38, 16.87, 7.14],
            maximal_variance: [41.93, 32.92, 18.89],
            png_kilobytes: [[3.3, 3.4], [3.2, 5.2]],
            jpeg_kilobytes: [[10.6, 12.6], [10.6, 14.1]],
        },
    ),
    (
        "folds",
        "Isba",
        PaperModel {
            reconstruction: [2.91, 9.56, 2.41],
            average_variance: [14.29, 8.75, 5.12],
            maximal_variance: [33.14, 29.65, 9.96],
            png_kilobytes: [[2.1, 4.8], [2.5, 5.7]],
            jpeg_kilobytes: [[5.3, 6.5], [7.9, 11.2]],
        },
    ),
    (
        "knit",
        "Pulli",
        PaperModel {
            reconstruction: [5.46, 9.12, 0.30],
            average_variance: [23.20, 7.83, 1.38],
            maximal_variance: [26.85, 19.46, 10.01],
            png_kilobytes: [[3.8, 5.6], [1.4, 5.8]],
            jpeg_kilobytes: [[8.9, 12.9], [3.7, 12.8]],
        },
    ),
];
