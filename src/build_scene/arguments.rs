//! Flags of `brdfc build`.

use crate::CliError;
use crate::interrupt::Interrupt;
use crate::output::{make_folder, write_file};
use brdfc_jobs::encode::bytes_from_text;
use brdfc_jobs::encode::options::EncodeOptions;
use brdfc_jobs::scene::build::BuildSettings;
use brdfc_jobs::scene::memory;
use brdfc_jobs::scene::works::Shard;
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Where packs go if nothing is said.
pub(crate) const DEFAULT_FOLDER: &str = "packs";
/// Less is not enough for one material.
const LEAST_MEMORY: u64 = 64 << 20;

/// Make the packs that a scene needs, or those of a folder of measured materials.
///
/// A manifest names materials and the uses that a scene makes of them; docs/scene.md lists its keys. A material that no
/// use refers to is not even opened. Of folders, files and patterns each material is made, named after its file.
///
/// What was made before of the same source by the same options is kept. One material that fails does not stop the
/// others. The output folder changes at the end, all at once, and then holds what report.json says, besides what
/// others put there. An encoding option wins over the defaults of a manifest, not over what a material says of itself.
///
/// Where the manifest names an environment that lights the scene (the key `environment` of `scene`), the maps of adaptive shading are
/// made too: how fast each material's lobes and the environment vary, and importance samples of the lobes.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc build scene.toml
  brdfc build scans --out packs
  brdfc build scans/*.binary paint.brdf --max-delta-e 1
  brdfc build scene.toml --out assets/packs --jobs 4 --json > report.json
  brdfc build scene.toml --shard 2/8 --out part-2
  brdfc build scene.toml --from part-1 --from part-2
  brdfc build scene.toml --dry-run --explain")]
pub struct Arguments {
    #[command(flatten)]
    pub(super) build: BuildArguments,
    /// Say what would be done and how large packs would be, and do nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Say what is needed of each material, which uses ask for it, and what that saves.
    #[arg(long)]
    pub(super) explain: bool,
    /// Make every pack again.
    #[arg(long)]
    pub(super) no_cache: bool,
    /// Stop at the first material that fails or misses a limit, and leave the folder as it was.
    #[arg(long)]
    pub(super) fail_fast: bool,
    /// Make share I of N of the parts alone, and keep it in the store of the output folder, for a build that puts all in place.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["only", "dry_run"])]
    pub(super) shard: Option<Shard>,
    /// Make one part alone, likewise: MATERIAL.brdf, MATERIAL.maps or environment.maps ('brdfc plan' lists them).
    #[arg(long, value_name = "PART", conflicts_with = "dry_run")]
    pub(super) only: Vec<String>,
    /// Take what was made by another build from its folder, such as that of another machine.
    #[arg(long, value_name = "DIR")]
    pub(super) from: Vec<PathBuf>,
    /// Write this empty file when all is done and well.
    #[arg(long, value_name = "FILE")]
    pub(super) stamp: Option<PathBuf>,
    /// Write the files that the report depends on, as a rule for make or ninja.
    #[arg(long, value_name = "FILE")]
    pub(super) depfile: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Encoding")]
    pub(super) options: EncodeOptions,
}

/// What every command asks for that builds.
#[derive(Debug, Args)]
pub(crate) struct BuildArguments {
    /// A scene manifest; or files, folders and patterns of measured materials, and synth: addresses.
    #[arg(value_name = "SCENE.toml|DIR|FILE", required = true)]
    pub(crate) inputs: Vec<OsString>,
    /// Folder for packs and reports.
    #[arg(long, short, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    pub(crate) out: PathBuf,
    /// Leave files of earlier builds in the folder that this one does not need.
    #[arg(long)]
    keep: bool,
    /// Replace files that no build wrote where packs have their names.
    #[arg(long)]
    force: bool,
    /// Memory that the materials which are worked on may take together, such as 2GiB (default: 300 MiB for each thread).
    /// Fewer are worked on at a time where that is needed.
    #[arg(long, value_name = "B", value_parser = bytes_from_text)]
    memory: Option<u64>,
}

impl BuildArguments {
    /// How a build is done, where nothing else is said.
    pub(crate) fn settings<'a>(&'a self, interrupt: &'a Interrupt) -> Result<BuildSettings<'a>, CliError> {
        Ok(BuildSettings {
            out: &self.out,
            looks_up: true,
            from: &[],
            keep: self.keep,
            force: self.force,
            fail_fast: false,
            whole: false,
            memory: self.memory()?,
            placing: interrupt.placing(),
        })
    }

    /// Bytes that all materials that are worked on may take together.
    pub(crate) fn memory(&self) -> Result<u64, CliError> {
        match self.memory {
            Some(bytes) if bytes < LEAST_MEMORY => {
                Err(CliError::Usage(format!("--memory: found {bytes} bytes; allowed 64MiB or more")))
            }
            Some(bytes) => Ok(bytes),
            None => Ok(memory::PER_THREAD * rayon::current_num_threads() as u64),
        }
    }
}

impl Arguments {
    /// How a build is done.
    pub(super) fn settings<'a>(&'a self, interrupt: &'a Interrupt) -> Result<BuildSettings<'a>, CliError> {
        let settings = self.build.settings(interrupt)?;
        Ok(BuildSettings { looks_up: !self.no_cache, from: &self.from, fail_fast: self.fail_fast, ..settings })
    }

    /// The file that says that all is done.
    pub(super) fn write_stamp(&self) -> Result<(), CliError> {
        let Some(file) = &self.stamp else { return Ok(()) };
        file.parent().map_or(Ok(()), make_folder)?;
        write_file(file, b"")
    }
}
