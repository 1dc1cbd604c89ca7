//! Pages about the packs of a build, or about a flat BTF: `brdfc report`.
//!
//! [`Reports::open`] reads a folder of packs, [`gather`] compares them with their sources, and [`html`], [`csv()`] and
//! [`sheet_png`] format the result. [`FlatPage`] does the same for a flat BTF.

pub use brdfc_jobs::report::page::{
    CSV_HEADER, FLAT_CSV_HEADER, FlatPage, PER_PAGE, Page, PageMaterial, PageOptions, PageReport, Reports, ViewLink,
    csv, flat_csv, flat_html, gather, html, part_html,
};
pub use brdfc_jobs::scene::plan::REPORT;
pub use brdfc_jobs::write::build_folder;

use brdfc_jobs::report::page::sheet;
use brdfc_render::rendering::rgb_png;

/// Draws all materials of a page as a PNG: source, pack and ΔE, with labels and the colour scale of differences.
pub fn sheet_png(page: &Page) -> Vec<u8> {
    rgb_png(&sheet(page))
}
