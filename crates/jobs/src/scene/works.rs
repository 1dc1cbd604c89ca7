//! Distributed builds: each part of each material is a work item that any machine can make and store. A build that
//! finds all items in its store only puts the files in place.

use super::assets::AssetJob;
use super::error::JobError;
use super::lobes::LOBES;
use super::memory::Shared;
use super::plan::{EnvironmentJob, Job, Plan};
use super::run::{BuildContext, PACK, RequestedParts, in_turn};
use super::scene_section::ENVIRONMENT;
use brdfc_core::progress::Progress;
use std::path::Path;
use std::str::FromStr;

/// Name of the maps for adaptive shading among the parts of a material.
const MAPS: &str = "maps";

/// A work item of a build: the smallest part of its work that a machine can take.
#[derive(Debug, Clone, Copy)]
pub enum Work<'a> {
    /// The pack of a material.
    Pack(&'a Job),
    /// The lobes of a material.
    Lobes(&'a Job),
    /// The maps of a material for adaptive shading.
    Maps(&'a Job),
    /// The maps of the environment.
    Environment(&'a EnvironmentJob),
    /// The pack of an asset that is no material.
    Asset(&'a AssetJob),
}

impl Work<'_> {
    /// Name of the item: `MATERIAL.brdf`, `MATERIAL.lobes`, `MATERIAL.maps`, `ASSET.pwt`, `ASSET.environment` or `environment.maps`.
    pub fn name(&self) -> String {
        match self {
            Self::Pack(job) => format!("{}.{PACK}", job.name),
            Self::Lobes(job) => format!("{}.{LOBES}", job.name),
            Self::Maps(job) => format!("{}.{MAPS}", job.name),
            Self::Environment(_) => format!("{ENVIRONMENT}.{MAPS}"),
            Self::Asset(job) => format!("{}.{}", job.name, self.part()),
        }
    }

    /// Paths of the files that it reads, or the address of its source.
    pub fn sources(&self) -> Vec<String> {
        let of_path = |path: &Path| path.display().to_string();
        match self {
            Self::Pack(job) | Self::Lobes(job) => vec![job.input.to_string()],
            Self::Maps(job) => {
                let texture = job.texture.iter().map(|texture| of_path(&texture.path));
                [job.input.to_string()].into_iter().chain(texture).collect()
            }
            Self::Environment(job) => vec![of_path(&job.path)],
            Self::Asset(job) => job.files.iter().map(|path| of_path(path)).collect(),
        }
    }

    /// Name of the material or of the asset; `None` for the environment.
    pub fn material(&self) -> Option<&str> {
        match self {
            Self::Pack(job) | Self::Lobes(job) | Self::Maps(job) => Some(&job.name),
            Self::Asset(job) => Some(&job.name),
            Self::Environment(_) => None,
        }
    }

    /// Name of the part.
    pub fn part(&self) -> &'static str {
        match self {
            Self::Pack(_) => PACK,
            Self::Lobes(_) => LOBES,
            Self::Maps(_) | Self::Environment(_) => MAPS,
            Self::Asset(job) => job.kind.pack().name(),
        }
    }
}

impl Plan {
    /// All work items, in an order that depends only on the plan. Materials with the same source and recipe share
    /// their items.
    pub fn works(&self) -> Vec<Work<'_>> {
        let mut works: Vec<Work<'_>> = self.environment.iter().map(Work::Environment).collect();
        for (number, job) in self.jobs.iter().enumerate() {
            if self.jobs[..number].iter().any(|other| other.is_same_work(job)) {
                continue;
            }
            works.push(Work::Pack(job));
            works.extend(job.lobes.map(|_| Work::Lobes(job)));
            works.extend(job.has_maps().then_some(Work::Maps(job)));
        }
        works.extend(self.assets.iter().map(Work::Asset));
        works
    }
}

/// One of several equal shares of the work items of a build.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub number: usize,
    /// Number of shards, at least 1.
    pub count: usize,
}

impl Shard {
    /// Selects the items of this shard: every `count`-th.
    pub fn of<'a>(self, works: Vec<Work<'a>>) -> Vec<Work<'a>> {
        works.into_iter().skip(self.number - 1).step_by(self.count).collect()
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once('/').and_then(|(number, count)| {
            let shard = Self { number: number.parse().ok()?, count: count.parse().ok()? };
            (1 <= shard.number && shard.number <= shard.count).then_some(shard)
        });
        parsed.ok_or_else(|| "expected I/N with I from 1 to N, such as 2/8".to_owned())
    }
}

/// Result of a work item: true if it was made, false if it was in the store.
pub type WorkResult = Result<bool, JobError>;

/// Makes work items and stores them. An item that fails does not stop the others.
pub fn make(works: &[Work<'_>], context: &BuildContext<'_>, progress: &dyn Progress) -> Vec<WorkResult> {
    let shared = Shared::new(context.memory);
    in_turn(works.len(), |number| {
        let work = works[number];
        let name = work.name();
        let part = progress.part(&name);
        let result = match work {
            Work::Pack(job) => context.made_part(job, RequestedParts::PACK, &shared, part.as_ref()),
            Work::Lobes(job) => context.made_part(job, RequestedParts::LOBES, &shared, part.as_ref()),
            Work::Maps(job) => context.made_part(job, RequestedParts::MAPS, &shared, part.as_ref()),
            Work::Environment(job) => context.environment(job, &shared, part.as_ref()).map(|made| made.times.is_some()),
            Work::Asset(job) => context.asset(job, &shared, part.as_ref()).map(|made| made.times.is_some()),
        };
        part.finished(result.is_ok());
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::manifest::Manifest;
    use crate::scene::plan::plan;
    use std::path::Path;

    fn planned() -> Plan {
        let text = "[scene]\nenvironment='sky.exr'\n[materials.a]\nsource='a.brdf'\n[materials.b]\nsource='b.brdf'\n\
                    [materials.twin]\nsource='a.brdf'\n[[uses]]\nmaterial='a'\n[[uses]]\nmaterial='b'\n\
                    maps=['lobes','samples']\n[[uses]]\nmaterial='twin'\n";
        plan(&Manifest::parse(text).unwrap(), Path::new("")).unwrap()
    }

    #[test]
    fn every_item_is_in_one_shard() {
        let plan = planned();
        let names = |works: Vec<Work<'_>>| works.iter().map(Work::name).collect::<Vec<_>>();
        let all = names(plan.works());
        assert_eq!(all, ["environment.maps", "a.brdf", "a.lobes", "b.brdf", "b.lobes", "b.maps"]);
        for count in 1..8 {
            let mut shared: Vec<String> =
                (1..=count).flat_map(|number| names(Shard { number, count }.of(plan.works()))).collect();
            shared.sort_by_key(|name| all.iter().position(|other| other == name));
            assert_eq!(shared, all, "{count} shards");
        }
    }

    #[test]
    fn shards_as_people_write_them() {
        assert_eq!("2/8".parse(), Ok(Shard { number: 2, count: 8 }));
        for text in ["0/2", "3/2", "1/0", "1", "a/b", "-1/2", ""] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
