//! Held-out rows of real gonioreflectometer scans test moving least squares.

use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, dot};
use brdfc_readers::alta::AltaTable;
use brdfc_readers::scan::{Row, Scan};
use brdfc_source::ScanSource;
use brdfc_source::open::{Facts, open_file};
use brdfc_source::scan::ScanFacts;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

const SEEDS: u64 = 10;

/// A scan with its spectra replaced by their mean.
fn flat_scan(bytes: &[u8]) -> Vec<Row> {
    let text = std::str::from_utf8(bytes).unwrap();
    let numbers: Vec<f64> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_ascii_whitespace)
        .map(|token| token.parse().unwrap())
        .collect();
    let count = numbers[0] as usize;
    numbers[1 + count..]
        .chunks_exact(4 + count)
        .map(|n| {
            let mean = n[4..].iter().sum::<f64>() / count as f64;
            Row { theta_i: n[0], phi_i: n[1], theta_o: n[2], phi_o: n[3], value: [mean; 3] }
        })
        .collect()
}

fn pair(row: &Row) -> DirectionPair {
    DirectionPair::from_angles(row.theta_i, row.phi_i, row.theta_o, row.phi_o)
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Median relative error at left-out rows, per seed, of an estimator based on the other rows.
fn held_out(rows: &[Row], estimate: impl Fn(&[Row], &[DirectionPair]) -> Vec<f64>) -> Vec<f64> {
    (0..SEEDS)
        .map(|seed| {
            let mut shuffled = rows.to_vec();
            shuffled.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
            let (left_out, rest) = shuffled.split_at(rows.len() / 10);
            let pairs: Vec<_> = left_out.iter().map(pair).collect();
            let found = estimate(rest, &pairs);
            let floor = 0.01 * median(&mut rows.iter().map(|r| r.value[0]).collect::<Vec<_>>());
            let mut errors: Vec<f64> = left_out
                .iter()
                .zip(found)
                .filter(|(row, _)| row.value[0] > floor)
                .map(|(row, f)| (f - row.value[0]).abs() / row.value[0])
                .collect();
            median(&mut errors)
        })
        .collect()
}

fn moving_least_squares(rest: &[Row], pairs: &[DirectionPair]) -> Vec<f64> {
    let source = ScanSource::new(&Scan { rows: rest.to_vec(), ..Scan::default() }).unwrap();
    assert!(source.summary().isotropic);
    let mut tally = Tally::default();
    pairs.iter().map(|pair| source.eval(*pair, &mut tally)[0]).collect()
}

fn nearest_neighbour(rest: &[Row], pairs: &[DirectionPair]) -> Vec<f64> {
    let points: Vec<_> = rest.iter().map(pair).collect();
    pairs
        .iter()
        .map(|asked| {
            let near = |p: &DirectionPair| dot(p.incoming, asked.incoming) + dot(p.outgoing, asked.outgoing);
            let best = (0..rest.len()).max_by(|a, b| near(&points[*a]).total_cmp(&near(&points[*b]))).unwrap();
            rest[best].value[0]
        })
        .collect()
}

#[test]
fn left_out_rows_are_predicted() {
    for (name, allowed) in [("acryl_blue", 0.06), ("krylon_blue", 0.03), ("mystique", 0.12)] {
        let Some(path) = brdfc_testing::shared_data(&format!("gonio/{name}.brdf")) else { return };
        let rows = flat_scan(&std::fs::read(path).unwrap());
        let per_seed = held_out(&rows, moving_least_squares);
        let mean = per_seed.iter().sum::<f64>() / SEEDS as f64;
        let nearest = held_out(&rows, nearest_neighbour).iter().sum::<f64>() / SEEDS as f64;
        let list: Vec<String> = per_seed.iter().map(|e| format!("{:.2}", 100.0 * e)).collect();
        println!(
            "{name}: median relative error {:.2} % (mean of {SEEDS} seeds: {}), nearest neighbour {:.2} %",
            100.0 * mean,
            list.join(" "),
            100.0 * nearest
        );
        assert!(mean <= allowed, "{name}: {mean}");
        assert!(nearest > mean, "the check separates a bad estimator from a good one: {nearest}");
    }
}

/// Retro-reflective tape: left-out rows are predicted, and the peak is at the light.
#[test]
fn retro_reflective_tape_is_bright_towards_the_light() {
    let Some(path) = brdfc_testing::shared_data("retro/retro-3M-jaune.dat") else { return };
    let opened = open_file(&path, None).unwrap();
    let Facts::Scan(ScanFacts { summary, .. }) = opened.facts else { panic!("{:?}", opened.facts) };
    assert!(summary.isotropic && summary.rows > 7000 && summary.left_out.is_some(), "{summary:?}");
    let value = |theta_i: f64, theta_o: f64, phi: f64| {
        let pair = DirectionPair::from_angles(theta_i.to_radians(), 0.0, theta_o.to_radians(), phi.to_radians());
        opened.source.eval(pair, &mut Tally::default())[0]
    };
    for theta in [15.0, 30.0] {
        let (back, mirror) = (value(theta, theta - 2.0, 0.0), value(theta, theta - 2.0, 180.0));
        assert!(back > 1.5 * mirror, "{theta}: {back} {mirror}");
    }
    let table = AltaTable::from_bytes(&std::fs::read(path).unwrap()).unwrap();
    let error = held_out(&table.scan.rows, moving_least_squares).iter().sum::<f64>() / SEEDS as f64;
    println!("retro-3M-jaune: median relative error {:.2} %", 100.0 * error);
    assert!(error < 0.06, "{error}");
}
