//! Layouts of samples, pages and channels, and files that lack pixels.

use super::*;

#[test]
fn pages_and_sample_formats_of_tiff_are_those_that_fields_name() {
    for (tag, value, is_full) in
        [(Tag::NewSubfileType, 1, false), (Tag::NewSubfileType, 4, false), (Tag::NewSubfileType, 2, true)]
    {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
        tiff_page::<colortype::RGB8>(&mut encoder, [2, 2], &[7; 12], &[(tag, TagValue::Long(value))]);
        tiff_page::<colortype::RGB8>(&mut encoder, SIZE, &eight(), &[]);
        let (image, found) = photograph(&bytes.into_inner(), "tif", None).unwrap();
        let size = if is_full { [2, 2] } else { SIZE };
        assert_eq!([image.width, image.height], size, "{value}: {found}");
        assert_eq!(found.contains("page 2"), !is_full, "{found}");
    }
    let only = tiff::<colortype::RGB8>(&eight(), &[(Tag::NewSubfileType, TagValue::Long(1))]);
    assert!(photograph(&only, "tif", None).unwrap_err().contains("found a TIFF of reduced images or masks only"));

    let words: Vec<u32> = codes(|v| (4_294_967_295.0 * v) as u32);
    let mut integers = tiff::<colortype::RGB32>(&words, &[]);
    let error = photograph(&integers, "tif", None).unwrap_err();
    assert!(error.contains("TIFF samples: found Uint of 32 bits (SampleFormat), expected grey or RGB of"), "{error}");
    // Without the field, samples are unsigned integers.
    let field = [339u16.to_le_bytes(), 3u16.to_le_bytes()].concat();
    let at = integers.windows(4).position(|window| window == field).unwrap();
    integers[at..at + 2].copy_from_slice(&65000u16.to_le_bytes());
    assert!(photograph(&integers, "tif", None).unwrap_err().contains("found Uint of 32 bits"));
    let signed: Vec<i16> = codes(|v| (32767.0 * v) as i16);
    let error = photograph(&tiff::<colortype::GrayI16>(&signed[..SIZE[0] * SIZE[1]], &[]), "tif", None).unwrap_err();
    assert!(error.contains("found Int of 16 bits (SampleFormat)"), "{error}");
    let doubles: Vec<f64> = codes(|v| v);
    let (grey, _) =
        photograph(&tiff::<colortype::Gray64Float>(&doubles[..SIZE[0] * SIZE[1]], &[]), "tif", None).unwrap();
    assert!(grey.pixels.iter().zip(&doubles).all(|(pixel, v)| *pixel == [*v as f32; 3]));
    let cmyk = tiff::<colortype::CMYK8>(&[0; 4 * SIZE[0] * SIZE[1]], &[]);
    assert!(photograph(&cmyk, "tif", None).unwrap_err().contains("TIFF samples: found CMYK(8)"));
}

/// A TIFF of fields of 16 bits, by default of 8-bit RGB, whose strips or tiles are `parts`.
fn raw_tiff(is_big: bool, fields: &[(u16, &[u16])], parts: &[Vec<u8>]) -> Vec<u8> {
    let short = |v: u16| if is_big { v.to_be_bytes() } else { v.to_le_bytes() };
    let long = |v: usize| if is_big { (v as u32).to_be_bytes() } else { (v as u32).to_le_bytes() };
    let [width, height] = SIZE.map(|side| side as u16);
    let default: [(u16, &[u16]); 7] =
        [(256, &[width]), (257, &[height]), (258, &[8]), (259, &[1]), (262, &[2]), (277, &[3]), (278, &[height])];
    let is_tiled = fields.iter().any(|(tag, _)| *tag == 322);
    let all: BTreeMap<u16, &[u16]> = default.into_iter().chain(fields.iter().copied()).collect();
    let all = all.into_iter().filter(|(tag, _)| *tag != 278 || !is_tiled);
    let mut entries: Vec<(u16, u16, usize, Vec<u8>)> =
        all.map(|(tag, values)| (tag, 3, values.len(), values.iter().flat_map(|v| short(*v)).collect())).collect();
    let [offsets, lengths] = if is_tiled { [324, 325] } else { [273, 279] };
    let of_lengths = parts.iter().flat_map(|part| long(part.len())).collect();
    entries.push((lengths, 4, parts.len(), of_lengths));
    entries.push((offsets, 4, parts.len(), vec![0; 4 * parts.len()]));
    entries.sort_by_key(|entry| entry.0);
    // Values of more than four bytes follow the directory, and the parts follow them.
    let values_at = 8 + 2 + 12 * entries.len() + 4;
    let values: usize = entries.iter().map(|entry| entry.3.len()).filter(|length| *length > 4).sum();
    let mut at = values_at + values;
    let mut offsets_of_parts = Vec::new();
    for part in parts {
        offsets_of_parts.extend(long(at));
        at += part.len();
    }
    entries.iter_mut().filter(|entry| entry.0 == offsets).for_each(|entry| entry.3.clone_from(&offsets_of_parts));
    let mut bytes = [if is_big { &b"MM\0*"[..] } else { b"II*\0" }, &long(8), &short(entries.len() as u16)].concat();
    let mut after = Vec::new();
    for (tag, kind, count, mut value) in entries {
        bytes.extend([&short(tag)[..], &short(kind), &long(count)].concat());
        if value.len() > 4 {
            bytes.extend(long(values_at + after.len()));
            after.append(&mut value);
        } else {
            value.resize(4, 0);
            bytes.append(&mut value);
        }
    }
    [bytes, vec![0; 4], after, parts.concat()].concat()
}

/// Part of the image from a corner, with 0 outside, as bytes of some channels.
fn part([left, top]: [usize; 2], [width, height]: [usize; 2], of: impl Fn([u8; 3]) -> Vec<u8>) -> Vec<u8> {
    let places = (0..width * height).map(|at| [left + at % width, top + at / width]);
    let level =
        |x: usize, y: usize, c| if x < SIZE[0] && y < SIZE[1] { (255.0 * code(x, y, c)).round() as u8 } else { 0 };
    places.flat_map(|[x, y]| of([0, 1, 2].map(|c| level(x, y, c)))).collect()
}

/// Parts of a size, row by row.
fn parts(size: [usize; 2], of: impl Fn([u8; 3]) -> Vec<u8>) -> Vec<Vec<u8>> {
    let count = [0, 1].map(|k| SIZE[k].div_ceil(size[k]));
    (0..count[0] * count[1]).map(|k| part([k % count[0] * size[0], k / count[0] * size[1]], size, &of)).collect()
}

fn compressed<C: colortype::ColorType>(
    samples: &[C::Inner],
    compression: tiff::encoder::Compression,
    predictor: tiff::tags::Predictor,
) -> Vec<u8>
where
    [C::Inner]: tiff::encoder::TiffValue,
{
    let mut bytes = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut bytes).unwrap().with_compression(compression).with_predictor(predictor);
    tiff_page::<C>(&mut { encoder }, SIZE, samples, &[]);
    bytes.into_inner()
}

/// Rows of floats with the predictor of floating-point numbers: planes of bytes, then differences.
fn predicted_floats() -> Vec<u8> {
    let floats: Vec<f32> = codes(|v| v as f32);
    let row = |row: &[f32]| {
        let planes: Vec<u8> = (0..4).flat_map(|k| row.iter().map(move |v| v.to_be_bytes()[k])).collect();
        (0..planes.len()).map(|k| planes[k].wrapping_sub(if k < 3 { 0 } else { planes[k - 3] })).collect::<Vec<_>>()
    };
    floats.chunks(3 * SIZE[0]).flat_map(row).collect()
}

#[test]
fn layouts_of_samples_are_read() {
    use png::{BitDepth, ColorType};
    use tiff::encoder::{Compression, DeflateLevel};
    use tiff::tags::Predictor;
    let rgb = |v: [f64; 3]| v.map(srgb);
    let grey = |v: [f64; 3]| [srgb(v[0]); 3];
    let linear = |v: [f64; 3]| v;
    let gamma = |v: [f64; 3]| [v[0].powf(2.2); 3];
    // Big-endian numbers near 257 times the level, of two different bytes.
    let wide_level = |v: u8| [v, v ^ 1];
    let wide = |v: [u8; 3]| v.into_iter().flat_map(wide_level).collect();
    let plane = |c: usize| move |v: [u8; 3]| vec![v[c]];
    let wide_plane = |c: usize| move |v: [u8; 3]| wide_level(v[c]).to_vec();
    let with = |alpha: u8| move |v: [u8; 3]| [&v[..], &[alpha]].concat();
    let planes = |size| [0, 1, 2].map(|c| parts(size, plane(c))).concat();
    let wide_planes = [0, 1, 2].map(|c| parts([SIZE[0], 10], wide_plane(c)));
    // The last strip has two rows.
    let wide_planes = wide_planes.map(|mut plane| {
        plane[3].truncate(2 * 2 * SIZE[0]);
        plane
    });
    let mut jpeg = Cursor::new(Vec::new());
    let levels = part([0, 0], SIZE, plane(0));
    image::GrayImage::from_raw(SIZE[0] as u32, SIZE[1] as u32, levels.clone())
        .unwrap()
        .write_to(&mut jpeg, image::ImageFormat::Jpeg)
        .unwrap();
    let tile: [(u16, &[u16]); 2] = [(322, &[32]), (323, &[16])];
    let grey_profile = ColorProfile::new_gray_with_gamma(2.2).encode().unwrap();
    let palette: Vec<u8> = parts([BLOCK; 2], |v| v.to_vec()).iter().flat_map(|block| block[..3].to_vec()).collect();
    let index: Vec<u8> =
        (0..SIZE[0] * SIZE[1]).map(|at| (at / SIZE[0] / BLOCK * BLOCKS[0] + at % SIZE[0] / BLOCK) as u8).collect();
    let grey_alpha = part([0, 0], SIZE, |v| vec![v[0], 70]);
    type Case<'a> = (&'a str, &'a str, Vec<u8>, &'a dyn Fn([f64; 3]) -> [f64; 3]);
    let cases: Vec<Case<'_>> = vec![
        ("LZW", "tif", compressed::<colortype::RGB16>(&sixteen(), Compression::Lzw, Predictor::Horizontal), &rgb),
        (
            "Deflate",
            "tif",
            compressed::<colortype::RGB8>(&eight(), Compression::Deflate(DeflateLevel::Fast), Predictor::Horizontal),
            &rgb,
        ),
        ("PackBits", "tif", compressed::<colortype::RGB8>(&eight(), Compression::Packbits, Predictor::None), &rgb),
        (
            "predictor 3",
            "tif",
            raw_tiff(
                false,
                &[(258, &[32]), (259, &[8]), (317, &[3]), (339, &[3])],
                &[stored_zlib(&predicted_floats())],
            ),
            &linear,
        ),
        ("tiles", "tif", raw_tiff(false, &tile, &parts([32, 16], |v| v.to_vec())), &rgb),
        ("tiles of 16 bits", "tif", raw_tiff(true, &[tile[0], tile[1], (258, &[16])], &parts([32, 16], wide)), &rgb),
        ("planes", "tif", raw_tiff(true, &[(258, &[16]), (278, &[10]), (284, &[2])], &wide_planes.concat()), &rgb),
        (
            "a plane of tiles",
            "tif",
            raw_tiff(
                false,
                &[(322, &[32]), (323, &[48]), (262, &[1]), (277, &[1]), (284, &[2])],
                &parts([32, 48], plane(0)),
            ),
            &grey,
        ),
        ("planes of tiles", "tif", raw_tiff(false, &[tile[0], tile[1], (284, &[2])], &planes([32, 16])), &rgb),
        ("alpha", "tif", raw_tiff(true, &[(277, &[4]), (338, &[2])], &[part([0, 0], SIZE, with(70))]), &rgb),
        ("opaque", "tif", raw_tiff(false, &[(277, &[4]), (338, &[1])], &[part([0, 0], SIZE, with(255))]), &rgb),
        ("another sample", "tif", raw_tiff(false, &[(277, &[4]), (338, &[0])], &[part([0, 0], SIZE, with(70))]), &rgb),
        (
            "grey, alpha",
            "tif",
            raw_tiff(false, &[(262, &[1]), (277, &[2]), (338, &[2])], std::slice::from_ref(&grey_alpha)),
            &grey,
        ),
        ("JPEG", "tif", raw_tiff(false, &[(259, &[7]), (262, &[1]), (277, &[1])], &[jpeg.into_inner()]), &grey),
        ("palette", "png", png_of(ColorType::Indexed, &index, BitDepth::Eight, &[(b"PLTE", palette.clone())]), &rgb),
        (
            "palette, tRNS",
            "png",
            png_of(ColorType::Indexed, &index, BitDepth::Eight, &[(b"PLTE", palette), (b"tRNS", vec![9; 6])]),
            &rgb,
        ),
        ("tRNS", "png", png8(&[(b"tRNS", vec![0, 200, 0, 40, 0, 90])]), &rgb),
        ("RGBA", "png", png_of(ColorType::Rgba, &part([0, 0], SIZE, with(70)), BitDepth::Eight, &[]), &rgb),
        ("grey, alpha", "png", png_of(ColorType::GrayscaleAlpha, &grey_alpha, BitDepth::Eight, &[]), &grey),
        ("grey profile", "png", png_of(ColorType::Grayscale, &levels, BitDepth::Eight, &[iccp(&grey_profile)]), &gamma),
    ];
    for (name, extension, bytes, expected) in &cases {
        let (image, found) = photograph(bytes, extension, None).unwrap_or_else(|error| panic!("{name}: {error}"));
        let off = difference(&image, expected, false);
        assert!(off < if *name == "JPEG" { 0.03 } else { 1e-3 }, "{extension} {name}: {off}, {found}");
    }

    let four = |fields: &[(u16, &[u16])], parts: &[Vec<u8>]| {
        raw_tiff(false, &[&[(277, &[4][..]), (338, &[0])], fields].concat(), parts)
    };
    let mut swapped = parts([SIZE[0], 16], |v| v.to_vec());
    let moved = swapped[0].pop().unwrap();
    swapped[1].push(moved);
    let whole = |alpha| vec![part([0, 0], SIZE, with(alpha))];
    for (bytes, expected) in [
        (
            four(&[(259, &[8]), (317, &[2])], &[stored_zlib(&whole(70)[0])]),
            "SamplesPerPixel: found 4 in rows with a predictor, expected 3, or plain strips",
        ),
        (four(&tile, &parts([32, 16], with(70))), "SamplesPerPixel: found 4 in tiles, expected 3, or plain strips"),
        (
            raw_tiff(false, &[(322, &[32]), (323, &[48]), (284, &[2])], &planes([32, 48])),
            "PlanarConfiguration: found separate planes (2) in tiles of 48 rows, expected a divisor of 32 rows",
        ),
        (four(&[(338, &[1])], &whole(70)), "found colours multiplied by alpha, with alpha below 1 at (0, 0), expected"),
        (four(&[(317, &[2])], &whole(70)), "Predictor: found a predictor of uncompressed data, expected 1 (none)"),
        (four(&[(266, &[2])], &whole(70)), "FillOrder: found 2 (lowest bit first), expected 1"),
        (raw_tiff(false, &[(278, &[16])], &swapped), "strip or tile 1 of 2303 bytes instead of 2304"),
        (raw_tiff(false, &[(259, &[7]), (262, &[6])], &[self::jpeg(&[])]), "TIFF samples: found YCbCr(8)"),
    ] {
        let error = photograph(&bytes, "tif", None).map(drop).expect_err(expected);
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn shares_are_not_converted_and_are_upright() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, png16(&[gama(1.0), (b"eXIf", exif(3, 1, false))])).unwrap();
    let shares = open_shares(Input::File(path.clone())).unwrap();
    let colours = open_colours(Input::File(path)).unwrap();
    for (at, (share, colour)) in shares.pixels.iter().zip(&colours.pixels).enumerate() {
        let [x, y] = place(3, [at % SIZE[0], at / SIZE[0]]);
        assert!((0..3).all(|c| (f64::from(share[c]) - code(x, y, c)).abs() < 1e-5) && share[3] == 0.0);
        assert!((0..3).all(|c| (f64::from(colour[c]) - code(x, y, c)).abs() < 1e-4));
    }
    assert_eq!(shares.conversions, ["stored values", "orientation 3 (turned by 180°)"]);
}

/// A progressive JPEG of 35 x 27 pixels of libjpeg: 4:2:0, spectral selection and successive approximation.
const PROGRESSIVE: &[u8] = include_bytes!("../progressive.jpg");

#[test]
fn images_that_lost_data_are_refused() {
    let noise = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([x * 61, y * 99, x * y].map(|v| v as u8)));
    let mut baseline = Cursor::new(Vec::new());
    noise.write_to(&mut baseline, image::ImageFormat::Jpeg).unwrap();
    for jpeg in [baseline.get_ref(), PROGRESSIVE] {
        assert!(photograph(jpeg, "jpg", None).is_ok());
        let scan = jpeg.windows(2).position(|pair| pair == [0xff, 0xda]).unwrap() + 14;
        let frame = jpeg.windows(2).position(|pair| matches!(pair, [0xff, 0xc0 | 0xc2])).unwrap();
        let end = jpeg.len() - 2;
        for tenth in 1..10 {
            let cut = scan + (end - scan) * tenth / 10;
            for lost in [&b""[..], &vec![0; end - cut]] {
                let broken = [&jpeg[..cut], lost, b"\xff\xd9"].concat();
                // The decoder itself accepts most of these.
                let error = photograph(&broken, "jpg", None).expect_err("a cut image");
                assert!(error.contains("truncated") || error.contains("invalid"), "{tenth}: {error}");
            }
        }
        let mut large = jpeg.to_vec();
        large[frame + 5..frame + 9].copy_from_slice(&[0x20, 0, 0x20, 0]);
        let error = photograph(&large, "jpg", None).unwrap_err();
        assert!(error.contains("the JPEG of 8192 x 8192 pixels is truncated or broken"), "{error}");
    }
    // Rows of a PNG whose checksums are right.
    let mut rows = Vec::new();
    let mut encoder = png::Encoder::new(&mut rows, SIZE[0] as u32, SIZE[1] as u32 / 2);
    encoder.set_color(png::ColorType::Rgb);
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&eight()[..SIZE[0] * SIZE[1] * 3 / 2]).unwrap();
    writer.finish().unwrap();
    // The header of the whole image, and the pixels of half of it.
    let half = [&png8(&[])[..33], &rows[33..]].concat();
    let error = photograph(&half, "png", None).unwrap_err();
    assert!(error.contains("not have enough data for image"), "{error}");
    // The lengths of strips of a TIFF, and the strips.
    let whole = tiff::<colortype::RGB8>(&eight(), &[]);
    let field = [279u16.to_le_bytes(), 4u16.to_le_bytes()].concat();
    let at = whole.windows(4).position(|window| window == field).unwrap();
    let count = u32::from_le_bytes(whole[at + 4..at + 8].try_into().unwrap());
    let place = u32::from_le_bytes(whole[at + 8..at + 12].try_into().unwrap()) as usize;
    let lengths = if count == 1 { at + 8 } else { place };
    let mut short = whole.clone();
    short[lengths..lengths + 4].copy_from_slice(&100u32.to_le_bytes());
    let error = photograph(&short, "tif", None).unwrap_err();
    assert!(error.contains("the TIFF is truncated"), "{error}");
    for samples in [2, SIZE[0] * 3, SIZE[0] * SIZE[1] * 3 / 2] {
        let short = tiff::<colortype::RGB8>(&eight(), &[]);
        assert!(photograph(&short[..short.len().min(8 + samples)], "tif", None).is_err(), "{samples}");
    }
}

#[test]
fn photographs_of_61_megapixels_are_read_and_larger_ones_are_not() {
    let grey = |width, height| {
        let mut bytes = Cursor::new(Vec::new());
        image::GrayImage::new(width, height).write_to(&mut bytes, image::ImageFormat::Png).unwrap();
        photograph(&bytes.into_inner(), "png", None).map(|(image, _)| [image.width, image.height])
    };
    assert_eq!(grey(9504, 64), Ok([9504, 64]));
    let error = grey(16385, 1).unwrap_err();
    assert!(error.contains("image size: found 16385 x 1, expected 1 to 16384 along each side, and at most"), "{error}");
    assert!(grey(16384, 10_000).unwrap_err().contains("found 16384 x 10000"));
}
