//! A page that draws packs: turned, lit and held against each other by whoever opens it.
//!
//! One file of HTML that needs no network. What is bound is as `brdfc_shaders::resources` says it, compressed, so that the page
//! neither parses packs nor unpacks Zstandard; shaders are the decoders of `brdfc-formats` behind `shaders/shade.wgsl`, in
//! WGSL and in GLSL ES 3.00.

mod data;
mod error;
mod html;
mod item;
mod mesh;
mod open;
mod packed;
mod scenes;
mod script;
mod source_table;

pub use error::ViewError;
pub use item::{Drawn, ViewItem};
pub use open::{ViewOptions, open_items};

use brdfc_shaders::{Decoder, Program, program};
use data::{PageData, PageItem, Programs};
use error::check_bytes;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// A page, and what of it is not the packs' own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewPage {
    /// The file.
    pub html: String,
    /// Bytes of it that are no pack's.
    pub bytes_alone: usize,
}

/// The page of these materials, the first of them on the left, the second one, if there is one, on the right.
///
/// # Errors
/// More textures than a page should hold; a shader that does not go into a language, which is a fault of this program.
pub fn view_page(items: &[ViewItem]) -> Result<ViewPage, ViewError> {
    let scenes = scenes::of(items);
    let listed: Vec<PageItem> = items.iter().map(PageItem::new).collect();
    let mut programs = BTreeMap::new();
    for (item, listed) in items.iter().zip(&listed) {
        for exact in if listed.is_wide() { &[false, true][..] } else { &[false] } {
            let name =
                if *exact { format!("{}, exact", item.decoder().name()) } else { item.decoder().name().to_owned() };
            if let Entry::Vacant(entry) = programs.entry(name) {
                entry.insert(drawing(item.decoder(), *exact)?);
            }
        }
    }
    let mut texels = 0;
    for item in &listed {
        texels += item.texel_bytes();
        check_bytes(item.name(), texels)?;
    }
    let bytes_of_packs: usize = listed.iter().map(PageItem::bytes).sum();
    let programs = Programs { of: programs, show: showing()? }.packed();
    let data = PageData { programs, scenes, items: listed };
    let html = html::html(&title(items), &data);
    let bytes_alone = html.len() - bytes_of_packs;
    Ok(ViewPage { html, bytes_alone })
}

fn title(items: &[ViewItem]) -> String {
    match items {
        [one] => one.name.clone(),
        [first, second] => format!("{} and {}", first.name, second.name),
        many => format!("{} materials", many.len()),
    }
}

/// What draws a kind of pack; `exact`: the shader filters wavelets. Each has one way in it: drivers compile, and some run, both sides
/// of a branch.
fn drawing(decoder: Decoder, exact: bool) -> Result<Program, ViewError> {
    let filtered = |name| {
        format!(
            "fn filtered(wi: vec3<f32>, wo: vec3<f32>, level: f32) -> vec3<f32> {{ return {name}(wi, wo, level); }}\n"
        )
    };
    let of_kind = match decoder {
        Decoder::Table => include_str!("shaders/table.wgsl").to_owned(),
        Decoder::Wavelet => {
            filtered(if exact { "wavelet_brdf_exact" } else { "wavelet_brdf" }) + include_str!("shaders/wavelet.wgsl")
        }
        Decoder::FlatBtf => include_str!("shaders/flat_btf.wgsl").to_owned(),
        Decoder::Pwt => include_str!("shaders/pwt.wgsl").to_owned(),
        Decoder::Bandwidth | Decoder::Importance => unreachable!("no item has it"),
    };
    let (frame, corner) = (brdfc_render::shading_point::SHADING_POINT_WGSL, brdfc_render::camera::CORNER_WGSL);
    let source = [&decoder.wgsl(), &of_kind, frame, corner, include_str!("shaders/shade.wgsl")].join("\n");
    program(&source, "project", "shade").map_err(ViewError::Shader)
}

/// What shows what was drawn.
fn showing() -> Result<Program, ViewError> {
    let colours = brdfc_render::picture::RAMP.map(|rgb| {
        let [r, g, b] = rgb.map(|code| code / 255.0);
        format!("vec3<f32>({r:.6}, {g:.6}, {b:.6})")
    });
    let ramp = format!(
        "const FULL_SCALE: f32 = {:?};\nconst RAMP: array<vec3<f32>, {}> = array<vec3<f32>, {}>({});\n",
        brdfc_render::picture::DELTA_E_FULL_SCALE,
        colours.len(),
        colours.len(),
        colours.join(", ")
    );
    program(&(ramp + include_str!("shaders/show.wgsl")), "cover", "show").map_err(ViewError::Shader)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaders_of_all_kinds_go_into_both_languages() {
        let kinds = [Decoder::Table, Decoder::Wavelet, Decoder::FlatBtf, Decoder::Pwt].map(|decoder| (decoder, false));
        for (decoder, exact) in kinds.into_iter().chain([(Decoder::Wavelet, true)]) {
            let made = drawing(decoder, exact).unwrap();
            assert!(made.textures.iter().all(|texture| texture.group == 1) && !made.textures.is_empty());
            assert!(made.blocks.iter().any(|block| block.group == 0));
        }
        assert_eq!(showing().unwrap().textures.len(), 2);
    }
}
