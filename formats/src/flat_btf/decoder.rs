//! CPU decoder of flat BTFs, the reference for shaders. Equations and sections refer to Hadim et al. 2009; FBTF are the
//! views, VDIM is the indirection map.
//!
//! All steps are f32 operations in a fixed order without fused operations. A shader that follows them with manual
//! filtering produces the same bits.

use super::atlas::Atlas;
use super::displacement::{DisplacementMap, SAME_SIDE};
use super::factored::FactoredFlatBtf;
use super::flat_view::FlatView;
use super::indirection::{IndirectionHeader, IndirectionMap};
use super::maps::{DiffuseMap, NormalMap, ReferenceMap};
use super::view_weights::{BlendedDirection, ViewWeights};
use crate::FormatError;
use crate::container::rgb9e5;
use crate::direction::polynomial_atan2;
use crate::tap::{Tap, footprint, periodic_tap, wrap};
use std::f32::consts::TAU;

/// Parts of one asset that a decoder reads.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfParts {
    /// Parameters visible in the view along the normal.
    pub reference: ReferenceMap,
    /// View-dependent displacement of these parameters.
    pub indirection: Indirection,
    /// Normals for the light form.
    pub normal: NormalMap,
    /// Reflectances for the light form.
    pub diffuse: DiffuseMap,
    /// Appearance of texels in each view under each light.
    pub values: FlatValues,
}

/// View-dependent displacement of the surface point visible through the reference plane.
#[derive(Debug, Clone, PartialEq)]
pub enum Indirection {
    /// The part `indirection`: directions, distances and heights.
    Samples(IndirectionMap),
    /// The part `displacement`: less accurate, without heights, at most a sixteenth of the size.
    Compact(DisplacementMap),
}

impl Indirection {
    /// The indirection map, if that is the stored form.
    pub fn samples(&self) -> Option<&IndirectionMap> {
        match self {
            Self::Samples(map) => Some(map),
            Self::Compact(_) => None,
        }
    }

    /// Sizes and views. For displacements, the size is the number of blocks.
    pub fn header(&self) -> &IndirectionHeader {
        match self {
            Self::Samples(map) => map.header(),
            Self::Compact(map) => &map.header().blocks,
        }
    }
}

impl From<DisplacementMap> for Indirection {
    fn from(map: DisplacementMap) -> Self {
        Self::Compact(map)
    }
}

impl From<IndirectionMap> for Indirection {
    fn from(map: IndirectionMap) -> Self {
        Self::Samples(map)
    }
}

/// Appearance of texels in each view under each light.
#[derive(Debug, Clone, PartialEq)]
pub enum FlatValues {
    /// No values: only the light form is available.
    None,
    /// All views in order, at least one.
    Views(Vec<FlatView>),
    /// Factored values: shadows and weights of texels, and components of views and lights.
    Factored(Box<FactoredFlatBtf>),
}

impl FlatValues {
    /// Uncompressed views; empty for other forms.
    pub fn views(&self) -> &[FlatView] {
        match self {
            Self::Views(views) => views,
            Self::None | Self::Factored(_) => &[],
        }
    }

    /// Factored values, if that is the stored form.
    pub fn factored(&self) -> Option<&FactoredFlatBtf> {
        match self {
            Self::Factored(asset) => Some(asset),
            Self::None | Self::Views(_) => None,
        }
    }

    /// Polar angle and azimuth, radians, of all views and of all lights.
    pub fn directions(&self) -> Option<[&[[f32; 2]]; 2]> {
        match self {
            Self::None => None,
            Self::Views(views) => views.first().map(|view| [&view.header().views[..], &view.header().lights]),
            Self::Factored(asset) => Some([&asset.header().views, &asset.header().lights]),
        }
    }

    /// Number of mipmap levels of the texels.
    pub fn levels(&self) -> u32 {
        self.factored().map_or(1, |asset| asset.header().levels)
    }
}

/// Matching parts, ready for random access.
#[derive(Debug, Clone, PartialEq)]
pub struct FlatBtfDecoder {
    parts: FlatBtfParts,
}

impl FlatBtfDecoder {
    /// Creates a decoder after checking that the parts match.
    ///
    /// # Errors
    /// Returns an error that names the part whose size, view or directions differ from the others.
    pub fn new(parts: FlatBtfParts) -> Result<Self, FormatError> {
        let (reference, size) = (parts.reference.size(), parts.diffuse.size());
        let same = |part: &'static str, found: u32, allowed: u32, of: &str| {
            if found == allowed {
                return Ok(());
            }
            let field = format!("size of the part {part}");
            Err(FormatError::whole(field, found.to_string(), format!("{allowed}, the size of the part {of}")))
        };
        match &parts.indirection {
            Indirection::Samples(map) => same("indirection", map.header().size, reference, "reference")?,
            Indirection::Compact(map) => {
                let blocks = map.header().blocks.size;
                if !reference.is_multiple_of(blocks) {
                    let allowed = format!("a divisor of {reference}, the size of the part reference");
                    return Err(FormatError::whole("size of the part displacement", blocks.to_string(), allowed));
                }
            }
        }
        same("normal", parts.normal.size(), size, "diffuse")?;
        if let Some(asset) = parts.values.factored() {
            same("weights", asset.header().size, size, "diffuse")?;
        }
        let views = parts.values.views();
        for (k, view) in views.iter().enumerate() {
            let (header, first) = (view.header(), views[0].header());
            same("flat", header.size, size, "diffuse")?;
            if header.view as usize != k || header.views.len() != views.len() {
                let found = format!("view {} of {}", header.view, header.views.len());
                let allowed = format!("view {k} of {}: all views in order", views.len());
                return Err(FormatError::whole("views of the part flat", found, allowed));
            }
            if (&header.views, &header.lights) != (&first.views, &first.lights) {
                let field = format!("directions of view {k}");
                return Err(FormatError::whole(field, "differ from view 0", "equal directions in all views").problem());
            }
        }
        Ok(Self { parts })
    }

    /// Parts of the asset.
    pub fn parts(&self) -> &FlatBtfParts {
        &self.parts
    }

    /// Converts the decoder back to the parts of the asset.
    pub fn into_parts(self) -> FlatBtfParts {
        self.parts
    }

    /// GPU layout of uncompressed views; has no lights if there are none.
    pub fn atlas(&self) -> Atlas {
        let lights = self.parts.values.views().first().map_or(0, |view| view.header().lights.len());
        Atlas::new(self.parts.diffuse.size(), lights as u32)
    }

    /// Equations 2 and 3, `VDIM_v = VDIM_n + d_v δ_v`. Returns the parameters, in [0, 1), and the height in tiles of
    /// the surface point visible through a point of the reference plane. `uv` is in tiles and unbounded; `view` is a
    /// unit vector to the viewer.
    ///
    /// The directions of four view samples are blended and normalised; their distances are blended linearly. Views
    /// below the horizon are clamped to the largest polar angle. Compact displacements are blended in the view's own
    /// frame and have height 0. They and their reference are interpolated between texel centres.
    pub fn indirection(&self, uv: [f32; 2], view: [f32; 3]) -> [f32; 3] {
        let reference = &self.parts.reference;
        let size = reference.size();
        let texel = uv.map(|c| ((wrap(c) * size as f32) as u32).min(size - 1));
        let [u, v] = reference.parameters()[(texel[1] * size + texel[0]) as usize];
        let header = self.parts.indirection.header();
        let position = view_position(header, view);
        let column = block_tap(position[0], header.zenith_samples - 1);
        let samples = footprint(column, block_tap(position[1], header.azimuth_samples));
        match &self.parts.indirection {
            Indirection::Samples(map) => {
                let [x, y, distance, height] = blended(&samples, |k, a| map.sample(texel, k, a));
                let length = (x * x + y * y).sqrt();
                let scale = if length > 0.0 { distance / length } else { 0.0 };
                [wrap(u + scale * x), wrap(v + scale * y), height]
            }
            Indirection::Compact(map) => {
                let [u, v] = self.smooth_reference(uv);
                let scale = map.scale(view);
                let taps = uv.map(|c| periodic_tap(wrap(c), header.size));
                let [along, across] = one_side(
                    taps,
                    |block| map.in_view(block, blended(&samples, |k, a| map.sample(block, k, a))),
                    |difference| map.on_one_side(difference, scale).then_some(difference),
                );
                let length = (view[0] * view[0] + view[1] * view[1]).sqrt();
                let [cosine, sine] = if length > 0.0 { [view[0] / length, view[1] / length] } else { [1.0, 0.0] };
                let [x, y] = [scale * (along * cosine - across * sine), scale * (along * sine + across * cosine)];
                [wrap(u + x), wrap(v + y), 0.0]
            }
        }
    }

    /// Parameters of the view along the normal, interpolated between texel centres on the same side of a silhouette as
    /// the texel that contains `uv`.
    fn smooth_reference(&self, uv: [f32; 2]) -> [f32; 2] {
        let (size, parameters) = (self.parts.reference.size(), self.parts.reference.parameters());
        let apart = |difference: [f32; 2]| {
            let apart = difference.map(|c| c - (c + 0.5).floor());
            (apart[0].abs().max(apart[1].abs()) <= SAME_SIDE / size as f32).then_some(apart)
        };
        one_side(uv.map(|c| periodic_tap(wrap(c), size)), |[i, j]| parameters[(j * size + i) as usize], apart)
    }

    /// Equation 1, `BTF = FBTF(VDIM)`, relative to a white diffuser that faces the light. Views and lights are blended
    /// by weight; texels are filtered bilinearly with period 1.
    ///
    /// # Panics
    /// Panics without uncompressed views, or if weights refer to views or lights that do not exist.
    pub fn full(&self, uv: [f32; 2], view: [f32; 3], views: ViewWeights, lights: ViewWeights) -> [f32; 3] {
        let [u, v, _] = self.indirection(uv, view);
        let (size, stored) = (self.parts.diffuse.size(), self.parts.values.views());
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
                let texels = stored[view as usize].light(light);
                let sample = filtered(&footprint, size, |at| rgb9e5::decode(texels[at]));
                for channel in 0..3 {
                    value[channel] += weight * sample[channel];
                }
            }
        }
        value
    }

    /// Equation 1 for values of any form: [`Self::full`] for uncompressed views, which have only the finest level, or
    /// [`FactoredFlatBtf::value`] at a level of detail, 0 the finest.
    ///
    /// # Panics
    /// Panics without values, or if weights refer to views or lights that do not exist.
    pub fn value(
        &self,
        uv: [f32; 2],
        level_of_detail: f32,
        view: BlendedDirection,
        light: BlendedDirection,
    ) -> [f32; 3] {
        match &self.parts.values {
            FlatValues::Factored(asset) => {
                let [u, v, _] = self.indirection(uv, view.direction);
                asset.value([u, v], level_of_detail, view, light)
            }
            FlatValues::None | FlatValues::Views(_) => self.full(uv, view.direction, view.samples, light.samples),
        }
    }

    /// Light form of section 3.5: a diffuse colour lit with a normal map. `light` is a unit vector to the light.
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

/// Position of a view among the samples of a block, polar angle first: the coordinates `u` and `v` of section 3.5 and
/// figure 7, by which a sampler can blend.
fn view_position(header: &IndirectionHeader, [x, y, z]: [f32; 3]) -> [f32; 2] {
    let polar = polynomial_atan2((x * x + y * y).sqrt(), z).min(header.largest_angle);
    let azimuth = polynomial_atan2(y.abs(), x);
    let azimuth = if y < 0.0 { TAU - azimuth } else { azimuth };
    let column = polar / header.largest_angle * (header.zenith_samples - 1) as f32;
    [column, azimuth / TAU * header.azimuth_samples as f32]
}

/// Sum of weighted samples `(k, a)`, in their order.
fn blended<const N: usize>(samples: &[([u32; 2], f32); 4], sample: impl Fn(u32, u32) -> [f32; N]) -> [f32; N] {
    let mut blended = [0.0f32; N];
    for ([k, a], weight) in samples {
        let sample = sample(*k, *a);
        for component in 0..N {
            blended[component] += weight * sample[component];
        }
    }
    blended
}

/// Interpolates four values on the same side of a silhouette as the nearest. Values on the other side are replaced by
/// the nearest. `apart` returns the difference of two values.
fn one_side(
    [column, row]: [Tap; 2],
    value: impl Fn([u32; 2]) -> [f32; 2],
    apart: impl Fn([f32; 2]) -> Option<[f32; 2]>,
) -> [f32; 2] {
    let around = footprint(column, row).map(|(at, weight)| (value(at), weight));
    let upper = [column, row].map(|tap| usize::from(tap.weight >= 0.5));
    let (here, _) = around[upper[0] + 2 * upper[1]];
    let mut smooth = here;
    for (there, weight) in around {
        if let Some(difference) = apart([there[0] - here[0], there[1] - here[1]]) {
            smooth[0] += weight * difference[0];
            smooth[1] += weight * difference[1];
        }
    }
    smooth
}

/// Samples around a position from 0 to `last`.
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
