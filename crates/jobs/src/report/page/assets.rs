//! Assets of a page that are no materials: RTI captures, BTFs and environments, each with a rendering of its pack.

use super::markup::image;
use super::parts::{listed_pack, wrong_kind};
use super::view_link::escaped;
use crate::environment::Surroundings;
use crate::error::Error;
use crate::report::build::AssetEntry;
use brdfc_core::words::bytes;
use brdfc_formats::Pack;
use brdfc_formats::environment::EnvironmentPack;
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_metrics::image::LinearImage;
use brdfc_pwt::measure::images_at;
use brdfc_render::rendering::{Panel, to_panel};
use brdfc_render::scene::Environment;
use maud::{Markup, html};
use std::path::Path;
use std::slice;

/// Largest side of a rendering, pixels.
const SIDE: u32 = 320;
/// Light of the rendering of an RTI capture: from the upper left, as people expect it.
const LIGHT: [f32; 3] = [-0.408_248_3, 0.408_248_3, 0.816_496_6];
/// Value of a rendering that is shown as white, as a multiple of the mean.
const WHITE: f64 = 4.0;

/// One asset of a page.
#[derive(Debug)]
pub struct PageAsset {
    /// Its entry in the build report.
    pub entry: AssetEntry,
    /// A rendering of its pack; absent without a pack.
    pub rendering: Option<Panel>,
}

/// Reads the pack of an asset and draws it.
///
/// # Errors
/// Returns an error if the pack cannot be read or differs from the report.
pub(super) fn page_asset(folder: &Path, entry: AssetEntry) -> Result<PageAsset, Error> {
    let Some(listed) = &entry.pack else { return Ok(PageAsset { entry, rendering: None }) };
    let (pack, _) = listed_pack(folder, slice::from_ref(listed), &listed.file)?;
    let rendering = match pack {
        Pack::Pwt(pack) => lit(pack),
        Pack::Environment(pack) => panorama(&pack),
        other => return Err(wrong_kind(&folder.join(&listed.file), other.kind(), entry.kind.pack().summary())),
    };
    Ok(PageAsset { entry, rendering: Some(rendering) })
}

/// A tree, seen along the normal under [`LIGHT`].
fn lit(pack: PwtPack) -> Panel {
    let [width, height] = pack.header().size;
    let levels = pack.header().levels;
    let level = (0..levels).find(|level| width.max(height) >> level <= SIDE).unwrap_or(levels);
    let decoder = PwtDecoder::new(pack);
    let [width, height] = decoder.unpacked(0, level).size();
    panel([width, height], images_at(&decoder, [0.0, 0.0, 1.0], level, &[LIGHT]).remove(0), 1.0)
}

/// An environment as a latitude-longitude image, exposed by its mean.
fn panorama(pack: &EnvironmentPack) -> Panel {
    let Environment { width, height, pixels } = Surroundings::from(pack).into_image();
    let step = width.div_ceil(SIDE as usize).max(1);
    let (columns, rows) = (width / step, height / step);
    // The mean of the pixels of a block.
    let block = |at: usize| {
        let (x, y) = (at % columns * step, at / columns * step);
        let of_block = (0..step * step).map(|k| pixels[(y + k / step) * width + x + k % step]);
        let sum = of_block.fold([0.0f32; 3], |sum, pixel| [0, 1, 2].map(|c| sum[c] + pixel[c]));
        sum.map(|value| value / (step * step) as f32)
    };
    let small: Vec<[f32; 3]> = (0..columns * rows).map(block).collect();
    let mean =
        small.as_flattened().iter().map(|value| f64::from(*value)).sum::<f64>() / (3 * small.len()).max(1) as f64;
    let exposure = if mean > 0.0 { 1.0 / (WHITE * mean) } else { 1.0 };
    panel([columns, rows], small, exposure)
}

fn panel([width, height]: [usize; 2], mut pixels: Vec<[f32; 3]>, exposure: f64) -> Panel {
    pixels.as_flattened_mut().iter_mut().for_each(|value| *value = value.max(0.0));
    let coverage = vec![1.0; pixels.len()];
    to_panel(&LinearImage { width, height, pixels, coverage, background: [0.0; 3] }, exposure)
}

/// Table and renderings of the assets.
pub(super) fn assets(assets: &[PageAsset]) -> Markup {
    let heads = ["asset", "kind", "size", "images", "fetches", "on disk", "on GPU", "PSNR", "ΔE", ""];
    html! {
        @if !assets.is_empty() {
            h2 { "Captures, BTFs and environments" }
            p {
                "ΔE is the mean colour difference from the photographs; environments are prefiltered and have none. Renderings show the \
                 packs, captures and BTFs along the normal, lit from the upper left."
            }
            div.scroll { table.all {
                thead { tr { @for name in heads { th.left[name == "kind"] data-sorts="" { (name) } } } }
                tbody { @for PageAsset { entry, .. } in assets { (row(entry)) } }
            } }
            @for asset in assets { (section(asset)) }
        }
    }
}

fn row(entry: &AssetEntry) -> Markup {
    html! { tr {
        td { a href={ "#" (escaped(&entry.asset)) } { (entry.asset) } @if entry.retained { " " span.soft { "retained" } } }
        td.left { (entry.kind.name()) }
        @if let Some(report) = &entry.report {
            td { (report.size[0]) " x " (report.size[1]) } td { (report.images) }
            td { @if let Some(fetches) = report.fetches { (fetches) } @else { "-" } }
            td data-value=(report.bytes_on_disk) { (bytes(report.bytes_on_disk)) }
            td data-value=(report.bytes_on_gpu) { (bytes(report.bytes_on_gpu)) }
            td { @if let Some(psnr) = report.psnr { (format!("{psnr:.1} dB")) } @else { "-" } }
            td { @if let Some(delta_e) = report.delta_e { (format!("{delta_e:.2}")) } @else { "-" } }
        } @else {
            @for _ in 2..9 { td { "-" } }
        }
        td.left { @if entry.passed() { span.good { "passed" } } @else { span.bad { "failed" } } }
    } }
}

fn section(PageAsset { entry, rendering }: &PageAsset) -> Markup {
    let report = entry.report.as_ref();
    let failed = entry.gates.iter().filter(|gate| !gate.passed);
    html! {
        section.material id=(entry.asset) {
            h2 { (entry.asset) " " span.soft { (entry.source) } }
            @if let Some(error) = &entry.error { p.bad { (error) } }
            @for missed in report.iter().filter_map(|report| report.missed.as_ref()) { p.bad { (missed) } }
            @for gate in failed { p.bad { (gate) } }
            @if let Some(rendering) = rendering {
                div.row.large { figure { (image(rendering, &format!("rendering of {}", entry.asset))) } }
            }
            ul { @for note in report.iter().flat_map(|report| &report.notes) { li { (note) } } }
        }
    }
}
