//! Kind of an input, from its name, the first bytes of packs and of standard input, and the files of a folder. No other module decides
//! what an input is.

use crate::btf_stack::files_in;
use crate::error::InputError;
use crate::flat_btf::{flat_btf_in, is_kind_of_flat_btf};
use crate::input::{Input, InputFile};
use crate::pack::{kind_in, kind_of_file};
use crate::read::{extension_of, found_extension, unknown_kind};
use crate::rti_capture::{self, is_rti_capture};
use crate::{ptm, rti, ubo_btf};
use brdfc_core::address::{SYNTH_PREFIX, split_query};
use brdfc_core::analytic::MODELS;
use brdfc_formats::{FormatError, PackKind};
use brdfc_readers::btf_stack::{StackContents, is_image};
use brdfc_readers::file_kind::FileKind;
use brdfc_readers::recognise::{EXR, HDR, JPEG, KTX2, MANIFEST, PNG, TIFF};
use brdfc_readers::{alta, merl, rgl, scan, scan_csv};
use std::path::Path;

/// File that makes a folder the output of a build.
pub const BUILD_REPORT: &str = "report.json";

/// Dense tables of a BRDF.
const TABLES: [&FileKind; 2] = [&merl::KIND, &rgl::KIND];
/// Scattered samples of a BRDF.
const SCANS: [&FileKind; 3] = [&scan::KIND, &scan_csv::KIND, &alta::KIND];
/// Images of any use.
const IMAGES: [&FileKind; 5] = [&PNG, &JPEG, &EXR, &HDR, &TIFF];
/// Extensions of meshes.
const MESHES: [&str; 2] = ["obj", "ply"];

/// Kind of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// `synth:` and the name of an analytic model.
    Model,
    /// `synth:` and another name: a procedural structure, or a wrong name.
    Structure,
    /// A dense table of a BRDF: MERL, RGL.
    Table,
    /// Scattered samples of a BRDF.
    Scan,
    /// A pack; for a flat BTF also the folder that contains it.
    Pack(PackKind),
    /// A KTX2 file that does not start like a pack: a cube map, a damaged pack, a missing file.
    Texture,
    /// Photographs of one view under known lights: the list of lights or its folder.
    RtiCapture,
    /// A polynomial texture map.
    Ptm,
    /// An RTI file of hemispherical harmonics.
    Rti,
    /// An ordinary BTF: a file of the Bonn database, or a folder of images.
    Btf,
    /// A mesh.
    Mesh,
    /// An image: heights, colours or an environment, by its use.
    Image,
    /// A manifest.
    Manifest,
    /// The output of a build: its folder or its report.
    Build,
    /// A folder of packs without the report of a build.
    Packs,
    /// Any other folder.
    Folder,
    /// Any other file.
    Other,
}

impl Kind {
    /// Recognises an input. A file need not exist.
    ///
    /// # Errors
    /// Returns an error if standard input or a folder cannot be read, and for a folder with several flat BTFs.
    pub fn of(input: &Input) -> Result<Self, InputError> {
        let texture = |kind: Option<PackKind>| kind.map_or(Self::Texture, Self::Pack);
        Ok(match input {
            Input::Address(address) => Self::of_address(address),
            Input::File(path) if path.is_dir() => Self::of_folder(path)?,
            Input::File(path) => match Self::of_name(path) {
                Self::Texture => texture(kind_of_file(path)),
                kind => kind,
            },
            Input::Stdin(stdin) => match Self::of_extension(&input.extension()?) {
                Self::Texture => texture(kind_in(stdin.bytes()?)),
                kind => kind,
            },
        })
    }

    /// Kind of a file by its name alone, without a look at the file.
    pub fn of_name(file: &Path) -> Self {
        if file.file_name().is_some_and(|name| name == BUILD_REPORT) {
            return Self::Build;
        }
        Self::of_extension(&extension_of(file))
    }

    fn of_extension(extension: &str) -> Self {
        let is_one_of = |kinds: &[&FileKind]| kinds.iter().any(|kind| kind.extensions.contains(&extension));
        match extension {
            ptm::EXTENSION => Self::Ptm,
            rti::EXTENSION => Self::Rti,
            rti_capture::EXTENSION => Self::RtiCapture,
            ubo_btf::EXTENSION => Self::Btf,
            _ if is_one_of(&TABLES) => Self::Table,
            _ if is_one_of(&SCANS) => Self::Scan,
            _ if is_one_of(&[&KTX2]) => Self::Texture,
            _ if is_one_of(&[&MANIFEST]) => Self::Manifest,
            _ if MESHES.contains(&extension) => Self::Mesh,
            _ if is_one_of(&IMAGES) => Self::Image,
            _ => Self::Other,
        }
    }

    fn of_address(address: &str) -> Self {
        let name = split_query(address.strip_prefix(SYNTH_PREFIX).unwrap_or(address)).0;
        if MODELS.iter().any(|model| model.name == name) { Self::Model } else { Self::Structure }
    }

    fn of_folder(folder: &Path) -> Result<Self, InputError> {
        let files = files_in(folder);
        let has_packs = files.iter().any(|file| Self::of_name(Path::new(file)) == Self::Texture && !file.contains('/'));
        // Number of views if the images have the names of a BTF.
        let views = StackContents::new(&files).map_or(0, |contents| contents.views.len());
        let has_list = is_rti_capture(folder);
        // Other programs write files of this name, too, next to what they report on.
        if folder.join(BUILD_REPORT).is_file() && !has_list && (has_packs || views == 0) {
            return Ok(Self::Build);
        }
        // The folder of a flat BTF may also hold renderings.
        if let Some(file) = flat_btf_in(folder)? {
            return Ok(kind_of_file(&file).map_or(Self::Texture, Self::Pack));
        }
        // A capture has one view, also if its images have the names of a BTF; a list next to several views is not theirs.
        let is_capture = has_list && views < 2;
        let has_images = files.iter().any(|file| is_image(file));
        Ok(match (has_images, has_packs) {
            _ if is_capture => Self::RtiCapture,
            // Images next to packs are renderings, unless their names are those of a BTF.
            (true, _) if !has_packs || views > 0 => Self::Btf,
            (_, true) => Self::Packs,
            _ => Self::Folder,
        })
    }

    /// Returns true for measured and analytic BRDFs, but not for packs.
    pub fn is_brdf(self) -> bool {
        matches!(self, Self::Model | Self::Table | Self::Scan)
    }

    /// Returns true for a flat BTF.
    pub fn is_flat_btf(self) -> bool {
        matches!(self, Self::Pack(kind) if is_kind_of_flat_btf(kind))
    }

    /// Returns true for a KTX2 file, which is a pack unless it is damaged or of another program.
    pub fn is_ktx2(self) -> bool {
        matches!(self, Self::Pack(_) | Self::Texture)
    }

    /// Name in messages, with an article.
    pub fn name(self) -> &'static str {
        match self {
            Self::Model => "an analytic model",
            Self::Structure => "a structure",
            Self::Table => "a table of a BRDF",
            Self::Scan => "a scan",
            Self::Pack(kind) => kind.summary(),
            Self::Texture => "a KTX2 file that is not a pack",
            Self::RtiCapture => "an RTI capture",
            Self::Ptm => "a polynomial texture map",
            Self::Rti => "an RTI file",
            Self::Btf => "a BTF",
            Self::Mesh => "a mesh",
            Self::Image => "an image",
            Self::Manifest => "a manifest",
            Self::Build => "the output of a build",
            Self::Packs => "a folder of packs without the report of a build",
            Self::Folder => "a folder",
            Self::Other => "a file of another kind",
        }
    }

    /// Advice for an input of this kind; empty if nothing helps.
    fn remedy(self) -> &'static str {
        match self {
            Self::RtiCapture | Self::Ptm | Self::Rti => "; 'brdfc pwt' makes a pack of it",
            Self::Btf => "; 'brdfc flatten' makes a flat BTF of it, and 'brdfc pwt' a pack of a view or of all",
            Self::Structure | Self::Mesh => "; 'brdfc flatten' makes a flat BTF of it",
            Self::Manifest => "; 'brdfc build' makes its packs",
            Self::Build => "; name one of its packs, or use 'brdfc report'",
            Self::Packs => "; name one of its packs",
            _ => "",
        }
    }

    /// Error of an input of this kind where others are expected. An input that cannot be read gets the error of reading it.
    pub fn refused(self, input: &Input, allowed: impl Into<String>) -> InputError {
        self.found(input, format!("{}{}", allowed.into(), self.remedy()))
    }

    /// Same as [`Self::refused`], without advice on commands.
    pub fn found(self, input: &Input, allowed: String) -> InputError {
        let mut listener = ();
        if input.address().is_some() || input.path().is_some_and(Path::is_dir) {
            return InputError::format(input.named_path(), FormatError::whole("input", self.name(), allowed));
        }
        let file = match InputFile::of(input, &mut listener) {
            Ok(file) => file,
            Err(error) => return error,
        };
        let error = match (self, input.path()) {
            (Self::Other, Some(path)) => unknown_kind("file name", found_extension(&extension_of(path)), allowed),
            (Self::Other, None) => {
                let found = if file.length == 0 { "empty file" } else { "unknown layout" };
                unknown_kind("contents", Err(found), allowed)
            }
            _ => FormatError::whole("input", self.name(), allowed),
        };
        match input.path() {
            None if self != Self::Other => InputError::format(input.named_path(), error),
            _ => file.wrong(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::FORMATS;

    fn of(path: &Path) -> Kind {
        Kind::of(&Input::from(path)).unwrap()
    }

    #[test]
    fn every_format_of_a_brdf_has_a_kind() {
        for extension in FORMATS.iter().flat_map(|format| format.kind.extensions) {
            let kind = Kind::of_extension(extension);
            assert!(kind.is_brdf() || kind == Kind::Texture, "{extension}: {kind:?}");
        }
        let ours = TABLES.iter().chain(&SCANS).count();
        assert_eq!(FORMATS.len(), ours + 1, "a format is missing here, or one here is not opened");
    }

    #[test]
    fn folders_are_recognised_by_their_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path();
        let write = |name: &str| std::fs::write(path.join(name), "").unwrap();
        assert_eq!(of(path), Kind::Folder);
        write("a.ktx2");
        assert_eq!(of(path), Kind::Packs);
        // A rendering of the pack.
        write("a.png");
        assert_eq!(of(path), Kind::Packs);
        std::fs::remove_file(path.join("a.ktx2")).unwrap();
        assert_eq!(of(path), Kind::Btf);
        write("a.lp");
        assert_eq!(of(path), Kind::RtiCapture);
        // A report of another program.
        write(BUILD_REPORT);
        assert_eq!([of(path), of(&path.join(BUILD_REPORT))], [Kind::RtiCapture, Kind::Build]);
        write("a.ktx2");
        assert_eq!(of(path), Kind::RtiCapture);
        std::fs::remove_file(path.join("a.lp")).unwrap();
        assert_eq!(of(path), Kind::Build);
    }

    #[test]
    fn a_list_next_to_several_views_is_not_theirs() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| std::fs::write(folder.path().join(name), "").unwrap();
        ["notes.lp", "tl000 pl000 tv000 pv000.png", "tl030 pl000 tv000 pv000.png"].into_iter().for_each(write);
        assert_eq!(of(folder.path()), Kind::RtiCapture);
        write("tl000 pl000 tv040 pv000.png");
        assert_eq!(of(folder.path()), Kind::Btf);
        write(BUILD_REPORT);
        assert_eq!(of(folder.path()), Kind::Btf);
    }

    #[test]
    fn files_are_recognised_by_their_names_although_they_are_missing() {
        for (name, kind) in [
            ("a.binary", Kind::Table),
            ("a.CSV", Kind::Scan),
            ("a.ktx2", Kind::Texture),
            ("a.lp", Kind::RtiCapture),
            ("a.BTF", Kind::Btf),
            ("a.obj", Kind::Mesh),
            ("a.jpeg", Kind::Image),
            ("a.toml", Kind::Manifest),
            ("a.json", Kind::Other),
            ("a", Kind::Other),
            ("synth:ggx?alpha=0.1", Kind::Model),
            ("synth:button", Kind::Structure),
        ] {
            assert_eq!(Kind::of(&name.into()).unwrap(), kind, "{name}");
        }
    }

    #[test]
    fn refusals_name_what_was_found_and_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let error = |name: &str, bytes: Option<&str>| {
            let path = folder.path().join(name);
            bytes.iter().for_each(|bytes| std::fs::write(&path, bytes).unwrap());
            let error = of(&path).refused(&path.into(), "a BRDF").to_string();
            error.rsplit_once(name).map(|(_, rest)| rest.to_owned()).unwrap()
        };
        assert_eq!(
            error("a.lp", Some("0")),
            ": input: found an RTI capture, expected a BRDF; 'brdfc pwt' makes a pack of it"
        );
        assert_eq!(error("a.txt", Some("")), ": file name: found extension .txt, expected a BRDF");
        assert_eq!(error("none", Some("")), ": file name: no extension; expected a BRDF");
        assert!(error("a.png", Some("%PDF-1.7")).ends_with("expected a BRDF; it looks like a PDF"));
        assert!(error("gone.ptm", None).starts_with(": cannot read: "));
    }
}
