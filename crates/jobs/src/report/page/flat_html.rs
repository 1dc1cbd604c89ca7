//! The page of a flat BTF.

use super::flat::FlatPage;
use super::markup::{colour_scale, document, image};
use crate::flatten::words::{errors, facts, remarks};
use crate::flatten::{AssetFile, PartFile};
use brdfc_core::words::bytes;
use brdfc_formats::flat_btf::FlatPart;
use brdfc_render::flat::FlatPicture;
use maud::{Markup, html};

/// A whole file of HTML. The same page gives the same bytes.
pub fn flat_html(page: &FlatPage) -> String {
    let FlatPage { asset, pictures, .. } = page;
    let content = html! {
        p {
            "A flat BTF: a surface with relief, laid flat. ΔE is the colour difference of look-ups against what the surface \
             shows (CIE L*a*b*; about 1 is just visible)."
        }
        @if let Some(view) = &page.view { p { a href=(view.whole()) { "Turn and light it in a browser" } } }
        div.scroll { table.wraps {
            tbody { @for (name, value) in facts(asset) { tr { td { (name) } td.left.words { (value) } } } }
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
        (parts(asset))
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

/// The files; views, of which there may be hundreds, together.
fn parts(asset: &AssetFile) -> Markup {
    let is_view = |part: &str| FlatPart::from_name(part) == Some(FlatPart::View);
    let (views, single): (Vec<_>, Vec<_>) = asset.parts.iter().partition(|(part, _)| is_view(part));
    let sum = |bytes: fn(&PartFile) -> u64| views.iter().map(|(_, part)| bytes(part)).sum::<u64>();
    let line = |name: &str, disk: u64, gpu: u64| {
        html! { tr { td { (name) } td { (bytes(disk)) } td { @if gpu == 0 { "-" } @else { (bytes(gpu)) } } } }
    };
    let of_views = match views.as_slice() {
        [] => String::new(),
        [(part, _)] => (*part).clone(),
        [(first, _), .., (last, _)] => format!("{first} to {last}, {} views", views.len()),
    };
    html! {
        h2 { "Parts" }
        div.scroll { table.wraps {
            thead { tr { th { "part" } th { "on disk" } th { "on GPU" } } }
            tbody {
                @for (name, part) in single { (line(name, part.bytes, part.gpu_bytes)) }
                @if !views.is_empty() { (line(&of_views, sum(|part| part.bytes), sum(|part| part.gpu_bytes))) }
                (line("all", asset.bytes(), asset.gpu_bytes()))
            }
        } }
    }
}
