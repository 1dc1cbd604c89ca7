//! Summary of a finished build.

use crate::table;
use brdfc::Outcomes;
use brdfc::bandwidth::BandwidthFacts;
use brdfc::scene::{PARTS, Packed, environment_map, part_name};

/// Formats packs as a table, one per line, and maps if there are any.
pub(super) fn text(outcomes: &Outcomes) -> String {
    let made = || outcomes.materials.iter().filter_map(|outcome| Some((&outcome.name, outcome.result.as_ref().ok()?)));
    let packs = made().map(|(name, made)| {
        let seconds = made.times.as_ref().map(|times| times.iter().map(|t| t.seconds).sum());
        let mut row = vec![name.clone()];
        row.extend(table::material_row(&made.report, seconds));
        row
    });
    let packs = made().next().map(|_| table::plain(&table::MATERIAL_HEADER, packs));

    let mut rows = Vec::new();
    if let Some(Ok(made)) = &outcomes.environment {
        rows.push(bandwidth_row(environment_map(), &made.report));
    }
    for (name, maps) in made().filter_map(|(name, made)| Some((name, made.maps.as_ref()?))) {
        let [bandwidth, samples] = PARTS.map(|part| part_name(name, part));
        rows.extend(maps.bandwidth.as_ref().map(|map| bandwidth_row(bandwidth, map)));
        rows.extend(maps.samples.as_ref().map(|packed| {
            let facts = &packed.facts;
            let size = format!("{} x {}", facts.samples, facts.polar * facts.azimuths);
            row(samples, size, "-".to_owned(), packed.bytes_on_disk, facts.gpu_bytes)
        }));
    }
    let header = ["map", "texels", "largest bandwidth", "on disk", "on GPU"];
    let maps = (!rows.is_empty()).then(|| table::plain(&header, &rows));
    packs.into_iter().chain(maps).collect::<Vec<_>>().join("\n")
}

fn bandwidth_row(file: String, map: &Packed<BandwidthFacts>) -> Vec<String> {
    let facts = &map.facts;
    let size = format!("{} x {}", facts.size[0], facts.size[1]);
    row(file, size, format!("{:.2} {}", facts.largest, facts.unit), map.bytes_on_disk, facts.gpu_bytes)
}

fn row(file: String, size: String, largest: String, disk: u64, gpu: u64) -> Vec<String> {
    vec![file, size, largest, table::bytes(disk), table::bytes(gpu)]
}
