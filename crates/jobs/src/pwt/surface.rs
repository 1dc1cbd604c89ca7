//! Normals and albedo as images.

use super::make::wrong;
use crate::error::Error;
use brdfc_pwt::LightSamples;
use brdfc_pwt::normals::{SurfaceMaps, surface_maps};
use brdfc_readers::colour::encode_srgb_byte;
use brdfc_render::rendering::{Panel, rgb_png};
use serde::Serialize;

/// Report of normals and albedo.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, schemars::JsonSchema)]
pub struct SurfaceReport {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Number of lights.
    pub lights: usize,
    /// Share of the observations that differ from Lambert's law by more than a tenth of the albedo, such as shadows and
    /// highlights. Pixels count by their albedo.
    pub outliers: f64,
    /// Mean angle between normals from two halves of the lights, degrees, by albedo: about half the error of
    /// normals where highlights cause it, and several times the error where blocked lights do. Absent for fewer than 12 lights, for
    /// renderings of maps and packs, and if halves of the lights do not determine normals.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_halves: Option<f64>,
    /// 95th percentile of the same angle over pixels, by their number; pixels darker than 2 % of the brightest do not count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_halves_p95: Option<f64>,
}

/// Angle between normals from halves of the lights above which normals may be wrong, degrees.
const UNRELIABLE: f64 = 10.0;

impl SurfaceReport {
    /// Reason to doubt the normals, if there is one.
    pub fn doubt(&self) -> Option<String> {
        let angle = self.between_halves.filter(|angle| *angle > UNRELIABLE)?;
        let why = "most light comes from highlights or bounces, or, with smaller errors, many lights are blocked";
        Some(format!("normals may be wrong: those from halves of the lights differ by {angle:.1}° on average; {why}"))
    }
}

/// Computes normals and albedo from photographs.
///
/// # Errors
/// Returns an error if photographs are out of range, or if the lights do not determine normals.
pub fn make_surface(samples: &LightSamples) -> Result<(SurfaceMaps, SurfaceReport), Error> {
    let maps = surface_maps(&*samples.distant().map_err(wrong)?).map_err(wrong)?;
    let SurfaceMaps { size, outliers, between_halves, between_halves_p95, .. } = maps;
    let report = SurfaceReport { size, lights: samples.lights.len(), outliers, between_halves, between_halves_p95 };
    Ok((maps, report))
}

/// Normals as a PNG of 8-bit RGB, `255 (n / 2 + 1 / 2)`: x to the right, y up, z to the viewer.
pub fn normals_png(maps: &SurfaceMaps) -> Vec<u8> {
    png(maps.size, maps.normal_levels())
}

/// Albedo as a PNG of sRGB levels; values above 1 are clipped.
pub fn albedo_png(maps: &SurfaceMaps) -> Vec<u8> {
    png(maps.size, maps.albedo.as_flattened().iter().map(|value| encode_srgb_byte(f64::from(*value))).collect())
}

fn png([width, height]: [usize; 2], rgb: Vec<u8>) -> Vec<u8> {
    rgb_png(&Panel { width, height, rgb })
}
