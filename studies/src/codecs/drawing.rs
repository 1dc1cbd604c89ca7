//! Bytes and colour differences, a line per codec and a panel per material.

use super::{CodecMaterial, CodecRow, CodecStudy, envelope};
use plotters::prelude::*;

/// Pixels of a panel.
const PANEL: (u32, u32) = (460, 340);
const COLUMNS: usize = 3;
/// Codecs in the order of the legend. The line of `bc6h` and `bc7` is their lower envelope, like those of zfp and SZ3.
const CODECS: [(&str, RGBColor); 9] = [
    ("table", RGBColor(0, 90, 181)),
    ("factored", RGBColor(220, 50, 32)),
    ("wavelet", RGBColor(120, 120, 120)),
    ("zfp", RGBColor(0, 140, 90)),
    ("sz3", RGBColor(150, 90, 200)),
    ("bc6h", RGBColor(200, 150, 0)),
    ("bc7", RGBColor(230, 120, 180)),
    ("ggx", RGBColor(0, 0, 0)),
    ("neural", RGBColor(0, 170, 200)),
];

/// The figure as SVG. The horizontal axis has the bytes of a codec: for zfp and SZ3 on disk, for others on the GPU.
///
/// # Errors
/// Returns the error of the drawing library.
pub fn drawing(study: &CodecStudy) -> Result<String, String> {
    let rows = study.materials.len().div_ceil(COLUMNS).max(1);
    let columns = study.materials.len().clamp(1, COLUMNS);
    let size = (PANEL.0 * columns as u32, PANEL.1 * rows as u32);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        for (area, material) in root.split_evenly((rows, columns)).iter().zip(&study.materials) {
            panel(area, material).map_err(|error| error.to_string())?;
        }
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn panel(area: &Area<'_>, material: &CodecMaterial) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let mut chart = ChartBuilder::on(area)
        .caption(&material.material, ("sans-serif", 15))
        .margin(8)
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d((16.0..4.0e6f64).log_scale(), (0.02..40.0f64).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc("bytes")
        .y_desc("mean ΔE")
        .x_label_formatter(&|bytes| size(*bytes))
        .y_label_formatter(&|error| format!("{error}"))
        .draw()?;
    for (codec, colour) in CODECS {
        let points = worth_drawing(material, codec);
        if points.is_empty() {
            continue;
        }
        let style = ShapeStyle { color: colour.to_rgba(), filled: true, stroke_width: 2 };
        chart
            .draw_series(LineSeries::new(points.iter().copied(), style))?
            .label(codec)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 14, y)], style));
        chart.draw_series(points.iter().map(|point| Circle::new(*point, 2, style)))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerLeft)
        .background_style(WHITE.mix(0.8))
        .label_font(("sans-serif", 11))
        .draw()
}

fn size(bytes: f64) -> String {
    match bytes {
        b if b >= 1e6 => format!("{} MB", b / 1e6),
        b if b >= 1e3 => format!("{} kB", b / 1e3),
        b => format!("{b} B"),
    }
}

/// Points of a codec on its front: no smaller one has a smaller error.
fn worth_drawing(material: &CodecMaterial, codec: &str) -> Vec<(f64, f64)> {
    let bytes = |row: &CodecRow| if row.sampled { row.bytes_on_gpu } else { row.bytes_on_disk } as f64;
    let of_codec = material.rows.iter().filter(|row| row.codec == codec);
    envelope(of_codec.map(|row| (bytes(row), row.delta_e)).collect())
}
