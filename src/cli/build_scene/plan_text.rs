//! Text of a plan: what a build would do.

use crate::table;
use brdfc::scene::{AssetEntry, AssetJob, Explained, Job, MaterialEntry, NOTHING, Predicted, pack_name};
use brdfc::{BuildReport, PackRecipe, Plan};
use brdfc_terminal::words::{format_number, join_truncated};
use std::path::Path;

/// Maximum number of material names in a line.
pub(super) const MAX_NAMED: usize = 6;

/// Formats the plan as a table, one material per line.
pub(super) fn text(plan: &Plan, report: &BuildReport, out: &Path) -> String {
    let row = |(job, planned): (&Job, &MaterialEntry)| {
        let is_missing = job.input.path().is_some_and(|path| !path.exists());
        [
            job.name.clone(),
            job.needs.uses.to_string(),
            job.recipe.variant().to_owned(),
            job.recipe.target(),
            if is_missing { "no such file".to_owned() } else { of_pack(&job.recipe, planned) },
            job.input.to_string(),
            out.join(pack_name(&job.name)).display().to_string(),
        ]
    };
    let header = ["material", "uses", "codec", "target", "on GPU", "source", "pack"];
    let mut text = match plan.jobs.is_empty() {
        true => String::new(),
        false => table::plain(&header, plan.jobs.iter().zip(&report.materials).map(row)),
    };
    if !plan.assets.is_empty() {
        let header = ["asset", "kind", "on GPU", "source", "pack"];
        let rows = plan.assets.iter().zip(&report.assets).map(|(job, planned)| asset_row(job, planned, out));
        text += &(if text.is_empty() { "" } else { "\n" }.to_owned() + &table::plain(&header, rows));
    }
    let lobes = plan.jobs.iter().zip(&report.materials).filter_map(|(job, planned)| {
        let (recipe, predicted) = (job.lobes.as_ref()?, planned.predicted_lobes?);
        let limit = recipe.max_delta_e.map_or(String::new(), |limit| format!("ΔE {}, ", format_number(limit)));
        let target = format!("{limit}up to {} look-ups", recipe.max_fetches);
        let file = out.join(planned.lobes.as_ref()?).display().to_string();
        Some([job.name.clone(), target, bounds(predicted, planned.cached), file])
    });
    let lobes: Vec<_> = lobes.collect();
    if !lobes.is_empty() {
        text += &format!("\n{}\n", table::plain(&["lobes of", "target", "on GPU", "file"], lobes));
    }
    if let Some(job) = &plan.environment {
        let maps: Vec<String> = job.files().map(|file| out.join(file).display().to_string()).collect();
        text += &format!("lit by {}: {}\n", job.path.display(), maps.join(", "));
    }
    for (k, words) in ["bandwidth maps", "importance samples"].into_iter().enumerate() {
        let of: Vec<&str> = plan.jobs.iter().filter(|job| job.maps[k]).map(|job| job.name.as_str()).collect();
        if !of.is_empty() {
            text += &format!("{words} of {}\n", of.join(", "));
        }
    }
    if !plan.skipped.is_empty() {
        text += &format!("not used by the scene: {}\n", join_truncated(&plan.skipped, MAX_NAMED));
    }
    text + &needs(&report.needs)
}

fn asset_row(job: &AssetJob, planned: &AssetEntry, out: &Path) -> [String; 5] {
    let on_gpu = match &planned.report {
        _ if !job.path.exists() => "no such file".to_owned(),
        Some(report) => format!("{}, cached", table::bytes(report.bytes_on_gpu)),
        None => "searched".to_owned(),
    };
    let file = out.join(job.file()).display().to_string();
    [job.name.clone(), job.kind.name().to_owned(), on_gpu, job.path.display().to_string(), file]
}

/// Formats the features that each material needs, and why.
pub(super) fn needs(explained: &[Explained]) -> String {
    if explained.is_empty() {
        return String::new();
    }
    let row = |explained: &Explained| {
        let about = if explained.need == NOTHING { "about " } else { "" };
        let bytes = explained.saved_bytes.map(|bytes| format!("{about}{}", table::bytes(bytes)));
        let format_time = |seconds: f64| match seconds {
            ..0.0 => format!("takes about {:.2} s more", -seconds),
            _ => format!("about {seconds:.2} s"),
        };
        let seconds = explained.saved_seconds.map(format_time);
        let saved: Vec<String> = bytes.into_iter().chain(seconds).collect();
        let saved = if saved.is_empty() { "-".to_owned() } else { saved.join(", ") };
        vec![explained.material.clone(), explained.need.clone(), explained.why.clone(), saved]
    };
    let (unused, needed): (Vec<&Explained>, Vec<&Explained>) =
        explained.iter().partition(|explained| explained.need == NOTHING);
    let mut rows: Vec<_> = needed.into_iter().map(row).collect();
    match unused[..] {
        [first, _, ..] => rows.push(row(&all_unused(first, &unused))),
        _ => rows.extend(unused.into_iter().map(row)),
    }
    format!("\n{}", table::words(&["material", "needed", "because of", "saves"], &rows))
}

/// Combines all materials that need no pack into one row, because each saves the same bytes.
fn all_unused(first: &Explained, unused: &[&Explained]) -> Explained {
    let names: Vec<&str> = unused.iter().map(|explained| explained.material.as_str()).collect();
    let count = unused.len();
    Explained {
        material: join_truncated(&names, MAX_NAMED),
        why: format!("no use refers to these {count}"),
        saved_bytes: first.saved_bytes.map(|bytes| bytes * count as u64),
        saved_seconds: first.saved_seconds.map(|seconds| seconds * count as f64),
        ..first.clone()
    }
}

/// Predicted bytes of a pack on a GPU.
fn of_pack(recipe: &PackRecipe, planned: &MaterialEntry) -> String {
    let Some(predicted) = planned.predicted else { return "-".to_owned() };
    let is_open = predicted.least == 0 && recipe.is_search() && planned.cached.is_none();
    format!("{}{}", if is_open { "searched, " } else { "" }, bounds(predicted, planned.cached))
}

/// Predicted bytes on a GPU: the size of the cached file, or a range.
fn bounds(Predicted { least, most }: Predicted, cached: Option<bool>) -> String {
    match least {
        _ if cached == Some(true) => format!("{}, cached", table::bytes(most)),
        0 => format!("up to {}", table::bytes(most)),
        _ => format!("{} to {}", table::bytes(least), table::bytes(most)),
    }
}
