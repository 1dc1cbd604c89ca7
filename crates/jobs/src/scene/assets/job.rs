//! Kinds, options and jobs of assets.

use super::report::AssetReport;
use crate::encode::OptionError;
use crate::pwt::PwtOptions;
use crate::report::gate::GateResult;
use crate::report::material::StageTime;
use crate::scene::gates::Require;
use crate::scene::maps::part_name;
use crate::store::Digest;
use brdfc_codec::Budget;
use brdfc_formats::PackKind;
use brdfc_formats::environment::{EnvironmentHeader, MAX_SIDE, MIN_SIDE};
use brdfc_pwt::PwtRecipe;
use brdfc_source::Kind;
use brdfc_source::btf_stack::images_of;
use brdfc_source::input_files::files_behind;
use brdfc_source::photograph::CodeValues;
use serde::{Deserialize, Serialize};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Kind of an asset, which determines its heading in a manifest and its encoder.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum AssetKind {
    /// Photographs of one view under known lights, or a file of an RTI viewer.
    #[default]
    RtiCapture,
    /// An ordinary BTF.
    Btf,
    /// A latitude-longitude image or a cube map.
    Environment,
}

impl AssetKind {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::RtiCapture, Self::Btf, Self::Environment];

    /// Heading of such assets in a manifest.
    pub fn heading(self) -> &'static str {
        match self {
            Self::RtiCapture => "captures",
            Self::Btf => "btfs",
            Self::Environment => "environments",
        }
    }

    /// Name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::RtiCapture => "RTI capture",
            Self::Btf => "BTF",
            Self::Environment => "environment",
        }
    }

    /// Kind of its pack.
    pub fn pack(self) -> PackKind {
        match self {
            Self::RtiCapture | Self::Btf => PackKind::Pwt,
            Self::Environment => PackKind::Environment,
        }
    }

    /// Kind of the asset at a path; `None` for materials and for inputs that are none. Of folders of images only those count whose names
    /// are those of a BTF: others may hold measured materials, too.
    pub fn at(path: &Path) -> Option<Self> {
        let kind = Self::of(Kind::of(&path.into()).ok()?)?;
        let is_folder_of_images = kind == Self::Btf && path.is_dir();
        (!is_folder_of_images || !images_of(path).is_empty()).then_some(kind)
    }

    /// Kind of the asset that a build makes of an input; `None` for materials and for inputs that are none.
    pub(super) fn of(kind: Kind) -> Option<Self> {
        match kind {
            Kind::RtiCapture | Kind::Ptm | Kind::Rti => Some(Self::RtiCapture),
            Kind::Btf => Some(Self::Btf),
            Kind::Image => Some(Self::Environment),
            _ => None,
        }
    }

    /// Keys of its limits in the table `require`.
    pub fn limits(self) -> &'static [&'static str] {
        match self {
            Self::RtiCapture | Self::Btf => &["max_delta_e", "max_bytes", "max_fetches"],
            Self::Environment => &["max_bytes"],
        }
    }

    /// Inputs under its heading, for messages.
    pub fn inputs(self) -> &'static str {
        match self {
            Self::RtiCapture => "an RTI capture: a folder with a list of lights (.lp), the list, a .ptm or a .rti",
            Self::Btf => "an ordinary BTF: a folder of images, or a .btf file",
            Self::Environment => brdfc_source::environment::KINDS,
        }
    }

    /// Returns true for inputs that belong under its heading.
    pub(super) fn accepts(self, kind: Kind) -> bool {
        let is_cube = self == Self::Environment && matches!(kind, Kind::Texture | Kind::Pack(PackKind::Environment));
        is_cube || Self::of(kind) == Some(self)
    }
}

/// An asset of a manifest: its source, options and requirements.
#[derive(Debug, Clone, Default)]
pub struct Asset {
    /// Name of the asset.
    pub name: String,
    /// Kind of the asset.
    pub kind: AssetKind,
    /// A path, relative to the manifest.
    pub source: OsString,
    /// Meaning of the code values of photographs in spite of what they state.
    pub photographs: Option<CodeValues>,
    /// Options of polynomial wavelet trees.
    pub options: PwtOptions,
    /// Texels along each side of a face of an environment.
    pub side: Option<u32>,
    /// Limits that its finished pack has to meet.
    pub require: Require,
}

/// Settings that affect the bytes of a pack.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum AssetRecipe {
    /// A polynomial wavelet tree: its settings, and the meaning of the code values of photographs.
    Pwt(PwtRecipe, Option<CodeValues>),
    /// A prefiltered environment: texels along each side of a face; `None` retains the detail of the image.
    Environment(Option<u32>),
}

/// Valid sides of an environment, for messages.
const SIDES: &str = "a power of two, 8 to 2048";
const _: () = assert!(MIN_SIDE == 8 && MAX_SIDE == 2048);

impl Asset {
    /// Resolves the options.
    ///
    /// # Errors
    /// Returns an error for an option that is out of range.
    pub fn recipe(&self) -> Result<AssetRecipe, OptionError> {
        match self.kind {
            AssetKind::RtiCapture | AssetKind::Btf => Ok(AssetRecipe::Pwt(self.options.recipe()?, self.photographs)),
            AssetKind::Environment => match self.side.filter(|side| !EnvironmentHeader::is_side(*side)) {
                Some(side) => Err(OptionError::new("side", side.to_string(), SIDES)),
                None => Ok(AssetRecipe::Environment(self.side)),
            },
        }
    }
}

/// The job that makes an asset.
#[derive(Debug, Clone)]
pub struct AssetJob {
    /// Name of the asset.
    pub name: String,
    /// Kind of the asset.
    pub kind: AssetKind,
    /// Path as written in the manifest.
    pub declared: String,
    /// Path, resolved against the manifest's folder.
    pub path: PathBuf,
    /// Files that it reads, sorted; the path itself if they cannot be listed.
    pub files: Vec<PathBuf>,
    /// Settings of its encoder.
    pub recipe: AssetRecipe,
    /// Limits that the finished pack has to meet.
    pub required: Budget,
}

impl AssetJob {
    /// Name of its pack in the output folder.
    pub fn file(&self) -> String {
        part_name(&self.name, self.kind.pack().name())
    }
}

/// An asset whose pack is in the store.
#[derive(Debug, Clone)]
pub struct MadeAsset {
    /// Contents of the pack, and its errors.
    pub report: AssetReport,
    /// Results of its gates.
    pub gates: Vec<GateResult>,
    /// Hash of the pack.
    pub file: Digest,
    /// Seconds per stage; `None` if the pack came from the store.
    pub times: Option<Vec<StageTime>>,
}

impl MadeAsset {
    /// Returns true if the pack meets its target and passes all gates.
    pub fn passed(&self) -> bool {
        self.report.missed.is_none() && self.gates.iter().all(|gate| gate.passed)
    }
}

/// Files of a source, sorted; the path alone if it is none.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = files_behind(path).into_iter().filter(|file| !file.is_dir()).collect();
    files.sort();
    files.dedup();
    if files.is_empty() {
        files.push(path.to_owned());
    }
    files
}
