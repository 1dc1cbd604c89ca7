//! Flags of `brdfc build`.

use crate::output::{make_folder, refuse_own, write_file};
use crate::reading::{ReadingOptions, in_range};
use brdfc::scene::Shard;
use brdfc::{Build, EncodeOptions, Error};
use brdfc_terminal::values::bytes_from_text;
use clap::Args;
use std::ffi::OsString;
use std::path::PathBuf;

/// Minimum of `--memory`: one material needs this much.
const MIN_MEMORY: u64 = 64 << 20;

/// Parses an amount of memory.
fn memory_from_text(text: &str) -> Result<u64, String> {
    let bytes = bytes_from_text(text).ok().filter(|bytes| *bytes >= MIN_MEMORY);
    bytes.ok_or_else(|| "expected 64MiB or more, such as 512MiB, 2GiB or 2147483648 (bytes)".to_owned())
}

/// Build the packs that a scene needs, or a pack of each measured material and other asset in a folder.
///
/// A manifest lists materials, RTI captures, BTFs, environments, and the uses that a scene makes of materials;
/// docs/manifest.md describes its keys. The build does not open materials that no use refers to. Without a manifest, it
/// builds each asset of the given files, folders and patterns, and names the pack after the file or folder. Of
/// subfolders it takes those of RTI captures and BTFs only, and it skips packs in folders.
///
/// The build reuses packs that it made before from the same source with the same options. If one material fails, the
/// others are still built. The output folder changes once, at the end: report.json lists the files that the build
/// wrote, and other files stay. Encoding options override the defaults of a manifest, but not the settings of a single
/// material. The exit code is 1 if a material misses a limit or a requirement of the manifest.
///
/// If the manifest names an environment that lights the scene (environment in the table scene), the build also makes
/// the lobes of each material, a few look-ups for each pixel, and the prefiltered environment that they look up. Uses
/// request maps for adaptive shading by the key maps. Without a manifest, --environment names the image.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc build scene.toml
  brdfc build scans --out packs
  brdfc build scans/*.binary paint.brdf --max-delta-e 1
  brdfc build scans/*.binary --environment museum.exr
  brdfc build scene.toml --out assets/packs --jobs 4 --json > report.json
  brdfc build scene.toml --shard 2/8 --out part-2
  brdfc build scene.toml --from part-1 --from part-2
  brdfc build scene.toml --dry-run --explain")]
pub struct Arguments {
    #[command(flatten)]
    pub(super) build: BuildArguments,
    /// Without a manifest: also make the lobes of each material, and the prefiltered environment that they look up from
    /// this latitude-longitude image (.exr, .hdr), cube map or prefiltered environment (.ktx2). With a manifest, set
    /// environment in the table scene.
    #[arg(long, value_name = "FILE")]
    environment: Option<String>,
    /// Print the plan and the predicted range of pack sizes, and build nothing.
    #[arg(long)]
    pub(super) dry_run: bool,
    /// Print which features each material needs, which uses require them, and how many bytes a pack saves
    /// without the rest.
    #[arg(long)]
    pub(super) explain: bool,
    /// Build every pack again, even if an earlier build made it.
    #[arg(long)]
    pub(super) no_cache: bool,
    /// Stop at the first material that fails or misses a limit, and leave the output folder unchanged.
    #[arg(long)]
    pub(super) fail_fast: bool,
    /// Build only shard I of N, I from 1 to N, into the store of the output folder (.brdfc-cache). A later build
    /// without this option moves the results into place. There is no report, so --json is not available.
    #[arg(long, value_name = "I/N", conflicts_with_all = ["only", "dry_run", "explain"])]
    pub(super) shard: Option<Shard>,
    /// Build only this part into the store, as --shard does: MATERIAL.brdf, MATERIAL.lobes, MATERIAL.maps, NAME.pwt,
    /// NAME.environment or environment.maps ('brdfc plan' lists them). May be repeated.
    #[arg(long, value_name = "PART", conflicts_with_all = ["dry_run", "explain"])]
    pub(super) only: Vec<String>,
    /// Reuse results from the output folder of another build, for example of another machine. May be repeated.
    #[arg(long, value_name = "DIR")]
    pub(super) from: Vec<PathBuf>,
    /// Create this empty file when the build succeeds.
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
    pub(super) stamp: Option<PathBuf>,
    /// Write a rule for make or ninja to FILE that lists the files which report.json depends on.
    #[arg(long, value_name = "FILE", conflicts_with = "dry_run")]
    pub(super) depfile: Option<PathBuf>,
    #[command(flatten, next_help_heading = "Encoding")]
    pub(super) options: EncodeOptions,
}

/// Arguments of all commands that build.
#[derive(Debug, Args)]
pub(crate) struct BuildArguments {
    /// A scene manifest; or files, folders and patterns of measured materials, RTI captures, BTFs and environments, and
    /// synth: addresses.
    #[arg(value_name = "SCENE.toml|DIR|FILE", required = true)]
    pub(crate) inputs: Vec<OsString>,
    /// Folder for packs and reports (default: packs).
    #[arg(long, short, value_name = "DIR", default_value = Build::DEFAULT_FOLDER)]
    pub(crate) out: PathBuf,
    /// Keep packs of earlier builds, and their entries in the report, for materials that this build does not include.
    #[arg(long)]
    keep: bool,
    /// Overwrite files that no build wrote if packs or reports need their names. Without this option they are an error.
    #[arg(long)]
    force: bool,
    /// Memory limit for the materials in progress, together: at least 64MiB, in bytes or with KiB, MiB or GiB
    /// (default: 300MiB per thread). The build works on fewer materials at a time to stay below it.
    #[arg(long, value_name = "B", value_parser = memory_from_text)]
    memory: Option<u64>,
    #[command(flatten, next_help_heading = "Reading of materials")]
    reading: ReadingOptions,
}

impl BuildArguments {
    /// Makes the build from these arguments, with defaults for everything else.
    pub(crate) fn build(&self, options: &EncodeOptions) -> Result<Build, Error> {
        let build = Build::from_inputs(&self.inputs)?.options(options.clone()).reading(in_range(self.reading)?);
        let build = build.out(&self.out).keep(self.keep).force(self.force);
        Ok(match self.memory {
            Some(bytes) => build.memory(bytes),
            None => build,
        })
    }
}

impl Arguments {
    /// Makes the build from all arguments.
    pub(super) fn build(&self) -> Result<Build, Error> {
        let mut build = self.build.build(&self.options)?;
        if let Some(image) = &self.environment {
            build = build.environment(image)?;
        }
        Ok(build.cache(!self.no_cache).reuse(self.from.clone()).fail_fast(self.fail_fast))
    }

    /// Writes the file of `--stamp`.
    pub(super) fn write_stamp(&self) -> Result<(), Error> {
        let Some(file) = &self.stamp else { return Ok(()) };
        file.parent().map_or(Ok(()), make_folder)?;
        // The build may have created folders, so that the path now leads elsewhere.
        refuse_own("--stamp", file, &self.build.out)?;
        write_file(file, b"")
    }
}
