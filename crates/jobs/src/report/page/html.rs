//! HTML of a page about a build.

use super::assets::assets;
use super::evidence::Thumbnails;
use super::figures::{albedos, error_over_bytes, errors_by_angle};
use super::gather::{Page, PageMaterial};
use super::markup::{colour_scale, document, image};
use super::parts::PagePart;
use super::view_link::{ViewLink, escaped};
use crate::report::material::{MaterialReport, remarks};
use crate::scene::lobes::LobesReport;
use brdfc_core::words::{bytes, percent};
use brdfc_metrics::by_angle::WorstPair;
use brdfc_metrics::fit_error::{COVERED, FitError};
use brdfc_render::rendering::Panel;
use brdfc_render::within::left_out_summary;
use maud::{Markup, PreEscaped, html};

/// Writes the page as HTML. Output is deterministic.
pub fn html(page: &Page) -> String {
    let failed = page.materials.iter().filter(|material| !material.entry.passed()).count()
        + page.assets.iter().filter(|asset| !asset.entry.passed()).count();
    let count = page.materials.len();
    let content = html! {
        p {
            (counts(count, page.assets.len()))
            @if page.left_out > 0 { "; " (page.left_out) " others passed and are left out" }
            @if failed > 0 { ", " span.bad { (failed) " of them failed or missed a requirement" } }
            "."
            @if count > 0 {
                " ΔE is the mean colour difference between renderings of a ball, pack against source (CIE L*a*b*; about \
                 1 is just visible); ε_r is the mean relative error of values."
            }
            @if page.materials.iter().any(is_of_a_range) {
                " * marks packs that cover only some directions; their errors are over those directions."
            }
            @if !page.skipped.is_empty() { " Not used by the scene: " (page.skipped.join(", ")) "." }
        }
        @if let Some(error) = page.environment.as_ref().and_then(|(entry, _)| entry.error.as_ref()) {
            p.bad { "environment: " (error) }
        }
        @if let Some(view) = &page.view {
            p { a href=(view.whole()) { "Open all packs in the viewer" } }
        }
        (regressions(page))
        @if !page.materials.is_empty() { (table(page)) }
        (lobes(page))
        (assets(&page.assets))
        @if page.materials.is_empty() {
        } @else if page.parts.is_empty() {
            h3 { "All packs" }
            (sheet(&page.materials))
            @for material in &page.materials { (section(material, page.view.as_ref())) }
        } @else {
            h3 { "Renderings" }
            p { @for (number, part) in page.parts.iter().enumerate() {
                a href=(escaped(part)) { (page.first_of(number)) } " "
            } }
        }
        (environment(page))
    };
    document(&format!("{}: packs and their errors", page.scene), &content)
}

/// Numbers of materials and of other assets.
fn counts(materials: usize, others: usize) -> String {
    let of = |count: usize, name: &str| if count == 1 { format!("one {name}") } else { format!("{count} {name}s") };
    let text = match (materials, others) {
        (materials, 0) => of(materials, "material"),
        (0, others) => of(others, "asset"),
        (materials, others) => format!("{}, {}", of(materials, "material"), of(others, "other asset")),
    };
    text.replacen("one", "One", usize::from(text.starts_with("one")))
}

/// Writes a page with the sections of some materials of `page`, whose file is `name`.
pub fn part_html(page: &Page, materials: &[PageMaterial], name: &str) -> String {
    let [first, last] = [materials.first(), materials.last()].map(|one| one.map_or("", |one| &one.entry.material));
    let content = html! {
        p { a href=(escaped(name)) { "All materials" } }
        (sheet(materials))
        @for material in materials { (section(material, page.view.as_ref())) }
    };
    document(&format!("{}: {first} to {last}", page.scene), &content)
}

fn regressions(page: &Page) -> Markup {
    html! {
        @if !page.regressions.is_empty() {
            div.regressions {
                h2 { "Regressions and missed requirements" }
                div.scroll { table {
                    thead { tr { th { "material" } th.left { "figure" } th { "before" } th { "now" } th { "growth" } } }
                    tbody { @for worse in &page.regressions { tr {
                        td { a href=[page.address(&worse.material)] { (worse.material) } }
                        td.left { (worse.figure) }
                        td.words[worse.growth.is_none()] { (worse.before) } td.bad.words[worse.growth.is_none()] { (worse.now) }
                        td { @if let Some(growth) = worse.growth { (percent(growth)) } @else { "-" } }
                    } } }
                } }
            }
        } @else if page.is_compared {
            p.good { "No figure is worse than in the earlier build, and all requirements are met." }
        }
    }
}

/// Returns true if a pack covers only some directions.
fn is_of_a_range(material: &PageMaterial) -> bool {
    material.entry.report.as_ref().is_some_and(|report| !report.directions.is_all())
}

/// Head of a sortable column.
fn head(name: &str) -> Markup {
    html! { th data-sorts="" { (name) } }
}

fn table(page: &Page) -> Markup {
    let heads =
        ["material", "codec", "size", "fetches", "on disk", "on GPU", "ΔE", "ΔE 95 %", "ε_r", "albedo error", ""];
    html! {
        div.scroll { table.all {
            thead { tr { @for name in heads { (head(name)) } } }
            tbody { @for material in &page.materials {
                @let entry = &material.entry;
                tr {
                    td {
                        a href=[page.address(&entry.material)] { (breakable(&entry.material)) }
                        @if entry.retained { " " span.soft { "retained" } }
                    }
                    @if let Some(report) = &entry.report {
                        @let rendering = &report.off_grid.rendering.delta_e;
                        td { (report.codec.variant()) } td { (report.codec.size()) } td { (report.fetches) }
                        td data-value=(report.bytes_on_disk) { (bytes(report.bytes_on_disk)) }
                        td data-value=(report.bytes_on_gpu) { (bytes(report.bytes_on_gpu)) }
                        td { (format!("{:.2}", rendering.mean)) @if !report.directions.is_all() { "*" } }
                        td { (format!("{:.2}", rendering.p95)) }
                        (share(report.off_grid.norms.relative_mean))
                        td { (format!("{:.3}", report.off_grid.albedo_max_difference)) }
                    } @else {
                        @for _ in 1..10 { td { "-" } }
                    }
                    td.left { @if entry.passed() { span.good { "passed" } } @else { span.bad { "failed" } } }
                }
            } }
        } }
    }
}

/// Look-ups, bytes and errors of lobes, one material per line.
fn lobes(page: &Page) -> Markup {
    let entries = page.materials.iter().map(|material| &material.entry);
    let rows: Vec<_> = entries.filter_map(|entry| Some((&entry.material, entry.lobes_report()?))).collect();
    html! {
        @if !rows.is_empty() {
            h3 { "Lobes: the light of an environment by a few look-ups" }
            p.soft {
                "ΔE is between renderings of a ball by lobes and by the integral over all directions, in four environments that the fit \
                 does not use and that are not those of the scene: noise, a sky with a sun, a studio and a room with lamps."
            }
            div.scroll { table.all {
                thead { tr { @for name in ["material", "look-ups", "on disk", "on GPU", "ΔE", "ΔE 95 %", ""] { (head(name)) } } }
                tbody { @for (name, lobes) in rows { tr {
                    td { a href=[page.address(name)] { (breakable(name)) } }
                    td { (lobes.facts.fetches) }
                    td data-value=(lobes.bytes_on_disk) { (bytes(lobes.bytes_on_disk)) }
                    td data-value=(lobes.facts.gpu_bytes) { (bytes(lobes.facts.gpu_bytes)) }
                    td { (format!("{:.2}", lobes.facts.delta_e.mean)) }
                    td { (format!("{:.2}", lobes.facts.delta_e.p95)) }
                    td.left { @if lobes.missed.is_none() { span.good { "passed" } } @else { span.bad { "failed" } } }
                } } }
            } }
        }
    }
}

fn share(value: f64) -> Markup {
    html! { td data-value=(value) { (percent(value)) } }
}

/// Renderings of all packs, each above its difference image.
fn sheet(materials: &[PageMaterial]) -> Markup {
    html! {
        p.soft { "ΔE is of the rendering shown. In the table it is the mean over a ball under each of three distant lights." }
        div.sheet { @for material in materials {
            @if let Some(thumbnails) = material.evidence.as_ref().and_then(|evidence| evidence.thumbnails.first()) {
                figure {
                    a href={ "#" (material.entry.material) } { (image(&thumbnails.pack, &material.entry.material)) }
                    @if let Some((difference, mean)) = &thumbnails.difference {
                        (image(difference, &format!("ΔE of {}", material.entry.material)))
                        figcaption {
                            (breakable(&material.entry.material)) br; "ΔE " (format!("{mean:.2}"))
                            (left_out_summary(thumbnails.left_out))
                        }
                    } @else {
                        figcaption { (breakable(&material.entry.material)) }
                    }
                }
            }
        } }
        (colour_scale())
    }
}

/// Lets a name break after `_`, `-` and `.`.
fn breakable(name: &str) -> Markup {
    html! { @for part in name.split_inclusive(['_', '-', '.']) { (part) wbr; } }
}

fn section(material: &PageMaterial, view: Option<&ViewLink>) -> Markup {
    let entry = &material.entry;
    html! {
        section.material id=(entry.material) {
            h2 { (entry.material) " " span.soft { (entry.source) } }
            @if entry.retained { p.soft { "Made by an earlier build and retained: the last build did not request it." } }
            @if let Some(error) = &entry.error { p.bad { (error) } }
            @if let Some(link) = view.and_then(|view| view.of_material(&entry.material)) {
                p { a href=(link) { "Open in the viewer" } }
            }
            @if let Some(report) = &entry.report {
                p {
                    (report.codec.variant()) " " (report.codec.size()) ", " (bytes(report.bytes_on_gpu)) " on the GPU, "
                    (bytes(report.bytes_on_disk)) " on disk, "
                    @if report.fetches == 1 { "one fetch" } @else { (report.fetches) " fetches" }
                    @if let Some(missed) = &report.missed { ". " span.bad { (missed) } }
                }
                @if let Some(fit) = &report.fit { (fit_summary(fit)) }
                @if !report.directions.is_all() {
                    p.soft {
                        "Covers only " (report.directions) ". Errors are over these directions. ΔE in the table is over pixels \
                         that sample these directions instead of a ball; renderings omit other directions."
                    }
                }
                @if let Some(missed) = entry.lobes_report().and_then(LobesReport::missed) { p.bad { (missed) } }
                @for gate in &entry.gates {
                    p class=(if gate.passed { "good" } else { "bad" }) {
                        @if gate.passed { "passed: " } @else { "failed: " } (gate)
                    }
                }
                (renderings(material))
                (plots(material, report))
                (worst(material))
                (maps(&entry.material, &material.maps))
                (checks(report))
                (times(material))
            }
        }
    }
}

/// Cross-validation errors of a fit to samples.
fn fit_summary(fit: &FitError) -> Markup {
    let or_unknown = |error: Option<f64>| error.map_or("unknown".to_owned(), percent);
    let gaps = [(fit.ball, "the ball's pixels"), (fit.test_directions, "the test directions")];
    let gaps = gaps.map(|(gaps, pairs)| {
        format!("{:.0}° at {pairs}, and farther than {COVERED}° at {} of them", gaps.farthest, percent(gaps.uncovered))
    });
    html! {
        p {
            "Fitted to samples: ε_r " (or_unknown(fit.samples)) " at held-out samples, " (or_unknown(fit.incidences))
            " at held-out incidences"
            @if let Some(delta_e) = fit.delta_e { ", about ΔE " (format!("{delta_e:.2}")) " on the ball" }
            ". Angles of lights and viewers from the nearest sample: up to " (gaps.join("; up to ")) "."
        }
    }
}

fn renderings(material: &PageMaterial) -> Markup {
    let Some(evidence) = &material.evidence else { return html! {} };
    let name = &material.entry.material;
    html! {
        @if let Some(reason) = &material.without_source { p.soft { "Not compared with its source: " (reason) } }
        div.row {
            @for drawn in &evidence.thumbnails { (triple(name, drawn, ["source", "pack"])) }
            @if let Some(drawn) = &evidence.in_environment {
                (triple(name, drawn, ["integral", "lobes"]))
            }
        }
    }
}

/// Renderings of the source and of a file, named by their captions, and their difference.
fn triple(name: &str, drawn: &Thumbnails, [of_source, of_file]: [&str; 2]) -> Markup {
    let Thumbnails { scene, turned, source, pack, difference, noise, left_out } = drawn;
    let noise = noise.map_or(String::new(), |noise| format!(", {noise:.2} by noise alone"));
    let how = if *turned { ", turned by 90°" } else { "" };
    let figure = |panel: &Panel, what: &str, caption: &str| {
        html! { figure { (image(panel, &format!("{scene} of {name}, {what}{how}"))) figcaption { (caption) } } }
    };
    html! {
        div.triple {
            @if let Some(source) = source { (figure(source, of_source, &format!("{of_source}{how}"))) }
            (figure(pack, of_file, &format!("{of_file}{}", left_out_summary(*left_out))))
            @if let Some((difference, mean)) = difference { (figure(difference, "difference", &format!("ΔE {mean:.2}{noise}"))) }
        }
    }
}

fn plots(material: &PageMaterial, report: &MaterialReport) -> Markup {
    let by_angle = material.evidence.as_ref().and_then(|evidence| evidence.by_angle.as_ref());
    let plot = |title: &str, drawn: String| {
        html! { div.plot { h3 { (title) } (PreEscaped(drawn)) } }
    };
    html! {
        div.row {
            @if let Some(by_angle) = by_angle { (plot("Error by incoming angle", errors_by_angle(&by_angle.angles))) }
            @if report.tried.len() > 1 {
                (plot("Error against bytes: tables blue, wavelets orange, ring: selected", error_over_bytes(report)))
            }
            (plot("Albedo: line source, dots pack", albedos(report)))
        }
    }
}

fn worst(material: &PageMaterial) -> Markup {
    let Some(by_angle) = material.evidence.as_ref().and_then(|evidence| evidence.by_angle.as_ref()) else {
        return html! {};
    };
    let colour = |f: [f64; 3]| f.map(|value| format!("{value:.4}")).join(" ");
    html! {
        @if !by_angle.worst.is_empty() {
            h3 { "Worst direction pairs" }
            div.scroll { table {
                thead { tr {
                    th { "θi" } th { "θo" } th { "φo - φi" } th { "source, 1/sr" } th { "pack, 1/sr" }
                } }
                tbody { @for pair in &by_angle.worst {
                    @let [theta_i, theta_o, phi] = angles(pair);
                    tr {
                        td { (format!("{theta_i:.1}°")) } td { (format!("{theta_o:.1}°")) } td { (format!("{phi:.1}°")) }
                        td { (colour(pair.reference)) } td { (colour(pair.approximation)) }
                    }
                } }
            } }
        }
    }
}

/// Polar angles, and the azimuth between both, degrees.
fn angles(pair: &WorstPair) -> [f64; 3] {
    let theta = |v: [f64; 3]| v[2].clamp(-1.0, 1.0).acos().to_degrees();
    let phi = |v: [f64; 3]| v[1].atan2(v[0]).to_degrees();
    let between = (phi(pair.outgoing) - phi(pair.incoming)).rem_euclid(360.0);
    [theta(pair.incoming), theta(pair.outgoing), between]
}

/// Table and images of maps.
fn maps(name: &str, parts: &[PagePart]) -> Markup {
    html! {
        @if !parts.is_empty() {
            h3 { "Light from the environment" }
            div.scroll { table {
                thead { tr { th { "file" } th { "on disk" } th { "on GPU" } th.left { "contents" } } }
                tbody { @for part in parts { tr {
                    td { (part.file) } td { (bytes(part.bytes_on_disk)) } td { (bytes(part.bytes_on_gpu)) }
                    td.left.words { (part.summary) }
                } } }
            } }
            div.row.large { @for part in parts {
                @if let Some(panel) = &part.image {
                    figure {
                        (image(panel, &format!("bandwidth of {name}")))
                        figcaption { "bandwidth, from 1/256 of the largest (dark) to the largest (light)" }
                    }
                }
            } }
        }
    }
}

fn environment(page: &Page) -> Markup {
    let Some((entry, parts)) = &page.environment else { return html! {} };
    html! {
        section.material id="environment" {
            h2 { "environment " span.soft { (entry.source) } }
            @if let Some(error) = &entry.error { p.bad { (error) } }
            (maps("the environment", parts))
        }
    }
}

fn checks(report: &MaterialReport) -> Markup {
    let off_grid = &report.off_grid;
    let over = off_grid.albedo.iter().flat_map(|point| point.approximation).fold(0.0, f64::max);
    html! {
        h3 { "Checks" }
        ul {
            li { "largest albedo of the pack " (format!("{over:.3}")) @if over > 1.0 { span.bad { ", not energy-conserving" } } }
            li { "largest albedo error " (format!("{:.4}", off_grid.albedo_max_difference)) }
            li { "values change by " (percent(off_grid.reciprocity)) " when light and viewer are exchanged" }
            @for line in remarks(report) { li { (line) } }
        }
    }
}

fn times(material: &PageMaterial) -> Markup {
    let stages = &material.note.stages;
    let mut sums: Vec<(&str, f64)> = Vec::new();
    for stage in stages {
        match sums.iter_mut().find(|(name, _)| *name == stage.stage) {
            Some((_, seconds)) => *seconds += stage.seconds,
            None => sums.push((&stage.stage, stage.seconds)),
        }
    }
    let listed: Vec<String> = sums.iter().map(|(name, seconds)| format!("{name} {seconds:.2} s")).collect();
    html! { @if !listed.is_empty() { p.soft { "Build times: " (listed.join(", ")) } } }
}
