//! Table packs: decoding, fitting and rounding, each compared with f64.

use super::fed::{Numbers, Of, constant, pairs};
use super::row::{Measure, StressRow, U, Worst};
use super::stages::{STEPS, Stages};
use brdfc_core::address::parse_synth;
use brdfc_core::{Source, Symmetry};
use brdfc_formats::direction::{DirectionPair, half_vector};
use brdfc_formats::table::{Angles, Axes, Curve, KNOTS, Position, TableDecoder, TableHeader, TablePack, TableSymmetry};
use brdfc_table::encode::Prepared;
use brdfc_table::lattice::{Equations, Lattice};
use brdfc_table::recipe::{Size, TableRecipe};
use nalgebra::{DMatrix, DVector};

/// The f32 value of π at which angles are folded.
const PI: f64 = std::f32::consts::PI as f64;
const FRAC_PI_2: f64 = std::f32::consts::FRAC_PI_2 as f64;
/// Steps of texels of ten bits.
const TEN_BITS: f64 = 1023.0;

pub fn rows(stages: &Stages, small: bool) -> Vec<StressRow> {
    let mut rows = vec![decode(stages, small)];
    rows.extend(solve(stages, small));
    rows.push(round(stages, small));
    rows
}

/// A table of random shape.
fn header(symmetry: u32, layers: u32, numbers: &mut Numbers) -> TableHeader {
    let mut knots = [0.0f32; KNOTS];
    for k in 1..KNOTS {
        knots[k] = knots[k - 1] + 0.02 + numbers.unit() as f32;
    }
    let last = knots[KNOTS - 1];
    knots.iter_mut().for_each(|knot| *knot /= last);
    TableHeader {
        channels: 1,
        symmetry: TableSymmetry::from_bits(symmetry).expect("four bits"),
        axes: Axes {
            half: 2 + numbers.below(40) as u32,
            difference: 2 + numbers.below(20) as u32,
            azimuth: 2 + numbers.below(10) as u32,
            layers,
        },
        mean: 0.3,
        bias: 1e-4,
        low: [-9.2; 3],
        span: [numbers.between(0.0, 20.0) as f32; 3],
        slope: numbers.between(-0.95, 0.95) as f32,
        knots,
    }
}

fn decode(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    let mut numbers = Numbers::new(20);
    let every = pairs(small);
    for symmetry in 0..16 {
        for (layers, curved) in [(1, false), (1, true), (5, false), (5, true)] {
            if layers == 1 && symmetry > 3 {
                continue;
            }
            let header = header(symmetry, layers, &mut numbers);
            let lattice = Lattice::new(&header);
            let values: Vec<[f32; 3]> = (0..lattice.len()).map(|_| [numbers.unit() as f32; 3]).collect();
            let curve: Vec<[f32; 3]> = (0..17).map(|_| [numbers.between(-4.0, 12.0) as f32; 3]).collect();
            let made = TablePack::new(header, &values).and_then(|pack| match curved {
                true => pack.with_curve(Curve::new(1, 0, &curve)?),
                false => Ok(pack),
            });
            let Ok(pack) = made else {
                worst.add(f64::NAN);
                continue;
            };
            let (decoder, texels) = (TableDecoder::new(&pack), pack.values());
            let exact = ExactTable { header: &header, texels: &texels, curve: pack.curve().map(Curve::values) };
            for _ in 0..if small { 200 } else { 2_000 } {
                let pair = every[numbers.below(every.len())];
                let found = (stages.decode_table)(&decoder, pair)[0];
                worst.add((f64::from(found) - exact.log_value(pair)) / exact.allowed());
            }
        }
    }
    worst.row(
        ["decoding tables, f32", "all symmetries, poles and grazing rings, with and without a curve"],
        Measure::OfBound,
        1.0,
        "8 roundings of each position times the number of nodes and the span, along columns times the slope of their warp; 16 of the sum",
    )
}

struct ExactTable<'a> {
    header: &'a TableHeader,
    texels: &'a [[f32; 3]],
    curve: Option<Vec<[f32; 3]>>,
}

impl ExactTable<'_> {
    /// Bound for roundings of positions and sums.
    fn allowed(&self) -> f64 {
        let header = self.header;
        let [half, difference, _] = header.extent().map(f64::from);
        let steepest = header.knots.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0f32, f32::max);
        let columns = half * f64::from(steepest) * (KNOTS - 1) as f64;
        let nodes = columns + 2.0 * difference + f64::from(header.slices()) + f64::from(header.axes.layers);
        let (span, curve) = (f64::from(header.span[0]), if self.curve.is_some() { 16.0 } else { 0.0 });
        let of_curve = curve * 16.0 * 8.0 * U;
        8.0 * U * nodes * span + of_curve + 16.0 * U * (span + curve + f64::from(header.low[0].abs()))
    }

    /// The logarithm at the angles computed by the stage itself, whose error has its own row.
    fn log_value(&self, pair: DirectionPair) -> f64 {
        let angles = Angles::of(pair);
        let header = self.header;
        let root = (f64::from(angles.theta_half) / FRAC_PI_2).min(1.0).sqrt();
        let along = root * (KNOTS - 1) as f64;
        let lower = (along as usize).min(KNOTS - 2);
        let [a, b] = [header.knots[lower], header.knots[lower + 1]].map(f64::from);
        let column = (a + (along - lower as f64) * (b - a)) * f64::from(header.axes.half - 1);
        let ratio = f64::from(angles.ratio);
        let row = ratio * (1.0 + f64::from(header.slope) * (1.0 - ratio)) * f64::from(header.axes.difference - 1);
        let [half_share, difference_share] = folded(angles, header.symmetry);
        let steps = header.axes.azimuth - u32::from(header.symmetry.mirror);
        let slice = difference_share * f64::from(steps);
        let mut value = 0.0;
        for (layer, weight) in layers(header, half_share) {
            value += weight * self.trilinear([column, row, slice], layer);
        }
        let curve = self.curve.as_ref().map_or(0.0, |nodes| {
            let at = root * (nodes.len() - 1) as f64;
            let lower = (at as usize).min(nodes.len() - 2);
            let [a, b] = [nodes[lower][0], nodes[lower + 1][0]].map(f64::from);
            a + (at - lower as f64) * (b - a)
        });
        f64::from(header.low[0]) + f64::from(header.span[0]) * value + curve
    }

    fn trilinear(&self, position: [f64; 3], layer: u32) -> f64 {
        let [columns, rows, _] = self.header.extent();
        let sizes = [columns, rows, self.header.slices()];
        let lower: [u32; 3] = std::array::from_fn(|axis| (position[axis] as u32).min(sizes[axis] - 2));
        (0..8u32)
            .map(|corner| {
                let step: [u32; 3] = std::array::from_fn(|axis| corner >> axis & 1);
                let weight: f64 = (0..3)
                    .map(|axis| {
                        let share = position[axis] - f64::from(lower[axis]);
                        if step[axis] == 1 { share } else { 1.0 - share }
                    })
                    .product();
                let [c, r, s] = std::array::from_fn(|axis| lower[axis] + step[axis]);
                let texel = (((layer * sizes[2] + s) * rows + r) * columns + c) as usize;
                weight * f64::from(self.texels[texel][0])
            })
            .sum()
    }
}

/// Layers on either side and their weights.
fn layers(header: &TableHeader, half_share: f64) -> [(u32, f64); 2] {
    let layers = header.axes.layers;
    if layers == 1 {
        return [(0, 1.0), (0, 0.0)];
    }
    let steps = layers - u32::from(header.symmetry.reflected);
    let at = half_share * f64::from(steps);
    let lower = (at as u32).min(steps - 1);
    [(lower, 1.0 - (at - f64::from(lower))), ((lower + 1) % layers, at - f64::from(lower))]
}

/// Azimuths as shares of their periods, folded by a symmetry.
fn folded(angles: Angles, symmetry: TableSymmetry) -> [f64; 2] {
    let (mut half, mut difference) = (f64::from(angles.phi_half), f64::from(angles.phi_difference));
    if symmetry.reflected && symmetry.half_turn {
        half += if half < 0.0 { PI } else { 0.0 };
    }
    let folds = symmetry.reflected && if symmetry.half_turn { half > FRAC_PI_2 } else { half < 0.0 };
    if folds {
        half = if symmetry.half_turn { PI - half } else { -half };
        difference = -difference;
    }
    if symmetry.mirror {
        difference = difference.abs();
        if symmetry.reciprocal && difference > FRAC_PI_2 {
            difference = PI - difference;
        }
    }
    let turns = |flag: bool| if flag { 0.5 } else { 1.0 };
    let of = 2.0 * PI * turns(symmetry.reflected) * turns(symmetry.half_turn);
    let around = |share: f64, ends: bool| if ends { share.clamp(0.0, 1.0) } else { share - share.floor() };
    [
        around(half / of, symmetry.reflected),
        around(difference / (2.0 * PI * turns(symmetry.mirror) * turns(symmetry.reciprocal)), symmetry.mirror),
    ]
}

/// Conjugate gradients in f32 compared with a dense solution in f64, in the norm that they minimise.
fn solve(stages: &Stages, small: bool) -> [StressRow; 2] {
    let [mut touched, mut untouched] = [Worst::default(); 2];
    let mut numbers = Numbers::new(21);
    for round in 0..if small { 4 } else { 24 } {
        let axes = Axes { half: 6, difference: 4, azimuth: 3, layers: 1 };
        let header = TableHeader { axes, ..header(3, 1, &mut numbers) };
        let lattice = Lattice::new(&header);
        let sparse = round % 2 == 1;
        let mut equations = Equations::<1>::new(lattice);
        let mut exact = DMatrix::<f64>::zeros(lattice.len(), lattice.len());
        let mut right = DVector::<f64>::zeros(lattice.len());
        for _ in 0..if sparse { 12 } else { 3000 } {
            // Sparse samples touch only a corner.
            let mut share = || if sparse { 0.3 * numbers.unit() } else { numbers.unit() };
            let position = Position {
                column: (share() * 5.0) as f32,
                row: (share() * 3.0) as f32,
                slice: (share() * 2.0) as f32,
                layers: [0, 0],
                layer_weight: 0.0,
            };
            let value = (numbers.wide().ln()) as f32;
            let weight = numbers.between(1e-3, 1.0) as f32;
            let taps = lattice.taps(&position);
            equations.add(&taps, [value], weight);
            for (a, of_a) in lattice.touched(&taps) {
                right[a] += f64::from(weight * of_a) * f64::from(value);
                for (b, of_b) in lattice.touched(&taps) {
                    exact[(a, b)] += f64::from(weight * of_a) * f64::from(of_b);
                }
            }
        }
        equations.smooth(TIE);
        tie(&mut exact, axes);
        let mut found = vec![[0.0f32]; lattice.len()];
        (stages.solve)(&equations, &mut found);
        let Some(factor) = exact.clone().cholesky() else {
            touched.add(f64::NAN);
            continue;
        };
        let best = factor.solve(&right);
        let norm = |v: &DVector<f64>| v.dot(&(&exact * v)).max(0.0).sqrt();
        let missed = DVector::from_fn(lattice.len(), |node, _| f64::from(found[node][0]) - best[node]);
        let share = norm(&missed) / norm(&best);
        if sparse {
            untouched.add(share);
            continue;
        }
        let condition = condition(&exact);
        let root = condition.sqrt();
        let steps = 2.0 * ((root - 1.0) / (root + 1.0)).powi(STEPS as i32);
        touched.add(share / (steps + 1e-4 * root + 64.0 * U * condition));
    }
    [
        touched.row(
            ["fitting tables, f32", "logarithms of 1e-12 to 1e6, weights 1e-3 to 1, all nodes touched"],
            Measure::OfBound,
            1.0,
            "conjugate gradients: 2 ((√κ - 1) / (√κ + 1))^30 for the condition κ, the 1e-4 √κ at which they stop, 64 roundings κ; in the norm that they minimise",
        ),
        untouched.row(
            ["fitting tables, f32", "the same, almost no samples: most nodes are determined by weak ties"],
            Measure::Relative,
            1.0,
            "each step is closer in that norm than the first guess, whose distance is 1",
        ),
    ]
}

/// Weight of the ties between nodes and their neighbours in a fit.
const TIE: f32 = 1e-4;

/// Terms that [`Equations::smooth`] adds, for a table that is not periodic along any axis.
fn tie(matrix: &mut DMatrix<f64>, axes: Axes) {
    let sizes = [axes.half, axes.difference, axes.azimuth].map(|n| n as usize);
    let strides = [1, sizes[0], sizes[0] * sizes[1]];
    let tie = f64::from(TIE) * matrix.trace() / matrix.nrows() as f64;
    for node in 0..matrix.nrows() {
        for axis in 0..3 {
            if (node / strides[axis]) % sizes[axis] + 1 < sizes[axis] {
                let other = node + strides[axis];
                // Each node ties the other.
                for (a, b) in [(node, other), (other, node)] {
                    matrix[(a, a)] += tie;
                    matrix[(a, b)] -= tie;
                }
            }
        }
    }
}

/// Condition of the matrix scaled by its diagonal.
fn condition(matrix: &DMatrix<f64>) -> f64 {
    let scaled = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |a, b| {
        matrix[(a, b)] / (matrix[(a, a)] * matrix[(b, b)]).sqrt()
    });
    let values = scaled.symmetric_eigenvalues();
    values.max() / values.min().max(f64::MIN_POSITIVE)
}

/// Texels of complete packs compared with the fitted nodes.
fn round(stages: &Stages, small: bool) -> StressRow {
    let mut worst = Worst::default();
    let spike = Of {
        value: |pair: DirectionPair| if half_vector(pair)[2] > 0.9999 { 1e6 } else { 1e-12 },
        symmetry: Symmetry::FULL,
    };
    let address = |text: &str| parse_synth(text).ok();
    let mut sources: Vec<Box<dyn Source>> = vec![Box::new(spike), Box::new(constant(1e-12)), Box::new(constant(0.0))];
    sources.extend(address("synth:ggx?kd=0,0.1,0.9&alpha=0.003"));
    if !small {
        sources.extend(address("synth:ward?kd=0.2,0.1,0&ax=0.05&ay=0.5"));
        sources.extend(address("synth:lewis?kd=0,0,0.5&n=200"));
    }
    let size = Size::Nodes(Axes { half: 9, difference: 5, azimuth: 4, layers: 1 });
    for source in sources {
        let layers = if source.symmetry().isotropic { 1 } else { 3 };
        let size = if layers == 1 { size } else { Size::Nodes(Axes { half: 9, difference: 5, azimuth: 4, layers }) };
        let recipe = TableRecipe { size, measure: false, supercompress: false, ..TableRecipe::default() };
        let made = Prepared::new(source.as_ref(), &recipe, 1 << 13, &()).ok().and_then(|prepared| {
            let (_, nodes) = prepared.nodes(size, &()).ok()?;
            Some((nodes, (stages.table_pack)(&prepared, &recipe).ok()?))
        });
        let Some((nodes, pack)) = made else {
            worst.add(f64::NAN);
            continue;
        };
        compare_texels(&nodes, &pack, &mut worst);
    }
    worst.row(
        ["rounding tables", "a spike of 1e18 to 1, GGX of roughness 0.003, constants, black"],
        Measure::Steps,
        1.5,
        "half a step, and one more to compensate for the neighbours; grey tables have halves as fine as ten bits of the range",
    )
}

fn compare_texels(nodes: &[[f32; 3]], pack: &TablePack, worst: &mut Worst) {
    let header = pack.header();
    let slice = (header.axes.half * header.axes.difference) as usize;
    let texels = pack.values();
    for (k, node) in nodes.iter().enumerate() {
        // Without a mirror, the first slice of each layer is repeated after the layer.
        let layer = k / (slice * header.axes.azimuth as usize);
        let at = k + layer * slice * (header.slices() - header.axes.azimuth) as usize;
        for channel in 0..header.channels as usize {
            let (low, span) = (f64::from(header.low[channel]), f64::from(header.span[channel]));
            let target = f64::from(node[channel]).clamp(low, low + span);
            let found = low + span * f64::from(texels[at][channel]);
            worst.add(if span > 0.0 { (found - target) / span * TEN_BITS } else { found - low });
        }
    }
}
