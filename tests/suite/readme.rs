//! The commands in README.md and on the pages under docs/ work, and print what the pages say they print; links lead
//! somewhere; manifests on the pages parse.
//!
//! Each line of a fenced `sh` block is run, in the order of the page, in a folder of the page that holds a copy of the
//! demo scene. A line may end in `# exit code N`. A `text` block right after a `sh` block is what the block's last line
//! prints, and may stand nowhere else. In it `[..]` stands for what differs from run to run: times and adapters.
//!
//!     ./scripts/bless readme
//!
//! writes these blocks anew instead of comparing them. A `sh` block behind the comment `<!-- not run: WHY -->` is not run;
//! the flags of its `brdfc` commands are still checked, and no `text` block may follow.

use brdfc_jobs::scene::manifest::Manifest;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// What other lines of a block that is not run start with.
const SET_UP: [&str; 16] = [
    "pip install ",
    "python3 tests/",
    "./scripts/",
    "./bindings/",
    "./examples/",
    "npm install ./bindings/web",
    "python3 -m http.server",
    "# ",
    "sudo apt-get install ",
    "cargo install ",
    "cargo bench",
    "cargo build",
    "cargo test --release ",
    "cargo run --manifest-path examples/bevy/Cargo.toml ",
    "cargo run --release --example ",
    "ninja",
];
/// How the pages run the program.
const PROGRAMS: [&str; 3] = ["cargo run --release --features render -- ", "cargo run --release -- ", "brdfc "];
/// What stands in the place of times and adapters.
const ANYTHING: &str = "[..]";
/// How far a number may be from the one on the page: the last digit of mathematical functions is the machine's.
const TOLERANCE: f64 = 0.01;
/// Lines of the README, and characters of a line of prose.
const MOST_LINES: usize = 250;
const MOST_CHARACTERS: usize = 120;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All pages of the repository below `folder`, relative to its root.
fn pages_below(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(root().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        let skipped = ["node_modules", "target"].iter().any(|name| path.ends_with(name));
        if entry.file_type().unwrap().is_dir() && !skipped {
            found.extend(pages_below(&path));
        } else if path.ends_with(".md") {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// The pages whose commands are run.
fn pages_with_commands() -> Vec<String> {
    let pages: Vec<_> = std::iter::once("README.md".to_owned()).chain(pages_below("docs")).collect();
    assert!(pages.len() > 5, "{pages:?}");
    pages
}

fn read(page: &str) -> String {
    std::fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// A fenced block of a page.
#[derive(Debug)]
struct Block {
    language: String,
    /// Where its text stands in the page.
    at: Range<usize>,
    /// Whether only blank lines part it from the block before.
    follows: bool,
    /// Why it is not run.
    not_run: Option<String>,
}

/// Why the block after this line is not run.
fn reason(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- not run: ")?.strip_suffix(" -->")
}

fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut inside, mut follows, mut at) = (false, false, 0);
    let mut not_run = None;
    for line in page.split_inclusive('\n') {
        let end = at + line.len();
        match (line.trim_end().strip_prefix("```"), inside) {
            (Some(language), false) => {
                blocks.push(Block { language: language.to_owned(), at: end..end, follows, not_run: not_run.take() });
                inside = true;
            }
            (Some(_), true) => (inside, follows) = (false, true),
            (None, true) => blocks.last_mut().unwrap().at.end = end,
            (None, false) if line.trim().is_empty() => {}
            (None, false) => {
                not_run = reason(line.trim_end()).map(str::to_owned);
                follows = false;
            }
        }
        at = end;
    }
    assert!(!inside, "a block is not closed");
    blocks
}

/// A folder with the demo scene, and another with the program under the name that the pages use.
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

/// The lines of a block, those that end in a backslash joined.
fn lines(block: &str) -> Vec<String> {
    block.replace("\\\n", " ").lines().filter(|line| !line.trim().is_empty()).map(str::to_owned).collect()
}

/// A line without its remark, as the sandbox runs it, and its exit code; `None` if it does not run the program.
fn command(line: &str) -> Option<(String, i32)> {
    let (line, remark) = line.split_once(" # ").unwrap_or((line, ""));
    let code = remark.strip_prefix("exit code ").map_or(0, |code| code.trim().parse().unwrap());
    let rest = PROGRAMS.iter().find_map(|program| line.strip_prefix(program))?;
    Some((format!("brdfc {}", rest.trim()), code))
}

/// Whether a line of a block that is not run is one that may stand there.
fn is_set_up(line: &str) -> bool {
    let word = |prefix: &str| line.strip_prefix(prefix).and_then(|rest: &str| rest.split_whitespace().next());
    let there = |path: String| root().join(path).exists();
    SET_UP.iter().any(|start| line.starts_with(start))
        && word("./").is_none_or(|script| there(script.to_owned()))
        && word("cargo run --release --example ").is_none_or(|name| there(format!("examples/{name}.rs")))
}

/// Whether a command draws.
fn draws(command: &str) -> bool {
    let studies = ["throughput", "level-of-detail", "images", "adaptive", "pixel-", "bandwidth-directions", "antial"];
    command.starts_with("brdfc render ")
        || studies.iter().any(|study| command.starts_with(&format!("brdfc bench --study {study}")))
        || command.starts_with("brdfc schema render")
}

/// Whether commands that draw work here.
fn can_draw() -> bool {
    #[cfg(feature = "render")]
    let found = crate::common::has_adapter();
    #[cfg(not(feature = "render"))]
    let found = false;
    found
}

/// How many commands were run, only parsed, and compared in what they print.
#[derive(Debug, Default)]
struct Counts {
    run: usize,
    parsed: usize,
    compared: usize,
}

/// Runs a page; the page with the blocks of output that were printed.
fn run_page(name: &str, page: &str, bless: bool, can_draw: bool, counts: &mut Counts) -> String {
    let mut blessed = page.to_owned();
    let sandbox = Sandbox::new();
    // What the block before printed: nothing if it was skipped.
    let mut printed = None;
    let mut new_texts = Vec::new();
    for block in blocks(page) {
        let text = &page[block.at.clone()];
        match (block.language.as_str(), &block.not_run) {
            ("sh", Some(_)) => {
                for line in lines(text) {
                    let Some((command, _)) = command(&line) else {
                        assert!(is_set_up(&line), "{name}: neither ours nor known: {line}");
                        continue;
                    };
                    if draws(&command) && !cfg!(feature = "render") {
                        println!("skipped: {name}: {line}");
                        continue;
                    }
                    // Wrong flags come before the help.
                    let output = sandbox.run(&format!("{command} --help"));
                    let errors = String::from_utf8_lossy(&output.stderr);
                    assert!(output.status.success(), "{name}: {command}\n{errors}");
                    counts.parsed += 1;
                }
                printed = None;
            }
            ("sh", None) => {
                for line in lines(text) {
                    let (command, code) =
                        command(&line).unwrap_or_else(|| panic!("{name}: not a command of ours: {line}"));
                    if draws(&command) && !can_draw {
                        println!("skipped: {name}: {line}");
                        printed = Some((command, None));
                        continue;
                    }
                    let output = sandbox.run(&command);
                    let errors = String::from_utf8_lossy(&output.stderr);
                    assert_eq!(output.status.code(), Some(code), "{name}: {command}\n{errors}");
                    printed = Some((command, Some(masked(&String::from_utf8(output.stdout).unwrap()))));
                    counts.run += 1;
                }
            }
            ("text", _) => {
                assert!(block.follows, "{name}: a block of output that follows no commands:\n{text}");
                let (command, found) =
                    printed.take().unwrap_or_else(|| panic!("{name}: output of commands that are not run:\n{text}"));
                let Some((found, adapter)) = found else { continue };
                // Other drivers round otherwise.
                if !adapter.is_none_or(|adapter| adapter.starts_with("llvmpipe")) {
                    println!("skipped: {name}: what '{command}' prints with another driver");
                } else if bless {
                    new_texts.push((block.at.clone(), found));
                } else {
                    assert_same_words(name, &command, text, &found);
                    counts.compared += 1;
                }
            }
            _ => {}
        }
    }
    for (at, text) in new_texts.into_iter().rev() {
        blessed.replace_range(at, &text);
    }
    blessed
}

#[test]
#[cfg(unix)]
fn every_command_of_the_readme_and_the_docs_works() {
    let bless = std::env::var_os("BRDFC_BLESS").is_some();
    let can_draw = can_draw();
    let mut counts = Counts::default();
    for name in pages_with_commands() {
        let page = read(&name);
        let blessed = run_page(&name, &page, bless, can_draw, &mut counts);
        if bless && blessed != page {
            std::fs::write(root().join(&name), blessed).unwrap();
        }
    }
    println!("{counts:?}");
    let understood = counts.run >= 25 && counts.parsed >= 5 && (bless || counts.compared >= 3);
    assert!(understood, "the pages were not understood: {counts:?}");
}

/// What a command printed, with `[..]` for times and adapters, and the adapter.
fn masked(printed: &str) -> (String, Option<String>) {
    let mut adapter = None;
    let mut text = String::new();
    for line in printed.lines() {
        if let Some(name) = line.strip_prefix("drawn by ") {
            adapter = Some(name.to_owned());
            text += &format!("drawn by {ANYTHING}\n");
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        let masked = words.iter().enumerate().map(|(index, word)| {
            let unit = words.get(index + 1).map(|unit| unit.trim_end_matches(['.', ',', ';', ')']));
            let number = word.trim_start_matches('(');
            if number.parse::<f64>().is_ok() && matches!(unit, Some("s" | "ms")) {
                word.replace(number, &format!("{ANYTHING:>0$}", number.len()))
            } else {
                (*word).to_owned()
            }
        });
        text += &(masked.collect::<Vec<_>>().join(" ") + "\n");
    }
    (text, adapter)
}

/// Equal words; numbers may differ in the last digits.
fn assert_same_words(page: &str, command: &str, expected: &str, found: &str) {
    let told = format!(
        "{command}\n{page} says:\n{expected}\nit prints:\n{found}\n\
         If this is meant: ./scripts/bless readme"
    );
    let (a, b): (Vec<_>, Vec<_>) = (expected.split_whitespace().collect(), found.split_whitespace().collect());
    assert_eq!(a.len(), b.len(), "{told}");
    for (a, b) in a.into_iter().zip(b) {
        assert!(same_word(a, b), "{a} is not {b}\n{told}");
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
    assert_eq!(command("cargo run --release -- info x # exit code 3"), Some(("brdfc info x".to_owned(), 3)));
    assert_eq!(command("brdfc bench a b   # figure 12"), Some(("brdfc bench a b".to_owned(), 0)));
    assert!(command("rm -r packs").is_none() && !is_set_up("rm -r packs") && !is_set_up("./scripts/nothing"));
    assert!(is_set_up("./scripts/test") && !is_set_up("cargo run --release --example nothing"));
}

#[test]
fn times_and_adapters_are_masked() {
    let (text, adapter) =
        masked("a  1.02 MiB   12.34 s\ndrawn by llvmpipe (LLVM 15), a software driver\n(1.5 s, 3 left)\n");
    assert_eq!(text, "a  1.02 MiB    [..] s\ndrawn by [..]\n([..] s, 3 left)\n");
    assert_eq!(adapter.as_deref(), Some("llvmpipe (LLVM 15), a software driver"));
}

#[test]
#[cfg(unix)]
fn pages_that_are_wrong_are_refused() {
    let mut counts = Counts::default();
    let mut refused = |page: &str| {
        let run = std::panic::AssertUnwindSafe(|| run_page("page", page, false, false, &mut counts));
        std::panic::catch_unwind(run).is_err()
    };
    assert!(!refused("```sh\nbrdfc schema info\n```\n"));
    assert!(!refused("<!-- not run: slow -->\n```sh\nbrdfc bench --study rays\n./scripts/test\n```\n"));
    assert!(refused("```sh\nrm -r packs\n```\n"), "a command of others");
    assert!(refused("```sh\nbrdfc schema nothing\n```\n"), "a command that fails");
    assert!(refused("```sh\nbrdfc --version\n```\n\n```text\nbrdfc 77\n```\n"), "another output");
    assert!(refused("```text\nby hand\n```\n"), "an output of nothing");
    assert!(refused("<!-- not run: slow -->\n```sh\nbrdfc --version\n```\n```text\nby hand\n```\n"), "not run");
    assert!(refused("<!-- not run: slow -->\n```sh\nbrdfc bench --frobnicate\n```\n"), "a flag that is not there");
}

#[test]
#[cfg(unix)]
fn outputs_are_written_where_they_stand() {
    let page = "```sh\nbrdfc --version\n```\n\n```text\nold\n```\n\nold\n";
    let blessed = run_page("page", page, true, false, &mut Counts::default());
    let version = concat!("brdfc ", env!("CARGO_PKG_VERSION"));
    assert_eq!(blessed, format!("```sh\nbrdfc --version\n```\n\n```text\n{version}\n```\n\nold\n"));
}

/// The part of a link that names a heading, as hosts of repositories make it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    kept.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
}

/// A page without its fenced blocks.
fn prose(page: &str) -> String {
    let mut inside = false;
    let outside = page.lines().filter(|line| {
        let fence = line.starts_with("```");
        inside ^= fence;
        !inside && !fence
    });
    outside.collect::<Vec<_>>().join("\n")
}

#[test]
fn links_of_the_pages_lead_somewhere() {
    let mut pages = pages_with_commands();
    pages.push("CHANGELOG.md".to_owned());
    pages.extend(["formats", "tests"].into_iter().flat_map(pages_below));
    let mut checked = 0;
    for page in pages {
        let text = prose(&read(&page));
        let folder = root().join(&page).parent().unwrap().to_owned();
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for target in targets.filter(|target| !target.starts_with("http")) {
            let (path, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = if path.is_empty() { root().join(&page) } else { folder.join(path) };
            assert!(file.exists(), "{page}: {target}");
            if !heading.is_empty() {
                let there = prose(&std::fs::read_to_string(&file).unwrap());
                let mut headings =
                    there.lines().filter_map(|line| Some(line.strip_prefix('#')?.trim_start_matches('#')));
                assert!(headings.any(|found| anchor(found) == heading), "{page}: {target}");
            }
            checked += 1;
        }
    }
    assert!(checked > 40, "{checked}");
}

#[test]
fn the_readme_is_short() {
    let page = read("README.md");
    let lines = page.lines().count();
    assert!(lines <= MOST_LINES, "README.md: {lines} lines; allowed {MOST_LINES}");
    for line in prose(&page).lines().filter(|line| !line.contains("](") && !line.starts_with('|')) {
        assert!(line.chars().count() <= MOST_CHARACTERS, "README.md: {line}");
    }
}

#[test]
fn the_manifests_in_the_docs_parse() {
    let mut examples = 0;
    for name in pages_with_commands() {
        let page = read(&name);
        for block in blocks(&page).into_iter().filter(|block| block.language == "toml") {
            let text = &page[block.at];
            let manifest = Manifest::parse(text).unwrap_or_else(|error| panic!("{name}: {error}\n{text}"));
            // An asset takes the place of materials.
            let asset = manifest.render.asset.is_some();
            assert!(asset || !manifest.materials.is_empty() && !manifest.uses.is_empty());
            examples += 1;
        }
    }
    assert!(examples > 0);
}

/// The message about an unknown key lists all that are known.
#[test]
fn every_key_of_the_manifest_is_described() {
    let page = read("docs/scene.md");
    for table in
        ["[scene]", "[defaults]", "[materials.a]", "[[uses]]", "[render]", "[render.camera]", "[[render.lights]]"]
    {
        let error = Manifest::parse(&format!("{table}\nno_such_key = 1\n")).unwrap_err();
        for key in error.allowed.split(", ") {
            assert!(page.contains(&format!("\n| `{key}` |")), "docs/scene.md does not describe {key} of {table}");
        }
    }
}
