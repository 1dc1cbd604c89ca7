//! Table 3: compressed sizes of images of apparent BRDFs.

use brdfc_readers::colour::encode_srgb_byte;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
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
    /// Flat BTF, JPEG of the best quality.
    pub flat_jpeg: f64,
    /// Ordinary BTF, JPEG of the best quality.
    pub btf_jpeg: f64,
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

    /// The values of the texel with this number, view by view.
    pub(super) fn values(&self, number: usize) -> impl Iterator<Item = [f32; 3]> + '_ {
        self.values.iter().map(move |image| image[number])
    }

    /// The texel with this number.
    pub(super) fn texel(&self, number: usize) -> usize {
        self.texels[number]
    }

    /// Bytes of the image of each texel: PNG, JPEG and Zstandard.
    pub(super) fn sizes(&self, lights: usize) -> Vec<[f64; 3]> {
        let size = |texel: usize| {
            let bytes: Vec<u8> =
                self.values(texel).flat_map(|value| value.map(|c| encode_srgb_byte(f64::from(c)))).collect();
            [png_bytes(&bytes, lights), jpeg_bytes(&bytes, lights), zstd_bytes(&bytes)]
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

/// At the best quality, as in the paper.
fn jpeg_bytes(rgb: &[u8], width: usize) -> f64 {
    let mut file = Vec::new();
    let size = [width, rgb.len() / 3 / width].map(|side| side as u32);
    JpegEncoder::new_with_quality(&mut file, 100)
        .encode(rgb, size[0], size[1], ExtendedColorType::Rgb8)
        .expect("a small image fits into memory");
    file.len() as f64
}

fn zstd_bytes(bytes: &[u8]) -> f64 {
    zstd::bulk::compress(bytes, 19).expect("compression into memory does not fail").len() as f64
}

/// Pairs sizes of flat and ordinary images.
pub(super) fn summary(flat: &[[f64; 3]], btf: &[[f64; 3]], chosen: usize) -> ApparentSizes {
    let pair = |[png, jpeg, zstd]: [f64; 3], [btf_png, btf_jpeg, btf_zstd]: [f64; 3]| TexelSizes {
        flat_png: png,
        btf_png,
        flat_jpeg: jpeg,
        btf_jpeg,
        flat_zstd: zstd,
        btf_zstd,
    };
    let mean =
        |sizes: &[[f64; 3]]| [0, 1, 2].map(|k| sizes.iter().map(|size| size[k]).sum::<f64>() / sizes.len() as f64);
    let [flat_rest, btf_rest] = [flat, btf].map(|sizes| &sizes[chosen..]);
    ApparentSizes {
        texels: (0..chosen).map(|k| pair(flat[k], btf[k])).collect(),
        mean: pair(mean(flat_rest), mean(btf_rest)),
        samples: flat_rest.len(),
    }
}
