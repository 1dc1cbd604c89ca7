//! Packs as files.

use brdfc_formats::pwt::{Domain, LightCoordinates, PwtErrors, PwtHeader, PwtPack, TextureHeader};

/// What is worth knowing about a polynomial wavelet tree.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PwtFacts {
    /// Columns and rows of the rendering.
    pub size: [u32; 2],
    /// Whether it is a tile that repeats.
    pub repeats: bool,
    /// Coarsest mipmap level, counted from the rendering's own resolution.
    pub levels: u32,
    /// In what its terms are polynomials of the light.
    pub coordinates: LightCoordinates,
    /// Highest degree of them.
    pub degree: u32,
    /// In which scale terms are summed: linear, display, cube-root or log.
    pub domain: String,
    /// `ε` of logarithms, else 0.
    pub epsilon: f32,
    /// The textures, from the finest.
    pub textures: Vec<PwtTextureFacts>,
    /// Texture fetches of one look-up.
    pub fetches: u32,
    /// Bytes on a GPU, all levels included.
    pub gpu_bytes: u64,
    /// Errors at the photographs that it was made of; 0 lights where none were measured.
    pub errors: PwtErrors,
}

/// One of its textures.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PwtTextureFacts {
    /// How often the rendering's sides were halved for its finest texels.
    pub level: u32,
    /// Columns and rows of its finest texels.
    pub size: [u32; 2],
    /// Layers.
    pub layers: u32,
    /// Numbers of 8 bits in a texel.
    pub channels: u32,
}

impl PwtFacts {
    /// Of a pack.
    pub fn new(pack: &PwtPack) -> Self {
        let header = pack.header();
        let PwtHeader { size, repeats, levels, basis, domain, textures, errors, .. } = header.clone();
        let texture = |(index, texture): (usize, TextureHeader)| PwtTextureFacts {
            level: texture.level,
            size: header.texture_extent(index),
            layers: texture.layers(),
            channels: texture.channels,
        };
        Self {
            size,
            repeats,
            levels,
            coordinates: basis.coordinates,
            degree: basis.degree,
            domain: domain.name().to_owned(),
            epsilon: domain.code().1,
            textures: textures.into_iter().enumerate().map(texture).collect(),
            fetches: header.fetches(),
            gpu_bytes: pack.gpu_bytes(),
            errors,
        }
    }

    /// Lines for people: names and values, but for bytes.
    pub fn in_words(&self) -> Vec<(&'static str, String)> {
        let Self { size: [width, height], repeats, levels, coordinates, degree, domain, .. } = self;
        let of_texture = |texture: &PwtTextureFacts| {
            let PwtTextureFacts { level, size: [width, height], layers, channels } = texture;
            format!("level {level}: {width} x {height}, {layers} x {channels} numbers")
        };
        let tile = if *repeats { ", a tile" } else { "" };
        let domain = match domain.as_str() {
            log if log == (Domain::Logarithm { epsilon: 1.0 }).name() => format!("{log}, epsilon {:.4}", self.epsilon),
            other => other.to_owned(),
        };
        let PwtErrors { lights, psnr, held_out_psnr, delta_e } = self.errors;
        let errors = match lights {
            0 => "not measured".to_owned(),
            _ => format!("PSNR {psnr:.2} dB, mean delta E {delta_e:.2} at {lights} lights"),
        };
        let mut lines = vec![
            ("kind", "polynomial wavelet tree: a rendering under any light".to_owned()),
            ("pixels", format!("{width} x {height}{tile}, levels 0 to {levels}")),
            ("light", format!("{} coordinates, degree {degree}", coordinates.name())),
            ("domain", domain),
            ("textures", self.textures.iter().map(of_texture).collect::<Vec<_>>().join("; ")),
            ("fetches", self.fetches.to_string()),
            ("errors", errors),
        ];
        if lights > 0 && held_out_psnr != 0.0 {
            lines.push(("left out", format!("PSNR {held_out_psnr:.2} dB at lights that a fit did not see")));
        }
        lines
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use brdfc_testing::codecs::pwt::{example, packs};

    #[test]
    fn facts_of_known_packs() {
        let facts = PwtFacts::new(&example());
        assert_eq!((facts.size, facts.repeats, facts.levels, facts.degree), ([2, 2], true, 1, 1));
        assert_eq!((facts.fetches, facts.gpu_bytes, facts.errors.lights), (2, 6, 3));
        assert_eq!(facts.textures[1], PwtTextureFacts { level: 1, size: [1, 1], layers: 1, channels: 1 });
        let words =
            |facts: &PwtFacts| facts.in_words().into_iter().map(|(_, value)| value).collect::<Vec<_>>().join("\n");
        for part in
            ["2 x 2, a tile, levels 0 to 1", "projected coordinates, degree 1", "linear", "PSNR 40.00 dB", "35.00 dB"]
        {
            assert!(words(&facts).contains(part), "{part}: {}", words(&facts));
        }
        assert!(!words(&facts).contains("epsilon"));
        let mut unmeasured = facts;
        unmeasured.errors.lights = 0;
        assert!(words(&unmeasured).contains("not measured") && !words(&unmeasured).contains("PSNR"));
        let (_, log) = packs().swap_remove(2);
        let log = PwtFacts::new(&log);
        assert!(words(&log).contains("log, epsilon 0.0200") && !words(&log).contains("tile"), "{}", words(&log));
        assert!(words(&log).contains("level 1: 4 x 4, 4 x 2 numbers"), "{}", words(&log));
    }
}
