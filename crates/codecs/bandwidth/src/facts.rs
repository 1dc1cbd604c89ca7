//! Facts about bandwidth maps.

use brdfc_formats::bandwidth::{BandwidthKind, BandwidthMap};

/// Facts about a bandwidth map.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct BandwidthFacts {
    /// 'brdf', 'environment' or 'texture'.
    pub of: String,
    /// Unit of the bandwidths.
    pub unit: String,
    /// Texels per row and rows.
    pub size: [u32; 2],
    /// Width and height of the transformed image; for materials, of each lobe.
    pub transformed: [u32; 2],
    /// Share of the largest coefficient below which coefficients are ignored.
    pub epsilon: f32,
    /// Width and height of a texture, m.
    pub metres: Option<[f32; 2]>,
    /// True if a texture repeats.
    pub tiles: Option<bool>,
    /// Largest bandwidth.
    pub largest: f32,
    /// Mean over all texels.
    pub mean: f64,
    /// For materials, the share of texels, 0 to 1, with at least a quarter of a cycle per pixel of the transformed
    /// image: lobes may vary faster there than the resolution shows.
    pub limited: Option<f64>,
    /// Share of texels without any variation, 0 to 1.
    pub constant: f64,
    /// Bytes on a GPU.
    pub gpu_bytes: u64,
}

impl BandwidthFacts {
    /// A note for users if the resolution limits some of the values.
    pub fn remark(&self) -> Option<String> {
        let share = self.limited.filter(|share| *share > 0.0)?;
        let [width, height] = self.transformed;
        let all = self.size.map(f64::from).into_iter().product::<f64>();
        let count = (share * all).round();
        Some(format!(
            "bandwidth map: {count} of {all} values may be too low, because lobes have only {width} x {height} pixels"
        ))
    }

    /// Facts of a map.
    pub fn new(map: &BandwidthMap) -> Self {
        let (header, values) = (map.header(), map.values());
        let (metres, tiles) = match header.kind {
            BandwidthKind::Texture { metres, tiles } => (Some(metres), Some(tiles)),
            _ => (None, None),
        };
        let count = values.len() as f64;
        Self {
            of: header.kind.name().to_owned(),
            unit: header.kind.unit().to_owned(),
            size: map.size(),
            transformed: header.transformed,
            epsilon: header.epsilon,
            metres,
            tiles,
            largest: values.iter().copied().fold(0.0, f32::max),
            mean: values.iter().map(|value| f64::from(*value)).sum::<f64>() / count,
            limited: map.limited(),
            constant: values.iter().filter(|value| **value == 0.0).count() as f64 / count,
            gpu_bytes: map.texel_bytes().len() as u64,
        }
    }
}
