//! Viewer pages that draw packs interactively and compare them.
//!
//! A page is one HTML file that needs no network. It holds the compressed resources of `brdfc_shaders::resources`, so it neither
//! parses packs nor decompresses Zstandard. Its shaders are the decoders of `brdfc-formats` followed by `shaders/shade.wgsl`, in
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

/// A page that draws packs in a browser.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ViewPage {
    /// Contents of the HTML file, which needs no other files.
    pub html: String,
    /// Bytes of the file without the data of packs.
    pub bytes_alone: usize,
}

/// Writes a page of these materials. It shows the first on the left and the second, if any, on the right.
///
/// # Errors
/// Returns an error if the textures exceed the limit of a page.
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
