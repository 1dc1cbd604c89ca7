//! The CPU decoder of flat BTFs, the reference that shaders are held against. Equation and section numbers are those of
//! Hadim et al. 2009; FBTF are the views, VDIM is the indirection map.
//!
//! Every step is f32 arithmetic in a fixed order without fused operations, so that a shader that follows it with
//! manual filtering gives the same bits.

use super::atlas::Atlas;
use super::flat_view::FlatView;
use super::indirection::{IndirectionHeader, IndirectionMap};
use super::maps::{DiffuseMap, NormalMap, ReferenceMap};
use crate::FormatError;
use crate::container::rgb9e5;
use crate::direction::polynomial_atan2;
use crate::tap::{Tap, footprint, periodic_tap, wrap};
use std::f32::consts::TAU;

/// What a decoder reads: the parts of one asset.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfParts {
    /// What a view along the normal sees.
    pub reference: ReferenceMap,
    /// How that moves with the view.
    pub indirection: IndirectionMap,
    /// Normals for the light form.
    pub normal: NormalMap,
    /// Reflectances for the light form.
    pub diffuse: DiffuseMap,
    /// All views in order, or none where [`FlatBtfDecoder::full`] is not needed.
    pub views: Vec<FlatView>,
}

/// Three of the sampled directions and how much each of them counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewWeights {
    /// Which of the views, or of the lights.
    pub indices: [u32; 3],
    /// Their weights, with a sum of 1. What has a weight of 0 is not looked at.
    pub weights: [f32; 3],
}

/// Parts that fit together, ready for random access.
#[derive(Debug, Clone)]
pub struct FlatBtfDecoder {
    parts: FlatBtfParts,
}

impl FlatBtfDecoder {
    /// Checks that the parts belong together.
    ///
    /// # Errors
    /// Names the part whose size, view or directions are not those of the others.
    pub fn new(parts: FlatBtfParts) -> Result<Self, FormatError> {
        let (reference, size) = (parts.reference.size(), parts.diffuse.size());
        let same = |part: &'static str, found: u32, allowed: u32, of: &str| {
            if found == allowed {
                return Ok(());
            }
            let field = format!("size of the part {part}");
            Err(FormatError::whole(field, found.to_string(), format!("{allowed}, the size of the part {of}")))
        };
        same("indirection", parts.indirection.header().size, reference, "reference")?;
        same("normal", parts.normal.size(), size, "diffuse")?;
        for (k, view) in parts.views.iter().enumerate() {
            let (header, first) = (view.header(), parts.views[0].header());
            same("flat", header.size, size, "diffuse")?;
            if header.view as usize != k || header.views.len() != parts.views.len() {
                let found = format!("view {} of {}", header.view, header.views.len());
                let allowed = format!("view {k} of {}: all views in order", parts.views.len());
                return Err(FormatError::whole("views of the part flat", found, allowed));
            }
            if (&header.views, &header.lights) != (&first.views, &first.lights) {
                let field = format!("directions of view {k}");
                return Err(FormatError::whole(field, "other directions", "those of view 0"));
            }
        }
        Ok(Self { parts })
    }

    /// What it reads.
    pub fn parts(&self) -> &FlatBtfParts {
        &self.parts
    }

    /// The parts again.
    pub fn into_parts(self) -> FlatBtfParts {
        self.parts
    }

    /// How the flat values lie on a GPU; without any light where there are no views.
    pub fn atlas(&self) -> Atlas {
        let lights = self.parts.views.first().map_or(0, |view| view.header().lights.len());
        Atlas::new(self.parts.diffuse.size(), lights as u32)
    }

    /// Equations 2 and 3, `VDIM_v = VDIM_n + d_v δ_v`: the parameters, 0 to below 1, and the height in tiles of what is seen through a point of the reference
    /// plane. `uv` is in tiles, of any size; `view` is a unit vector to the viewer.
    ///
    /// The directions of four view samples are blended and normalised, their distances are blended
    /// linearly. Directions below the horizon are seen from the largest polar angle.
    pub fn indirection(&self, uv: [f32; 2], view: [f32; 3]) -> [f32; 3] {
        let (map, reference) = (&self.parts.indirection, &self.parts.reference);
        let size = map.header().size;
        let texel = uv.map(|c| ((wrap(c) * size as f32) as u32).min(size - 1));
        let position = view_position(map.header(), view);
        let column = block_tap(position[0], map.header().zenith_samples - 1);
        let row = block_tap(position[1], map.header().azimuth_samples);
        let mut blended = [0.0f32; 4];
        for ([k, a], weight) in footprint(column, row) {
            let sample = map.sample(texel, k, a);
            for component in 0..4 {
                blended[component] += weight * sample[component];
            }
        }
        let [x, y, distance, height] = blended;
        let length = (x * x + y * y).sqrt();
        let scale = if length > 0.0 { distance / length } else { 0.0 };
        let [u, v] = reference.parameters()[(texel[1] * size + texel[0]) as usize];
        [wrap(u + scale * x), wrap(v + scale * y), height]
    }

    /// Equation 1, `BTF = FBTF(VDIM)`, relative to a white diffuser that faces the light. Views and lights are blended by the
    /// weights, texels bilinearly with period 1.
    ///
    /// # Panics
    /// Without views, or with weights for views or lights that are not there: a mistake of the caller.
    pub fn full(&self, uv: [f32; 2], view: [f32; 3], views: ViewWeights, lights: ViewWeights) -> [f32; 3] {
        let [u, v, _] = self.indirection(uv, view);
        let size = self.parts.diffuse.size();
        let footprint = footprint(periodic_tap(u, size), periodic_tap(v, size));
        let mut value = [0.0f32; 3];
        for (view, view_weight) in views.indices.into_iter().zip(views.weights) {
            if view_weight == 0.0 {
                continue;
            }
            for (light, light_weight) in lights.indices.into_iter().zip(lights.weights) {
                if light_weight == 0.0 {
                    continue;
                }
                let weight = view_weight * light_weight;
                let texels = self.parts.views[view as usize].light(light);
                let sample = filtered(&footprint, size, |at| rgb9e5::decode(texels[at]));
                for channel in 0..3 {
                    value[channel] += weight * sample[channel];
                }
            }
        }
        value
    }

    /// The light form of section 3.5: a diffuse colour lit under a normal map. `light` is a unit vector to the light.
    pub fn light_form(&self, uv: [f32; 2], view: [f32; 3], light: [f32; 3]) -> [f32; 3] {
        let [u, v, _] = self.indirection(uv, view);
        let size = self.parts.diffuse.size();
        let footprint = footprint(periodic_tap(u, size), periodic_tap(v, size));
        let [x, y, z] = filtered(&footprint, size, |at| self.parts.normal.normals()[at]);
        let length = (x * x + y * y + z * z).sqrt();
        let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
        let cosine = (x * light[0] + y * light[1] + z * light[2]) * scale;
        let diffuse = filtered(&footprint, size, |at| rgb9e5::decode(self.parts.diffuse.texels()[at]));
        diffuse.map(|c| c * cosine.max(0.0))
    }
}

/// Where a view is among the samples of a block, polar angle first: what `u` and `v` of section 3.5 and figure 7 address,
/// where a shader leaves the blending to the sampler.
fn view_position(header: &IndirectionHeader, [x, y, z]: [f32; 3]) -> [f32; 2] {
    let polar = polynomial_atan2((x * x + y * y).sqrt(), z).min(header.largest_angle);
    let azimuth = polynomial_atan2(y.abs(), x);
    let azimuth = if y < 0.0 { TAU - azimuth } else { azimuth };
    let column = polar / header.largest_angle * (header.zenith_samples - 1) as f32;
    [column, azimuth / TAU * header.azimuth_samples as f32]
}

/// The samples around a position from 0 to `last`.
fn block_tap(position: f32, last: u32) -> Tap {
    let lower = (position as u32).min(last - 1);
    Tap { samples: [lower, lower + 1], weight: position - lower as f32 }
}

fn filtered(footprint: &[([u32; 2], f32); 4], size: u32, texel: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let mut value = [0.0f32; 3];
    for ([column, row], weight) in footprint {
        let texel = texel(*row as usize * size as usize + *column as usize);
        for channel in 0..3 {
            value[channel] += weight * texel[channel];
        }
    }
    value
}
