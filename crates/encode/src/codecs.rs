//! List of BRDF codecs: [`codecs!`] has one line for each.

use brdfc_codec::{
    BrdfRecipe, BrdfReport, Encode, EncodeError, EncodeOptions, Encoded, GridCache, OptionError, Variant,
};
use brdfc_core::progress::Progress;
use brdfc_core::{Darkest, Describe, Source, StrayRows};
use brdfc_formats::crop::DirectionRange;
use brdfc_formats::{BrdfPack, PackKind};
use encoders::{table, wavelet};
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// The encoders with the types of their recipes.
pub mod encoders {
    pub use brdfc_table as table;
    pub use brdfc_wavelet as wavelet;
}

/// Generates [`PackRecipe`], [`CodecReport`] and [`PackFacts`] from one line per codec: the name of its pack in
/// [`BrdfPack`], its recipe, its report, the facts about its packs, and their name in `brdfc info`.
macro_rules! codecs {
    ($($(#[$doc:meta])* $codec:ident: $recipe:ty, $report:ty, $facts:ty, $kind:literal;)*) => {
        /// Recipe of a pack. It dereferences to the common part of all recipes.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub enum PackRecipe {
            $($(#[$doc])* $codec($recipe),)*
        }

        impl Deref for PackRecipe {
            type Target = dyn BrdfRecipe;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$codec(recipe) => recipe,)*
                }
            }
        }

        impl DerefMut for PackRecipe {
            fn deref_mut(&mut self) -> &mut Self::Target {
                match self {
                    $(Self::$codec(recipe) => recipe,)*
                }
            }
        }

        impl PackRecipe {
            /// The codecs that users can choose.
            pub(super) const CODECS: &[CodecEntry] = &[$(CodecEntry {
                variants: <$recipe>::VARIANTS,
                recipe: |variant, options| Ok(Self::$codec(<$recipe>::from_options(variant, options)?)),
            }),*];

            /// Kind of the pack.
            pub fn kind(&self) -> PackKind {
                match self {
                    $(Self::$codec(_) => PackKind::$codec,)*
                }
            }

            /// Encodes a source.
            pub(super) fn encode(
                &self,
                source: &dyn Source,
                cache: &dyn GridCache,
                progress: &dyn Progress,
            ) -> Result<EncodedPack, EncodeError> {
                match self {
                    $(Self::$codec(recipe) => Ok(recipe.encode(source, cache, progress)?.map(CodecReport::$codec)),)*
                }
            }

            /// Bytes on a GPU of the levels of detail that [`BrdfRecipe::limit_levels`] omitted from a pack, where its
            /// report has them.
            pub fn bytes_of_left_out_levels(&self, report: &CodecReport, channels: u32) -> Option<u64> {
                match (self, report) {
                    $((Self::$codec(recipe), CodecReport::$codec(report)) => {
                        recipe.bytes_of_left_out_levels(report, channels)
                    })*
                    _ => None,
                }
            }
        }

        $(impl From<$recipe> for PackRecipe {
            fn from(recipe: $recipe) -> Self {
                Self::$codec(recipe)
            }
        })*

        /// Report of a pack, by its codec. It dereferences to the common part of all reports.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
        #[serde(rename_all = "kebab-case")]
        pub enum CodecReport {
            $($(#[$doc])* $codec($report),)*
        }

        impl Deref for CodecReport {
            type Target = dyn BrdfReport;

            fn deref(&self) -> &Self::Target {
                match self {
                    $(Self::$codec(report) => report,)*
                }
            }
        }

        /// Facts about a BRDF pack, by its codec.
        #[derive(Debug, Clone, PartialEq, Serialize, schemars::JsonSchema)]
        #[serde(tag = "kind")]
        pub enum PackFacts {
            $($(#[$doc])* #[serde(rename = $kind)] $codec($facts),)*
        }

        impl PackFacts {
            fn of_codec(&self) -> &dyn Describe {
                match self {
                    $(Self::$codec(facts) => facts,)*
                }
            }
        }

        impl From<&BrdfPack> for PackFacts {
            fn from(pack: &BrdfPack) -> Self {
                match pack {
                    $(BrdfPack::$codec(pack) => Self::$codec(pack.into()),)*
                }
            }
        }
    };
}

codecs! {
    /// A table pack, plain or factored.
    Table: table::Recipe, table::TableReport, table::TablePackFacts, "table-pack";
    /// A wavelet pack.
    Wavelet: wavelet::recipe::Recipe, wavelet::WaveletReport, wavelet::WaveletPackFacts, "wavelet-pack";
}

/// A codec that users can choose.
pub(super) struct CodecEntry {
    /// Its variants.
    pub(super) variants: &'static [Variant],
    /// Creates the recipe of a variant, see [`Encode::from_options`].
    pub(super) recipe: fn(&str, &EncodeOptions) -> Result<PackRecipe, OptionError>,
}

/// A pack of any codec with the measurements of its encoding.
pub type EncodedPack = Encoded<CodecReport>;

impl Describe for PackFacts {
    fn lines(&self) -> Vec<(&'static str, String)> {
        self.of_codec().lines()
    }

    fn samples(&self) -> u64 {
        self.of_codec().samples()
    }

    fn directions(&self) -> DirectionRange {
        self.of_codec().directions()
    }

    fn levels(&self) -> Option<u32> {
        self.of_codec().levels()
    }

    fn rows_raised(&self) -> u64 {
        self.of_codec().rows_raised()
    }

    fn darkest(&self) -> Option<Darkest> {
        self.of_codec().darkest()
    }

    fn stray_rows(&self) -> Option<StrayRows> {
        self.of_codec().stray_rows()
    }

    fn partial_spectrum(&self) -> Option<[f64; 2]> {
        self.of_codec().partial_spectrum()
    }

    fn summary(&self) -> Vec<(&'static str, String)> {
        self.of_codec().summary()
    }
}

impl From<table::recipe::TableRecipe> for PackRecipe {
    fn from(recipe: table::recipe::TableRecipe) -> Self {
        Self::Table(recipe.into())
    }
}

impl From<table::search::recipe::SearchRecipe> for PackRecipe {
    fn from(recipe: table::search::recipe::SearchRecipe) -> Self {
        Self::Table(recipe.into())
    }
}

impl Default for PackRecipe {
    fn default() -> Self {
        Self::Table(table::Recipe::default())
    }
}

impl PackRecipe {
    /// Skips the error against the source, unless the error decides something.
    #[must_use]
    pub fn without_measuring(mut self) -> Self {
        self.skip_measuring();
        self
    }
}
