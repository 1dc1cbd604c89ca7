//! `brdfc render --adaptive`: environment light, shaded where and as finely as predicted bandwidth requires.

use super::adaptive_options::{ANTIALIAS, AdaptiveOptions, MAX_SAMPLES, RATE_TILE};
use super::arguments::Arguments;
use super::materials::{self, Prepared, Subject};
use super::textures::{self, Textures};
use super::{gpu, outputs, scene};
use crate::output::{note, print, print_json, refuse_flags, remark, write_file};
use crate::table::{percent, plain, significant};
use crate::{Common, Error};
use brdfc::BrdfPack;
use brdfc::bandwidth::{BandwidthFacts, BandwidthMap, DEFAULT_EPSILON};
use brdfc::inspect::AnyPack as Pack;
use brdfc::render::{
    AdaptiveMaterial, AdaptiveRates, AdaptiveRenderer, AdaptiveScene, AdaptiveVerification, DistantLight, Environment,
    Frame, GpuError, LinearImage, PackReflectance, PartTextureReport, RATE_TILES, RateImage, Reflectance, Settings,
    Shading, Start, auto_exposure, environment_map, ground_truth, lookups, nothing_shown, prediction_png, rates_png,
    tabulated,
};
use brdfc::scene::EnvironmentJob;
use brdfc_terminal::words::format_number;
use serde::Serialize;
use std::time::Instant;

/// Default samples per pixel of forward shading and of the ground truth.
const FORWARD: u32 = 32;
const TRUTH: usize = 256;

/// Default side of the tiles of `--rates`.
const TILE: u32 = 16;

/// Report of `--adaptive --json`.
#[derive(Debug, Serialize, schemars::JsonSchema)]
pub struct Report {
    /// Layout of this report.
    version: u32,
    /// Settings and measurements.
    #[serde(flatten)]
    verification: AdaptiveVerification,
    /// Seconds from the start to the last image, encoding included.
    seconds: f64,
}

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<(), Error> {
    let started = Instant::now();
    let (mut settings, antialias) = settings(&arguments.adaptive)?;
    refuse(arguments)?;
    let metres = textures::metres(arguments)?;
    let subject = materials::subject(arguments)?;
    let setup = scene::setup(arguments, &subject)?;
    let frame = Frame { samples: 1, ..setup.frame };
    let gpu = gpu::open(arguments)?;
    let mut prepared = materials::prepare(arguments, &subject, &setup.names, common)?;
    for part in &mut prepared {
        // Maps and samples look the source up far too often for a scan.
        if let Some(table) = part.source.as_deref().map(|source| tabulated(source, &())).transpose()?.flatten() {
            note(common, &part.name, &table.summary());
            part.source = Some(Box::new(table.source));
        }
    }
    let of_part = |part: &Prepared| lookups(&part.material(), &part.maps).map_err(|error| error.prefixed(&part.name));
    let lookups = prepared.iter().map(of_part).collect::<Result<Vec<_>, _>>()?;
    let map = environment(arguments, &subject, &setup.scene.environment)?;
    let light = DistantLight::new(&setup.scene.environment, map);
    let decoding = gpu::decoding(arguments, &subject);
    let reflectances: Vec<PackReflectance> =
        prepared.iter().map(|part| PackReflectance::new(&part.pack, decoding)).collect();
    let index = |name: &String| prepared.iter().position(|part| part.name == *name).expect("every name was prepared");
    let parts: Vec<usize> = setup.names.iter().map(index).collect();
    let textures = Textures::open((arguments, metres), &subject, &setup, (&prepared, &parts))?;
    let plain: Vec<AdaptiveMaterial<'_>> =
        parts.iter().map(|part| lookups[*part].material(&reflectances[*part] as &dyn Reflectance)).collect();
    let materials = textures.on(&plain);
    let packs: Vec<&BrdfPack> = parts.iter().map(|part| &prepared[*part].pack).collect();
    for part in prepared.iter().filter(|part| !part.pack.directions().is_all()) {
        let text = format!("the pack covers {}; other directions use the nearest covered one", part.pack.directions());
        note(common, &part.name, &text);
    }
    let adaptive_scene = AdaptiveScene { scene: &setup.scene, light: &light, materials: &materials };

    let renderer = AdaptiveRenderer::new(&gpu)?;
    let loaded = renderer.load(&adaptive_scene, &packs, decoding)?;
    let g_buffer = renderer.g_buffer(&loaded, &setup.scene.camera, frame, settings.antialiasing_levels)?;
    let buffer = renderer.read(&g_buffer)?;
    let surface_points = (0..buffer.part.len()).filter(|point| buffer.part_at(*point).is_some()).count() as u64;

    let count = arguments.adaptive.forward.unwrap_or(FORWARD);
    let least = (TRUTH / antialias as usize).max(2 * count as usize);
    // Complete runs, whose spread estimates the error of the ground truth.
    let truth_samples = arguments.adaptive.truth.unwrap_or(least).next_multiple_of(16);
    if truth_samples < 2 * count as usize {
        note(
            common,
            &arguments.input,
            &format!("the ground truth has {truth_samples} samples, forward shading {count}; increase --truth"),
        );
    }
    remark(common, &format!("ground truth: {truth_samples} samples for each of {surface_points} points, on the CPU"));
    let distributions: Vec<_> = parts.iter().map(|part| &lookups[*part].distributions).collect();
    let (truth, truth_seconds) =
        timed(|| Ok(ground_truth(&adaptive_scene, frame, &buffer, &distributions, truth_samples, Start::Scattered)))?;
    let exposure = setup.exposure.unwrap_or_else(|| auto_exposure(&truth.image));
    let truth_psnr = truth.psnr(exposure);
    let truth = truth.image;
    settings.white = (1.0 / exposure) as f32;

    // Run once before timing, because a driver compiles shaders at the first run.
    renderer.run_prediction(&loaded, &g_buffer, &settings)?;
    let ((), bandwidth_seconds) = timed(|| renderer.run_prediction(&loaded, &g_buffer, &settings))?;
    let (rendering, seconds) = timed(|| renderer.draw(&loaded, &g_buffer, &settings))?;
    remark(common, &format!("adaptive: {seconds:.1} s; forward: {count} samples per point"));
    let ignored = textures.without_bandwidth().map(|textures| {
        let scene = AdaptiveScene { materials: &textures.on(&plain), ..adaptive_scene };
        let loaded = renderer.load(&scene, &packs, decoding)?;
        timed(|| renderer.draw(&loaded, &g_buffer, &settings))
    });
    let ignored = ignored.transpose()?;
    let (forward, forward_seconds) = timed(|| renderer.forward(&loaded, &g_buffer, count))?;

    let of_part = |number: usize| {
        let (prepared, lookup) = (&prepared[parts[number]], &lookups[parts[number]]);
        let of_maps = lookup.samples.gpu_bytes() + BandwidthFacts::new(&lookup.bandwidth).gpu_bytes;
        (prepared.name.clone(), prepared.pack.gpu_bytes() + of_maps)
    };
    let against = (&truth, exposure);
    let shaded = [rendering.samples(), rendering.shaded()];
    let without_texture_bandwidth = ignored.map(|(rendering, seconds)| {
        let shaded = [rendering.samples(), rendering.shaded()];
        Shading::new(&rendering.image, shaded, surface_points, seconds, against)
    });
    let of_forward = [surface_points * u64::from(count), surface_points];
    let rates = arguments.adaptive.rates.as_ref().map(|_| {
        let tile = arguments.adaptive.rate_tile.unwrap_or(TILE);
        RateImage::new(&rendering.prediction.level, [frame.width, frame.height], settings.antialiasing_levels, tile)
    });
    let verification = AdaptiveVerification {
        scene: setup.builtin.name().to_owned(),
        width: frame.width,
        height: frame.height,
        points: antialias as usize,
        surface_points,
        exposure,
        adapter: gpu.description().clone(),
        parts: setup.parts(of_part),
        textures: textures.report(&setup),
        without_texture_bandwidth,
        environment: [setup.scene.environment.width, setup.scene.environment.height],
        settings: (&settings).into(),
        adaptive: Shading::new(&rendering.image, shaded, surface_points, seconds, against),
        bandwidth_seconds,
        levels: rendering.levels.clone(),
        rates: rates.as_ref().map(|rates| AdaptiveRates::new(rates, &truth, exposure)),
        forward: Shading::new(&forward, of_forward, surface_points, forward_seconds, against),
        truth_samples,
        truth_psnr,
        truth_seconds,
    };
    outputs::write_images(arguments, &rendering.image, &truth, exposure)?;
    if let Some(path) = &arguments.adaptive.maps {
        write_file(path, &prediction_png(&rendering.prediction, [buffer.width, buffer.height]))?;
    }
    if let (Some(path), Some(rates)) = (&arguments.adaptive.rates, &rates) {
        write_file(path, &rates_png(rates))?;
    }
    if surface_points == 0 {
        note(common, &arguments.input, "no pixel shows a surface; check render.camera");
    }
    let checked = check(arguments, &verification, &truth);
    let seconds = started.elapsed().as_secs_f64();
    if common.json {
        print_json(&Report { version: 1, verification, seconds })?;
    } else {
        print(&text(&verification))?;
        remark(common, &format!("{seconds:.1} s"));
    }
    checked
}

fn timed<T>(run: impl FnOnce() -> Result<T, GpuError>) -> Result<(T, f64), Error> {
    let started = Instant::now();
    let found = run()?;
    Ok((found, started.elapsed().as_secs_f64()))
}

/// Resolves settings and points per pixel from the flags.
fn settings(options: &AdaptiveOptions) -> Result<(Settings, u32), Error> {
    let usage = |flag: &str, found: String, allowed: &str| Err(Error::wrong_usage(format!("--{flag}"), found, allowed));
    let default = Settings::default();
    let samples = options.budget.unwrap_or(default.samples);
    if !(0.01..=MAX_SAMPLES as f32).contains(&samples) {
        return usage("budget", format_number(samples), "0.01 to 1024");
    }
    let caution = options.caution.unwrap_or(default.caution);
    if !(0.001..=1000.0).contains(&caution) {
        return usage("caution", format_number(caution), "0.001 to 1000");
    }
    let directions = options.bandwidth_directions.unwrap_or(default.directions);
    let antialias = options.antialias.unwrap_or(1);
    if ![1, 4, 16].contains(&antialias) {
        return usage("antialias", antialias.to_string(), ANTIALIAS);
    }
    if let Some(tile) = options.rate_tile.filter(|tile| !RATE_TILES.contains(tile)) {
        return usage("rate-tile", tile.to_string(), RATE_TILE);
    }
    if let Some(limit) = options.min_psnr.filter(|limit| !limit.is_finite()) {
        return usage("min-psnr", limit.to_string(), "a number");
    }
    let antialiasing_levels = antialias.ilog2() / 2;
    Ok((Settings { samples, caution, directions, antialiasing_levels, ..default }, antialias))
}

/// Rejects flags that do not apply to adaptive shading.
fn refuse(arguments: &Arguments) -> Result<(), Error> {
    let flags = [
        (arguments.table, "--table", "renderings without it"),
        (arguments.max_delta_e.is_some(), "--max-delta-e", "renderings without it (use --min-psnr)"),
        (arguments.max_delta_e_p95.is_some(), "--max-delta-e-p95", "renderings without it (use --min-psnr)"),
        (arguments.max_flip.is_some(), "--max-flip", "renderings without it (use --min-psnr)"),
        (arguments.samples.is_some(), "--samples", "renderings without it (use --antialias)"),
        (arguments.repeat.is_some(), "--repeat", "renderings without it"),
    ];
    refuse_flags("--adaptive", &flags)
}

/// Returns the environment's map: from the build if the manifest's environment lights the scene, otherwise computed.
fn environment(arguments: &Arguments, subject: &Subject, environment: &Environment) -> Result<BandwidthMap, Error> {
    if let (Subject::Scene { packs: Some(packs), environment: Some(job), .. }, None) =
        (subject, &arguments.adaptive.environment)
        && job.maps[1]
        && let Some(Pack::Bandwidth(map)) =
            packs.environment(&EnvironmentJob { maps: [false, true], ..job.clone() }, &())?.pop()
    {
        return Ok(map);
    }
    environment_map(&environment.pixels, environment.width, DEFAULT_EPSILON)
        .map_err(|error| Error::internal(format!("environment: {error}")))
}

fn check(arguments: &Arguments, verification: &AdaptiveVerification, truth: &LinearImage) -> Result<(), Error> {
    let Some(limit) = arguments.adaptive.min_psnr else { return Ok(()) };
    if verification.surface_points == 0 {
        return Err(Error::check(format!("PSNR: no pixel shows a surface; expected at least {limit} dB")));
    }
    let invalid = verification.adaptive.invalid_pixels;
    if invalid > 0 {
        return Err(Error::check(format!("PSNR: {invalid} pixels are NaN or infinite; expected at least {limit} dB")));
    }
    if let Some(nothing) = nothing_shown(truth, verification.exposure) {
        return Err(Error::check(format!("PSNR: {nothing}; expected at least {limit} dB")));
    }
    match verification.adaptive.psnr {
        Some(psnr) if psnr < limit => {
            Err(Error::check(format!("PSNR: found {psnr:.2} dB, expected at least {limit} dB")))
        }
        _ => Ok(()),
    }
}

fn text(v: &AdaptiveVerification) -> String {
    let mut text = format!(
        "{}, {} x {} pixels, points per pixel: {}, exposure {}, environment {} x {}\ndrawn by {}{}\n",
        v.scene,
        v.width,
        v.height,
        v.points,
        significant(v.exposure),
        v.environment[0],
        v.environment[1],
        v.adapter.name,
        if v.adapter.software { ", a software driver" } else { "" },
    );
    for part in &v.parts {
        text += &format!("{}: {}, {}\n", part.part, part.material, crate::table::bytes(part.bytes_on_gpu));
    }
    for PartTextureReport { part, texture, metres: [width, height], repeats: [u, v] } in &v.textures {
        text += &format!("{part}: texture {texture}, {width} m x {height} m, {u} x {v} times per unit of uv\n");
    }
    let ignored = v.without_texture_bandwidth.iter().map(|shading| ("adaptive, t = 0", shading));
    let shadings = [("adaptive", &v.adaptive)].into_iter().chain(ignored).chain([("forward", &v.forward)]);
    let rows = shadings.map(|(name, shading)| {
        [
            name.to_owned(),
            shading.samples.to_string(),
            format!("{:.2}", shading.samples_per_point),
            shading.shaded.to_string(),
            format!("{:.2} s", shading.seconds),
            shading.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.2} dB")),
            format!("{:.4}", shading.flip),
        ]
    });
    let header = ["shading", "samples", "per point", "shaded pixels", "time", "PSNR", "FLIP"];
    text += &format!("\n{}\n", plain(&header, rows));
    let levels = v.levels.iter().enumerate().filter(|(_, level)| level.shaded > 0).map(|(number, level)| {
        [number.to_string(), level.pixels.to_string(), level.shaded.to_string(), level.samples.to_string()]
    });
    text += &plain(&["level", "pixels", "shaded", "samples"], levels);
    if let Some(rates) = &v.rates {
        let rows = rates.counts.map(|count| {
            [
                format!("{0} x {0}", count.side),
                count.tiles.to_string(),
                count.pixels.to_string(),
                count.shaded.to_string(),
            ]
        });
        text += &format!(
            "\n{}\nrates: {} x {} tiles of {} x {} pixels, {} of the pixels shaded{}.\n",
            plain(&["rate", "tiles", "pixels", "shaded"], rows),
            rates.width,
            rates.height,
            rates.tile,
            rates.tile,
            percent(rates.shaded_share()),
            rates.psnr.map_or(String::new(), |psnr| format!(", PSNR with these rates at most {psnr:.1} dB")),
        );
    }
    text += &format!(
        "\nbandwidth buffer: {:.3} s, {} of forward shading with {} samples. Ground truth: {} samples per point, \
         {:.1} s{}.\n",
        v.bandwidth_seconds,
        percent(v.bandwidth_seconds / v.forward.seconds.max(1e-9)),
        v.forward.samples_per_point,
        v.truth_samples,
        v.truth_seconds,
        v.truth_psnr.map_or(String::new(), |psnr| format!(", accurate to at least {psnr:.1} dB")),
    );
    for (name, shading) in [("adaptive", &v.adaptive), ("forward", &v.forward)] {
        if shading.invalid_pixels > 0 {
            text +=
                &format!("{name}: {} pixels are not numbers and are excluded from its PSNR.\n", shading.invalid_pixels);
        }
    }
    text
}
