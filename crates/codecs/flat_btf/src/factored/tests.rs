//! Assets with known factors are recovered; assets without factors are not.

use super::{Factored, FactoredRecipe, FactoredTarget, FactoredTrial, factor};
use brdfc_formats::FormatError;
use brdfc_formats::container::rgb9e5;
use brdfc_formats::flat_btf::factored::{
    BaseTable, BaseTexel, DIFFERENCE_ANGLES, HALF_ANGLES, TablePlace, from_opponent,
};
use brdfc_formats::flat_btf::{FlatHeader, FlatView, VisibilityMask, unit_vectors};

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

fn made(target: FactoredTarget, mask: &VisibilityMask, views: &[FlatView]) -> Factored {
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    factor(&FactoredRecipe::new(target), &flat(mask.size()), mask, view, &()).unwrap()
}

/// One of two colours of light and view, blended by texel, under shadows of texel and light. No texel is dark under all
/// lights.
fn product(texel: u32, view: u32, light: u32, shadow: impl Fn(u32, u32) -> f32) -> [f32; 3] {
    let component = |k: u32| {
        let at = 100 * view + light;
        [30.0 + 40.0 * noise(at, k), 10.0 * noise(at, k + 10) - 5.0, 10.0 * noise(at, k + 20) - 5.0]
    };
    let (a, b) = (component(1), component(2));
    let [wa, wb] = [0.4 + 0.5 * noise(texel, 1), 0.5 * noise(texel, 2)];
    let sum = [0, 1, 2].map(|c| wa * a[c] + wb * b[c]);
    from_opponent(sum).map(|c| c * shadow(texel, light))
}

/// Half of the shadows are hard, the other half soft.
fn shadow(texel: u32, light: u32) -> f32 {
    let number = noise(texel + 7000, light);
    if light == texel % LIGHTS {
        1.0
    } else if texel.is_multiple_of(2) {
        f32::from(u8::from(number > 0.4))
    } else {
        (1.3 * number - 0.3).clamp(0.0, 1.0)
    }
}

const EIGHT: FactoredTarget = FactoredTarget::Components { components: 8, shadowed: true };

#[test]
fn products_are_recovered() {
    let seen = mask(|_, _| true);
    let made = made(EIGHT, &seen, &views(|t, v, l| product(t, v, l, shadow)));
    let errors = made.facts.errors;
    assert!(errors.texels > 40 && errors.seen_mean < 0.6 && errors.seen_mean == errors.all_mean, "{errors:?}");
    // With exactly as many components as needed, shadows are recovered, too: only they can explain the absence of
    // light.
    let four = FactoredTarget::Components { components: 4, shadowed: true };
    let made = self::made(four, &seen, &views(|t, v, l| product(t, v, l, shadow)));
    assert!(made.facts.errors.seen_mean < 0.6, "{:?}", made.facts.errors);
    let map = made.asset.shadow().unwrap();
    let [mut dark, mut lit] = [Vec::new(), Vec::new()];
    for light in 0..LIGHTS {
        for texel in 0..SIZE * SIZE {
            let found = f32::from(map.layer(0, light)[texel as usize]) / 255.0;
            if shadow(texel, light) == 0.0 { dark.push(found) } else { lit.push(found / shadow(texel, light)) }
        }
    }
    let mean = |values: &[f32]| values.iter().sum::<f32>() / values.len() as f32;
    assert!(mean(&dark) < 0.01 && mean(&lit) > 0.5, "{} {}", mean(&dark), mean(&lit));
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
    let four = FactoredTarget::Components { components: 4, shadowed: false };
    let (seen, views) = (mask(|_, _| true), views(glossy));
    let errors = |normals: &[[f32; 3]]| {
        let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
        factor(&FactoredRecipe::new(four), normals, &seen, view, &()).unwrap().facts.errors
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
        product(t, v, light, shadow)
    };
    let errors = made(EIGHT, &mask(|_, _| true), &views(shuffled)).facts.errors;
    assert!(errors.seen_mean > 8.0, "{errors:?}");
}

/// A flat matte surface of one colour: one component, without shadows, and no error.
#[test]
fn a_flat_surface_needs_nothing() {
    let lambert = |_: u32, _: u32, l: u32| [0.8, 0.4, 0.2].map(|c: f32| c * (1.2 * l as f32 / LIGHTS as f32).cos());
    let seen = mask(|_, _| true);
    let made = made(FactoredTarget::Error(0.5), &seen, &views(lambert));
    assert!(made.facts.errors.seen_max < 0.5, "{:?}", made.facts.errors);
    assert_eq!((made.facts.components, made.facts.shadowed, made.facts.tried.len()), (4, false, 1));
    let asset = self::made(EIGHT, &seen, &views(lambert)).asset;
    assert!(asset.shadow().unwrap().texels().iter().all(|byte| *byte >= 253), "nothing is in shadow");
}

/// Filled values of unseen texels hardly matter: garbage there does not affect seen ones.
#[test]
fn unseen_texels_do_not_disturb() {
    let is_seen = |t: u32, v: u32| noise(t, v + 50) > 0.3;
    let garbage = |t: u32, v: u32, l: u32| {
        if is_seen(t, v) { product(t, v, l, shadow) } else { [0, 1, 2].map(|c| 0.3 * noise(t + 1000 * v, 3 * l + c)) }
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
    let (seen, views) = (mask(|_, _| true), views(|t, v, l| product(t, v, l, shadow)));
    let chosen = made(FactoredTarget::Error(0.5), &seen, &views);
    assert!(chosen.facts.errors.seen_mean <= 0.5, "{:?}", chosen.facts);
    let met = chosen.facts.tried.iter().filter(|trial| trial.errors.seen_mean <= 0.95 * 0.5);
    assert_eq!(met.map(|trial| trial.gpu_bytes).min(), Some(chosen.facts.gpu_bytes));
    // No candidate meets this target; the best trial is selected.
    let best = made(FactoredTarget::Error(0.0), &seen, &views);
    assert!(best.facts.errors.seen_mean > 0.0 && best.facts.tried.len() == 14, "{:?}", best.facts);
    let least = best.facts.tried.iter().map(|trial| trial.errors.seen_mean).fold(f32::MAX, f32::min);
    let own = best
        .facts
        .tried
        .iter()
        .find(|trial| (trial.components, trial.shadowed) == (best.facts.components, best.facts.shadowed));
    assert!(0.98 * own.unwrap().errors.seen_mean <= least, "{:?}", best.facts);
    // A target in bytes.
    let small = made(FactoredTarget::Bytes(chosen.asset.gpu_bytes()), &seen, &views);
    assert!(small.facts.gpu_bytes <= chosen.asset.gpu_bytes());
    // All shapes that fit are tried, not only the largest.
    let many = made(FactoredTarget::Bytes(u64::MAX), &seen, &views);
    let errors = |tried: &[FactoredTrial]| tried.iter().map(|trial| trial.errors.seen_mean).fold(f32::MAX, f32::min);
    assert_eq!(many.facts.tried.len(), 14);
    assert_eq!(errors(&many.facts.tried), least);
    assert_eq!((many.facts.components, many.facts.shadowed), (best.facts.components, best.facts.shadowed));
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let refused = factor(&FactoredRecipe::new(FactoredTarget::Bytes(100)), &flat(SIZE), &seen, view, &())
        .unwrap_err()
        .to_string();
    assert!(refused.starts_with("bytes of factors: found 100, expected "), "{refused}");
    let none = FactoredTarget::Components { components: 0, shadowed: true };
    let refused = factor(&FactoredRecipe::new(none), &flat(SIZE), &seen, view, &()).unwrap_err().to_string();
    assert_eq!(refused, "components: found 0, expected 1 to 64");
}

/// Slabs only change rounding; the number of threads changes nothing.
#[test]
fn threads_and_slabs() {
    let (seen, views) = (mask(|t, v| noise(t, v) > 0.2), views(|t, v, l| product(t, v, l, shadow)));
    let view = |view: u32| Ok::<_, FormatError>(views[view as usize].clone());
    let recipe = FactoredRecipe::new(EIGHT);
    let run = |threads: usize, recipe: FactoredRecipe| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| factor(&recipe, &flat(SIZE), &seen, view, &()).unwrap())
    };
    let one = run(1, recipe);
    for threads in [2, 5] {
        let other = run(threads, recipe);
        assert!(one == other, "{threads} threads");
    }
    let slabs = run(2, FactoredRecipe { slab_bytes: 100 * 4 * LIGHTS as usize * 9, ..recipe });
    let (a, b) = (one.facts.errors, slabs.facts.errors);
    assert!((a.seen_mean - b.seen_mean).abs() < 0.01 * a.seen_mean, "{a:?} {b:?}");
    assert_eq!(one.asset.basis().words(), slabs.asset.basis().words());
}

#[test]
fn views_of_other_assets_are_refused() {
    let views = views(|_, _, _| [0.5; 3]);
    let seen = mask(|_, _| true);
    let refusal = |view: &(dyn Fn(u32) -> Result<FlatView, FormatError> + Sync)| {
        factor(&FactoredRecipe::new(EIGHT), &flat(SIZE), &seen, view, &()).unwrap_err().to_string()
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
