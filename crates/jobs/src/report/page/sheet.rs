//! The contact sheet of a page.

use super::gather::{Page, PageMaterial};
use brdfc_core::words::bytes;
use brdfc_render::contact_sheet::{Cell, contact_sheet};
use brdfc_render::rendering::Panel;
use brdfc_render::within::left_out_summary;

/// Draws a contact sheet of all materials on ball and cloth, and by lobes in the scene's environment, with the bytes and the mean
/// ΔE of the page's table.
pub fn sheet(page: &Page) -> Panel {
    let cells: Vec<Cell> = page.materials.iter().map(cell).collect();
    contact_sheet(&cells)
}

fn cell(PageMaterial { entry, evidence, .. }: &PageMaterial) -> Cell {
    let thumbnails = || evidence.iter().flat_map(|evidence| &evidence.thumbnails).filter(|drawn| !drawn.turned);
    let left_out = thumbnails().map(|drawn| drawn.left_out).sum::<f64>() / thumbnails().count().max(1) as f64;
    let details = match &entry.report {
        Some(report) => {
            let size = bytes(report.bytes_on_gpu);
            let limits = if entry.passed() { "" } else { ", missed" };
            let left_out = left_out_summary(left_out);
            format!("{size}  mean ΔE {:.2}{left_out}{limits}", report.off_grid.rendering.delta_e.mean)
        }
        None => "failed: no pack".to_owned(),
    };
    let lit = evidence.iter().filter_map(|evidence| evidence.in_environment.as_ref());
    let rows = thumbnails().chain(lit).map(|drawn| {
        let difference = drawn.difference.as_ref().map(|(panel, _)| panel.clone());
        [drawn.source.clone(), Some(drawn.pack.clone()), difference]
    });
    Cell { name: entry.material.clone(), details, failed: !entry.passed(), rows: rows.collect() }
}
