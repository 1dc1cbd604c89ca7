//! Polynomial wavelet trees with made-up texels.

use crate::packs::Numbers;
use brdfc_formats::pwt::{
    Component, Domain, LightBasis, LightCoordinates, PwtErrors, PwtHeader, PwtPack, TextureHeader,
};

/// One that repeats where `extent` is its size and `repeats` says so; grey of channel 0, weights that are the terms
/// themselves, no textures yet.
pub fn plain(size: [u32; 2], extent: [u32; 2], levels: u32, basis: LightBasis) -> PwtHeader {
    let triangle = (0..basis.terms()).flat_map(|k| (0..=k).map(move |j| if j == k { 1.0 } else { 0.0 })).collect();
    PwtHeader {
        size,
        extent,
        repeats: false,
        levels,
        basis,
        domain: Domain::Linear,
        colour: [[1.0; 3], [0.0; 3], [0.0; 3]],
        triangle,
        textures: Vec::new(),
        errors: PwtErrors { lights: 0, psnr: 0.0, held_out_psnr: 0.0, delta_e: 0.0 },
    }
}

/// A texture of one number for channel 0.
pub fn single(level: u32, term: u32, scale: f32, low: f32) -> TextureHeader {
    TextureHeader { level, channels: 1, components: vec![Component { channel: 0, term, scale, low }] }
}

/// Bytes of each texture.
pub fn lengths(header: &PwtHeader) -> Vec<usize> {
    let of = |texture: &TextureHeader| {
        let texels = (texture.level..=header.levels)
            .map(|level| header.extent.iter().map(|side| (side >> level) as usize).product::<usize>());
        texels.sum::<usize>() * texture.components.len()
    };
    header.textures.iter().map(of).collect()
}

/// A pack of any texels.
pub fn random(header: PwtHeader, seed: u64) -> PwtPack {
    let mut numbers = Numbers::new(seed);
    let texels = lengths(&header).into_iter().map(|count| (0..count).map(|_| numbers.bits() as u8).collect()).collect();
    PwtPack::new(header, texels).expect("a header in range")
}

/// A header with made-up numbers: textures by level, channels and layers.
fn any(header: PwtHeader, domain: Domain, textures: &[[u32; 3]], seed: u64) -> PwtHeader {
    let mut numbers = Numbers::new(seed);
    let terms = header.basis.terms() as u32;
    let mut between = |low, high| numbers.between(low, high) as f32;
    let triangle = header.triangle.iter().map(|diagonal| diagonal + between(-0.2, 0.2)).collect();
    let colour = [[0.0; 3]; 3].map(|axis| axis.map(|_: f32| between(-0.8, 0.8)));
    let errors = PwtErrors {
        lights: 40,
        psnr: between(20.0, 50.0),
        held_out_psnr: between(20.0, 50.0),
        delta_e: between(0.0, 5.0),
    };
    let mut count = 0;
    let textures = textures.iter().map(|[level, channels, layers]| {
        let component = |_| {
            count += 1;
            // Terms and channels in turn.
            Component { channel: count % 3, term: count / 3 % terms, scale: between(0.1, 2.0), low: between(-1.0, 0.5) }
        };
        let components = (0..channels * layers).map(component).collect();
        TextureHeader { level: *level, channels: *channels, components }
    });
    let textures = textures.collect();
    PwtHeader { domain, triangle, colour, errors, textures, ..header }
}

/// Packs of all domains and coordinates, by name: tiles and others, with one texture and more.
pub fn packs() -> Vec<(&'static str, PwtPack)> {
    let basis = |coordinates, degree| LightBasis { coordinates, degree };
    let tile = PwtHeader { repeats: true, ..plain([8, 4], [8, 4], 2, basis(LightCoordinates::Projected, 2)) };
    let odd = plain([5, 3], [8, 4], 2, basis(LightCoordinates::Hemisphere, 5));
    let coarse = plain([6, 7], [8, 8], 3, basis(LightCoordinates::Paraboloid, 1));
    let one = plain([1, 1], [1, 1], 0, basis(LightCoordinates::Paraboloid, 0));
    [
        ("tile-projected-linear", any(tile, Domain::Linear, &[[0, 4, 1], [1, 2, 3], [2, 1, 5]], 1)),
        ("odd-hemisphere-display", any(odd, Domain::Display, &[[0, 1, 2], [2, 4, 27]], 2)),
        ("coarse-paraboloid-log", any(coarse, Domain::Logarithm { epsilon: 0.02 }, &[[1, 2, 4]], 3)),
        ("one-texel-cube-root", any(one, Domain::CubeRoot, &[[0, 4, 1]], 4)),
    ]
    .into_iter()
    .zip(5..)
    .map(|((name, header), seed)| (name, random(header, seed)))
    .collect()
}

/// What the page of the layout shows: two terms of a tile of 2 x 2 texels, one of them coarse.
pub fn example() -> PwtPack {
    let basis = LightBasis { coordinates: LightCoordinates::Projected, degree: 1 };
    let textures = vec![single(0, 0, 1.0, 0.0), single(1, 1, 0.5, -0.25)];
    let errors = PwtErrors { lights: 3, psnr: 40.0, held_out_psnr: 35.0, delta_e: 0.5 };
    let header = PwtHeader { repeats: true, textures, errors, ..plain([2, 2], [2, 2], 1, basis) };
    PwtPack::new(header, vec![vec![0, 255, 51, 102, 102], vec![204]]).expect("a header in range")
}
