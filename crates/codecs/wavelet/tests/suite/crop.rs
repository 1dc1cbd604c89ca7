//! Cropped data are those that no look-up within the range of directions reads.

use brdfc_core::address::parse_synth;
use brdfc_formats::crop::{DirectionRange, Elevations};
use brdfc_formats::direction::{DirectionPair, Parameterisation};
use brdfc_formats::wavelet::{Filter, Header, WaveletDecoder, WaveletPack};
use brdfc_testing::codecs::wavelet::{energy_preserving, header, pack};
use brdfc_testing::packs::pairs;
use brdfc_wavelet::crop::crop;
use brdfc_wavelet::encode::encode;
use brdfc_wavelet::recipe::{Recipe, Target};

fn range(light: [f32; 2], view: [f32; 2]) -> DirectionRange {
    let [light, view] = [light, view].map(|[from, to]| Elevations { from, to });
    DirectionRange { light, view }
}

const RANGES: [([f32; 2], [f32; 2]); 5] = [
    ([0.0, 90.0], [30.0, 90.0]),
    ([25.0, 90.0], [0.0, 20.0]),
    ([50.0, 65.0], [40.0, 70.0]),
    ([0.0, 10.0], [80.0, 90.0]),
    ([5.0, 90.0], [5.0, 90.0]),
];

/// Number of differing logarithms at pairs within and outside, at several levels of detail.
fn differing(whole: &WaveletPack, cropped: &WaveletPack, directions: DirectionRange) -> [usize; 2] {
    let [a, b] = [whole, cropped].map(WaveletDecoder::new);
    let mut differing = [0; 2];
    let mut seen = [0; 2];
    for (k, pair) in pairs(6000, 3).into_iter().enumerate() {
        let filter = [Filter::Nearest, Filter::Slices, Filter::Bilinear][k % 3];
        let level = [9.0, 2.0, 1.5][k % 3];
        let outside = usize::from(!directions.contains(pair));
        seen[outside] += 1;
        let bits = |decoder: &WaveletDecoder| decoder.log_value(pair, level, filter).map(f32::to_bits);
        differing[outside] += usize::from(bits(&a) != bits(&b));
    }
    assert!(seen[0] > 20 && seen[1] > 20, "{directions}: {seen:?}");
    differing
}

#[test]
fn look_ups_within_the_range_have_the_same_bits() {
    let tangent_pole = |levels, channels, bits| header(Parameterisation::TangentPole, levels, channels, bits);
    let headers: [Header; 4] = [
        tangent_pole(5, 3, 8),
        tangent_pole(4, 1, 12),
        energy_preserving(5, 1, 8),
        Header { stored_levels: 3, ..tangent_pole(5, 1, 8) },
    ];
    for (k, header) in headers.into_iter().enumerate() {
        let whole = pack(header, (1usize << (2 * header.stored_levels)) / 2, k as u64);
        for (light, view) in RANGES {
            let directions = range(light, view);
            let cropped = crop(whole.clone(), directions);
            let [within, outside] = differing(&whole, &cropped, directions);
            assert_eq!(within, 0, "{k}: {directions}");
            // Control: some data were cropped, with visible effect.
            assert!(outside > 0 || 100 * cropped.gpu_bytes() > 95 * whole.gpu_bytes(), "{k}: {directions}");
            let read = WaveletPack::from_bytes(&cropped.to_bytes(true)).expect("a pack");
            assert_eq!(read, cropped);
        }
        assert_eq!(crop(whole.clone(), DirectionRange::ALL), whole);
    }
}

/// A camera above 30 degrees with lights above 30 degrees.
#[test]
fn packs_for_views_from_above_are_smaller() {
    let source = parse_synth("synth:ggx?kd=0.3&f0=0.04&alpha=0.2").expect("an address");
    let directions = range([30.0, 90.0], [30.0, 90.0]);
    let whole = Recipe { levels: 4, stored_levels: 4, ..Recipe::default() };
    let cropped = Recipe { directions, ..whole.clone() };
    let [whole, cropped] = [&whole, &cropped].map(|recipe| encode(source.as_ref(), recipe, &()).expect("a pack"));
    let [most, left] = [&whole, &cropped].map(|made| made.pack.gpu_bytes());
    assert!(10 * left < 8 * most, "{left} of {most}");
    assert_eq!(differing(&whole.pack, &cropped.pack, directions)[0], 0);
    // The error is measured within the range: grazing angles are the hardest.
    let [whole, cropped] = [whole, cropped].map(|made| made.off_grid.norms.relative_mean);
    assert!(cropped > 0.0 && cropped < whole, "{cropped} {whole}");

    let budget =
        Recipe { target: Target::MaxBytes(left), directions, levels: 4, stored_levels: 4, ..Recipe::default() };
    let made = encode(source.as_ref(), &budget, &()).expect("a pack");
    assert!(made.pack.gpu_bytes() <= left && 10 * made.pack.gpu_bytes() > 9 * left, "a budget is filled");
    assert!(!directions.contains(DirectionPair::from_angles(0.1, 0.0, 1.5, 0.0)));
}
