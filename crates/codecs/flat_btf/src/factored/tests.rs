//! Assets with known factors are recovered; assets without factors are not.

use super::{Factored, FactoredRecipe, FactoredTarget, FactoredTrial, factor};
use brdfc_formats::FormatError;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{
    BaseTable, BaseTexel, DIFFERENCE_ANGLES, HALF_ANGLES, TablePlace, from_opponent,
};
use brdfc_formats::flat_btf::{FlatHeader, FlatView, ViewWeights, VisibilityMask, unit_vectors};

const SIZE: u32 = 16;
const VIEWS: u32 = 9;
const LIGHTS: u32 = 12;

/// A pseudorandom number of 0 to 1.
fn noise(a: u32, b: u32) -> f32 {
    let mut x = a.wrapping_mul(0x9e37_79b9) ^ b.wrapping_mul(0x85eb_ca6b) ^ 0x5bd1_e995;
    for _ in 0..2 {
        x = (x ^ (x >> 15)).wrapping_mul(0x2c1b_3c6d);
    }
    (x ^ (x >> 13)) as f32 / u32::MAX as f32
}

fn directions(count: u32) -> Vec<[f32; 2]> {
    (0..count).map(|k| [1.2 * k as f32 / count as f32, 0.5 * k as f32]).collect()
}

/// The views of `colour(texel, view, light)`.
fn views(colour: impl Fn(u32, u32, u32) -> [f32; 3]) -> Vec<FlatView> {
    let one = |view: u32| {
        let header = FlatHeader { size: SIZE, view, views: directions(VIEWS), lights: directions(LIGHTS) };
        let at = |k: u32| rgb9e5::encode(colour(k % (SIZE * SIZE), view, k / (SIZE * SIZE)));
        FlatView::new(header, (0..SIZE * SIZE * LIGHTS).map(at).collect()).unwrap()
    };
    (0..VIEWS).map(one).collect()
}

fn mask(seen: impl Fn(u32, u32) -> bool) -> VisibilityMask {
    let texel = |k: u32| if seen(k % (SIZE * SIZE), k / (SIZE * SIZE)) { 255 } else { 0 };
    VisibilityMask::new(SIZE, VIEWS, (0..SIZE * SIZE * VIEWS).map(texel).collect()).unwrap()
}

/// Normals of a plane.
fn flat(size: u32) -> Vec<[f32; 3]> {
    vec![[0.0, 0.0, 1.0]; (size * size) as usize]
}

/// Factors that take rays of light into account.
fn made(target: FactoredTarget, mask: &VisibilityMask, views: &[FlatView]) -> Factored {
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let lit = lights(mask.size(), views[0].header().lights.len() as u32);
    factor(&FactoredRecipe::new(target), &flat(mask.size()), mask, Some(&lit), view, &()).unwrap()
}

/// The texels that each light reaches.
fn lights(size: u32, lights: u32) -> VisibilityMask {
    let byte = |k: u32| if reaches(k % (size * size), k / (size * size)) { 255 } else { 0 };
    VisibilityMask::new(size, lights, (0..size * size * lights).map(byte).collect()).unwrap()
}

/// No texel is dark under all lights.
fn reaches(texel: u32, light: u32) -> bool {
    light == texel % LIGHTS || noise(texel + 7000, light) > 0.4
}

/// One of two colours of light and view, blended by texel, where light arrives.
fn product(texel: u32, view: u32, light: u32) -> [f32; 3] {
    if !reaches(texel, light) {
        return [0.0; 3];
    }
    let component = |k: u32| {
        let at = 100 * view + light;
        [30.0 + 40.0 * noise(at, k), 10.0 * noise(at, k + 10) - 5.0, 10.0 * noise(at, k + 20) - 5.0]
    };
    let (a, b) = (component(1), component(2));
    let [wa, wb] = [0.4 + 0.5 * noise(texel, 1), 0.5 * noise(texel, 2)];
    let sum = [0, 1, 2].map(|c| wa * a[c] + wb * b[c]);
    from_opponent(sum)
}

const EIGHT: FactoredTarget = FactoredTarget::Components { components: 8, residual: 1 };

#[test]
fn products_are_recovered() {
    let (seen, views) = (mask(|_, _| true), views(product));
    let made = made(EIGHT, &seen, &views);
    let errors = made.facts.errors;
    assert!(errors.texels > 40 && errors.seen_mean < 0.6 && errors.seen_mean == errors.all_mean, "{errors:?}");
    // Light is direct, so that the residual has nothing to add.
    let map = made.asset.residual().unwrap();
    assert_eq!((map.size(), map.lights()), (1, LIGHTS));
    let shares = (0..LIGHTS).map(|light| map.layer(0, light));
    assert!(
        shares.clone().all(|cell| cell[1] == 0 && (150..210).contains(&cell[0])),
        "{:?}",
        shares.collect::<Vec<_>>()
    );
    // The negative control: without the rays, shadows are no product.
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let eight = FactoredTarget::Components { components: 8, residual: 0 };
    let without = factor(&FactoredRecipe::new(eight), &flat(SIZE), &seen, None, view, &()).unwrap();
    assert!(without.asset.residual().is_none() && without.facts.errors.seen_mean > 5.0, "{:?}", without.facts.errors);
}

/// Light that is reflected once reaches shadows, from one side more than from the other: cells recover it, a single one
/// only its mean.
#[test]
fn light_in_shadows_is_recovered_by_cells() {
    let share = |t: u32, l: u32| {
        (0.15 - 0.1 * (std::f32::consts::TAU * ((t % SIZE) as f32 + 0.5) / SIZE as f32).cos()) * (1.0 - 0.05 * l as f32)
    };
    let albedo = |t: u32| [0.5 + 0.3 * noise(t, 70), 0.4, 0.2];
    let cosine = |l: u32| (1.2 * l as f32 / LIGHTS as f32).cos();
    let matte = |t: u32, _: u32, l: u32| {
        let share = if reaches(t, l) { cosine(l) } else { share(t, l) };
        albedo(t).map(|c| c * share)
    };
    let (seen, views) = (mask(|_, _| true), views(matte));
    let with = |residual: u32| made(FactoredTarget::Components { components: 4, residual }, &seen, &views);
    let error = |made: &Factored| made.facts.errors.seen_mean;
    let [none, one, four] = [0, 1, 4].map(with);
    assert!(error(&none) > 8.0 && error(&one) < 0.5 * error(&none), "{} {}", error(&none), error(&one));
    assert!(error(&four) < 1.0 && error(&four) < 0.4 * error(&one), "{} {}", error(&one), error(&four));
    // What the decoder makes of it, at texels of both sides.
    for (texel, light) in [([0, 3], 2), ([8, 5], 9), ([3, 14], 0)] {
        let at = texel[1] * SIZE + texel[0];
        let of = four.asset.texel(texel);
        let only = ViewWeights { indices: [light; 3], weights: [1.0, 0.0, 0.0] };
        let found = of.shadowed(of.value(4, light), only, 0.0);
        let expected = albedo(at).map(|c| c * share(at, light));
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 0.02 + 0.1 * expected[c]), "{found:?} {expected:?}");
    }
}

/// A gloss narrower than the steps between directions, under a different normal at each texel and with different
/// albedos: the base represents it, and components have nothing to add.
#[test]
fn gloss_under_known_normals_is_the_base() {
    let normal = |t: u32| {
        let (polar, azimuth) = (0.5 * noise(t, 60), std::f32::consts::TAU * noise(t, 61));
        [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()]
    };
    let (from, to) = (unit_vectors(&directions(VIEWS)), unit_vectors(&directions(LIGHTS)));
    let lobe = |i: usize| 2.0 / (1.0 + (i as f32 / 14.0).powi(4));
    let entries = (0..HALF_ANGLES * DIFFERENCE_ANGLES).map(|at| [lobe(at / DIFFERENCE_ANGLES); 3]);
    let table = BaseTable::new(entries.collect()).unwrap();
    let glossy = |t: u32, v: u32, l: u32| {
        let diffuse = [0.3 * noise(t, 62), 0.2 + 0.1 * noise(t, 63), 0.1];
        let texel =
            BaseTexel { diffuse, gloss: 0.5 + 0.5 * noise(t, 64), normal: normal(t), tables: TablePlace::default() };
        table.colour(&texel, from[v as usize], to[l as usize])
    };
    let four = FactoredTarget::Components { components: 4, residual: 0 };
    let (seen, views) = (mask(|_, _| true), views(glossy));
    let errors = |normals: &[[f32; 3]]| {
        let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
        factor(&FactoredRecipe::new(four), normals, &seen, None, view, &()).unwrap().facts.errors
    };
    let known = errors(&(0..SIZE * SIZE).map(normal).collect::<Vec<_>>());
    assert!(known.seen_mean < 0.3, "{known:?}");
    // The negative control: normals of a plane.
    let unknown = errors(&flat(SIZE));
    assert!(unknown.seen_mean > 10.0 * known.seen_mean, "{unknown:?} {known:?}");
}

/// The negative control: with lights shuffled at every texel, the values are no product.
#[test]
fn shuffled_lights_have_no_factors() {
    let shuffled = |t: u32, v: u32, l: u32| {
        let light = (l * 5 + (97.0 * noise(t, v)) as u32) % LIGHTS;
        product(t, v, light)
    };
    let errors = made(EIGHT, &mask(|_, _| true), &views(shuffled)).facts.errors;
    assert!(errors.seen_mean > 8.0, "{errors:?}");
}

/// A flat matte surface of one colour that all lights reach: four components, one cell, and no error.
#[test]
fn a_flat_surface_needs_nothing() {
    let lambert = |_: u32, _: u32, l: u32| [0.8, 0.4, 0.2].map(|c: f32| c * (1.2 * l as f32 / LIGHTS as f32).cos());
    let (seen, views) = (mask(|_, _| true), views(lambert));
    let all = VisibilityMask::new(SIZE, LIGHTS, vec![255; (SIZE * SIZE * LIGHTS) as usize]).unwrap();
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let target = FactoredRecipe::new(FactoredTarget::Error(0.5));
    for (lit, residual) in [(Some(&all), 1), (None, 0)] {
        let made = factor(&target, &flat(SIZE), &seen, lit, view, &()).unwrap();
        assert!(made.facts.errors.seen_max < 0.5, "{:?}", made.facts.errors);
        assert_eq!((made.facts.components, made.facts.residual, made.facts.tried.len()), (4, residual, 1));
    }
}

/// Filled values of unseen texels hardly matter: garbage there does not affect seen ones.
#[test]
fn unseen_texels_do_not_disturb() {
    let is_seen = |t: u32, v: u32| noise(t, v + 50) > 0.3;
    let garbage = |t: u32, v: u32, l: u32| {
        if is_seen(t, v) { product(t, v, l) } else { [0, 1, 2].map(|c| 0.3 * noise(t + 1000 * v, 3 * l + c)) }
    };
    let errors = |seen: &VisibilityMask| made(EIGHT, seen, &views(garbage)).facts.errors;
    let masked = errors(&mask(is_seen));
    assert!(masked.seen_mean < 2.5 && masked.all_mean > 3.0 * masked.seen_mean, "{masked:?}");
    // With garbage treated as seen, the error at seen texels grows.
    let all = errors(&mask(|_, _| true));
    assert!(all.seen_mean > 2.0 * masked.seen_mean, "{all:?} {masked:?}");
}

#[test]
fn fewest_bytes_that_meet_an_error() {
    let (seen, views) = (mask(|_, _| true), views(product));
    let chosen = made(FactoredTarget::Error(0.5), &seen, &views);
    assert!(chosen.facts.errors.seen_mean <= 0.5, "{:?}", chosen.facts);
    let met = chosen.facts.tried.iter().filter(|trial| trial.errors.seen_mean <= 0.95 * 0.5);
    assert_eq!(met.map(|trial| trial.gpu_bytes).min(), Some(chosen.facts.gpu_bytes));
    // No candidate meets this target; the best trial is selected.
    let best = made(FactoredTarget::Error(0.0), &seen, &views);
    assert!(best.facts.errors.seen_mean > 0.0 && best.facts.tried.len() == 14, "{:?}", best.facts);
    let least = best.facts.tried.iter().map(|trial| trial.errors.seen_mean).fold(f32::MAX, f32::min);
    // Twice the bytes must reduce the error by a tenth.
    let mut selected = best.facts.tried[0];
    for trial in &best.facts.tried {
        let doublings = (trial.gpu_bytes as f64 / selected.gpu_bytes as f64).log2();
        let most = 0.99 * 0.9f64.powf(doublings) * f64::from(selected.errors.seen_mean);
        if f64::from(trial.errors.seen_mean) < most {
            selected = *trial;
        }
    }
    let found = (best.facts.components, best.facts.residual);
    assert_eq!(found, (selected.components, selected.residual), "{:?}", best.facts);
    // A target in bytes.
    let small = made(FactoredTarget::Bytes(chosen.asset.gpu_bytes()), &seen, &views);
    assert!(small.facts.gpu_bytes <= chosen.asset.gpu_bytes());
    // All shapes that fit are tried, not only the largest.
    let many = made(FactoredTarget::Bytes(u64::MAX), &seen, &views);
    let errors = |tried: &[FactoredTrial]| tried.iter().map(|trial| trial.errors.seen_mean).fold(f32::MAX, f32::min);
    assert_eq!((many.facts.tried.len(), errors(&many.facts.tried)), (14, least));
    let own = many.facts.tried.iter().find(|trial| trial.gpu_bytes == many.facts.gpu_bytes).unwrap();
    assert!(0.98 * own.errors.seen_mean <= least, "{:?}", many.facts);
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let refused = factor(&FactoredRecipe::new(FactoredTarget::Bytes(100)), &flat(SIZE), &seen, None, view, &())
        .unwrap_err()
        .to_string();
    assert!(refused.starts_with("bytes of factors: found 100, expected "), "{refused}");
    let none = FactoredTarget::Components { components: 0, residual: 1 };
    let refused = factor(&FactoredRecipe::new(none), &flat(SIZE), &seen, None, view, &()).unwrap_err().to_string();
    assert_eq!(refused, "components: found 0, expected 1 to 64");
    for residual in [3, 8] {
        let target = FactoredTarget::Components { components: 4, residual };
        let refused = factor(&FactoredRecipe::new(target), &flat(SIZE), &seen, None, view, &()).unwrap_err();
        let expected = format!("cells of the residual: found {residual}, expected 0 or a power of two up to 4");
        assert_eq!(refused.to_string(), expected);
    }
}

/// Slabs only change rounding; the number of threads changes nothing.
#[test]
fn threads_and_slabs() {
    let (seen, views) = (mask(|t, v| noise(t, v) > 0.2), views(product));
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let recipe = FactoredRecipe::new(EIGHT);
    let run = |threads: usize, recipe: FactoredRecipe| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let lit = lights(SIZE, LIGHTS);
        pool.install(|| factor(&recipe, &flat(SIZE), &seen, Some(&lit), view, &()).unwrap())
    };
    let one = run(1, recipe);
    for threads in [2, 5] {
        let other = run(threads, recipe);
        assert!(one == other, "{threads} threads");
    }
    let slabs = run(2, FactoredRecipe { slab_bytes: 100 * 44 * LIGHTS as usize, ..recipe });
    let (a, b) = (one.facts.errors, slabs.facts.errors);
    assert!((a.seen_mean - b.seen_mean).abs() < 0.01 * a.seen_mean, "{a:?} {b:?}");
    assert_eq!(one.asset.basis().words(), slabs.asset.basis().words());
}

#[test]
fn masks_of_other_lights_are_refused() {
    let (seen, views) = (mask(|_, _| true), views(product));
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    for (lit, found) in [(lights(SIZE, 3), "3 lights, 16 x 16"), (lights(8, LIGHTS), "12 lights, 8 x 8")] {
        let refused = factor(&FactoredRecipe::new(EIGHT), &flat(SIZE), &seen, Some(&lit), view, &()).unwrap_err();
        let expected = "12 lights, 16 x 16 texels, as the views have";
        assert_eq!(refused.to_string(), format!("mask of lights: found {found} texels, expected {expected}"));
    }
}

#[test]
fn views_of_other_assets_are_refused() {
    let views = views(|_, _, _| [0.5; 3]);
    let seen = mask(|_, _| true);
    let refusal = |view: &(dyn Fn(u32) -> Result<FlatView, FormatError> + Sync)| {
        factor(&FactoredRecipe::new(EIGHT), &flat(SIZE), &seen, None, view, &()).unwrap_err().to_string()
    };
    let swapped = refusal(&|view| Ok(views[(view ^ 1) as usize].clone()));
    assert!(swapped.starts_with("part flat: found view 1 of 9, 16 x 16 texels, expected view 0 of 9"), "{swapped}");
    let turned = refusal(&|view| {
        let mut header = views[view as usize].header().clone();
        if view == 4 {
            header.lights[1][0] += 0.1;
        }
        FlatView::new(header, views[view as usize].texels().to_vec())
    });
    assert_eq!(turned, "directions of view 4: differ from view 0; expected equal directions in all views");
    let missing = refusal(&|view| Err(FormatError::whole("file", format!("no view {view}"), "one")));
    assert_eq!(missing, "file: found no view 0, expected one");
}

/// Black assets and assets of a few texels.
#[test]
fn ends_of_the_range() {
    let seen = mask(|_, _| true);
    let black = made(EIGHT, &seen, &views(|_, _, _| [0.0; 3]));
    assert_eq!(black.facts.errors.seen_max, 0.0);
    let bright = made(EIGHT, &seen, &views(|_, _, _| [60_000.0, 50_000.0, 1e4]));
    assert!(bright.facts.errors.seen_mean < 1.0, "{:?}", bright.facts.errors);
    let header = FlatHeader { size: 1, view: 0, views: directions(1), lights: directions(1) };
    let view = FlatView::new(header, vec![rgb9e5::encode([0.5, 0.25, 0.125])]).unwrap();
    let mask = VisibilityMask::new(1, 1, vec![255]).unwrap();
    let one = made(EIGHT, &mask, &[view]);
    assert!(one.facts.errors.texels == 1 && one.facts.errors.seen_max < 1.0, "{:?}", one.facts.errors);
}
