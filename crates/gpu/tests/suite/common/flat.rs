//! Flat BTFs of procedural structures, built in memory.

use brdfc_core::address::parse_synth;
use brdfc_flat_btf::indirection::indirection;
use brdfc_flat_btf::light_field::{ComputedField, FlattenedView, Holes, visible};
use brdfc_flat_btf::model::MesoModel;
use brdfc_flat_btf::structures::Structure;
use brdfc_flat_btf::surface::Appearance;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction::dot;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfParts, FlatHeader, FlatValues, FlatView, IndirectionHeader, IndirectionMap, NormalMap,
    ReferenceMap,
};

/// A structure such as `button?resolution=48`, and its appearance: its own materials, or another one.
pub fn structure(address: &str, material: Option<&str>) -> (MesoModel, Appearance) {
    let structure = Structure::parse(address).unwrap();
    let materials = material.map_or(structure.default_materials().to_vec(), |material| vec![material; 4]);
    let sources = materials.into_iter().map(|address| parse_synth(address).unwrap()).collect();
    (MesoModel::new(structure.mesh(), 2, &()).unwrap(), Appearance { sources, ..Default::default() })
}

/// A flat BTF of a structure. `texels` per side must be a power of 2.
pub fn parts(
    model: &MesoModel,
    appearance: &Appearance,
    texels: usize,
    header: IndirectionHeader,
    [views, lights]: [&DirectionSet; 2],
) -> FlatBtfParts {
    let map = model.texels(texels);
    let [towards, from] = [views.directions(), lights.directions()];
    let lit: Vec<Vec<bool>> = from.iter().map(|from| visible(&map, &model.caster, *from)).collect();
    let field = ComputedField::new(&map, appearance, &towards, &from, &lit);
    let [view_angles, light_angles] = [views, lights].map(angles);
    // Least squares of diffuse colours: sums of value x cosine and of cosine² over visible and lit points.
    let mut sums = vec![([0.0f64; 3], 0.0f64); texels * texels];
    let mut flat_views = Vec::new();
    for (view, towards) in towards.iter().enumerate() {
        let mask = visible(&map, &model.caster, *towards);
        let flat = FlattenedView::new(&field, view, &mask, Holes::PushPull).unwrap();
        let mut packed = Vec::with_capacity(texels * texels * from.len());
        for (light, from) in from.iter().enumerate() {
            let image = flat.image(light).unwrap();
            packed.extend(image.iter().map(|value| rgb9e5::encode(*value)));
            add(&mut sums, &image, &mask, &lit[light], |texel| dot(map.points[texel].normal, *from));
        }
        let (views, lights) = (view_angles.clone(), light_angles.clone());
        let header = FlatHeader { size: texels as u32, view: view as u32, views, lights };
        flat_views.push(FlatView::new(header, packed).unwrap());
    }
    let colour = |([r, g, b], weight): &([f64; 3], f64)| [r, g, b].map(|c| (c / weight.max(1e-9)) as f32);
    let colours: Vec<[f32; 3]> = sums.iter().map(colour).collect();
    let found = indirection(model, header, 2, &()).unwrap();
    let [zeniths, azimuths, size] = [header.zenith_samples, header.azimuth_samples, header.size].map(|n| n as usize);
    let displacement = |[i, j]: [u32; 2], k: u32, a: u32| {
        let row = (j as usize * azimuths + a as usize % azimuths) * size + i as usize;
        found.displacements[row * zeniths + k as usize]
    };
    let normals = map.points.iter().map(|point| point.normal.map(|c| c as f32)).collect();
    FlatBtfParts {
        reference: ReferenceMap::new(header.size, found.reference.clone()).unwrap(),
        indirection: IndirectionMap::from_displacements(header, displacement).unwrap().into(),
        normal: NormalMap::new(texels as u32, normals).unwrap(),
        diffuse: DiffuseMap::from_colours(texels as u32, &colours).unwrap(),
        values: FlatValues::Views(flat_views),
    }
}

/// Directions of a set, radians.
fn angles(set: &DirectionSet) -> Vec<[f32; 2]> {
    set.angles.iter().map(|angles| angles.map(|degrees| degrees.to_radians() as f32)).collect()
}

fn add(sums: &mut [([f64; 3], f64)], image: &[[f32; 3]], seen: &[bool], lit: &[bool], cosine: impl Fn(usize) -> f64) {
    for (texel, (sum, weight)) in sums.iter_mut().enumerate() {
        if seen[texel] && lit[texel] {
            let cosine = cosine(texel).max(0.0);
            (0..3).for_each(|k| sum[k] += cosine * f64::from(image[texel][k]));
            *weight += cosine * cosine;
        }
    }
}

/// The same parts with all displacements scaled by `factor`. With 0 every view sees the points of the view along the
/// normal.
pub fn with_displacements(parts: &FlatBtfParts, factor: f32) -> FlatBtfParts {
    let map = parts.indirection.samples().unwrap();
    let scaled = |texel, k, a| {
        let [x, y, distance, height] = map.sample(texel, k, a);
        ([x, y].map(|c| factor * distance * c), height)
    };
    FlatBtfParts {
        indirection: IndirectionMap::from_displacements(*map.header(), scaled).unwrap().into(),
        ..parts.clone()
    }
}
