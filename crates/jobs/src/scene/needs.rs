//! Needs: what the scene asks of each material. Everything outside is not computed and not written.

use super::manifest::Manifest;
use brdfc_formats::wavelet::level_of_detail;
use std::collections::BTreeMap;

/// What one material is needed for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Needs {
    /// Uses that refer to it, at least 1.
    pub uses: usize,
    /// Nearest distance at which any of them is seen, 0 or more.
    pub nearest: f64,
    /// Whether an environment lights it: then how fast its lobes vary, and samples of them, are needed too. Point lights
    /// need neither.
    pub maps: bool,
}

impl Needs {
    /// Finest level of detail that is ever asked for, of `levels`: [`level_of_detail`] at the nearest use, rounded up.
    pub fn stored_levels(&self, levels: u32, distance_scale: f64) -> u32 {
        level_of_detail(levels, self.nearest, distance_scale).ceil() as u32
    }
}

/// The environment whose map the scene needs: the one that lights it, if it lights anything.
pub fn environment(manifest: &Manifest) -> Option<&str> {
    manifest.scene.environment.as_deref().filter(|_| !manifest.uses.is_empty())
}

/// The needs of every material that is used, by name.
pub fn needs(manifest: &Manifest) -> BTreeMap<&str, Needs> {
    let maps = environment(manifest).is_some();
    let mut all: BTreeMap<&str, Needs> = BTreeMap::new();
    for used in &manifest.uses {
        let nearest = used.nearest.as_ref().map_or(0.0, |distance| *distance.get_ref());
        let entry = all.entry(used.material.get_ref()).or_insert(Needs { uses: 0, nearest, maps });
        entry.uses += 1;
        entry.nearest = entry.nearest.min(nearest);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_takes_levels_away() {
        let stored = |nearest| Needs { uses: 1, nearest, maps: false }.stored_levels(5, 0.15);
        assert_eq!(stored(0.0), 5);
        assert_eq!(stored(6.0), 5, "log2(0.9) is clamped at 0");
        assert_eq!(stored(14.0), 4, "2.1 is just over one level");
        assert_eq!(stored(13.0), 5, "1.95 is not");
        assert_eq!(stored(1e9), 0);
    }

    #[test]
    fn the_nearest_use_counts_and_unused_materials_have_no_needs() {
        let manifest = Manifest::parse(
            "[materials.a]\nsource='x'\n[materials.b]\nsource='y'\n\
             [[uses]]\nmaterial='a'\nnearest=20\n[[uses]]\nmaterial='a'\nnearest=7\n",
        )
        .unwrap();
        let all = needs(&manifest);
        assert_eq!(all.len(), 1);
        assert_eq!(all["a"], Needs { uses: 2, nearest: 7.0, maps: false });
    }

    #[test]
    fn maps_are_needed_where_an_environment_lights_something() {
        let materials = "[materials.a]\nsource='x'\n[materials.b]\nsource='y'\n";
        let parse = |text: &str| Manifest::parse(text).unwrap();
        let used = format!("{materials}[[uses]]\nmaterial='a'\n");
        let lit = parse(&format!("[scene]\nenvironment='sky.exr'\n{used}"));
        assert_eq!(environment(&lit), Some("sky.exr"));
        assert!(needs(&lit).len() == 1 && needs(&lit)["a"].maps);
        // What mirrors show is no light.
        for other in [used.clone(), format!("{used}[render]\nenvironment='sky.exr'\n")] {
            let manifest = parse(&other);
            assert!(environment(&manifest).is_none() && !needs(&manifest)["a"].maps, "{other}");
        }
        let empty = parse(&format!("[scene]\nenvironment='sky.exr'\n{materials}"));
        assert!(environment(&empty).is_none() && needs(&empty).is_empty());
    }
}
