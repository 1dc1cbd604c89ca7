//! The tables of pages as CSV.

use super::gather::{Page, PageMaterial};
use crate::flatten::FlatAsset;

/// First line of the figures of a build.
pub const CSV_HEADER: &str = "material,source,codec,size,fetches,bytes_on_disk,bytes_on_gpu,delta_e_mean,delta_e_p95,relative_error,\
                      albedo_max_difference,reciprocity,lobes_fetches,lobes_bytes_on_gpu,\
                      lobes_delta_e_mean,lobes_delta_e_p95,passed,retained,error\n";

/// First line of the figures of a flat BTF.
pub const FLAT_CSV_HEADER: &str = "texture,gpu_bytes\n";

/// Writes a header and a line per material.
pub fn csv(page: &Page) -> String {
    let mut text = CSV_HEADER.to_owned();
    for PageMaterial { entry, .. } in &page.materials {
        let mut fields = vec![quoted(&entry.material), quoted(&entry.source)];
        match &entry.report {
            Some(report) => {
                let off_grid = &report.off_grid;
                let numbers = [
                    off_grid.rendering.delta_e.mean,
                    off_grid.rendering.delta_e.p95,
                    off_grid.norms.relative_mean,
                    off_grid.albedo_max_difference,
                    off_grid.reciprocity,
                ];
                fields.extend([report.codec.variant().to_owned(), quoted(&report.codec.size())]);
                fields.push(report.fetches.to_string());
                fields.extend([report.bytes_on_disk, report.bytes_on_gpu].map(|bytes| bytes.to_string()));
                fields.extend(numbers.map(|number| number.to_string()));
            }
            None => fields.extend(std::iter::repeat_n(String::new(), 10)),
        }
        let of_lobes = entry.lobes_report().map(|lobes| {
            let (facts, error) = (&lobes.facts, &lobes.facts.delta_e);
            [facts.fetches.to_string(), facts.gpu_bytes.to_string(), error.mean.to_string(), error.p95.to_string()]
        });
        fields.extend(of_lobes.unwrap_or_default());
        fields.extend([
            entry.passed().to_string(),
            entry.retained.to_string(),
            quoted(entry.error.as_deref().unwrap_or("")),
        ]);
        text += &(fields.join(",") + "\n");
    }
    text
}

/// Writes a header and a line per texture of a flat BTF.
pub fn flat_csv(asset: &FlatAsset) -> String {
    let mut text = FLAT_CSV_HEADER.to_owned();
    for (name, bytes) in &asset.images {
        text += &format!("{name},{bytes}\n");
    }
    text
}

/// Quotes a field as RFC 4180 requires.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}
