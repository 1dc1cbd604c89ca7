//! Diffuse reflectance of texels, for the light form of flat BTFs (section 3.5 of Hadim et al. 2009): the `ρ` for which
//! `ρ max(0, n · l)` fits the values best where light arrives.

use super::texels::TexelMap;
use brdfc_formats::direction::{Vector, dot};
use rayon::prelude::*;

/// Sums of a least squares fit, texel by texel.
pub struct DiffuseFit {
    /// `Σ value c` and `Σ c²` with `c = n · l`.
    sums: Vec<([f64; 3], f64)>,
}

impl DiffuseFit {
    /// Creates a fit for `texels` texels.
    pub fn new(texels: usize) -> Self {
        Self { sums: vec![([0.0; 3], 0.0); texels] }
    }

    /// Adds the images of one view: `value(light, texel)` for texels that the view sees and the light reaches.
    pub fn add_view(
        &mut self,
        map: &TexelMap,
        mask: &[bool],
        lights: &[Vector],
        lit: impl Fn(usize, usize) -> bool + Sync,
        value: impl Fn(usize, usize) -> [f32; 3] + Sync,
    ) {
        self.sums.par_iter_mut().enumerate().filter(|(texel, _)| mask[*texel]).for_each(|(texel, (sum, weight))| {
            for (light, direction) in lights.iter().enumerate() {
                let cosine = dot(map.points[texel].normal, *direction);
                if cosine > 0.0 && lit(light, texel) {
                    let value = value(light, texel);
                    (0..3).for_each(|k| sum[k] += cosine * f64::from(value[k]));
                    *weight += cosine * cosine;
                }
            }
        });
    }

    /// Reflectance of each texel; `None` if no view sees it lit.
    pub fn reflectances(&self) -> Vec<Option<[f32; 3]>> {
        self.sums.iter().map(|(sum, weight)| (*weight > 0.0).then(|| sum.map(|s| (s / weight) as f32))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::MesoModel;
    use crate::testing::bumps;
    use brdfc_formats::direction::from_polar;

    #[test]
    fn a_matte_surface_gets_its_albedo() {
        let map = MesoModel::new(bumps(12, 0.4), 0, &()).unwrap().texels(8);
        let lights = [from_polar(0.2, 0.0), from_polar(1.0, 2.0)];
        let mut fit = DiffuseFit::new(64);
        let mask: Vec<bool> = (0..64).map(|t| t != 5).collect();
        let value = |light: usize, texel: usize| {
            let cosine = dot(map.points[texel].normal, lights[light]) as f32;
            [0.3 * cosine, 0.6 * cosine, 0.0]
        };
        fit.add_view(&map, &mask, &lights, |_, _| true, value);
        for (texel, found) in fit.reflectances().into_iter().enumerate() {
            match found {
                Some(rho) => assert!((rho[0] - 0.3).abs() < 1e-6 && (rho[1] - 0.6).abs() < 1e-6),
                None => assert_eq!(texel, 5),
            }
        }
    }
}
