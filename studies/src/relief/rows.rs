//! Settings and results of the study.

use schemars::JsonSchema;
use serde::Serialize;

/// Settings of the study.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ReliefSettings {
    /// Texels of all maps per side, a power of two. Heights have twice as many.
    pub texels: u32,
    /// Pixels per row of the renderings of the whole plane. The others are smaller.
    pub pixels: usize,
}

/// Results for one structure.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ReliefRow {
    /// The structure's address.
    pub model: String,
    /// One for each method.
    pub methods: Vec<MethodRow>,
}

/// Errors of a method against the surface itself, ray cast.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MethodRow {
    /// Name of the method.
    pub method: &'static str,
    /// Bytes on a GPU, mipmaps included. Absent for bounds, which compute from the surface.
    pub bytes: Option<u64>,
    /// Most filtered fetches of a pixel under one light. Absent for bounds.
    pub fetches: Option<u32>,
    /// Mean of these fetches over samples and lights of `plane`. Absent for bounds.
    pub mean_fetches: Option<f64>,
    /// 4 x 4 tiles on the plane.
    pub plane: RenderingRow,
    /// Time to draw this rendering on the CPU, nanoseconds per sample and thread. Absent for bounds.
    pub nanoseconds: Option<f64>,
    /// A part of the plane by polar angle of the view, mean of three azimuths.
    pub angles: Vec<AngleRow>,
    /// Share of the pixels whose ΔE changes by more than 5 when the camera turns by 0.5 degrees.
    pub jumps: f64,
    /// 16 x 16 tiles on the plane, against 64 samples per pixel.
    pub far: RenderingRow,
    /// 32 x 32 tiles on half as many pixels per row, about ten per tile, against 64 samples per pixel.
    pub farther: RenderingRow,
    /// Curved objects against the displaced object, outlines included.
    pub objects: Vec<ObjectRow>,
}

/// Differences of a rendering from that of the surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct RenderingRow {
    /// Mean ΔE (CIE76) over pixels that show a surface.
    pub delta_e: f64,
    /// 95th percentile of ΔE.
    pub p95: f64,
    /// PSNR of sRGB-encoded values, dB; absent if there is no difference.
    pub psnr: Option<f64>,
    /// Mean luminance over that of the surface.
    pub brightness: f64,
}

/// Mean ΔE of views at a polar angle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct AngleRow {
    /// Polar angle at the middle of the rendering, degrees.
    pub polar_angle: f64,
    /// Mean ΔE (CIE76).
    pub delta_e: f64,
}

/// Differences on a curved object.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct ObjectRow {
    /// Name of the scene.
    pub scene: &'static str,
    /// Differences from the displaced object.
    pub rendering: RenderingRow,
}
