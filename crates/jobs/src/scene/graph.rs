//! A build as a graph of jobs, for engines that run such graphs: one job per material and part, and one at the end that puts
//! all in place.

use super::plan::Plan;
use crate::store::{DONE, FOLDER};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The graph.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Graph {
    /// Layout of this report.
    pub version: u32,
    /// Jobs that do not depend on each other.
    pub jobs: Vec<GraphJob>,
    /// What comes when all of them are done.
    pub merge: MergeJob,
}

/// One job.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct GraphJob {
    /// Its name: material and part.
    pub name: String,
    /// The material; absent for the environment.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// `brdf` is the pack, `maps` are bandwidth map and samples.
    pub part: String,
    /// Files that it reads.
    pub inputs: Vec<String>,
    /// Program and arguments.
    pub command: Vec<String>,
    /// The file that it writes when it is done.
    pub stamp: String,
}

/// The last job.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MergeJob {
    /// Program and arguments.
    pub command: Vec<String>,
    /// The file that it writes when it is done.
    pub stamp: String,
    /// What it puts into the output folder: packs, maps and what is said of them. It leaves alone what is there unchanged.
    pub outputs: Vec<String>,
}

/// Where what is built comes from and goes to, as commands name it.
#[derive(Debug, Clone)]
pub struct Places {
    /// The program.
    pub program: String,
    /// The manifest, or files and folders.
    pub inputs: Vec<String>,
    /// The manifest, if there is one: a file that all jobs read.
    pub manifest: Option<PathBuf>,
    /// The output folder.
    pub out: PathBuf,
}

impl Graph {
    /// Of a plan.
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
            let source = Some(work.source()).filter(|source| Path::new(source).exists());
            GraphJob {
                material: work.material().map(str::to_owned),
                part: work.part().to_owned(),
                inputs: manifest.clone().into_iter().chain(source).collect(),
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

    /// As a file for ninja.
    pub fn ninja(&self) -> String {
        let mut text = "ninja_required_version = 1.3\n\n\
                        rule job\n  command = $job\n  description = $name\n\n\
                        # What is unchanged keeps its time.\n\
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

/// Arguments for a shell.
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
