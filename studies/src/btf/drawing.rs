//! Bytes and colour differences: a panel for each structure, a symbol for each method.

use super::{BtfAsset, BtfModel, BtfStudy};
use plotters::prelude::*;

/// Pixels of a panel.
const PANEL: (u32, u32) = (460, 360);
const COLUMNS: usize = 2;
/// Upper end of a panel's error axis, relative to the largest error, which leaves room for the legend.
const LEGEND: f64 = 1.55;
/// Prefixes of the names of methods, their names in the legend, and their colours.
const WAYS: [(&str, &str, RGBColor); 5] = [
    ("PTM", "PTM", RGBColor(220, 50, 32)),
    ("HSH", "HSH", RGBColor(200, 150, 0)),
    ("PWT of", "PWT of light and view", RGBColor(150, 90, 200)),
    ("PWT", "PWT", RGBColor(0, 90, 181)),
    ("factored", "factored", RGBColor(0, 140, 90)),
];

/// The figure as SVG. Full circles are for the ordinary BTF, open ones for the flat one.
///
/// # Errors
/// Returns the error of the drawing library.
pub fn drawing(study: &BtfStudy) -> Result<String, String> {
    let rows = study.models.len().div_ceil(COLUMNS).max(1);
    let columns = study.models.len().clamp(1, COLUMNS);
    let mut text = String::new();
    {
        let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        for (area, model) in root.split_evenly((rows, columns)).iter().zip(&study.models) {
            panel(area, model).map_err(|error| error.to_string())?;
        }
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// Bytes and errors of a method.
fn points(asset: &BtfAsset, way: usize) -> Vec<(f64, f64)> {
    let of_way = |method: &str| WAYS.iter().position(|(start, ..)| method.starts_with(start)) == Some(way);
    let rows = asset.rows.iter().filter(|row| of_way(&row.method));
    rows.map(|row| (row.bytes as f64, row.delta_e)).collect()
}

fn panel(area: &Area<'_>, model: &BtfModel) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let all = (0..WAYS.len()).flat_map(|way| [points(&model.classic, way), points(&model.flat, way)].concat());
    let [low, high, error] = all.fold([f64::MAX, 1.0, 1.0], |[low, high, error], (bytes, delta_e)| {
        [low.min(bytes), high.max(bytes), error.max(delta_e)]
    });
    let name = model.model.split('?').next().unwrap_or_default();
    let mut chart = ChartBuilder::on(area)
        .caption(format!("{name}: full circles ordinary BTF, open ones flat"), ("sans-serif", 14))
        .margin(8)
        .x_label_area_size(34)
        .y_label_area_size(40)
        .build_cartesian_2d((0.5 * low.min(high)..2.0 * high).log_scale(), 0.0..LEGEND * error)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("bytes")
        .y_desc("mean ΔE")
        .x_label_formatter(&|bytes| match *bytes {
            b if b >= 1e6 => format!("{} MB", b / 1e6),
            b => format!("{} kB", b / 1e3),
        })
        .draw()?;
    for (way, (_, name, colour)) in WAYS.into_iter().enumerate() {
        let style = move |filled| ShapeStyle { color: colour.to_rgba(), filled, stroke_width: 2 };
        chart
            .draw_series(points(&model.classic, way).into_iter().map(|at| Circle::new(at, 4, style(true))))?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 7, y), 4, style(true)));
        chart.draw_series(points(&model.flat, way).into_iter().map(|at| Circle::new(at, 4, style(false))))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .label_font(("sans-serif", 11))
        .draw()
}
