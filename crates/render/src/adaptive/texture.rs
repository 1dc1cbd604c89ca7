//! Textures that modulate materials: their colours, and their bandwidth along a surface (section 2.4 of Bagher et al.
//! 2012).
//!
//! Uses only f32 additions, multiplications, divisions and square roots where points are looked up, in a fixed order, so
//! that a shader can compute the same values.

use crate::curvature::step_squared;
use crate::gbuffer::GBuffer;
use crate::mipmaps::Mipmaps;
use brdfc_core::LUMINANCE_WEIGHTS;
use brdfc_formats::bandwidth::BandwidthMap;

/// A texture on a part of a scene. It repeats.
#[derive(Debug, Clone, Copy)]
pub struct PartTexture<'a> {
    /// Factors on `f_r`, linear RGB.
    pub colours: &'a Mipmaps,
    /// Bandwidth of one repetition, with its size in metres.
    pub bandwidth: &'a BandwidthMap,
    /// Repetitions per unit of u and v, whole numbers of at least 1.
    pub repeats: [f32; 2],
}

/// A texture at a point of a G-buffer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TexturePoint {
    /// Factor on `f_r`, linear RGB.
    pub colour: [f32; 3],
    /// `t`, bandwidth along the surface, cycles per metre.
    pub bandwidth: f32,
}

impl TexturePoint {
    /// A point without a texture.
    pub(super) const PLAIN: Self = Self { colour: [1.0; 3], bandwidth: 0.0 };

    /// Luminance of the colour.
    pub fn luminance(&self) -> f32 {
        let ([r, g, b], weights) = (self.colour, LUMINANCE_WEIGHTS.map(|weight| weight as f32));
        weights[0] * r + weights[1] * g + weights[2] * b
    }

    /// A radiance without texture, times the colour.
    pub fn tinted(&self, radiance: [f32; 3]) -> [f32; 3] {
        [0, 1, 2].map(|k| radiance[k] * self.colour[k])
    }
}

/// Size of a texture on the surface around a point.
struct Footprint {
    /// Maximum of the metres of the texture per metre of surface, over the steps to the neighbours: 1 if a repetition has
    /// the texture's size there. 1 without neighbours.
    stretch: f32,
    /// Maximum number of texels to a neighbour in the row or column, squared.
    texels_squared: f32,
}

impl PartTexture<'_> {
    /// Width and height of a repetition in metres; 1 for other kinds of maps.
    pub fn metres(&self) -> [f32; 2] {
        self.bandwidth.metres().unwrap_or([1.0; 2])
    }

    /// The texture at a point that shows its part.
    pub(super) fn point(&self, buffer: &GBuffer, point: usize) -> TexturePoint {
        let uv = buffer.uv[point];
        // Coordinates go up, and rows of images down.
        let place = [uv[0] * self.repeats[0], -(uv[1] * self.repeats[1])];
        let footprint = self.footprint(buffer, point);
        TexturePoint {
            colour: self.colours.colour(place, footprint.texels_squared),
            bandwidth: self.bandwidth.texture(place) * footprint.stretch,
        }
    }

    fn footprint(&self, buffer: &GBuffer, point: usize) -> Footprint {
        let (metres, size) = (self.metres(), self.colours.size().map(|side| side as f32));
        let (x, y) = (point % buffer.width, point / buffer.width);
        let (mut stretch_squared, mut texels_squared) = (-1.0f32, 0.0f32);
        for row in y.saturating_sub(1)..(y + 2).min(buffer.height) {
            for column in x.saturating_sub(1)..(x + 2).min(buffer.width) {
                let neighbour = row * buffer.width + column;
                if neighbour == point || buffer.part[neighbour] != buffer.part[point] {
                    continue;
                }
                let length_squared = step_squared(buffer, point, neighbour);
                if length_squared < 0.0 {
                    continue;
                }
                let step = self.step(buffer.uv[point], buffer.uv[neighbour]);
                let across = [0, 1].map(|k| step[k] * metres[k]);
                stretch_squared = stretch_squared.max(squared(across) / length_squared);
                if row == y || column == x {
                    texels_squared = texels_squared.max(squared([0, 1].map(|k| step[k] * size[k])));
                }
            }
        }
        let stretch = if stretch_squared < 0.0 { 1.0 } else { stretch_squared.sqrt() };
        Footprint { stretch, texels_squared }
    }

    /// Repetitions between two points. Coordinates of closed surfaces jump by whole numbers at their seam.
    fn step(&self, from: [f32; 2], to: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|k| {
            let step = to[k] - from[k];
            (step - (step + 0.5).floor()) * self.repeats[k]
        })
    }
}

fn squared([x, y]: [f32; 2]) -> f32 {
    x * x + y * y
}
