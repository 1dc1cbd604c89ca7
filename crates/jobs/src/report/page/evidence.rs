//! What a page shows of a material besides figures: pictures of source and pack, and where both differ.

use brdfc_formats::BrdfPack;
use brdfc_metrics::by_angle::{ByAngle, by_angle};
use brdfc_metrics::image::{LinearImage, auto_exposure, compare_images};
use brdfc_metrics::sampling::PairSet;
use brdfc_render::picture::{Panel, difference_panel, to_panel};
use brdfc_render::scene::Frame;
use brdfc_render::scenes::Builtin;
use brdfc_render::shade::{SourceReflectance, shade};
use brdfc_render::trace::trace;
use brdfc_source::Source;
use brdfc_source::pack::opened;

/// Pixels of a thumbnail, per side.
pub const SIDE: usize = 96;
const FRAME: Frame = Frame { width: SIDE, height: SIDE, samples: 1 };
const SCENES: [Builtin; 2] = [Builtin::Sphere, Builtin::Cloth];

/// Pictures of one scene, drawn by the decoder of the CPU.
#[derive(Debug, Clone)]
pub struct Thumbnails {
    /// Which scene.
    pub scene: &'static str,
    /// The source, where it is at hand.
    pub source: Option<Panel>,
    /// The pack.
    pub pack: Panel,
    /// ΔE of both, dark 0 to light 10; its mean over surfaces.
    pub difference: Option<(Panel, f64)>,
}

/// Everything that is made from a pack and its source.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// A ball and a cloth.
    pub thumbnails: Vec<Thumbnails>,
    /// Where both differ; absent without the source.
    pub by_angle: Option<ByAngle>,
}

/// Draws and compares. Both pictures of a scene have the exposure of the source's.
pub fn evidence(pack: &BrdfPack, source: Option<&dyn Source>) -> Evidence {
    let decoded = opened(pack, None).source;
    let draw = |source: &dyn Source, builtin: Builtin| -> LinearImage {
        let scene = builtin.scene();
        let reflectance = SourceReflectance(source);
        let materials = vec![&reflectance as _; scene.parts.len()];
        shade(&scene, FRAME, &trace(&scene, FRAME), &materials)
    };
    let thumbnails = SCENES.into_iter().map(|builtin| {
        let pack = draw(decoded.as_ref(), builtin);
        let source = source.map(|source| draw(source, builtin));
        let exposure = auto_exposure(source.as_ref().unwrap_or(&pack));
        let panel = |image: &LinearImage| to_panel(image, exposure);
        let difference = source.as_ref().map(|source| {
            (difference_panel(&pack, source, exposure), compare_images(&pack, source, exposure).delta_e.mean)
        });
        Thumbnails { scene: builtin.name(), source: source.as_ref().map(panel), pack: panel(&pack), difference }
    });
    let thumbnails = thumbnails.collect();
    let by_angle = source.map(|source| by_angle(source, decoded.as_ref(), &PairSet::comparison()));
    Evidence { thumbnails, by_angle }
}
