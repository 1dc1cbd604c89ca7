//! Small SVG plots in the colours of the surrounding text.

use super::super::material::MaterialReport;
use brdfc_metrics::by_angle::AngleError;
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::prelude::*;

const SIZE: (u32, u32) = (300, 180);
/// Placeholder for the text colour, which replaces it.
const INK: RGBColor = RGBColor(1, 2, 3);
/// Placeholder for the colour of grid lines.
const FAINT: RGBColor = RGBColor(4, 5, 6);
/// Colours of series, distinct on light and dark pages.
const FIRST: RGBColor = RGBColor(59, 130, 206);
const SECOND: RGBColor = RGBColor(217, 119, 43);

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), Box<dyn std::error::Error>>;

/// Mean relative error over the polar angle of incoming light.
pub(super) fn errors_by_angle(angles: &[AngleError]) -> String {
    let most = angles.iter().map(|angle| angle.relative_mean).filter(|e| e.is_finite()).fold(1e-3, f64::max);
    plot(|area| {
        let mut chart = chart(area).build_cartesian_2d(0.0..90.0f64, 0.0..100.0 * 1.1 * most)?;
        mesh(&mut chart, "incoming angle, degrees", "ε_r, %")?;
        let bar = |angle: &AngleError| {
            let top = 100.0 * angle.relative_mean;
            Rectangle::new([(angle.from + 1.0, 0.0), (angle.from + 9.0, top)], FIRST.filled())
        };
        chart.draw_series(angles.iter().filter(|angle| angle.relative_mean.is_finite()).map(bar))?;
        Ok(())
    })
}

/// Mean ΔE over bytes: all packs that were tried, and the selected pack.
pub(super) fn error_over_bytes(report: &MaterialReport) -> String {
    let selected = (report.bytes_on_gpu as f64, report.off_grid.rendering.delta_e.mean.max(1e-3));
    let tried: Vec<(f64, f64, bool)> = report
        .tried
        .iter()
        .map(|trial| (trial.bytes_on_gpu as f64, trial.delta_e.max(1e-3), trial.codec == "wavelet"))
        .filter(|(_, error, _)| error.is_finite())
        .collect();
    let all = || tried.iter().map(|(bytes, error, _)| (*bytes, *error)).chain([selected]);
    let ends = |values: &mut dyn Iterator<Item = f64>| {
        let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
        (0.7 * low)..(1.4 * high)
    };
    let (bytes, errors) = (ends(&mut all().map(|point| point.0)), ends(&mut all().map(|point| point.1)));
    plot(|area| {
        let mut chart = chart(area).build_cartesian_2d(bytes.log_scale(), errors.log_scale())?;
        mesh(&mut chart, "bytes on the GPU", "mean ΔE")?;
        let point = |(bytes, error, wavelet): &(f64, f64, bool)| {
            Circle::new((*bytes, *error), 3, if *wavelet { SECOND } else { FIRST }.filled())
        };
        chart.draw_series(tried.iter().map(point))?;
        chart.draw_series([Circle::new(selected, 6, INK.stroke_width(2))])?;
        Ok(())
    })
}

/// Albedo of source and pack over the polar angle of incoming light, as the mean of the channels.
pub(super) fn albedos(report: &MaterialReport) -> String {
    let first = report.off_grid.albedo.iter().filter(|point| point.phi == 0.0);
    let grey = |colour: [f64; 3]| colour.iter().sum::<f64>() / 3.0;
    let points: Vec<[f64; 3]> =
        first.map(|point| [point.theta, grey(point.reference), grey(point.approximation)]).collect();
    let most = points.iter().flat_map(|p| [p[1], p[2]]).filter(|v| v.is_finite()).fold(1e-3, f64::max);
    plot(|area| {
        let mut chart = chart(area).build_cartesian_2d(0.0..90.0f64, 0.0..1.15 * most)?;
        mesh(&mut chart, "incoming angle, degrees", "albedo")?;
        chart.draw_series(LineSeries::new(points.iter().map(|p| (p[0], p[1])), INK.stroke_width(1)))?;
        chart.draw_series(points.iter().map(|p| Circle::new((p[0], p[2]), 2, SECOND.filled())))?;
        Ok(())
    })
}

fn chart<'a, 'b>(area: &'a Area<'b>) -> ChartBuilder<'a, 'b, SVGBackend<'b>> {
    let mut chart = ChartBuilder::on(area);
    chart.margin(6).x_label_area_size(28).y_label_area_size(44);
    chart
}

fn mesh<'a, X, Y>(
    chart: &mut ChartContext<'a, SVGBackend<'_>, Cartesian2d<X, Y>>,
    horizontal: &str,
    vertical: &str,
) -> Drawn
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let label = ("sans-serif", 11).into_font().color(&INK);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(FAINT)
        .axis_style(INK)
        .x_labels(5)
        .y_labels(4)
        .label_style(label.clone())
        .axis_desc_style(label)
        .x_label_formatter(&|value| short(*value))
        .y_label_formatter(&|value| short(*value))
        .x_desc(horizontal)
        .y_desc(vertical)
        .draw()?;
    Ok(())
}

/// Formats a number with few digits, and `k` and `M` for thousands and millions.
fn short(value: f64) -> String {
    match value.abs() {
        large if large >= 1e6 => format!("{:.0}M", value / 1e6),
        large if large >= 1e3 => format!("{:.0}k", value / 1e3),
        large if large >= 10.0 || value.fract() == 0.0 => format!("{value:.0}"),
        large if large >= 0.1 => format!("{value:.1}"),
        _ => format!("{value:.2}"),
    }
}

fn plot(draw: impl FnOnce(&Area<'_>) -> Drawn) -> String {
    let mut text = String::new();
    let drawn = {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        draw(&root).and_then(|()| root.present().map_err(Into::into))
    };
    // The page is written even if a plot cannot be drawn.
    if drawn.is_err() {
        return String::new();
    }
    text.replace("#010203", "currentColor").replace("#040506", "var(--faint)")
}
