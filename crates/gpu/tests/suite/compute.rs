//! Shaders over lists of any length: empty, one item, more than a row of workgroups.

use brdfc_formats::BrdfPack;
use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::direction::Parameterisation;
use brdfc_formats::wavelet::Filter;
use brdfc_gpu::{GpuError, SliceFilter};
use brdfc_probe::{Compute, Evaluator};
use brdfc_testing::codecs::wavelet::{header, pack};
use brdfc_testing::packs::pairs;

#[test]
fn lists_of_any_length() {
    let Some(gpu) = crate::common::gpu() else { return };
    let source = "fn compute(at: u32) {
        output[2u * at] = input[at];
        output[2u * at + 1u] = f32(at);
    }";
    let compute = Compute::new(gpu, source, &[], FrameBlock::default()).unwrap();
    for count in [0, 1, 64, 65, 65_536, 65_537, 200_001] {
        let input: Vec<f32> = (0..count).map(|k| 0.5 * k as f32).collect();
        let found = compute.run(&input, 1, 2).unwrap();
        assert_eq!(found.len(), 2 * count);
        let wrong = found.chunks_exact(2).enumerate().find(|(k, found)| **found != [0.5 * *k as f32, *k as f32]);
        assert_eq!(wrong, None, "of {count}");
    }
    let refused = compute.run(&[0.0; 3], 2, 1).unwrap_err();
    let expected = "found 3 numbers in items of 2 and 1, expected at most 16777216";
    assert_eq!(refused, GpuError::TooLarge(expected.to_owned()));
}

#[test]
fn pairs_are_evaluated_whether_they_are_read_or_not() {
    let Some(gpu) = crate::common::gpu() else { return };
    let evaluator = Evaluator::new(gpu).unwrap();
    let pack = BrdfPack::Wavelet(pack(header(Parameterisation::HalfDifference, 2, 3, 8), 4, 1));
    let loaded = evaluator.load(&pack, Filter::Nearest).unwrap();
    for count in [0, 1, 70_000] {
        let pairs = pairs(count, 4);
        let on_device = evaluator.load_pairs(&pairs, 1.0, SliceFilter::Exact).unwrap();
        evaluator.run(&loaded, &on_device).unwrap();
        let found = evaluator.eval(&loaded, &pairs, 1.0, SliceFilter::Exact).unwrap();
        assert_eq!(found.len(), count);
        // The last pair represents its row.
        let alone = pairs.last().map(|pair| evaluator.eval(&loaded, &[*pair], 1.0, SliceFilter::Exact).unwrap()[0]);
        assert_eq!(found.last().copied(), alone);
    }
}
