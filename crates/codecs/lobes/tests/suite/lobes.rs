//! Known weights, energy, limits, errors, determinism.

use crate::ENVIRONMENTS;
use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Symmetry, Tally};
use brdfc_formats::direction::{DirectionPair, from_polar};
use brdfc_formats::lobes::{Anchor, LobesPack, view_position};
use brdfc_lobes::{EncodedLobes, LobesRecipe, encode};
use std::f64::consts::{FRAC_PI_2, TAU};

fn source(address: &str) -> Box<dyn Source> {
    parse_synth(address).unwrap()
}

fn encoded(address: &str, max_fetches: usize, max_delta_e: Option<f64>) -> EncodedLobes {
    encode(source(address).as_ref(), &ENVIRONMENTS, &LobesRecipe { max_fetches, max_delta_e }, &()).unwrap()
}

/// Cosines of the view angles of a pack. The encoder remains above the horizon.
fn cosines(pack: &LobesPack) -> Vec<f64> {
    let last = f64::from(pack.header().nodes - 1);
    (0..pack.header().nodes).map(|node| (1.0 - (f64::from(node) / last).powi(2)).max(0.02)).collect()
}

/// Weights with the scale, and sharpness.
fn weights(pack: &LobesPack) -> Vec<[f32; 4]> {
    let scale = pack.header().scale;
    pack.weights().iter().map(|[r, g, b, sharpness]| [scale * r, scale * g, scale * b, *sharpness]).collect()
}

/// Sum of the weights of all lobes at a node.
fn sum(pack: &LobesPack, node: usize) -> [f64; 3] {
    let nodes = pack.header().views();
    let mut sum = [0.0; 3];
    for lobe in &pack.header().lobes {
        let weight = weights(pack)[lobe.row as usize * nodes + node];
        (0..3).for_each(|k| sum[k] += f64::from(weight[k]));
    }
    sum
}

/// Reflected share of uniform light, by the midpoint rule over half vectors.
fn albedo(source: &dyn Source, cosine: f64) -> [f64; 3] {
    const STEPS: usize = 400;
    let outgoing = [(1.0 - cosine * cosine).sqrt(), 0.0, cosine];
    let mut sum = [0.0; 3];
    for ring in 0..STEPS {
        let share = (ring as f64 + 0.5) / STEPS as f64;
        let theta = share * share * FRAC_PI_2;
        let solid_angle = theta.sin() * (2.0 * share * FRAC_PI_2 / STEPS as f64) * (TAU / STEPS as f64);
        for cell in 0..STEPS {
            let half = from_polar(theta, (cell as f64 + 0.5) * TAU / STEPS as f64);
            let projection: f64 = (0..3).map(|k| half[k] * outgoing[k]).sum();
            let incoming = [0, 1, 2].map(|k| 2.0 * projection * half[k] - outgoing[k]);
            if incoming[2] > 0.0 && projection > 0.0 {
                let value = source.eval(DirectionPair::new(incoming, outgoing), &mut Tally::default());
                (0..3).for_each(|k| sum[k] += value[k] * incoming[2] * 4.0 * projection * solid_angle);
            }
        }
    }
    sum
}

#[test]
fn lambert_is_the_irradiance_times_the_albedo() {
    let found = encoded("synth:lambert?kd=0.8,0.5,0.1", 1, Some(1.0));
    let best = found.best();
    println!("{:?}", best.error);
    assert!(best.meets && best.error.mean < 0.3, "{:?}", best.error);
    let header = best.pack.header();
    assert_eq!((header.lobes.len(), header.lobes[0].anchor, header.lobes[0].tilt), (1, Anchor::Normal, [0.0; 2]));
    for (node, [r, g, b, sharpness]) in weights(&best.pack).iter().enumerate() {
        let near = [(r, 0.8), (g, 0.5), (b, 0.1)].iter().all(|(found, albedo)| (*found / albedo - 1.0).abs() < 0.01);
        assert!(near && *sharpness == 0.0, "{node}: {r} {g} {b} {sharpness}");
    }
}

/// A source times a factor.
struct Times<'a>(&'a dyn Source, f64);

impl Source for Times<'_> {
    fn eval(&self, pair: DirectionPair, tally: &mut Tally) -> [f64; 3] {
        self.0.eval(pair, tally).map(|f| self.1 * f)
    }

    fn symmetry(&self) -> Symmetry {
        self.0.symmetry()
    }
}

/// Values in other units, which half floats alone would round to a few digits or clip, have the same lobes.
#[test]
fn magnitudes_do_not_matter() {
    let source = source("synth:ggx?kd=0.2&f0=0.3&alpha=0.3");
    let recipe = LobesRecipe { max_fetches: 3, max_delta_e: None };
    let of = |factor: f64| {
        let encoded = encode(&Times(source.as_ref(), factor), &ENVIRONMENTS, &recipe, &()).unwrap();
        encoded.best().pack.clone()
    };
    let plain = of(1.0);
    for exponent in [-30, 30] {
        let factor = 2f64.powi(exponent);
        let scaled = of(factor);
        assert_eq!(scaled.weights(), plain.weights());
        assert_eq!(scaled.header().scale, plain.header().scale * factor as f32);
        assert_eq!(scaled.header().lobes, plain.header().lobes);
    }
    // The largest weight uses the range.
    let largest = plain.weights().iter().flat_map(|texel| texel[..3].to_vec()).fold(0.0, f32::max);
    assert!((0.5..=1.0).contains(&largest), "{largest}");
}

#[test]
fn black_has_no_weights() {
    for (address, max_delta_e) in [("synth:lambert?kd=0", Some(1.0)), ("synth:lambert?kd=0", None)] {
        let found = encoded(address, 4, max_delta_e);
        let best = found.best();
        assert!(best.meets && best.error.mean == 0.0, "{:?}", best.error);
        assert!(best.pack.weights().iter().all(|[r, g, b, _]| [*r, *g, *b] == [0.0; 3]), "{:?}", best.pack);
        assert_eq!(LobesPack::from_bytes(&best.pack.to_bytes(true)).unwrap(), best.pack);
    }
}

/// Lobes reflect no more of uniform light than the material, at no view angle.
#[test]
fn no_light_is_added() {
    for address in [
        "synth:lambert?kd=1",
        "synth:ggx?kd=0.3&f0=0.04&alpha=0.3",
        "synth:ggx?kd=0&f0=0.9,0.6,0.3&alpha=0.15",
        "synth:ward?ax=0.15&ay=0.4",
    ] {
        let source = source(address);
        for trial in encoded(address, 8, None).trials {
            let mut least = f64::INFINITY;
            // At azimuth 0, over the tangent.
            for (node, cosine) in cosines(&trial.pack).into_iter().enumerate() {
                let (found, albedo) = (sum(&trial.pack, node), albedo(source.as_ref(), cosine));
                // Quadratures differ by 1 % at grazing angles, and weights are half floats.
                let most = if cosine > 0.2 { 1.002 } else { 1.01 };
                let ratios = [0, 1, 2].map(|k| found[k] / albedo[k]);
                assert!(ratios.iter().all(|ratio| *ratio < most), "{address}, node {node}: {found:?} {albedo:?}");
                least = ratios.into_iter().fold(least, f64::min);
            }
            println!("{address}, {} look-ups: least share of the albedo {least:.3}", trial.pack.fetches());
        }
    }
    // The quadrature of this test.
    let white = albedo(source("synth:lambert?kd=1").as_ref(), 0.6);
    assert!((white[0] - 1.0).abs() < 2e-3, "{white:?}");
}

#[test]
fn mirrors_follow_the_mirror_direction() {
    let found = encoded("synth:ggx?kd=0&f0=0.9&alpha=0.05", 2, Some(0.01));
    let best = found.best();
    let (header, nodes) = (best.pack.header(), best.pack.header().nodes as usize);
    let of_anchor = |anchor: Anchor| -> f32 {
        let lobes = header.lobes.iter().filter(|lobe| lobe.anchor == anchor);
        lobes.map(|lobe| weights(&best.pack)[lobe.row as usize * nodes][1]).sum()
    };
    let shares = Anchor::ALL.map(of_anchor);
    println!("{shares:?} {:?}", best.error);
    assert!(shares[1] > 0.8 * shares.iter().sum::<f32>() && shares[1] > 0.5, "{shares:?}");
    // The sharpest look-up that these environments have.
    let largest = weights(&best.pack).iter().map(|texel| texel[3]).fold(0.0, f32::max);
    assert!(largest > 2.0, "{largest}");
    // Finer environments have sharper levels than the fit: a mirror asks for them, a rougher material does not.
    let sharpest = ENVIRONMENTS.training[0].header().sharpest() as f32;
    let sharpness = |alpha: f64| {
        let found = encoded(&format!("synth:ggx?kd=0&f0=0.9&alpha={alpha}"), 2, None);
        weights(&found.best().pack).iter().map(|texel| texel[3]).fold(0.0, f32::max)
    };
    assert!(sharpness(0.003) > sharpest + 1.0 && sharpness(0.3) < sharpest, "{} {}", sharpness(0.003), sharpness(0.3));
    // A matte material has no lobe in that direction.
    let lambert = encoded("synth:lambert?kd=0.9", 1, None);
    assert!(lambert.best().pack.header().lobes.iter().all(|lobe| lobe.anchor == Anchor::Normal));
}

/// Lobes of brushed metal stay with the tangent: the same view of a frame that is turned by 90 degrees looks different.
#[test]
fn anisotropic_highlights_follow_the_tangent() {
    const WARD: &str = "synth:ward?kd=0&ks=0.8&ax=0.12&ay=0.45";
    let found = encoded(WARD, 8, None);
    let pack = &found.best().pack;
    let header = pack.header();
    println!("{} look-ups: {:?}", pack.fetches(), found.best().error);
    assert!(found.best().error.mean < 1.0 && !header.is_isotropic(), "{:?}", found.best().error);
    // Highlights are stretched along the bitangent.
    let spread = |axis: usize| {
        let mirror = header.lobes.iter().filter(|lobe| lobe.anchor == Anchor::Mirror);
        mirror.map(|lobe| lobe.tilt[axis].abs()).fold(0.0, f32::max)
    };
    assert!(spread(1) > 2.0 * spread(0) && spread(1) > 0.2, "{:?}", header.lobes);
    // Above the normal there is one view: all azimuths have the same weights.
    let (nodes, azimuths) = (header.nodes as usize, header.azimuths as usize);
    for row in 0..header.rows as usize {
        let first = |azimuth: usize| weights(pack)[(row * azimuths + azimuth) * nodes];
        assert!((1..azimuths).all(|azimuth| first(azimuth) == first(0)), "row {row}");
    }
    let radiance = |pack: &LobesPack, turn: f64, axes: [[f32; 3]; 3]| {
        let outgoing = [0.6 * turn.cos(), 0.6 * turn.sin(), 0.8].map(|c| c as f32);
        pack.radiance(&ENVIRONMENTS.training[1], axes, outgoing)
    };
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let [mut difference, mut total] = [0.0; 2];
    for step in 0..40 {
        let turn = f64::from(step) * TAU / 40.0;
        let value = radiance(pack, turn, [x, y, z])[1];
        // The same view in a frame that is turned by 90 degrees.
        difference += (radiance(pack, turn - FRAC_PI_2, [y, [-1.0, 0.0, 0.0], z])[1] - value).abs();
        total += value;
    }
    assert!(difference > 0.05 * total, "{difference} {total}");
    // Lobes of an isotropic material of the same mean roughness look the same.
    let round = encoded("synth:ward?kd=0&ks=0.8&ax=0.23&ay=0.23", 8, None);
    let round = &round.best().pack;
    assert!(round.header().is_isotropic());
    let turned = |turn: f64| {
        radiance(round, turn - FRAC_PI_2, [y, [-1.0, 0.0, 0.0], z])[1] - radiance(round, turn, [x, y, z])[1]
    };
    assert!((0..40).all(|step| turned(f64::from(step) * TAU / 40.0).abs() < 1e-4 * total));
}

#[test]
fn more_look_ups_have_smaller_errors() {
    let found = encoded("synth:ggx?kd=0.2&f0=0.3&alpha=0.3", 8, None);
    let errors: Vec<f64> = found.trials.iter().map(|trial| trial.error.mean).collect();
    println!("{errors:.3?}");
    assert!(errors[errors.len() - 1] < 0.7 * errors[0], "{errors:?}");
    assert!(found.trials.windows(2).all(|pair| pair[0].pack.fetches() < pair[1].pack.fetches()));
    assert!(found.trials.iter().all(|trial| trial.meets && trial.pack.fetches() <= 8));
    assert_eq!(found.best().error.mean, errors.iter().copied().fold(f64::INFINITY, f64::min));
    // The smallest number of look-ups within a limit.
    let limit = 1.0001 * errors[2];
    let limited = encoded("synth:ggx?kd=0.2&f0=0.3&alpha=0.3", 8, Some(limit));
    assert!(limited.best().meets && limited.best().error.mean <= limit && limited.trials.len() <= 3);
    assert_eq!(limited.selected + 1, limited.trials.len());
    // A limit that no number of look-ups meets.
    let none = encoded("synth:ggx?kd=0.2&f0=0.3&alpha=0.3", 2, Some(1e-6));
    assert!(none.trials.iter().all(|trial| !trial.meets) && none.best().pack.fetches() <= 2);
}

/// Each node has the view angle at which its weights were fitted.
#[test]
fn nodes_have_their_view_angles() {
    let found = encoded("synth:ggx?kd=0.3&f0=0.04&alpha=0.3", 2, None);
    let pack = &found.best().pack;
    let last = (pack.header().nodes - 1) as f32;
    for (node, cosine) in cosines(pack).into_iter().enumerate().rev().skip(1) {
        assert!((view_position(cosine as f32) * last - node as f32).abs() < 1e-3, "{node} {cosine}");
        let outgoing = [(1.0 - cosine * cosine).sqrt() as f32, 0.0, cosine as f32];
        let stored = weights(pack)[node];
        let look = pack.lookup(outgoing, 0);
        assert!((0..3).all(|k| (look.weight[k] - stored[k]).abs() < 1e-3), "{node}: {look:?} {stored:?}");
    }
}

#[test]
fn invalid_input_is_rejected() {
    let error = |address: &str, max_fetches: usize, max_delta_e: Option<f64>| {
        let recipe = LobesRecipe { max_fetches, max_delta_e };
        encode(source(address).as_ref(), &ENVIRONMENTS, &recipe, &()).unwrap_err()
    };
    for (max_fetches, max_delta_e, expected) in [
        (0, None, "look-ups of lobes: found 0, expected 1 to 32"),
        (33, None, "look-ups of lobes: found 33, expected 1 to 32"),
        (4, Some(0.0), "maximum ΔE: found 0, expected a positive number"),
        (4, Some(f64::NAN), "maximum ΔE: found NaN, expected a positive number"),
    ] {
        assert_eq!(error("synth:ggx", max_fetches, max_delta_e).to_string(), expected);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let bytes = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let found = encoded("synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.2", 3, None);
            found.trials.iter().map(|trial| trial.pack.to_bytes(true)).collect::<Vec<_>>()
        })
    };
    assert_eq!(bytes(1), bytes(2));
}
