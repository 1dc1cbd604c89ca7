//! How large a pack will be, before it is made.

use crate::encode::auto::LARGEST;
use crate::encode::recipe::PackRecipe;
use brdfc_formats::wavelet::{Header, gpu_bytes};
use brdfc_table::recipe::Size;
use brdfc_wavelet::crop::{needed_coefficients, window};
use brdfc_wavelet::recipe::{Recipe, Target};
use serde::{Deserialize, Serialize};

/// Bytes on a GPU that a pack will have: grey and coloured ones differ, and a search ends where its budget is met.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Predicted {
    /// At least.
    pub least: u64,
    /// At most.
    pub most: u64,
}

impl Predicted {
    /// Of a pack that is there.
    pub fn exactly(bytes: u64) -> Self {
        Self { least: bytes, most: bytes }
    }
}

/// The bytes of packs of a recipe.
pub fn predict(recipe: &PackRecipe) -> Predicted {
    match recipe {
        PackRecipe::Table(recipe) => match recipe.size {
            Size::Bytes(most) => Predicted { least: 0, most },
            Size::Nodes(axes) => {
                // Where a table does not start again, it has one slice less; grey texels have half the bytes.
                let texels = |azimuth: u32| u64::from(axes.half * axes.difference * azimuth * axes.layers);
                Predicted { least: 2 * texels(axes.azimuth), most: 4 * texels(axes.azimuth + 1) }
            }
        },
        PackRecipe::Wavelet(recipe) => of_wavelet(recipe),
        PackRecipe::Auto(recipe) => {
            Predicted { least: 0, most: recipe.budget.bytes.map_or(LARGEST, |bytes| bytes.min(LARGEST)) }
        }
    }
}

fn of_wavelet(recipe: &Recipe) -> Predicted {
    let header = |channels: u32| Header {
        parameterisation: recipe.parameterisation,
        levels: recipe.levels,
        stored_levels: recipe.stored_levels,
        channels,
        bits: recipe.bits,
        mean: 1.0,
        bias: 1.0,
        lifted: recipe.lift,
    };
    let (grey, colour) = (header(1), header(3));
    let window = window(&grey, recipe.directions.light);
    let stored = 1usize << (2 * recipe.stored_levels);
    let all = needed_coefficients(&grey, recipe.directions.view)[..stored].iter().filter(|needed| **needed).count();
    let bytes = |header: &Header, slices: usize| gpu_bytes(header, window, slices + 1);
    match recipe.target {
        Target::Ratio(ratio) => {
            let kept = ((grey.cells() as f64 / ratio).round() as usize).clamp(1, stored);
            // Of those, the ones that no look-up within the directions touches go as well.
            let (fewest, most) = (if all == stored { kept } else { 1 }, kept.min(all));
            Predicted { least: bytes(&grey, fewest), most: bytes(&colour, most) }
        }
        Target::MaxBytes(most) => Predicted { least: 0, most },
        Target::MaxError(_) => Predicted { least: bytes(&grey, 1), most: bytes(&colour, all) },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::encode::encode;
    use crate::encode::options::EncodeOptions;
    use brdfc_formats::crop::{DirectionRange, Elevations};
    use brdfc_source::open::open;

    /// Whatever is predicted holds what is made.
    #[test]
    fn packs_are_as_large_as_predicted() {
        let options =
            |text: &str| toml::from_str::<EncodeOptions>(text).expect("options").resolve(&EncodeOptions::default());
        let narrow = Elevations { from: 30.0, to: 90.0 };
        let seen_from_above = DirectionRange { light: narrow, view: narrow };
        let mut exact = 0;
        for address in ["synth:lambert?kd=0.5", "synth:ggx?kd=0.1,0.2,0.3&f0=0.04&alpha=0.3"] {
            let source = open(address, None).expect("an address").source;
            for text in
                ["", "codec = 'table'", "max_bytes = 3000", "grid = 8\nratio = 4", "grid = 8\nmax_error = '20%'"]
            {
                for directions in [DirectionRange::ALL, seen_from_above] {
                    let mut recipe = options(text).expect("in range");
                    recipe.limit_directions(directions);
                    recipe.limit_levels(|levels| levels - 1);
                    let made = encode(source.as_ref(), &recipe, &()).expect("a pack").pack.gpu_bytes();
                    let Predicted { least, most } = predict(&recipe);
                    assert!((least..=most).contains(&made), "{address} {text} {directions}: {least} {made} {most}");
                    exact += usize::from(made == least || made == most);
                }
            }
        }
        assert!(exact >= 2, "a ratio says how large a pack becomes");
    }
}
