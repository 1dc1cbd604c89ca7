//! Colour and orientation of photographs, as PNG, JPEG and TIFF state them.

use super::*;

#[test]
fn colours_are_converted_as_the_file_states_them() {
    let profile_tag = |stated: Stated| stated.profile().map(|icc| (Tag::IccProfile, TagValue::Bytes(icc)));
    for stated in ALL {
        let icc = stated.profile();
        let chunks: Vec<_> = icc.iter().map(|icc| iccp(icc)).collect();
        let segments = icc.as_ref().map_or(Vec::new(), |icc| jpeg_icc(icc, 100));
        let tags: Vec<_> = profile_tag(stated).into_iter().collect();
        let floats: Vec<f32> = codes(|v| v as f32);
        // Code values of a JPEG are off by rounding in YCbCr.
        let files = [
            ("png", 8, png8(&chunks), 1e-3),
            ("png", 16, png16(&chunks), 1e-3),
            ("jpg", 8, jpeg(&segments), 0.03),
            ("tif", 8, tiff::<colortype::RGB8>(&eight(), &tags), 1e-3),
            ("tif", 16, tiff::<colortype::RGB16>(&sixteen(), &tags), 1e-3),
            ("tif", 32, tiff::<colortype::RGB32Float>(&floats, &tags), 1e-3),
        ];
        for (extension, depth, bytes, tolerance) in files {
            let name = format!("{stated:?} {extension} {depth}");
            let (image, found) = photograph(&bytes, extension, None).unwrap_or_else(|error| panic!("{name}: {error}"));
            // Floats without a profile are linear.
            let meaning = if depth == 32 && stated == Stated::Nothing { Stated::Linear } else { stated };
            let off = difference(&image, |v| meaning.linear(v), depth == 32);
            assert!(off < tolerance, "{name}: {off}, {found}");
            let unstated = difference(&image, |v| v.map(if depth == 32 { |v| v } else { srgb }), depth == 32);
            let is_same = stated == Stated::Nothing || (depth == 32 && stated == Stated::Linear);
            assert_eq!(unstated < 0.03, is_same, "{name}: {unstated}");
            if stated == Stated::P3 {
                assert_overridden(&bytes, extension, tolerance);
            }
        }
    }
}

/// Reads code values as linear and as sRGB in spite of what the file states.
fn assert_overridden(bytes: &[u8], extension: &str, tolerance: f64) {
    for (codes, meaning) in [(CodeValues::Linear, Stated::Linear), (CodeValues::Srgb, Stated::Nothing)] {
        let (image, found) = photograph(bytes, extension, Some(codes)).unwrap_or_else(|e| panic!("{codes:?}: {e}"));
        let off = difference(&image, |v| meaning.linear(v), false);
        assert!(off < tolerance && found.contains("read as"), "{extension} as {codes:?}: {off}, {found}");
    }
}

#[test]
fn chunks_of_png_have_an_order() {
    let (linear, srgb_chunk) = (gama(1.0), (b"sRGB", vec![0]));
    let cicp = |primaries, transfer| (b"cICP", vec![primaries, transfer, 0, 1]);
    let adobe = iccp(&Stated::Adobe.profile().unwrap());
    let bt709 = |v: f64| if v < 0.081 { v / 4.5 } else { ((v + 0.099) / 1.099).powf(1.0 / 0.45) };
    let p3 = |v: [f64; 3]| Stated::P3.linear(v);
    let rec2020 = |v: [f64; 3]| to_rec709(v, [[0.708, 0.292], [0.17, 0.797], [0.131, 0.046]], D65);
    type Case<'a> = (&'a str, Vec<(&'a [u8; 4], Vec<u8>)>, &'a dyn Fn([f64; 3]) -> [f64; 3]);
    let cases: [Case<'_>; 10] = [
        ("gAMA", vec![linear.clone()], &|v| v),
        ("gAMA 1/2.2", vec![gama(0.45455)], &|v| v.map(|v| v.powf(1.0 / 0.45455))),
        // Near linear, and more than rounding.
        ("gAMA 0.99602", vec![gama(0.99602)], &|v| v.map(|v| v.powf(1.0 / 0.99602))),
        ("gAMA, cHRM", vec![gama(0.45455), chrm(P3, D65)], &|v| to_rec709(v.map(|v| v.powf(1.0 / 0.45455)), P3, D65)),
        ("cHRM", vec![chrm(P3, D65)], &p3),
        ("sRGB over gAMA", vec![srgb_chunk.clone(), linear.clone(), chrm(P3, D65)], &|v| v.map(srgb)),
        ("iCCP over gAMA", vec![adobe.clone(), linear.clone()], &|v| Stated::Adobe.linear(v)),
        ("cICP over all", vec![cicp(12, 13), adobe, linear], &p3),
        ("cICP linear", vec![cicp(9, 8)], &rec2020),
        ("cICP BT.709", vec![cicp(1, 1)], &|v| v.map(bt709)),
    ];
    for (name, chunks, linear) in cases {
        for bytes in [png8(&chunks), png16(&chunks)] {
            let (image, found) = photograph(&bytes, "png", None).unwrap_or_else(|error| panic!("{name}: {error}"));
            let off = difference(&image, linear, false);
            assert!(off < 1e-3, "{name}: {off}, {found}");
        }
    }
    for (primaries, transfer) in [(9, 16), (9, 18), (1, 2), (200, 13)] {
        let png = png8(&[cicp(primaries, transfer)]);
        let error = photograph(&png, "png", None).unwrap_err();
        assert!(error.contains("PNG chunk cICP: found cICP"), "{error}");
        assert_overridden(&png, "png", 1e-3);
    }
}

#[test]
fn exif_and_fields_of_tiff_state_colours() {
    let adobe = |v| Stated::Adobe.linear(v);
    for (colour_space, is_r03, is_adobe) in
        [(1, false, false), (2, false, true), (0xffff, true, true), (0xffff, false, false)]
    {
        let bytes = jpeg(&[jpeg_exif(exif(1, colour_space, is_r03))]);
        let (image, found) = photograph(&bytes, "jpg", None).unwrap();
        let off = if is_adobe { difference(&image, adobe, false) } else { difference(&image, |v| v.map(srgb), false) };
        assert!(off < 0.03 && found.contains("Adobe RGB") == is_adobe, "{colour_space} {is_r03}: {off}, {found}");
        let is_uncalibrated = colour_space == 0xffff && !is_r03;
        assert_eq!(found.contains("sRGB (EXIF states an uncalibrated colour space)"), is_uncalibrated, "{found}");
        // A TIFF points to the same directory.
        let of = |at| tiff::<colortype::RGB16>(&sixteen(), &[(Tag::ExifDirectory, TagValue::Long(at))]);
        let at = of(0).len() as u32;
        let mut directories = exif(1, colour_space, is_r03)[38..].to_vec();
        directories[22..26].copy_from_slice(&(at + 30).to_le_bytes());
        let (image, in_tiff) = photograph(&[of(at), directories].concat(), "tif", None).unwrap();
        let off = if is_adobe { difference(&image, adobe, false) } else { difference(&image, |v| v.map(srgb), false) };
        assert!(off < 1e-3 && in_tiff == found, "{colour_space} {is_r03}: {off}, {in_tiff}");
    }
    let white = || (Tag::Unknown(318), TagValue::Rationals(D65.to_vec()));
    let primaries = || (Tag::Unknown(319), TagValue::Rationals(P3.concat()));
    let of = |tags: Tags<'_>| tiff::<colortype::RGB16>(&sixteen(), tags);
    let (image, found) = photograph(&of(&[white(), primaries()]), "tif", None).unwrap();
    assert!(difference(&image, |v| Stated::P3.linear(v), false) < 1e-3, "{found}");
    assert!(photograph(&of(&[white()]), "tif", None).unwrap().1.contains("sRGB (not stated)"));
    let curve = (Tag::Unknown(301), TagValue::Bytes(vec![0; 256]));
    for (tags, expected) in [
        (vec![primaries()], "PrimaryChromaticities: found 6 numbers, WhitePoint 0, expected"),
        (vec![curve], "TransferFunction: found a curve, expected an ICC profile"),
    ] {
        let error = photograph(&of(&tags), "tif", None).unwrap_err();
        assert!(error.contains(expected), "{error}");
        assert_overridden(&of(&tags), "tif", 1e-3);
    }
}

#[test]
fn clipped_pixels_are_counted() {
    for stated in [Stated::P3, Stated::Adobe, Stated::Nothing] {
        let icc = stated.profile();
        let chunks: Vec<_> = icc.iter().map(|icc| iccp(icc)).collect();
        let is_outside = |block: &usize| {
            let [x, y] = [block % BLOCKS[0] * BLOCK, block / BLOCKS[0] * BLOCK];
            let linear = stated.linear(std::array::from_fn(|c| code(x, y, c)));
            linear.iter().any(|v| !(-1e-3..=1.001).contains(v))
        };
        let blocks = BLOCKS[0] * BLOCKS[1];
        let count = (0..blocks).filter(is_outside).count();
        assert_eq!(count > 0, stated != Stated::Nothing);
        let share = 100.0 * count as f64 / blocks as f64;
        let expected = format!("{share:.3} % of the pixels lie outside the gamut of Rec. 709 and were clipped");
        for bytes in [png8(&chunks), png16(&chunks)] {
            let file = tempfile::Builder::new().suffix(".png").tempfile().unwrap();
            std::fs::write(file.path(), bytes).unwrap();
            let conversions = open_colours(Input::from(file.path())).unwrap().conversions;
            assert_eq!(conversions.get(1), Some(&expected).filter(|_| count > 0), "{stated:?} {conversions:?}");
        }
    }
}

#[test]
fn profiles_that_do_not_fit_are_refused() {
    let grey = ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
    let mut without_primaries = ColorProfile::new_adobe_rgb();
    let black = moxcms::Xyzd::default();
    let colorants = [
        &mut without_primaries.red_colorant,
        &mut without_primaries.green_colorant,
        &mut without_primaries.blue_colorant,
    ];
    colorants.into_iter().for_each(|colorant| *colorant = black);
    let mut parts = jpeg_icc(&Stated::Adobe.profile().unwrap(), 100);
    parts.remove(1);
    let broken = png8(&[(b"iCCP", b"x\0\0no stream".to_vec())]);
    for (bytes, extension, expected) in [
        (png8(&[iccp(&grey)]), "png", "ICC profile: found a profile of Gray for 3 channels, expected"),
        (png8(&[iccp(b"no profile")]), "png", "ICC profile: "),
        (
            png8(&[iccp(&without_primaries.encode().unwrap())]),
            "png",
            "found a matrix whose white is [0.000, 0.000, 0.000]",
        ),
        (broken.clone(), "png", "ICC profile: a broken PNG chunk iCCP; expected"),
        (jpeg(&parts), "jpg", "expected all parts of the profile"),
    ] {
        let error = photograph(&bytes, extension, None).unwrap_err();
        assert!(error.contains(expected), "{error}");
        assert_overridden(&bytes, extension, if extension == "jpg" { 0.03 } else { 1e-3 });
    }
    // Numbers have no colour.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, broken).unwrap();
    assert!(open_colours(Input::File(path.clone())).is_err());
    assert_eq!(open_shares(Input::File(path)).unwrap().conversions, ["stored values"]);
}

#[test]
fn images_are_turned_upright() {
    for orientation in 1..=8 {
        let exif = exif(orientation, 1, false);
        let tags = [(Tag::Orientation, TagValue::Short(orientation))];
        let files = [
            ("png", png8(&[(b"eXIf", exif.clone())]), 1e-6),
            ("jpg", jpeg(&[jpeg_exif(exif)]), 0.03),
            ("tif", tiff::<colortype::RGB8>(&eight(), &tags), 1e-6),
        ];
        for (extension, bytes, tolerance) in files {
            let (image, found) = photograph(&bytes, extension, None).unwrap();
            let size = if orientation >= 5 { [SIZE[1], SIZE[0]] } else { SIZE };
            assert_eq!([image.width, image.height], size, "{extension} {orientation}");
            assert_eq!(found.contains(&format!("orientation {orientation} (")), orientation > 1, "{found}");
            for (at, pixel) in image.pixels.iter().enumerate() {
                let [x, y] = place(orientation, [at % size[0], at / size[0]]);
                let off = (0..3).map(|c| (f64::from(pixel[c]) - srgb(code(x, y, c))).abs()).fold(0.0, f64::max);
                assert!(off < tolerance, "{extension} {orientation}: {off} at {at}");
            }
        }
    }
    // Some writers store the orientation as LONG.
    let long = b"MM\0*\0\0\0\x08\0\x01\x01\x12\0\x04\0\0\0\x01\0\0\0\x06\0\0\0\0";
    let (_, found) = photograph(&jpeg(&[jpeg_exif(long.to_vec())]), "jpg", None).unwrap();
    assert!(found.contains("orientation 6 ("), "{found}");
    // EXIF may follow the pixels.
    let (with, without) = (png8(&[(b"eXIf", exif(3, 1, false))]), png8(&[]));
    let (head, tail) = without.split_at(without.len() - 12);
    let late = [head, &with[33..33 + 12 + exif(3, 1, false).len()], tail].concat();
    assert_eq!(photograph(&late, "png", None).unwrap().0, photograph(&with, "png", None).unwrap().0);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.png"), png8(&[(b"eXIf", exif(1, 1, false))])).unwrap();
    std::fs::write(folder.path().join("b.png"), png8(&[(b"eXIf", exif(3, 1, false))])).unwrap();
    std::fs::write(folder.path().join("a.lp"), "2\na.png 0 0 1\nb.png 0 .6 .8\n").unwrap();
    let error = RtiCapture::open(folder.path()).unwrap_err().to_string();
    assert!(
        error.contains("b.png: orientation: found 3 (turned by 180°), expected 1 (upright), that of a.png"),
        "{error}"
    );
}

#[test]
fn mixed_colours_are_converted_each_by_its_own() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.png"), png8(&[])).unwrap();
    std::fs::write(folder.path().join("b.png"), png8(&[gama(1.0)])).unwrap();
    std::fs::write(folder.path().join("a.lp"), "2\na.png 0 0 1\nb.png 0 .6 .8\n").unwrap();
    let capture = RtiCapture::open(folder.path()).unwrap();
    assert!(difference(&capture.image(0).unwrap(), |v| v.map(srgb), false) < 1e-6);
    assert!(difference(&capture.image(1).unwrap(), |v| v, false) < 1e-4);
    let expected =
        "the images state different colours: gAMA 1, linear (1 of 2 images); sRGB (not stated) (1 of 2 images)";
    assert_eq!(capture.notes(), [expected]);
    // Three bytes per pixel of sRGB levels, and six of others.
    assert_eq!(capture.bytes(), (9 * SIZE[0] * SIZE[1]) as u64);
}
