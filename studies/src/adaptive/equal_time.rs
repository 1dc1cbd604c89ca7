//! Sheets of all methods at equal time (figures 14 and 15 of Bagher et al. 2012).

use super::case::Case;
use super::comparison::{CaseRow, MethodRow, TARGETS, budgets};
use super::curve::{Cost, Point, Target};
use super::method::{Method, Prefiltered, draw};
use brdfc_render::contact_sheet::{Cell, contact_sheet};
use brdfc_render::rendering::{Panel, difference_panel, to_panel};

/// Draws the best rendering of each method within the time that adaptive shading needs for 30 dB, or else 25 dB, next to
/// the ground truth. `None` if adaptive shading has neither.
pub fn equal_time_sheet(case: &Case<'_>, prefiltered: Prefiltered<'_>, row: &CaseRow) -> Option<Panel> {
    let adaptive = row.methods.iter().find(|of| of.method == Method::Adaptive)?;
    let met = |(target, cost): (&Target, &Option<Cost>)| matches!(target, Target::Psnr(_)).then_some(*cost).flatten();
    let needed = TARGETS.iter().zip(&adaptive.needed).rev().find_map(met)?;
    let exposure = case.exposure;
    let cell = |of: &MethodRow| {
        let name = Method::ALL.iter().find(|(method, _)| *method == of.method).map_or("", |(_, name)| *name);
        // Adaptive shading draws the rendering before or after the interpolated one.
        let slack = if of.method == Method::Adaptive { f64::sqrt(2.0) } else { 1.0 };
        let within = |(_, _, point): &(usize, usize, Point)| point.seconds <= slack * needed.seconds;
        let all = of
            .curves
            .iter()
            .enumerate()
            .flat_map(|(curve, of)| of.points.iter().enumerate().map(move |(at, point)| (curve, at, *point)));
        let found = all.filter(within).max_by(|a, b| a.2.psnr.total_cmp(&b.2.psnr));
        let Some((curve, at, point)) = found else {
            let details = format!("longer than {:.0} ms", 1e3 * needed.seconds);
            return Cell { name: name.to_owned(), details, failed: true, rows: Vec::new() };
        };
        let variant = of.curves[curve].variant;
        let (image, _) = draw(case, prefiltered, of.method, variant, budgets(of.method, prefiltered)[at]);
        let details = format!("{:.0} ms, {:.1} dB, FLIP {:.3}", 1e3 * point.seconds, point.psnr, point.flip);
        let difference = difference_panel(&image, &case.truth, exposure);
        let panels = [to_panel(&case.truth, exposure), to_panel(&image, exposure), difference];
        Cell { name: name.to_owned(), details, failed: false, rows: vec![panels.map(Some)] }
    };
    Some(contact_sheet(&row.methods.iter().map(cell).collect::<Vec<_>>()))
}
