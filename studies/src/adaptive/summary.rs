//! Summary of the comparison: in how many cases a method is the cheapest, and by what factor it beats simpler methods.

use super::comparison::{CaseRow, TARGETS};
use super::curve::Cost;
use super::method::Method;
use schemars::JsonSchema;
use serde::Serialize;

/// A method over all cases.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct MethodSummary {
    /// The method.
    pub method: Method,
    /// One for each target.
    pub targets: Vec<TargetSummary>,
}

/// A method over all cases at one target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct TargetSummary {
    /// Number of cases that any method reaches.
    pub cases: usize,
    /// Number of cases that this method reaches.
    pub reached: usize,
    /// Number of cases in which it needs the fewest samples or fetches of all methods.
    pub fewest_samples: usize,
    /// Number of cases in which it takes the shortest time of all methods.
    pub fastest: usize,
    /// Geometric mean of the factor by which it needs fewer samples than the best other method among forward, filtered,
    /// half and quarter resolution, and both together, over cases that both reach; null without any.
    pub samples_gain: Option<f64>,
    /// The same factor for the time.
    pub seconds_gain: Option<f64>,
    /// Number of cases with an error of this method at the time of adaptive shading, see [`MethodRow::at_equal_time`].
    ///
    /// [`MethodRow::at_equal_time`]: super::MethodRow::at_equal_time
    pub within_time: usize,
    /// Mean PSNR, or geometric mean of FLIP, of those cases; null without any.
    pub at_equal_time: Option<f64>,
}

/// Summarises all methods.
pub fn summary(rows: &[CaseRow]) -> Vec<MethodSummary> {
    let of = |(method, _): &(Method, &str)| MethodSummary {
        method: *method,
        targets: (0..TARGETS.len()).map(|target| at_target(rows, *method, target)).collect(),
    };
    Method::ALL.iter().map(of).collect()
}

fn at_target(rows: &[CaseRow], method: Method, target: usize) -> TargetSummary {
    // Costs of a case, of all methods that reach the target.
    let costs = |row: &CaseRow| -> Vec<(Method, Cost)> {
        row.methods.iter().filter_map(|of| Some((of.method, of.needed[target]?))).collect()
    };
    let all: Vec<Vec<(Method, Cost)>> = rows.iter().map(costs).filter(|costs| !costs.is_empty()).collect();
    let wins = |by: fn(&Cost) -> f64| {
        let least = |costs: &&Vec<(Method, Cost)>| {
            costs.iter().min_by(|a, b| by(&a.1).total_cmp(&by(&b.1))).is_some_and(|(least, _)| *least == method)
        };
        all.iter().filter(least).count()
    };
    let gain = |by: fn(&Cost) -> f64| {
        let logarithm = |costs: &Vec<(Method, Cost)>| {
            let own = costs.iter().find(|(of, _)| *of == method)?;
            let simple = costs.iter().filter(|(of, _)| Method::SIMPLE.contains(of) && *of != method);
            let best = simple.map(|(_, cost)| by(cost)).min_by(f64::total_cmp)?;
            Some((best / by(&own.1)).ln())
        };
        let found: Vec<f64> = all.iter().filter_map(logarithm).collect();
        (!found.is_empty()).then(|| (found.iter().sum::<f64>() / found.len() as f64).exp())
    };
    let of_method = |row: &'_ CaseRow| row.methods.iter().find(|of| of.method == method)?.at_equal_time[target];
    let at_time: Vec<f64> = rows.iter().filter_map(of_method).collect();
    let mean = |errors: &[f64]| {
        let qualities = errors.iter().map(|error| TARGETS[target].quality_of(*error)).sum::<f64>();
        (!errors.is_empty()).then(|| TARGETS[target].error(qualities / errors.len() as f64))
    };
    TargetSummary {
        within_time: at_time.len(),
        at_equal_time: mean(&at_time),
        cases: all.len(),
        reached: all.iter().filter(|costs| costs.iter().any(|(of, _)| *of == method)).count(),
        fewest_samples: wins(|cost| cost.samples),
        fastest: wins(|cost| cost.seconds),
        samples_gain: gain(|cost| cost.samples),
        seconds_gain: gain(|cost| cost.seconds),
    }
}

#[cfg(test)]
mod tests {
    use super::super::comparison::MethodRow;
    use super::*;

    fn row(costs: &[(Method, Option<f64>)]) -> CaseRow {
        let methods = costs.iter().map(|(method, samples)| MethodRow {
            method: *method,
            // The time has the reversed order.
            needed: vec![samples.map(|samples| Cost { samples, seconds: 1.0 / samples }); TARGETS.len()],
            best: vec![None; TARGETS.len()],
            at_equal_time: vec![samples.map(|samples| 30.0 - samples); TARGETS.len()],
            curves: Vec::new(),
        });
        CaseRow {
            material: String::new(),
            shape: String::new(),
            environment: String::new(),
            pixels: 0,
            surface_pixels: 0,
            truth_samples: 0,
            truth_psnr: None,
            truth_flip: 0.0,
            methods: methods.collect(),
        }
    }

    #[test]
    fn gains_compare_with_the_best_simple_method() {
        use Method::{Adaptive, Filtered, Forward, Lobes};
        let rows = [
            row(&[(Forward, Some(8.0)), (Filtered, Some(4.0)), (Adaptive, Some(2.0)), (Lobes, None)]),
            row(&[(Forward, Some(9.0)), (Filtered, Some(3.0)), (Adaptive, Some(6.0)), (Lobes, Some(1.0))]),
            row(&[(Forward, None), (Filtered, None), (Adaptive, Some(5.0)), (Lobes, None)]),
            row(&[(Forward, None)]),
        ];
        let of = |method: Method| at_target(&rows, method, 0);
        let adaptive = of(Adaptive);
        assert_eq!((adaptive.cases, adaptive.reached, adaptive.fewest_samples, adaptive.fastest), (3, 3, 2, 1));
        assert!((adaptive.samples_gain.unwrap() - 1.0).abs() < 1e-12, "2 and 1/2: {adaptive:?}");
        assert!((of(Lobes).samples_gain.unwrap() - 3.0).abs() < 1e-12);
        assert_eq!((adaptive.within_time, of(Forward).within_time), (3, 2));
        assert!((of(Forward).at_equal_time.unwrap() - 21.5).abs() < 1e-12, "of 22 and 21 dB");
        // Simple methods are compared with the others: forward needs twice and three times as many as filtered.
        assert!((of(Forward).samples_gain.unwrap() - 1.0 / 6f64.sqrt()).abs() < 1e-12);
        assert_eq!(
            of(Method::Half),
            TargetSummary {
                reached: 0,
                fewest_samples: 0,
                fastest: 0,
                samples_gain: None,
                seconds_gain: None,
                within_time: 0,
                at_equal_time: None,
                ..adaptive
            }
        );
    }
}
