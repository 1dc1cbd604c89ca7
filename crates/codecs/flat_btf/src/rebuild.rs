//! Images of ordinary BTFs, computed directly and rebuilt from a flat BTF by equation 1 of Hadim et al. 2009,
//! `BTF_{v,l}(i, j) = FBTF_{v,l}(VDIM_v(i, j))`.

use super::model::MesoModel;
use super::surface::{Appearance, SurfacePoint};
use brdfc_formats::direction::Vector;
use brdfc_formats::tap::{Tap, bilinear};
use rayon::prelude::*;

/// Surface points that a view sees through the texels of the reference plane: `oversampling²` for each.
pub struct ViewImage {
    /// Texels per side.
    pub size: usize,
    view: Vector,
    /// Rays per texel.
    per_texel: usize,
    points: Vec<SurfacePoint>,
    parameters: Vec<[f32; 2]>,
}

impl ViewImage {
    /// Casts the rays of one view.
    pub fn new(model: &MesoModel, view: Vector, size: usize, oversampling: usize) -> Self {
        let per_texel = oversampling * oversampling;
        let ray = |index: usize| {
            let (texel, sub) = (index / per_texel, index % per_texel);
            let at = |texel: usize, sub: usize| (texel as f64 + (sub as f64 + 0.5) / oversampling as f64) / size as f64;
            let seen = model.seen([at(texel % size, sub % oversampling), at(texel / size, sub / oversampling)], view);
            (model.point(&seen.hit), seen.parameters.map(|c| c.rem_euclid(1.0) as f32))
        };
        let (points, parameters) = (0..size * size * per_texel).into_par_iter().map(ray).unzip();
        Self { size, view, per_texel, points, parameters }
    }

    /// Image of the surface under one light: means over the rays of a texel.
    pub fn direct(&self, model: &MesoModel, appearance: &Appearance, light: Vector) -> Vec<[f32; 3]> {
        let value = |point: &SurfacePoint| match model.caster.sees_sky(point, light) {
            true => appearance.relative_radiance(point, self.view, light),
            false => [0.0; 3],
        };
        self.points.chunks_exact(self.per_texel).map(|points| mean(points.iter().map(value), self.per_texel)).collect()
    }

    /// Image rebuilt from the flat image of the same view and light: the mean of bilinear, periodic look-ups at the
    /// points that the rays of a texel see. It does not use an indirection map, so that its error comes from the
    /// flat image alone.
    pub fn rebuilt(&self, flat: &[[f32; 3]]) -> Vec<[f32; 3]> {
        let values = sample_bilinear(flat, &self.parameters);
        values.chunks_exact(self.per_texel).map(|values| mean(values.iter().copied(), self.per_texel)).collect()
    }
}

/// Bilinear, periodic look-ups into a flat image.
pub fn sample_bilinear(flat: &[[f32; 3]], parameters: &[[f32; 2]]) -> Vec<[f32; 3]> {
    let size = flat.len().isqrt();
    parameters.iter().map(|at| periodic_bilinear(size, *at, |texel| flat[texel])).collect()
}

fn mean(values: impl Iterator<Item = [f32; 3]>, count: usize) -> [f32; 3] {
    let sum = values.fold([0.0f32; 3], |sum, value| [sum[0] + value[0], sum[1] + value[1], sum[2] + value[2]]);
    sum.map(|s| s / count as f32)
}

/// Bilinear value of a periodic image of `size` x `size` texels; `texel` returns the texels, row by row.
pub fn periodic_bilinear(size: usize, [u, v]: [f32; 2], texel: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let axis = |c: f32| Tap::new(c * size as f32, size as u32, true);
    bilinear([axis(u), axis(v)], |[x, y]| texel(y * size + x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light_field::{ComputedField, FlattenedView, Holes, visible};
    use crate::testing::overhang;
    use brdfc_core::address::parse_synth;
    use brdfc_formats::direction::from_polar;

    #[test]
    fn equation_1_converges_to_the_btf_with_more_texels() {
        let model = MesoModel::new(overhang(48), 0, &()).unwrap();
        let appearance =
            Appearance { sources: vec![parse_synth("synth:lewis?kd=0.5&ks=0.1&n=8").unwrap()], ..Default::default() };
        let (views, lights) = ([from_polar(0.8, 0.6)], [from_polar(0.5, 2.0)]);
        let seen = ViewImage::new(&model, views[0], 48, 1);
        let reference = seen.direct(&model, &appearance, lights[0]);
        let error = |texels: usize, turned: f64| {
            let map = model.texels(texels);
            let lit = [visible(&map, &model.caster, lights[0])];
            let field = ComputedField::new(&map, &appearance, &views, &lights, &lit);
            let mask = visible(&map, &model.caster, views[0]);
            let Ok(flat) = FlattenedView::new(&field, 0, &mask, Holes::PushPull).unwrap().image(0);
            let seen = ViewImage::new(&model, from_polar(0.8, 0.6 + turned), 48, 1);
            let rebuilt = seen.rebuilt(&flat);
            let off = rebuilt.iter().zip(&reference).map(|(a, b)| (a[0] - b[0]).abs()).sum::<f32>();
            off / reference.iter().map(|v| v[0]).sum::<f32>()
        };
        let (coarse, fine) = (error(32, 0.0), error(256, 0.0));
        assert!(coarse < 0.2 && fine < 0.02 && fine < 0.4 * coarse, "{coarse} {fine}");
        // The negative control: the map of another view.
        assert!(error(256, 0.5) > 10.0 * fine);
    }
}
