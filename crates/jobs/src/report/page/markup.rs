//! Shared parts of pages.

use super::style::{PALETTE, SCRIPT, STYLE};
use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use brdfc_render::rendering::{DELTA_E_FULL_SCALE, Panel, rgb_png};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// Writes a complete HTML file with light and dark colours.
pub(crate) fn file(title: &str, style: &str, body: &Markup) -> String {
    let document = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(PALETTE)) (PreEscaped(style)) }
            }
            body { (body) }
        }
    };
    document.into_string()
}

/// Writes a report page.
pub(super) fn document(title: &str, content: &Markup) -> String {
    file(title, STYLE, &html! { h1 { (title) } (content) script { (PreEscaped(SCRIPT)) } })
}

/// Embeds an image as PNG.
pub(super) fn image(panel: &Panel, description: &str) -> Markup {
    html! { img src={ "data:image/png;base64," (STANDARD.encode(rgb_png(panel))) } alt=(description); }
}

/// Colour scale of difference images.
pub(super) fn colour_scale() -> Markup {
    html! {
        p.soft { "Differences: ΔE 0 " span.scale style="display:inline-block" {} " " (DELTA_E_FULL_SCALE) }
    }
}
