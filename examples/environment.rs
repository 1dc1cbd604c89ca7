//! Draws `docs/environment.png`: eight materials on balls in a room with windows and lamps, by lobes and by the integral over all
//! directions.
//!
//! `cargo run --release --example environment`
//!
//! The first row has the lobes that `brdfc encode --codec lobes` selects without options, the second one the integral. The room is
//! not among the environments of the fit. Look-ups, bytes and errors are printed.

use brdfc_environment::training::TrainingEnvironment;
use brdfc_jobs::environment::prefilter_image;
use brdfc_jobs::lobes::encode_lobes;
use brdfc_lobes::LobesRecipe;
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_render::lobes::{IntegralMaterial, PrefilteredLight, draw_integral, draw_on_cpu};
use brdfc_render::rendering::to_panel;
use brdfc_render::scene::{Camera, Environment, Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_source::open::open;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{Rgb, RgbImage};
use std::error::Error;
use std::path::Path;

/// Pixels of a ball's square.
const FRAME: Frame = Frame { width: 120, height: 120, samples: 2 };
/// Directions of the integral for each pixel.
const DIRECTIONS: usize = 4096;
/// A room, by its number among the environments.
const ROOM: u64 = 207;
/// Pixels of the latitude-longitude image of the room.
const IMAGE: [usize; 2] = [1024, 512];
/// Files are in the folder of the demo.
const MATERIALS: [(&str, &str); 8] = [
    ("matte", "synth:lambert?kd=0.5,0.4,0.3"),
    ("Phong", "synth:lewis"),
    ("blue paint", "blue_paint.brdf"),
    ("red plastic", "red_plastic.binary"),
    ("sharp plastic", "synth:ggx?kd=0.05,0.2,0.08&f0=0.05&alpha=0.12"),
    ("rough copper", "synth:ggx?kd=0&f0=0.9,0.55,0.4&alpha=0.45"),
    ("gold", "synth:ggx?kd=0&f0=1,0.75,0.33&alpha=0.15"),
    ("mirror", "synth:ggx?kd=0&f0=0.9&alpha=0.02"),
];

fn main() -> Result<(), Box<dyn Error>> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let room = TrainingEnvironment::new(ROOM);
    let [width, height] = IMAGE;
    let environment = Environment::of(width, height, |direction| room.radiance(direction).map(|c| c as f32));
    let light = PrefilteredLight::new(prefilter_image(&environment, None, &())?);
    let ball = Builtin::Sphere.scene();
    let camera = Camera { field_of_view: 0.87 * ball.camera.field_of_view, ..ball.camera };
    let scene = Scene { environment, camera, ..ball };

    let mut rows = RgbImage::new((FRAME.width * MATERIALS.len()) as u32, 2 * FRAME.height as u32);
    for (column, (name, address)) in MATERIALS.into_iter().enumerate() {
        let path = root.join("testdata/demo").join(address);
        let is_file = !address.starts_with("synth:");
        let source = if is_file { open(path, None)? } else { open(address, None)? }.source;
        let encoded = encode_lobes(source.as_ref(), &LobesRecipe::default(), &())?;
        let pack = encoded.best().pack.clone();
        let (fetches, bytes) = (pack.fetches(), pack.gpu_bytes());
        let by_lobes = draw_on_cpu(&scene, FRAME, &light, &[Some(&pack)]);
        let material = IntegralMaterial::new(source.as_ref())?;
        let integral = draw_integral(&scene, FRAME, &[Some(&material)], DIRECTIONS).image;
        let exposure = auto_exposure(&integral);
        let difference = compare_images(&by_lobes, &integral, exposure).delta_e;
        println!("{name}: {fetches} look-ups, {bytes} bytes, ΔE {:.2}, 95 %: {:.2}", difference.mean, difference.p95);
        put(&mut rows, [column, 0], &by_lobes, exposure);
        put(&mut rows, [column, 1], &integral, exposure);
    }
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    rows.write_with_encoder(encoder)?;
    Ok(std::fs::write(root.join("docs/environment.png"), bytes)?)
}

/// Copies a rendering into its place.
fn put(rows: &mut RgbImage, [column, row]: [usize; 2], image: &LinearImage, exposure: f64) {
    let panel = to_panel(image, exposure);
    for (at, pixel) in panel.rgb.as_chunks::<3>().0.iter().enumerate() {
        let (x, y) = (at % FRAME.width + column * FRAME.width, at / FRAME.width + row * FRAME.height);
        rows.put_pixel(x as u32, y as u32, Rgb(*pixel));
    }
}
