//! Elements of the viewer page.

use super::data::PageData;
use super::script::script;
use crate::report::page::markup::file;
use maud::{Markup, PreEscaped, html};

const STYLE: &str = "
* { box-sizing: border-box; }
html, body { height: 100%; margin: 0; }
body { display: grid; grid-template-columns: minmax(0, 1fr) 19rem; background: var(--paper); color: var(--ink);
  font: 15px/1.45 system-ui, sans-serif; }
#stage { position: relative; min-height: 0; overflow: hidden; }
canvas { position: absolute; inset: 0; width: 100%; height: 100%; display: block; touch-action: none; cursor: grab; }
canvas:active { cursor: grabbing; }
#stage input[type=range] { position: absolute; left: 0; right: 0; bottom: 0.6rem; width: 100%; margin: 0; }
#border { position: absolute; top: 0; bottom: 0; left: var(--split); width: 1px; background: #fff8; pointer-events: none; }
#wrong { position: absolute; inset: 0; padding: 2rem; background: var(--paper); color: var(--bad); overflow-wrap: anywhere; }
form { padding: 0.9rem 1rem; overflow-y: auto; border-left: 1px solid var(--faint); }
h1 { font-size: 1.05rem; margin: 0 0 0.7rem; overflow-wrap: anywhere; }
label, fieldset { display: block; margin: 0 0 0.6rem; } fieldset { border: 0; padding: 0; }
select, form input[type=range] { width: 100%; font: inherit; }
fieldset label { display: inline-block; margin: 0 0.7rem 0 0; } fieldset label.whole { display: block; margin: 0; }
p { margin: 0 0 0.6rem; } .soft { color: var(--soft); font-size: 0.85rem; }
#facts p { font-size: 0.85rem; overflow-wrap: anywhere; }
#whole, #here { font-variant-numeric: tabular-nums; min-height: 1.45em; }
.scale { display: inline-block; width: 9rem; height: 0.7rem; border: 1px solid var(--faint);
  background: linear-gradient(90deg, var(--ramp)); }
button { font: inherit; padding: 0.2rem 0.7rem; }
#disc { display: block; width: 12rem; max-width: 100%; margin: 0 auto 0.4rem; touch-action: none; cursor: crosshair; }
.rim { fill: #1c1c1c; stroke: var(--soft); stroke-width: 0.01; } .dot { fill: #999; } .dot.used { fill: #6cf; }
.handle { fill: #fd6; fill-opacity: 0.55; stroke: #fff; stroke-width: 0.012; } .handle.chosen { fill-opacity: 1; }
[hidden] { display: none !important; }
@media (max-width: 46rem) { body { grid-template-columns: 1fr; grid-template-rows: minmax(18rem, 60vh) auto; height: auto; }
  form { border-left: 0; } }
body.embedded { grid-template: 1fr / 1fr; height: 100%; } .embedded form { display: none; }
";

/// Colours of differences, as a CSS variable.
fn ramp() -> String {
    let colours = brdfc_render::rendering::RAMP.map(|[r, g, b]| format!("rgb({r} {g} {b})"));
    format!(":root {{ --ramp: {}; }}", colours.join(", "))
}

/// The page.
pub(super) fn html(title: &str, data: &PageData) -> String {
    // Escaped, so that the text neither ends the element nor starts a comment.
    let text = serde_json::to_string(data).expect("data is plain").replace('<', "\\u003c");
    let body = html! {
        div #stage {
            canvas #canvas tabindex="0" aria-label="The material on a surface. Arrow keys turn it; with Shift they move the light." {}
            input type="range" name="split" form="controls" min="0" max="1" step="0.002" aria-label="Position of the divider";
            div #border {}
            p #wrong hidden {}
        }
        (controls(title, data))
        script type="application/json" #data { (PreEscaped(text)) }
        script type="module" { (PreEscaped(script())) }
    };
    file(title, &(ramp() + STYLE), &body)
}

fn controls(title: &str, data: &PageData) -> Markup {
    let several = data.items.len() > 1;
    html! {
        form #controls autocomplete="off" {
            h1 { (title) }
            label #surfaces {
                "Surface"
                select name="scene" { @for scene in &data.scenes { option value=(scene.name) { (scene.name) } } }
            }
            label hidden[!several] { "Left" (choices(data, false)) }
            label hidden[!several] { "Right" (choices(data, true)) }
            fieldset #modes {
                @for (value, what) in [("split", "split"), ("one", "left only"), ("difference", "ΔE")] {
                    label { input type="radio" name="mode" value=(value); " " (what) }
                }
            }
            p #scale .soft { "ΔE 0 " span.scale {} " " (brdfc_render::rendering::DELTA_E_FULL_SCALE) }
            p #whole { "Drawing …" }
            p #here .soft {}
            (lights())
            div #levels {
                label { input type="checkbox" name="follows"; " level of detail from the distance, as in an engine" }
                label { input type="range" name="coarser" min="0" step="0.1" aria-label="Levels coarser than the finest"; span #coarser-shown .soft {} }
            }
            fieldset #environment hidden {
                label.whole {
                    "Rotation of the environment"
                    input type="range" name="rotation" min="-180" max="180" step="1";
                }
                label { input type="checkbox" name="behind" checked; " environment as background" }
            }
            label { "Exposure" input type="range" name="stops" min="-4" max="4" step="0.1"; }
            fieldset #drags {
                "Dragging moves the "
                label { input type="radio" name="drags" value="view" checked; " surface" }
                label { input type="radio" name="drags" value="light"; " light" }
            }
            p {
                button type="button" #again { "Reset" } " "
                button type="button" #save { "Save as PNG" }
            }
            p #turning .soft {
                "Drag with Shift or the right button to move the light. Zoom with the wheel, two fingers, + or -. Arrow keys turn \
                 the surface; with Shift they move the light."
                @if data.environment.is_some() {
                    " The light of lobes is their environment, which turns about the vertical."
                }
            }
            p #images .soft hidden {
                "Drag, or use the arrow keys, to move the light; with Shift or the right button, the image. Keys 1 to 3 select a \
                 light. A click on a dot of the disc selects the light of that photograph. Zoom with the wheel, two fingers, + or -."
            }
            div #facts {}
            @if several { p.soft { "ΔE is the CIE76 difference of the displayed colours; about 1 is just visible." } }
            p.soft { "Drawn with " span #api { "…" } }
        }
    }
}

/// Lights of images.
fn lights() -> Markup {
    html! {
        fieldset #lights hidden {
            svg #disc viewBox="-1.1 -1.1 2.2 2.2" role="img" aria-label="Directions of the lights, seen from above" {}
            p #light .soft {}
            label { "Brightness of the light" input #brightness type="range" min="0" max="2" step="0.01"; }
            button type="button" #add { "Add a light" } " "
            button type="button" #remove { "Remove" }
        }
    }
}

fn choices(data: &PageData, or_none: bool) -> Markup {
    html! {
        select name=(if or_none { "right" } else { "left" }) {
            @if or_none { option value="-1" { "none" } }
            @for (number, item) in data.items.iter().enumerate() { option value=(number) { (item.name) } }
        }
    }
}
