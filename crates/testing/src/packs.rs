//! Helpers for tests of packs.
use brdfc_formats::FormatError;
use brdfc_formats::container::{Extent, MAX_TEXEL_BYTES, PackedTexture, TexelFormat, Texture, seal};
use brdfc_formats::crop::{Crop, DirectionRange, Elevations, Window};
use brdfc_formats::direction::DirectionPair;
use std::collections::BTreeMap;

/// Pseudo-random numbers that are the same on every run.
pub struct Numbers(u64);

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 32) as u32
    }

    /// Number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / 4_294_967_296.0
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

/// A crop of made-up directions.
pub(crate) fn crop(window: Window) -> Crop {
    let directions =
        DirectionRange { light: Elevations { from: 10.0, to: 80.0 }, view: Elevations { from: 0.0, to: 45.0 } };
    Crop { directions, window }
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
            // Some chains go down to a single texel. Some sides are odd, or reach 1 long before the other side.
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
/// Returns the error of the container.
pub fn read_texture(bytes: &[u8]) -> Result<Texture, FormatError> {
    PackedTexture::from_bytes(bytes)?.unpack_levels(MAX_TEXEL_BYTES)
}

/// Changed bytes of a pack with a valid checksum, so that a reader checks the rest.
pub fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    seal(&mut bytes);
    bytes
}

/// Key of a pack's bindings.
pub const BINDINGS_ENTRY: &str = "brdfc.bindings";

/// Replaces text in the bindings of a pack.
///
/// # Panics
/// If there are no bindings with the old text.
pub fn rebind(texture: &mut Texture, old: &str, new: &str) {
    let list = texture.entries.get_mut(BINDINGS_ENTRY).expect("a pack has bindings");
    let text = String::from_utf8(std::mem::take(list)).expect("bindings are text");
    assert!(text.contains(old), "no '{old}' in {text}");
    *list = text.replace(old, new).into_bytes();
}

/// Changes the image of a binding, a file in an entry.
///
/// # Panics
/// If there is no such image.
pub fn change_image(texture: &mut Texture, name: &str, change: impl FnOnce(&mut Texture)) {
    let entry = texture.entries.get_mut(&format!("brdfc.image.{name}")).expect("the entry of an image");
    let mut image = read_texture(entry).expect("our own image");
    change(&mut image);
    *entry = image.to_bytes(false);
}

/// A random direction, at most slightly below the horizon.
pub fn unit_vector(numbers: &mut Numbers) -> [f32; 3] {
    let (z, azimuth) = (numbers.between(-0.2, 1.0), numbers.between(0.0, 6.3));
    let sine = (1.0 - z * z).sqrt();
    [sine * azimuth.cos(), sine * azimuth.sin(), z].map(|c| c as f32)
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

/// Checks every line of a page's hex dumps against the bytes. Returns the number of lines.
///
/// Prints the dump, to be copied to the page if a test fails.
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
