//! Default materials, shapes, environments and sizes of the comparison.

use brdfc_environment::training::{KINDS, TrainingEnvironment};
use brdfc_render::scene::{Environment, HeightMap, Scene, Surface};
use brdfc_render::scenes::Builtin;
use std::f64::consts::TAU;

/// Names and addresses of the default materials, from sharp to matte.
pub const MATERIALS: [(&str, &str); 5] = [
    ("chrome", "synth:ggx?kd=0&f0=0.55,0.56,0.55&alpha=0.04"),
    ("glossy metal", "synth:ggx?kd=0.05,0.04,0.03&f0=0.9,0.8,0.6&alpha=0.1"),
    ("red plastic", "synth:ggx?kd=0.45,0.04,0.03&f0=0.045&alpha=0.07"),
    ("blue paint", "synth:ggx?kd=0.05,0.12,0.35&f0=0.045&alpha=0.3"),
    ("matte", "synth:lambert?kd=0.6,0.55,0.45"),
];

/// Sizes of renderings, pixels per side.
pub const SIZES: [usize; 3] = [192, 384, 768];

/// Seeds of the two random environments, a studio and a room. Lobes are neither fitted to them nor measured with them.
const SEEDS: [(&str, u64); 2] = [("studio", 202), ("room", 203)];
/// Pixels per row of a random environment.
const ENVIRONMENT_WIDTH: usize = 512;
/// Bumps of the bump-mapped ball along u, and along v.
const BUMPS: [f64; 2] = [24.0, 12.0];
/// Texels per side of its bump map.
const BUMP_TEXELS: usize = 512;

/// Names and scenes of the default shapes: smooth, two halves with geometric detail, and a ball with a bump map.
pub fn shapes() -> Vec<(String, Scene)> {
    let builtin = [Builtin::Sphere, Builtin::BumpyBall, Builtin::RibbedTorus];
    let named = builtin.iter().map(|shape| (shape.name().to_owned(), shape.scene()));
    named.chain([("bump-map".to_owned(), bump_mapped_ball())]).collect()
}

/// A smooth ball with the bumps of a texture.
fn bump_mapped_ball() -> Scene {
    let mut scene = Builtin::Sphere.scene();
    let height = |at: usize| {
        let [u, v] = [at % BUMP_TEXELS, at / BUMP_TEXELS].map(|k| (k as f64 + 0.5) / BUMP_TEXELS as f64);
        // The slope of the surface is the height's derivative by uv: up to 0.3.
        0.002 * (TAU * BUMPS[0] * u).sin() as f32 * (TAU * BUMPS[1] * v).sin() as f32
    };
    let bump = HeightMap { size: BUMP_TEXELS, heights: (0..BUMP_TEXELS * BUMP_TEXELS).map(height).collect() };
    scene.parts[0].surface = Surface { bump: Some(bump), ..Surface::default() };
    scene
}

/// Names and images of the default environments: the sky of the scenes, and the random ones.
pub fn environments() -> Vec<(String, Environment)> {
    let sky = ("sky".to_owned(), Builtin::Sphere.scene().environment);
    std::iter::once(sky).chain(SEEDS.iter().map(|(name, seed)| ((*name).to_owned(), random(*seed)))).collect()
}

/// Names and images of the environments that models are fitted in: the random ones that lobes are fitted to.
pub fn training_environments() -> Vec<(String, Environment)> {
    (0..KINDS).map(|seed| (format!("training {seed}"), random(seed))).collect()
}

fn random(seed: u64) -> Environment {
    let light = TrainingEnvironment::new(seed);
    Environment::of(ENVIRONMENT_WIDTH, ENVIRONMENT_WIDTH / 2, |d| light.radiance(d).map(|c| c as f32))
}

/// The first `most` combinations of numbers of material, shape and environment, in an order in which the first ones have
/// each number about equally often: along the diagonal of all three axes, from the next diagonal on once it closes.
pub fn combinations([materials, shapes, environments]: [usize; 3], most: usize) -> Vec<[usize; 3]> {
    let pairs = materials * shapes;
    let combination = |k: usize| {
        let pair = k % pairs;
        let shape = (pair + pair / least_common_multiple(materials, shapes)) % shapes;
        let environment = (k + k / least_common_multiple(pairs, environments)) % environments;
        [pair % materials, shape, environment]
    };
    (0..most.min(pairs * environments)).map(combination).collect()
}

fn least_common_multiple(a: usize, b: usize) -> usize {
    (a..=a * b).step_by(a).find(|multiple| multiple.is_multiple_of(b)).unwrap_or(a * b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_combinations_have_everything_and_all_are_different() {
        for counts in [[5, 4, 3], [2, 4, 3], [1, 4, 1], [6, 4, 3], [3, 3, 3]] {
            let all = counts.iter().product();
            let mut found = combinations(counts, usize::MAX);
            for (axis, count) in counts.into_iter().enumerate() {
                let first = &found[..count.max(2).min(all)];
                assert!((0..count).all(|k| first.iter().any(|case| case[axis] == k)), "{counts:?} {axis}");
            }
            found.sort();
            found.dedup();
            assert_eq!(found.len(), all, "{counts:?}");
        }
    }

    #[test]
    fn the_bump_map_turns_normals_as_much_as_the_bumps_of_geometry() {
        let scene = bump_mapped_ball();
        let bump = scene.parts[0].surface.bump.as_ref().unwrap();
        let steepest =
            (0..1000).map(|k| bump.gradient([0.0173 * k as f64, 0.0071 * k as f64])[0].abs()).fold(0.0, f64::max);
        assert!((0.2..0.5).contains(&steepest.atan()), "{steepest}");
    }
}
