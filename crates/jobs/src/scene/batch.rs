//! Batch builds: materials from folders, lists of files, and patterns.

use super::assets::{Asset, AssetKind, files_of};
use super::manifest::{Manifest, Material, Use};
use super::names;
use super::patterns::{Named, is_lost};
use crate::error::{Error, ErrorKind};
use crate::file_name::folded;
use brdfc_core::address;
use brdfc_readers::scan_csv::{ANGLE_COLUMNS, VECTOR_COLUMNS};
use brdfc_source::Kind;
use brdfc_source::btf_stack::has_views_and_lights;
use brdfc_source::open::files_but_for;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::fmt::Display;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use toml::Spanned;

/// Extension of packs.
const PACKS: &str = "ktx2";

/// Sources that the inputs name, and files that are not sources.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Found {
    /// Paths and addresses, without duplicates, and the kinds of assets that are no materials. The files of a folder or a pattern are
    /// sorted.
    pub sources: Vec<Source>,
    /// Files and folders in the given folders that are not built.
    pub others: Vec<PathBuf>,
}

/// A path or an address, and its kind unless it is a material.
type Source = (OsString, Option<AssetKind>);

/// Finds the sources that files, folders, patterns and addresses name. The folder of an RTI capture or of a BTF is one source; any other
/// folder, and one that also holds measured materials, names the materials and other assets in it, without packs.
///
/// # Errors
/// Returns an error if a folder cannot be listed or holds no material and no other asset, or if no file matches a pattern.
pub fn find(inputs: &[Named]) -> Result<Found, Error> {
    let mut found = Found::default();
    let mut seen = BTreeSet::new();
    for input in inputs {
        let path = input.path();
        let with_kind = |path: OsString| {
            let kind = AssetKind::at(Path::new(&path));
            (path, kind)
        };
        let several = if address_of(path.as_os_str()).is_some() {
            vec![(path.into(), None)]
        } else if path.is_dir() {
            let (sources, others) = of_folder(&path)?;
            found.others.extend(others);
            sources
        } else if input.is_pattern() {
            matching(input, path.display())?.into_iter().map(with_kind).collect()
        } else {
            vec![with_kind(path.into())]
        };
        for (source, kind) in several {
            // `./a` is `a`.
            let path = Path::new(&source);
            if seen.insert(path.strip_prefix("./").unwrap_or(path).to_owned()) {
                found.sources.push((source, kind));
            }
        }
    }
    Ok(found)
}

/// Inputs from the command line.
pub fn given(inputs: &[OsString]) -> Vec<Named> {
    inputs.iter().map(|input| Named::new("", input)).collect()
}

/// Returns the source as text if it is a `synth:` address.
pub fn address_of(source: &OsStr) -> Option<&str> {
    source.to_str().filter(|text| address::is_synth(text))
}

/// Returns true if a file is a measured material, which excludes packs, or a dangling link to one. A .csv file counts
/// if it has columns of values.
fn is_measured(path: &Path) -> bool {
    let is_csv = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("csv"));
    // Regular files and dangling links only: a read from a pipe may block forever.
    (path.is_file() || is_lost(path)) && Kind::of_name(path).is_brdf() && (!is_csv || has_values(path))
}

/// Kind of the asset that a folder is as a whole; `None` for a folder of materials and assets, with these `entries`. The subfolders of a
/// BTF are those of its views or of its lights; one with several views and several lights is a BTF itself.
fn kind_of_whole(folder: &Path, entries: &[PathBuf]) -> Option<AssetKind> {
    let kind = AssetKind::at(folder)?;
    let is_btf = |path: &Path| kind == AssetKind::Btf && path.is_dir() && has_views_and_lights(path);
    (!entries.iter().any(|path| is_measured(path) || is_btf(path))).then_some(kind)
}

/// Kind of the asset at a path in a folder. Of images only Radiance files count: others may be photographs of materials.
fn kind_among_others(path: &Path) -> Option<AssetKind> {
    let is_radiance = || path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("hdr"));
    // A read from a pipe may block forever.
    let is_readable = path.is_dir() || path.is_file() || is_lost(path);
    let kind = if is_readable { AssetKind::at(path) } else { None };
    kind.filter(|kind| *kind != AssetKind::Environment || is_radiance())
}

/// Files and folders in a folder, sorted, without hidden ones.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let io = |error: std::io::Error| Error::read(folder, &error);
    let paths = std::fs::read_dir(folder).map_err(io)?.map(|entry| Ok(entry.map_err(io)?.path()));
    let mut paths = paths.collect::<Result<Vec<_>, Error>>()?;
    paths.retain(|path| !path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.')));
    paths.sort();
    Ok(paths)
}

/// Returns true if the first bytes name a column that only scans have, or cannot be read: the reader reports the
/// error then.
fn has_values(path: &Path) -> bool {
    const START: u64 = 4096;
    let mut start = Vec::new();
    let read = std::fs::File::open(path).and_then(|file| file.take(START).read_to_end(&mut start));
    let text = String::from_utf8_lossy(&start);
    let mut words = text.split(|c: char| !c.is_alphanumeric() && c != '_');
    read.is_err() || words.any(|word| [ANGLE_COLUMNS[0], VECTOR_COLUMNS[6]].contains(&word))
}

/// The sources that a folder names, and what is in it besides them.
fn of_folder(folder: &Path) -> Result<(Vec<Source>, Vec<PathBuf>), Error> {
    let entries = entries(folder)?;
    if let Some(kind) = kind_of_whole(folder, &entries) {
        let own = files_of(folder);
        // The subfolders of a BTF are those of its views or lights.
        let is_other = |path: &PathBuf| {
            own.binary_search(path).is_err()
                && kind_among_others(path).is_some_and(|found| found != kind || !path.is_dir())
        };
        return Ok((vec![(folder.into(), Some(kind))], entries.into_iter().filter(is_other).collect()));
    }
    let (mut sources, mut others) = (Vec::new(), Vec::new());
    for path in entries {
        match kind_among_others(&path) {
            Some(kind) => sources.push((path.into(), Some(kind))),
            None if is_measured(&path) => sources.push((path.into(), None)),
            None if path.is_dir() => {
                // Its files decide whether it is an asset.
                std::fs::read_dir(&path).map_err(|error| Error::read(&path, &error))?;
            }
            None => others.push(path),
        }
    }
    // Photographs of a list are not left out.
    let lists = sources.iter().filter(|(source, kind)| kind.is_some() && !Path::new(source).is_dir());
    let own: BTreeSet<PathBuf> = lists.flat_map(|(source, _)| files_of(Path::new(source))).collect();
    others.retain(|path| !own.contains(path));
    if sources.is_empty() {
        let found = match others.len() {
            0 => "no files".to_owned(),
            1 => "no asset, only one other file".to_owned(),
            count => format!("no asset, only {count} other files"),
        };
        let allowed = format!(
            "expected {}, .ptm or .rti (RTI viewer), .btf (BTF), .hdr (environment), or folders of RTI captures and BTFs; name packs \
             individually",
            files_but_for(PACKS)
        );
        return Err(Error::check(format!("{}: {found}; {allowed}", folder.display())));
    }
    Ok((sources, others))
}

/// Finds the files that match. Errors name the pattern as `label`.
fn matching(pattern: &Named, label: impl Display) -> Result<Vec<OsString>, Error> {
    let (built, files): (Vec<PathBuf>, Vec<PathBuf>) = pattern.files()?.into_iter().partition(|path| is_built(path));
    if files.is_empty() {
        let wrong = if built.is_empty() {
            "no file matches; expected a file, or a pattern such as scans/*.binary"
        } else {
            "only packs of a build match; name packs individually"
        };
        return Err(Error::check(format!("{label}: {wrong}")));
    }
    Ok(files.into_iter().map(OsString::from).collect())
}

/// Returns true if a file is a pack in the output folder of a build. Patterns skip such packs.
fn is_built(path: &Path) -> bool {
    Kind::of_name(path).is_ktx2() && path.parent().is_some_and(|folder| folder.join(crate::store::FOLDER).is_dir())
}

/// Creates a manifest of these sources, with one use without limits for each material. The names of the materials come from the
/// files; other assets whose names differ in their extension only have it in their name.
///
/// # Errors
/// Returns an error if two sources have the same name.
pub fn manifest_of(sources: &[Source]) -> Result<Manifest, Error> {
    let mut manifest = Manifest::default();
    let mut names = Names::default();
    let short: Vec<String> = sources.iter().map(|(source, kind)| name_of(source, *kind)).collect();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    short.iter().for_each(|name| *counts.entry(folded(name)).or_default() += 1);
    for ((source, kind), name) in sources.iter().zip(short) {
        if let Some(kind) = *kind {
            let whole = if counts[&folded(&name)] > 1 { names::of_whole(Path::new(source)) } else { name };
            let name = names.add(source, whole)?;
            manifest.assets.push(Asset { name, kind, source: source.clone(), ..Asset::default() });
            continue;
        }
        let name = names.add(source, name)?;
        let material = Material { source: source.clone(), ..Material::default() };
        manifest.materials.insert(name.clone(), material);
        manifest.uses.push(Use::of(Spanned::new(0..0, name)));
    }
    manifest.assets.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(manifest)
}

impl Manifest {
    /// Paths and patterns of the used materials, of the other assets and of the environment. `folder` is the folder of the manifest.
    pub fn inputs(&self, folder: &Path) -> Vec<Named> {
        let used = self.uses.iter().filter_map(|used| self.materials.get(used.material.get_ref()));
        let sources = used.map(|material| &material.source).filter(|source| address_of(source).is_none());
        // The environment is always a file, even if its name has wildcards.
        let environment = self.scene.environment.iter().map(|file| Named::new(folder.join(file), ""));
        let textures = self.uses.iter().filter_map(|used| used.texture.as_ref());
        let textures = textures.map(|texture| Named::new(folder.join(texture.get_ref()), ""));
        // Sources of assets are no patterns, either.
        let assets = self.assets.iter().map(|asset| Named::new(folder.join(&asset.source), ""));
        sources.map(|source| Named::new(folder, source)).chain(textures).chain(environment).chain(assets).collect()
    }

    /// Expands patterns: replaces each material whose source is a pattern with one material per matching file, and
    /// each of its uses with one use per file. `folder` is the folder of the manifest.
    ///
    /// # Errors
    /// Returns an error if no file matches a pattern, or if two materials have the same name.
    pub fn expanded(mut self, folder: &Path) -> Result<Self, Error> {
        let named = |material: &Material| Named::new(folder, &material.source);
        let is_group = |material: &Material| address_of(&material.source).is_none() && named(material).is_pattern();
        let groups: Vec<String> =
            self.materials.iter().filter(|(_, material)| is_group(material)).map(|(name, _)| name.clone()).collect();
        if groups.is_empty() {
            return Ok(self);
        }
        let mut members: BTreeMap<String, Vec<String>> = BTreeMap::new();
        let mut added = Vec::new();
        for group in groups {
            let material = self.materials.remove(&group).expect("the group is a material");
            let source = material.source.display();
            for path in matching(&named(&material), source).map_err(|error| in_manifest(error, &group, &material))? {
                // Relative to the manifest, like other sources.
                let declared = Path::new(&path).strip_prefix(folder).map_or(path.clone(), OsString::from);
                added.push((group.clone(), Material { source: declared, ..material.clone() }));
            }
        }
        let mut names = Names::default();
        self.materials.iter().for_each(|(name, material)| names.reserve(name, &material.source));
        for (group, material) in added {
            let name = names
                .add(&material.source, name_of(&material.source, None))
                .map_err(|error| in_manifest(error, &group, &material))?;
            members.entry(group).or_default().push(name.clone());
            self.materials.insert(name, material);
        }
        let uses = std::mem::take(&mut self.uses);
        self.uses = uses.into_iter().flat_map(|used| each_member(used, &members)).collect();
        Ok(self)
    }
}

/// Adds the place in the manifest to the error of a material's source. I/O errors stay unchanged.
fn in_manifest(error: Error, name: &str, material: &Material) -> Error {
    if error.kind() == ErrorKind::Io {
        return error;
    }
    let text = format!("line {}, materials.{name}.source, {error}", material.line);
    error.with_message(text)
}

fn each_member(used: Use, members: &BTreeMap<String, Vec<String>>) -> Vec<Use> {
    let Some(names) = members.get(used.material.get_ref()) else { return vec![used] };
    let of = |name: &String| Use { material: Spanned::new(used.material.span(), name.clone()), ..used.clone() };
    names.iter().map(of).collect()
}

/// Name of a source: of a model, of a folder, or of a file without its extension.
fn name_of(source: &OsStr, kind: Option<AssetKind>) -> String {
    let path = Path::new(source);
    match address_of(source).and_then(|address| address.strip_prefix(address::SYNTH_PREFIX)) {
        Some(model) => model.split('?').next().unwrap_or_default().to_owned(),
        None if kind.is_some() && path.is_dir() => names::of_whole(path),
        None => names::of_file(path),
    }
}

/// Names in use, folded, with the source of each.
#[derive(Default)]
struct Names(BTreeMap<String, String>);

impl Names {
    fn reserve(&mut self, name: &str, source: &OsStr) {
        self.0.insert(folded(name), source.display().to_string());
    }

    /// Adds the name of a source and returns it.
    ///
    /// # Errors
    /// Returns an error if the name is invalid or in use.
    fn add(&mut self, source: &OsStr, name: String) -> Result<String, Error> {
        let label = source.display().to_string();
        names::check_name(&name, true)
            .map_err(|allowed| Error::wrong_input(&label, format!("the name {name}"), allowed))?;
        match self.0.insert(folded(&name), label.clone()) {
            Some(first) => {
                let text = format!("{first} and {label}: both would be named {name}; rename one of the files");
                Err(Error::input(text + " (names must differ in more than case)"))
            }
            None => Ok(name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(files: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        files.iter().for_each(|file| std::fs::write(folder.path().join(file), "").unwrap());
        folder
    }

    #[test]
    fn a_folder_stands_for_its_measured_files() {
        let there = folder(&["b.brdf", "a.binary", "notes.txt", "c.BSDF", "old.ktx2", ".d.csv"]);
        let write = |name: &str, text: &str| std::fs::write(there.path().join(name), text).unwrap();
        write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
        write("report.csv", "name,value\nflat_btf_reference,5460\n");
        write("e.csv", "# angles\ntheta_i,phi_i,theta_o,phi_o,r,g,b\n0,0,0,0,1,1,1\n");
        write("d.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,1,0,0,1,1,1,1\n");
        let found = find(&given(&[there.path().into()])).unwrap();
        let names: Vec<_> = found.sources.iter().map(|(source, _)| names::of_file(Path::new(source))).collect();
        assert_eq!((names, found.others.len()), (["a", "b", "c", "d", "e"].map(str::to_owned).to_vec(), 4));
        let empty = folder(&["notes.txt"]);
        let error = find(&given(&[empty.path().into()])).unwrap_err().to_string();
        assert!(error.contains("no asset, only one other file; expected .binary"), "{error}");
    }

    #[test]
    fn patterns_in_manifests() {
        let there = folder(&["b.brdf", "a.brdf", "c.csv"]);
        let text = "[materials.all]\nsource='*.brdf'\nmax_delta_e=1\n[materials.one]\nsource='c.csv'\n\
                    [[uses]]\nmaterial='all'\nnearest=4\n[[uses]]\nmaterial='one'\n";
        let manifest = Manifest::parse(text).unwrap().expanded(there.path()).unwrap();
        let of =
            |m: &Manifest| m.materials.iter().map(|(n, m)| format!("{n}={}", m.source.display())).collect::<Vec<_>>();
        assert_eq!(of(&manifest), ["a=a.brdf", "b=b.brdf", "one=c.csv"]);
        let uses: Vec<_> = manifest.uses.iter().map(|used| used.material.get_ref().as_str()).collect();
        assert_eq!(uses, ["a", "b", "one"]);
        assert_eq!(manifest.materials["b"].options.max_delta_e, Some(1.0));
        let nothing = text.replace("*.brdf", "*.bsdf");
        let error = Manifest::parse(&nothing).unwrap().expanded(there.path()).unwrap_err().to_string();
        assert!(error.contains("no file matches"), "{error}");
    }

    #[test]
    fn collisions_are_rejected() {
        let sources = ["x/red.brdf", "y/Red.binary"].map(|source| (source.into(), None));
        let error = manifest_of(&sources).unwrap_err().to_string();
        assert!(error.starts_with("x/red.brdf and y/Red.binary: both would be named Red"), "{error}");
        let names: Vec<_> = manifest_of(&[("nul.brdf".into(), None)]).unwrap().materials.into_keys().collect();
        assert_eq!(names, ["nul_"], "Windows cannot have such a file");
    }

    /// A folder of measured materials stays one with other assets in it.
    #[test]
    fn materials_next_to_assets_are_found() {
        let there = folder(&["red.binary", "red.hdr", "coin.ptm", "coin.rti", "notes.txt"]);
        let image = |folder: &str, view: u32, light: u32| {
            let folder = there.path().join(folder);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(format!("tl{light:03} pl000 tv{view:03} pv000.png")), "").unwrap();
        };
        for (view, light) in [(0, 0), (0, 30), (40, 0), (40, 30)] {
            image("coin.v1", view, light);
            image("coin.v2", view, light);
            image(&format!("views/{view}"), view, light);
        }
        std::fs::write(there.path().join("dirs.lp"), "1\na.jpg 0 0 1\n").unwrap();
        std::fs::write(there.path().join("a.jpg"), "").unwrap();
        let found = find(&given(&[there.path().into()])).unwrap();
        assert_eq!(found.others, [there.path().join("notes.txt")], "photographs of a list are not left out");
        let manifest = manifest_of(&found.sources).unwrap();
        assert_eq!(manifest.materials.keys().collect::<Vec<_>>(), ["red"]);
        let names: Vec<_> = manifest.assets.iter().map(|asset| (asset.name.as_str(), asset.kind)).collect();
        let (capture, btf) = (AssetKind::RtiCapture, AssetKind::Btf);
        let expected = [
            ("coin_ptm", capture),
            ("coin_rti", capture),
            ("coin_v1", btf),
            ("coin_v2", btf),
            ("dirs", capture),
            ("red_hdr", AssetKind::Environment),
            ("views", btf),
        ];
        assert_eq!(names, expected);
        // Files of other kinds next to photographs do not hide them, nor does a list next to a BTF.
        let outer = folder(&["lights.lp", "red.binary"]);
        for other in ["coin.v1/sky.hdr", "coin.v1/notes.lp", "coin.v1/lights.dat"] {
            std::fs::write(there.path().join(other), "").unwrap();
        }
        let sources = |folder: &Path| find(&given(&[folder.into()])).unwrap();
        std::fs::rename(there.path().join("coin.v1"), outer.path().join("coin.v1")).unwrap();
        let in_outer = |name: &str| OsString::from(outer.path().join(name));
        let expected =
            [(in_outer("coin.v1"), Some(btf)), (in_outer("lights.lp"), Some(capture)), (in_outer("red.binary"), None)];
        assert_eq!(sources(outer.path()).sources, expected);
        std::fs::remove_file(outer.path().join("coin.v1/lights.dat")).unwrap();
        let alone = sources(&outer.path().join("coin.v1"));
        assert_eq!(alone.sources, expected[..1]);
        let names: Vec<_> = alone.others.iter().filter_map(|path| path.file_name()).collect();
        assert_eq!(names, ["sky.hdr"]);
        // A folder with one BTF in it names the BTF.
        let outer = folder(&[]);
        std::fs::rename(there.path().join("coin.v2"), outer.path().join("wood")).unwrap();
        assert_eq!(sources(outer.path()).sources, [(outer.path().join("wood").into(), Some(btf))]);
    }
}
