//! Relightable images for web viewers: the folder that `relight` (CNR-ISTI) writes and the RTI layer of OpenLIME opens,
//! `info.json` and JPEG files `plane_0.jpg`, `plane_1.jpg` and so on, three coefficients in each.
//!
//! Values are sRGB-encoded, `v(l) = B_0(l) + Σ_k c_k B_k(l)`, as `"colorspace": "mrgb"`. The basis is a grid over the
//! octahedral square of the hemisphere, `"type": "bilinear"`: the diamond `|X| + |Y| <= 1` of `l / (|x| + |y| + |z|)`,
//! turned by 45 degrees. Texels are bytes, `c_k = (byte / 255 - bias_k) scale_k`. Numbers of the basis are bytes, too:
//! `B_0 = byte / 255`, `B_k = (byte - 127) / range_k`.
//!
//! Polynomial texture maps are `"type": "ptm"` and `"colorspace": "rgb"`: six files, each with the RGB coefficients of a
//! term, in the order 1, x, y, x², x y, y².

use brdfc_readers::ptm::{Ptm, PtmModel, TERMS, terms};
use serde::{Deserialize, Serialize};

/// Nodes along a side of the grid of the basis.
const RESOLUTION: usize = 32;
/// Coefficients in one image.
const CHANNELS: usize = 3;
/// Coefficients of an image without components, because viewers open no image without planes.
const EMPTY: usize = 9;
/// Middle of the bytes of the basis: 0.
const MIDDLE: f32 = 127.0;
/// The term of a `.ptm` file at each place of the web's order.
const ORDER: [usize; TERMS] = [5, 3, 4, 0, 2, 1];

/// A relightable image as a sum of components in sRGB-encoded values, 0 to 1.
pub struct Components<'a> {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Coefficient of each component, row by row from the top: `c_1` and following.
    pub planes: Vec<Vec<f32>>,
    /// RGB of `B_0`, `B_1` and so on under the light of a unit vector, z >= 0: one more than planes.
    pub basis: &'a dyn Fn([f32; 3]) -> Vec<[f32; 3]>,
    /// Unit vectors to the photographed lights, which viewers show; may be empty.
    pub lights: &'a [[f32; 3]],
}

/// Contents of `info.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WebInfo {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Extension of the planes.
    pub format: String,
    /// Kind of basis.
    pub r#type: WebBasis,
    /// Nodes along a side of the grid of the basis; 0 for polynomials.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub resolution: usize,
    /// Kind of components.
    pub colorspace: WebColours,
    /// Coordinates of the photographed lights.
    pub lights: Vec<f32>,
    /// Coefficients per texel, a multiple of 3.
    pub nplanes: usize,
    /// Quality of the JPEG files, 1 to 100.
    pub quality: u8,
    /// RGB bytes of the nodes, row by row, for each component; empty for polynomials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub basis: Vec<u8>,
    /// Scales of the bytes: one element.
    pub materials: [WebMaterial; 1],
}

/// Functions of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum WebBasis {
    /// Bilinear between nodes of a grid.
    Bilinear,
    /// The polynomial of a polynomial texture map.
    Ptm,
}

/// Colours of components.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WebColours {
    /// A component has a colour for each light.
    Mrgb,
    /// A component belongs to one channel.
    Rgb,
}

/// Scales of bytes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WebMaterial {
    /// Bytes of the basis per unit, for each component; empty for polynomials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub range: Vec<f32>,
    /// Difference between bytes 255 and 0 of each coefficient.
    pub scale: Vec<f32>,
    /// The byte that represents 0, over 255, of each coefficient.
    pub bias: Vec<f32>,
}

/// A relightable image in the layout of web viewers.
#[derive(Debug, Clone, PartialEq)]
pub struct WebImage {
    /// Everything except texels.
    pub info: WebInfo,
    /// RGB of each file, row by row from the top.
    pub planes: Vec<Vec<u8>>,
}

fn is_zero(resolution: &usize) -> bool {
    *resolution == 0
}

/// The light of a node of the grid.
fn light_of_node(column: usize, row: usize, resolution: usize) -> [f32; 3] {
    let at = |k: usize| 2.0 * k as f32 / (resolution - 1) as f32 - 1.0;
    let (x, y) = (0.5 * (at(column) - at(row)), 0.5 * (at(column) + at(row)));
    // At the border, rounding may give less than 0.
    let light = [x, y, (1.0 - x.abs() - y.abs()).max(0.0)];
    let length = light.iter().map(|c| c * c).sum::<f32>().sqrt();
    light.map(|c| c / length)
}

impl WebImage {
    /// Quantises components. `quality` is noted in the description; the caller compresses the planes.
    ///
    /// # Panics
    /// Panics if planes have another size, or if the basis has another number of functions.
    pub fn new(components: &Components<'_>, quality: u8) -> Self {
        let count = components.planes.len();
        let nodes: Vec<Vec<[f32; 3]>> = (0..RESOLUTION * RESOLUTION)
            .map(|node| (components.basis)(light_of_node(node % RESOLUTION, node / RESOLUTION, RESOLUTION)))
            .collect();
        assert!(nodes.iter().all(|node| node.len() == count + 1), "a function of each component");
        let mut web = Self::quantised(components.size, &components.planes, quality);
        web.info.lights = components.lights.as_flattened().to_vec();
        web.info.resolution = RESOLUTION;
        web.info.basis = nodes.iter().flat_map(|node| node[0]).map(|v| (255.0 * v).round() as u8).collect();
        for k in 1..=web.info.nplanes {
            let values = || nodes.iter().flat_map(|node| node.get(k).copied().unwrap_or_default());
            let largest = values().fold(0.0, |most: f32, v| most.max(v.abs()));
            let range = if largest > 0.0 { MIDDLE / largest } else { 1.0 };
            web.info.basis.extend(values().map(|v| (MIDDLE + range * v).round() as u8));
            web.info.materials[0].range.push(range);
        }
        web
    }

    /// Quantises the polynomials of a map.
    pub fn of_map(map: &Ptm, quality: u8) -> Self {
        let plane = |k: usize| -> Vec<f32> {
            let (term, channel) = (ORDER[k / CHANNELS], k % CHANNELS);
            let coefficient = |bytes: [u8; TERMS]| map.coefficients(bytes)[term] / 255.0;
            match map.model() {
                PtmModel::Rgb(pixels) => pixels.iter().map(|bytes| coefficient(bytes[channel]) as f32).collect(),
                PtmModel::Lrgb { luminance, colour } => {
                    let shade = |code: u8| f64::from(code) / 255.0;
                    let pixels = luminance.iter().zip(colour);
                    pixels.map(|(bytes, colour)| (coefficient(*bytes) * shade(colour[channel])) as f32).collect()
                }
            }
        };
        let planes: Vec<Vec<f32>> = (0..CHANNELS * TERMS).map(plane).collect();
        let mut web = Self::quantised(map.size().map(|side| side as usize), &planes, quality);
        (web.info.r#type, web.info.colorspace) = (WebBasis::Ptm, WebColours::Rgb);
        web
    }

    /// Quantised planes, with 0 up to a multiple of three and instead of none, and without a basis.
    fn quantised([width, height]: [usize; 2], coefficients: &[Vec<f32>], quality: u8) -> Self {
        let nplanes = if coefficients.is_empty() { EMPTY } else { coefficients.len().next_multiple_of(CHANNELS) };
        let mut planes = vec![vec![0; CHANNELS * width * height]; nplanes / CHANNELS];
        let mut material = WebMaterial { range: Vec::new(), scale: vec![1.0; nplanes], bias: vec![0.0; nplanes] };
        for (k, coefficients) in coefficients.iter().enumerate() {
            assert_eq!(coefficients.len(), width * height, "planes of one size");
            let (least, most) = coefficients.iter().fold((f32::MAX, f32::MIN), |(a, b), c| (a.min(*c), b.max(*c)));
            let scale = if most > least { most - least } else { 1.0 };
            (material.scale[k], material.bias[k]) = (scale, -least / scale);
            let texels = planes[k / CHANNELS].iter_mut().skip(k % CHANNELS).step_by(CHANNELS);
            texels.zip(coefficients).for_each(|(byte, c)| *byte = (255.0 * (c - least) / scale).round() as u8);
        }
        let info = WebInfo {
            width,
            height,
            format: "jpg".to_owned(),
            r#type: WebBasis::Bilinear,
            resolution: 0,
            colorspace: WebColours::Mrgb,
            lights: Vec::new(),
            nplanes,
            quality,
            basis: Vec::new(),
            materials: [material],
        };
        Self { info, planes }
    }

    /// RGB of each component under a light, `B_0` first: bilinear between the nodes, or the terms of polynomials.
    pub fn weights(&self, light: [f32; 3]) -> Vec<[f32; 3]> {
        if self.info.r#type == WebBasis::Ptm {
            let terms = terms([light[0], light[1]]);
            let of_channel = |term: usize, c: usize| [0, 1, 2].map(|k| if k == c { terms[term] as f32 } else { 0.0 });
            let all = ORDER.into_iter().flat_map(|term| (0..CHANNELS).map(move |c| of_channel(term, c)));
            return std::iter::once([0.0; 3]).chain(all).collect();
        }
        let WebInfo { resolution, nplanes, .. } = self.info;
        let sum: f32 = light.iter().map(|c| c.abs()).sum();
        let at = |v: f32| (0.5 * (v / sum + 1.0) * (resolution - 1) as f32).max(0.0);
        let (x, y) = (at(light[0] + light[1]), at(light[1] - light[0]));
        let [column, row] = [x, y].map(|v| (v as usize).min(resolution - 2));
        let (x, y) = (x - column as f32, y - row as f32);
        let weight = |k: usize, channel: usize| {
            let node = |dx, dy| {
                let node = (k * resolution + row + dy) * resolution + column + dx;
                let byte = f32::from(self.info.basis[CHANNELS * node + channel]);
                if k == 0 { byte / 255.0 } else { (byte - MIDDLE) / self.info.materials[0].range[k - 1] }
            };
            let (top, bottom) = ((1.0 - x) * node(0, 0) + x * node(1, 0), (1.0 - x) * node(0, 1) + x * node(1, 1));
            (1.0 - y) * top + y * bottom
        };
        (0..=nplanes).map(|k| [0, 1, 2].map(|channel| weight(k, channel))).collect()
    }

    /// sRGB-encoded values under a light, row by row from the top. They may exceed 0 to 1.
    pub fn image(&self, light: [f32; 3]) -> Vec<[f32; 3]> {
        let weights = self.weights(light);
        let mut image = vec![weights[0]; self.info.width * self.info.height];
        let material = &self.info.materials[0];
        for (k, weight) in weights[1..].iter().enumerate() {
            let (bias, scale) = (material.bias[k], material.scale[k]);
            let texels = self.planes[k / CHANNELS].iter().skip(k % CHANNELS).step_by(CHANNELS);
            for (pixel, byte) in image.iter_mut().zip(texels) {
                let coefficient = (f32::from(*byte) / 255.0 - bias) * scale;
                pixel.iter_mut().zip(weight).for_each(|(value, w)| *value += w * coefficient);
            }
        }
        image
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ptm::spread_lights;

    /// Known answer: two smooth components, at lights that are no nodes. Another light is the negative control.
    #[test]
    fn components_are_recovered_to_8_bits() {
        let size = [7, 5];
        let planes = vec![
            (0..35).map(|k| 0.3 * (k as f32).sin() - 0.1).collect::<Vec<f32>>(),
            (0..35).map(|k| 0.2 * (0.7 * k as f32).cos() + 0.5).collect(),
        ];
        let basis = |[x, y, z]: [f32; 3]| vec![[0.4 * z; 3], [x, 0.5 * x, 0.2], [0.3 * y, 0.6 * y, 0.1 * y]];
        let lights = spread_lights(30);
        let web = WebImage::new(&Components { size, planes: planes.clone(), basis: &basis, lights: &lights }, 90);
        assert_eq!((web.info.nplanes, web.planes.len(), web.info.basis.len()), (3, 1, 4 * 3 * RESOLUTION * RESOLUTION));
        let largest = |light: [f32; 3], shown: [f32; 3]| {
            let b = basis(light);
            let image = web.image(shown);
            let difference = |pixel: usize, c: usize| {
                let value = b[0][c] + planes[0][pixel] * b[1][c] + planes[1][pixel] * b[2][c];
                (value - image[pixel][c]).abs()
            };
            (0..35).flat_map(|pixel| (0..3).map(move |c| (pixel, c))).map(|(p, c)| difference(p, c)).fold(0.0, f32::max)
        };
        for light in &lights {
            assert!(largest(*light, *light) < 0.02, "{light:?}: {}", largest(*light, *light));
            let [x, y, z] = *light;
            assert!(x.hypot(y) < 0.3 || largest(*light, [-x, -y, z]) > 0.06, "{light:?}");
        }
    }

    /// Both layouts of a map; another light is the negative control.
    #[test]
    fn maps_are_recovered_to_8_bits() {
        let polynomial = [-30.0, -20.0, 10.0, 40.0, -25.0, 140.0];
        let [a, b] = [1.0, 0.6].map(|scale| polynomial.map(|c: f32| scale * c));
        let flat = [0.0, 0.0, 0.0, 0.0, 0.0, 200.0];
        for map in [
            Ptm::from_coefficients_rgb([2, 1], &[[a, b, flat], [b, flat, a]]).unwrap(),
            Ptm::from_coefficients_lrgb([2, 1], &[a, b], &[[255, 128, 64], [10, 200, 250]]).unwrap(),
        ] {
            let web = WebImage::of_map(&map, 90);
            assert_eq!((web.planes.len(), web.info.nplanes), (6, 18));
            for light in [[0.5, 0.3], [-0.6, 0.1]] {
                let largest = |[x, y]: [f32; 2]| {
                    let image = web.image([x, y, (1.0 - x * x - y * y).sqrt()]);
                    let differences = (0..2).flat_map(|pixel| {
                        let expected = map.polynomials(pixel, light).map(|code| code as f32 / 255.0);
                        [0, 1, 2].map(|c| (expected[c] - image[pixel][c]).abs())
                    });
                    differences.fold(0.0, f32::max)
                };
                assert!(largest(light) < 0.01 && largest(light.map(|c| -c)) > 0.05, "{light:?} {}", largest(light));
            }
        }
    }

    #[test]
    fn nodes_have_their_lights() {
        for node in 0..RESOLUTION * RESOLUTION {
            let light = light_of_node(node % RESOLUTION, node / RESOLUTION, RESOLUTION);
            let basis = |at: [f32; 3]| vec![[f32::from(u8::from(at == light)); 3]];
            let web = WebImage::new(&Components { size: [1, 1], planes: Vec::new(), basis: &basis, lights: &[] }, 90);
            assert!((web.weights(light)[0][0] - 1.0).abs() < 1e-3, "{light:?}: {:?}", web.weights(light));
            // There are planes, of zeros.
            assert_eq!((web.info.nplanes, &web.planes), (EMPTY, &vec![vec![0; CHANNELS]; EMPTY / CHANNELS]));
            assert_eq!((web.weights(light).len(), web.image(light)[0]), (EMPTY + 1, web.weights(light)[0]));
        }
    }
}
