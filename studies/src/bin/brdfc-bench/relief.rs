//! The study of reliefs.

use super::arguments::Arguments;
use super::remarks::Remarks;
use super::structures::{file_stem, structures};
use brdfc_render::rendering::rgb_png;
use brdfc_studies::StudyResult;
use brdfc_studies::relief::{MethodRow, ReliefRow, ReliefSettings, RenderingRow, relief_study, steps};
use brdfc_terminal::output::{make_folder, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};

/// Texels per side.
const TEXELS: usize = 128;
const MAX_TEXELS: usize = 512;
/// Pixels per row.
const PIXELS: usize = 640;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let texels = arguments.power_of_two_texels(TEXELS, MAX_TEXELS)?;
    let pixels = arguments.pixels.unwrap_or(PIXELS);
    if !(64..=2048).contains(&pixels) {
        return Err(Error::usage(format!("--pixels: found {pixels}, expected 64 to 2048")));
    }
    let settings = ReliefSettings { texels: texels as u32, pixels };
    let structures = structures(arguments)?;
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let with_sheet = arguments.out.is_some();
    let remarks = Remarks::new(common, steps(with_sheet) * structures.len());
    let mut rows = Vec::new();
    for (input, address) in structures {
        let study = relief_study(&address, &settings, with_sheet, &|| remarks.done(1));
        let (row, sheet) = study.map_err(|error| Error::input(format!("{input}: {error}")))?;
        if let (Some(folder), Some(sheet)) = (&arguments.out, sheet) {
            write_file(&folder.join(format!("relief-{}.png", file_stem(&address))), &rgb_png(&sheet))?;
        }
        rows.push(row);
    }
    Ok(StudyResult::Relief { settings, rows })
}

pub(super) fn text(settings: &ReliefSettings, rows: &[ReliefRow]) -> String {
    let mut text = format!(
        "{0} x {0} texels, heights twice as many per side. Errors are mean ΔE against the surface itself, ray cast. All \
         methods have the reflectance of the layers; the last two are bounds, which compute from the surface.\n",
        settings.texels
    );
    for row in rows {
        text += &format!("\n{}\n\n{}\n{}", row.model, on_the_plane(&row.methods), elsewhere(&row.methods));
    }
    text + "\nFetches: most of a pixel under one light, and the mean on the plane. 95 %: 95th percentile of ΔE. Jumps: share \
            of pixels whose ΔE changes by more than 5 when the camera turns by 0.5°.\n16 x 16 tiles, and 32 x 32 on half as many pixels per row: against 64 samples per pixel; brightness \
            over that of the surface. Objects: against the displaced object.\n"
}

fn on_the_plane(methods: &[MethodRow]) -> String {
    let angles = methods.first().map_or(&[][..], |method| &method.angles);
    let angles = angles.iter().map(|row| format!("{:.0}°", row.polar_angle));
    let header: Vec<String> = ["method", "on a GPU", "fetches", "mean", "ns", "plane", "95 %", "dB"]
        .map(str::to_owned)
        .into_iter()
        .chain(angles)
        .chain(["jumps".to_owned()])
        .collect();
    let cells = |row: &MethodRow| {
        let or_none = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let (most, mean) = (row.fetches.map(|n| n.to_string()), row.mean_fetches.map(|n| format!("{n:.1}")));
        let stored = [row.bytes.map(bytes), most, mean, row.nanoseconds.map(|n| format!("{n:.0}"))];
        let plane =
            [Some(two(row.plane.delta_e)), Some(two(row.plane.p95)), row.plane.psnr.map(|psnr| format!("{psnr:.1}"))];
        let cells = [row.method.to_owned()].into_iter().chain(stored.map(or_none)).chain(plane.map(or_none));
        let cells = cells.chain(row.angles.iter().map(|angle| two(angle.delta_e)));
        cells.chain([percent(row.jumps)]).collect::<Vec<_>>()
    };
    plain(&header.iter().map(String::as_str).collect::<Vec<_>>(), methods.iter().map(cells))
}

fn elsewhere(methods: &[MethodRow]) -> String {
    let objects = methods.first().map_or(&[][..], |method| &method.objects);
    let header = ["method", "16 x 16 tiles", "brightness", "32 x 32", "brightness"]
        .into_iter()
        .chain(objects.iter().map(|row| row.scene));
    let cells = |row: &MethodRow| {
        let of = |rendering: &RenderingRow| two(rendering.delta_e);
        let distant = [&row.far, &row.farther].map(|far| [of(far), percent(far.brightness)]);
        let far = [row.method.to_owned()].into_iter().chain(distant.into_iter().flatten());
        far.chain(row.objects.iter().map(|object| of(&object.rendering))).collect::<Vec<_>>()
    };
    plain(&header.collect::<Vec<_>>(), methods.iter().map(cells))
}

fn two(value: f64) -> String {
    format!("{value:.2}")
}
