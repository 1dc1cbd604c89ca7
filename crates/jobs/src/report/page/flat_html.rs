//! The page of a flat BTF.

use super::flat::FlatPage;
use super::markup::{colour_scale, document, image};
use crate::flatten::words::{errors, facts, remarks};
use crate::flatten::{AssetFile, FlatAsset};
use brdfc_core::words::bytes;
use brdfc_render::flat::FlatPicture;
use maud::{Markup, html};

/// A whole file of HTML. The same page gives the same bytes.
pub fn flat_html(page: &FlatPage) -> String {
    let FlatPage { asset: whole, pictures, .. } = page;
    let asset = &whole.about;
    let content = html! {
        p {
            "A flat BTF: a surface with relief, laid flat. ΔE is the colour difference of look-ups against what the surface \
             shows (CIE L*a*b*; about 1 is just visible)."
        }
        @if let Some(view) = &page.view { p { a href=(view.whole()) { "Turn and light it in a browser" } } }
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
            (row(&pictures.tile))
        }
        section.material {
            h2 { "What texels hold, over the parameters" }
            (row(&pictures.texels))
        }
        section.material {
            h2 { "On surfaces, 4 tiles per unit" }
            (row(&pictures.scenes))
            (colour_scale())
        }
        (images(whole))
    };
    document(&format!("{}: a flat BTF and its errors", asset.name), &content)
}

fn row(pictures: &[FlatPicture]) -> Markup {
    html! {
        div.row.large { @for FlatPicture { caption, panel } in pictures {
            figure { (image(panel, caption)) figcaption { (caption) } }
        } }
    }
}

fn errors_table(asset: &AssetFile) -> Markup {
    let known = errors(asset);
    html! {
        @if known.is_empty() {
            p.soft { "Errors were not measured: that takes direct light and values that can be computed again." }
        } @else {
            div.scroll { table.wraps {
                thead { tr { th { "error" } th { "look-ups" } th { "mean" } th { "95 %" } th { "largest" } } }
                tbody { @for (name, error) in known { tr {
                    td { (name) } td { (error.samples) }
                    @for value in [error.mean, error.p95, error.max] { td { (format!("{value:.2}")) } }
                } } }
            } }
        }
    }
}

/// What is on a GPU.
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
