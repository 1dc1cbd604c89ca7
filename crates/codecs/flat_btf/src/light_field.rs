//! Values of flat BTFs: the light that each texel of the surface reflects, for each view and light (section 3.3 of
//! Hadim et al. 2009).
//!
//! Views are computed one at a time: memory holds one image per light and the shadows, never views x lights.

use super::caster::PeriodicCaster;
use super::fill::{Poisson, PushPull};
use super::interreflection::Bounces;
use super::surface::{Appearance, SurfacePoint};
use super::texels::TexelMap;
use brdfc_core::progress::{Cancelled, Progress};
use brdfc_formats::direction::{Vector, dot, from_polar};
use rayon::prelude::*;

/// Source of texel values: a surface and its materials, or measured images.
pub trait LightField: Sync {
    /// Error of reading values.
    type Error: Send;
    /// State prepared once for all lights of a view.
    type View: Send + Sync;

    /// Prepares a view for `texels`, all of which it sees.
    ///
    /// # Errors
    /// Returns an error if values cannot be read.
    fn view(&self, view: usize, texels: Vec<u32>) -> Result<Self::View, Self::Error>;

    /// Values at the texels of a view under one light: radiance divided by the radiance of a white diffuser that faces
    /// the light.
    ///
    /// # Errors
    /// Returns an error if values cannot be read.
    fn values(&self, view: &Self::View, light: usize) -> Result<Vec<[f32; 3]>, Self::Error>;
}

/// Computes [`visible`] for each of `directions`, one progress step each.
///
/// # Errors
/// Returns an error if `progress` cancels.
pub fn visible_from_each(
    texels: &TexelMap,
    caster: &PeriodicCaster,
    directions: &[Vector],
    progress: &dyn Progress,
) -> Result<Vec<Vec<bool>>, Cancelled> {
    let one = |direction: &Vector| {
        let mask = visible(texels, caster, *direction);
        progress.step().map(|()| mask)
    };
    directions.iter().map(one).collect()
}

/// For each texel, true if it is visible from infinitely far away in direction `view`: neither turned away nor hidden
/// by the repeated surface.
pub fn visible(texels: &TexelMap, caster: &PeriodicCaster, view: Vector) -> Vec<bool> {
    let seen = |point: &SurfacePoint| dot(point.normal, view) > 0.0 && caster.sees_sky(point, view);
    texels.points.par_iter().map(seen).collect()
}

/// Number of views of [`projected`], and the largest sine of their polar angles, squared.
const PROJECTED_VIEWS: usize = 13;
const LARGEST_SINE_SQUARED: f64 = 0.9;

/// For each texel, the area that views see of it over its own: the mean over views up to 72 degrees from the normal of
/// the plane.
pub fn projected(texels: &TexelMap, caster: &PeriodicCaster) -> Vec<f32> {
    // A spiral with equal steps of area in the disc of sines.
    let view = |k: usize| {
        let sine = (LARGEST_SINE_SQUARED * (k as f64 + 0.5) / PROJECTED_VIEWS as f64).sqrt();
        from_polar(sine.asin(), 2.399_963 * k as f64)
    };
    let views: Vec<Vector> = (0..PROJECTED_VIEWS).map(view).collect();
    let of_texel = |point: &SurfacePoint| {
        let area = |view: &Vector| {
            let cosine = dot(point.normal, *view);
            if cosine > 0.0 && caster.sees_sky(point, *view) { cosine } else { 0.0 }
        };
        (views.iter().map(area).sum::<f64>() / views.len() as f64) as f32
    };
    texels.points.par_iter().map(of_texel).collect()
}

/// Values computed from a surface and its materials: direct light with cast shadows, and optionally light of one
/// bounce.
pub struct ComputedField<'a> {
    texels: &'a TexelMap,
    appearance: &'a Appearance,
    views: &'a [Vector],
    lights: &'a [Vector],
    /// For each light, the texels that it reaches.
    lit: &'a [Vec<bool>],
    bounces: Option<Bounces>,
}

impl<'a> ComputedField<'a> {
    /// Creates a field. `lit` holds, for each light, the texels that it reaches: [`visible_from_each`] of `lights`.
    pub fn new(
        texels: &'a TexelMap,
        appearance: &'a Appearance,
        views: &'a [Vector],
        lights: &'a [Vector],
        lit: &'a [Vec<bool>],
    ) -> Self {
        Self { texels, appearance, views, lights, lit, bounces: None }
    }

    /// Adds the light of one bounce.
    pub fn with_bounces(self, bounces: Bounces) -> Self {
        Self { bounces: Some(bounces), ..self }
    }
}

/// A view of a [`ComputedField`].
pub struct ComputedView {
    view: usize,
    texels: Vec<u32>,
    /// For each texel and ray, the share of the light arriving along the ray that leaves towards the view.
    shares: Vec<[f32; 3]>,
}

impl LightField for ComputedField<'_> {
    type Error = std::convert::Infallible;
    type View = ComputedView;

    fn view(&self, view: usize, texels: Vec<u32>) -> Result<ComputedView, Self::Error> {
        let shares = self
            .bounces
            .as_ref()
            .map_or(Vec::new(), |bounces| bounces.shares(self.appearance, self.texels, self.views[view], &texels));
        Ok(ComputedView { view, texels, shares })
    }

    fn values(&self, view: &ComputedView, light: usize) -> Result<Vec<[f32; 3]>, Self::Error> {
        let (towards, from) = (self.views[view.view], self.lights[light]);
        let value = |(nth, texel): (usize, &u32)| {
            let index = *texel as usize;
            let mut value = match self.lit[light][index] {
                true => self.appearance.relative_radiance(&self.texels.points[index], towards, from),
                false => [0.0; 3],
            };
            if let Some(bounces) = &self.bounces {
                let added = bounces.gathered(index, light, &view.shares, nth);
                (0..3).for_each(|k| value[k] += added[k]);
            }
            value
        };
        Ok(view.texels.iter().enumerate().map(value).collect())
    }
}

/// Guide images for filling holes, one for each light: every texel as seen by the most vertical view that sees it.
pub struct FillGuide {
    images: Vec<Vec<[f32; 3]>>,
}

impl FillGuide {
    /// Builds the guide from the views in `order`, the most vertical first. Texels that no view sees are filled from
    /// their neighbours.
    ///
    /// # Errors
    /// Returns the errors of `field`.
    pub fn new<F: LightField>(
        field: &F,
        masks: &[Vec<bool>],
        order: &[usize],
        lights: usize,
    ) -> Result<Self, F::Error> {
        let texels = masks[0].len();
        let mut known = vec![false; texels];
        let mut firsts: Vec<(F::View, Vec<u32>)> = Vec::new();
        for view in order {
            let first: Vec<u32> =
                (0..texels as u32).filter(|t| masks[*view][*t as usize] && !known[*t as usize]).collect();
            first.iter().for_each(|texel| known[*texel as usize] = true);
            if !first.is_empty() {
                firsts.push((field.view(*view, first.clone())?, first));
            }
        }
        let fill = PushPull::new(&known);
        let image = |light: usize| {
            let mut image = vec![[0.0; 3]; texels];
            for (view, first) in &firsts {
                let values = field.values(view, light)?;
                first.iter().zip(values).for_each(|(texel, value)| image[*texel as usize] = value);
            }
            fill.fill(&mut image);
            Ok(image)
        };
        Ok(Self { images: (0..lights).into_par_iter().map(image).collect::<Result<_, _>>()? })
    }
}

/// One view of a flat BTF, ready to produce its images.
pub struct FlattenedView<'a, F: LightField> {
    field: &'a F,
    view: F::View,
    seen: Vec<u32>,
    texels: usize,
    fill: Fill<'a>,
}

enum Fill<'a> {
    Black,
    PushPull(PushPull),
    Poisson(Poisson, &'a FillGuide),
}

/// Treatment of texels that a view does not see.
#[derive(Clone, Copy)]
pub enum Holes<'a> {
    /// They stay black, for callers that do not read them.
    Black,
    /// Filled by push-pull.
    PushPull,
    /// Filled by Poisson inpainting after this guide.
    Poisson(&'a FillGuide),
}

impl<'a, F: LightField> FlattenedView<'a, F> {
    /// Prepares a view with the texels that it sees.
    ///
    /// # Errors
    /// Returns the errors of the field.
    pub fn new(field: &'a F, view: usize, mask: &[bool], holes: Holes<'a>) -> Result<Self, F::Error> {
        let fill = match holes {
            Holes::Black => Fill::Black,
            Holes::PushPull => Fill::PushPull(PushPull::new(mask)),
            Holes::Poisson(guide) => Fill::Poisson(Poisson::new(mask), guide),
        };
        let seen: Vec<u32> = (0..mask.len() as u32).filter(|texel| mask[*texel as usize]).collect();
        Ok(Self { field, view: field.view(view, seen.clone())?, seen, texels: mask.len(), fill })
    }

    /// Image under one light: seen texels unchanged, the others filled.
    ///
    /// # Errors
    /// Returns the errors of the field.
    pub fn image(&self, light: usize) -> Result<Vec<[f32; 3]>, F::Error> {
        let values = self.field.values(&self.view, light)?;
        let mut image = vec![[0.0; 3]; self.texels];
        self.seen.iter().zip(values).for_each(|(texel, value)| image[*texel as usize] = value);
        match &self.fill {
            Fill::Black => {}
            Fill::PushPull(fill) => fill.fill(&mut image),
            Fill::Poisson(fill, guide) => fill.fill(&mut image, &guide.images[light]),
        }
        Ok(image)
    }
}

/// Indices of the views, the most vertical first.
pub fn from_above(views: &[Vector]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..views.len()).collect();
    order.sort_by(|a, b| views[*b][2].total_cmp(&views[*a][2]).then(a.cmp(b)));
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::PeriodicMesh;
    use crate::parameterise::parameterise;
    use crate::testing::{bumps, height_field, overhang};
    use crate::texels::texel_map;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::from_polar;

    fn made_of(address: &str) -> Appearance {
        Appearance { sources: vec![parse_synth(address).unwrap()], ..Default::default() }
    }

    fn lit(texels: &TexelMap, caster: &PeriodicCaster, lights: &[Vector]) -> Vec<Vec<bool>> {
        visible_from_each(texels, caster, lights, &()).unwrap()
    }

    fn field<'a>(
        mesh: &PeriodicMesh,
        texels: &'a TexelMap,
        caster: &PeriodicCaster,
        material: &'a Appearance,
        [views, lights]: [&'a [Vector]; 2],
        (samples, lit): (usize, &'a [Vec<bool>]),
    ) -> ComputedField<'a> {
        let field = ComputedField::new(texels, material, views, lights, lit);
        if samples == 0 {
            return field;
        }
        field.with_bounces(Bounces::new(mesh, texels, caster, material, lights, samples, &()).unwrap())
    }

    fn flat_texels(mesh: &PeriodicMesh, size: usize) -> TexelMap {
        texel_map(mesh, &parameterise(mesh, 0, &()).unwrap().coordinates, size)
    }

    #[test]
    fn a_plane_reflects_like_its_material() {
        let mesh = height_field(5, |_, _| 0.0);
        let (texels, caster) = (flat_texels(&mesh, 8), PeriodicCaster::new(&mesh));
        let views = [from_polar(0.9, 1.0), [0.0, 0.0, 1.0]];
        let lights = [from_polar(0.5, 3.0), from_polar(1.2, 0.0)];
        let material = made_of("synth:lambert?kd=0.2,0.5,0.8");
        // A plane does not illuminate itself: a bounce adds nothing.
        for samples in [0, 4] {
            let lit = lit(&texels, &caster, &lights);
            let field = field(&mesh, &texels, &caster, &material, [&views, &lights], (samples, &lit));
            let mask = visible(&texels, &caster, views[0]);
            assert!(mask.iter().all(|seen| *seen));
            let flat = FlattenedView::new(&field, 0, &mask, Holes::PushPull).unwrap();
            for (light, direction) in lights.iter().enumerate() {
                let Ok(image) = flat.image(light);
                assert!(image.iter().all(|v| (f64::from(v[1]) - 0.5 * direction[2]).abs() < 1e-6));
            }
        }
    }

    #[test]
    fn shadows_are_where_the_light_does_not_see() {
        let mesh = bumps(32, 0.5);
        let (texels, caster) = (flat_texels(&mesh, 32), PeriodicCaster::new(&mesh));
        let views = [[0.0, 0.0, 1.0]];
        let lights = [from_polar(1.25, 0.4)];
        let material = made_of("synth:lambert?kd=1");
        let lit = lit(&texels, &caster, &lights);
        let field = ComputedField::new(&texels, &material, &views, &lights, &lit);
        let Ok(image) =
            FlattenedView::new(&field, 0, &visible(&texels, &caster, views[0]), Holes::PushPull).unwrap().image(0);
        let dark = image.iter().filter(|v| v[0] == 0.0).count();
        let (mut turned_away, mut shadowed) = (0, 0);
        for (point, lit) in texels.points.iter().zip(&lit[0]) {
            let faces = dot(point.normal, lights[0]) > 0.0 && dot(point.geometric_normal, lights[0]) > 0.0;
            assert!(faces || !lit);
            turned_away += usize::from(!faces);
            shadowed += usize::from(faces && !lit);
        }
        assert!(shadowed > 30 && turned_away > 30, "{shadowed} {turned_away}");
        assert_eq!(dark, shadowed + turned_away);
    }

    #[test]
    fn holes_of_a_matte_surface_are_filled_from_other_views() {
        let mesh = overhang(48);
        let (texels, caster) = (flat_texels(&mesh, 64), PeriodicCaster::new(&mesh));
        let views = [[0.0, 0.0, 1.0], from_polar(1.1, 0.0), from_polar(1.1, std::f64::consts::PI)];
        let lights = [from_polar(0.6, 1.0)];
        let material = made_of("synth:lambert?kd=0.7");
        let lit = lit(&texels, &caster, &lights);
        let field = ComputedField::new(&texels, &material, &views, &lights, &lit);
        let masks: Vec<Vec<bool>> = views.iter().map(|view| visible(&texels, &caster, *view)).collect();
        let guide = FillGuide::new(&field, &masks, &from_above(&views), 1).unwrap();
        let known: Vec<bool> = (0..64 * 64).map(|t| masks.iter().any(|mask| mask[t])).collect();
        let all: Vec<u32> = (0..64 * 64).collect();
        let Ok(truth) = field.values(&field.view(0, all).unwrap(), 0);
        let error = |holes| {
            let Ok(image) = FlattenedView::new(&field, 1, &masks[1], holes).unwrap().image(0);
            let off = |t: &usize| f64::from((image[*t][0] - truth[*t][0]).abs());
            let seen: f64 = (0..64 * 64).filter(|t| masks[1][*t]).map(|t| off(&t)).sum();
            assert_eq!(seen, 0.0, "seen texels are unchanged");
            (0..64 * 64).filter(|t| known[*t] && !masks[1][*t]).map(|t| off(&t)).sum::<f64>()
        };
        // A matte surface looks the same from everywhere: the guide is exact; push-pull can only interpolate.
        let (poisson, push_pull) = (error(Holes::Poisson(&guide)), error(Holes::PushPull));
        assert!(push_pull > 10.0 && poisson < 0.02 * push_pull, "{poisson} {push_pull}");
    }

    /// Texels with centres on the bottom line of a crease: a ray that starts along the normal of one side starts behind
    /// the other side.
    #[test]
    fn the_bottom_of_a_crease_is_seen() {
        let size = 64;
        let wave = |x: f64, _: f64| {
            let t = (4.0 * (x - 0.5 / size as f64)).rem_euclid(1.0);
            0.5 * if t < 0.5 { t } else { 1.0 - t }
        };
        let mesh = height_field(size, wave);
        let (texels, caster) = (flat_texels(&mesh, size), PeriodicCaster::new(&mesh));
        for view in [[0.0, 0.0, 1.0], from_polar(0.1, 1.0)] {
            let unseen = visible(&texels, &caster, view).iter().filter(|seen| !**seen).count();
            assert_eq!(unseen, 0, "{view:?}");
        }
        // The negative control: hidden texels stay hidden.
        let slanted = visible(&texels, &caster, from_polar(1.2, 0.0));
        assert!(slanted.iter().filter(|seen| !**seen).count() > size * size / 3);
    }

    #[test]
    fn one_bounce_in_a_furnace_of_white_walls() {
        // Many lights illuminate the surface evenly from all directions: direct and bounced light together stay below
        // 1. A bounce only adds light, most where the surface hides most of the sky.
        let mesh = bumps(24, 1.0);
        let (texels, caster) = (flat_texels(&mesh, 16), PeriodicCaster::new(&mesh));
        let views = [[0.0, 0.0, 1.0]];
        let lights: Vec<Vector> = (0..64)
            .map(|k| {
                // Equal solid angles times cosine.
                let (ring, turn) = (k / 8, k % 8);
                let z = (1.0 - (f64::from(ring) + 0.5) / 8.0).sqrt();
                from_polar(z.acos(), f64::from(turn) * std::f64::consts::TAU / 8.0)
            })
            .collect();
        let material = made_of("synth:lambert?kd=1");
        let total = |samples: usize| -> Vec<f64> {
            let lit = lit(&texels, &caster, &lights);
            let field = field(&mesh, &texels, &caster, &material, [&views, &lights], (samples, &lit));
            let all: Vec<u32> = (0..16 * 16).collect();
            let view = field.view(0, all).unwrap();
            let mut sum = vec![0.0; 16 * 16];
            for (light, direction) in lights.iter().enumerate() {
                let Ok(values) = field.values(&view, light);
                // A light that covers a cosine-weighted 1/64 of the sky.
                sum.iter_mut().zip(values).for_each(|(s, v)| *s += f64::from(v[0]) / direction[2] / 64.0);
            }
            sum
        };
        let (direct, bounced) = (total(0), total(64));
        let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
        let lost = 1.0 - mean(&direct);
        assert!(lost > 0.1, "{lost}");
        let gained = mean(&bounced) - mean(&direct);
        // The first bounce returns most of the light that the walls block, and never more.
        assert!(gained > 0.4 * lost && gained < 1.0 * lost, "{gained} {lost}");
        assert!(direct.iter().zip(&bounced).all(|(d, b)| b >= d));
    }
}
