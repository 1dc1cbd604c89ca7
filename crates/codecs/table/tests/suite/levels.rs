//! Levels of detail: the same energy, a wider highlight.

use brdfc_core::Tally;
use brdfc_core::address::parse_synth;
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot};
use brdfc_formats::table::{Angles, TableDecoder, TablePack};
use brdfc_metrics::sampling::{points, random_pairs};
use brdfc_table::encode::encode;
use brdfc_table::levels::MAX_LEVELS;
use brdfc_table::recipe::{Size, TableRecipe};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn packed(address: &str, levels: u32) -> TablePack {
    let source = parse_synth(address).unwrap();
    let recipe = TableRecipe { size: Size::Bytes(16 << 10), levels, measure: false, ..TableRecipe::default() };
    encode(source.as_ref(), &recipe, &()).unwrap().pack
}

/// Light reflected under uniform illumination in all directions: `∫∫ f cos θi cos θo / π`, over half-difference angles,
/// denser near highlights.
fn sent_out(f: impl Fn(DirectionPair) -> f64) -> f64 {
    const COUNT: usize = 100_000;
    let of_place = |[a, b, c, d]: [f64; 4]| {
        let theta_half = a * a * FRAC_PI_2;
        let phi_difference = TAU * c;
        let largest = theta_half.cos().atan2(theta_half.sin() * phi_difference.cos().abs());
        let angles = Angles {
            theta_half: theta_half as f32,
            phi_half: (TAU * d) as f32,
            ratio: b as f32,
            phi_difference: phi_difference as f32,
        };
        let (pair, theta) = (angles.pair(), b * largest);
        if !pair.is_above_horizon() {
            return 0.0;
        }
        // dω_i dω_o = 4 cos θ_d dω_h dω_d.
        let solid_angles = 4.0 * theta.cos() * theta.sin() * largest * TAU * theta_half.sin() * PI * a * TAU;
        f(pair) * pair.incoming[2] * pair.outgoing[2] * solid_angles / PI
    };
    points(0).take(COUNT).map(of_place).sum::<f64>() / COUNT as f64
}

/// Check of the integral above: a matte white reflects all light.
#[test]
fn light_is_counted_whole() {
    assert!((sent_out(|_| 1.0 / PI) - 1.0).abs() < 1e-3);
}

/// White furnace: a matte white stays white at every level.
#[test]
fn lambert_is_flat_at_every_level() {
    let decoder = TableDecoder::new(&packed("synth:lambert?kd=1", MAX_LEVELS));
    assert_eq!(decoder.levels(), MAX_LEVELS);
    for pair in random_pairs(2000, 1) {
        for level in 0..=2 * MAX_LEVELS {
            let f = decoder.eval_at(pair, 0.5 * level as f32)[0];
            assert!((f64::from(f) * PI - 1.0).abs() < 2e-3, "level {level}: {f}");
        }
    }
}

#[test]
fn every_level_reflects_the_same_energy() {
    for address in
        ["synth:ggx?kd=0.3,0.1,0.05&f0=0.5&alpha=0.08", "synth:ggx?kd=0&f0=0.9&alpha=0.05", "synth:ward?ax=0.1&ay=0.3"]
    {
        let decoder = TableDecoder::new(&packed(address, 5));
        let energy = |level: u32| sent_out(|pair| f64::from(decoder.eval_at(pair, level as f32)[1]));
        let finest = energy(5);
        let mirror = DirectionPair::from_angles(0.3, 0.0, 0.3, PI);
        let mut before = f32::INFINITY;
        for level in (0..=5).rev() {
            let found = energy(level);
            assert!((found / finest - 1.0).abs() < 0.01, "{address}, level {level}: {found} of {finest}");
            let between = sent_out(|pair| f64::from(decoder.eval_at(pair, level as f32 - 0.5)[1]));
            assert!(level == 0 || (between / finest - 1.0).abs() < 0.01, "{address}, below {level}: {between}");
            let peak = decoder.eval_at(mirror, level as f32)[1];
            assert!(peak < before, "{address}, level {level}: {peak} after {before}");
            before = peak;
        }
        // Negative control: blurred logarithms, as in coarse levels of wavelet packs, lose light.
        let blurred = sent_out(|pair| {
            let around = |k: usize| {
                let turn = TAU * k as f64 / 8.0;
                let slopes = [0.2 * turn.cos(), 0.2 * turn.sin()];
                let moved = DirectionPair::new(tilted(pair.incoming, slopes), tilted(pair.outgoing, slopes));
                decoder.log_values(if moved.is_above_horizon() { moved } else { pair }, 5.0).fine[1]
            };
            f64::from(decoder.from_log((0..8).map(around).sum::<f32>() / 8.0))
        });
        assert!(blurred < 0.93 * finest, "{address}: {blurred} of {finest}");
    }
}

/// A direction in the frame of a facet whose normal is tilted by slopes `x` and `y`.
fn tilted(v: Vector, [x, y]: [f64; 2]) -> Vector {
    let length = (1.0 + x * x + y * y).sqrt();
    let normal = [x / length, y / length, 1.0 / length];
    let along = cross([0.0, 1.0, 0.0], normal);
    let size = dot(along, along).sqrt();
    let tangent = along.map(|c| c / size);
    [dot(v, tangent), dot(v, cross(normal, tangent)), dot(v, normal)]
}

/// A level is closer to the average of a bumpy surface than the finest level is.
#[test]
fn levels_show_bumps_that_are_too_small_to_see() {
    let address = "synth:ggx?kd=0.3,0.1,0.05&f0=0.3&alpha=0.06";
    let (source, decoder) = (parse_synth(address).unwrap(), TableDecoder::new(&packed(address, 5)));
    // Slopes with the standard deviation of level 1, the fourth below the finest.
    let deviation = 0.125;
    let slope = |[a, b, ..]: [f64; 4]| {
        let radius = deviation * (-2.0 * (1.0 - a).ln()).sqrt();
        [radius * (TAU * b).cos(), radius * (TAU * b).sin()]
    };
    let slopes: Vec<[f64; 2]> = points(0).take(256).map(slope).collect();
    let high = |pair: &DirectionPair| pair.incoming[2] > 0.4 && pair.outgoing[2] > 0.4;
    let pairs: Vec<DirectionPair> = random_pairs(2000, 9).into_iter().filter(high).collect();
    let mut errors = [0.0; 2];
    for pair in &pairs {
        let of_facet = |slope: &[f64; 2]| {
            let facet = DirectionPair::new(tilted(pair.incoming, *slope), tilted(pair.outgoing, *slope));
            source.eval(facet, &mut Tally::default())[1] * facet.incoming[2].max(0.0)
        };
        let shown = slopes.iter().map(of_facet).sum::<f64>() / slopes.len() as f64;
        for (error, level) in errors.iter_mut().zip([5.0, 1.0]) {
            let found = f64::from(decoder.eval_at(*pair, level)[1]) * pair.incoming[2];
            *error += (found / shown).ln().abs() / pairs.len() as f64;
        }
    }
    assert!(errors[1] < 0.5 * errors[0] && errors[1] < 0.2, "{errors:?}");
}
