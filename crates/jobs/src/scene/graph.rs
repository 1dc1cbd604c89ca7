//! A build as a job graph for build systems and render farms: one job per material and part, and a final job that
//! puts all files in place.

use super::plan::Plan;
use crate::store::{DONE, FOLDER};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Graph of the jobs of a build, for build systems such as Ninja.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Graph {
    /// Layout version of this report.
    pub version: u32,
    /// Jobs that make parts of materials, in any order or at once.
    pub jobs: Vec<GraphJob>,
    /// The final job, which depends on all others.
    pub merge: MergeJob,
}

/// A job of the graph.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GraphJob {
    /// Name of the job: material and part.
    pub name: String,
    /// Name of the material or of another asset; absent for the environment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Part that the job makes: `brdf` is the pack, `lobes` are the lobes, `maps` are the bandwidth map and the samples, or the
    /// maps of the environment; `pwt` and `environment` are packs of other assets.
    pub part: String,
    /// Paths of the files that the job reads: the manifest, the source and a texture.
    pub inputs: Vec<String>,
    /// Command line: the program, then its arguments.
    pub command: Vec<String>,
    /// Stamp file, which the job writes on success.
    pub stamp: String,
}

/// The job that runs last and fills the output folder.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MergeJob {
    /// Command line: the program, then its arguments.
    pub command: Vec<String>,
    /// Stamp file, which the job writes on success.
    pub stamp: String,
    /// Files that it puts into the output folder: packs, maps and reports. It does not rewrite unchanged files.
    pub outputs: Vec<String>,
}

/// Program, inputs and output folder, as they appear in the commands.
#[derive(Debug, Clone)]
pub struct Places {
    /// Name or path of the program `brdfc`.
    pub program: String,
    /// The manifest, or files and folders.
    pub inputs: Vec<String>,
    /// The manifest, which all jobs read; `None` without one.
    pub manifest: Option<PathBuf>,
    /// Path of the output folder.
    pub out: PathBuf,
}

impl Graph {
    /// Creates the graph of a plan.
    pub fn new(plan: &Plan, places: &Places) -> Self {
        let stamp = |name: &str| places.out.join(FOLDER).join(DONE).join(name).display().to_string();
        let build = |more: &[&str]| {
            let mut command = vec![places.program.clone(), "build".to_owned()];
            command.extend(places.inputs.iter().cloned());
            command.extend(["--out".to_owned(), places.out.display().to_string()]);
            command.extend(more.iter().map(|argument| (*argument).to_owned()));
            command
        };
        let manifest = places.manifest.as_ref().map(|path| path.display().to_string());
        let jobs = plan.works().into_iter().map(|work| {
            let name = work.name();
            let sources = work.sources().into_iter().filter(|source| Path::new(source).exists());
            GraphJob {
                material: work.material().map(str::to_owned),
                part: work.part().to_owned(),
                inputs: manifest.clone().into_iter().chain(sources).collect(),
                command: build(&["--only", &name, "--stamp", &stamp(&name), "--quiet"]),
                stamp: stamp(&name),
                name,
            }
        });
        let merge = MergeJob {
            command: build(&["--stamp", &stamp("all"), "--quiet"]),
            stamp: stamp("all"),
            outputs: plan.files().map(|name| places.out.join(name).display().to_string()).collect(),
        };
        Self { version: 1, jobs: jobs.collect(), merge }
    }

    /// Formats the graph as a Ninja build file.
    pub fn ninja(&self) -> String {
        let mut text = "ninja_required_version = 1.3\n\n\
                        rule job\n  command = $job\n  description = $name\n\n\
                        # Unchanged outputs keep their times.\n\
                        rule merge\n  command = $job\n  description = merge\n  restat = 1\n\n"
            .to_owned();
        for job in &self.jobs {
            let inputs: String = job.inputs.iter().map(|path| format!(" {}", path_of_ninja(path))).collect();
            text += &format!("build {}: job{inputs}\n", path_of_ninja(&job.stamp));
            text += &format!("  job = {}\n  name = {}\n", command(&job.command), value(&job.name));
        }
        let stamps: String = self.jobs.iter().map(|job| format!(" {}", path_of_ninja(&job.stamp))).collect();
        let outputs: String = self.merge.outputs.iter().map(|path| format!(" {}", path_of_ninja(path))).collect();
        text += &format!("build {} |{outputs}: merge{stamps}\n", path_of_ninja(&self.merge.stamp));
        text += &format!("  job = {}\n", command(&self.merge.command));
        text + &format!("\ndefault {}\n", path_of_ninja(&self.merge.stamp))
    }
}

fn value(text: &str) -> String {
    text.replace('$', "$$").replace('\n', " ")
}

fn path_of_ninja(path: &str) -> String {
    value(path).replace(' ', "$ ").replace(':', "$:")
}

/// Formats a command line for a shell, inside a Ninja value.
fn command(arguments: &[String]) -> String {
    let quoted = |argument: &String| {
        let plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:@%+".contains(c);
        if !argument.is_empty() && argument.chars().all(plain) {
            argument.clone()
        } else {
            format!("'{}'", argument.replace('\'', "'\\''"))
        }
    };
    value(&arguments.iter().map(quoted).collect::<Vec<_>>().join(" "))
}
