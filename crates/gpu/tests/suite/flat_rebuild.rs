//! The rebuilt values of the study of flat BTFs equal the values of the packs: the stored map and the packed values.

use crate::common::flat;
use brdfc_flat_btf::rebuild::{ViewImage, sample_bilinear, stored_parameters};
use brdfc_formats::container::rgb9e5;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{FlatBtfDecoder, IndirectionHeader, ViewWeights};

const HEADER: IndirectionHeader =
    IndirectionHeader { size: 24, zenith_samples: 4, azimuth_samples: 6, largest_angle: 1.4 };

#[test]
fn rebuilt_images_are_those_of_the_decoder() {
    let (model, appearance) = flat::structure("button?resolution=48", None);
    let set = DirectionSet::new("list", vec![[0.0, 0.0], [40.0, 75.0], [65.0, 200.0]]).unwrap();
    let decoder = FlatBtfDecoder::new(flat::parts(&model, &appearance, 32, HEADER, [&set, &set])).unwrap();
    let still = FlatBtfDecoder::new(flat::with_displacements(decoder.parts(), 0.0)).unwrap();
    for (view, direction) in set.directions().iter().enumerate() {
        let image: Vec<[f32; 3]> =
            decoder.parts().values.views()[view].light(1).iter().map(|t| rgb9e5::decode(*t)).collect();
        let rebuilt = sample_bilinear(&image, &stored_parameters(&decoder, *direction));
        let only = |index: usize| ViewWeights { indices: [index as u32; 3], weights: [1.0, 0.0, 0.0] };
        for (texel, value) in rebuilt.iter().enumerate() {
            let at = [texel % 24, texel / 24].map(|c| (c as f32 + 0.5) / 24.0);
            let expected = decoder.full(at, direction.map(|c| c as f32), only(view), only(1));
            for channel in 0..3 {
                assert!((value[channel] - expected[channel]).abs() < 1e-5, "{view} {texel}: {value:?} {expected:?}");
            }
        }
        // The control: rays of the view itself, or a map without displacements, hit other points in oblique views.
        let exact = ViewImage::new(&model, *direction, 24, 1).rebuilt(&image);
        let unmoved = sample_bilinear(&image, &stored_parameters(&still, *direction));
        let off = |image: &[[f32; 3]]| {
            let all = image.iter().zip(&rebuilt).map(|(a, b)| f64::from((a[0] - b[0]).abs()));
            all.sum::<f64>() / rebuilt.len() as f64
        };
        if view > 0 {
            assert!(off(&exact) > 5e-3 && off(&unmoved) > 5e-3, "{} {}", off(&exact), off(&unmoved));
        }
    }
}
