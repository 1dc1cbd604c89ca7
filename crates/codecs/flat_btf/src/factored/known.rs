//! Reflectance of surfaces whose materials are known: a table for each material, and for each texel a normal, a tint and
//! a share, without views and lights.
//!
//! Materials are evaluated in the frame of the normal, so that one table of pairs of directions serves all texels.

use super::assemble::{self, Shape};
use super::base::{Albedo, Rays, StoredBase};
use super::gloss::fit_table;
use super::masks::Masks;
use super::measure::summary;
use super::report::{Factored, FactoredFacts, FactoredTrial};
use super::sample::{Sample, choose};
use crate::texels::TexelSurface;
use brdfc_core::{Source, Tally};
use brdfc_formats::FormatError;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::FlatHeader;
use brdfc_formats::flat_btf::factored::{
    Axis, BaseMaterial, BaseTable, BaseTexel, BasisMap, ChromaRange, FactoredHeader, LevelTable, MAX_ENTRY,
    MAX_MATERIALS, TablePlace,
};
use brdfc_metrics::lab::{distance_squared, lab};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Number of texels that errors are measured at.
const MEASURED: usize = 225;
/// One in this many pairs of directions is used for errors.
const THINNED: usize = 7;
const UP: [f32; 3] = [0.0, 0.0, 1.0];

/// Values of a material at all pairs of sampled directions: radiance divided by that of a white diffuser that faces the
/// light. Pair `view * lights + light`.
struct KnownValues<'a> {
    rays: &'a Rays,
    values: Vec<[f32; 3]>,
}

fn directions(rays: &Rays, pair: usize) -> [[f32; 3]; 2] {
    let lights = rays.lights.len();
    [rays.views[pair / lights], rays.lights[pair % lights]]
}

impl<'a> KnownValues<'a> {
    fn new(source: &dyn Source, rays: &'a Rays) -> Self {
        let value = |pair: usize| {
            let [view, light] = directions(rays, pair);
            let pair = DirectionPair::new(light.map(f64::from), view.map(f64::from));
            let f_r = source.eval(pair, &mut Tally::default());
            f_r.map(|f_r| (PI * f64::from(light[2]) * f_r.max(0.0)) as f32)
        };
        Self { rays, values: (0..rays.views.len() * rays.lights.len()).into_par_iter().map(value).collect() }
    }

    /// Fits a material over the axis with the smaller error.
    fn material(&self) -> Result<BaseMaterial, FormatError> {
        let [half, mirror] = [self.fit(Axis::Half)?, self.fit(Axis::Mirror)?];
        Ok(if self.error(&mirror) < self.error(&half) { mirror } else { half })
    }

    /// Fits a material over an axis.
    fn fit(&self, axis: Axis) -> Result<BaseMaterial, FormatError> {
        let lights = self.rays.lights.len();
        let words = |values: &[[f32; 3]]| values.iter().map(|value| rgb9e5::encode(*value)).collect();
        let views: Vec<Vec<u32>> = self.values.chunks_exact(lights).map(words).collect();
        let sample = Sample { texels: vec![0], masks: Masks::all(views.len(), 1), lights, views };
        let (table, albedos) = fit_table(axis, &sample, &[UP], self.rays, &|_, _| true)?;
        let [red, green, blue, gloss] = albedos[0];
        let scaled = table.entries().iter().map(|entry| entry.map(|c| (gloss * c).min(MAX_ENTRY)));
        let table = BaseTable::new(scaled.collect())?.over(axis);
        Ok(BaseMaterial { diffuse: [red, green, blue], tables: vec![LevelTable::close_up(table)] })
    }

    /// Mean ΔE of a material.
    fn error(&self, material: &BaseMaterial) -> f64 {
        let pairs = (0..self.values.len()).step_by(THINNED);
        let texel = BaseTexel { diffuse: [1.0; 3], gloss: 0.0, normal: UP, tables: TablePlace::default() };
        let difference = |pair: usize| {
            let [view, light] = directions(self.rays, pair);
            f64::from(distance_squared(lab(material.value(&texel, view, light)), lab(self.values[pair])).sqrt())
        };
        pairs.clone().map(difference).sum::<f64>() / pairs.len().max(1) as f64
    }
}

/// Tint (three) and share of the second material of a texel.
fn tint(shares: &[[f32; 3]]) -> Albedo {
    let sum = |shares: &[f32; 3]| shares.iter().sum::<f32>();
    let second = shares.get(1).map_or(0.0, sum);
    let all = sum(&shares[0]) + second;
    let [red, green, blue] = [0, 1, 2].map(|c: usize| shares.iter().map(|share| share[c]).sum());
    [red, green, blue, if all > 0.0 { second / all } else { 0.0 }]
}

/// Directions at which materials are evaluated, and texels per side.
fn sampled(size: u32) -> FlatHeader {
    let set = DirectionSet::ubo2014();
    let angles: Vec<[f32; 2]> = set.angles.iter().map(|angles| angles.map(|angle| angle.to_radians() as f32)).collect();
    FlatHeader { size, view: 0, views: angles.clone(), lights: angles }
}

/// Least bytes on a GPU of known materials, at `size x size` texels.
pub fn least_bytes(size: u32) -> u64 {
    let none = FlatHeader { views: Vec::new(), lights: Vec::new(), ..sampled(size) };
    let header = assemble::header(Shape { groups: 0, residual: 0 }, size, &none, ChromaRange::ALL);
    FactoredHeader { materials: 1, table_levels: header.levels, ..header }.gpu_bytes()
}

/// Fits the materials of a surface. `None` for more than [`MAX_MATERIALS`]. Each level has the tables of the finest;
/// mipmaps weight texels by `counts`. The error is the mean over pairs of directions up to 75 degrees from
/// the normal.
///
/// # Errors
/// Returns an error only for layouts that cannot be: too many texels.
pub fn known(
    sources: &[Box<dyn Source>],
    surface: &TexelSurface,
    size: u32,
    counts: &[f32],
) -> Result<Option<Factored>, FormatError> {
    if sources.len() > MAX_MATERIALS as usize {
        return Ok(None);
    }
    let sampled = sampled(size);
    let rays = Rays::new(&sampled);
    let values: Vec<KnownValues<'_>> = sources.iter().map(|source| KnownValues::new(&**source, &rays)).collect();
    let mut materials = values.iter().map(KnownValues::material).collect::<Result<Vec<_>, _>>()?;
    let tints: Vec<Albedo> = surface.shares.iter().map(|shares| tint(&shares[..sources.len()])).collect();
    let base = StoredBase::new(BaseTable::black(), &tints, &surface.normals);

    let none = FlatHeader { views: Vec::new(), lights: Vec::new(), ..sampled };
    let header = assemble::header(Shape { groups: 0, residual: 0 }, size, &none, ChromaRange::ALL);
    let levels = header.levels as usize;
    materials.iter_mut().for_each(|material| material.tables = vec![material.tables[0].clone(); levels]);
    let basis = BasisMap::of_materials(header, &materials)?;
    let [_, measured] = choose(tints.len(), 0, MEASURED);
    let of_texel = |at: &usize| -> Vec<f32> {
        let texel = BaseTexel { normal: UP, ..*base.texel(*at) };
        let difference = |pair: usize| {
            let [view, light] = directions(&rays, pair);
            let truth = [0, 1, 2].map(|c: usize| {
                values.iter().zip(&surface.shares[*at]).map(|(of, share)| share[c] * of.values[pair][c]).sum()
            });
            distance_squared(lab(basis.colour(&texel, view, light)), lab(truth)).sqrt()
        };
        (0..values[0].values.len()).step_by(THINNED).map(difference).collect()
    };
    let mut all: Vec<f32> = measured.par_iter().map(of_texel).collect::<Vec<_>>().concat();
    let errors = summary(measured.len(), all.clone(), &mut all);

    let counts: Vec<f32> = counts.iter().map(|count| count.max(assemble::MIN_COUNT)).collect();
    let asset = assemble::asset(basis, &base, &[], &counts, None)?.with_errors(errors);
    let gpu_bytes = asset.gpu_bytes();
    let trial = FactoredTrial { components: 0, residual: 0, gpu_bytes, errors };
    let facts = FactoredFacts { components: 0, residual: 0, gpu_bytes, errors, tried: vec![trial] };
    Ok(Some(Factored { asset, facts }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_core::address::parse_synth;

    /// A Phong lobe is a function of the mirror angle, and a Cook-Torrance lobe of half and difference angles. The
    /// control of each is the other axis.
    #[test]
    fn lobes_have_tables_over_their_own_angles() {
        let rays = Rays::new(&sampled(1));
        for (address, axis) in [("synth:lewis?kd=0.5&ks=0.1&n=8", Axis::Mirror), ("synth:ggx", Axis::Half)] {
            let values = KnownValues::new(&*parse_synth(address).unwrap(), &rays);
            let [half, mirror] = [Axis::Half, Axis::Mirror].map(|axis| values.error(&values.fit(axis).unwrap()));
            println!("{address}: half {half}, mirror {mirror}");
            let (own, other) = if axis == Axis::Half { (half, mirror) } else { (mirror, half) };
            assert!(own < 0.1 && own < 0.2 * other, "{address}: {half} {mirror}");
            assert_eq!(values.material().unwrap(), values.fit(axis).unwrap());
        }
    }
}
