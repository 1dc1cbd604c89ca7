//! Parts of a table that a limited range of directions never uses.

use brdfc_formats::crop::{DirectionRange, Window};
use brdfc_formats::table::{Angles, TableHeader};
use std::f64::consts::FRAC_PI_2;

/// Width of the ring around the texels that filtering reads.
const GUARD: u32 = 1;

/// Columns and rows that look-ups within a range of directions read, with a ring around them.
///
/// For polar angles `θ_i` and `θ_o` the angles of both the half vector and the difference are between `|θ_i - θ_o| / 2`
/// and `(θ_i + θ_o) / 2`. A direction is within `θ` of the normal if `θ_d / θ_d,max` is at most `θ / (π/2)`: with `R
/// cos(θ_d + δ)` the lower of both cosines, `δ = π/2 - θ_d,max` and `R <= 1`, it is `(acos(cos θ / R) - δ) / (π/2 -
/// δ)`.
pub fn window(header: &TableHeader, directions: DirectionRange) -> Window {
    let ([light_low, light_high], [view_low, view_high]) = (directions.light.polar(), directions.view.polar());
    let apart = (light_low - view_high).max(view_low - light_high).max(0.0);
    let place = |theta_half: f64, ratio: f64| {
        let (theta_half, ratio) = (theta_half as f32, ratio as f32);
        let position = header.position_of(Angles { theta_half, phi_half: 0.0, ratio, phi_difference: 0.0 });
        [position.column, position.row]
    };
    let lowest = place(apart / 2.0, apart / 2.0 / FRAC_PI_2);
    let highest = place((light_high + view_high) / 2.0, light_high.max(view_high) / FRAC_PI_2);
    let nodes = [header.axes.half, header.axes.difference];
    let last = |k: usize| (highest[k] as u32 + 1 + GUARD).min(nodes[k] - 1);
    let first = |k: usize| (lowest[k] as u32).saturating_sub(GUARD).min(nodes[k] - 2);
    Window::between([first(0), first(1)], [last(0), last(1)])
}

/// Number of texels of a pack whose texture has such a window.
pub fn texels(header: &TableHeader, directions: DirectionRange) -> usize {
    let [columns, rows] = window(header, directions).size;
    (columns * rows * header.extent()[2]) as usize
}
