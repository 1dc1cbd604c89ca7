//! Report pages of builds and flat BTFs: one HTML file that needs no network and no scripts, and its figures as CSV and JSON.

mod against;
mod assets;
mod csv;
mod evidence;
mod figures;
mod flat;
mod gather;
mod html;
pub(crate) mod markup;
mod parts;
mod sheet;
mod style;
mod view_link;

pub use against::{Regression, regressions};
pub use assets::PageAsset;
pub use csv::{CSV_HEADER, FLAT_CSV_HEADER, csv, flat_csv};
pub use evidence::{Evidence, LitBall, ThumbnailScenes, Thumbnails, evidence};
pub use flat::{FlatPage, flat_html};
pub use gather::{PER_PAGE, Page, PageMaterial, PageOptions, Reports, gather, source_of};
pub use html::{html, part_html};
pub use parts::PagePart;
pub use sheet::sheet;
pub use view_link::{ViewLink, source_name};

use super::build::{AssetEntry, MaterialEntry};
use brdfc_metrics::by_angle::ByAngle;
use schemars::JsonSchema;
use serde::Serialize;

/// Figures of a page, as JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PageReport<'a> {
    /// Layout of this report.
    pub version: u32,
    /// Name of the scene.
    pub scene: &'a str,
    /// Regressions against the earlier build, the worst first.
    pub regressions: &'a [Regression],
    /// Materials of the scene, sorted by name.
    pub materials: Vec<PageEntry<'a>>,
    /// RTI captures, BTFs and environments, sorted by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub assets: Vec<&'a AssetEntry>,
}

/// Figures of one material.
#[derive(Debug, Serialize, JsonSchema)]
pub struct PageEntry<'a> {
    /// The material's entry in the build report.
    #[serde(flatten)]
    pub entry: &'a MaterialEntry,
    /// Error by angle; absent if the source is not available or there is no pack.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_angle: Option<&'a ByAngle>,
    /// Mean ΔE of a ball in the environment of the scene, by lobes against the integral over all directions; absent without lobes
    /// or source.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_delta_e: Option<f64>,
    /// Mean ΔE that the noise of the integral alone causes. Both do not add up: errors are independent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub environment_noise: Option<f64>,
}

impl Page {
    /// Figures of the page, for its JSON report.
    pub fn report(&self) -> PageReport<'_> {
        let materials = self.materials.iter().map(|material| {
            let evidence = material.evidence.as_ref();
            let lit = evidence.and_then(|evidence| evidence.in_environment.as_ref());
            PageEntry {
                entry: &material.entry,
                by_angle: evidence.and_then(|evidence| evidence.by_angle.as_ref()),
                environment_delta_e: lit.and_then(|lit| Some(lit.difference.as_ref()?.1)),
                environment_noise: lit.and_then(|lit| lit.noise),
            }
        });
        let assets = self.assets.iter().map(|asset| &asset.entry);
        PageReport {
            version: 1,
            scene: &self.scene,
            regressions: &self.regressions,
            materials: materials.collect(),
            assets: assets.collect(),
        }
    }
}
