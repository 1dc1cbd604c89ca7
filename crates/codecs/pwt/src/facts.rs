//! Facts about polynomial wavelet trees.

use brdfc_formats::pwt::{Domain, LightCoordinates, PwtErrors, PwtHeader, PwtPack, TextureHeader};

/// Facts about a polynomial wavelet tree.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PwtFacts {
    /// Columns and rows of the image of each view.
    pub size: [u32; 2],
    /// Number of views.
    pub views: u32,
    /// True if it is a tile that repeats.
    pub repeats: bool,
    /// Coarsest mipmap level, counted from the resolution of the image.
    pub levels: u32,
    /// Terms of the light: polynomials of these coordinates, or learned terms.
    pub coordinates: LightCoordinates,
    /// Highest degree of the polynomials, or the number of learned terms without their mean.
    pub degree: u32,
    /// Scale in which terms are summed: linear, display, cube-root or log.
    pub domain: String,
    /// `ε` of logarithms, else 0.
    pub epsilon: f32,
    /// The textures, finest first.
    pub textures: Vec<PwtTextureFacts>,
    /// Texture fetches per look-up of a view, up to three times as many between views; learned terms take `degree + 1` more for each light, for the mean and each term.
    pub fetches: u32,
    /// Bytes on a GPU, all levels included.
    pub gpu_bytes: u64,
    /// Errors at the photographs that it was fitted to; 0 lights if not measured.
    pub errors: PwtErrors,
}

/// One of its textures.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct PwtTextureFacts {
    /// Number of times that the sides of the image were halved for its finest texels.
    pub level: u32,
    /// Columns and rows of its finest level.
    pub size: [u32; 2],
    /// Number of layers of each view.
    pub layers: u32,
    /// Channels of 8 bits per texel.
    pub channels: u32,
}

impl PwtFacts {
    /// Facts of a pack.
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
            views: header.view_count(),
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

    /// Summary as names and values, without bytes.
    pub fn summary(&self) -> Vec<(&'static str, String)> {
        let Self { size: [width, height], repeats, levels, coordinates, degree, domain, .. } = self;
        let of_texture = |texture: &PwtTextureFacts| {
            let PwtTextureFacts { level, size: [width, height], layers, channels } = texture;
            format!("level {level}: {width} x {height}, {layers} layers x {channels} channels")
        };
        let tile = if *repeats { ", a tile" } else { "" };
        let domain = match domain.as_str() {
            log if log == (Domain::Logarithm { epsilon: 1.0 }).name() => format!("{log}, epsilon {:.4}", self.epsilon),
            other => other.to_owned(),
        };
        let (light, fetches) = match coordinates {
            LightCoordinates::Learned => {
                let fetches = format!("{}, and {} for each light (mean and terms)", self.fetches, degree + 1);
                (format!("a mean and {degree} learned term{}", if *degree == 1 { "" } else { "s" }), fetches)
            }
            polynomial => (format!("{} coordinates, degree {degree}", polynomial.name()), self.fetches.to_string()),
        };
        let kind = match self.views {
            1 => "polynomial wavelet tree: one view under any light".to_owned(),
            views => format!("polynomial wavelet tree: {views} views under any light"),
        };
        let fetches = if self.views > 1 { format!("{fetches}; between views three times the first") } else { fetches };
        let PwtErrors { lights, psnr, held_out_psnr, delta_e } = self.errors;
        let errors = match lights {
            0 => "not measured".to_owned(),
            _ => format!("PSNR {psnr:.2} dB, mean delta E {delta_e:.2} at {lights} lights"),
        };
        let mut lines = vec![
            ("kind", kind),
            ("pixels", format!("{width} x {height}{tile}, levels 0 to {levels}")),
            ("light", light),
            ("domain", domain),
            ("textures", self.textures.iter().map(of_texture).collect::<Vec<_>>().join("; ")),
            ("fetches", fetches),
            ("errors", errors),
        ];
        if lights > 0 && held_out_psnr != 0.0 {
            lines.push(("held out", format!("PSNR {held_out_psnr:.2} dB at lights outside the fit")));
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
            |facts: &PwtFacts| facts.summary().into_iter().map(|(_, value)| value).collect::<Vec<_>>().join("\n");
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
        assert!(words(&log).contains("level 1: 4 x 4, 4 layers x 2 channels"), "{}", words(&log));
        let (_, learned) = packs().swap_remove(4);
        let fetches = learned.header().light_map.as_ref().unwrap().terms();
        let learned = words(&PwtFacts::new(&learned));
        assert!(learned.contains("a mean and 5 learned terms") && fetches == 6, "{learned}");
        assert!(learned.contains(&format!("2, and {fetches} for each light (mean and terms)")), "{learned}");
    }
}
