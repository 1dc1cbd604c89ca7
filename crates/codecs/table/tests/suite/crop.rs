//! Cropped texels are those that no look-up within the range of directions reads.

use brdfc_core::PackSource;
use brdfc_core::address::parse_synth;
use brdfc_formats::crop::{Crop, DirectionRange, Elevations, Window};
use brdfc_formats::table::{Angles, TableDecoder, TablePack};
use brdfc_metrics::compare::Reference;
use brdfc_metrics::sampling::PairSet;
use brdfc_table::crop::window;
use brdfc_table::encode::encode;
use brdfc_table::recipe::{Size, TableRecipe};
use brdfc_table::samples::Samples;
use brdfc_testing::codecs::table::tables;
use brdfc_testing::packs::pairs;

fn range(light: [f32; 2], view: [f32; 2]) -> DirectionRange {
    let [light, view] = [light, view].map(|[from, to]| Elevations { from, to });
    DirectionRange { light, view }
}

const RANGES: [([f32; 2], [f32; 2]); 5] = [
    ([30.0, 90.0], [30.0, 90.0]),
    ([0.0, 90.0], [45.0, 90.0]),
    ([70.0, 90.0], [0.0, 20.0]),
    ([50.0, 65.0], [40.0, 70.0]),
    ([5.0, 90.0], [5.0, 90.0]),
];

/// Number of differing logarithms at pairs within and outside.
fn differing(whole: &TablePack, cropped: &TablePack, directions: DirectionRange) -> [usize; 2] {
    let [a, b] = [whole, cropped].map(TableDecoder::new);
    let mut differing = [0; 2];
    let mut seen = [0; 2];
    for (k, pair) in pairs(6000, 3).into_iter().enumerate() {
        let level = [9.0, 1.0, 0.5][k % 3];
        let outside = usize::from(!directions.contains(pair));
        seen[outside] += 1;
        differing[outside] += usize::from(a.log_values(pair, level) != b.log_values(pair, level));
    }
    assert!(seen[0] > 20 && seen[1] > 20, "{directions}: {seen:?}");
    differing
}

#[test]
fn look_ups_within_the_range_have_the_same_bits() {
    let mut smaller = 0;
    for (name, whole) in tables().into_iter().filter(|(_, pack)| pack.crop().is_none()) {
        for (light, view) in RANGES {
            let directions = range(light, view);
            let crop = Crop { directions, window: window(whole.header(), directions) };
            let cropped = whole.cropped(crop).expect("within the texture");
            let [within, outside] = differing(&whole, &cropped, directions);
            assert_eq!(within, 0, "{name}: {directions}");
            smaller += usize::from(cropped.gpu_bytes() < whole.gpu_bytes());
            assert!(outside > 0 || cropped.gpu_bytes() == whole.gpu_bytes(), "{name}: {directions}");
            let read = TablePack::from_bytes(&cropped.to_bytes(true)).expect("a pack");
            assert_eq!(read, cropped);
        }
        let [columns, rows, _] = whole.header().extent();
        assert_eq!(window(whole.header(), DirectionRange::ALL), Window::whole([columns, rows]));
    }
    assert!(smaller > 20, "{smaller}");
}

#[test]
fn budgets_count_cropped_bytes() {
    let source = parse_synth("synth:ggx?kd=0.3&f0=0.04&alpha=0.2").expect("an address");
    let directions = range([30.0, 90.0], [30.0, 90.0]);
    for factored in [false, true] {
        let whole = TableRecipe { size: Size::Bytes(4 << 10), factored, ..TableRecipe::default() };
        let cropped = TableRecipe { directions, ..whole.clone() };
        let [whole, cropped] = [&whole, &cropped].map(|recipe| encode(source.as_ref(), recipe, &()).expect("a pack"));
        let bytes = cropped.pack.gpu_bytes();
        assert!(bytes <= 4 << 10 && bytes > 3600, "{bytes}");
        let header = cropped.pack.header();
        assert!(10 * header.texels() > 12 * whole.pack.header().texels(), "{:?}", header.axes);
        assert_eq!(cropped.pack.crop().map(|crop| crop.directions), Some(directions));
        // Grazing angles have the largest errors.
        let [found, most] = [cropped, whole].map(|made| made.off_grid.norms.relative_mean);
        assert!(found < 0.5 * most, "{found} {most}");
    }
}

/// If little but a highlight remains, a table that is fitted to the range is closer there than a cropped table with as
/// many nodes for all directions; elsewhere, where it was not fitted, it is farther.
#[test]
fn tables_are_fitted_to_the_range() {
    let source = parse_synth("synth:ggx?kd=0.3,0.2,0.1&f0=0.04&alpha=0.12").expect("an address");
    for directions in [range([85.0, 90.0], [0.0, 90.0]), range([0.0, 90.0], [0.0, 20.0])] {
        let whole = TableRecipe { size: Size::Bytes(4 << 10), ..TableRecipe::default() };
        let fitted = TableRecipe { directions, ..whole.clone() };
        let [whole, fitted] =
            [&whole, &fitted].map(|recipe| encode(source.as_ref(), recipe, &()).expect("a pack").pack);
        let crop = Crop { directions, window: window(whole.header(), directions) };
        let cropped = whole.cropped(crop).expect("within the texture");
        let within = Reference::new(source.as_ref(), PairSet::within(directions));
        let delta_e =
            |reference: &Reference, pack| reference.compare(&PackSource::new(pack, None)).rendering.delta_e.mean;
        let [found, before] = [&fitted, &cropped].map(|pack| delta_e(&within, pack));
        assert!(found < 0.8 * before, "{directions}: {found} after {before}");
        let everywhere = Reference::new(source.as_ref(), PairSet::comparison());
        let [found, before] = [&fitted, &whole].map(|pack| delta_e(&everywhere, pack));
        assert!(found > 1.2 * before, "{directions}: {found} elsewhere, {before}");
    }
}

/// Ranges are as narrow as packs allow; all samples are within, and their number is exact.
#[test]
fn samples_are_within_the_range() {
    let source = parse_synth("synth:lambert").expect("an address");
    let narrow = [([0.0, 0.1], [0.0, 0.1]), ([89.9, 90.0], [40.0, 40.1]), ([20.0, 25.0], [60.0, 65.0])];
    for (light, view) in narrow.into_iter().chain(RANGES) {
        let directions = range(light, view);
        let samples = Samples::within(source.as_ref(), 3000, false, directions);
        assert_eq!(samples.len(), 3000, "{directions}");
        let is_within = |angles: &Angles| directions.contains(angles.pair());
        let within = samples.angles.iter().filter(|angles| is_within(angles)).count();
        // Angles are rounded to f32.
        assert!(within > 2900 || light[1] < 1.0, "{directions}: {within}");
    }
    let all = Samples::draw(source.as_ref(), 3000, false);
    let outside = all.angles.iter().filter(|angles| !range([85.0, 90.0], [0.0, 90.0]).contains(angles.pair())).count();
    assert!(outside > 2500, "without a range they are everywhere");
}
