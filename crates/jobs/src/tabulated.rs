//! Tables that replace sources whose evaluation is slow.
//!
//! A scan is completed from its samples at each look-up, which takes about ten microseconds. Renderings and bandwidth
//! maps look it up millions of times.

use crate::Error;
use brdfc_core::progress::Progress;
use brdfc_core::words::{bytes, percent};
use brdfc_core::{PackSource, Source};
use brdfc_metrics::compare::Comparison;
use brdfc_table::encode::encode;
use brdfc_table::recipe::{Size, TableRecipe};

/// Bytes of a table on a GPU: the largest tables.
const BYTES: u64 = 512 << 10;

/// A table that replaces a source.
#[derive(Debug)]
pub struct Tabulated {
    /// The table, a factored pack.
    pub source: PackSource,
    /// Its error against the source.
    pub error: Comparison,
    bytes: u64,
}

impl Tabulated {
    /// Size and error, for a note.
    pub fn summary(&self) -> String {
        let (error, size) = (&self.error, bytes(self.bytes));
        let highlight = match error.highlight {
            Some(highlight) => format!(", the highlight keeps {} of its light", percent(highlight.retained())),
            None => String::new(),
        };
        let [relative, delta_e] = [percent(error.norms.relative_mean), format!("{:.2}", error.rendering.delta_e.mean)];
        format!("the scan is replaced by a table of {size}: ε_r {relative}, ΔE {delta_e}{highlight}")
    }
}

/// Tabulates a source that is completed from samples; `None` for others, which are fast enough. Takes seconds.
///
/// # Errors
/// Returns an error if the work was cancelled.
pub fn tabulated(source: &dyn Source, progress: &dyn Progress) -> Result<Option<Tabulated>, Error> {
    if source.completion().is_none() {
        return Ok(None);
    }
    let recipe = TableRecipe { size: Size::Bytes(BYTES), factored: true, ..TableRecipe::default() };
    let encoded = encode(source, &recipe, progress)?;
    let source = PackSource::new(&encoded.pack, None);
    Ok(Some(Tabulated { source, error: encoded.off_grid, bytes: encoded.pack.gpu_bytes() }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::Tally;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::DirectionPair;
    use brdfc_source::open::open;

    #[test]
    fn a_scan_becomes_a_table_with_about_its_values() {
        // A diffuse material with a soft highlight, measured at a few incidences.
        let model = parse_synth("synth:ggx?kd=0.4,0.2,0.1&alpha=0.5").unwrap();
        let mut text = String::from("theta_i,phi_i,theta_o,phi_o,r,g,b\n");
        for (i, o, azimuth) in (0..8).flat_map(|i| (0..10).flat_map(move |o| (0..8).map(move |a| (i, o, a)))) {
            let [theta_i, theta_o] = [0.15 * f64::from(i) + 0.1, 0.14 * f64::from(o) + 0.05];
            let phi = 0.44 * f64::from(azimuth);
            let pair = DirectionPair::from_angles(theta_i, 0.0, theta_o, phi);
            let [r, g, b] = model.eval(pair, &mut Tally::default());
            text += &format!("{theta_i},0,{theta_o},{phi},{r},{g},{b}\n");
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("soft.csv");
        std::fs::write(&path, text).unwrap();
        let scan = open(&*path, None).unwrap().source;
        let table = tabulated(scan.as_ref(), &()).unwrap().expect("a scan");
        assert!(table.error.norms.relative_mean < 0.05 && table.summary().contains("ε_r"), "{}", table.summary());
        for k in 0..50 {
            let angle = f64::from(k);
            let pair = DirectionPair::from_angles(0.02 * angle, 0.0, 1.1 - 0.02 * angle, 0.06 * angle);
            let [a, b] = [scan.as_ref(), &table.source as &dyn Source].map(|of| of.eval(pair, &mut Tally::default()));
            assert!((0..3).all(|c| (a[c] - b[c]).abs() < 0.1 * a[c]), "{a:?} {b:?}");
        }
        // Models are fast, and stay.
        assert!(tabulated(model.as_ref(), &()).unwrap().is_none());
    }
}
