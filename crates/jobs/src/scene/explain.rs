//! What a scene needs of each material, why, and what that saves.

use super::plan::{Job, Plan};
use super::run::Made;
use super::uses::Use;
use crate::encode::PackRecipe;
use crate::report::material::StageTime;
use crate::store::Digest;
use brdfc_core::progress::Stage;
use brdfc_core::words::join_truncated;
use brdfc_formats::crop::{DirectionRange, Elevations};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One need.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Explained {
    /// Whose.
    pub material: String,
    /// What is needed.
    pub need: String,
    /// Which uses ask for that.
    pub why: String,
    /// Bytes on a GPU that are left out for it, where that is known: of what was made and of what would have been made without
    /// it, or the mean of other materials of this build.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saved_bytes: Option<u64>,
    /// Seconds of work that are saved, likewise; below zero where the need costs some. Of two runs only where they differ for
    /// sure.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saved_seconds: Option<f64>,
}

/// The needs of all materials of a plan; what is saved where there are packs. `kept` finds what was made before of a job,
/// which may be one that no plan has: what a material would be without one of its needs.
pub fn explain(plan: &Plan, made: &BTreeMap<&str, &Made>, kept: &Kept<'_>) -> Vec<Explained> {
    let maps = [0, 1].map(|k| Mean::of(made.values().filter_map(|made| of_map(made, k))));
    let packs = Mean::of(made.values().map(|made| (made.report.bytes_on_gpu, seconds(&made.pack_times, |_| true))));
    let mut all = Vec::new();
    for job in &plan.jobs {
        let made = made.get(job.name.as_str()).copied();
        let before = all.len();
        all.extend(levels(job, made, kept));
        all.extend(coarser_levels(job, made, kept));
        all.extend(directions(job, made, kept));
        all.extend(without_maps(job, plan, maps));
        if all.len() == before {
            let names = names(&job.uses, |used| {
                used.nearest.is_none() && used.light() == Elevations::ALL && used.view() == Elevations::ALL
            });
            all.push(said(
                job,
                "all levels of detail and directions",
                &names.unwrap_or_else(|| "any distance".to_owned()),
            ));
        }
    }
    for name in &plan.skipped {
        let none = Explained {
            material: name.clone(),
            need: NOTHING.to_owned(),
            why: "no use refers to it".to_owned(),
            saved_bytes: packs.map(|mean| mean.bytes),
            saved_seconds: packs.map(|mean| mean.seconds),
        };
        all.push(none);
    }
    all
}

/// Mean bytes on a GPU, and seconds.
#[derive(Clone, Copy)]
struct Mean {
    bytes: u64,
    seconds: f64,
}

impl Mean {
    fn of(all: impl Iterator<Item = (u64, f64)>) -> Option<Self> {
        let all: Vec<(u64, f64)> = all.collect();
        let count = all.len();
        let (bytes, seconds) = all.into_iter().fold((0, 0.0), |(bytes, sum), (b, s)| (bytes + b, sum + s));
        (count > 0).then(|| Self { bytes: bytes / count as u64, seconds: seconds / count as f64 })
    }
}

fn said(job: &Job, need: &str, why: &str) -> Explained {
    let (material, need, why) = (job.name.clone(), need.to_owned(), why.to_owned());
    Explained { material, need, why, saved_bytes: None, saved_seconds: None }
}

/// What is needed of a material that no use refers to.
pub const NOTHING: &str = "nothing";

/// A material of another recipe, made of the source with this hash, if it was made before.
pub type Kept<'a> = dyn Fn(&Job, Digest) -> Option<Made> + 'a;

/// What a pack has less than what was made before by another recipe: bytes, and seconds where they differ by more than runs do.
fn less_than_kept(job: &Job, recipe: PackRecipe, made: Option<&Made>, kept: &Kept<'_>) -> (Option<u64>, Option<f64>) {
    let other = made.and_then(|made| kept(&Job { recipe, maps: [false; 2], ..job.clone() }, made.source));
    let Some((made, other)) = made.zip(other) else { return (None, None) };
    let bytes = other.report.bytes_on_gpu.checked_sub(made.report.bytes_on_gpu);
    let [before, now] = [&other, made].map(|made| seconds(&made.pack_times, |_| true));
    (bytes, Some(before - now).filter(|saved| saved.abs() > LEAST_SHARE * before.max(now)))
}

/// Two runs of the same work may differ by so much of the longer one.
const LEAST_SHARE: f64 = 0.5;

/// The recipe of a material with all levels of detail that were asked for.
fn with_all_levels(job: &Job) -> PackRecipe {
    let mut recipe = job.asked.clone();
    recipe.limit_directions(job.needs.directions);
    recipe
}

/// Finer levels of detail that are not stored.
fn levels(job: &Job, made: Option<&Made>, kept: &Kept<'_>) -> Option<Explained> {
    // Among tables there may be none whose levels the distance takes away.
    let [stored, all] = job.recipe.stored_levels()?;
    if stored == all {
        return None;
    }
    let need = format!("levels of detail 0 to {stored} of {all}");
    let nearest = |used: &Use| used.nearest.as_ref().is_some_and(|at| *at.get_ref() <= job.needs.nearest);
    let why = format!("nearest at {}: {}", job.needs.nearest, names(&job.uses, nearest).unwrap_or_default());
    let saved_bytes =
        made.and_then(|made| job.recipe.bytes_of_left_out_levels(&made.report.codec, made.report.channels));
    let (of_kept, saved_seconds) = less_than_kept(job, with_all_levels(job), made, kept);
    Some(Explained { saved_bytes: saved_bytes.or(of_kept), saved_seconds, ..said(job, &need, &why) })
}

/// Coarser levels of detail of tables that are not stored.
fn coarser_levels(job: &Job, made: Option<&Made>, kept: &Kept<'_>) -> Option<Explained> {
    let (asked, stored) = (job.asked.coarser_levels(), job.recipe.coarser_levels());
    if stored == asked {
        return None;
    }
    let need = format!("{stored} of {asked} coarser levels of detail");
    let farthest = |used: &Use| used.farthest.as_ref().is_some_and(|at| *at.get_ref() >= job.needs.farthest);
    let why = format!("farthest at {}: {}", job.needs.farthest, names(&job.uses, farthest).unwrap_or_default());
    let (saved_bytes, saved_seconds) = less_than_kept(job, with_all_levels(job), made, kept);
    Some(Explained { saved_bytes, saved_seconds, ..said(job, &need, &why) })
}

/// Directions that are cropped. A search makes another pack than without them.
fn directions(job: &Job, made: Option<&Made>, kept: &Kept<'_>) -> Option<Explained> {
    let DirectionRange { light, view } = job.needs.directions;
    if job.needs.directions.is_all() {
        return None;
    }
    let narrows = |used: &Use| used.light() != Elevations::ALL || used.view() != Elevations::ALL;
    let why = names(&job.uses, narrows).unwrap_or_default();
    let of = |what: &str, range: Elevations| {
        if range == Elevations::ALL { String::new() } else { format!("{what} from {range}") }
    };
    let parts: Vec<String> =
        [of("light", light), of("seen", view)].into_iter().filter(|part| !part.is_empty()).collect();
    let mut whole = job.recipe.clone();
    whole.limit_directions(DirectionRange::ALL);
    let (of_kept, saved_seconds) = less_than_kept(job, whole, made, kept);
    let found = |made: &Made| made.report.of_all_directions?.checked_sub(made.report.bytes_on_gpu);
    let saved_bytes = made.and_then(|made| match &job.recipe {
        recipe if recipe.has_fixed_size() => Some(made.report.cropped_bytes),
        // What is cropped is room for more nodes and slices.
        recipe if !recipe.limits_error() => None,
        _ => found(made).or(of_kept).filter(|bytes| *bytes > 0),
    });
    Some(Explained { saved_bytes, saved_seconds, ..said(job, &parts.join(", "), &why) })
}

/// Maps that are not made of a scene that has an environment.
fn without_maps(job: &Job, plan: &Plan, maps: [Option<Mean>; 2]) -> Option<Explained> {
    let wanted = job.maps;
    if !plan.has_environment || wanted == [true; 2] {
        return None;
    }
    let need = match wanted {
        [false, false] => "no maps",
        [true, false] => "a bandwidth map, no samples",
        _ => "samples, no bandwidth map",
    };
    let why = if job.needs.lit_by_environment { "what uses want" } else { "points alone light it" };
    let missing = [0, 1].into_iter().filter(|k| !wanted[*k]);
    let means: Option<Vec<Mean>> = missing.map(|k| maps[k]).collect();
    let saved_bytes = means.as_ref().map(|means| means.iter().map(|mean| mean.bytes).sum());
    let saved_seconds = means.map(|means| means.iter().map(|mean| mean.seconds).sum()).filter(|seconds| *seconds > 0.0);
    let names = names(&job.uses, |_| true).unwrap_or_default();
    Some(Explained { saved_bytes, saved_seconds, ..said(job, need, &format!("{why}: {names}")) })
}

/// Bytes of a map of a material that has it, and seconds where it was made now.
fn of_map(made: &Made, k: usize) -> Option<(u64, f64)> {
    let maps = made.maps.as_ref()?;
    let (bytes, stage) = match k {
        0 => (maps.bandwidth.as_ref()?.facts.gpu_bytes, Stage::BandwidthMap),
        _ => (maps.samples.as_ref()?.facts.gpu_bytes, Stage::ImportanceSamples),
    };
    Some((bytes, made.times.as_ref().map_or(0.0, |times| seconds(times, |name| name == stage.name()))))
}

fn seconds(times: &[StageTime], counts: impl Fn(&str) -> bool) -> f64 {
    times.iter().filter(|time| counts(&time.stage)).map(|time| time.seconds).sum()
}

/// Names of uses, a few at most.
fn names(uses: &[(String, Use)], which: impl Fn(&Use) -> bool) -> Option<String> {
    const NAMED: usize = 3;
    let all: Vec<&str> = uses.iter().filter(|(_, used)| which(used)).map(|(name, _)| name.as_str()).collect();
    (!all.is_empty()).then(|| join_truncated(&all, NAMED))
}
