//! Draws `docs/packs.png` and `docs/spheres.png`: the demo's materials and a sharp one on lit spheres, from the source and
//! from packs.
//!
//! `cargo run --release --example spheres`
//!
//! In the first image, columns are materials; rows are the source, the pack that `brdfc encode` makes without options, and the wavelet
//! pack of `--codec wavelet`, 4:1. Their costs are printed. In the second image, rows are materials; columns are the source, then
//! wavelet packs with the paper's ranking of slices, at 4:1, 16:1 and 32:1 with 8 bits. The camera is orthographic and looks along
//! -z. One point light shines on each sphere; the colour of a pixel is equation 1 of Claustres et al. 2007,
//! `f_r I cos θi / |x - x_light|²`.

use brdfc::encode::encoders::wavelet::recipe::{Recipe, Target};
use brdfc_core::PackSource;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, dot, normalize};
use brdfc_jobs::encode::PackRecipe;
use brdfc_jobs::encode::{EncodedPack, encode};
use brdfc_jobs::scene::manifest::Manifest;
use brdfc_jobs::scene::plan::plan;
use brdfc_source::open::open;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{Rgb, RgbImage};
use rayon::prelude::*;
use std::error::Error;
use std::path::Path;

/// Pixels of the square around a sphere.
const TILE: usize = 160;
/// Radius of a sphere in pixels.
const RADIUS: f64 = 74.0;
/// Samples per pixel and axis.
const SAMPLES: usize = 3;
/// Position of the light relative to the sphere's centre, in radii.
const LIGHT: Vector = [-2.5, 3.0, 4.0];
/// Linear value of a white matte surface that faces the light, as far away as the sphere's centre; 1 is the maximum of the
/// image.
const EXPOSURE: f64 = 1.5;
/// Linear value of the background.
const BACKGROUND: f64 = 0.12;
/// A lobe narrower than a few cells of the 32 x 32 grid.
const SHARP: &str = "synth:ggx?kd=0.05,0.2,0.08&f0=0.05&alpha=0.12";
const RATIOS: [f64; 3] = [4.0, 16.0, 32.0];

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let demo = root.join("testdata/demo");
    let manifest = Manifest::parse(&std::fs::read_to_string(demo.join("scene.toml"))?)?;
    let mut rows: Vec<(String, String)> =
        plan(&manifest, &demo)?.jobs.into_iter().map(|job| (job.name, job.input.to_string())).collect();
    rows.push(("sharp".to_owned(), SHARP.to_owned()));

    let (count, tile) = (rows.len() as u32, TILE as u32);
    let mut packs = RgbImage::new(tile * count, tile * 3);
    let mut ratios = RgbImage::new(tile * (1 + RATIOS.len() as u32), tile * count);
    for (row, (name, address)) in rows.iter().enumerate() {
        let source = open(address, None)?.source;
        draw(&mut packs, [row, 0], source.as_ref());
        draw(&mut ratios, [0, row], source.as_ref());
        let by_default = PackRecipe::default();
        // The result of '--codec wavelet', and below the ranking of the paper.
        for (line, recipe) in (1..).zip([by_default, PackRecipe::Wavelet(Recipe::visible())]) {
            let made = encode(source.as_ref(), &recipe, &())?;
            println!("{name}, {}: {}", made.codec.variant(), cost(&made));
            draw(&mut packs, [row, line], &PackSource::new(&*made.pack, None));
        }
        for (column, ratio) in (1..).zip(RATIOS) {
            let paper = PackRecipe::Wavelet(Recipe { target: Target::Ratio(ratio), ..Recipe::default() });
            let made = encode(source.as_ref(), &paper.without_measuring(), &())?;
            draw(&mut ratios, [column, row], &PackSource::new(&*made.pack, None));
        }
    }
    write(&packs, &root.join("docs/packs.png"))?;
    write(&ratios, &root.join("docs/spheres.png"))
}

/// Formats bytes, fetches and visible error.
fn cost(made: &EncodedPack) -> String {
    let rendering = &made.off_grid.rendering.delta_e;
    let (bytes, fetches) = (made.pack.gpu_bytes(), made.pack.fetches());
    format!("{bytes} bytes, {fetches} fetches, ΔE {:.2}, 95 %: {:.2}", rendering.mean, rendering.p95)
}

fn write(rendering: &RgbImage, path: &Path) -> Result<(), Box<dyn Error>> {
    let mut bytes = Vec::new();
    rendering.write_with_encoder(PngEncoder::new_with_quality(
        &mut bytes,
        CompressionType::Best,
        FilterType::Adaptive,
    ))?;
    Ok(std::fs::write(path, bytes)?)
}

/// Draws one sphere into the tile at `[column, row]`.
fn draw(rendering: &mut RgbImage, [column, row]: [usize; 2], material: &dyn Source) {
    let pixels: Vec<[u8; 3]> = (0..TILE * TILE)
        .into_par_iter()
        .map(|pixel| {
            let mut sum = [0.0; 3];
            for sample in 0..SAMPLES * SAMPLES {
                let at = |index: usize, sub: usize| index as f64 + (sub as f64 + 0.5) / SAMPLES as f64;
                let x = (at(pixel % TILE, sample % SAMPLES) - 0.5 * TILE as f64) / RADIUS;
                let y = (0.5 * TILE as f64 - at(pixel / TILE, sample / SAMPLES)) / RADIUS;
                // Clipped per sample, so that the edges of highlights are smooth too.
                let value = shade(material, x, y).map(|v| v.clamp(0.0, 1.0));
                (0..3).for_each(|channel| sum[channel] += value[channel]);
            }
            sum.map(|s| srgb(s / (SAMPLES * SAMPLES) as f64))
        })
        .collect();
    for (pixel, colour) in pixels.into_iter().enumerate() {
        rendering.put_pixel((column * TILE + pixel % TILE) as u32, (row * TILE + pixel / TILE) as u32, Rgb(colour));
    }
}

/// Linear colour at a point of the image plane, in radii from the sphere's centre.
fn shade(material: &dyn Source, x: f64, y: f64) -> Vector {
    let height = 1.0 - x * x - y * y;
    if height <= 0.0 {
        return [BACKGROUND; 3];
    }
    let normal = [x, y, height.sqrt()];
    // The tangent follows circles of latitude: the poles of the frame are at the top and bottom of the outline.
    let tangent = normalize([normal[2], 0.0, -normal[0]]);
    let bitangent = cross(normal, tangent);
    let to_light = [LIGHT[0] - x, LIGHT[1] - y, LIGHT[2] - normal[2]];
    let light = normalize(to_light);
    let local = |v: Vector| [dot(v, tangent), dot(v, bitangent), dot(v, normal)];
    let pair = DirectionPair::new(local(light), local([0.0, 0.0, 1.0]));
    let cosine = pair.incoming[2].max(0.0);
    let intensity = EXPOSURE * std::f64::consts::PI * dot(LIGHT, LIGHT);
    material.eval(pair, &mut Tally::default()).map(|f| f * intensity * cosine / dot(to_light, to_light))
}

fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Linear value to sRGB, 8 bits.
fn srgb(value: f64) -> u8 {
    let encoded = if value <= 0.003_130_8 { 12.92 * value } else { 1.055 * value.powf(1.0 / 2.4) - 0.055 };
    (255.0 * encoded).round() as u8
}
