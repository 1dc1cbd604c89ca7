//! Explanations of a build: the needs of each material, the uses that cause them, and the savings.

use super::plan::{Job, Plan};
use super::run::Made;
use super::uses::{DEFAULT_MAPS, Use};
use crate::encode::PackRecipe;
use crate::report::material::StageTime;
use crate::store::Digest;
use brdfc_core::progress::Stage;
use brdfc_core::words::join_truncated;
use brdfc_formats::crop::{DirectionRange, Elevations};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A need of a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Explained {
    /// Name of the material.
    pub material: String,
    /// Need as a phrase, such as `all levels of detail and directions`; `nothing` if no use refers to the material.
    pub need: String,
    /// The uses that cause it.
    pub why: String,
    /// Bytes on a GPU that the need saves, compared with a pack made without it, or estimated from the mean of the
    /// other materials of this build. Absent if unknown.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saved_bytes: Option<u64>,
    /// Seconds of work that the need saves, from the same comparison; negative if it costs time. Absent if unknown,
    /// or if two runs differ by no more than their usual variation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saved_seconds: Option<f64>,
}

/// Explains the needs of all materials of a plan, with the savings of those that were made. `lookup` finds earlier
/// results of a job, including jobs that no plan has: a material without one of its needs.
pub fn explain(plan: &Plan, made: &BTreeMap<&str, &Made>, lookup: &CachedLookup<'_>) -> Vec<Explained> {
    let means = [0, 1, 2].map(|k| Mean::of(made.values().filter_map(|made| of_map(made, k))));
    let packs = Mean::of(made.values().map(|made| (made.report.bytes_on_gpu, seconds(&made.pack_times, |_| true))));
    let mut all = Vec::new();
    for job in &plan.jobs {
        let made = made.get(job.name.as_str()).copied();
        let before = all.len();
        all.extend(levels(job, made, lookup));
        all.extend(coarser_levels(job, made, lookup));
        all.extend(directions(job, made, lookup));
        if all.len() == before {
            let names = names(&job.uses, |used| {
                used.nearest.is_none() && used.light() == Elevations::ALL && used.view() == Elevations::ALL
            });
            all.push(entry(
                job,
                "all levels of detail and directions",
                &names.unwrap_or_else(|| "any distance".to_owned()),
            ));
        }
        all.extend(maps(job, plan, means));
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

/// Mean bytes on a GPU and mean seconds of several materials.
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

fn entry(job: &Job, need: &str, why: &str) -> Explained {
    let (material, need, why) = (job.name.clone(), need.to_owned(), why.to_owned());
    Explained { material, need, why, saved_bytes: None, saved_seconds: None }
}

/// The need of a material that no use refers to.
pub const NOTHING: &str = "nothing";

/// Looks up the earlier result of a job, made from the source with this hash.
pub type CachedLookup<'a> = dyn Fn(&Job, Digest) -> Option<Made> + 'a;

/// Savings of a pack compared with the cached pack of another recipe: bytes, and seconds if they differ by more than
/// the variation between runs.
fn saved_against_cached(
    job: &Job,
    recipe: PackRecipe,
    made: Option<&Made>,
    lookup: &CachedLookup<'_>,
) -> (Option<u64>, Option<f64>) {
    let other =
        made.and_then(|made| lookup(&Job { recipe, lobes: None, maps: [false; 2], ..job.clone() }, made.source));
    let Some((made, other)) = made.zip(other) else { return (None, None) };
    let bytes = other.report.bytes_on_gpu.checked_sub(made.report.bytes_on_gpu);
    let [before, now] = [&other, made].map(|made| seconds(&made.pack_times, |_| true));
    (bytes, Some(before - now).filter(|saved| saved.abs() > MIN_SHARE * before.max(now)))
}

/// Two runs of the same work may differ by this share of the longer one.
const MIN_SHARE: f64 = 0.5;

/// The recipe of a material with all levels of detail of its options.
fn with_all_levels(job: &Job) -> PackRecipe {
    let mut recipe = job.asked.clone();
    recipe.limit_directions(job.needs.directions);
    recipe
}

/// Finer levels of detail that are not stored.
fn levels(job: &Job, made: Option<&Made>, lookup: &CachedLookup<'_>) -> Option<Explained> {
    // `None` if the codec cannot omit finer levels.
    let [stored, all] = job.recipe.stored_levels()?;
    if stored == all {
        return None;
    }
    let need = format!("levels of detail 0 to {stored} of {all}");
    let nearest = |used: &Use| used.nearest.as_ref().is_some_and(|at| *at.get_ref() <= job.needs.nearest);
    let why = format!("nearest at {}: {}", job.needs.nearest, names(&job.uses, nearest).unwrap_or_default());
    let saved_bytes =
        made.and_then(|made| job.recipe.bytes_of_left_out_levels(&made.report.codec, made.report.channels));
    let (of_cached, saved_seconds) = saved_against_cached(job, with_all_levels(job), made, lookup);
    Some(Explained { saved_bytes: saved_bytes.or(of_cached), saved_seconds, ..entry(job, &need, &why) })
}

/// Coarser levels of detail of table packs that are not stored.
fn coarser_levels(job: &Job, made: Option<&Made>, lookup: &CachedLookup<'_>) -> Option<Explained> {
    let (asked, stored) = (job.asked.coarser_levels(), job.recipe.coarser_levels());
    if stored == asked {
        return None;
    }
    let need = format!("{stored} of {asked} coarser levels of detail");
    let farthest = |used: &Use| used.farthest.as_ref().is_some_and(|at| *at.get_ref() >= job.needs.farthest);
    let why = format!("farthest at {}: {}", job.needs.farthest, names(&job.uses, farthest).unwrap_or_default());
    let (saved_bytes, saved_seconds) = saved_against_cached(job, with_all_levels(job), made, lookup);
    Some(Explained { saved_bytes, saved_seconds, ..entry(job, &need, &why) })
}

/// Directions outside the range of the uses, which are cropped. With a search, the cropped pack also differs otherwise.
fn directions(job: &Job, made: Option<&Made>, lookup: &CachedLookup<'_>) -> Option<Explained> {
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
    let (of_cached, saved_seconds) = saved_against_cached(job, whole, made, lookup);
    let found = |made: &Made| made.report.of_all_directions?.checked_sub(made.report.bytes_on_gpu);
    let saved_bytes = made.and_then(|made| match &job.recipe {
        recipe if recipe.has_fixed_size() => Some(made.report.cropped_bytes),
        // With a limit of bytes, the cropped bytes are spent on more nodes and slices.
        recipe if !recipe.limits_error() => None,
        _ => found(made).or(of_cached).filter(|bytes| *bytes > 0),
    });
    Some(Explained { saved_bytes, saved_seconds, ..entry(job, &parts.join(", "), &why) })
}

/// Lobes and maps of a scene with an environment, and the savings by those that are not made.
fn maps(job: &Job, plan: &Plan, means: [Option<Mean>; 3]) -> Option<Explained> {
    if !plan.has_environment {
        return None;
    }
    let requested = [job.lobes.is_some(), job.maps[0], job.maps[1]];
    let named = ["lobes", "a bandwidth map", "importance samples"].into_iter().zip(requested);
    let texture = job.texture.iter().map(|_| "a bandwidth map of the texture");
    let named: Vec<&str> = named.filter_map(|(name, requested)| requested.then_some(name)).chain(texture).collect();
    let need = if named.is_empty() { "no lobes and no maps".to_owned() } else { named.join(", ") };
    let why = match job.needs.lit_by_environment {
        false => "point lights only",
        true if requested == DEFAULT_MAPS => "lit by the environment",
        true => "maps of the uses",
    };
    let missing = [0, 1, 2].into_iter().filter(|k| !requested[*k]);
    let means: Option<Vec<Mean>> = missing.map(|k| means[k]).collect::<Option<Vec<_>>>().filter(|all| !all.is_empty());
    let saved_bytes = means.as_ref().map(|means| means.iter().map(|mean| mean.bytes).sum());
    let saved_seconds = means.map(|means| means.iter().map(|mean| mean.seconds).sum()).filter(|seconds| *seconds > 0.0);
    let names = names(&job.uses, |_| true).unwrap_or_default();
    Some(Explained { saved_bytes, saved_seconds, ..entry(job, &need, &format!("{why}: {names}")) })
}

/// Bytes of the lobes or a map of a material, and seconds if this build made it; `None` if the material does not have it.
fn of_map(made: &Made, k: usize) -> Option<(u64, f64)> {
    let maps = made.maps.as_ref()?;
    let (bytes, stage) = match k {
        0 => (maps.lobes.as_ref()?.facts.gpu_bytes, Stage::Lobes),
        1 => (maps.bandwidth.as_ref()?.facts.gpu_bytes, Stage::BandwidthMap),
        _ => (maps.samples.as_ref()?.facts.gpu_bytes, Stage::ImportanceSamples),
    };
    Some((bytes, made.times.as_ref().map_or(0.0, |times| seconds(times, |name| name == stage.name()))))
}

fn seconds(times: &[StageTime], counts: impl Fn(&str) -> bool) -> f64 {
    times.iter().filter(|time| counts(&time.stage)).map(|time| time.seconds).sum()
}

/// Names of the selected uses, the first three of them; `None` if there are none.
fn names(uses: &[(String, Use)], which: impl Fn(&Use) -> bool) -> Option<String> {
    const NAMED: usize = 3;
    let all: Vec<&str> = uses.iter().filter(|(_, used)| which(used)).map(|(name, _)| name.as_str()).collect();
    (!all.is_empty()).then(|| join_truncated(&all, NAMED))
}
