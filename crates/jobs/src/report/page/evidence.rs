//! Renderings of a material's source and pack, and the directions at which both differ.

use crate::Error;
use crate::environment::Surroundings;
use crate::tabulated::tabulated;
use brdfc_core::PackSource;
use brdfc_core::Source;
use brdfc_formats::BrdfPack;
use brdfc_formats::environment::EnvironmentPack;
use brdfc_formats::lobes::LobesPack;
use brdfc_metrics::by_angle::{ByAngle, by_angle};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_metrics::sampling::PairSet;
use brdfc_render::lobes::{DIRECTIONS, Integral, IntegralMaterial, PrefilteredLight, draw_integral, draw_on_cpu};
use brdfc_render::rendering::{Panel, difference_panel, to_panel};
use brdfc_render::scene::{Frame, Scene};
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{Reflectance, SourceReflectance, Turned, shade};
use brdfc_render::trace::{Hits, trace};
use brdfc_render::within::{outside, share_left_out, without};

/// Pixels of a thumbnail, per side.
pub const SIDE: usize = 96;
const FRAME: Frame = Frame { width: SIDE, height: SIDE, samples: 1 };
/// Scenes of every material, with the tangent as it is.
const SCENES: [(Builtin, bool); 2] = [(Builtin::Sphere, false), (Builtin::Cloth, false)];
/// Additional scene of anisotropic materials, with the tangent turned by 90 degrees.
const TURNED: (Builtin, bool) = (Builtin::Sphere, true);

/// Renderings of one scene, drawn by the CPU decoder.
#[derive(Debug, Clone)]
pub struct Thumbnails {
    /// Name of the scene.
    pub scene: &'static str,
    /// True if the tangent is turned by 90 degrees.
    pub turned: bool,
    /// Rendering of the source; `None` if the source is not available.
    pub source: Option<Panel>,
    /// Rendering of the pack.
    pub pack: Panel,
    /// Rendering of ΔE, from 0 (dark) to 10 (light), and the mean ΔE over surfaces.
    pub difference: Option<(Panel, f64)>,
    /// Mean ΔE that the noise of the source's rendering causes by itself; `None` without noise.
    pub noise: Option<f64>,
    /// Share of the surface's pixels that are left out, as the pack does not cover their directions.
    pub left_out: f64,
}

/// Renderings and errors of a pack and its source.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// A ball and a cloth; for anisotropic materials also the ball with the tangent turned.
    pub thumbnails: Vec<Thumbnails>,
    /// The ball in the environment of the scene, by lobes and by the integral over all directions; absent without lobes.
    pub in_environment: Option<Thumbnails>,
    /// Error by angle; absent without the source.
    pub by_angle: Option<ByAngle>,
}

/// The scenes of thumbnails, with what each pixel shows: the same for all materials.
pub struct ThumbnailScenes(Vec<(Builtin, bool, Scene, Hits)>);

impl ThumbnailScenes {
    /// Builds the scenes and casts their rays.
    pub fn new() -> Self {
        let staged = |(builtin, turned): (Builtin, bool)| {
            let scene = builtin.scene();
            let hits = trace(&scene, FRAME);
            (builtin, turned, scene, hits)
        };
        Self(SCENES.into_iter().chain([TURNED]).map(staged).collect())
    }
}

impl Default for ThumbnailScenes {
    fn default() -> Self {
        Self::new()
    }
}

/// Draws and compares a pack and its source, and leaves out directions that the pack does not cover. Both renderings of a scene
/// have the exposure of the source's rendering. `lit` are lobes of the material, and a ball in the light that they look up;
/// `scenes` the scenes of thumbnails.
///
/// # Errors
/// Returns an error if the lobes of the source cannot be tabulated.
pub fn evidence(
    pack: &BrdfPack,
    source: Option<&dyn Source>,
    lit: Option<(&LobesPack, &LitBall)>,
    ThumbnailScenes(scenes): &ThumbnailScenes,
) -> Result<Evidence, Error> {
    let decoded = PackSource::new(&**pack, None);
    let draw = |source: &dyn Source, turned: bool, scene: &Scene, hits: &Hits| -> (LinearImage, f64) {
        let reflectance = SourceReflectance(source);
        let turned = turned.then_some(Turned(&reflectance));
        let reflectance: &dyn Reflectance = turned.as_ref().map_or(&reflectance, |turned| turned);
        let materials = vec![reflectance; scene.parts.len()];
        let outside = outside(scene, FRAME, hits, &vec![pack.directions(); scene.parts.len()]);
        let image = without(shade(scene, FRAME, hits, &materials), &outside);
        (image, share_left_out(hits, FRAME, &outside))
    };
    let isotropic = source.unwrap_or(&decoded).symmetry().isotropic;
    let scenes = scenes.iter().filter(|(_, turned, ..)| !turned || !isotropic);
    let thumbnails = scenes.map(|(builtin, turned, scene, hits)| {
        let (pack, left_out) = draw(&decoded, *turned, scene, hits);
        let source = source.map(|source| draw(source, *turned, scene, hits).0);
        Thumbnails { turned: *turned, left_out, ..Thumbnails::of(*builtin, &pack, source.as_ref()) }
    });
    let thumbnails = thumbnails.collect();
    let in_environment = lit.map(|(lobes, ball)| ball.thumbnails(lobes, source)).transpose()?;
    let by_angle = source.map(|source| by_angle(source, &decoded, &PairSet::within(pack.directions())));
    Ok(Evidence { thumbnails, in_environment, by_angle })
}

impl Evidence {
    /// Keeps figures only.
    pub(super) fn drop_renderings(&mut self) {
        self.thumbnails.clear();
        let none = || Panel { width: 0, height: 0, rgb: Vec::new() };
        if let Some(lit) = &mut self.in_environment {
            (lit.source, lit.pack) = (None, none());
            lit.difference = lit.difference.take().map(|(_, mean)| (none(), mean));
        }
    }
}

impl Thumbnails {
    /// Compares a rendering with that of the source.
    fn of(builtin: Builtin, pack: &LinearImage, source: Option<&LinearImage>) -> Self {
        let exposure = auto_exposure(source.unwrap_or(pack));
        let panel = |image: &LinearImage| to_panel(image, exposure);
        let difference = source.map(|source| {
            (difference_panel(pack, source, exposure), compare_images(pack, source, exposure).delta_e.mean)
        });
        let (source, pack) = (source.map(panel), panel(pack));
        Self { scene: builtin.name(), turned: false, source, pack, difference, noise: None, left_out: 0.0 }
    }
}

/// A ball in an environment.
pub struct LitBall {
    light: PrefilteredLight,
    scene: Scene,
}

impl LitBall {
    /// Unpacks the environment. The integral is over its finest level.
    pub fn new(environment: EnvironmentPack) -> Self {
        let image = Surroundings::from(&environment).into_image();
        let scene = Scene { environment: image, ..Builtin::Sphere.scene() };
        Self { light: PrefilteredLight::new(environment), scene }
    }

    fn thumbnails(&self, lobes: &LobesPack, source: Option<&dyn Source>) -> Result<Thumbnails, Error> {
        let by_lobes = draw_on_cpu(&self.scene, FRAME, &self.light, &[Some(lobes)]);
        // The integral looks the source up far too often for a scan.
        let table = source.map(|source| tabulated(source, &())).transpose()?.flatten();
        let source = table.as_ref().map(|table| &table.source as &dyn Source).or(source);
        let integral = source.map(|source| -> Result<Integral, Error> {
            let material = IntegralMaterial::new(source).map_err(|error| Error::internal(error.to_string()))?;
            Ok(draw_integral(&self.scene, FRAME, &[Some(&material)], DIRECTIONS))
        });
        let integral = integral.transpose()?;
        let noise = |integral: &Integral| integral.noise(auto_exposure(&integral.image)).delta_e.mean;
        let noise = integral.as_ref().map(noise);
        let image = integral.as_ref().map(|integral| &integral.image);
        Ok(Thumbnails { noise, ..Thumbnails::of(Builtin::Sphere, &by_lobes, image) })
    }
}
