//! Renderings of a material's source and pack, and the directions at which both differ.

use brdfc_core::PackSource;
use brdfc_core::Source;
use brdfc_formats::BrdfPack;
use brdfc_metrics::by_angle::{ByAngle, by_angle};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_metrics::sampling::PairSet;
use brdfc_render::rendering::{Panel, difference_panel, to_panel};
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{Reflectance, SourceReflectance, Turned, shade};
use brdfc_render::trace::trace;
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
    /// Share of the surface's pixels that are left out, as the pack does not cover their directions.
    pub left_out: f64,
}

/// Renderings and errors of a pack and its source.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// A ball and a cloth; for anisotropic materials also the ball with the tangent turned.
    pub thumbnails: Vec<Thumbnails>,
    /// Error by angle; absent without the source.
    pub by_angle: Option<ByAngle>,
}

/// Draws and compares a pack and its source, and leaves out directions that the pack does not cover. Both renderings of a scene
/// have the exposure of the source's rendering.
pub fn evidence(pack: &BrdfPack, source: Option<&dyn Source>) -> Evidence {
    let decoded = PackSource::new(&**pack, None);
    let draw = |source: &dyn Source, (builtin, turned): (Builtin, bool)| -> (LinearImage, f64) {
        let scene = builtin.scene();
        let reflectance = SourceReflectance(source);
        let turned = turned.then_some(Turned(&reflectance));
        let reflectance: &dyn Reflectance = turned.as_ref().map_or(&reflectance, |turned| turned);
        let materials = vec![reflectance; scene.parts.len()];
        let hits = trace(&scene, FRAME);
        let outside = outside(&scene, FRAME, &hits, &vec![pack.directions(); scene.parts.len()]);
        let image = without(shade(&scene, FRAME, &hits, &materials), &outside);
        (image, share_left_out(&hits, FRAME, &outside))
    };
    let isotropic = source.unwrap_or(&decoded).symmetry().isotropic;
    let scenes = SCENES.into_iter().chain((!isotropic).then_some(TURNED));
    let thumbnails = scenes.map(|scene| {
        let (pack, left_out) = draw(&decoded, scene);
        let source = source.map(|source| draw(source, scene).0);
        let exposure = auto_exposure(source.as_ref().unwrap_or(&pack));
        let panel = |image: &LinearImage| to_panel(image, exposure);
        let difference = source.as_ref().map(|source| {
            (difference_panel(&pack, source, exposure), compare_images(&pack, source, exposure).delta_e.mean)
        });
        let (name, turned) = (scene.0.name(), scene.1);
        let (source, pack) = (source.as_ref().map(panel), panel(&pack));
        Thumbnails { scene: name, turned, source, pack, difference, left_out }
    });
    let thumbnails = thumbnails.collect();
    let by_angle = source.map(|source| by_angle(source, &decoded, &PairSet::within(pack.directions())));
    Evidence { thumbnails, by_angle }
}
