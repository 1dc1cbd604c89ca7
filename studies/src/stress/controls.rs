//! Negative controls: deliberately broken stages, some only by a few roundings, which the bounds must detect.

use super::row::StressRow;
use super::stages::Stages;
use super::{decode, directions, encode, logarithms, neighbourhoods, pack, propagation, tables, texels, transforms};
use brdfc_formats::bandwidth::propagation::Bandwidth;
use brdfc_formats::table::{TableHeader, TablePack};

/// A broken stage.
#[derive(Debug, Clone, Copy)]
pub struct Control {
    /// Rows of this kind of stage.
    pub rows: fn(&Stages, bool) -> Vec<StressRow>,
    /// Name of the stage.
    pub stage: &'static str,
    /// Summary of the change.
    pub change: &'static str,
    /// Breaks the stage.
    pub break_it: fn(&mut Stages),
}

const fn control(
    rows: fn(&Stages, bool) -> Vec<StressRow>,
    stage: &'static str,
    change: &'static str,
    break_it: fn(&mut Stages),
) -> Control {
    Control { rows, stage, change, break_it }
}

impl Control {
    /// Rows of the broken stage whose bound does not hold.
    pub fn detected(&self, small: bool) -> Vec<StressRow> {
        let mut stages = Stages::default();
        (self.break_it)(&mut stages);
        let rows = (self.rows)(&stages, small);
        rows.into_iter().filter(|row| row.stage == self.stage && !row.holds).collect()
    }
}

/// All negative controls.
pub const CONTROLS: [Control; 37] = [
    control(directions::rows, "tangent-pole grid, f64", "angles rounded to f32", |s| {
        s.to_tangent_pole = |d| [f64::from(d[2].atan2(d[0]) as f32), d[1].acos()];
    }),
    control(directions::rows, "half and difference vectors, f64", "difference vectors rounded to f32", |s| {
        s.to_half_difference = |pair| {
            let (h, d) = (Stages::default().to_half_difference)(pair);
            (h, d.map(|c| f64::from(c as f32)))
        };
    }),
    control(directions::rows, "angles of decoders, f32", "angles 5e-7 too large", |s| {
        s.atan2 = |y, x| y.atan2(x) * 1.000_000_5
    }),
    control(directions::rows, "angles of tables, f32", "ratio of angles 1e-5 too large", |s| {
        s.angles = |pair| {
            let mut angles = (Stages::default().angles)(pair);
            angles.ratio *= 1.0 + 1e-5;
            angles
        };
    }),
    control(logarithms::rows, "ln, f32", "logarithm 1e-6 too large", |s| s.ln = |y| y.ln() * (1.0 + 1e-6)),
    control(logarithms::rows, "exp, f32", "argument 1e-7 too large", |s| s.exp = |x| (x * (1.0 + 1e-7)).exp()),
    control(logarithms::rows, "log encoding, f32", "no bias", |s| {
        s.log_encode = |table, encoding| {
            let mut encoded = table.clone();
            // Without the bias denormals and zeros have no logarithm.
            encoded.values.iter_mut().for_each(|v| *v = (f64::from(*v) / encoding.mean).ln() as f32);
            encoded
        };
    }),
    control(logarithms::rows, "log decoding, f32", "no clamp at 0", |s| {
        s.from_log = |decoder, v| decoder.header().mean * (v.exp() - decoder.header().bias)
    }),
    control(logarithms::rows, "log decoding, f32", "values 1e-6 too large", |s| {
        s.from_log = |decoder, v| (Stages::default().from_log)(decoder, v) * (1.0 + 1e-6)
    }),
    control(transforms::rows, "Haar, f32", "coefficients 1e-5 too large", |s| {
        s.haar = |samples, n| (Stages::default().haar)(samples, n).iter().map(|c| c * (1.0 + 1e-5)).collect();
    }),
    control(transforms::rows, "Haar, f32", "coefficients with 1e-20 added", |s| {
        s.haar = |samples, n| (Stages::default().haar)(samples, n).iter().map(|c| c + 1e-20).collect();
    }),
    control(transforms::rows, "Haar and back, f32", "coefficients with 1e-3 added", |s| {
        s.haar_inverse = |c, n| (Stages::default().haar_inverse)(c, n).iter().map(|c| c + 1e-3).collect();
    }),
    control(transforms::rows, "Daubechies and back, f32", "pixels in reverse order", |s| {
        s.daubechies = |image, _| image.iter().rev().copied().collect()
    }),
    control(transforms::rows, "means of levels, f32", "means of logarithms", |s| {
        s.means = |table, level| {
            let mut logarithms = table.clone();
            logarithms.values.mapv_inplace(|value| (value + 1e-6).ln());
            let mut mean = (Stages::default().means)(&logarithms, level);
            mean.values.mapv_inplace(|value| value.exp() - 1e-6);
            mean
        };
    }),
    control(transforms::rows, "smoothing, f32", "values 1e-5 too large", |s| {
        s.smooth = |values, grid, radius| {
            values.iter_mut().flatten().for_each(|v| *v *= 1.0 + 1e-5);
            (Stages::default().smooth)(values, grid, radius)
        };
    }),
    control(texels::rows, "threshold", "ties by number from the end", |s| {
        s.threshold = |energies, _, count| {
            let mut ranked: Vec<u32> = (1..energies.len() as u32).rev().collect();
            ranked.sort_by(|a, b| energies[*b as usize].total_cmp(&energies[*a as usize]));
            ranked.insert(0, 0);
            let mut selected = ranked[..count.clamp(1, ranked.len())].to_vec();
            selected.sort_unstable();
            selected
        };
    }),
    control(texels::rows, "energies of slices, f64", "a rounding that depends on the slice", |s| {
        s.energies = |coefficients| {
            let energies = (Stages::default().energies)(coefficients);
            energies.iter().enumerate().map(|(k, energy)| energy * (1.0 + k as f64 * f64::EPSILON)).collect()
        };
    }),
    control(texels::rows, "rounding to texels", "texels one step too large", |s| {
        s.quantise = |table, selected, header| {
            let mut quantised = (Stages::default().quantise)(table, selected, header);
            quantised.texels.iter_mut().for_each(|byte| *byte = byte.saturating_add(1));
            quantised
        };
    }),
    control(pack::rows, "packs written and read", "slices numbered by a single byte", |s| {
        s.read = |bytes| {
            let mut pack = (Stages::default().read)(bytes)?;
            pack.index.iter_mut().for_each(|slice| *slice &= 255);
            Ok(pack)
        };
    }),
    control(pack::rows, "limit of slices", "any bytes are a pack", |s| {
        s.read = |_| Ok(pack::pack(2, 1, 8, false, 1));
        s.write = |_| Vec::new();
    }),
    control(decode::rows, "decoding wavelets, f32", "fraction of the level dropped", |s| {
        s.decode = |decoder, pair, level| (Stages::default().decode)(decoder, pair, level.floor());
    }),
    control(decode::rows, "decoding energy-preserving wavelets, f32", "fraction of the level dropped", |s| {
        s.decode = |decoder, pair, level| (Stages::default().decode)(decoder, pair, level.floor());
    }),
    control(tables::rows, "decoding tables, f32", "values 1e-4 too large", |s| {
        s.decode_table = |decoder, pair| (Stages::default().decode_table)(decoder, pair).map(|v| v * (1.0 + 1e-4));
    }),
    control(tables::rows, "fitting tables, f32", "one step of the solver", |s| {
        s.solve = |equations, x| equations.solve(x, 1)
    }),
    control(tables::rows, "fitting tables, f32", "solution with the wrong sign", |s| {
        s.solve = |equations, x| {
            (Stages::default().solve)(equations, x);
            x.iter_mut().for_each(|[v]| *v = -*v);
        }
    }),
    control(tables::rows, "rounding tables", "nodes of another fit", |s| {
        s.table_pack = |prepared, recipe| {
            let other = brdfc_table::recipe::TableRecipe { factored: true, ..recipe.clone() };
            (Stages::default().table_pack)(prepared, &other)
        };
    }),
    control(neighbourhoods::rows, "moving least squares, f64", "weights rounded to f32, and 1e-5 too large", |s| {
        s.local_fit = |basis, weights, residuals| {
            let rounded: Vec<f64> = weights.iter().map(|w| f64::from(*w as f32)).collect();
            (Stages::default().local_fit)(basis, &rounded, residuals).map(|v| v * (1.0 + 1e-5))
        };
    }),
    control(neighbourhoods::rows, "trust in a fit, f64", "variance 1e-5 too large", |s| {
        s.local_fit = |basis, weights, residuals| {
            let [linear, quadratic, of_linear, of_quadratic] = (Stages::default().local_fit)(basis, weights, residuals);
            [linear, quadratic, of_linear * (1.0 + 1e-5), of_quadratic * (1.0 + 1e-5)]
        };
    }),
    control(neighbourhoods::rows, "moving least squares, f64", "value rounded to f32", |s| {
        s.neighbourhood = |neighbourhood| f64::from((Stages::default().neighbourhood)(neighbourhood) as f32);
    }),
    control(neighbourhoods::rows, "moving least squares, f64", "range of the neighbours added", |s| {
        s.neighbourhood = |neighbourhood| {
            let (low, high) = neighbourhood.range(0);
            (Stages::default().neighbourhood)(neighbourhood) + high - low
        };
    }),
    control(neighbourhoods::rows, "completion of scans, f64", "values rounded to f32", |s| {
        s.scan = |source, pair| (Stages::default().scan)(source, pair).map(|v| f64::from(v as f32));
    }),
    control(propagation::rows, "bandwidth over a reflection, f32", "a flight forgotten", |s| {
        s.one_bounce = |from: Bandwidth, light, surface, _| from.one_bounce(light, surface, 0.0);
    }),
    control(propagation::rows, "bandwidth over a reflection, f32", "twice the bandwidth, above the limit", |s| {
        s.one_bounce = |from: Bandwidth, light, surface, image| {
            let bounced = from.one_bounce(light, surface, image);
            Bandwidth { spatial: 2.0 * bounced.spatial, angular: 2.0 * bounced.angular }
        };
    }),
    control(propagation::rows, "mean bandwidth, f32", "twice the mean", |s| {
        s.mean_bandwidth = |average| {
            let mean = average.mean();
            Bandwidth { spatial: 2.0 * mean.spatial, angular: 2.0 * mean.angular }
        };
    }),
    control(propagation::rows, "level of the pyramid", "no finest level", |s| {
        s.pyramid_level = |bandwidth, coarsest| ((-(2.0 * bandwidth).log2()).floor() as i32).min(coarsest);
    }),
    control(encode::rows, "whole wavelet encode", "mean 1 % too large, bias 1 % too small", |s| {
        s.encode = |source, recipe| {
            let mut encoded = (Stages::default().encode)(source, recipe)?;
            encoded.pack.header.mean *= 1.01;
            encoded.pack.header.bias *= 0.99;
            Ok(encoded)
        };
    }),
    control(encode::rows, "whole table encode", "mean and bias 1 % too small", |s| {
        s.table_pack = |prepared, recipe| {
            let pack = (Stages::default().table_pack)(prepared, recipe)?;
            let header = *pack.header();
            let header = TableHeader { mean: 0.99 * header.mean, bias: 0.99 * header.bias, ..header };
            let changed = TablePack::new(header, &pack.values()).and_then(|changed| match pack.curve() {
                Some(curve) => changed.with_curve(curve.clone()),
                None => Ok(changed),
            });
            Ok(changed.unwrap_or(pack))
        };
    }),
];
