//! Registration of wavelet packs as a BRDF codec.

use super::crop::{needed_coefficients, window};
use super::encode::{self, check, encode_tabulated};
use super::energy::{needed_in_trees, slices_of_pack};
use super::measure::GridError;
use super::recipe::{Ranking, Recipe, Target};
use super::table::Grid;
use super::tabulated::Tabulated;
use brdfc_codec::{
    BrdfRecipe, BrdfReport, Encode, EncodeError, EncodeOptions, Encoded, ErrorLimits, GridCache, Message, OptionError,
    Predicted, Variant,
};
use brdfc_core::Source;
use brdfc_core::progress::{Progress, Stage};
use brdfc_core::words::{bytes, format_number, percent, quoted};
use brdfc_formats::BrdfPack;
use brdfc_formats::crop::{DirectionRange, Window};
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::{Header, MAX_LEVELS, gpu_bytes};
use brdfc_metrics::norms::Norms;
use serde::{Deserialize, Serialize};

/// The name of the codec.
const WAVELET: &str = "wavelet";

/// Memory of an encoding without its source and its grids, bytes; measured with a scan.
const MEMORY: u64 = 16 << 20;

/// Report of a wavelet pack.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct WaveletReport {
    /// Parameterisation of the two hemispheres of the table.
    pub parameterisation: Parameterisation,
    /// Cells per axis and hemisphere.
    pub grid: usize,
    /// Finest level of detail that is stored.
    pub stored_levels: u32,
    /// Bits per component.
    pub bits: u32,
    /// True if each level of detail has a tree of its own, which preserves energy.
    pub energy_preserving: bool,
    /// Number of retained slices, without the zero slice.
    pub slices_retained: usize,
    /// Number of wavelet coefficients, and of slices at 1:1.
    pub slices_in_all: usize,
    /// Compression ratio: `slices_in_all / slices_retained`.
    pub ratio: f64,
    /// Codec error: decoded table against table.
    pub on_grid: GridError,
}

impl BrdfReport for WaveletReport {
    fn variant(&self) -> &'static str {
        WAVELET
    }

    fn size(&self) -> String {
        format!("{}/{} slices", self.slices_retained, self.slices_in_all)
    }

    fn on_grid(&self) -> Option<&Norms> {
        Some(&self.on_grid.norms)
    }
}

impl BrdfRecipe for Recipe {
    fn variant(&self) -> &'static str {
        WAVELET
    }

    fn target(&self) -> String {
        let target = match self.target {
            Target::Ratio(ratio) => format!("{ratio}:1"),
            Target::MaxError(error) => format!("ε_r at most {}", percent(error)),
            Target::MaxBytes(most) => format!("at most {}", bytes(most)),
        };
        let (grid, stored, levels) = (1u32 << self.levels, self.stored_levels, self.levels);
        format!("{target}, {grid} x {grid}, {stored} of {levels} levels, {} bits", self.bits)
    }

    fn directions(&self) -> DirectionRange {
        self.directions
    }

    fn limit_directions(&mut self, directions: DirectionRange) {
        self.directions = directions;
    }

    fn has_fixed_size(&self) -> bool {
        matches!(self.target, Target::Ratio(_))
    }

    fn limits_error(&self) -> bool {
        matches!(self.target, Target::MaxError(_))
    }

    fn asked_errors(&self) -> ErrorLimits {
        match self.target {
            Target::MaxError(most) => ErrorLimits { relative: Some(most), ..ErrorLimits::default() },
            _ => ErrorLimits::default(),
        }
    }

    fn skip_measuring(&mut self) {
        self.measure_off_grid = false;
    }

    fn set_supercompress(&mut self, supercompress: bool) {
        self.supercompress = supercompress;
    }

    fn stored_levels(&self) -> Option<[u32; 2]> {
        Some([self.stored_levels, self.levels])
    }

    fn limit_levels(&mut self, finest: &dyn Fn(u32) -> u32) {
        self.stored_levels = finest(self.levels);
    }

    fn memory(&self) -> u64 {
        // Grid and coefficients, three channels of f32 each; those of coarser levels are a third.
        MEMORY + (2 * 12 * (1u64 << (4 * self.levels))).div_ceil(3) * if self.energy_preserving { 4 } else { 3 }
    }

    fn predict(&self) -> Predicted {
        let (grey, colour) = (self.header(1, 1.0, 1.0), self.header(3, 1.0, 1.0));
        let window = window(&grey, self.directions.light);
        let stored = 1usize << (2 * self.stored_levels);
        let needed = needed_coefficients(&grey, self.directions.view);
        let (all, trees) = (needed[..stored].iter().filter(|needed| **needed).count(), needed_in_trees(&grey, &needed));
        // Slices that no look-up within the directions reads are dropped.
        let bytes = |header: &Header, retained: usize| {
            gpu_bytes(header, window, slices_of_pack(retained.min(all), &trees, [retained, stored]))
        };
        // The zero slice, and the scaling coefficient of each tree.
        let smallest = gpu_bytes(&grey, window, 2 + grey.trees() as usize);
        match self.target {
            Target::Ratio(ratio) => {
                let retained = ((grey.cells() as f64 / ratio).round() as usize).clamp(1, stored);
                let least = if all == stored { bytes(&grey, retained) } else { smallest };
                Predicted { least, most: bytes(&colour, retained) }
            }
            Target::MaxBytes(most) => Predicted { least: 0, most },
            Target::MaxError(_) => Predicted { least: smallest, most: bytes(&colour, stored) },
        }
    }
}

impl Encode for Recipe {
    type Report = WaveletReport;

    const VARIANTS: &'static [Variant] = &[Variant {
        name: WAVELET,
        options: &[
            "max_error",
            "max_bytes",
            "ratio",
            "grid",
            "bits",
            "parameterisation",
            "bias",
            "ranking",
            "plain_levels",
        ],
    }];

    /// Slices are ranked by visible error if the codec is named, otherwise by energy. Levels of detail are
    /// energy-preserving unless the plain ones of the paper are requested.
    fn from_options(_: &str, options: &EncodeOptions) -> Result<Self, OptionError> {
        let mut recipe = if options.codec.is_some() { Self::visible() } else { Self::default() };
        if let Some(grid) = options.grid {
            if !grid.is_power_of_two() || !(2..=1 << MAX_LEVELS).contains(&grid) {
                return Err(EncodeOptions::out_of_range("grid", grid.to_string()));
            }
            recipe.levels = grid.ilog2();
            recipe.stored_levels = recipe.levels;
        }
        if let Some(bits) = options.bits {
            if bits != 8 && !(10..=16).contains(&bits) {
                return Err(EncodeOptions::out_of_range("bits", bits.to_string()));
            }
            recipe.bits = bits;
        }
        if let Some(name) = options.parameterisation.as_deref().filter(|name| *name != recipe.parameterisation.name()) {
            let allowed = "tangent-pole; use the codec table for half-difference angles";
            return Err(OptionError::new("parameterisation", quoted(name), allowed));
        }
        if let Some(name) = &options.ranking {
            let known = Ranking::NAMES.iter().find(|(known, _)| known == name);
            let Some((_, ranking)) = known else {
                return Err(EncodeOptions::out_of_range("ranking", quoted(name)));
            };
            recipe.ranking = *ranking;
        }
        recipe.energy_preserving = options.plain_levels != Some(true);
        recipe.bias = options.bias()?.unwrap_or(recipe.bias);
        recipe.target = target(options)?.unwrap_or(recipe.target);
        Ok(recipe)
    }

    fn encode(
        &self,
        source: &dyn Source,
        cache: &dyn GridCache,
        progress: &dyn Progress,
    ) -> Result<Encoded<WaveletReport>, EncodeError> {
        check(self)?;
        progress.stage(Stage::Resample, 1)?;
        let tabulated = tabulated(source, self.grid(), cache);
        let encode::Encoded { pack, cropped_bytes, bytes, on_grid, off_grid, tally, evaluated } =
            encode_tabulated(&tabulated, source, self, progress)?;
        let header = &pack.header;
        let slices_retained = pack.retained();
        let report = WaveletReport {
            parameterisation: header.parameterisation,
            grid: header.grid(),
            stored_levels: header.stored_levels,
            bits: header.bits,
            energy_preserving: header.energy_preserving,
            slices_retained,
            slices_in_all: header.cells(),
            ratio: header.cells() as f64 / slices_retained as f64,
            on_grid,
        };
        Ok(Encoded {
            cropped_bytes,
            evaluated,
            ..Encoded::new(BrdfPack::Wavelet(pack), bytes, report, off_grid, tally)
        })
    }

    fn bytes_of_left_out_levels(&self, report: &WaveletReport, channels: u32) -> Option<u64> {
        let Target::Ratio(ratio) = self.target else { return None };
        // Number of slices for all directions; cropped directions are counted elsewhere.
        let all = ((report.slices_in_all as f64 / ratio).round() as usize).max(1);
        let whole = Self { stored_levels: self.levels, ..self.clone() }.header(channels, 1.0, 1.0);
        let stored = self.header(channels, 1.0, 1.0);
        let window = Window::whole([whole.grid() as u32; 2]);
        let bytes = |header: &Header| {
            let stored = 1 << (2 * header.stored_levels);
            let (retained, trees) = (all.min(stored), needed_in_trees(header, &vec![true; stored]));
            gpu_bytes(header, window, slices_of_pack(retained, &trees, [retained, stored]))
        };
        Some(bytes(&whole) - bytes(&stored))
    }
}

/// Target of the options, if any.
fn target(options: &EncodeOptions) -> Result<Option<Target>, OptionError> {
    let given = [options.ratio.is_some(), options.max_error.is_some(), options.max_bytes.is_some()];
    if given.iter().filter(|given| **given).count() > 1 {
        let field = if options.ratio.is_some() { "ratio" } else { "max_error" };
        let problem = Message::from("several limits; set only one of ").with_key("ratio").with_text(", ");
        let problem = problem.with_key("max_error").with_text(" and ").with_key("max_bytes");
        return Err(OptionError::conflict(field, problem));
    }
    if let Some(ratio) = options.ratio {
        if !(1.0..=4096.0).contains(&ratio) {
            return Err(EncodeOptions::out_of_range("ratio", format_number(ratio)));
        }
        return Ok(Some(Target::Ratio(ratio)));
    }
    let error = options.budget()?.error.map(Target::MaxError);
    Ok(error.or(options.max_bytes.map(Target::MaxBytes)))
}

/// The source on a grid, from the cache if it has the samples. Otherwise the source is sampled and the samples are
/// cached.
fn tabulated(source: &dyn Source, grid: Grid, cache: &dyn GridCache) -> Tabulated {
    let name = format!("wavelet {} {}", grid.parameterisation.name(), grid.levels);
    let cached = cache.take(&name).and_then(|(values, tally)| Tabulated::from_bytes(source, grid, &values, tally));
    cached.unwrap_or_else(|| {
        let made = Tabulated::new(source, grid);
        cache.put(&name, &|| made.to_bytes(), &made.tally);
        made
    })
}
