//! ALTA tables as sources: all forms of one material give one source.

use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Tally};
use brdfc_formats::direction::{DirectionPair, Vector, cross, dot, half_vector};
use brdfc_readers::alta::AltaTable;
use brdfc_source::ScanSource;
use std::f64::consts::TAU;

/// Light and view of an isotropic material.
fn directions() -> Vec<DirectionPair> {
    let angles = (0..9).flat_map(|i| (0..9).flat_map(move |o| (0..13).map(move |p| (i, o, p))));
    let pair = |(i, o, p): (i32, i32, i32)| {
        DirectionPair::from_angles(0.05 + 0.15 * f64::from(i), 0.0, 0.04 + 0.15 * f64::from(o), 0.24 * f64::from(p))
    };
    angles.map(pair).collect()
}

fn polar_angle(v: Vector) -> f64 {
    v[0].hypot(v[1]).atan2(v[2])
}

fn azimuth(v: Vector) -> f64 {
    v[1].atan2(v[0])
}

/// Polar angles of half and difference vector, and the view's azimuth in the half vector's frame.
fn rusinkiewicz(pair: DirectionPair) -> [f64; 3] {
    let (half, view) = (half_vector(pair), pair.outgoing);
    let along = cross([-half[1], half[0], 0.0], half);
    let length = dot(along, along).sqrt();
    let across = [-half[1], half[0], 0.0];
    let at = [dot(view, along) / length, dot(view, across) / dot(across, across).sqrt()];
    [polar_angle(half), dot(view, half).min(1.0).acos(), at[1].atan2(at[0])]
}

fn table(name: &str, numbers: impl Fn(DirectionPair) -> Vec<f64>) -> ScanSource {
    let material = parse_synth("synth:ggx?alpha=0.5").expect("an address");
    let rows: Vec<String> = directions()
        .into_iter()
        .map(|pair| {
            let value = material.eval(pair, &mut Tally::default())[0];
            numbers(pair).into_iter().chain([value]).map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
        })
        .collect();
    let count = rows[0].split(' ').count() - 1;
    let text = format!("#DIM {count} 1\n#PARAM_IN {name}\n#PARAM_OUT INV_STERADIAN\n{}\n", rows.join("\n"));
    let table = AltaTable::from_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
    ScanSource::new(&table.scan).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn isotropic_forms_are_one_material() {
    let projected = |theta: f64, phi: f64| [theta * phi.cos(), theta * phi.sin()];
    let first = table("ISOTROPIC_TL_TV_PROJ_DPHI", |pair| {
        let [x, y] = projected(polar_angle(pair.outgoing), azimuth(pair.outgoing));
        vec![polar_angle(pair.incoming), x, y]
    });
    let others = [
        table("ISOTROPIC_TV_TL_DPHI", |pair| {
            vec![polar_angle(pair.outgoing), polar_angle(pair.incoming), -azimuth(pair.outgoing)]
        }),
        table("RUSIN_TH_TD_PD", |pair| rusinkiewicz(pair).to_vec()),
        table("SCHLICK_TL_TK_PROJ_DPHI", |pair| {
            let [x, y, z] = pair.incoming;
            let back = half_vector(DirectionPair::new([-x, -y, z], pair.outgoing));
            let [x, y] = projected(polar_angle(back), azimuth(back));
            vec![polar_angle(pair.incoming), x, y]
        }),
    ];
    let material = parse_synth("synth:ggx?alpha=0.5").expect("an address");
    let asked: Vec<DirectionPair> = (0..40)
        .map(|k| {
            let k = f64::from(k);
            DirectionPair::from_angles(0.1 + 0.025 * k, 0.7 * k % TAU, 1.1 - 0.02 * k, 1.3 * k % TAU)
        })
        .collect();
    let mut far = 0;
    for pair in &asked {
        let value = |source: &dyn Source| source.eval(*pair, &mut Tally::default())[0];
        let (expected, found) = (value(material.as_ref()), value(&first));
        far += usize::from((found - expected).abs() > 0.1 * expected);
        for other in &others {
            assert!(other.summary().isotropic);
            assert!((value(other) - found).abs() < 1e-6 * found, "{pair:?}: {} {found}", value(other));
        }
    }
    assert!(far <= 4, "{far} of {} are farther than a tenth from the material", asked.len());
}

/// Checks the page's claim about `INV_STERADIAN_COSINE_FACTOR`: after removing the view's cosine the data are
/// reciprocal, after removing the light's they are not.
#[test]
fn the_cosine_of_measured_tape_is_the_views() {
    let Some(path) = brdfc_testing::shared_data("retro/retro-3M-jaune.dat") else { return };
    let table = AltaTable::from_bytes(&std::fs::read(path).unwrap()).unwrap();
    let rows = &table.scan.rows;
    let turn = |row: &brdfc_readers::scan::Row| (row.phi_o - row.phi_i).cos();
    let mut logarithms = [Vec::new(), Vec::new()];
    for row in rows {
        let exchanged = rows.iter().find(|other| {
            let near = |a: f64, b: f64| (a - b).abs() < 0.01;
            near(other.theta_i, row.theta_o) && near(other.theta_o, row.theta_i) && near(turn(other), turn(row))
        });
        let Some(other) = exchanged.filter(|other| other.theta_i < row.theta_i) else { continue };
        let ratio = (row.value[0] / other.value[0]).ln();
        // The same with the light's cosine.
        let wrong = ratio + 2.0 * (row.theta_o.cos() / row.theta_i.cos()).ln();
        logarithms[0].push(ratio);
        logarithms[1].push(wrong);
    }
    let [right, wrong] = logarithms.map(|found| {
        assert!(found.len() >= 3, "{}", found.len());
        (found.iter().sum::<f64>() / found.len() as f64).abs()
    });
    println!("mean logarithm of the ratio: {right:.3} with the view's cosine, {wrong:.3} with the light's");
    assert!(right < 0.04 && wrong > 0.2, "{right} {wrong}");
}
