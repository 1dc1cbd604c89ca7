//! Compiles all shaders with a second compiler: Tint, used by Chrome and Dawn, is stricter than naga. It runs in Node,
//! by the package that `scripts/test` installs next to this file.

use brdfc_formats::PackKind;
use brdfc_formats::bandwidth::propagation::PROPAGATION_WGSL;
use brdfc_formats::direction_mesh::DIRECTION_MESH_WGSL;
use brdfc_formats::flat_btf::shader::flat_btf_value_wgsl;
use brdfc_formats::table::shader::TABLE_BRDF_WGSL;
use brdfc_formats::wavelet::shader::WAVELET_BRDF_WGSL;
use serde::{Deserialize, Serialize};
use std::process::{Command, Stdio};

/// Exit code of the script if the package does not run on this machine.
const NO_PACKAGE: i32 = 3;

#[derive(Serialize)]
struct Module {
    name: String,
    source: String,
}

impl Module {
    fn new(name: impl Into<String>, source: impl Into<String>) -> Self {
        Self { name: name.into(), source: source.into() }
    }
}

#[derive(Deserialize)]
struct Answer {
    features: Vec<String>,
    modules: Vec<Vec<Message>>,
}

#[derive(Deserialize)]
struct Message {
    r#type: String,
    line: usize,
    column: usize,
    text: String,
}

/// Tint's messages for each of the modules; `None` if it is missing.
fn compiled(modules: &[Module]) -> Option<Answer> {
    let folder = brdfc_testing::repository().join("tests/tint");
    let mut command = Command::new("node");
    command.arg("compile.mjs").current_dir(&folder);
    let child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let mut child = match child {
        Ok(child) => child,
        Err(error) => {
            println!("skipped: Tint does not run: node: {error}");
            return None;
        }
    };
    // A script that has ended does not read; its exit code has the reason.
    let _ = serde_json::to_writer(child.stdin.take().unwrap(), modules);
    let output = child.wait_with_output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(NO_PACKAGE) {
        println!("skipped: Tint does not run: {}", errors.lines().next().unwrap_or_default());
        return None;
    }
    assert!(output.status.success(), "{}: {errors}", output.status);
    let answer: Answer = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer.modules.len(), modules.len());
    Some(answer)
}

/// The messages about a module, each with its line.
fn complaints(module: &Module, messages: &[Message]) -> String {
    let line = |message: &Message| {
        let code = module.source.lines().nth(message.line.max(1) - 1).unwrap_or_default().trim();
        format!(
            "{}:{}:{}: {}: {}\n    {code}\n",
            module.name, message.line, message.column, message.r#type, message.text
        )
    };
    messages.iter().map(line).collect()
}

/// Sources that engines paste before their own shaders.
fn shipped() -> Vec<Module> {
    let decoders = PackKind::ALL.map(|decoder| Module::new(decoder.name(), (decoder.descriptor().wgsl)()));
    let others = [("direction mesh", DIRECTION_MESH_WGSL), ("propagation", PROPAGATION_WGSL)];
    decoders.into_iter().chain(others.map(|(name, source)| Module::new(name, source))).collect()
}

/// The modules that the renderer compiles.
fn composed() -> Vec<Module> {
    use brdfc_formats::pwt::shader::PWT_WGSL;
    use brdfc_gpu::{AdaptiveShaders, flat_scene_source, pwt_scene_source, scene_source};
    use brdfc_probe::{COMPUTE_WGSL, EVALUATE_FLAT_BTF_WGSL, EVALUATE_PWT_WGSL, EVALUATE_TABLE_WGSL, EVALUATE_WGSL};
    let adaptive = AdaptiveShaders::default();
    let compute = "fn compute(at: u32) { output[at] = input[at]; }\n";
    vec![
        Module::new("scene", scene_source()),
        Module::new("flat scene", flat_scene_source(PackKind::FlatBtf)),
        Module::new("flat scene of trees", flat_scene_source(PackKind::FlatBtfTrees)),
        Module::new("adaptive G-buffer", adaptive.g_buffer),
        Module::new("adaptive steps", adaptive.steps),
        Module::new("evaluate", format!("{WAVELET_BRDF_WGSL}\n{EVALUATE_WGSL}")),
        Module::new("evaluate-table", format!("{TABLE_BRDF_WGSL}\n{EVALUATE_TABLE_WGSL}")),
        Module::new("evaluate flat BTFs", format!("{}\n{EVALUATE_FLAT_BTF_WGSL}", flat_btf_value_wgsl())),
        Module::new("scene of polynomial wavelet trees", pwt_scene_source()),
        Module::new("evaluate polynomial wavelet trees", format!("{PWT_WGSL}\n{EVALUATE_PWT_WGSL}")),
        Module::new("compute", format!("{compute}{COMPUTE_WGSL}")),
    ]
}

/// Compiles without optional features of WebGPU. The last three modules are wrong, to show that errors are reported.
#[test]
fn tint_compiles_all_shaders() {
    let mut modules = shipped();
    modules.extend(composed());
    let good = modules.len();
    let mesh = DIRECTION_MESH_WGSL;
    let beyond = mesh.replace("3.4028234e38", "3.40282347e38");
    let undeclared = mesh.replace("var direction_mesh_words", "var words");
    assert!(beyond != mesh && undeclared != mesh);
    modules.extend([
        Module::new("a number beyond the largest of 32 bits", beyond),
        Module::new("a name that is not declared", undeclared),
        Module::new("not WGSL", "fn"),
    ]);
    let Some(answer) = compiled(&modules) else { return };
    // The device has no optional features.
    assert_eq!(answer.features, ["core-features-and-limits"]);
    let messages = modules.iter().zip(&answer.modules);
    let all: Vec<String> = messages.map(|(module, messages)| complaints(module, messages)).collect();
    assert!(all[..good].iter().all(String::is_empty), "{}", all[..good].concat());
    assert!(all[good].contains("cannot be represented as 'f32'"), "{}", all[good]);
    assert!(all[good].contains("var best = 3.40282347e38;"), "{}", all[good]);
    assert!(all[good + 1].contains("unresolved value 'direction_mesh_words'"), "{}", all[good + 1]);
    assert!(!all[good + 2].is_empty());
}

/// A check that does not need Tint: numbers that naga accepts but Tint does not.
#[test]
fn numbers_of_shaders_are_within_those_of_32_bits() {
    let too_large = |source: &str| {
        let code: String = source.lines().map(|line| line.split("//").next().unwrap().to_owned() + "\n").collect();
        let numbers = code.split(|c: char| !(c.is_ascii_alphanumeric() || c == '.'));
        let values = numbers.filter(|n| n.starts_with(|c: char| c.is_ascii_digit())).filter_map(|n| n.parse().ok());
        let mut large = values.filter(|value: &f64| *value > f64::from(f32::MAX));
        large.next()
    };
    for module in shipped().iter().chain(&composed()) {
        assert_eq!(too_large(&module.source), None, "{}", module.name);
    }
    assert!(too_large("let a = 3.40282347e38;").is_some());
    assert_eq!(too_large("let a = 3.4028234e38; // not 1e39"), None);
    assert_eq!("3.4028234e38".parse(), Ok(f32::MAX));
}
