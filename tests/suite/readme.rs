//! The commands in README.md work, and print what the README says they print; the manifest in docs/scene.md parses.
//!
//! Each line of a fenced `sh` block is run in one folder that holds a copy of the demo scene, in the order of the page.
//! A line may end in `# exit code N`. A `text` block right after a `sh` block is what the block's last line prints;
//! with `BRDFC_UPDATE_README=1` in the environment these blocks are written anew instead of compared.

use brdfc_jobs::scene::manifest::Manifest;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What a line may start with that the README shows and this test does not run: set-up, or checked elsewhere.
const NOT_RUN: [&str; 15] = [
    "./scripts/test",
    // Needs Embree.
    "./scripts/compare-embree",
    "sudo apt-get install",
    "cargo install",
    "cargo bench",
    "cargo build",
    "cargo run --release --example",
    // In tests/cli/bench.rs.
    "brdfc bench --study flat-btf",
    // In tests/cli/render.rs.
    "brdfc bench --study throughput",
    "brdfc bench --study level-of-detail",
    "brdfc bench --study images",
    // In tests/cli/render_adaptive.rs.
    "brdfc bench --study adaptive",
    "brdfc bench --study pixel-bandwidth",
    "brdfc bench --study bandwidth-directions",
    "brdfc bench --study antialiasing",
];
/// How far a number may be from the one in the README: the last digit of mathematical functions is the machine's.
const TOLERANCE: f64 = 0.01;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A fenced block of a page: its language, its text, and whether only blank lines part it from the block before.
struct Block {
    language: String,
    text: String,
    follows: bool,
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut inside, mut follows) = (false, false);
    for line in page.lines() {
        match (line.strip_prefix("```"), inside) {
            (Some(language), false) => {
                blocks.push(Block { language: language.to_owned(), text: String::new(), follows });
                inside = true;
            }
            (Some(_), true) => (inside, follows) = (false, true),
            (None, true) => blocks.last_mut().unwrap().text += &format!("{line}\n"),
            (None, false) => follows &= line.trim().is_empty(),
        }
    }
    assert!(!inside, "a block is not closed");
    blocks
}

/// A folder with the demo scene, and another with the program under the name that the README uses.
struct Sandbox {
    work: tempfile::TempDir,
    programs: tempfile::TempDir,
}

impl Sandbox {
    fn new() -> Self {
        let (work, programs) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let demo = work.path().join("testdata/demo");
        std::fs::create_dir_all(&demo).unwrap();
        for entry in std::fs::read_dir(root().join("testdata/demo")).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, demo.join(path.file_name().unwrap())).unwrap();
        }
        let program: PathBuf = programs.path().join("brdfc");
        // A hard link where both are on one file system; the program is large.
        if std::fs::hard_link(env!("CARGO_BIN_EXE_brdfc"), &program).is_err() {
            std::fs::copy(env!("CARGO_BIN_EXE_brdfc"), &program).unwrap();
        }
        Self { work, programs }
    }

    fn run(&self, command: &str) -> Output {
        let mut path = std::ffi::OsString::from(self.programs.path());
        path.push(":");
        path.push(std::env::var_os("PATH").unwrap_or_default());
        Command::new("sh")
            .args(["-c", command])
            .current_dir(self.work.path())
            .env("PATH", path)
            .stdin(Stdio::null())
            .output()
            .unwrap()
    }
}

/// The command of a line as the sandbox runs it, and its exit code; `None` if it is one that is not run.
fn command(line: &str) -> Result<Option<(String, i32)>, String> {
    let (command, code) = line.split_once("# exit code ").map_or((line, 0), |(c, n)| (c, n.trim().parse().unwrap()));
    if NOT_RUN.iter().any(|start| command.starts_with(start)) {
        return Ok(None);
    }
    let command = command.replacen("cargo run --release -- ", "brdfc ", 1);
    if !command.starts_with("brdfc ") {
        return Err(format!("neither a command of ours nor one that is known not to run: {line}"));
    }
    Ok(Some((command, code)))
}

#[test]
#[cfg(unix)]
fn every_command_of_the_readme_works() {
    let page = std::fs::read_to_string(root().join("README.md")).unwrap();
    let update = std::env::var_os("BRDFC_UPDATE_README").is_some();
    let mut updated = page.clone();
    let sandbox = Sandbox::new();
    let can_draw = can_draw();
    let mut printed = None;
    let (mut run, mut compared) = (0, 0);
    for block in blocks(&page) {
        match block.language.as_str() {
            "sh" => {
                for line in block.text.replace("\\\n", " ").lines().filter(|l| !l.trim().is_empty()) {
                    let Some((command, code)) = command(line).unwrap() else {
                        println!("skipped: {line}");
                        printed = None;
                        continue;
                    };
                    if command.starts_with("brdfc render ") && !can_draw {
                        println!("skipped: {line}");
                        printed = None;
                        continue;
                    }
                    let output = sandbox.run(&command);
                    let errors = String::from_utf8_lossy(&output.stderr);
                    assert_eq!(output.status.code(), Some(code), "{command}\n{errors}");
                    printed = Some((command, String::from_utf8(output.stdout).unwrap()));
                    run += 1;
                }
            }
            "text" if block.follows => {
                let (command, found) = printed.take().expect("a block of output follows a command that is run");
                if update {
                    updated = updated.replace(&block.text, &found);
                } else {
                    assert_same_words(&command, &block.text, &found);
                }
                compared += 1;
            }
            _ => {}
        }
    }
    if update {
        std::fs::write(root().join("README.md"), updated).unwrap();
    }
    println!("{run} commands run, the output of {compared} compared");
    assert!(run >= 10 && compared >= 3, "the README was not understood: {run} commands, {compared} outputs");
}

/// Whether commands that draw work here.
fn can_draw() -> bool {
    #[cfg(feature = "render")]
    let found = crate::common::has_adapter();
    #[cfg(not(feature = "render"))]
    let found = false;
    found
}

/// Equal words; numbers may differ in the last digits, and times (a number before `s`) at will.
fn assert_same_words(command: &str, expected: &str, found: &str) {
    let split = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
    let (a, b) = (split(expected), split(found));
    let told = format!(
        "{command}\nthe README says:\n{expected}\nit prints:\n{found}\n\
         If this is meant: BRDFC_UPDATE_README=1 cargo test --test readme"
    );
    assert_eq!(a.len(), b.len(), "{told}");
    for (index, (a_word, b_word)) in a.iter().zip(&b).enumerate() {
        let is_time = a.get(index + 1).is_some_and(|unit| unit == "s");
        assert!(is_time || same_word(a_word, b_word), "{a_word} is not {b_word}\n{told}");
    }
}

fn same_word(a: &str, b: &str) -> bool {
    a.split(',').count() == b.split(',').count()
        && a.split(',').zip(b.split(',')).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()),
            _ => a == b,
        })
}

#[test]
fn the_comparison_of_outputs_can_fail() {
    assert!(same_word("1.000,2", "1.005,2") && same_word("a:1", "a:1"));
    assert!(!same_word("1.00", "1.05") && !same_word("1,2", "1") && !same_word("4:1", "5:1"));
    assert!(command("rm -r packs").is_err() && command("cargo bench").unwrap().is_none());
    assert_eq!(command("cargo run --release -- info x # exit code 3"), Ok(Some(("brdfc info x ".to_owned(), 3))));
}

#[test]
fn links_of_the_pages_lead_somewhere() {
    for page in ["README.md", "docs/scene.md"] {
        let path = root().join(page);
        let text = std::fs::read_to_string(&path).unwrap();
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for target in targets.filter(|target| !target.starts_with("http")) {
            let file = path.parent().unwrap().join(target.split('#').next().unwrap());
            assert!(file.exists(), "{page}: {target}");
        }
    }
}

#[test]
fn the_manifest_in_the_docs_parses() {
    let page = std::fs::read_to_string(root().join("docs/scene.md")).unwrap();
    let mut examples = 0;
    for block in blocks(&page).iter().filter(|block| block.language == "toml") {
        let manifest = Manifest::parse(&block.text).unwrap_or_else(|error| panic!("{error}\n{}", block.text));
        assert!(!manifest.materials.is_empty() && !manifest.uses.is_empty());
        examples += 1;
    }
    assert!(examples > 0);
}

/// The message about an unknown key lists all that are known.
#[test]
fn every_key_of_the_manifest_is_described() {
    let page = std::fs::read_to_string(root().join("docs/scene.md")).unwrap();
    for table in
        ["[scene]", "[defaults]", "[materials.a]", "[[uses]]", "[render]", "[render.camera]", "[[render.lights]]"]
    {
        let error = Manifest::parse(&format!("{table}\nno_such_key = 1\n")).unwrap_err();
        for key in error.allowed.split(", ") {
            assert!(page.contains(&format!("\n| `{key}` |")), "docs/scene.md does not describe {key} of {table}");
        }
    }
}
