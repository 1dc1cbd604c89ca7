//! Renderings of the surface, and of the methods next to it.

use super::methods::{Method, Stored};
use super::rows::{AngleRow, MethodRow, ObjectRow, RenderingRow};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::surface::Appearance;
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images, delta_e_map, luminance};
use brdfc_render::flat::reference;
use brdfc_render::scene::{Camera, Frame, Scene};
use brdfc_render::scenes::Builtin;
use std::time::Instant;

/// Polar angles of views, degrees.
const POLAR_ANGLES: [f64; 6] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0];
/// Azimuths of views, degrees. Not those of sampled directions.
pub(super) const AZIMUTHS: [f64; 3] = [34.0, 155.0, 275.0];
/// Polar angle of the views in motion, and by how much they turn, degrees.
pub(super) const MOTION: [f64; 2] = [45.0, 0.5];
/// Change of ΔE that is seen as a jump.
const JUMP: f32 = 5.0;
/// Vertical angle of view and distance of the camera for these views: 4 x 4 tiles of the plane are 2 x 2 units.
const FIELD_OF_VIEW: f64 = 20.0;
pub(super) const DISTANCE: f64 = 3.0;
/// Curved objects.
const OBJECTS: [Builtin; 3] = [Builtin::Vase, Builtin::Bottle, Builtin::Teapot];

/// Side of the grid of samples of a pixel.
pub(super) const SAMPLES: usize = 2;
/// Tiles per side of the plane from far away, and the side of its grid of samples of a pixel.
pub(super) const FAR_TILES: u32 = 16;
pub(super) const FAR_SAMPLES: usize = 8;
/// Tiles per side of the plane from farther away, on a share of the pixels per row.
const FARTHER_TILES: u32 = 32;
const FARTHER_SHARE: f64 = 0.5;

/// The surface itself.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    pub(super) model: &'a MesoModel,
    pub(super) appearance: &'a Appearance,
}

impl Surface<'_> {
    /// Draws the surface with another side of the grid of samples of a pixel.
    pub(super) fn drawn(&self, scene: Scene, frame: Frame, repeat: u32, samples: usize) -> Rendering {
        let surface = reference(&scene, Frame { samples, ..frame }, self.model, self.appearance, repeat);
        let exposure = auto_exposure(&surface);
        Rendering { scene, frame, repeat, surface, exposure }
    }
}

/// A view of the surface.
pub(super) struct Rendering {
    scene: Scene,
    frame: Frame,
    repeat: u32,
    pub(super) surface: LinearImage,
    pub(super) exposure: f64,
}

/// Views of the surface.
pub(super) struct Renderings {
    plane: Rendering,
    /// For each polar angle, one of each azimuth.
    angles: Vec<Vec<Rendering>>,
    /// Pairs of views before and after a turn.
    motion: Vec<[Rendering; 2]>,
    far: Rendering,
    farther: Rendering,
    objects: Vec<(&'static str, Rendering)>,
}

impl Renderings {
    /// Number of calls of `done` by [`Self::new`].
    pub(super) const COUNT: usize = 3 + POLAR_ANGLES.len() + AZIMUTHS.len() + OBJECTS.len();

    /// Draws the surface. Calls `done` after each view or group of views.
    pub(super) fn new(surface: Surface<'_>, pixels: usize, done: &dyn Fn()) -> Self {
        let frame = |share: f64| {
            let width = ((pixels as f64 * share) as usize).max(16);
            Frame { width, height: width * 3 / 4, samples: SAMPLES }
        };
        let draw = |scene, share, tiles, truth| counted(surface.drawn(scene, frame(share), tiles, truth), done);
        let tiles = Builtin::Plane.tiles();
        let turned =
            |polar: f64, azimuth: f64| surface.drawn(plane_from(polar, azimuth, DISTANCE), frame(0.4), tiles, SAMPLES);
        let plane = draw(Builtin::Plane.scene(), 1.0, tiles, SAMPLES);
        let at = |polar: &f64| counted(AZIMUTHS.map(|azimuth| turned(*polar, azimuth)).into(), done);
        let angles = POLAR_ANGLES.iter().map(at).collect();
        let [polar, turn] = MOTION;
        let moving = |azimuth: &f64| counted([0.0, turn].map(|by| turned(polar, azimuth + by)), done);
        let motion = AZIMUTHS.iter().map(moving).collect();
        let far = draw(Builtin::Plane.scene(), 1.0, FAR_TILES, FAR_SAMPLES);
        let farther = draw(Builtin::Plane.scene(), FARTHER_SHARE, FARTHER_TILES, FAR_SAMPLES);
        let object = |builtin: Builtin| (builtin.name(), draw(builtin.scene(), 0.5, builtin.tiles(), SAMPLES));
        Self { plane, angles, motion, far, farther, objects: OBJECTS.map(object).into() }
    }

    /// Errors of a method.
    pub(super) fn row(&self, method: &Method<'_>) -> MethodRow {
        let started = Instant::now();
        let plane = self.plane.drawn(method);
        let samples = self.plane.frame.width * self.plane.frame.height * self.plane.frame.samples_per_pixel();
        let nanoseconds = started.elapsed().as_nanos() as f64 * rayon::current_num_threads() as f64 / samples as f64;
        let mean = |renderings: &Vec<Rendering>| {
            renderings.iter().map(|rendering| rendering.row(&rendering.drawn(method)).delta_e).sum::<f64>()
                / renderings.len() as f64
        };
        let angles = POLAR_ANGLES.iter().zip(&self.angles);
        MethodRow {
            method: method.name,
            bytes: method.stored.as_ref().map(|stored| stored.bytes),
            fetches: method.stored.as_ref().map(|stored| stored.fetches),
            mean_fetches: method.stored.as_ref().map(|stored| self.plane.mean_fetches(stored)),
            plane: self.plane.row(&plane),
            nanoseconds: method.stored.as_ref().map(|_| nanoseconds),
            angles: angles
                .map(|(polar, renderings)| AngleRow { polar_angle: *polar, delta_e: mean(renderings) })
                .collect(),
            jumps: self.jumps(method),
            far: self.far.row(&self.far.drawn(method)),
            farther: self.farther.row(&self.farther.drawn(method)),
            objects: self
                .objects
                .iter()
                .map(|(scene, rendering)| ObjectRow { scene, rendering: rendering.row(&rendering.drawn(method)) })
                .collect(),
        }
    }

    fn jumps(&self, method: &Method<'_>) -> f64 {
        let drawn = |pair: &[Rendering; 2]| changes(pair, &pair.each_ref().map(|rendering| rendering.drawn(method)));
        share_of_jumps(&self.motion.iter().flat_map(drawn).collect::<Vec<_>>())
    }
}

/// Change of the ΔE of each pixel from the first to the second view. `images` are a method's.
pub(super) fn changes(pair: &[Rendering; 2], images: &[LinearImage; 2]) -> Vec<f32> {
    let [before, after] = [0, 1].map(|k| delta_e_map(&images[k], &pair[k].surface, pair[0].exposure));
    before.iter().zip(&after).map(|(a, b)| (a - b).abs()).collect()
}

/// Share of the pixels whose ΔE jumps.
pub(super) fn share_of_jumps(changes: &[f32]) -> f64 {
    changes.iter().filter(|change| **change > JUMP).count() as f64 / changes.len() as f64
}

impl Rendering {
    /// The same view by a method.
    pub(super) fn drawn(&self, method: &Method<'_>) -> LinearImage {
        (method.draw)(&self.scene, self.frame, self.repeat)
    }

    /// Mean fetches of a method over samples and lights of this view of a plane.
    fn mean_fetches(&self, stored: &Stored<'_>) -> f64 {
        (stored.mean_fetches)(&self.scene, self.frame, self.repeat)
    }

    /// Differences of an image from this view.
    pub(super) fn row(&self, image: &LinearImage) -> RenderingRow {
        let difference = compare_images(image, &self.surface, self.exposure);
        let sum = |image: &LinearImage| image.pixels.iter().map(|pixel| luminance(*pixel)).sum::<f64>();
        RenderingRow {
            delta_e: difference.delta_e.mean,
            p95: difference.delta_e.p95,
            psnr: difference.psnr,
            brightness: sum(image) / sum(&self.surface),
        }
    }
}

pub(super) fn counted<T>(made: T, done: &dyn Fn()) -> T {
    done();
    made
}

/// The plane, seen from angles in degrees around its middle, and from a distance.
pub(super) fn plane_from(polar: f64, azimuth: f64, distance: f64) -> Scene {
    let (polar, azimuth) = (polar.to_radians(), azimuth.to_radians());
    let (x, z) = (azimuth.cos(), azimuth.sin());
    let camera = Camera {
        eye: [polar.sin() * x, polar.cos(), polar.sin() * z].map(|c| distance * c),
        target: [0.0; 3],
        up: [-polar.cos() * x, polar.sin(), -polar.cos() * z],
        field_of_view: FIELD_OF_VIEW,
    };
    Scene { camera, ..Builtin::Plane.scene() }
}
