//! Factored flat BTFs without components: a base alone, and known materials.

use crate::factored::close;
use brdfc_formats::container::Extent;
use brdfc_formats::flat_btf::factored::{BaseMaterial, BaseTexel, BasisMap, FactoredHeader, LevelTable, TablePlace};
use brdfc_formats::flat_btf::{BlendedDirection, FlatBtfParts, SampledDirections};
use brdfc_testing::codecs::flat_btf::{
    BASE, Factors, MATERIALS, SMALL, base_table, factored, flat_relief, nothing, only, towards, two_materials,
};
use brdfc_testing::packs::Numbers;

/// Without components the base alone is the value; samples are not read.
#[test]
fn a_base_alone() {
    let asset = factored(SMALL, BASE, 5);
    assert_eq!((asset.header().tables_extent(), asset.lowest_light()), (Extent::D3([8, 48, 1]), 0.0));
    assert!(asset.basis().words().is_empty());
    assert_eq!(SampledDirections::of(&FlatBtfParts::new(flat_relief(SMALL), asset.clone())), Ok(None));
    let mut numbers = Numbers::new(3);
    for k in 0..100 {
        let (view, light) = (towards(nothing(k)), towards(nothing(k / 5)));
        let uv = [0; 2].map(|_| numbers.between(-2.0, 2.0) as f32);
        let detail = numbers.between(-0.5, 3.0) as f32;
        let texel = asset.filtered(uv, detail);
        let expected = base_table().colour(texel.base(), view.direction, light.direction);
        assert!(expected[0] > 0.0 || light.direction[2] < 0.9, "{light:?}");
        assert_eq!(texel.blended(view, light), expected);
        let sampled = |direction: BlendedDirection| BlendedDirection { samples: only(77), ..direction };
        assert_eq!(texel.blended(sampled(view), sampled(light)), expected);
    }
    let header = asset.header().clone();
    let refusal = |change: &dyn Fn(&mut FactoredHeader)| {
        let mut header = header.clone();
        change(&mut header);
        header.check().unwrap_err().to_string()
    };
    let directions = "brdfc.flat-btf.factored directions: found";
    let allowed = "expected no views and lights, because there are no groups";
    for (views, lights) in [(1, 0), (0, 2), (3, 5)] {
        let found = refusal(&|header| {
            header.views = vec![[0.0; 2]; views];
            header.lights = vec![[0.0; 2]; lights];
        });
        assert_eq!(found, format!("{directions} {views} views and {lights} lights, {allowed}"));
    }
    let residual = refusal(&|header| header.residual = 1);
    assert_eq!(residual, "brdfc.flat-btf.factored cells of the residual: found 1, expected 0 to 0");
    assert!(refusal(&|header| header.wide_groups = 1).starts_with("brdfc.flat-btf.factored wide groups: found 1"));
    assert!(refusal(&|header| header.groups = 1).starts_with("brdfc.views: found 0 directions, expected 1 to 2048"));
}

/// A value is a tint times the materials, blended by their shares.
#[test]
fn materials_are_blended_and_tinted() {
    let materials = two_materials();
    let asset = factored(SMALL, MATERIALS, 5);
    assert_eq!((asset.basis().materials(), asset.header().axes), (&materials[..], 0b10));
    assert_eq!(asset.header().tables_extent(), Extent::D3([8, 96, 2]));
    let one = factored(SMALL, Factors { materials: 1, ..BASE }, 5);
    assert_eq!((one.basis().materials(), one.header().axes), (&materials[..1], 0));
    let (mut lit, mut far) = (0, 0);
    for k in 0..100 {
        let (view, light) = (towards(nothing(k)), towards(nothing(k / 5)));
        let (uv, detail) = ([0.13 * k as f32, -0.29 * k as f32], 0.05 * k as f32);
        let texel = asset.filtered(uv, detail);
        let base = *texel.base();
        let BaseTexel { diffuse: tint, gloss: share, .. } = base;
        // Tables follow the level of detail up to their last.
        assert!((base.tables.level as f32 + base.tables.blend - detail.clamp(0.0, 1.0)).abs() < 1e-5);
        let at = |level: usize| {
            let base = BaseTexel { tables: TablePlace { level, blend: 0.0 }, ..base };
            materials.each_ref().map(|it| it.value(&base, view.direction, light.direction))
        };
        let share_of_far = base.tables.level as f32 + base.tables.blend;
        let [close_up, from_afar] = [at(0), at(1)];
        let mixed =
            |k: usize| [0, 1, 2].map(|c: usize| close_up[k][c] + share_of_far * (from_afar[k][c] - close_up[k][c]));
        let [first, second] = [mixed(0), mixed(1)];
        far += usize::from(share_of_far > 0.1 && from_afar[0][0] < 0.95 * close_up[0][0]);
        let blended = [0, 1, 2].map(|c: usize| tint[c] * ((1.0 - share) * first[c] + share * second[c]));
        close(texel.blended(view, light), blended, 1e-5);
        close(one.filtered(uv, detail).blended(view, light), [0, 1, 2].map(|c: usize| tint[c] * first[c]), 1e-5);
        lit += usize::from(blended[0] > 0.1 && (first[0] - second[0]).abs() > 0.1);
    }
    assert!(lit > 20 && far > 20, "{lit} {far}");
    let header = asset.header().clone();
    let refusal = |header: &FactoredHeader| header.check().unwrap_err().to_string();
    let grouped = FactoredHeader { groups: 1, ..header.clone() };
    assert_eq!(
        refusal(&grouped),
        "brdfc.flat-btf.factored groups: found 1, expected no groups, because there are materials"
    );
    let axes = FactoredHeader { axes: 4, ..header.clone() };
    assert_eq!(refusal(&axes), "brdfc.flat-btf.factored axes: found 4, expected 0 to 3");
    assert!(BasisMap::of_materials(header.clone(), &[materials[0].clone(), materials[0].clone()]).is_ok());
    let three = [0, 1, 0].map(|k: usize| materials[k].clone());
    assert!(BasisMap::of_materials(header.clone(), &three).is_err());
    let bright = BaseMaterial { diffuse: [0.0, f32::NAN, 0.0], ..materials[1].clone() };
    let bright = BasisMap::of_materials(header.clone(), &[materials[0].clone(), bright]).unwrap_err().to_string();
    let expected =
        "brdfc.flat-btf.factored albedo of material 1: found [0.0, NaN, 0.0], expected numbers of 0 to 65536";
    assert_eq!(bright, expected);
    let changed = |change: &dyn Fn(&mut Vec<LevelTable>)| {
        let mut others = materials.clone();
        change(&mut others[1].tables);
        BasisMap::of_materials(header.clone(), &others).unwrap_err().to_string()
    };
    for (found, error) in [
        (1, changed(&|tables| drop(tables.pop()))),
        (3, changed(&|tables| tables.push(tables[0].clone()))),
        (0, changed(&|tables| tables.clear())),
        (2, changed(&|tables| tables[1] = materials[0].tables[1].clone())),
    ] {
        assert_eq!(error, format!("tables of material 1: found {found}, expected 2 over one axis"));
    }
    let table = &materials[0].tables[0].gloss;
    for (factors, found) in [(vec![1.0; 383], "383"), (vec![-1.0; 384], "-1"), (vec![f32::NAN; 384], "NaN")] {
        let refused = LevelTable::new(table.clone(), factors).unwrap_err().to_string();
        assert!(refused.starts_with(&format!("diffuse factors of a material: found {found}, expected ")), "{refused}");
    }
}
