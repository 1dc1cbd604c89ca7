//! The error study of flat BTFs.

use super::arguments::Arguments;
use super::remarks::Remarks;
use super::structures::{file_stem, short_name, structures};
use brdfc_core::words::format_number;
use brdfc_render::rendering::rgb_png;
use brdfc_studies::StudyResult;
use brdfc_studies::flat_btf::{ModelRow, StudyError, StudySettings, TexelSizes, study_model};
use brdfc_terminal::directions::{default_set, direction_set};
use brdfc_terminal::output::{make_folder, write_file};
use brdfc_terminal::table::plain;
use brdfc_terminal::{Common, Error};

/// Texels of the plane per side. The flat BTF has twice as many per side, 256 as in the paper.
const TEXELS: usize = 128;
/// Polar angles x rows of azimuths of the indirection map. Azimuths are as close as in `ubo2003` at its largest polar
/// angle, where blending views loses most.
const INDIRECTION: [u32; 2] = [16, 25];
const LARGEST_ANGLE: f64 = 80.0;
/// Maximum number of samples of the indirection map, 512 MiB.
const MAX_SAMPLES: usize = 1 << 26;

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let texels = arguments.texels.unwrap_or(TEXELS);
    let flat_texels = arguments.flat_texels.unwrap_or(2 * texels.next_power_of_two());
    for (option, value, most) in [("texels", texels, 512), ("flat-texels", flat_texels, 1024)] {
        if !(8..=most).contains(&value) {
            return Err(Error::usage(format!("--{option}: found {value}, expected 8 to {most}")));
        }
    }
    if !flat_texels.is_power_of_two() {
        return Err(Error::usage(format!("--flat-texels: found {flat_texels}, expected a power of two")));
    }
    let largest_angle = arguments.largest_angle.unwrap_or(LARGEST_ANGLE);
    if !(largest_angle > 0.0 && largest_angle <= 89.0) {
        return Err(Error::wrong_usage("--largest-angle", format_number(largest_angle), "above 0, up to 89 degrees"));
    }
    let indirection = arguments.indirection.unwrap_or(INDIRECTION);
    let samples = texels * texels * indirection.map(|count| count as usize).into_iter().product::<usize>();
    if samples > MAX_SAMPLES {
        let allowed = format!("at most {MAX_SAMPLES}; lower --texels or --indirection");
        return Err(Error::wrong_usage("--texels x --indirection", format!("a map of {samples} samples"), allowed));
    }
    let directions = direction_set("directions", arguments.directions.as_ref().unwrap_or(&default_set()))?;
    let settings = StudySettings {
        texels,
        flat_texels,
        oversampling: 1,
        indirection,
        largest_angle,
        rounds: 0,
        directions: directions.name.clone(),
        count: directions.len(),
    };
    let directions = directions.directions();
    let structures = structures(arguments)?;
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    let remarks = Remarks::new(common, structures.len() * directions.len());
    let mut rows = Vec::new();
    for (input, address) in structures {
        let study = study_model(&address, &settings, &directions, &|| remarks.done(1));
        let (row, figures) = study.map_err(|error| match error {
            StudyError::Address(error) => Error::input(format!("{input}: {error}")),
            StudyError::Parameterise(error) => Error::input(format!("{input}: {error}")),
            StudyError::Encode(error) => Error::input(format!("{input}: {error}")),
        })?;
        if let Some(folder) = &arguments.out {
            for (figure, panel) in figures.named() {
                write_file(&folder.join(format!("{figure}-{}.png", file_stem(&address))), &rgb_png(panel))?;
            }
        }
        rows.push(row);
    }
    Ok(StudyResult::FlatBtf { settings, rows })
}

pub(super) fn text(settings: &StudySettings, rows: &[ModelRow]) -> String {
    let mut text = format!(
        "{0} views and lights ({1}), {2} x {2} texels of the plane, {3} x {3} of the flat BTF, {4} x {5} polar \
         angles and rows of azimuths of the indirection map up to {6}°.\n\n",
        settings.count,
        settings.directions,
        settings.texels,
        settings.flat_texels,
        settings.indirection[0],
        settings.indirection[1],
        settings.largest_angle
    );
    text += "Table 1: colour difference (L*a*b*) of BTFs rebuilt by equation 1; maximum and variance of means of images. \
         Through the map: by the indirection map, whose views are blended; exact rays: instead of the map, errors of \
         the flat BTF alone\n";
    let header = ["model", "through the map", "max", "variance", "exact rays", "max", "variance"];
    let header = [&header[..], &["paper", "mean", "max", "variance"]].concat();
    text += &table(&header, rows, |row| {
        let (r, p) = (&row.reconstruction, &row.paper.reconstruction);
        let ours = [r.through_map, r.exact_rays].map(|e| [e.mean, e.largest_image, e.image_variance].map(two));
        let paper = p.map(two);
        [name(row)]
            .into_iter()
            .chain(ours.into_iter().flatten())
            .chain([row.paper_model.to_owned()])
            .chain(paper)
            .collect()
    });
    text += "\nTable 1, means by polar angle of the view. Unblended: through a map that contains each view\n";
    let header = ["model", "polar angle", "views", "through the map", "unblended", "exact rays"];
    let cells = rows.iter().flat_map(|row| {
        row.reconstruction.angles.iter().map(|a| {
            let means = [a.through_map, a.unblended, a.exact_rays].map(two);
            [name(row), format!("{:.0}°", a.polar_angle), a.views.to_string()]
                .into_iter()
                .chain(means)
                .collect::<Vec<_>>()
        })
    });
    text += &plain(&header, cells);
    text +=
        "\nTable 1, means through the map, through its compact form, with holes filled by push-pull, and unblended\n";
    text += &table(&["model", "through the map", "compact", "push-pull", "unblended"], rows, |row| {
        let r = &row.reconstruction;
        let means = [r.through_map.mean, r.mean_compact, r.mean_push_pull, r.mean_unblended];
        [name(row)].into_iter().chain(means.map(two)).collect()
    });
    text += "\nTable 2: variance over the views (L*a*b*), mean over texels; in brackets how many times lower than the BTF's\n";
    let header = ["model", "BTF", "push-pull", "poisson", "visible", "paper: BTF", "filled", "visible"];
    text += &table(&header, rows, |row| {
        let (c, p) = (&row.coherency, &row.paper.average_variance);
        let lower = |value: f64, of: f64| match value {
            v if v < 1e-6 => "0".to_owned(),
            v => format!("{v:.2} ({:.1})", of / v),
        };
        let ours = [c.push_pull.mean, c.poisson.mean, c.visible.mean].map(|v| lower(v, c.btf.mean));
        let [a, b, d] = ours;
        vec![name(row), two(c.btf.mean), a, b, d, two(p[0]), lower(p[1], p[0]), lower(p[2], p[0])]
    });
    text += "\nTable 2, maximum over texels\n";
    text += &table(&header, rows, |row| {
        let (c, p) = (&row.coherency, &row.paper.maximal_variance);
        let ours = [c.btf.max, c.push_pull.max, c.poisson.max, c.visible.max, p[0], p[1], p[2]].map(two);
        std::iter::once(name(row)).chain(ours).collect()
    });
    text += "\nTable 3: kilobytes of images of apparent BRDFs, flat < ordinary; the mean is over 64 texels\n";
    let header = ["model", "as", "mean", "texel 1", "texel 2", "paper: texel 1", "texel 2"];
    let cells = rows.iter().flat_map(|row| {
        let sizes = |of: fn(&TexelSizes) -> [f64; 2]| {
            let [first, second] = [0, 1].map(|k| row.apparent.texels.get(k).map_or([0.0; 2], of));
            [of(&row.apparent.mean), first, second].map(|sizes| less(sizes.map(|bytes| bytes / 1e3)))
        };
        let line = |form: &str, ours: [String; 3], paper: Option<[[f64; 2]; 2]>| {
            let paper = paper.map_or([(); 2].map(|()| "-".to_owned()), |paper| paper.map(less));
            [name(row), form.to_owned()].into_iter().chain(ours).chain(paper).collect::<Vec<_>>()
        };
        [
            line("PNG", sizes(|t| [t.flat_png, t.btf_png]), Some(row.paper.png_kilobytes)),
            line("JPEG", sizes(|t| [t.flat_jpeg, t.btf_jpeg]), Some(row.paper.jpeg_kilobytes)),
            line("Zstandard", sizes(|t| [t.flat_zstd, t.btf_zstd]), None),
        ]
    });
    text += &plain(&header, cells);
    text +=
        "\nFigure 10: distance of blended from real indirections in 1/256 of the tile, mean (median), by polar angle\n";
    let header =
        ["model", "grid", "all", "0-10°", "10-20°", "20-30°", "30-40°", "40-50°", "50-60°", "60-70°", "70-80°"];
    let cells = rows.iter().flat_map(|row| {
        row.grids.iter().map(|grid| {
            let both = |mean: f64, median: f64| format!("{mean:.1} ({median:.2})");
            let bands = grid.bands.iter().zip(&grid.band_medians).map(|(mean, median)| both(*mean, *median));
            let first = [name(row), format!("{} x {}", grid.polar_angles, grid.azimuth_rows)];
            first.into_iter().chain([both(grid.mean, grid.median)]).chain(bands).collect::<Vec<_>>()
        })
    });
    text + &plain(&header, cells) + "\nThe paper's models are not ours: its figures show the magnitude to expect.\n"
}

fn table(header: &[&str], rows: &[ModelRow], cells: impl Fn(&ModelRow) -> Vec<String>) -> String {
    plain(header, rows.iter().map(cells))
}

fn less([flat, ordinary]: [f64; 2]) -> String {
    let sign = if flat < ordinary { "<" } else { ">=" };
    format!("{flat:.1} {sign} {ordinary:.1}")
}

fn name(row: &ModelRow) -> String {
    short_name(&row.model)
}

fn two(value: f64) -> String {
    format!("{value:.2}")
}
