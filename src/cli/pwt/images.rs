//! Outputs of `brdfc pwt` for other programs: normals, albedo, and relightable images for web viewers.

use crate::output::{
    check_folder, make_folder, refuse_missing_folder, refuse_other_extension, refuse_overwriting, refuse_same_outputs,
    write_file,
};
use crate::{Error, table};
use brdfc::relight::{
    LightSamples, Ptm, SurfaceReport, WebExport, WebReport, albedo_png, make_surface, make_web, make_web_of_map,
    normals_png,
};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Paths of these outputs.
#[derive(Debug, Args)]
pub struct ImageOutputs {
    /// Write normals as an 8-bit PNG, n / 2 + 1 / 2, with x right, y up and z to the viewer: photometric stereo without
    /// the lights that shadows or gloss spoil.
    #[arg(long, value_name = "NORMALS.png")]
    pub normals: Option<PathBuf>,
    /// Write the albedo that belongs to the normals as an sRGB PNG.
    #[arg(long, value_name = "ALBEDO.png")]
    pub albedo: Option<PathBuf>,
    /// Write a relightable image for web viewers into this folder: info.json and JPEG planes, which OpenLIME opens as a
    /// layer of type "rti".
    #[arg(long, value_name = "DIR")]
    pub web: Option<PathBuf>,
}

/// Reports of these outputs.
#[derive(Debug, Default, Serialize, schemars::JsonSchema)]
pub struct ImageReports {
    /// Normals and albedo; null if there are none.
    surface: Option<SurfaceReport>,
    /// The relightable image for web viewers; null if there is none.
    web: Option<WebReport>,
}

impl ImageOutputs {
    /// Rejects paths that cannot be written, before anything is computed.
    pub fn check(&self, output: Option<&Path>, inputs: &[&Path]) -> Result<(), Error> {
        for (option, path) in [("--normals", &self.normals), ("--albedo", &self.albedo)] {
            let Some(path) = path else { continue };
            refuse_overwriting(option, path, inputs)?;
            refuse_other_extension(option, path, &["png"])?;
            refuse_missing_folder(path)?;
        }
        if let Some(folder) = &self.web {
            check_folder(folder)?;
            refuse_overwriting("--web", folder, inputs)?;
        }
        refuse_same_outputs(&[
            ("--output", output),
            ("--normals", self.normals.as_deref()),
            ("--albedo", self.albedo.as_deref()),
            ("--web", self.web.as_deref()),
        ])
    }

    /// Computes and writes them. `measured` is true for photographs. The image for web viewers has the polynomials of a map, if there is one. Also returns why there are no
    /// normals, or why they are unreliable.
    pub fn write(
        &self,
        (samples, measured): (&LightSamples, bool),
        map: Option<&Ptm>,
        (hold_out, seed): (usize, u64),
        inputs: &[&Path],
    ) -> Result<(ImageReports, Option<String>), Error> {
        let mut reports = ImageReports::default();
        let images = self.normals.is_some() || self.albedo.is_some();
        // Renderings of a map or a pack agree, also where both are wrong.
        let make_surface = |samples: &LightSamples| {
            let (maps, report) = make_surface(samples)?;
            Ok::<_, Error>((
                maps,
                SurfaceReport { between_halves: report.between_halves.filter(|_| measured), ..report },
            ))
        };
        let (surface, note) = match self.web {
            _ if images => (Some(make_surface(samples)?), None),
            // Web viewers do not need normals.
            Some(_) => match make_surface(samples) {
                Ok(surface) => (Some(surface), None),
                Err(error) => (None, Some(format!("no normals for web viewers: {error}"))),
            },
            None => (None, None),
        };
        let note = note.or_else(|| surface.as_ref()?.1.doubt());
        if let Some((maps, report)) = surface.as_ref().filter(|_| images) {
            self.normals.as_ref().map_or(Ok(()), |path| write_file(path, &normals_png(maps)))?;
            self.albedo.as_ref().map_or(Ok(()), |path| write_file(path, &albedo_png(maps)))?;
            reports.surface = Some(*report);
        }
        let maps = surface.as_ref().map(|(maps, _)| maps);
        if let Some(folder) = &self.web {
            let WebExport { files, report, .. } = match map {
                Some(map) => make_web_of_map(map, samples, maps)?,
                None => make_web(samples, maps, hold_out, seed)?,
            };
            for (name, _) in &files {
                refuse_overwriting("--web", &folder.join(name), inputs)?;
            }
            make_folder(folder)?;
            for (name, bytes) in &files {
                write_file(&folder.join(name), bytes)?;
            }
            reports.web = Some(report);
        }
        Ok((reports, note))
    }
}

impl ImageReports {
    /// Tables.
    pub fn summary(&self) -> String {
        let mut text = String::new();
        let pixels = |[width, height]: [usize; 2]| format!("{width} x {height}");
        if let Some(SurfaceReport { size, lights, outliers, between_halves, between_halves_p95 }) = self.surface {
            let angle = |found: Option<f64>| found.map_or("-".to_owned(), |angle| format!("{angle:.1}°"));
            let row = vec![
                pixels(size),
                lights.to_string(),
                table::percent(outliers),
                angle(between_halves),
                angle(between_halves_p95),
            ];
            text.push_str(&table::plain(&["normals", "lights", "outliers", "between halves", "95 %"], &[row]));
        }
        if let Some(web) = &self.web {
            let decimals = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
            let row = vec![
                pixels(web.size),
                web.coefficients.to_string(),
                table::bytes(web.bytes_on_disk as u64),
                decimals(Some(web.errors.psnr)),
                decimals(Some(web.errors.delta_e)),
                decimals(web.held_out.as_ref().map(|held| held.psnr)),
                decimals(web.held_out.as_ref().map(|held| held.delta_e)),
            ];
            let header = ["web", "coefficients", "files", "dB", "ΔE", "dB held out", "ΔE held out"];
            text.push_str(&table::plain(&header, &[row]));
        }
        text
    }
}
