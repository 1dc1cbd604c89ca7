//! Regressions of a build against an earlier one.

use crate::report::build::{AssetEntry, BuildReport, MaterialEntry};
use crate::report::material::MaterialReport;
use crate::scene::assets::AssetReport;
use crate::scene::lobes::LobesReport;
use crate::scene::scene_section::ENVIRONMENT;
use brdfc_metrics::compare::is_black;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A figure that got worse by more than the tolerance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Regression {
    /// The material's name.
    pub material: String,
    /// Name of the figure, such as `mean ΔE`.
    pub figure: String,
    /// Value in the earlier build.
    pub before: String,
    /// Value in the compared build.
    pub now: String,
    /// Relative growth; absent if the figure is not a number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
}

impl std::fmt::Display for Regression {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { material, figure, before, now, growth } = self;
        write!(f, "{material}: {figure}: now {now}; before {before}")?;
        growth.map_or(Ok(()), |growth| write!(f, " (+{:.1} %)", 100.0 * growth))
    }
}

/// Absolute differences of figures that are never reported, as they are invisible: a hundredth of a just visible difference.
const NEGLIGIBLE: [(&str, f64); 7] = [
    ("mean ΔE", 1e-2),
    ("ΔE, 95th percentile", 4e-2),
    ("ε_r", 1e-4),
    ("largest albedo difference", 5e-4),
    ("light lost in the highlight", 1e-2),
    ("bytes on the GPU", 0.0),
    ("fetches", 0.0),
];

/// The same for lobes.
const NEGLIGIBLE_OF_LOBES: [(&str, f64); 3] =
    [("mean ΔE of lobes", 1e-2), ("ΔE of lobes, 95th percentile", 4e-2), ("look-ups of lobes", 0.0)];

/// The same for assets that are no materials.
const NEGLIGIBLE_OF_ASSETS: [(&str, f64); 3] = [("mean ΔE", 1e-2), ("bytes on the GPU", 0.0), ("fetches", 0.0)];

fn figures_of_lobes(lobes: &LobesReport) -> [f64; 3] {
    [lobes.facts.delta_e.mean, lobes.facts.delta_e.p95, lobes.facts.fetches as f64]
}

fn figures(report: &MaterialReport) -> [f64; 7] {
    let off_grid = &report.off_grid;
    [
        off_grid.rendering.delta_e.mean,
        off_grid.rendering.delta_e.p95,
        off_grid.norms.relative_mean,
        off_grid.albedo_max_difference,
        off_grid.highlight.map_or(0.0, |highlight| 1.0 - highlight.retained()),
        report.bytes_on_gpu as f64,
        f64::from(report.fetches),
    ]
}

/// Lists regressions against `old` and missed requirements, the worst first.
///
/// - Figures that grew by more than the share `tolerance`.
/// - Materials, and the environment's maps, that are missing or failed.
/// - Failed gates and missed limits, whether or not they failed before, and also of new materials.
/// - Materials whose directions changed: their figures do not compare.
/// - An earlier build that made no material.
pub fn regressions(new: &BuildReport, old: &BuildReport, tolerance: f64) -> Vec<Regression> {
    let by_name = |report: &BuildReport| -> BTreeMap<String, usize> {
        report.materials.iter().enumerate().map(|(number, entry)| (entry.material.clone(), number)).collect()
    };
    let (in_new, in_old) = (by_name(new), by_name(old));
    let mut found = Vec::new();
    // A build without packs has no figures to compare with.
    let no_assets = old.assets.iter().all(|entry| entry.report.is_none());
    if no_assets && old.materials.iter().all(|entry| entry.report.is_none()) {
        found.push(only("all materials", "earlier build", "no packs", "nothing to compare with"));
    }
    for now in &new.materials {
        let was = in_old.get(&now.material).map(|number| &old.materials[*number]);
        if was.is_none_or(|was| was.report.is_none()) {
            match &now.error {
                Some(error) => found.push(regression(now, "material", "missing", error)),
                None => failed_checks(&MaterialEntry::default(), now, &mut found),
            }
        }
    }
    let map = |report: &BuildReport| report.environment.as_ref().map(|entry| entry.maps.is_some());
    if let (Some(true), now @ (None | Some(false))) = (map(old), map(new)) {
        let error = new.environment.as_ref().and_then(|entry| entry.error.as_deref()).unwrap_or("not made");
        found.push(only(ENVIRONMENT, "maps", "made", if now.is_none() { "missing" } else { error }));
    }
    for now in &new.assets {
        let was = old.assets.iter().find(|was| was.asset == now.asset);
        regressions_of_asset(was, Some(now), tolerance, &mut found);
    }
    for was in old.assets.iter().filter(|was| new.assets.iter().all(|now| now.asset != was.asset)) {
        regressions_of_asset(Some(was), None, tolerance, &mut found);
    }
    for before in &old.materials {
        let now = in_new.get(&before.material).map(|number| &new.materials[*number]);
        match (before.report.as_ref(), now) {
            (Some(_), None) => found.push(regression(before, "material", "made", "missing")),
            (Some(was), Some(now)) => match &now.report {
                None => found.push(regression(before, "material", "made", now.error.as_deref().unwrap_or("not made"))),
                Some(is) => {
                    failed_checks(before, now, &mut found);
                    if let (Some(was), Some(is)) = (before.lobes_report(), now.lobes_report()) {
                        let [was, is] = [was, is].map(figures_of_lobes);
                        grown(
                            &before.material,
                            NEGLIGIBLE_OF_LOBES.into_iter().zip(was).zip(is),
                            tolerance,
                            &mut found,
                        );
                    }
                    // Every error of a black material is 0.
                    if is_black(is.off_grid.mean) && !is_black(was.off_grid.mean) {
                        found.push(regression(now, "material", "reflects light", "black"));
                        continue;
                    }
                    // Errors at other directions do not compare.
                    if was.directions != is.directions {
                        let [before, after] = [was, is].map(directions);
                        found.push(regression(now, "directions", &before, &after));
                        continue;
                    }
                    let all = NEGLIGIBLE.into_iter().zip(figures(was)).zip(figures(is));
                    grown(&before.material, all, tolerance, &mut found);
                }
            },
            (None, _) => {}
        }
    }
    found.sort_by(|a, b| {
        let growth = |regression: &Regression| regression.growth.unwrap_or(f64::INFINITY);
        growth(b).total_cmp(&growth(a)).then_with(|| a.material.cmp(&b.material))
    });
    found
}

fn directions(report: &MaterialReport) -> String {
    if report.directions.is_all() { "all".to_owned() } else { report.directions.to_string() }
}

fn only(material: &str, figure: &str, before: &str, now: &str) -> Regression {
    regression(&MaterialEntry { material: material.to_owned(), ..MaterialEntry::default() }, figure, before, now)
}

fn regression(entry: &MaterialEntry, figure: &str, before: &str, now: &str) -> Regression {
    Regression {
        material: entry.material.clone(),
        figure: figure.to_owned(),
        before: before.to_owned(),
        now: now.to_owned(),
        growth: None,
    }
}

/// Regressions of an asset that is no material.
fn regressions_of_asset(
    was: Option<&AssetEntry>,
    now: Option<&AssetEntry>,
    tolerance: f64,
    found: &mut Vec<Regression>,
) {
    let before = was.and_then(|was| was.report.as_ref());
    let Some(name) = now.or(was).map(|entry| entry.asset.as_str()) else { return };
    let Some((now, is)) = now.and_then(|now| Some((now, now.report.as_ref()?))) else {
        let error = now.and_then(|now| now.error.as_deref()).unwrap_or("missing");
        // An asset that failed before, too, has no figures to compare.
        if before.is_some() || was.is_none() {
            found.push(only(name, "asset", if before.is_some() { "made" } else { "missing" }, error));
        }
        return;
    };
    for gate in now.gates.iter().filter(|gate| !gate.passed) {
        let gates = was.map_or(&[][..], |was| &was.gates);
        let was = gates.iter().find(|other| other.gate == gate.gate && !other.passed);
        found.push(only(name, &gate.gate, was.map_or("passed", |was| &was.found), &gate.found));
    }
    if let Some(text) = &is.missed {
        let was = if before.is_some_and(|before| before.missed.is_some()) { "missed" } else { "met" };
        found.push(only(name, "limits", was, text));
    }
    if let Some(was) = before {
        if was.delta_e.is_some() != is.delta_e.is_some() {
            let [was, is] = [was, is].map(|report| report.delta_e.map_or("nothing to measure".to_owned(), number));
            found.push(only(name, NEGLIGIBLE_OF_ASSETS[0].0, &was, &is));
        }
        let (was_delta_e, delta_e) = was.delta_e.zip(is.delta_e).unwrap_or_default();
        let figures = |report: &AssetReport, delta_e| {
            [delta_e, report.bytes_on_gpu as f64, report.fetches.map_or(0.0, f64::from)]
        };
        let values = figures(was, was_delta_e).into_iter().zip(figures(is, delta_e));
        let all = NEGLIGIBLE_OF_ASSETS.into_iter().zip(values).map(|(figure, (was, is))| ((figure, was), is));
        grown(name, all, tolerance, found);
    }
}

fn failed_checks(before: &MaterialEntry, now: &MaterialEntry, found: &mut Vec<Regression>) {
    for gate in now.gates.iter().filter(|gate| !gate.passed) {
        let was = before.gates.iter().find(|other| other.gate == gate.gate && !other.passed);
        found.push(regression(now, &gate.gate, was.map_or("passed", |was| &was.found), &gate.found));
    }
    let missed = |entry: &MaterialEntry| entry.report.as_ref().and_then(|report| report.missed.clone());
    if let Some(text) = missed(now) {
        found.push(regression(now, "limits", if missed(before).is_some() { "missed" } else { "met" }, &text));
    }
    let missed = |entry: &MaterialEntry| entry.lobes_report().and_then(|lobes| lobes.missed.clone());
    if let Some(text) = missed(now) {
        let was = if missed(before).is_some() { "missed" } else { "met" };
        found.push(regression(now, "limits of lobes", was, &text));
    }
}

/// Adds the figures that grew. Each has its name, the largest difference that is never reported, and both values.
fn grown(
    material: &str,
    figures: impl Iterator<Item = (((&'static str, f64), f64), f64)>,
    tolerance: f64,
    found: &mut Vec<Regression>,
) {
    for (((figure, smallest), before), now) in figures {
        // NaN is worse than any number.
        let within = now <= before * (1.0 + tolerance) || now - before <= smallest;
        if !(within || now.is_nan() && before.is_nan()) {
            let growth = if before > 0.0 { now / before - 1.0 } else { f64::INFINITY };
            found.push(Regression {
                material: material.to_owned(),
                figure: figure.to_owned(),
                before: number(before),
                now: number(now),
                growth: Some(growth).filter(|growth| growth.is_finite()),
            });
        }
    }
}

fn number(value: f64) -> String {
    if value.fract() == 0.0 { value.to_string() } else { format!("{value:.4}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::PackRecipe;
    use crate::encode::encode;
    use crate::report::gate::GateResult;
    use crate::scene::maps::MapsReport;
    use brdfc_lobes::{LobesFacts, RenderingError};
    use brdfc_source::open::open;

    fn build() -> BuildReport {
        let opened = open("synth:ggx?alpha=0.4", None).unwrap();
        let made = encode(opened.source.as_ref(), &PackRecipe::default(), &()).unwrap();
        let report = Some(MaterialReport::new(&made, &opened, &()).unwrap());
        let entry =
            |name: &str| MaterialEntry { material: name.to_owned(), report: report.clone(), ..Default::default() };
        let materials = vec![entry("a"), entry("b")];
        BuildReport {
            version: crate::report::build::BUILD_VERSION,
            scene: "s".into(),
            materials,
            assets: Vec::new(),
            environment: None,
            skipped: Vec::new(),
            needs: Vec::new(),
            checksum: None,
        }
    }

    fn changed(change: impl Fn(&mut MaterialEntry)) -> Vec<String> {
        let (old, mut new) = (build(), build());
        change(&mut new.materials[1]);
        regressions(&new, &old, 0.02).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn the_same_and_the_better_are_no_regressions() {
        assert!(changed(|_| {}).is_empty());
        assert!(changed(|entry| entry.report.as_mut().unwrap().bytes_on_gpu -= 1).is_empty());
        assert!(changed(|entry| entry.report.as_mut().unwrap().off_grid.rendering.delta_e.mean *= 1.019).is_empty());
        // A growth by a third that is invisible.
        let (mut old, mut new) = (build(), build());
        for (report, mean) in [(&mut old, 0.0042), (&mut new, 0.0057)] {
            report.materials[1].report.as_mut().unwrap().off_grid.rendering.delta_e.mean = mean;
        }
        assert!(regressions(&new, &old, 0.02).is_empty());
    }

    #[test]
    fn missed_limits_are_reported_even_if_missed_before() {
        let mut both = build();
        both.materials[1].report.as_mut().unwrap().missed = Some("nothing meets it".into());
        both.materials[0].gates = vec![GateResult::new("require.max_bytes", "2".to_owned(), "1".to_owned(), false)];
        let found: Vec<String> = regressions(&both, &both, 0.02).iter().map(ToString::to_string).collect();
        assert_eq!(found, ["a: require.max_bytes: now 2; before 2", "b: limits: now nothing meets it; before missed"]);
    }

    #[test]
    fn regressions_are_reported() {
        let found = changed(|entry| entry.report.as_mut().unwrap().off_grid.rendering.delta_e.mean += 0.5);
        assert!(found.len() == 1 && found[0].starts_with("b: mean ΔE: now 0.") && found[0].contains("; before 0."));
        let found = changed(|entry| entry.report.as_mut().unwrap().off_grid.norms.relative_mean = f64::NAN);
        assert!(found.len() == 1 && found[0].contains("ε_r: now NaN; before "), "{found:?}");
        let found = changed(|entry| (entry.report, entry.error) = (None, Some("it broke".into())));
        assert_eq!(found, ["b: material: now it broke; before made"]);
        let found = changed(|entry| entry.gates.push(GateResult::new("require.max_bytes", "9", "8", false)));
        assert_eq!(found, ["b: require.max_bytes: now 9; before passed"]);
        let found = changed(|entry| entry.report.as_mut().unwrap().missed = Some("nothing meets it".into()));
        assert_eq!(found, ["b: limits: now nothing meets it; before met"]);
        // A limit of lobes, and a larger error of lobes.
        let of_lobes = |mean: f64, missed: Option<&str>| MapsReport {
            lobes: Some(LobesReport {
                bytes_on_disk: 1000,
                facts: LobesFacts {
                    fetches: 2,
                    anchors: [0, 2, 0],
                    nodes: 24,
                    azimuths: 1,
                    gpu_bytes: 384,
                    delta_e: RenderingError { mean, p95: 2.0 },
                },
                missed: missed.map(str::to_owned),
            }),
            ..MapsReport::default()
        };
        let compared = |now: MapsReport| {
            let [mut old, mut new] = [build(), build()];
            old.materials[1].maps = Some(of_lobes(0.5, None));
            new.materials[1].maps = Some(now);
            regressions(&new, &old, 0.02).iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert!(compared(of_lobes(0.5, None)).is_empty());
        assert_eq!(compared(of_lobes(0.75, None)), ["b: mean ΔE of lobes: now 0.7500; before 0.5000 (+50.0 %)"]);
        assert_eq!(compared(of_lobes(0.5, Some("too far"))), ["b: limits of lobes: now too far; before met"]);
        let found = changed(|entry| entry.material = "c".into());
        assert_eq!(found, ["b: material: now missing; before made"]);
    }

    /// New materials that fail are reported, too, and so is an earlier build without packs.
    #[test]
    fn nothing_passes_by_being_absent() {
        let (new, old) = (build(), build());
        let nothing = BuildReport { materials: Vec::new(), ..build() };
        let found = regressions(&new, &nothing, 0.02);
        assert!(found.iter().any(|worse| worse.now == "nothing to compare with"), "{found:?}");
        let mut failed = old.clone();
        failed.materials.iter_mut().for_each(|entry| entry.report = None);
        assert!(!regressions(&new, &failed, 0.02).is_empty());

        let mut more = new.clone();
        let broken = MaterialEntry { material: "zzz".into(), error: Some("gone".into()), ..MaterialEntry::default() };
        more.materials.push(broken);
        let found = regressions(&more, &old, 0.02);
        assert!(found.len() == 1 && found[0].material == "zzz" && found[0].now == "gone", "{found:?}");
        let mut missed = new.clone();
        let mut entry = missed.materials[0].clone();
        entry.material = "zzz".into();
        entry.gates = vec![GateResult::new("require.max_bytes", "2".to_owned(), "1".to_owned(), false)];
        missed.materials.push(entry);
        assert_eq!(regressions(&missed, &old, 0.02)[0].material, "zzz");

        // Errors at other directions do not compare.
        let mut narrow = new.clone();
        narrow.materials[0].report.as_mut().unwrap().directions.view.from = 45.0;
        let found = regressions(&narrow, &old, 0.02);
        assert!(found.len() == 1 && found[0].figure == "directions" && found[0].before == "all", "{found:?}");
    }
}
