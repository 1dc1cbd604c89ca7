//! What a page shows of a material besides figures: renderings of source and pack, and where both differ.

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
/// What every material is drawn on: as it is.
const SCENES: [(Builtin, bool); 2] = [(Builtin::Sphere, false), (Builtin::Cloth, false)];
/// What anisotropic ones are drawn on besides: turned, so that what lay along the highlight lies across.
const TURNED: (Builtin, bool) = (Builtin::Sphere, true);

/// Renderings of one scene, drawn by the decoder of the CPU.
#[derive(Debug, Clone)]
pub struct Thumbnails {
    /// Which scene.
    pub scene: &'static str,
    /// Whether the tangent is turned by 90 degrees.
    pub turned: bool,
    /// The source, where it is at hand.
    pub source: Option<Panel>,
    /// The pack.
    pub pack: Panel,
    /// ΔE of both, dark 0 to light 10; its mean over surfaces.
    pub difference: Option<(Panel, f64)>,
    /// Share of the surface's pixels that are left out, as the pack is for other directions.
    pub left_out: f64,
}

/// Everything that is made from a pack and its source.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// A ball and a cloth; of anisotropic materials the ball once more, turned.
    pub thumbnails: Vec<Thumbnails>,
    /// Where both differ; absent without the source.
    pub by_angle: Option<ByAngle>,
}

/// Draws and compares, where the pack is for the directions that are asked for: the rest is left out. Both renderings of a scene have the exposure of the source's.
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
