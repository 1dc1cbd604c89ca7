//! Table 3: compressed sizes of images of apparent BRDFs.

use brdfc_readers::colour::encode_srgb_byte;
use serde::Serialize;

/// Sizes of images of apparent BRDFs, in bytes.
#[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
pub struct ApparentSizes {
    /// Two texels, as in the paper.
    pub texels: Vec<TexelSizes>,
    /// Means over a regular grid of texels.
    pub mean: TexelSizes,
    /// Number of texels of the means.
    pub samples: usize,
}

/// Sizes for one texel: the image of all views (rows) and lights (columns), 8 bits sRGB.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, schemars::JsonSchema)]
pub struct TexelSizes {
    /// Flat BTF, PNG.
    pub flat_png: f64,
    /// Ordinary BTF, PNG.
    pub btf_png: f64,
    /// Flat BTF, Zstandard of the raw bytes.
    pub flat_zstd: f64,
    /// Ordinary BTF, Zstandard of the raw bytes.
    pub btf_zstd: f64,
}

/// Apparent BRDFs of selected texels, collected image by image.
pub(super) struct Apparent {
    texels: Vec<usize>,
    /// For each view and light, the values at the texels.
    values: Vec<Vec<[f32; 3]>>,
}

impl Apparent {
    pub(super) fn new(texels: Vec<usize>) -> Self {
        Self { texels, values: Vec::new() }
    }

    /// The values of one image at the texels.
    pub(super) fn pick(&self, image: &[[f32; 3]]) -> Vec<[f32; 3]> {
        self.texels.iter().map(|texel| image[*texel]).collect()
    }

    /// Adds the values of one image. Images are added view by view.
    pub(super) fn add(&mut self, values: Vec<[f32; 3]>) {
        self.values.push(values);
    }

    /// Bytes of the image of each texel: PNG and Zstandard.
    pub(super) fn sizes(&self, lights: usize) -> Vec<[f64; 2]> {
        let size = |texel: usize| {
            let bytes: Vec<u8> =
                self.values.iter().flat_map(|image| image[texel].map(|c| encode_srgb_byte(f64::from(c)))).collect();
            [png_bytes(&bytes, lights), zstd_bytes(&bytes)]
        };
        (0..self.texels.len()).map(size).collect()
    }
}

fn png_bytes(rgb: &[u8], width: usize) -> f64 {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width as u32, (rgb.len() / 3 / width) as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_compression(png::Compression::High);
    let mut writer = encoder.write_header().expect("a header of a small image");
    writer.write_image_data(rgb).expect("as many bytes as the header says");
    writer.finish().expect("memory can be written to");
    file.len() as f64
}

fn zstd_bytes(bytes: &[u8]) -> f64 {
    zstd::bulk::compress(bytes, 19).expect("compression into memory does not fail").len() as f64
}

/// Pairs sizes of flat and ordinary images.
pub(super) fn summary(flat: &[[f64; 2]], btf: &[[f64; 2]], chosen: usize) -> ApparentSizes {
    let of =
        |k: usize| TexelSizes { flat_png: flat[k][0], btf_png: btf[k][0], flat_zstd: flat[k][1], btf_zstd: btf[k][1] };
    let rest: Vec<TexelSizes> = (chosen..flat.len()).map(of).collect();
    let mean = |field: fn(&TexelSizes) -> f64| rest.iter().map(field).sum::<f64>() / rest.len() as f64;
    ApparentSizes {
        texels: (0..chosen).map(of).collect(),
        mean: TexelSizes {
            flat_png: mean(|s| s.flat_png),
            btf_png: mean(|s| s.btf_png),
            flat_zstd: mean(|s| s.flat_zstd),
            btf_zstd: mean(|s| s.btf_zstd),
        },
        samples: rest.len(),
    }
}
