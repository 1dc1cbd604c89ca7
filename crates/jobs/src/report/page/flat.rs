//! The page of a flat BTF: its report and renderings of its contents.

use super::markup::{document, image};
use super::view_link::ViewLink;
use crate::error::Error;
use crate::flatten::words::{errors, facts, remarks};
use crate::flatten::{AssetFile, FlatAsset, open_asset};
use brdfc_core::words::bytes;
use brdfc_render::flat::{FlatMaterial, FlatRendering, FlatRenderings, flat_renderings};
use brdfc_source::{Input, InputError};
use maud::{Markup, html};

/// Tiles per unit of uv on the scenes: few enough to show the relief.
const REPEAT: u32 = 4;

/// Contents of a page about a flat BTF.
#[derive(Debug)]
pub struct FlatPage {
    /// The report that `brdfc flatten` wrote.
    pub asset: FlatAsset,
    /// Renderings of its contents.
    pub renderings: FlatRenderings,
    /// The viewer page to link to.
    pub view: Option<ViewLink>,
}

impl FlatPage {
    /// Reads a flat BTF and draws it.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is invalid.
    pub fn open(input: &Input) -> Result<Self, Error> {
        let (file, asset) = open_asset(input)?;
        let wrong = |error| InputError::Format { name: input.to_string(), error };
        let material = FlatMaterial::new(file.decoder, REPEAT).map_err(wrong)?;
        let renderings = flat_renderings(&material);
        Ok(Self { asset, renderings, view: None })
    }
}

/// Writes the page as HTML. Output is deterministic.
pub fn flat_html(page: &FlatPage) -> String {
    let FlatPage { asset: whole, renderings, .. } = page;
    let asset = &whole.about;
    let content = html! {
        p {
            "A flat BTF: a surface with relief, laid flat. ΔE is the colour difference from the surface or from its \
             images (CIE L*a*b*; about 1 is just visible)."
        }
        @if let Some(view) = &page.view { p { a href=(view.whole()) { "Open in the viewer" } } }
        div.scroll { table.wraps {
            tbody { @for (name, value) in facts(whole) { tr { td { (name) } td.left.words { (value) } } } }
            @if !asset.materials.is_empty() { tbody { tr {
                td { "materials" } td.left.words { (asset.materials.join(", ")) }
            } } }
        } }
        @for line in remarks(asset) { p.soft { (line) } }
        (errors_table(asset))
        section.material {
            h2 { "One tile of the plane" }
            (row(&renderings.tile))
        }
        section.material {
            h2 { "Texel values, over the parameters" }
            (row(&renderings.texels))
        }
        section.material {
            h2 { "On surfaces, 4 tiles per unit" }
            (row(&renderings.scenes))
        }
        (images(whole))
    };
    document(&format!("{}: a flat BTF and its errors", asset.name), &content)
}

fn row(renderings: &[FlatRendering]) -> Markup {
    html! {
        div.row.large { @for FlatRendering { caption, panel } in renderings {
            figure { (image(panel, caption)) figcaption { (caption) } }
        } }
    }
}

fn errors_table(asset: &AssetFile) -> Markup {
    let known = errors(asset);
    html! {
        @if known.is_empty() {
            p.soft { "Errors were not measured: this requires direct light and values that can be recomputed." }
        } @else {
            div.scroll { table.wraps {
                thead { tr { th { "error" } th { "points" } th { "mean" } th { "95 %" } th { "largest" } } }
                tbody { @for (name, samples, figures) in known { tr {
                    td { (name) } td { (samples) }
                    @for value in figures { td { (format!("{value:.2}")) } }
                } } }
            } }
        }
    }
}

/// Table of the textures.
fn images(asset: &FlatAsset) -> Markup {
    let line = |name: &str, gpu: u64| html! { tr { td { (name) } td { (bytes(gpu)) } } };
    html! {
        h2 { "Textures" }
        div.scroll { table.wraps {
            thead { tr { th { "texture" } th { "on GPU" } } }
            tbody {
                @for (name, gpu) in &asset.images { (line(name, *gpu)) }
                (line("all", asset.gpu_bytes))
            }
        } }
    }
}
