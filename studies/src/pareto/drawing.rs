//! Bytes and seconds against colour differences, two panels for each material.

use super::{ParetoMaterial, ParetoRow, ParetoStudy};
use plotters::prelude::*;

/// Pixels of a panel.
const PANEL: (u32, u32) = (520, 340);
/// Codecs, and grids of wavelets, in the order of the legend.
const SERIES: [(&str, RGBColor); 6] = [
    ("table", RGBColor(0, 90, 181)),
    ("factored", RGBColor(220, 50, 32)),
    ("wavelet 8²", RGBColor(200, 150, 0)),
    ("wavelet 16²", RGBColor(0, 140, 90)),
    ("wavelet 32²", RGBColor(150, 90, 200)),
    ("wavelet 64²", RGBColor(110, 110, 110)),
];

/// The figure as SVG on white: on the left bytes on a GPU, on the right seconds of encoding. Rows on the front are
/// large and joined by a line.
///
/// # Errors
/// Returns the error of the drawing library.
pub fn drawing(study: &ParetoStudy) -> Result<String, String> {
    let rows = study.materials.len().max(1);
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (2 * PANEL.0, PANEL.1 * rows as u32)).into_drawing_area();
        root.fill(&WHITE).map_err(|error| error.to_string())?;
        for (areas, material) in root.split_evenly((rows, 2)).chunks(2).zip(&study.materials) {
            panel(&areas[0], material, &BYTES).map_err(|error| error.to_string())?;
            panel(&areas[1], material, &SECONDS).map_err(|error| error.to_string())?;
        }
        root.present().map_err(|error| error.to_string())?;
    }
    Ok(text)
}

/// The horizontal axis.
struct Cost {
    name: &'static str,
    of: fn(&ParetoRow) -> f64,
    on_front: fn(&ParetoRow) -> bool,
    label: fn(f64) -> String,
    /// Position of the legend, in an empty corner.
    legend: SeriesLabelPosition,
}

const BYTES: Cost = Cost {
    name: "bytes on a GPU",
    of: |row| row.bytes_on_gpu as f64,
    on_front: |row| row.on_bytes_front,
    label: |bytes| match bytes {
        b if b >= 1e6 => format!("{} MB", b / 1e6),
        b if b >= 1e3 => format!("{} kB", b / 1e3),
        b => format!("{b} B"),
    },
    legend: SeriesLabelPosition::UpperRight,
};

const SECONDS: Cost = Cost {
    name: "seconds of encoding",
    of: |row| row.encode_seconds,
    on_front: |row| row.on_seconds_front,
    label: |seconds| format!("{seconds}"),
    legend: SeriesLabelPosition::LowerLeft,
};

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

fn panel(area: &Area<'_>, material: &ParetoMaterial, cost: &Cost) -> Result<(), DrawingAreaErrorKind<std::io::Error>> {
    let point = |row: &ParetoRow| ((cost.of)(row), row.delta_e.max(MIN_DELTA_E));
    let mut chart = ChartBuilder::on(area)
        .caption(&material.material, ("sans-serif", 15))
        .margin(8)
        .x_label_area_size(34)
        .y_label_area_size(48)
        .build_cartesian_2d(
            range(material.rows.iter().map(|row| point(row).0)).log_scale(),
            range(material.rows.iter().map(|row| point(row).1)).log_scale(),
        )?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .x_desc(cost.name)
        .y_desc("mean ΔE")
        .x_label_formatter(&|value| (cost.label)(*value))
        .y_label_formatter(&|error| format!("{error}"))
        .draw()?;
    let mut front: Vec<(f64, f64)> =
        material.rows.iter().filter(|row| (cost.on_front)(row) && row.delta_e.is_finite()).map(point).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.total_cmp(&a.1)));
    chart
        .draw_series(LineSeries::new(front, BLACK.stroke_width(1)))?
        .label("front")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 14, y)], BLACK));
    for (name, colour) in SERIES {
        let of_series: Vec<&ParetoRow> = material.rows.iter().filter(|row| series(row) == name).collect();
        if of_series.is_empty() {
            continue;
        }
        let circle = |row: &&ParetoRow| {
            let (size, style) = if (cost.on_front)(row) { (5, colour.filled()) } else { (2, colour.mix(0.6).filled()) };
            Circle::new(point(row), size, style)
        };
        chart
            .draw_series(of_series.iter().map(circle))?
            .label(name)
            .legend(move |(x, y)| Circle::new((x + 7, y), 4, colour.filled()));
    }
    chart
        .configure_series_labels()
        .position(cost.legend.clone())
        .background_style(WHITE.mix(0.8))
        .label_font(("sans-serif", 11))
        .draw()
}

fn series(row: &ParetoRow) -> String {
    row.wavelet.map_or_else(|| row.codec.clone(), |wavelet| format!("{} {}²", row.codec, wavelet.grid))
}

/// Smaller differences are drawn as this value.
const MIN_DELTA_E: f64 = 1e-4;

/// Range from slightly below the smallest to slightly above the largest.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let values = values.filter(|value| value.is_finite());
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
    if low < high { 0.7 * low..1.4 * high } else { 0.1..10.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(codec: &str, bytes_on_gpu: u64, delta_e: f64) -> ParetoRow {
        ParetoRow {
            codec: codec.to_owned(),
            setting: String::new(),
            wavelet: None,
            bytes_on_gpu,
            bytes_on_disk: 0,
            fetches: 1,
            encode_seconds: 1.0,
            runs: 1,
            decode_rate: 1.0,
            delta_e,
            delta_e_p95: 0.0,
            relative_error: 0.0,
            on_bytes_front: false,
            on_seconds_front: false,
        }
    }

    /// A point for each row, a large one for each on a front. Black materials have an error of 0, which has no
    /// logarithm.
    #[test]
    fn points_are_drawn_and_those_on_the_front_are_large() {
        let rows = vec![row("table", 100, 1.0), row("table", 200, 2.0), row("factored", 400, 0.0)];
        let materials = vec![ParetoMaterial::marked("paint", rows)];
        let drawn = drawing(&ParetoStudy { threads: 1, materials }).unwrap();
        let count = |radius: &str| drawn.matches(radius).count();
        assert_eq!((count("r=\"5\""), count("r=\"2\"")), (3, 3), "{drawn}");
        assert!(drawn.contains("paint") && drawn.contains("seconds of encoding"));
        assert!(drawing(&ParetoStudy { threads: 1, materials: Vec::new() }).is_ok());
    }
}
