//! View-dependent indirection maps of a surface, measured by casting rays (section 3.4 of Hadim et al. 2009), and sampled
//! shadows.

use crate::caster::MAX_POLAR_DEGREES;
use crate::compact::ParameterHeights;
use crate::factored::with_mipmaps;
use crate::model::MesoModel;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_formats::FormatError;
use brdfc_formats::direction::{Vector, from_polar};
use brdfc_formats::flat_btf::{SeenPoint, ShadowMap, Vdim, VdimHeader};
use rayon::prelude::*;

/// Rays per texel and axis, by default.
pub const OVERSAMPLING: usize = 2;

/// A measured view of a map: parameters that a view sees through a texel, not wrapped, and the height of the point.
type Measured = ([f64; 2], f64);

/// A map of one level before rounding.
pub struct MeasuredVdim {
    pub(crate) header: VdimHeader,
    /// Parameters that the view along the normal sees less the centre of the texel, row by row.
    pub(crate) reference: Vec<[f32; 2]>,
    /// For each row `j` of texels, for each azimuth `a` below `R - 1`, for each column `i`, for each polar angle `k`.
    seen: Vec<SeenPoint>,
}

impl MeasuredVdim {
    /// Measures a map of one level by `oversampling²` rays for each texel and view. `progress` receives a step per row of
    /// texels.
    ///
    /// The value of a texel is the mean over the largest group of its rays that meet the surface close together: a mean
    /// over both sides of a silhouette would be a point that none of them sees.
    ///
    /// # Errors
    /// Returns an error if `progress` cancels.
    pub fn new(
        model: &MesoModel,
        header: VdimHeader,
        oversampling: usize,
        progress: &dyn Progress,
    ) -> Result<Self, Cancelled> {
        let size = header.size as usize;
        let angles = |a: u32| (0..header.polar_angles).map(move |k| header.view_angles(k, a));
        let views: Vec<Vector> = (0..header.azimuth_rows - 1)
            .flat_map(angles)
            // A ray along the ground meets nothing: stay slightly above it.
            .map(|[polar, azimuth]| from_polar(polar.min(MAX_POLAR_DEGREES.to_radians()), azimuth))
            .collect();
        let row = |j: usize| {
            let through = |i: usize, view| through_texel(model, [i, j], size, oversampling, view);
            let normal: Vec<Measured> = (0..size).map(|i| through(i, [0.0, 0.0, 1.0])).collect();
            let mut seen = Vec::with_capacity(size * views.len());
            for views in views.chunks_exact(header.polar_angles as usize) {
                for (i, reference) in normal.iter().enumerate() {
                    seen.push(seen_from(*reference, *reference));
                    seen.extend(views[1..].iter().map(|view| seen_from(through(i, *view), *reference)));
                }
            }
            let centre = |k: usize| (k as f64 + 0.5) / size as f64;
            let reference = |(i, (r, _)): (usize, &Measured)| [r[0] - centre(i), r[1] - centre(j)].map(|c| c as f32);
            progress.step()?;
            Ok((normal.iter().enumerate().map(reference).collect::<Vec<_>>(), seen))
        };
        let rows = (0..size).into_par_iter().map(row).collect::<Result<Vec<_>, Cancelled>>()?;
        let (mut reference, mut seen) = (Vec::new(), Vec::with_capacity(size * size * views.len()));
        for (r, s) in rows {
            reference.extend(r);
            seen.extend(s);
        }
        Ok(Self { header, reference, seen })
    }

    /// Rounds to a map.
    ///
    /// # Errors
    /// Returns an error if the header or a number is out of range.
    pub fn map(&self) -> Result<Vdim, FormatError> {
        Vdim::of_views(self.header, self.reference.clone(), |texel, k, a| self.seen(texel, k, a))
    }

    /// What view `(k, a)` sees through a texel.
    pub(crate) fn seen(&self, texel: [u32; 2], k: u32, a: u32) -> SeenPoint {
        self.seen[index(&self.header, texel, k, a)]
    }
}

/// Index of a view of a texel in [`MeasuredVdim::seen`].
fn index(header: &VdimHeader, [i, j]: [u32; 2], k: u32, a: u32) -> usize {
    let [size, polar_angles, azimuths] = [header.size, header.polar_angles, header.azimuth_rows - 1];
    (((j * azimuths + a) * size + i) * polar_angles + k) as usize
}

/// Measures all levels of a map, with compact samples if `is_compact`. `progress` receives [`steps`] steps.
///
/// # Errors
/// Returns an error if the header or a number is out of range, or if `progress` cancels.
pub fn indirection<E: From<FormatError> + From<Cancelled>>(
    model: &MesoModel,
    header: VdimHeader,
    oversampling: usize,
    is_compact: bool,
    progress: &dyn Progress,
) -> Result<Vdim, E> {
    header.check()?;
    let heights = is_compact.then(|| ParameterHeights::new(model, &header));
    let of_level = |level| {
        let header = VdimHeader { size: header.side(level), levels: 1, ..header };
        let measured = MeasuredVdim::new(model, header, oversampling, progress)?;
        Ok(match &heights {
            Some(heights) => measured.compact(header.block, heights)?,
            None => measured.map()?,
        })
    };
    let levels = (0..header.levels).map(of_level).collect::<Result<Vec<_>, E>>()?;
    Ok(Vdim::of_levels(levels)?)
}

/// Progress steps of [`indirection`].
pub fn steps(header: &VdimHeader) -> usize {
    (0..header.levels).map(|level| header.side(level) as usize).sum()
}

/// Shadows of sampled lights: `reached` has for each light the texels that it reaches, `counts` the weights of texels in
/// coarser levels.
///
/// # Errors
/// Returns an error if the lights are out of range.
pub fn shadow_map(
    lights: Vec<[f32; 2]>,
    reached: &[Vec<bool>],
    counts: &[f32],
    levels: u32,
) -> Result<ShadowMap, FormatError> {
    let bytes: Vec<u8> = reached.iter().flatten().map(|lit| if *lit { 255 } else { 0 }).collect();
    ShadowMap::new(lights, counts.len().isqrt() as u32, levels, with_mipmaps(&bytes, counts, 1, levels))
}

fn seen_from((parameters, height): Measured, (reference, _): Measured) -> SeenPoint {
    SeenPoint { displacement: [0, 1].map(|k| (parameters[k] - reference[k]) as f32), height: height as f32 }
}

/// Parameters that one view sees through each of `size` x `size` texels of the reference plane, row by row, not
/// wrapped: a map that contains this view holds these values.
pub fn seen_through_texels(model: &MesoModel, view: Vector, size: usize, oversampling: usize) -> Vec<[f32; 2]> {
    let seen = |texel: usize| {
        let (parameters, _) = through_texel(model, [texel % size, texel / size], size, oversampling, view);
        parameters.map(|c| c as f32)
    };
    (0..size * size).into_par_iter().map(seen).collect()
}

/// Distance, in texels, within which rays that meet the surface form a group.
const GROUP: f64 = 2.0;

/// Parameters and height that a view sees through a texel of the reference plane.
fn through_texel(model: &MesoModel, texel: [usize; 2], size: usize, oversampling: usize, view: Vector) -> Measured {
    let scale = 1.0 / size as f64;
    let sub = 1.0 / oversampling as f64;
    let mut seen = Vec::with_capacity(oversampling * oversampling);
    for y in 0..oversampling {
        for x in 0..oversampling {
            let offset = [(x as f64 + 0.5) * sub, (y as f64 + 0.5) * sub];
            let at = [0, 1].map(|k| (texel[k] as f64 + offset[k]) * scale);
            let found = model.seen(at, view);
            seen.push((found.parameters, model.point(&found.hit).position[2]));
        }
    }
    if seen.len() == 1 {
        return seen[0];
    }
    let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
    let group = |of: [f64; 2]| seen.iter().filter(move |(p, _)| apart(*p, of) <= GROUP * scale);
    let of = seen
        .iter()
        .map(|(p, _)| (*p, group(*p).count()))
        .reduce(|best, next| if next.1 > best.1 { next } else { best })
        .expect("there is a ray");
    let (mut parameters, mut height) = ([0.0; 2], 0.0);
    for (p, z) in group(of.0) {
        (0..2).for_each(|k| parameters[k] += p[k] / of.1 as f64);
        height += z / of.1 as f64;
    }
    (parameters, height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{PeriodicMesh, VertexMaterial};

    const HEADER: VdimHeader =
        VdimHeader { size: 8, block: 1, polar_angles: 5, azimuth_rows: 9, largest_angle: 1.2, levels: 1, lights: 0 };

    fn map(model: &MesoModel) -> Vdim {
        MeasuredVdim::new(model, HEADER, 2, &()).unwrap().map().unwrap()
    }

    /// Model of a height field of `n` x `n` vertices at `(column / n, row / n)`.
    fn height_field(n: usize, height: impl Fn(f64, f64) -> f64) -> MesoModel {
        let at = |i: usize| [(i % n) as f64 / n as f64, (i / n) as f64 / n as f64];
        let points = (0..n * n).map(at).map(|[x, y]| [x, y, height(x, y)]);
        let mesh = PeriodicMesh::from_grid(n, n, points.collect(), vec![VertexMaterial::default(); n * n]);
        MesoModel::new(mesh, 0, &()).unwrap()
    }

    /// Checks all displacements before rounding, by texel and angles of the view.
    fn each(
        model: &MesoModel,
        h: VdimHeader,
        oversampling: usize,
        mut check: impl FnMut([usize; 2], [f64; 2], [f32; 2], f32),
    ) {
        let mut values = MeasuredVdim::new(model, h, oversampling, &()).unwrap().seen.into_iter();
        for j in 0..h.size as usize {
            for a in 0..h.azimuth_rows - 1 {
                for i in 0..h.size as usize {
                    for k in 0..h.polar_angles {
                        let SeenPoint { displacement, height } = values.next().unwrap();
                        check([i, j], h.view_angles(k, a), displacement, height);
                    }
                }
            }
        }
        assert!(values.next().is_none());
    }

    #[test]
    fn a_plane_in_the_reference_plane_has_the_identity_and_no_displacement() {
        let model = height_field(6, |_, _| 0.0);
        let map = map(&model);
        for texel in 0..64 {
            let r = map.reference([texel % 8, texel / 8], 0);
            assert!(r[0].abs() < 1e-6 && r[1].abs() < 1e-6, "{r:?}");
        }
        each(&model, HEADER, 2, |_, _, d, z| {
            assert!(d[0].abs() < 2e-6 && d[1].abs() < 2e-6 && z.abs() < 1e-6, "{d:?} {z}");
        });
    }

    #[test]
    fn a_raised_plane_shifts_by_its_height_times_the_tangent() {
        let height = 0.11;
        let model = height_field(6, |_, _| height);
        each(&model, HEADER, 1, |_, [polar, azimuth], d, z| {
            let shift = height * polar.tan();
            let expected = [shift * azimuth.cos(), shift * azimuth.sin()];
            assert!((0..2).all(|k| (f64::from(d[k]) - expected[k]).abs() < 1e-5), "{d:?} {expected:?}");
            assert!((f64::from(z) - height).abs() < 1e-6);
        });
    }

    #[test]
    fn a_tilted_plane_has_the_analytic_shift() {
        // A roof of two tilted planes, z = s (¼ - |x - ½|). Away from its edges each is a plane.
        let slope = 0.4;
        let model = height_field(32, |x, _| slope * (0.25 - (x - 0.5).abs()));
        // Parameterised, the roof is the unit square again: u = x, v = y, by symmetry.
        each(&model, HEADER, 1, |[i, j], [polar, azimuth], d, _| {
            let (x, y) = ((i as f64 + 0.5) / 8.0, (j as f64 + 0.5) / 8.0);
            if !(0.15..0.35).contains(&x) || polar > 0.7 {
                return;
            }
            // The left plane, z = s (x - ¼): x + t w_x, z = t w_z.
            let w = from_polar(polar, azimuth);
            let t = slope * (x - 0.25) / (w[2] - slope * w[0]);
            let expected = [t * w[0], t * w[1]];
            assert!((0..2).all(|k| (f64::from(d[k]) - expected[k]).abs() < 1e-5), "{d:?} {expected:?} at {x} {y}");
        });
    }

    #[test]
    fn a_sphere_cap_has_the_analytic_intersection() {
        // A cap of radius r, sunk by half of it: its parameters are not x and y; heights and positions are compared.
        let (radius, sunk) = (0.4, 0.2);
        let cap = |x: f64, y: f64| {
            let d = (x - 0.5).powi(2) + (y - 0.5).powi(2);
            (radius * radius - d).max(0.0).sqrt().max(sunk) - sunk
        };
        let n = 256;
        let model = height_field(n, cap);
        let mut checked = 0;
        for (polar, azimuth) in [(0.0, 0.0), (0.4, 1.0), (0.8, 2.0), (1.0, 5.0)] {
            let w = from_polar(polar, azimuth);
            for k in 0..400 {
                let at = [f64::from(k % 20) / 20.0 + 0.013, f64::from(k / 20) / 20.0 + 0.007];
                // |at + t w - c| = r with c = (½, ½, -sunk); take the higher solution.
                let from = [at[0] - 0.5, at[1] - 0.5, sunk];
                let b = from[0] * w[0] + from[1] * w[1] + from[2] * w[2];
                let c = from.iter().map(|v| v * v).sum::<f64>() - radius * radius;
                if b * b - c < 0.02 {
                    continue;
                }
                let t = -b + (b * b - c).sqrt();
                if t * w[2] < 0.03 {
                    continue;
                }
                let expected = [at[0] + t * w[0], at[1] + t * w[1], t * w[2]];
                let seen = model.point(&model.seen(at, w).hit).position;
                assert!((0..3).all(|k| (seen[k] - expected[k]).abs() < 2e-4), "{seen:?} {expected:?}");
                checked += 1;
            }
        }
        assert!(checked > 200, "{checked}");
    }

    #[test]
    fn rays_on_both_sides_of_an_edge_are_not_mixed() {
        // A wall: seen from the side, rays of one texel land on its top or far behind.
        let model = height_field(64, |x, _| if x > 0.5 { 0.3 } else { 0.0 });
        let header = VdimHeader { size: 16, ..HEADER };
        let (mut top, mut ground) = (0, 0);
        each(&model, header, 4, |[i, _], [polar, azimuth], _, z| {
            // From the right, the edge of the wall's top hides the ground from 0.295 on: inside texel 4.
            if (3..=6).contains(&i) && azimuth == 0.0 && (polar - 0.6).abs() < 1e-6 {
                assert!(!(0.01..=0.29).contains(&z), "{z}");
                *(if z > 0.1 { &mut top } else { &mut ground }) += 1;
            }
        });
        assert!(top > 0 && ground > 0);
    }

    #[test]
    fn threads_do_not_matter() {
        let tau = std::f64::consts::TAU;
        let model = height_field(16, |x, y| 0.075 * ((tau * x).sin() + (tau * (y + x)).cos()));
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| map(&model))
        };
        assert_eq!(run(1), run(4));
    }
}
