//! Simulated scans with noise: the strength that left-out rows choose, compared with the truth and with fixed numbers of
//! neighbours.

use brdfc_core::Smooth;
use brdfc_core::Source;
use brdfc_formats::crop::DirectionRange;
use brdfc_metrics::rendering::ReferenceRendering;
use brdfc_readers::scan::Scan;
use brdfc_source::simulate::{ScanPlan, scan};
use brdfc_source::{Reading, ScanSource};

const PLAN: ScanPlan =
    ScanPlan { rows: 4000, incidences: 8, azimuths: None, noise: 0.0, gaps: 0.0, duplicates: 0.0, seed: 3 };

fn truth(model: &str) -> Box<dyn Source> {
    brdfc_source::open::open(model, None).unwrap().source
}

fn completed(model: &str, plan: &ScanPlan, neighbours: Option<usize>) -> ScanSource {
    let rows = scan(truth(model).as_ref(), plan);
    ScanSource::read(&Scan { rows, ..Scan::default() }, Reading { neighbours, ..Reading::default() }).unwrap()
}

fn delta_e(model: &str, source: &ScanSource) -> f64 {
    ReferenceRendering::new(truth(model).as_ref(), DirectionRange::ALL).0.compare(source).delta_e.mean
}

/// Matte and glossy models; the strength was tuned on seed 1 of `lambert`, `ward` and `ggx` with alpha 0.05, 0.15 and 0.5.
#[test]
fn noisy_scans_are_near_the_truth() {
    for model in ["synth:ggx?alpha=0.15", "synth:lambert", "synth:lewis", "synth:ggx?alpha=0.05&kd=0.3,0.1,0.05"] {
        for (noise, allowed) in [(0.1, 0.5), (0.3, 1.0)] {
            let plan = ScanPlan { noise, ..PLAN };
            let chosen = completed(model, &plan, None);
            let found = delta_e(model, &chosen);
            // The default of scans without noise is the control.
            let few = delta_e(model, &completed(model, &plan, Some(14)));
            let estimate = chosen.summary().noise;
            println!(
                "{model}, noise {noise}: ΔE {found:.3}, with 14 neighbours {few:.3}, estimated noise {estimate:.3}"
            );
            assert!(found <= allowed && few > 2.0 * allowed, "{model} {noise}: {found} {few}");
            assert!((estimate / noise - 1.0).abs() < 0.1, "{model} {noise}: {estimate}");
        }
    }
}

/// Several azimuths of incidence: a fit over four dimensions.
#[test]
fn noisy_anisotropic_scans_improve() {
    let model = "synth:ward?ax=0.15&ay=0.5";
    for (noise, allowed) in [(0.1, 0.9), (0.3, 1.7)] {
        let plan = ScanPlan { noise, ..PLAN };
        let [found, few] = [None, Some(20)].map(|count| delta_e(model, &completed(model, &plan, count)));
        println!("{model}, noise {noise}: ΔE {found:.3}, with 20 neighbours {few:.3}");
        assert!(found <= allowed && few > 1.5 * found, "{noise}: {found} {few}");
    }
}

#[test]
fn scans_without_noise_keep_their_values() {
    for model in ["synth:ggx?alpha=0.15", "synth:lambert", "synth:ward?ax=0.15&ay=0.5"] {
        let (chosen, default) = (completed(model, &PLAN, None), if model.contains("ward") { 20 } else { 14 });
        assert_eq!(chosen.summary().neighbours, [default; 2], "{model}");
        let [found, many] = [None, Some(250)].map(|count| delta_e(model, &completed(model, &PLAN, count)));
        assert!(found < 0.25 && (found < many || model.contains("lambert")), "{model}: {found} {many}");
    }
}

/// `false` keeps the rows of noisy scans, and `true` also smooths scans with little noise.
#[test]
fn scans_are_smoothed_on_request() {
    let model = "synth:lambert";
    let found = |noise: f64, smooth| {
        let rows = scan(truth(model).as_ref(), &ScanPlan { noise, ..PLAN });
        let reading = Reading { smooth, ..Reading::default() };
        let source = ScanSource::read(&Scan { rows, ..Scan::default() }, reading).unwrap();
        (source.summary().neighbours != [14; 2], delta_e(model, &source))
    };
    let [kept, smoothed] = [false, true].map(|is_smooth| found(0.03, Some(Smooth::Chosen(is_smooth))));
    assert!(!kept.0 && smoothed.0 && smoothed.1 < 0.5 * kept.1, "{kept:?} {smoothed:?}");
    assert_eq!(found(0.03, None), kept);
    let rough = found(0.3, Some(Smooth::Chosen(false)));
    assert!(!rough.0 && found(0.3, None).1 < 0.5 * rough.1, "{rough:?}");
}

#[test]
fn numbers_of_neighbours_are_checked() {
    let rows = scan(truth("synth:lambert").as_ref(), &ScanPlan { rows: 40, ..PLAN });
    let scan = Scan { rows, ..Scan::default() };
    let read = |neighbours, smooth| ScanSource::read(&scan, Reading { neighbours, smooth, ..Reading::default() });
    for count in [0, 41] {
        let error = read(Some(count), None).unwrap_err().to_string();
        assert!(error.contains(&format!("found {count}")) && error.contains("expected 1 to 40"), "{error}");
    }
    for count in [1, 14, 40] {
        assert_eq!(read(Some(count), None).unwrap().summary().neighbours, [count; 2]);
    }
    let error = read(None, Some(Smooth::Radius(3))).unwrap_err().to_string();
    assert!(error.contains("found 3") && error.contains("expected true or false for a scan"), "{error}");
}
