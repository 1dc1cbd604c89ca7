//! A page that draws packs: turned, lit and held against each other by whoever opens it.
//!
//! One file of HTML that needs no network. What is bound is as `brdfc_shaders::resources` says it, compressed, so that the page
//! neither parses packs nor unpacks Zstandard; shaders are the decoders of `brdfc-formats` behind `shaders/shade.wgsl`, in
//! WGSL and in GLSL ES 3.00.

mod data;
mod html;
mod item;
mod mesh;
mod open;
mod packed;
mod scenes;
mod script;
mod shaders;

pub use item::{Drawn, ViewItem};
pub use open::{ViewOptions, open_items};
pub use shaders::PageShader;

use crate::error::Error;
use data::{PageData, PageItem, Programs};
use open::check_bytes;
use std::collections::BTreeMap;

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
/// More textures than a page should hold.
pub fn view_page(items: &[ViewItem]) -> Result<ViewPage, Error> {
    let scenes = scenes::of(items);
    let listed: Vec<PageItem> = items.iter().map(PageItem::new).collect();
    let mut programs = BTreeMap::new();
    for (item, listed) in items.iter().zip(&listed) {
        for exact in if listed.wide { &[false, true][..] } else { &[false] } {
            let shader = PageShader::drawing(item.decoder(), *exact);
            programs.entry(shader.name.clone()).or_insert_with(|| shader.program());
        }
    }
    let mut texels = 0;
    for item in &listed {
        texels += item.texel_bytes();
        check_bytes(&item.name, texels)?;
    }
    let bytes_of_packs: usize = listed.iter().map(PageItem::bytes).sum();
    let programs = Programs { of: programs, show: PageShader::showing().program() }.packed();
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
