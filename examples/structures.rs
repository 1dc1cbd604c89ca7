//! Draws meso-structures, 2 x 2 tiles from 45 degrees and from above, lit by the sun with shadows.
//!
//! `cargo run --release --example structures -- FOLDER [STRUCTURE...]`
//!
//! A structure is an address without its prefix, such as `knit?count=8`. By default, all are drawn with default parameters.
//! Files are `FOLDER/0.png`, `FOLDER/1.png`, and so on.

use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Tally};
use brdfc_flat_btf::mesh::{MAX_MATERIALS, PeriodicMesh};
use brdfc_flat_btf::structures::{STRUCTURES, Structure};
use brdfc_formats::direction::{DirectionPair, Vector, add_scaled, cross, dot, from_polar, normalize};
use image::{Rgb, RgbImage};
use std::error::Error;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::path::Path;

/// Pixels along a view.
const SIZE: usize = 768;
/// Width of a view, in tiles.
const WIDTH: f64 = 2.0;

/// An orthographic view of a square of the plane: its frame, and the nearest surface at each pixel.
struct View {
    axes: [Vector; 3],
    /// Depth (towards the viewer), triangle and barycentric coordinates.
    nearest: Vec<(f64, usize, [f64; 3])>,
    size: usize,
}

impl View {
    fn new(mesh: &PeriodicMesh, towards: Vector, size: usize) -> Self {
        let right = normalize(cross([0.0, 0.0, 1.0], towards));
        let axes = [right, cross(towards, right), towards];
        let mut view = Self { axes, nearest: vec![(f64::NEG_INFINITY, 0, [0.0; 3]); size * size], size };
        let corners: Vec<[Vector; 3]> = (0..mesh.triangles.len()).map(|k| mesh.corners(k)).collect();
        // Enough tiles around the middle to fill slanted views.
        for tile in (-4..4).flat_map(|y| (-3..3).map(move |x| [f64::from(x), f64::from(y), 0.0])) {
            for (index, triangle) in corners.iter().enumerate() {
                view.draw(index, triangle.map(|corner| view.project(add_scaled(corner, 1.0, tile))));
            }
        }
        view
    }

    /// Pixel coordinates and depth.
    fn project(&self, point: Vector) -> Vector {
        let scale = self.size as f64 / WIDTH;
        let [x, y, depth] = self.axes.map(|axis| dot(axis, point));
        [(x + 0.5 * WIDTH) * scale, (0.5 * WIDTH - y) * scale, depth]
    }

    fn draw(&mut self, index: usize, [a, b, c]: [Vector; 3]) {
        let area = |p: Vector, q: Vector, r: [f64; 2]| (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        let whole = area(a, b, [c[0], c[1]]);
        let range = |k: usize| {
            let (low, high) = (a[k].min(b[k]).min(c[k]), a[k].max(b[k]).max(c[k]));
            (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).ceil().max(0.0) as usize).min(self.size)
        };
        for y in range(1) {
            for x in range(0) {
                let at = [x as f64 + 0.5, y as f64 + 0.5];
                let shares = [area(b, c, at) / whole, area(c, a, at) / whole, area(a, b, at) / whole];
                let depth = shares[0] * a[2] + shares[1] * b[2] + shares[2] * c[2];
                let nearest = &mut self.nearest[y * self.size + x];
                if shares.iter().all(|share| *share >= 0.0) && depth > nearest.0 {
                    *nearest = (depth, index, shares);
                }
            }
        }
    }
}

fn rendering(mesh: &PeriodicMesh, materials: &[Box<dyn Source>], towards: Vector) -> RgbImage {
    let light = from_polar(0.9, 2.7);
    let (view, sun) = (View::new(mesh, towards, SIZE), View::new(mesh, light, 2 * SIZE));
    RgbImage::from_fn(SIZE as u32, SIZE as u32, |x, y| {
        let (depth, index, shares) = view.nearest[y as usize * SIZE + x as usize];
        if depth == f64::NEG_INFINITY {
            return Rgb([40; 3]);
        }
        let (mut point, mut normal, mut tint, mut weights) = ([0.0; 3], [0.0; 3], [0.0; 3], [0.0; MAX_MATERIALS]);
        for (corner, share) in mesh.triangles[index].into_iter().zip(shares) {
            let vertex = corner.vertex as usize;
            point = add_scaled(point, share, mesh.position(corner));
            normal = add_scaled(normal, share, mesh.normals[vertex]);
            tint = add_scaled(tint, share, mesh.materials[vertex].tint.map(f64::from));
            let of_vertex = mesh.materials[vertex].weights;
            (0..MAX_MATERIALS).for_each(|k| weights[k] += share * f64::from(of_vertex[k]));
        }
        let normal = normalize(normal);
        let tangent = normalize(cross([0.0, 1.0, 0.0], normal));
        let frame = [tangent, cross(normal, tangent), normal];
        let reflected = |from: Vector, to: Vector| {
            let pair = DirectionPair::new(frame.map(|axis| dot(axis, from)), frame.map(|axis| dot(axis, to)));
            let mut sum = [0.0; 3];
            for (material, weight) in materials.iter().zip(weights) {
                sum = add_scaled(sum, weight, material.eval(pair, &mut Tally::default()));
            }
            sum
        };
        // There is no highlight at 60 degrees from the mirror direction.
        let diffuse = || reflected(normal, add_scaled(frame[2].map(|n| 0.5 * n), 0.75f64.sqrt(), tangent));
        // The same place in the tile that the sun's map shows.
        let lit = (-2..3).flat_map(|ty| (-2..3).map(move |tx| [f64::from(tx), f64::from(ty), 0.0])).any(|tile| {
            let [px, py, depth] = sun.project(add_scaled(point, 1.0, tile));
            let inside = |p: f64| (0.0..2.0 * SIZE as f64).contains(&p);
            inside(px) && inside(py) && depth > sun.nearest[py as usize * sun.size + px as usize].0 - 0.006
        });
        let direct = reflected(light, towards).map(|f| if lit { 3.4 * f * dot(normal, light).max(0.0) } else { 0.0 });
        // A little ambient light, as if the surface were diffuse.
        let around = diffuse().map(|f| 0.55 * f * (0.6 + 0.4 * normal[2]).max(0.0));
        Rgb(std::array::from_fn(|c| {
            let value = tint[c] * (direct[c] + around[c]);
            (255.0 * value.clamp(0.0, 1.0).powf(1.0 / 2.2)) as u8
        }))
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let folder = arguments.first().ok_or("give a folder for the renderings")?;
    let all: Vec<String> = STRUCTURES.iter().map(|info| info.name.to_owned()).collect();
    let structures = if arguments.len() > 1 { &arguments[1..] } else { &all };
    for (k, text) in structures.iter().enumerate() {
        let structure = Structure::parse(text)?;
        let mesh = structure.mesh();
        let addresses = structure.default_materials().iter();
        let materials = addresses.map(|address| parse_synth(address)).collect::<Result<Vec<_>, _>>()?;
        let mut sheet = RgbImage::new(2 * SIZE as u32, SIZE as u32);
        // Slightly oblique, so that the view has an upright direction: -y is below.
        for (column, [theta, phi]) in [[FRAC_PI_4, -1.2], [1e-6, -FRAC_PI_2]].into_iter().enumerate() {
            let view = rendering(&mesh, &materials, from_polar(theta, phi));
            image::imageops::replace(&mut sheet, &view, (column * SIZE) as i64, 0);
        }
        let path = Path::new(folder).join(format!("{k}.png"));
        sheet.save(&path)?;
        println!("{}: {}, heights {:.3?}", path.display(), structure.canonical(), mesh.height_range());
    }
    Ok(())
}
