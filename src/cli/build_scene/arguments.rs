//! Flags of `brdfc build`.

use crate::output::{make_folder, refuse_own, write_file};
use brdfc::scene::Shard;
use brdfc::{Build, EncodeOptions, Error};
use brdfc_terminal::values::bytes_from_text;
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Less is not enough for one material.
const LEAST_MEMORY: u64 = 64 << 20;

/// Parses an amount of memory.
fn memory_from_text(text: &str) -> Result<u64, String> {
    let bytes = bytes_from_text(text).ok().filter(|bytes| *bytes >= LEAST_MEMORY);
    bytes.ok_or_else(|| "expected 64MiB or more, such as 512MiB, 2GiB or 2147483648 (bytes)".to_owned())
}

/// Make the packs that a scene needs, or those of a folder of measured materials.
///
/// A manifest names materials and the uses that a scene makes of them; docs/scene.md lists its keys. A material that no
/// use refers to is not even opened. Without a manifest each material of the folders, files and patterns is made, and its
/// pack is named after its file; of folders that is what stands in them directly, packs left out.
///
/// What was made before of the same source by the same options is kept. One material that fails does not stop the
/// others. The output folder changes at the end, all at once: report.json lists what was built into it, and files that
/// others put there stay. An encoding option wins over the table defaults of a manifest, not over what a material says
/// of itself. A limit that is missed, and a gate of the manifest that stays closed, are exit code 1.
///
/// Where the manifest names an environment that lights the scene (environment in the table scene), maps for adaptive
/// shading are made too: how fast each material's lobes and the environment vary, and importance samples of the lobes.
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
    /// Say what would be made and between which sizes packs will be, and make nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Say what is needed of each material, which uses ask for it, and what is saved by leaving out the rest.
    #[arg(long)]
    pub(super) explain: bool,
    /// Make every pack again, also what was made before.
    #[arg(long)]
    pub(super) no_cache: bool,
    /// Stop at the first material that fails or misses a limit, and leave the folder as it was.
    #[arg(long)]
    pub(super) fail_fast: bool,
    /// Make share I of N alone, I from 1 to N, and keep it in the store of the output folder (.brdfc-cache); a build without
    /// this option puts all in place. It has no report, so no --json.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["only", "dry_run", "explain"])]
    pub(super) shard: Option<Shard>,
    /// Make one part alone, likewise; may be given several times: MATERIAL.brdf, MATERIAL.maps or environment.maps
    /// ('brdfc plan' lists them).
    #[arg(long, value_name = "PART", conflicts_with_all = ["dry_run", "explain"])]
    pub(super) only: Vec<String>,
    /// Take what another build made from its output folder, such as that of another machine; may be given several times.
    #[arg(long, value_name = "DIR")]
    pub(super) from: Vec<PathBuf>,
    /// Write this empty file when all is done and well.
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
    pub(super) stamp: Option<PathBuf>,
    /// Write the files that report.json depends on to FILE, as a rule for make or ninja.
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
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
    #[arg(long, short, value_name = "DIR", default_value = Build::DEFAULT_FOLDER)]
    pub(crate) out: PathBuf,
    /// Leave materials of earlier builds in the folder and in the report that this one does not ask for.
    #[arg(long)]
    keep: bool,
    /// Replace files that no build wrote, where they have names that packs or reports get; without it they are an error.
    #[arg(long)]
    force: bool,
    /// Memory that the materials which are worked on may take together: 64MiB or more, in bytes or with KiB, MiB or GiB
    /// (default: 300MiB for each thread). Fewer are worked on at a time where that is needed.
    #[arg(long, value_name = "B", value_parser = memory_from_text)]
    memory: Option<u64>,
}

impl BuildArguments {
    /// The build that these arguments ask for, with the defaults of the rest.
    pub(crate) fn build(&self, options: &EncodeOptions) -> Result<Build, Error> {
        let build = Build::from_inputs(&self.inputs)?.options(options.clone());
        let build = build.out(&self.out).keep(self.keep).force(self.force);
        Ok(match self.memory {
            Some(bytes) => build.memory(bytes),
            None => build,
        })
    }
}

impl Arguments {
    /// The build.
    pub(super) fn build(&self) -> Result<Build, Error> {
        let build = self.build.build(&self.options)?;
        Ok(build.cache(!self.no_cache).reuse(self.from.clone()).fail_fast(self.fail_fast))
    }

    /// The file that says that all is done.
    pub(super) fn write_stamp(&self) -> Result<(), Error> {
        let Some(file) = &self.stamp else { return Ok(()) };
        file.parent().map_or(Ok(()), make_folder)?;
        // Folders that were not there before may lead elsewhere than it seemed.
        refuse_own("--stamp", file, &self.build.out)?;
        write_file(file, b"")
    }
}
