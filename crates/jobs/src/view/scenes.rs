//! Scenes of a page.

use super::data::PageScene;
use super::item::{ItemScene, ViewItem};
use super::mesh::PackedMesh;
use brdfc_render::pwt::image_scene;

/// All scenes of the materials, without duplicates.
pub(super) fn of(items: &[ViewItem]) -> Vec<PageScene> {
    let mut all: Vec<ItemScene> = Vec::new();
    for scene in items.iter().flat_map(ViewItem::scenes) {
        if !all.contains(&scene) {
            all.push(scene);
        }
    }
    all.into_iter().map(page_scene).collect()
}

fn page_scene(of: ItemScene) -> PageScene {
    let scene = match of {
        ItemScene::Builtin(builtin) => builtin.scene(),
        ItemScene::Image(size) => image_scene(size.map(|side| side as usize), [1; 2]),
    };
    let [part] = &scene.parts[..] else { unreachable!("scenes of pages have one part") };
    let mesh = PackedMesh::new(&part.mesh);
    let half_sides = match of {
        ItemScene::Builtin(_) => None,
        ItemScene::Image([width, height]) => {
            let longer = f64::from(width.max(height));
            Some([f64::from(width) / longer, f64::from(height) / longer])
        }
    };
    let brdfc_render::scene::Scene { camera, lights, background, .. } = scene;
    PageScene { name: of.name(), camera, lights, background, mesh, half_sides }
}
