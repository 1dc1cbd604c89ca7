//! Needs of a scene: the levels of detail, directions, lobes and maps of each material that its uses can show. `brdfc`
//! builds only these.

use super::manifest::Manifest;
use super::maps::RequestedMaps;
use super::uses::Use;
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::wavelet::level_of_detail;
use std::collections::BTreeMap;

/// Needs of one material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// Number of uses, at least 1.
    pub uses: usize,
    /// Nearest distance of all uses, 0 or more.
    pub nearest: f64,
    /// Farthest distance of all uses; infinite if any has no limit.
    pub farthest: f64,
    /// Smallest range that contains the directions of all uses.
    pub directions: DirectionRange,
    /// True if an environment lights it. Point lights need no maps.
    pub lit_by_environment: bool,
    /// True if it needs lobes.
    pub lobes: bool,
    /// True if it needs a bandwidth map.
    pub bandwidth: bool,
    /// True if it needs importance samples.
    pub samples: bool,
    /// True if it needs the bandwidth map of its texture.
    pub texture: bool,
}

impl Needs {
    /// Finest level of detail that any use needs, of `levels`: [`level_of_detail`] at the nearest distance, rounded up.
    pub fn stored_levels(&self, levels: u32, distance_scale: f64) -> u32 {
        level_of_detail(levels, self.nearest, distance_scale).ceil() as u32
    }

    /// Number of levels below the finest that any use needs: `log2(α d)` at the farthest distance, rounded up.
    pub fn coarser_levels(&self, distance_scale: f64) -> u32 {
        let below = (distance_scale * self.farthest).log2().max(0.0).ceil();
        if below < f64::from(u32::MAX) { below as u32 } else { u32::MAX }
    }

    fn of(used: &Use, has_environment: bool) -> Self {
        let distance = |distance: &Option<toml::Spanned<f64>>| distance.as_ref().map(|distance| *distance.get_ref());
        let lit_by_environment = has_environment && used.is_lit_by_environment();
        let [lobes, bandwidth, samples] = used.requested_maps().map(|requested| requested && lit_by_environment);
        Self {
            uses: 1,
            nearest: distance(&used.nearest).unwrap_or(0.0),
            farthest: distance(&used.farthest).unwrap_or(f64::INFINITY),
            directions: DirectionRange { light: used.light(), view: used.view() },
            lit_by_environment,
            lobes,
            bandwidth,
            samples,
            texture: bandwidth && used.texture.is_some(),
        }
    }

    /// Union of two needs.
    fn with(self, other: Self) -> Self {
        Self {
            uses: self.uses + other.uses,
            nearest: self.nearest.min(other.nearest),
            farthest: self.farthest.max(other.farthest),
            directions: self.directions.with(other.directions),
            lit_by_environment: self.lit_by_environment || other.lit_by_environment,
            lobes: self.lobes || other.lobes,
            bandwidth: self.bandwidth || other.bandwidth,
            samples: self.samples || other.samples,
            texture: self.texture || other.texture,
        }
    }
}

/// The environment of the scene and its maps, if any use needs one: prefiltered light for lobes, and a bandwidth map next to
/// those of materials.
pub fn environment<'a>(manifest: &'a Manifest, needs: &BTreeMap<&str, Needs>) -> Option<(&'a str, RequestedMaps)> {
    let environment = manifest.scene.environment.as_deref()?;
    let maps = [needs.values().any(|needs| needs.lobes), needs.values().any(|needs| needs.bandwidth)];
    (maps != [false; 2]).then_some((environment, maps))
}

/// The needs of all materials that have uses, by name.
pub fn needs(manifest: &Manifest) -> BTreeMap<&str, Needs> {
    let has_environment = manifest.scene.environment.is_some();
    let mut all: BTreeMap<&str, Needs> = BTreeMap::new();
    for used in &manifest.uses {
        let needs = Needs::of(used, has_environment);
        all.entry(used.material.get_ref()).and_modify(|entry| *entry = entry.with(needs)).or_insert(needs);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_formats::crop::Elevations;

    fn parse(text: &str) -> Manifest {
        Manifest::parse(text).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn distance_limits_levels() {
        let at = |nearest: f64, farthest: f64| {
            let text = format!(
                "[materials.a]\nsource='x'\n[[uses]]\nmaterial='a'\nnearest={nearest:?}\nfarthest={farthest:?}\n"
            );
            needs(&parse(&text))["a"]
        };
        let stored = |nearest| at(nearest, 1e12).stored_levels(5, 0.15);
        assert_eq!(stored(0.0), 5);
        assert_eq!(stored(6.0), 5, "log2(0.9) is clamped at 0");
        assert_eq!(stored(14.0), 4, "2.1 is just over one level");
        assert_eq!(stored(13.0), 5, "1.95 is not");
        assert_eq!(stored(1e9), 0);
        let coarser = |farthest| at(0.0, farthest).coarser_levels(0.15);
        assert_eq!(coarser(6.0), 0);
        assert_eq!(coarser(13.0), 1);
        assert_eq!(coarser(14.0), 2);
        assert_eq!(
            needs(&parse("[materials.a]\nsource='x'\n[[uses]]\nmaterial='a'\n"))["a"].coarser_levels(0.15),
            u32::MAX
        );
    }

    #[test]
    fn the_nearest_use_counts_and_unused_materials_have_no_needs() {
        let manifest = parse(
            "[materials.a]\nsource='x'\n[materials.b]\nsource='y'\n\
             [[uses]]\nmaterial='a'\nnearest=20\nfarthest=30\nview_elevation=[10,30]\n\
             [[uses]]\nmaterial='a'\nnearest=7\nfarthest=9\nview_elevation=[50,60]\nlight_elevation=[0,45]\n",
        );
        let all = needs(&manifest);
        assert_eq!(all.len(), 1);
        let needs = all["a"];
        assert_eq!((needs.uses, needs.nearest, needs.farthest), (2, 7.0, 30.0));
        let directions = DirectionRange { light: Elevations::ALL, view: Elevations { from: 10.0, to: 60.0 } };
        assert_eq!(needs.directions, directions, "a use without light_elevation has all");
    }

    #[test]
    fn maps_are_needed_if_an_environment_lights_a_use() {
        let materials = "[materials.a]\nsource='x'\n[materials.b]\nsource='y'\n";
        let used = format!("{materials}[[uses]]\nmaterial='a'\n");
        let lit = parse(&format!("[scene]\nenvironment='sky.exr'\n{used}"));
        assert_eq!(environment(&lit, &needs(&lit)), Some(("sky.exr", [true, false])));
        let needed = needs(&lit)["a"];
        assert!(needs(&lit).len() == 1 && needed.lobes && !needed.bandwidth && !needed.samples);
        // The environment that mirrors reflect does not light the scene.
        for other in [used.clone(), format!("{used}[render]\nenvironment='sky.exr'\n")] {
            let manifest = parse(&other);
            assert!(environment(&manifest, &needs(&manifest)).is_none() && !needs(&manifest)["a"].lobes, "{other}");
        }
        let empty = parse(&format!("[scene]\nenvironment='sky.exr'\n{materials}"));
        assert!(environment(&empty, &needs(&empty)).is_none() && needs(&empty).is_empty());
    }

    #[test]
    fn uses_have_lighting_and_maps() {
        let lit = |rest: &str| {
            let text =
                format!("[scene]\nenvironment='sky.exr'\n[materials.a]\nsource='x'\n[[uses]]\nmaterial='a'\n{rest}");
            let manifest = parse(&text);
            let all = needs(&manifest);
            let Needs { lit_by_environment, lobes, bandwidth, samples, .. } = all["a"];
            ([lit_by_environment, lobes, bandwidth, samples], environment(&manifest, &all).map(|(_, maps)| maps))
        };
        assert_eq!(lit("lighting=['points']\n"), ([false; 4], None));
        assert_eq!(lit("lighting=['points','environment']\n"), ([true, true, false, false], Some([true, false])));
        assert_eq!(
            lit("maps=['samples']\n"),
            ([true, false, false, true], None),
            "samples alone need no environment's map"
        );
        assert_eq!(lit("maps=[]\n"), ([true, false, false, false], None));
        let all = "maps=['bandwidth','samples','lobes']\n";
        assert_eq!(lit(all), ([true; 4], Some([true; 2])));
        let both = "lighting=['points']\n[[uses]]\nmaterial='a'\nmaps=['bandwidth']\n";
        assert_eq!(lit(both), ([true, false, true, false], Some([false, true])));
    }

    #[test]
    fn invalid_needs_are_rejected() {
        let error = |rest: &str| {
            let text = format!("[materials.a]\nsource='x'\n[[uses]]\nmaterial='a'\n{rest}\n");
            Manifest::parse(&text).expect_err(rest).to_string()
        };
        for (rest, expected) in [
            ("nearest=-1", "line 5, uses[0].nearest: found -1, expected a distance, 0 or more"),
            ("nearest=4\nfarthest=3", "line 6, uses[0].farthest: found 3, expected at least 4, the value of nearest"),
            ("view_elevation=[30, 20]", "uses[0].view_elevation: found [30, 20], expected [from, to], 0 to 90"),
            ("light_elevation=[0, 91]", "uses[0].light_elevation: found [0, 91]"),
            ("light_elevation=[10, 12]", "5 apart or more"),
            ("light_elevation=[10]", "uses[0].light_elevation"),
            ("lighting=['sun']", "uses[0].lighting: found \"sun\", expected points or environment"),
            ("lighting=[]", "uses[0].lighting: found [], expected one or both"),
            ("lighting=['environment']", "the scene has no environment"),
            ("maps=['samples']", "uses[0].maps: needs an environment"),
        ] {
            let found = error(rest);
            assert!(found.contains(expected), "{found}");
        }
        let text = "[scene]\nenvironment='sky.exr'\n[materials.a]\nsource='x'\n[[uses]]\nmaterial='a'\nlight_elevation=[0,30]\n";
        let found = Manifest::parse(text).expect_err("an environment").to_string();
        assert!(found.contains("an environment, which lights from all directions"), "{found}");
    }
}
