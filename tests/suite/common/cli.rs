//! Runs the real program in a folder of its own.

use assert_cmd::Command;
use brdfc_testing::tensor::Material;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// What a run left behind.
#[derive(Debug)]
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Ran {
    /// The same, for runs that must have worked.
    #[track_caller]
    pub fn succeeded(self) -> Self {
        assert_eq!(self.code, 0, "{}", self.stderr);
        self
    }

    pub fn json(&self) -> Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
}

/// A folder that is removed at the end, and is the working folder of every run in it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// A run that has not started; for standard input, environment and the like.
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_brdfc"));
        command.current_dir(self.path()).args(arguments).timeout(Duration::from_secs(120));
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Ran {
        let output = self.command(arguments).output().unwrap();
        Ran {
            code: output.status.code().unwrap_or_else(|| panic!("{arguments:?} was killed: {output:?}")),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, bytes).unwrap();
        path
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path().join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).unwrap()
    }

    /// All files below a folder, hidden ones too, by path relative to it.
    pub fn files(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let mut files = BTreeMap::new();
        collect(&self.path().join(folder), "", &mut files);
        files
    }

    /// What a build wrote for others to use: all but the cache.
    pub fn products(&self, folder: &str) -> BTreeMap<String, Vec<u8>> {
        let mut files = self.files(folder);
        files.retain(|name, _| !name.starts_with(".brdfc-cache/"));
        files
    }
}

fn collect(folder: &Path, prefix: &str, files: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
        if entry.file_type().unwrap().is_dir() {
            collect(&entry.path(), &format!("{name}/"), files);
        } else {
            files.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
}

/// A small RGL material whose colour depends on all coordinates.
pub fn rgl_bytes() -> Vec<u8> {
    let colour =
        |at: brdfc_testing::tensor::At| 0.1 + 0.1 * at.channel as f32 + 0.2 * at.s * at.t + 0.05 * at.theta as f32;
    Material { colour, nodes: 4, vndf: |u, v| 1.0 + u + 0.5 * v, ..Material::default() }.container().build()
}

/// One small input of every kind, made in `folder`: their names.
pub fn inputs(folder: &Folder) -> [&'static str; 5] {
    let synth = |model, arguments: &[&str]| {
        folder.run(&[&["synth", model][..], arguments].concat()).succeeded();
    };
    synth("lewis?kd=0.6,0.3,0.1&ks=0.3&n=20", &["-o", "table.binary", "--dimensions", "12x12x24"]);
    synth("ggx?kd=0.1,0.1,0.4&alpha=0.3", &["-o", "round.brdf", "--rows", "300", "--noise", "0.05", "--seed", "7"]);
    synth("ward", &["-o", "brushed.csv", "--rows", "400", "--duplicates", "0.1", "--noise", "0.02"]);
    folder.write("material.bsdf", rgl_bytes());
    ["table.binary", "round.brdf", "brushed.csv", "material.bsdf", "synth:ward?kd=0.2,0.1,0.1&ay=0.5"]
}
