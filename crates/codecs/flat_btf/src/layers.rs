//! Layers of a relief: cuts the surface by vertical lines, sorts the cuts into sheets, and filters the sheets.
//!
//! A sheet that is absent from a column continues there as its neighbour sheet, mirrored at the rim where both meet:
//! what hangs over the base then has a negative thickness beyond its rim, and filtered sheets meet at the rim itself,
//! between texels. Where a solid reaches from top to bottom, the gap below has a negative height in the same way.

use crate::mesh::{PeriodicMesh, corner_coordinates, twice_area};
use crate::project::project;
use brdfc_formats::FormatError;
use brdfc_formats::flat_btf::{LayerHeader, LayerMap};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Lines per texel and axis.
const LINES: usize = 4;
/// Distance over which an absent sheet is mirrored, in tiles: rays that are nearly parallel to the plane take long steps,
/// and find a rim only if its mirror image is about as long.
const MIRRORED: f64 = 1.0 / 32.0;
/// Least such distance, in texels.
const MIRRORED_TEXELS: f64 = 4.0;
/// Distance between the surface and sheets that follow it inside the solid, as a share of the range of heights: three
/// steps of a byte, so that rays meet the surface first.
const INSIDE: f64 = 3.0 / 255.0;

/// Counts of what the layers simplify.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
pub struct LayerReport {
    /// Sheets: 1 or 3.
    pub sheets: u32,
    /// Share of the lines, in millionths, that cross more sheets than are stored: their thinnest parts were left out.
    pub simplified: u32,
    /// Share of the lines, in millionths, that leave the solid without entering it, or the reverse: the surface is not
    /// closed there.
    pub open: u32,
}

/// Crossing of a vertical line with the surface.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Cut {
    z: f32,
    /// Parameters less the position of the line, in tiles.
    moved: [f32; 2],
}

/// Cuts of a line, from above.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Column {
    One(Cut),
    Three([Cut; 3]),
}

/// Makes layers of `size x size` texels, a power of two from 2 on. `coordinates` are the parameters of the vertices.
///
/// # Errors
/// Returns an error if the surface is higher than layers can be.
pub fn layers(
    mesh: &PeriodicMesh,
    coordinates: &[[f64; 2]],
    size: u32,
) -> Result<(LayerMap, LayerReport), FormatError> {
    let side = size as usize * LINES;
    let (columns, mut report) = columns(mesh, coordinates, side);
    let overhangs = columns.iter().any(|column| matches!(column, Some(Column::Three(_))));
    report.sheets = if overhangs { 3 } else { 1 };
    let [low, high] = mesh.height_range();
    let filled = fill(columns, side, (INSIDE * (high - low)) as f32);
    let mut level = project(size as usize, LINES, |line| numbers(&filled[line]));
    drop(filled);
    let levels = size.ilog2() + 1;
    let margin = 1e-3 + 0.002 * (high - low);
    let header =
        LayerHeader { size, sheets: report.sheets, levels, heights: [(low - margin) as f32, (high + margin) as f32] };
    let (mut heights, mut moved) = (Vec::new(), Vec::new());
    for k in 0..levels {
        if k > 0 {
            let (side, finer) = ((size >> k).max(1) as usize, level);
            level = project(side, 2, |at| finer[at]);
        }
        let byte = |z: f32| (255.0 * ((z - header.heights[0]) / header.range()).clamp(0.0, 1.0)).round() as u8;
        for texel in &level {
            heights.push(byte(texel[0]));
            if overhangs {
                heights.extend([byte(texel[3]), byte(texel[6]), 0]);
            }
        }
        // Level 0 of the displacements has as many texels as level 1 of the heights.
        if k > 0 {
            for sheet in 0..report.sheets as usize {
                moved.extend(level.iter().map(|texel| [texel[3 * sheet + 1], texel[3 * sheet + 2]]));
            }
        }
    }
    Ok((LayerMap::new(header, heights, moved)?, report))
}

/// Height and displacement of each sheet.
fn numbers(cuts: &[Cut; 3]) -> [f32; 9] {
    std::array::from_fn(|k| if k % 3 == 0 { cuts[k / 3].z } else { cuts[k / 3].moved[k % 3 - 1] })
}

/// Cuts the surface by `side x side` lines.
fn columns(mesh: &PeriodicMesh, coordinates: &[[f64; 2]], side: usize) -> (Vec<Option<Column>>, LayerReport) {
    let n = side as f64;
    // Lines are moved by a hair, so that none meets an edge that lies on the grid.
    let offset = [0.5 + 1.1e-5, 0.5 + 1.3e-5];
    let mut rows: Vec<Vec<(u32, i64)>> = vec![Vec::new(); side];
    for triangle in 0..mesh.triangles.len() {
        let y = mesh.corners(triangle).map(|corner| corner[1] * n - offset[1]);
        let (low, high) = (y[0].min(y[1]).min(y[2]), y[0].max(y[1]).max(y[2]));
        for row in low.ceil() as i64..=high.floor() as i64 {
            rows[row.rem_euclid(side as i64) as usize].push((triangle as u32, row));
        }
    }
    let of_row = |row: &Vec<(u32, i64)>| {
        let mut cuts: Vec<(usize, bool, Cut)> = Vec::new();
        for (triangle, row) in row {
            let corners = mesh.corners(*triangle as usize);
            let parameters = corner_coordinates(mesh, coordinates, *triangle as usize);
            let p = corners.map(|c| [c[0] * n - offset[0], c[1] * n - offset[1]]);
            let area = twice_area(p);
            if area == 0.0 {
                continue;
            }
            let y = *row as f64;
            let x = p.map(|c| c[0]);
            let (low, high) = (x[0].min(x[1]).min(x[2]), x[0].max(x[1]).max(x[2]));
            for column in low.ceil() as i64..=high.floor() as i64 {
                let at = [column as f64, y];
                let u = twice_area([p[0], at, p[2]]) / area;
                let v = twice_area([p[0], p[1], at]) / area;
                if u < 0.0 || v < 0.0 || u + v > 1.0 {
                    continue;
                }
                let blend = |c: [f64; 3]| (1.0 - u - v) * c[0] + u * c[1] + v * c[2];
                let line = [(column as f64 + offset[0]) / n, (y + offset[1]) / n];
                let moved = [0, 1].map(|k| (blend(parameters.map(|c| c[k])) - line[k]) as f32);
                let cut = Cut { z: blend(corners.map(|c| c[2])) as f32, moved };
                cuts.push((column.rem_euclid(side as i64) as usize, area > 0.0, cut));
            }
        }
        cuts.sort_by(|a, b| a.0.cmp(&b.0).then(b.2.z.total_cmp(&a.2.z)));
        let (mut columns, mut simplified, mut open) = (vec![None; side], 0u64, 0u64);
        for cuts in cuts.chunk_by(|a, b| a.0 == b.0) {
            let (column, is_simplified, is_open) = column(cuts);
            columns[cuts[0].0] = column;
            simplified += u64::from(is_simplified);
            open += u64::from(is_open);
        }
        (columns, simplified, open)
    };
    let rows: Vec<_> = rows.par_iter().map(of_row).collect();
    let [simplified, open] = [
        rows.iter().map(|row| row.1).sum::<u64>(),
        rows.iter().map(|row| row.2 + row.0.iter().filter(|c| c.is_none()).count() as u64).sum(),
    ]
    .map(|lines| (1e6 * lines as f64 / (n * n)).ceil() as u32);
    let columns = rows.into_iter().flat_map(|row| row.0).collect();
    (columns, LayerReport { sheets: 1, simplified, open })
}

/// The sheets of a line; `None` without any. True if parts were left out, and if the surface is open there.
fn column(cuts: &[(usize, bool, Cut)]) -> (Option<Column>, bool, bool) {
    // Upper and lower sides alternate along a closed surface.
    let mut kept: Vec<Cut> = Vec::new();
    for (_, up, cut) in cuts {
        if *up == kept.len().is_multiple_of(2) {
            kept.push(*cut);
        }
    }
    let open = kept.len() < cuts.len() || kept.len().is_multiple_of(2);
    if kept.len().is_multiple_of(2) {
        kept.pop();
    }
    let simplified = kept.len() > 3;
    while kept.len() > 3 {
        // A pair of neighbouring cuts below the first: the thinnest gap or solid.
        let thickness = |k: &usize| kept[*k].z - kept[k + 1].z;
        let thinnest = (1..kept.len() - 1).min_by(|a, b| thickness(a).total_cmp(&thickness(b))).expect("five cuts");
        kept.drain(thinnest..thinnest + 2);
    }
    let column = match kept[..] {
        [top, underside, base] => Some(Column::Three([base, top, underside])),
        [base] => Some(Column::One(base)),
        _ => None,
    };
    (column, simplified, open)
}

/// Offsets to the nearest column that `is_one` accepts, on the torus. `None` if there is none.
fn nearest(side: usize, is_one: impl Fn(usize) -> bool) -> Option<Vec<[i32; 2]>> {
    const FAR: i32 = 1 << 14;
    let mut offsets: Vec<[i32; 2]> = (0..side * side).map(|at| if is_one(at) { [0; 2] } else { [FAR; 2] }).collect();
    if offsets.iter().all(|offset| *offset != [0; 2]) {
        return None;
    }
    let wrapped = |i: i64| i.rem_euclid(side as i64) as usize;
    let length = |offset: [i32; 2]| i64::from(offset[0]).pow(2) + i64::from(offset[1]).pow(2);
    let mut relax = |at: usize, neighbours: &[[i32; 2]]| {
        let (i, j) = ((at % side) as i64, (at / side) as i64);
        for [x, y] in neighbours {
            let there = offsets[wrapped(j + i64::from(*y)) * side + wrapped(i + i64::from(*x))];
            let through = [there[0] + x, there[1] + y];
            if length(through) < length(offsets[at]) {
                offsets[at] = through;
            }
        }
    };
    // Two rounds of sweeps: the second crosses the border.
    for _ in 0..2 {
        for sign in [1, -1] {
            let ordered = |step: usize| if sign > 0 { step } else { side * side - 1 - step };
            let visited = [[-1, 0], [0, -1], [-1, -1], [1, -1]].map(|offset| offset.map(|c: i32| sign * c));
            (0..side * side).for_each(|step| relax(ordered(step), &visited));
            // Rows in the same order, each against its direction.
            let turned = |at: usize| at - at % side + (side - 1 - at % side);
            (0..side * side).for_each(|step| relax(turned(ordered(step)), &[[sign, 0]]));
        }
    }
    Some(offsets)
}

/// Continues absent sheets. `inside` is the distance of sheets that follow the surface.
fn fill(columns: Vec<Option<Column>>, side: usize, inside: f32) -> Vec<[Cut; 3]> {
    let index = |at: usize, offset: [f64; 2]| {
        let wrapped = |c: usize, d: f64| (c as i64 + d.round() as i64).rem_euclid(side as i64) as usize;
        wrapped(at / side, offset[1]) * side + wrapped(at % side, offset[0])
    };
    let columns: Vec<Column> = if columns.contains(&None) {
        let Some(solid) = nearest(side, |at| columns[at].is_some()) else {
            return vec![[Cut::default(); 3]; side * side];
        };
        (0..side * side).filter_map(|at| columns[index(at, solid[at].map(f64::from))]).collect()
    } else {
        columns.into_iter().flatten().collect()
    };
    let Some(rims) = nearest(side, |at| matches!(columns[at], Column::Three(_))) else {
        let one = |(Column::One(base) | Column::Three([base, ..])): &Column| [*base, Cut::default(), Cut::default()];
        return columns.iter().map(one).collect();
    };
    let most = (MIRRORED * side as f64).max(MIRRORED_TEXELS * LINES as f64);
    let filled = |at: usize| {
        let own = match columns[at] {
            Column::Three(cuts) => return cuts,
            Column::One(own) => own,
        };
        let to_rim = rims[at].map(f64::from);
        let length = to_rim[0].hypot(to_rim[1]);
        let beyond = (length.min(most) / length).max(0.0);
        let offset = |share: f64| to_rim.map(|c| c * (1.0 + share));
        let three = |offset: [f64; 2]| match columns[index(at, offset)] {
            Column::Three(cuts) => Some(cuts.map(|cut| {
                // Parameters stay where they are; the position moves.
                let moved = [0, 1].map(|k| cut.moved[k] + (offset[k].round() / side as f64) as f32);
                Cut { moved, ..cut }
            })),
            _ => None,
        };
        let [rim_base, rim_top, _] = three(to_rim).expect("a rim");
        let [base, top, underside] = three(offset(beyond)).unwrap_or_else(|| three(to_rim).expect("a rim"));
        // Far from a rim all sheets follow one: it may continue as the top of one rim and as the base of another.
        let far = (2.0 * length / most - 1.0).clamp(0.0, 1.0) as f32;
        let joined = |cut: Cut, above: f32| Cut {
            z: cut.z + far * (own.z + above - cut.z),
            moved: [0, 1].map(|k| cut.moved[k] + far * (own.moved[k] - cut.moved[k])),
        };
        if (own.z - rim_top.z).abs() < (own.z - rim_base.z).abs() {
            // Solid from top to bottom: the gap turned inside out.
            [joined(underside, -inside), own, joined(base, -2.0 * inside)]
        } else {
            [own, joined(underside, -inside), joined(top, inside)]
        }
    };
    (0..side * side).into_par_iter().map(filled).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MesoModel;
    use crate::structures::Structure;
    use crate::testing::{height_field, overhang};
    use brdfc_formats::direction::{Vector, from_polar};
    use brdfc_formats::flat_btf::{MacroSurface, MarchSteps};

    fn made(model: &MesoModel, size: u32) -> (LayerMap, LayerReport) {
        layers(&model.mesh, &model.parameterisation.coordinates, size).unwrap()
    }

    fn single(v: Vector) -> [f32; 3] {
        v.map(|c| c as f32)
    }

    /// Places and directions that cover tile and hemisphere up to 70 degrees.
    fn rays() -> impl Iterator<Item = ([f64; 2], Vector)> {
        (0..2000).map(|k| {
            let [u, v, w, t] = [0.754_877, 0.569_840, 0.618_034, 0.414_214].map(|step| (f64::from(k) * step).fract());
            ([u, v], from_polar((1.0 - 0.66 * w).acos(), std::f64::consts::TAU * t))
        })
    }

    #[test]
    fn a_plane_has_one_sheet_at_its_height() {
        let model = MesoModel::new(height_field(7, |_, _| 0.25), 0, &()).unwrap();
        let (map, report) = made(&model, 8);
        assert_eq!(report, LayerReport { sheets: 1, simplified: 0, open: 0 });
        let [low, _] = map.header().heights;
        for (at, view) in rays() {
            let point =
                map.seen(at.map(|c| c as f32), single(view), MacroSurface::PLANE, 0.0, MarchSteps::of(map.header()));
            let height = low + point.height * map.header().range();
            assert!((height - 0.25).abs() < 1e-4, "{at:?} {point:?}");
            let parameters = map.parameters(point.at, point.sheet, 0.0);
            let expected = [0, 1].map(|k| at[k] + 0.25 * view[k] / view[2]);
            assert!(
                (0..2).all(|k| (f64::from(parameters[k]) - expected[k]).abs() < 2e-3),
                "{parameters:?} {expected:?}"
            );
            assert_eq!(
                map.lit(&point, [0.0, 0.0, 1.0], single(view), MacroSurface::PLANE, 0.0, MarchSteps::of(map.header())),
                1.0
            );
        }
    }

    /// Shares of rays of sight that end within a texel and a half of the surface's own point, and of points at which
    /// light agrees.
    fn agreement(model: &MesoModel, map: &LayerMap) -> [f64; 2] {
        let steps = MarchSteps { sight: 64, refine: 3, both: 128 };
        let texel = 1.0 / f64::from(map.header().size);
        let light = from_polar(0.9, 2.0);
        let (mut near, mut agreed, mut count) = (0.0, 0.0, 0.0);
        for (at, view) in rays() {
            let truth = model.point(&model.seen(at, view).hit);
            let found = map.seen(at.map(|c| c as f32), single(view), MacroSurface::PLANE, 0.0, steps);
            count += 1.0;
            let off = [0, 1].map(|k| f64::from(found.at[k]) - truth.position[k]);
            near += f64::from(u8::from(off[0].hypot(off[1]) < 1.5 * texel));
            let lit = map.lit(&found, single(truth.normal), single(light), MacroSurface::PLANE, 0.0, steps) == 1.0;
            let facing = brdfc_formats::direction::dot(truth.normal, light) > 0.0;
            agreed += f64::from(u8::from((facing && lit) == model.caster.sees_sky(&truth, light)));
        }
        [near / count, agreed / count]
    }

    #[test]
    fn rays_through_the_layers_of_an_overhang_end_at_its_surface() {
        let button = Structure::parse("button?resolution=96").unwrap();
        let model = MesoModel::new(button.mesh(), 0, &()).unwrap();
        let (map, report) = made(&model, 128);
        assert_eq!((report.sheets, report.open), (3, 0));
        let found = agreement(&model, &map);
        assert!(found[0] > 0.97 && found[1] > 0.95, "{found:?}");
        // The negative control: the layers of a plane.
        let plane = MesoModel::new(height_field(7, |_, _| 0.0), 0, &()).unwrap();
        let other = agreement(&model, &made(&plane, 64).0);
        assert!(other[0] < 0.5 * found[0] && other[1] < found[1], "{other:?}");
    }

    /// A wall that stands upright is as steep as a texel allows, and hides what is behind it.
    #[test]
    fn walls_stand_upright() {
        let wall = |x: f64, _: f64| if (0.25..0.75).contains(&x) { 0.3 } else { 0.0 };
        let model = MesoModel::new(height_field(64, wall), 0, &()).unwrap();
        let (map, report) = made(&model, 64);
        assert_eq!(report.sheets, 1);
        let found = agreement(&model, &map);
        assert!(found[0] > 0.95 && found[1] > 0.93, "{found:?}");
    }

    /// A sheet that passes through itself has no inside: lines keep its highest side, and are counted.
    #[test]
    fn surfaces_that_pass_through_themselves_are_counted() {
        let model = MesoModel::new(overhang(64), 0, &()).unwrap();
        let (map, report) = made(&model, 64);
        assert!(report.open > 10_000 && report.sheets == 1, "{report:?}");
        let above = map.seen([0.5, 0.3], [0.0, 0.0, 1.0], MacroSurface::PLANE, 0.0, MarchSteps::of(map.header()));
        assert!((0.0..=1.0).contains(&above.height));
    }

    /// More than three cuts: the thinnest parts go, the first cut stays.
    #[test]
    fn lines_keep_their_thickest_parts() {
        let cut = |z: f32| Cut { z, moved: [z, 0.0] };
        let line = |heights: &[f32]| -> Vec<(usize, bool, Cut)> {
            heights.iter().enumerate().map(|(k, z)| (0, k % 2 == 0, cut(*z))).collect()
        };
        let (found, simplified, open) = column(&line(&[1.0, 0.9, 0.5, 0.45, 0.1]));
        assert_eq!((found, simplified, open), (Some(Column::Three([cut(0.1), cut(1.0), cut(0.9)])), true, false));
        let (found, simplified, open) = column(&line(&[1.0, 0.2, 0.1]));
        assert_eq!((found, simplified, open), (Some(Column::Three([cut(0.1), cut(1.0), cut(0.2)])), false, false));
        // A surface that is open below, and a line without any.
        let (found, _, open) = column(&line(&[1.0, 0.2]));
        assert_eq!((found, open), (Some(Column::One(cut(1.0))), true));
        assert_eq!(column(&[]).0, None);
    }

    #[test]
    fn nearest_columns_cross_the_border() {
        let found = nearest(8, |at| at == 8 * 7 + 6).unwrap();
        assert_eq!((found[0], found[8 * 7 + 6], found[8 * 3 + 6][1].abs()), ([-2, -1], [0, 0], 4));
        assert!(nearest(4, |_| false).is_none());
    }
}
