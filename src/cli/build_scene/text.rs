//! Summary of a finished build.

use crate::table;
use brdfc::bandwidth::BandwidthFacts;
use brdfc::environment::EnvironmentFacts;
use brdfc::scene::{LOBES, LobesReport, MadeAsset, PARTS, Packed, TEXTURE, part_name};
use brdfc::{Outcomes, Plan};

/// Formats packs as a table, one per line, and lobes and maps if there are any.
pub(super) fn text(plan: &Plan, outcomes: &Outcomes) -> String {
    let made = || outcomes.materials.iter().filter_map(|outcome| Some((&outcome.name, outcome.result.as_ref().ok()?)));
    let packs = made().map(|(name, made)| {
        let seconds = made.times.as_ref().map(|times| times.iter().map(|t| t.seconds).sum());
        let mut row = vec![name.clone()];
        row.extend(table::material_row(&made.report, seconds));
        row
    });
    let packs = made().next().map(|_| table::plain(&table::MATERIAL_HEADER, packs));

    let lobes = made().filter_map(|(name, made)| Some(lobes_row(name, made.maps.as_ref()?.lobes.as_ref()?)));
    let lobes: Vec<_> = lobes.collect();
    let header = ["lobes", "look-ups", "on disk", "on GPU", "ΔE", "ΔE 95 %"];
    let lobes = (!lobes.is_empty()).then(|| table::plain(&header, lobes));

    let mut rows = Vec::new();
    if let (Some(job), Some(Ok(made))) = (&plan.environment, &outcomes.environment) {
        let maps = &made.report;
        let cells = maps.prefiltered.iter().map(environment_cells).chain(maps.bandwidth.iter().map(bandwidth_cells));
        rows.extend(job.files().zip(cells).map(|(file, cells)| row(file, cells)));
    }
    for (name, maps) in made().filter_map(|(name, made)| Some((name, made.maps.as_ref()?))) {
        let [bandwidth, samples] = PARTS.map(|part| part_name(name, part));
        rows.extend(maps.bandwidth.as_ref().map(|map| row(bandwidth, bandwidth_cells(map))));
        rows.extend(maps.samples.as_ref().map(|packed| {
            let facts = &packed.facts;
            let size = format!("{} x {}", facts.samples, facts.polar * facts.azimuths);
            row(samples, cells(size, "-".to_owned(), packed.bytes_on_disk, facts.gpu_bytes))
        }));
        let texture = part_name(name, TEXTURE);
        rows.extend(maps.texture.as_ref().map(|map| row(texture, bandwidth_cells(map))));
    }
    let header = ["map", "texels", "largest bandwidth", "on disk", "on GPU"];
    let maps = (!rows.is_empty()).then(|| table::plain(&header, &rows));
    let assets =
        outcomes.assets.iter().filter_map(|outcome| Some(asset_row(&outcome.name, outcome.result.as_ref().ok()?)));
    let assets: Vec<_> = assets.collect();
    let header = ["asset", "size", "images", "fetches", "on disk", "on GPU", "dB", "ΔE", "time"];
    let assets = (!assets.is_empty()).then(|| table::plain(&header, assets));
    packs.into_iter().chain(lobes).chain(maps).chain(assets).collect::<Vec<_>>().join("\n")
}

fn asset_row(name: &str, made: &MadeAsset) -> [String; 9] {
    let report = &made.report;
    let decimals = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let seconds = made.times.as_ref().map(|times| times.iter().map(|stage| stage.seconds).sum::<f64>());
    let [disk, gpu] = [report.bytes_on_disk, report.bytes_on_gpu].map(table::bytes);
    [
        name.to_owned(),
        format!("{} x {}", report.size[0], report.size[1]),
        report.images.to_string(),
        report.fetches.map_or("-".to_owned(), |fetches| fetches.to_string()),
        disk,
        gpu,
        decimals(report.psnr),
        decimals(report.delta_e),
        seconds.map_or("cached".to_owned(), |seconds| format!("{seconds:.2} s")),
    ]
}

fn lobes_row(name: &str, lobes: &LobesReport) -> [String; 6] {
    let LobesReport { bytes_on_disk, facts, .. } = lobes;
    let [mean, p95] = [facts.delta_e.mean, facts.delta_e.p95].map(|error| format!("{error:.2}"));
    let [disk, gpu] = [*bytes_on_disk, facts.gpu_bytes].map(table::bytes);
    [part_name(name, LOBES), facts.fetches.to_string(), disk, gpu, mean, p95]
}

/// Cells of a map after its name: texels, largest bandwidth, bytes on disk and on a GPU.
type Cells = [String; 4];

fn bandwidth_cells(map: &Packed<BandwidthFacts>) -> Cells {
    let facts = &map.facts;
    let size = format!("{} x {}", facts.size[0], facts.size[1]);
    cells(size, format!("{:.2} {}", facts.largest, facts.unit), map.bytes_on_disk, facts.gpu_bytes)
}

fn environment_cells(map: &Packed<EnvironmentFacts>) -> Cells {
    let EnvironmentFacts { side, gpu_bytes, .. } = map.facts;
    cells(format!("6 x {side} x {side}"), "-".to_owned(), map.bytes_on_disk, gpu_bytes)
}

fn cells(size: String, largest: String, disk: u64, gpu: u64) -> Cells {
    [size, largest, table::bytes(disk), table::bytes(gpu)]
}

fn row(file: String, cells: Cells) -> Vec<String> {
    [file].into_iter().chain(cells).collect()
}
