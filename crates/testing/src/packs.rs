//! What several tests of packs share. Each of them uses only a part.
use brdfc_formats::container::{Extent, MAX_TEXEL_BYTES, PackedTexture, TexelFormat, Texture, seal};
use brdfc_formats::crop::{Crop, DirectionRange, Elevations, Window};
use brdfc_formats::direction::{DirectionPair, Parameterisation};
use brdfc_formats::table::{Axes, Curve, KNOTS, TableHeader, TablePack, TableSymmetry};
use brdfc_formats::wavelet::{Filter, Header, SliceScale, WaveletDecoder, WaveletPack};
use brdfc_formats::{ErrorSummary, FormatError};
use std::collections::BTreeMap;

/// Numbers that are the same on every run.
pub struct Numbers(u64);

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// In `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / 4_294_967_296.0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

pub fn header(parameterisation: Parameterisation, levels: u32, channels: u32, bits: u32) -> Header {
    Header { parameterisation, levels, stored_levels: levels, channels, bits, mean: 0.25, bias: 0.01, lifted: false }
}

/// That of a pack whose coarser cells keep the light.
pub fn lifted(levels: u32, channels: u32, bits: u32) -> Header {
    Header { lifted: true, ..header(Parameterisation::TangentPole, levels, channels, bits) }
}

/// A pack with made-up slices: `kept` coefficients, spread over the tree, with random texels and scales that keep
/// values in a sensible range.
pub fn pack(header: Header, kept: usize, seed: u64) -> WaveletPack {
    let mut numbers = Numbers::new(seed);
    let cells = header.cells();
    let stored = 1usize << (2 * header.stored_levels);
    assert!((1..=stored).contains(&kept));
    let mut index = vec![0u16; cells];
    let mut next = 0;
    for coefficient in 0..stored {
        // Evenly spread; the scaling coefficient comes first.
        if coefficient * kept / stored >= next || coefficient == 0 {
            next += 1;
            index[coefficient] = next as u16;
        }
    }
    let slices = next + 1;
    let scales = (0..slices)
        .map(|slice| match slice {
            0 => SliceScale::default(),
            1 => SliceScale { scale: (2.5 * header.grid() as f64) as f32, offset: -2.0 },
            _ => {
                let half = numbers.between(0.05, 1.0);
                SliceScale { scale: 2.0 * half as f32, offset: numbers.between(-1.2, -0.8) as f32 * half as f32 }
            }
        })
        .collect();
    let summary = |numbers: &mut Numbers| ErrorSummary {
        samples: numbers.bits(),
        rms: numbers.unit() as f32,
        relative_mean: numbers.unit() as f32,
        relative_p95: numbers.unit() as f32,
        relative_p99: numbers.unit() as f32,
        relative_max: numbers.unit() as f32,
        log_rms: numbers.unit() as f32,
        cosine_log_rms: numbers.unit() as f32,
        albedo_max_difference: numbers.unit() as f32,
        reciprocity: numbers.unit() as f32,
    };
    let (on_grid, off_grid) = (summary(&mut numbers), summary(&mut numbers));
    let texel_bytes = header.texel_format().texel_bytes();
    let mut texels = vec![0u8; slices * cells * texel_bytes];
    for texel in texels[cells * texel_bytes..].chunks_exact_mut(texel_bytes) {
        let colours = if header.channels == 1 { texel_bytes } else { texel_bytes / 4 * 3 };
        texel[colours..].fill(0xff);
        texel[..colours].fill_with(|| numbers.bits() as u8);
    }
    WaveletPack { header, index, scales, on_grid, off_grid, crop: None, texels }
}

/// Packs of every texel format, both parameterisations, several sizes, down to two slices.
pub fn packs() -> Vec<(String, WaveletPack)> {
    let mut packs = Vec::new();
    for levels in 1..=5u32 {
        for channels in [1, 3] {
            for bits in [8, 12, 16] {
                for kept in [1, 2, 3, 1 << levels] {
                    let seed = packs.len() as u64;
                    let parameterisation = Parameterisation::NAMES[(levels + bits / 4) as usize % 2].1;
                    let made = pack(header(parameterisation, levels, channels, bits), kept, seed);
                    packs.push((format!("levels {levels}, channels {channels}, bits {bits}, kept {kept}"), made));
                }
            }
        }
    }
    for (levels, channels, bits) in [(1, 1, 16), (2, 3, 12), (4, 3, 8), (5, 1, 8), (6, 3, 16)] {
        let made = pack(lifted(levels, channels, bits), 1 << levels, packs.len() as u64);
        packs.push((format!("lifted, levels {levels}, channels {channels}, bits {bits}"), made));
    }
    let cropped = packs.iter().enumerate().filter(|(k, _)| k % 9 == 5).map(|(k, (name, pack))| {
        let grid = pack.header.grid() as u32;
        let first = [k as u32 % grid, k as u32 / 3 % grid];
        let size = [0, 1].map(|axis| 1 + (k as u32 + axis as u32) % (grid - first[axis]));
        (format!("{name}, cropped"), pack.cropped(crop(Window { first, size })).expect("within the grid"))
    });
    let cropped: Vec<_> = cropped.collect();
    packs.extend(cropped);
    packs
}

/// A crop of made-up directions.
fn crop(window: Window) -> Crop {
    let directions =
        DirectionRange { light: Elevations { from: 10.0, to: 80.0 }, view: Elevations { from: 0.0, to: 45.0 } };
    Crop { directions, window }
}

/// Tables of both formats and every symmetry, with random texels; then some with a curve.
pub fn tables() -> Vec<(String, TablePack)> {
    let mut packs = Vec::new();
    for bits in 0..16 {
        let symmetry = TableSymmetry::from_bits(bits).expect("four bits");
        for layers in [1, 3] {
            if layers == 1 && bits > 3 {
                continue;
            }
            let axes = Axes { half: 5 + bits, difference: 4, azimuth: 2 + bits % 3, layers };
            let mut numbers = Numbers::new(u64::from(16 * bits + layers));
            let mut knots = [0.0f32; KNOTS];
            for k in 1..KNOTS {
                knots[k] = knots[k - 1] + numbers.between(0.01, 0.1) as f32;
            }
            let last = knots[KNOTS - 1];
            knots = knots.map(|knot| knot / last);
            let header = TableHeader {
                channels: if bits % 2 == 0 { 3 } else { 1 },
                symmetry,
                axes,
                mean: 0.25,
                bias: 1e-4,
                low: [-3.0, -2.5, -2.0],
                span: [5.0, 4.0, 4.5],
                slope: numbers.between(-0.5, 0.6) as f32,
                knots,
            };
            let count = axes.half * axes.difference * axes.azimuth * axes.layers;
            let mut value = || std::array::from_fn(|_| numbers.unit() as f32);
            let values: Vec<[f32; 3]> = (0..count).map(|_| value()).collect();
            let pack = TablePack::new(header, &values).expect("in range");
            packs.push((format!("symmetry {bits}, layers {layers}"), pack));
        }
    }
    let factored = |(name, pack): (String, TablePack)| {
        let levels = if pack.header().symmetry.bits() == 3 { 0 } else { 3 };
        let mut numbers = Numbers::new(packs.len() as u64);
        let count = 9 * (levels + 1);
        let values: Vec<[f32; 3]> =
            (0..count).map(|_| std::array::from_fn(|_| numbers.between(-1.0, 2.0) as f32)).collect();
        let curve = Curve::new(pack.header().channels, levels, &values).expect("in range");
        (format!("{name}, curve"), pack.with_curve(curve).expect("of the same format"))
    };
    let names = ["symmetry 0, layers 1", "symmetry 3, layers 1", "symmetry 15, layers 3"];
    let plain = packs.iter().filter(|(name, _)| names.contains(&name.as_str())).cloned();
    let factored: Vec<_> = plain.map(factored).collect();
    packs.extend(factored);
    let cropped = packs.iter().enumerate().filter(|(k, _)| k % 4 == 1).map(|(k, (name, pack))| {
        let [columns, rows, _] = pack.extent();
        let window = Window { first: [k as u32 % (columns - 1), k as u32 % 3], size: [2, rows - k as u32 % 3] };
        (format!("{name}, cropped"), pack.cropped(crop(window)).expect("within the texture"))
    });
    let cropped: Vec<_> = cropped.collect();
    packs.into_iter().chain(cropped).collect()
}

/// Textures of every format and kind, some with mipmap levels, with random texels.
pub fn textures() -> Vec<(String, Texture)> {
    let mut textures = Vec::new();
    for format in TexelFormat::ALL {
        let extents = [
            (Extent::D2([1, 1]), 1),
            (Extent::D2([5, 3]), 1),
            (Extent::D2Array([2, 3, 1]), 1),
            (Extent::D2Array([3, 2, 4]), 1),
            (Extent::D3([3, 2, 5]), 1),
            // Down to a single texel, or not; sides that are odd, that are halved to 1 long before the other is.
            (Extent::D2([5, 3]), 3),
            (Extent::D2([4, 4]), 2),
            (Extent::D2([1, 9]), 4),
            (Extent::D2Array([7, 3, 3]), 3),
            (Extent::D2Array([2, 2, 1]), 2),
            (Extent::D3([3, 2, 5]), 3),
        ];
        for (extent, levels) in extents {
            let mut numbers = Numbers::new(textures.len() as u64);
            let mut texels = vec![0; extent.texels_of_levels(levels) as usize * format.texel_bytes()];
            texels.fill_with(|| numbers.bits() as u8);
            let note = vec![7; textures.len() % 5];
            let entries = BTreeMap::from([("brdfc.note".to_owned(), note), ("brdfc.other".to_owned(), vec![1, 0])]);
            let name = format!("{format:?}, {extent}, levels {levels}");
            textures.push((name, Texture { format, extent, entries, levels, texels }));
        }
    }
    textures
}

/// A texture with as many levels as its file has.
///
/// # Errors
/// Those of the container.
pub fn read_texture(bytes: &[u8]) -> Result<Texture, FormatError> {
    PackedTexture::from_bytes(bytes)?.unpack_levels(MAX_TEXEL_BYTES)
}

/// Changed bytes of a pack with the checksum that they need: a reader looks at what is behind it.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    seal(&mut bytes);
    bytes
}

/// The entry of a pack's bindings.
pub const BINDINGS_ENTRY: &str = "brdfc.bindings";

/// Puts other text into the bindings of a pack.
///
/// # Panics
/// When there are no bindings with the old text.
pub fn rebind(texture: &mut Texture, old: &str, new: &str) {
    let list = texture.entries.get_mut(BINDINGS_ENTRY).expect("a pack has bindings");
    let text = String::from_utf8(std::mem::take(list)).expect("bindings are text");
    assert!(text.contains(old), "no '{old}' in {text}");
    *list = text.replace(old, new).into_bytes();
}

/// Changes the image of a binding, a file in an entry.
///
/// # Panics
/// When there is no such image.
pub fn change_image(texture: &mut Texture, name: &str, change: impl FnOnce(&mut Texture)) {
    let entry = texture.entries.get_mut(&format!("brdfc.image.{name}")).expect("the entry of an image");
    let mut image = read_texture(entry).expect("our own image");
    change(&mut image);
    *entry = image.to_bytes(false);
}

/// The pack whose bytes stand in `formats/src/container/spec.md` and `formats/src/wavelet/spec.md`.
pub fn example() -> WaveletPack {
    let header = Header {
        parameterisation: Parameterisation::HalfDifference,
        levels: 1,
        stored_levels: 1,
        channels: 1,
        bits: 8,
        mean: 0.5,
        bias: 0.01,
        lifted: false,
    };
    let summary = ErrorSummary { samples: 16, rms: 0.25, reciprocity: 0.125, ..ErrorSummary::default() };
    WaveletPack {
        header,
        index: vec![1, 0, 2, 0],
        scales: vec![
            SliceScale::default(),
            SliceScale { scale: 2.0, offset: -1.0 },
            SliceScale { scale: 0.5, offset: -0.25 },
        ],
        on_grid: summary,
        off_grid: summary,
        crop: None,
        texels: vec![0, 0, 0, 0, 0, 85, 170, 255, 255, 170, 85, 0],
    }
}

/// Directions all over the hemisphere, some close to its borders.
pub fn pairs(count: usize, seed: u64) -> Vec<DirectionPair> {
    let mut numbers = Numbers::new(seed);
    let mut angles = || (numbers.between(0.0, 1.57), numbers.between(-3.2, 3.2));
    (0..count)
        .map(|_| {
            let ((theta_i, phi_i), (theta_o, phi_o)) = (angles(), angles());
            DirectionPair::from_angles(theta_i, phi_i, theta_o, phi_o)
        })
        .collect()
}

/// Reads bytes, whatever their checksum is, and where they are a pack decodes it here and there: whatever a file holds, `f_r`
/// is a number.
pub fn survives(bytes: &[u8]) -> bool {
    let Ok(pack) = WaveletPack::from_bytes(&sealed(bytes.to_vec())) else { return false };
    let decoder = WaveletDecoder::new(&pack);
    for (k, pair) in pairs(3, 5).into_iter().enumerate() {
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let value = decoder.eval(pair, [9.0, 0.5, 1.25][k], filter);
            assert!(value.iter().all(|v| v.is_finite() && *v >= 0.0), "{value:?}");
        }
    }
    true
}

/// Checks every line of a page's hex dumps against the bytes they show; returns the number of lines.
///
/// Prints the dump, to be put on the page where a test fails.
pub fn check_dump(page: &str, bytes: &[u8]) -> usize {
    for (line, chunk) in bytes.chunks(16).enumerate() {
        let hex: Vec<String> = chunk.iter().map(|byte| format!("{byte:02x}")).collect();
        let text: String = chunk.iter().map(|b| if (0x20..0x7f).contains(b) { char::from(*b) } else { '.' }).collect();
        println!("{:08x}  {:47}  {text}", 16 * line, hex.join(" "));
    }
    let mut lines = 0;
    for line in page.lines() {
        let Some((offset, rest)) = line.split_once("  ") else { continue };
        let Ok(offset) = usize::from_str_radix(offset, 16) else { continue };
        let hex: Vec<u8> =
            rest.split("  ").next().unwrap().split(' ').map(|b| u8::from_str_radix(b, 16).unwrap()).collect();
        assert_eq!(hex, bytes[offset..offset + hex.len()], "line {offset:#x}");
        lines += 1;
    }
    lines
}
