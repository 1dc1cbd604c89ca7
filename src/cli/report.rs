//! `brdfc report`: a page about a build.

use super::output::{
    folder_of, print, print_json, refuse_dash, refuse_flags, refuse_missing_folder, refuse_other_extension,
    refuse_overwriting, remark, to_json, write_file,
};
use super::progress::Materials;
use super::{Common, Error};
use brdfc::inspect::{Kind, flat_btf_file};
use brdfc::report::{
    CSV_HEADER, FLAT_CSV_HEADER, FlatPage, Page, PageMaterial, PageOptions, REPORT, Reports, ViewLink, build_folder,
    csv, flat_csv, flat_html, gather, html, part_html, sheet_png,
};
use brdfc::view::{ViewOptions, open_items, view_page};
use brdfc::{Fraction, Input, Progress};
use brdfc_terminal::words::counted;
use clap::Args;
use std::path::{Path, PathBuf};

/// Write a page about the packs in a folder, or about a flat BTF: renderings, errors, checks.
///
/// The page is a single HTML file that works without a network and without scripts; of more than 100 materials, renderings
/// are on pages of 100 next to it, such as REPORT-1.html. The program writes the figures next
/// to the page, as .csv and .json files of the same name. The CPU's decoder draws the renderings. The page compares
/// packs with their sources if the sources are still where the build found them.
///
/// With --against, the page begins with the figures that got worse since an earlier build, if any; the exit code is
/// then 1.
///
/// Schemas of --json: 'report'; 'flat-btf' for a flat BTF.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  brdfc report packs -o report.html --sheet sheet.png
  brdfc report packs -o report.html --view view.html
  brdfc report packs -o report.html --only missed
  brdfc report packs -o report.html --against last-week/report.json --tolerance 5%
  brdfc report button -o button.html")]
pub struct Arguments {
    /// The folder that 'brdfc build' filled, or the report.json in it; a flat BTF, or its folder.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The page to write: .html or .htm.
    #[arg(long, short, value_name = "REPORT.html")]
    output: PathBuf,
    /// Builds only: also write an image of all materials, with labels and the colour scale of differences: source, pack
    /// and ΔE.
    #[arg(long, value_name = "IMAGE.png")]
    sheet: Option<PathBuf>,
    /// Also write a page that draws all packs in a browser, as 'brdfc view' does, and link to it; in the folder of the
    /// main page.
    #[arg(long, value_name = "VIEW.html")]
    view: Option<PathBuf>,
    /// Builds only: leave out materials that met all their limits and requirements.
    #[arg(long, value_name = "missed")]
    only: Option<Only>,
    /// Builds only: compare with an earlier build, given by its report.json or folder.
    #[arg(long, value_name = "OLD")]
    against: Option<PathBuf>,
    /// Tolerance of --against: the fraction or percentage by which a figure may be worse, 0.05 or 5% (default: 2%).
    #[arg(long, value_name = "SHARE", default_value = "2%", requires = "against")]
    tolerance: Fraction,
}

/// Materials of the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Only {
    /// Materials that failed, or missed a limit or a requirement.
    Missed,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let output = arguments.output.as_path();
    if !is_html(output) {
        let found = output.display();
        return Err(Error::wrong_usage("--output", found, "a name that ends in .html or .htm"));
    }
    refuse_dash(&arguments.folder)?;
    let folder = build_folder(&arguments.folder);
    arguments.sheet.as_ref().map_or(Ok(()), |sheet| refuse_other_extension("--sheet", sheet, &["png"]))?;
    let input = Input::from(arguments.folder.clone().into_os_string());
    let kind = Kind::of(&input)?;
    if kind.is_flat_btf() {
        return of_flat_btf(arguments, &input, common);
    }
    // A build that is not complete has no report yet.
    if !matches!(kind, Kind::Build | Kind::Packs | Kind::Folder) {
        let allowed = "the folder of a build, or a flat BTF; 'brdfc info' describes a single pack";
        return Err(kind.refused(&input, allowed).into());
    }
    let tolerance = arguments
        .tolerance
        .checked()
        .map_err(|allowed| Error::wrong_usage("--tolerance", arguments.tolerance, allowed))?;
    let against = arguments.against.as_ref().map(|path| if path.is_dir() { path.join(REPORT) } else { path.clone() });
    let [csv_path, json_path] = ["csv", "json"].map(|extension| output.with_extension(extension));
    let own = folder.join(REPORT);
    let inputs: Vec<&Path> = [own.as_path()].into_iter().chain(against.as_deref()).collect();
    refuse_pages_over(output, [&csv_path, &json_path], &inputs)?;
    if let Some(path) = &arguments.sheet {
        refuse_overwriting("--sheet", path, &inputs)?;
        refuse_missing_folder(path)?;
    }
    let reports = Reports::open(folder, against.as_deref())?.only_missed(arguments.only.is_some());
    let built = reports.files();
    let built: Vec<&Path> = built.iter().map(PathBuf::as_path).collect();
    refuse_pages_over(output, [&csv_path, &json_path], &built)?;
    refuse_other_figures(output, &csv_path, &json_path)?;
    if let Some(path) = &arguments.view {
        refuse_unfit_view(path, output, &[&built[..], &inputs].concat())?;
    }
    if let Some(path) = &arguments.sheet {
        refuse_overwriting("--sheet", path, &built)?;
    }
    // An interrupt ends the process at once: each file is either complete or absent.
    let progress = Materials::new(reports.count(), false, common);
    let view = write_view(arguments, &progress)?;
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let options = PageOptions { tolerance, name: &name, view, keeps_renderings: arguments.sheet.is_some() };
    let files = [&built[..], &inputs].concat();
    let mut write = |page: &Page, part: &str, materials: &[PageMaterial]| {
        let path = output.with_file_name(part);
        refuse_overwriting("--output", &path, &files)?;
        write_file(&path, part_html(page, materials, &name).as_bytes())
    };
    let page = gather(reports, options, &mut write, &progress)?;
    drop(progress);
    write_file(&csv_path, csv(&page).as_bytes())?;
    write_file(&json_path, to_json(&page.report()).as_bytes())?;
    if let Some(path) = &arguments.sheet {
        write_file(path, &sheet_png(&page))?;
    }
    write_file(output, html(&page).as_bytes())?;
    if common.json {
        print_json(&page.report())?;
    } else {
        let lines: String = page.regressions.iter().map(|worse| format!("{worse}\n")).collect();
        print(&lines)?;
    }
    let what = match (page.materials.len(), page.assets.len()) {
        (materials, 0) => counted(materials, "material"),
        (0, assets) => counted(assets, "asset"),
        (materials, assets) => {
            format!("{}, {}", counted(materials, "material"), counted(assets, "other asset"))
        }
    };
    remark(common, &format!("{}: {what}", output.display()));
    match page.regressions.len() {
        0 => Ok(()),
        1 => Err(Error::check("one figure is worse than before or misses its limit")),
        count => Err(Error::check(format!("{count} figures are worse than before or miss their limits"))),
    }
}

fn is_html(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"))
}

/// Writes the page of `--view`.
fn write_view(arguments: &Arguments, progress: &dyn Progress) -> Result<Option<ViewLink>, Error> {
    let Some(path) = &arguments.view else { return Ok(None) };
    let items = open_items(&[Input::from(&arguments.folder)], ViewOptions::default(), progress)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    write_file(path, view_page(&items, None)?.html.as_bytes())?;
    Ok(Some(ViewLink::new(&name, items.into_iter().map(|item| item.name))))
}

/// Checks that the page of `--view` is next to the page that links to it, and overwrites no other file.
fn refuse_unfit_view(path: &Path, output: &Path, others: &[&Path]) -> Result<(), Error> {
    let [folder, of_output] = [path, output].map(|path| folder_of(path).canonicalize().ok());
    let is_same = path.file_name() == output.file_name();
    if !is_html(path) || is_same || folder != of_output {
        let found = path.display();
        let allowed = "another .html file in the folder of --output";
        return Err(Error::wrong_usage("--view", found, allowed));
    }
    refuse_overwriting("--view", path, others)
}

/// Checks that the page and its figures overwrite no input, and that the folder exists.
fn refuse_pages_over(output: &Path, figures: [&PathBuf; 2], inputs: &[&Path]) -> Result<(), Error> {
    refuse_overwriting("--output", output, inputs)?;
    for path in figures {
        refuse_overwriting("--output", path, inputs).map_err(|_| {
            let (page, path) = (output.display(), path.display());
            let text = format!("the figures of {page} would overwrite the input {path}; choose another name");
            Error::usage(format!("--output: {text}"))
        })?;
    }
    refuse_missing_folder(output)
}

/// Rejects figures that would replace any file except figures of an earlier page: `scan.csv` next to `scan.html` may be
/// a measurement.
fn refuse_other_figures(output: &Path, csv_path: &Path, json_path: &Path) -> Result<(), Error> {
    // The first column stays when others are added.
    let first = |header: &'static str| header.split_inclusive(',').next().unwrap_or_default();
    let is_csv = |bytes: &[u8]| [CSV_HEADER, FLAT_CSV_HEADER].iter().any(|h| bytes.starts_with(first(h).as_bytes()));
    let is_json =
        |bytes: &[u8]| serde_json::from_slice(bytes).is_ok_and(|json: serde_json::Value| json.get("version").is_some());
    let is_own = |path: &Path| match std::fs::metadata(path).and_then(|file| match file.is_file() {
        true => std::fs::read(path),
        false => Ok(Vec::new()),
    }) {
        Ok(bytes) if path == csv_path => is_csv(&bytes),
        Ok(bytes) => is_json(&bytes),
        Err(_) => true,
    };
    for path in [csv_path, json_path] {
        if !is_own(path) {
            let (page, path) = (output.display(), path.display());
            let text = format!("the figures of {page} would overwrite {path}, which no report made");
            return Err(Error::usage(format!("--output: {text}; choose another name")));
        }
    }
    Ok(())
}

/// Writes the page of a flat BTF.
fn of_flat_btf(arguments: &Arguments, input: &Input, common: Common) -> Result<(), Error> {
    let output = arguments.output.as_path();
    let given = [
        (arguments.against.is_some(), "--against"),
        (arguments.sheet.is_some(), "--sheet"),
        (arguments.only.is_some(), "--only"),
    ];
    let flags = given.map(|(given, flag)| (given, flag, "builds"));
    refuse_flags(format!("{input}, a flat BTF"), &flags)?;
    let file = flat_btf_file(input)?;
    let file = file.path();
    let [csv_path, json_path] = ["csv", "json"].map(|extension| output.with_extension(extension));
    refuse_pages_over(output, [&csv_path, &json_path], file.as_slice())?;
    refuse_other_figures(output, &csv_path, &json_path)?;
    if let Some(path) = &arguments.view {
        refuse_unfit_view(path, output, file.as_slice())?;
    }
    let mut page = FlatPage::open(input)?;
    page.view = write_view(arguments, &())?;
    write_file(&csv_path, flat_csv(&page.asset).as_bytes())?;
    write_file(&json_path, to_json(&page.asset).as_bytes())?;
    write_file(output, flat_html(&page).as_bytes())?;
    if common.json {
        print_json(&page.asset)?;
    }
    remark(common, &format!("{}: {}", output.display(), counted(page.asset.images.len(), "texture")));
    Ok(())
}
