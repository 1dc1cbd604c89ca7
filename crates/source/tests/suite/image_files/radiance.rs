//! Radiance of EXR and Radiance HDR: windows, layers, primaries and headers.

use super::*;

/// An EXR of a data window in a display window, whose channels hold `value` of the channel and the place in the data window.
fn exr_of(
    display: ([i32; 2], [usize; 2]),
    data: ([i32; 2], [usize; 2]),
    channels: &[&str],
    chromaticities: Option<Chromaticities>,
    value: impl Fn(usize, [usize; 2]) -> f32,
) -> Vec<u8> {
    let [width, height] = data.1;
    let samples = |c: usize| (0..width * height).map(|at| value(c, [at % width, at / width])).collect();
    let list = channels.iter().enumerate().map(|(c, name)| AnyChannel::new(*name, FlatSamples::F32(samples(c))));
    let attributes = LayerAttributes { layer_position: Vec2(data.0[0], data.0[1]), ..LayerAttributes::default() };
    let layer = Layer::new((width, height), attributes, Encoding::SMALL_LOSSLESS, AnyChannels::sort(list.collect()));
    let window = IntegerBounds::new(Vec2(display.0[0], display.0[1]), Vec2(display.1[0], display.1[1]));
    let mut all = ImageAttributes::new(window);
    all.chromaticities = chromaticities;
    let image = exr::prelude::Image::empty(all).with_layer(layer);
    let mut bytes = Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn data_windows_are_placed_in_display_windows() {
    let value = |c: usize, [x, y]: [usize; 2]| 1.0 + c as f32 + 10.0 * x as f32 + 100.0 * y as f32;
    // Inside the display window, beyond each side of it, and around it.
    for (corner, size) in [([3, 2], [5, 4]), ([-2, -1], [6, 5]), ([10, 5], [12, 9]), ([-3, -3], [30, 20])] {
        for origin in [[0, 0], [100, -50]] {
            let display = (origin, [16, 8]);
            let data = ([origin[0] + corner[0], origin[1] + corner[1]], size);
            let expected = |c: usize, at: usize| {
                let place = [at % 16, at / 16].map(|v| v as i32);
                let inside = [place[0] - corner[0], place[1] - corner[1]];
                let is_inside = (0..2).all(|k| (0..size[k] as i32).contains(&inside[k]));
                if is_inside { value(c, inside.map(|v| v as usize)) } else { 0.0 }
            };
            let exr = exr_of(display, data, &["R", "G", "B"], None, value);
            let image = from_exr(&exr).unwrap();
            let photograph = photograph(&exr, "exr", None).unwrap().0;
            assert_eq!(([image.width, image.height], &image.pixels), ([16, 8], &photograph.pixels));
            for (at, pixel) in image.pixels.iter().enumerate() {
                assert_eq!(*pixel, [0, 1, 2].map(|c| expected(c, at)), "{corner:?} {origin:?} {at}");
            }
            assert!(image.conversions[1].starts_with("data window of "), "{:?}", image.conversions);
            let heights = heights_from_exr(&exr_of(display, data, &["Y"], None, value)).unwrap();
            assert!(heights.heights.iter().enumerate().all(|(at, height)| *height == expected(0, at)));
        }
    }
    let whole = from_exr(&exr_of(([0, 0], [16, 8]), ([0, 0], [16, 8]), &["R", "G", "B"], None, value)).unwrap();
    assert_eq!(whole.conversions, ["linear (EXR)"]);
}

#[test]
fn the_only_colour_layer_of_an_exr_is_read() {
    let window = ([0, 0], [4, 4]);
    let read = |channels: &[&str]| {
        from_exr(&exr_of(window, window, channels, None, |c, _| c as f32 + 1.0)).map_err(|error| error.to_string())
    };
    for (channels, expected) in [
        (&["R", "G", "B", "Z"][..], [1.0, 2.0, 3.0]),
        (&["Z", "ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"], [2.0, 3.0, 4.0]),
        (&["a.R", "a.G", "a.B", "R", "G", "B"], [4.0, 5.0, 6.0]),
        (&["Y"], [1.0; 3]),
        (&["A", "left.Y"], [2.0; 3]),
        (&["a.Combined.R", "a.Combined.G", "a.Combined.B", "a.Diff.R", "a.Diff.G", "a.Diff.B"], [1.0, 2.0, 3.0]),
        // Components of a normal are no luminance.
        (&["a.R", "a.G", "a.B", "Normal.X", "Normal.Y", "Normal.Z"], [1.0, 2.0, 3.0]),
    ] {
        let image = read(channels).unwrap();
        assert!(image.pixels.iter().all(|pixel| *pixel == expected), "{channels:?} {:?}", image.pixels[0]);
    }
    let named = read(&["Z", "ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"]).unwrap();
    assert_eq!(named.conversions[1], "layer ViewLayer.Combined");
    let of_two = read(&["a.Diff.R", "a.Diff.G", "a.Diff.B", "a.beauty.R", "a.beauty.G", "a.beauty.B"]).unwrap();
    assert_eq!(of_two.conversions[1], "layer a.beauty, of 2 layers of colours");
    let unnamed = read(&["a.R", "a.G", "a.B", "R", "G", "B"]).unwrap();
    assert_eq!(unnamed.conversions[1], "layer without a name, of 2 layers of colours");
    let both = read(&["a.RGBA.R", "a.RGBA.G", "a.RGBA.B", "b.RGBA.R", "b.RGBA.G", "b.RGBA.B"]).unwrap_err();
    assert!(both.starts_with("EXR: found layers a.RGBA, b.RGBA, expected one layer of colours"), "{both}");
    let heights = heights_from_exr(&exr_of(window, window, &["a.Combined.R", "b.R"], None, |_, _| 0.0)).unwrap_err();
    assert_eq!(
        heights.to_string(),
        "EXR: found layers a.Combined, b, expected one layer of heights, or one without a name"
    );
    let next_to_normals = exr_of(window, window, &["N.X", "N.Y", "N.Z", "R"], None, |c, _| c as f32);
    assert_eq!(heights_from_exr(&next_to_normals).unwrap().heights, [3.0; 16]);
    let two = read(&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"]).unwrap_err();
    assert_eq!(
        two,
        "EXR: found layers a, b, expected one layer of colours, or one without a name, or one named Combined, Beauty or RGBA"
    );
    let none = read(&["U", "V"]).unwrap_err();
    assert_eq!(none, "EXR: found channels U, V, expected channels R, G and B, or Y");
    assert!(read(&["Y", "RY", "BY"]).unwrap_err().contains("found channels BY, RY, Y"));
}

#[test]
fn chromaticities_of_an_exr_are_converted() {
    let [red, green, blue] = ACES_CG.map(|[x, y]| Vec2(x as f32, y as f32));
    let white = Vec2(ACES_WHITE[0] as f32, ACES_WHITE[1] as f32);
    let window = ([0, 0], [4, 2]);
    let aces = Chromaticities { red, green, blue, white };
    let exr = exr_of(window, window, &["R", "G", "B"], Some(aces), |c, [x, y]| [0.2, 1.5, 0.7][c] * (1 + x + y) as f32);
    let image = from_exr(&exr).unwrap();
    assert_eq!(
        image.conversions,
        [
            "chromaticities of EXR, converted to linear Rec. 709",
            "100.000 % of the pixels lie outside the gamut of Rec. 709 and were clipped"
        ]
    );
    for (at, pixel) in image.pixels.iter().enumerate() {
        let scale = (1 + at % 4 + at / 4) as f64;
        let expected = to_rec709([0.2, 1.5, 0.7].map(|v| v * scale), ACES_CG, ACES_WHITE);
        // Radiance is not negative; photographs of floats keep colours outside the gamut.
        assert!(
            (0..3).all(|c| (f64::from(pixel[c]) - expected[c].max(0.0)).abs() < 1e-5 * scale),
            "{pixel:?} {expected:?}"
        );
        assert!(expected[0] < -0.1);
        let kept = photograph(&exr, "exr", None).unwrap().0.pixels[at];
        assert!((f64::from(kept[0]) - expected[0]).abs() < 1e-5 * scale);
    }
}

fn hdr(head: &str, resolution: &str) -> Vec<u8> {
    // Pixels of 1, 2, ... in the order of the file; red, and half and a quarter of it.
    let pixels = (1..=6u8).flat_map(|k| [8 * k, 4 * k, 2 * k, 128 + 5]);
    format!("{head}\n\n{resolution}\n").into_bytes().into_iter().chain(pixels).collect()
}

#[test]
fn headers_of_radiance_files_are_applied() {
    let head = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe";
    let read = |lines: &str| from_hdr(&hdr(&format!("{head}{lines}"), "-Y 2 +X 3"));
    let first = |lines: &str| read(lines).unwrap_or_else(|error| panic!("{lines}: {error}")).pixels[0].map(f64::from);
    let plain = [1.0, 0.5, 0.25];
    let close = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6);
    assert_eq!(first(""), plain);
    assert!(close(first("\nEXPOSURE=4"), plain.map(|v| v / 4.0)));
    assert!(close(first("\nEXPOSURE=4\nEXPOSURE= 0.5"), plain.map(|v| v / 2.0)));
    assert_eq!(first("\n\tEXPOSURE=4\n# EXPOSURE=3"), plain);
    assert!(close(first("\nCOLORCORR=2 1 .5"), [0.5, 0.5, 0.5]));
    assert!(close(first("\nGAMMA=2.2"), plain.map(|v| v.powf(2.2))));
    assert!(close(first("\nGAMMA=2\nEXPOSURE=4"), plain.map(|v| v * v / 4.0)));
    let primaries = "\nPRIMARIES=0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.329";
    assert!(close(first(primaries), to_rec709(plain, P3, D65).map(|v| v.max(0.0))));
    assert_eq!(read("\nEXPOSURE=4").unwrap().conversions, ["linear (Radiance)", "EXPOSURE 4 divided out"]);
    // As ImageMagick and Photoshop write it.
    let zeros = read("\nPRIMARIES=0 0 0 0 0 0 0 0").unwrap();
    assert_eq!(
        (zeros.pixels[0].map(f64::from), &zeros.conversions[..]),
        (plain, &["linear (Radiance)".to_owned()][..])
    );
    let error = read("\nPRIMARIES=1 0 0 1 0 0 2 2").unwrap_err().to_string();
    assert!(error.starts_with("primaries of Radiance PRIMARIES: found [[1.0, 0.0], "), "{error}");
    for lines in ["\nPRIMARIES=0 0 0 0 0 0 0 1", "\nEXPOSURE=0", "\nEXPOSURE=x", "\nCOLORCORR=1 2", "\nGAMMA=-1"] {
        assert!(read(lines).is_err(), "{lines}");
    }
    let xyze = from_hdr(&hdr("#?RADIANCE\nFORMAT=32-bit_rle_xyze", "-Y 2 +X 3")).unwrap().pixels[0].map(f64::from);
    let white = [1.0 / 3.0; 2];
    let [from, to] = [white, D65].map(|white| times(BRADFORD, xyz(white)));
    let cones = times(BRADFORD, plain);
    let adapted: [f64; 3] = std::array::from_fn(|c| cones[c] * to[c] / from[c]);
    let expected = solve(to_xyz(REC709, D65), solve(BRADFORD, adapted));
    assert!(close(xyze, expected.map(|v| v.max(0.0))), "{xyze:?} {expected:?}");
    let rgbe = from_hdr(&hdr("#?RGBE\nFORMAT=32-bit_rle_rgbe", "-Y 2 +X 3")).unwrap();
    assert_eq!(rgbe.pixels[0].map(f64::from), plain);
    let orders: [(&str, [usize; 2], [u8; 6]); 8] = [
        ("-Y 2 +X 3", [3, 2], [1, 2, 3, 4, 5, 6]),
        ("-Y 2 -X 3", [3, 2], [3, 2, 1, 6, 5, 4]),
        ("+Y 2 -X 3", [3, 2], [6, 5, 4, 3, 2, 1]),
        ("+Y 2 +X 3", [3, 2], [4, 5, 6, 1, 2, 3]),
        // Lines are columns: the first has 1, 2 and 3.
        ("+X 2 -Y 3", [2, 3], [1, 4, 2, 5, 3, 6]),
        ("-X 2 -Y 3", [2, 3], [4, 1, 5, 2, 6, 3]),
        ("-X 2 +Y 3", [2, 3], [6, 3, 5, 2, 4, 1]),
        ("+X 2 +Y 3", [2, 3], [3, 6, 2, 5, 1, 4]),
    ];
    for (resolution, size, expected) in orders {
        let image = from_hdr(&hdr(head, resolution)).unwrap();
        let found: Vec<u8> = image.pixels.iter().map(|pixel| pixel[0].round() as u8).collect();
        assert_eq!(([image.width, image.height], &found[..]), (size, &expected[..]), "{resolution}");
    }
    for resolution in ["-Y 2 +Y 3", "-Y 2", "-Y x +X 3", "-Y 0 +X 3"] {
        assert!(from_hdr(&hdr(head, resolution)).is_err(), "{resolution}");
    }
}
