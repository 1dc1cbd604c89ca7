//! Viewer pages that draw packs interactively and compare them.
//!
//! A page is one HTML file that needs no network. It holds the compressed resources of `brdfc_shaders::resources`, so it neither
//! parses packs nor decompresses Zstandard. Its shaders are the decoders of `brdfc-formats` followed by `shaders/shade.wgsl`, in
//! WGSL and in GLSL ES 3.00. Point lights light BRDFs and surfaces; an environment, which all share, lights lobes.

mod data;
mod environment;
mod html;
mod item;
mod mesh;
mod open;
mod packed;
mod photographs;
mod scenes;
mod script;
mod shaders;

pub use environment::ViewEnvironment;
pub use item::{Drawn, ViewItem};
pub use open::{ViewOptions, open_items};
pub use photographs::{Photograph, Photographs};
pub use shaders::PageShader;

use crate::error::Error;
use data::{PageData, PageEnvironment, PageItem, Programs};
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

/// Writes a page of these materials. It shows the first on the left and the second, if any, on the right. The environment is
/// left out if no material needs it.
///
/// # Errors
/// Returns an error if the textures exceed the limit of a page, or if a material needs an environment and there is none.
pub fn view_page(items: &[ViewItem], environment: Option<&ViewEnvironment>) -> Result<ViewPage, Error> {
    let lit = items.iter().find(|item| item.needs_environment());
    let environment = match (lit, environment) {
        (None, _) => None,
        (Some(_), Some(environment)) => Some(environment),
        (Some(item), None) => {
            return Err(Error::usage(format!(
                "{}: found no environment, expected one that lights the lobes",
                item.name
            )));
        }
    };
    let scenes = scenes::of(items);
    let listed: Vec<PageItem> = items.iter().map(PageItem::new).collect();
    let mut programs = BTreeMap::new();
    for (item, listed) in items.iter().zip(&listed) {
        for exact in if listed.wide { &[false, true][..] } else { &[false] } {
            let shader = PageShader::of_item(item, *exact);
            programs.entry(shader.name.clone()).or_insert_with(|| shader.program());
        }
    }
    let mut texels = 0;
    if let Some(environment) = environment {
        let shader = PageShader::behind();
        programs.insert(shader.name.clone(), shader.program());
        texels += environment.pack.gpu_bytes();
        check_bytes(&environment.name, texels)?;
    }
    let environment = environment.map(PageEnvironment::new);
    for item in &listed {
        texels += item.texel_bytes();
        check_bytes(&item.name, texels)?;
    }
    let bytes_of_packs: usize =
        listed.iter().map(PageItem::bytes).chain(environment.iter().map(PageEnvironment::bytes)).sum();
    let programs = Programs { of: programs, show: PageShader::showing().program() }.packed();
    let data = PageData { programs, scenes, environment, items: listed };
    let html = html::html(&title(items), &data);
    let bytes_alone = html.len() - bytes_of_packs;
    Ok(ViewPage { html, bytes_alone })
}

fn title(items: &[ViewItem]) -> String {
    // Photographs and normals accompany a pack.
    let packs: Vec<&ViewItem> = items.iter().filter(|item| item.photographs().is_none()).collect();
    match &packs[..] {
        [] => items.first().map_or_else(String::new, |item| item.name.clone()),
        [one] => one.name.clone(),
        [first, second] => format!("{} and {}", first.name, second.name),
        many => format!("{} materials", many.len()),
    }
}
