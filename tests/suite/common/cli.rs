//! Runs of the program, and inputs for them.

pub use brdfc_testing::program::Ran;

use brdfc_testing::program;
use brdfc_testing::tensor::Material;
use std::ops::Deref;

/// A folder for runs of `brdfc`.
pub struct Folder(program::Folder);

impl Folder {
    pub fn new() -> Self {
        Self(program::Folder::of(env!("CARGO_BIN_EXE_brdfc")))
    }
}

impl Deref for Folder {
    type Target = program::Folder;

    fn deref(&self) -> &program::Folder {
        &self.0
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

/// A `report.json` with this text and the checksum that it asks for, in place of any that it has.
pub fn with_checksum(text: &str) -> String {
    const KEY: &str = ",\n  \"checksum\": ";
    let end = text.rfind(KEY).unwrap_or_else(|| text.trim_end().strip_suffix("\n}").expect("an object").len());
    let body = &text[..end];
    format!("{body}{KEY}\"{}\"\n}}\n", blake3::hash(format!("{body}\n}}\n").as_bytes()))
}

/// Returns true for `PLACE: found X, expected Y` and `PLACE: problem; expected Y`.
pub fn states_what_is_expected(message: &str) -> bool {
    (message.contains("found ") && message.contains(", expected ")) || message.contains("; expected ")
}
