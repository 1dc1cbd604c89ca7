//! `brdfc synth`: writes analytic models as files.

use super::Error;
use super::output::{as_flag, is_stream, output_parser, refuse_flags, refuse_missing_folder, write_file};
use brdfc::synth::{
    Dimensions, MODELS, STRUCTURES, SYNTH_PREFIX, ScanPlan, Target, describe_models, describe_structures, file,
    split_query,
};
use brdfc::{FormatError, Fraction};
use brdfc_terminal::values::whole_number;
use brdfc_terminal::words::quoted;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// Write an analytic model as a measured file, or a structure as a mesh.
///
/// The extension selects the format. .binary is a MERL table. .brdf and .csv are scattered scans with seeded noise,
/// gaps and duplicates; .brdf has a spectrum of 31 bands with the model's colour. .obj and .ply contain one tile of a
/// structure, with its tints as vertex colours.
#[derive(Debug, Args)]
#[command(after_help = models())]
pub struct Arguments {
    /// MODEL or STRUCTURE, or MODEL?param=value&...
    model: String,
    /// The file to write, or - for stdout.
    #[arg(long, short, value_name = "FILE", value_parser = output_parser())]
    output: PathBuf,
    /// Format of stdout, which has no extension.
    #[arg(long, value_enum)]
    kind: Option<Extension>,
    /// Samples of a MERL table along theta_h, theta_d and phi_d, each 1 to 4096 (default: 90x90x180).
    #[arg(long, value_name = "HxDxP", allow_hyphen_values = true)]
    dimensions: Option<String>,
    /// Rows of a scan, 1 to 10000000 (default: 1440).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(1..=10_000_000))]
    rows: Option<usize>,
    /// Number of incoming polar angles of a scan, between 10 and 80 degrees: 1 to 1000 (default: 8).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(1..=1000))]
    incidences: Option<usize>,
    /// Number of incoming azimuths of a scan, 1 to 1000 (default: 1 for isotropic models, 8 for others).
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>(1..=1000))]
    azimuths: Option<usize>,
    /// Standard deviation of a scan's noise, as a fraction of the value, 0 to 2 (default: 0).
    #[arg(long, value_name = "SHARE")]
    noise: Option<Fraction>,
    /// Fraction of the outgoing hemisphere that a scan does not cover, 0 to 0.9 (default: 0).
    #[arg(long, value_name = "SHARE")]
    gaps: Option<Fraction>,
    /// Fraction of a scan's rows that repeat a direction pair, 0 to 0.9 (default: 0).
    #[arg(long, value_name = "SHARE")]
    duplicates: Option<Fraction>,
    /// Seed of a scan's noise, gaps and duplicates, 0 or more (default: 1).
    #[arg(long, value_name = "N", value_parser = whole_number::<u64>(0..=u64::MAX))]
    seed: Option<u64>,
}

fn models() -> String {
    format!(
        "Models:\n{}\nStructures (.obj, .ply):\n{}\nExamples:\n  brdfc synth 'lambert?kd=0.5' -o white.binary --dimensions 16x16x32\n  \
         brdfc synth 'ggx?kd=0.1,0.1,0.4&alpha=0.3' -o paint.brdf --noise 0.05 --gaps 0.1 --seed 7\n  \
         brdfc synth 'folds?resolution=64' -o folds.ply\n  brdfc synth velvet -o - --kind brdf > velvet.brdf",
        describe_models(),
        describe_structures()
    )
}

/// File extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Extension {
    /// A MERL table.
    Binary,
    /// A scan.
    Brdf,
    /// A scan.
    Csv,
    /// A mesh.
    Obj,
    /// A mesh.
    Ply,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Error> {
    let text = arguments.model.strip_prefix(SYNTH_PREFIX).unwrap_or(&arguments.model);
    let kind = kind(arguments, text)?;
    refuse_missing_folder(&arguments.output)?;
    check_options(arguments, kind)?;
    let target = match kind {
        Extension::Binary => Target::Merl(dimensions(arguments.dimensions.as_deref().unwrap_or("90x90x180"))?),
        Extension::Brdf => Target::Scan(plan(arguments)?),
        Extension::Csv => Target::Csv(plan(arguments)?),
        Extension::Obj => Target::Obj,
        Extension::Ply => Target::Ply,
    };
    write_file(&arguments.output, &file(&arguments.model, target).map_err(as_flag)?)
}

/// Determines the kind of file, and checks that it fits the model or structure.
fn kind(arguments: &Arguments, text: &str) -> Result<Extension, Error> {
    let output: &Path = &arguments.output;
    let name = split_query(text).0;
    let is_structure = STRUCTURES.iter().any(|info| info.name == name);
    let is_model = MODELS.iter().any(|info| info.name == name);
    let extension = output.extension().and_then(|e| Extension::from_str(e.to_str()?, true).ok());
    let stream = extension.is_none() && is_stream(output) && !output.is_dir();
    if !stream && arguments.kind.is_some() {
        let found = output.display();
        return Err(Error::usage(format!("--kind does not apply to {found}, only to - for stdout")));
    }
    let wrong = |allowed: &str| {
        Err(Error::usage(if stream {
            let found = arguments.kind.and_then(|kind| Some(kind.to_possible_value()?.get_name().to_owned()));
            let wrong = found.map_or("required without an extension;".to_owned(), |found| format!("found {found},"));
            format!("--kind: {wrong} expected {}", allowed.replace('.', ""))
        } else {
            format!("--output: found {}, expected a name that ends in {allowed}", output.display())
        }))
    };
    use Extension::{Binary, Brdf, Csv, Obj, Ply};
    match extension.or(arguments.kind) {
        Some(Binary | Brdf | Csv) if is_structure => wrong(&format!(".obj or .ply, for the structure {name}")),
        Some(Obj | Ply) if is_model => wrong(&format!(".binary, .brdf or .csv, for the model {name}")),
        Some(kind) => Ok(kind),
        None => wrong(".binary, .brdf or .csv (models), .obj or .ply (structures)"),
    }
}

/// Rejects options that would have no effect.
fn check_options(arguments: &Arguments, kind: Extension) -> Result<(), Error> {
    let found = arguments.output.display();
    let of_tables = arguments.dimensions.is_some() && kind != Extension::Binary;
    refuse_flags(&found, &[(of_tables, "--dimensions", ".binary files")])?;
    if matches!(kind, Extension::Brdf | Extension::Csv) {
        return Ok(());
    }
    let of_scans = [
        (arguments.rows.is_some(), "--rows"),
        (arguments.incidences.is_some(), "--incidences"),
        (arguments.azimuths.is_some(), "--azimuths"),
        (arguments.noise.is_some(), "--noise"),
        (arguments.gaps.is_some(), "--gaps"),
        (arguments.duplicates.is_some(), "--duplicates"),
        (arguments.seed.is_some(), "--seed"),
    ];
    refuse_flags(&found, &of_scans.map(|(given, flag)| (given, flag, ".brdf and .csv files")))
}

pub(super) fn dimensions(text: &str) -> Result<Dimensions, Error> {
    let parts: Vec<usize> = text.split('x').map(|p| p.parse().unwrap_or(0)).collect();
    let dimensions = match parts[..] {
        [theta_half, theta_difference, phi_difference] => Dimensions { theta_half, theta_difference, phi_difference },
        _ => Dimensions { theta_half: 0, theta_difference: 0, phi_difference: 0 },
    };
    // Report the size as it was given.
    let wrong = |error: FormatError| Error::wrong_usage("--dimensions", quoted(text), error.allowed);
    dimensions.check_for_writing().map_err(wrong)?;
    Ok(dimensions)
}

fn plan(arguments: &Arguments) -> Result<ScanPlan, Error> {
    // Report shares as they were given.
    for (flag, given, most) in [
        ("--noise", arguments.noise, 2.0),
        ("--gaps", arguments.gaps, 0.9),
        ("--duplicates", arguments.duplicates, 0.9),
    ] {
        if let Some(share) = given.filter(|share| !(0.0..=most).contains(&share.value())) {
            return Err(Error::wrong_usage(flag, share, format!("0 to {most}")));
        }
    }
    Ok(ScanPlan {
        rows: arguments.rows.unwrap_or(1440),
        incidences: arguments.incidences.unwrap_or(8),
        azimuths: arguments.azimuths,
        noise: arguments.noise.map_or(0.0, Fraction::value),
        gaps: arguments.gaps.map_or(0.0, Fraction::value),
        duplicates: arguments.duplicates.map_or(0.0, Fraction::value),
        seed: arguments.seed.unwrap_or(1),
    })
}
