//! Commands on the pages of the repository: each line of a fenced `sh` block is run, in the order of the page, in a folder of the
//! page that holds a copy of the demo scene. A line may end in `# exit code N`. A `text` block right after a `sh` block is what
//! the block's last line prints, and may be nowhere else. In it `[..]` marks what differs from run to run: times and
//! adapters.
//!
//! A `sh` block behind the comment `<!-- not run: WHY -->` is not run; the flags of its commands are still checked, and no `text`
//! block may follow. Commands of another program of the repository are left to its own tests.

use crate::repository;
use std::ops::Range;
use std::panic::resume_unwind;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;

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
/// Replaces times and adapters.
const ANYTHING: &str = "[..]";
/// How far a number may be from the one on the page: the last digit of mathematical functions is the machine's.
const TOLERANCE: f64 = 0.01;
/// The program whose commands are run.
#[derive(Debug)]
pub struct Program {
    /// Its name on the pages.
    pub name: &'static str,
    /// Where it is.
    pub path: &'static str,
    /// How the pages run it.
    pub starts: &'static [&'static str],
    /// How they run the other programs of the repository.
    pub others: &'static [&'static str],
    /// Whether a command draws.
    pub draws: fn(&str) -> bool,
    /// Whether it was built with the renderer.
    pub renders: bool,
    /// Whether commands that draw work here.
    pub can_draw: bool,
}

/// All pages of the repository below `folder`, relative to its root.
pub fn pages_below(folder: &str) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(repository().join(folder)).unwrap() {
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
pub fn pages_with_commands() -> Vec<String> {
    let pages: Vec<_> = std::iter::once("README.md".to_owned()).chain(pages_below("docs")).collect();
    assert!(pages.len() > 5, "{pages:?}");
    pages
}

/// The text of a page.
pub fn read(page: &str) -> String {
    std::fs::read_to_string(repository().join(page)).unwrap_or_else(|error| panic!("{page}: {error}"))
}

/// A fenced block of a page.
#[derive(Debug)]
pub struct Block {
    /// What it is in.
    pub language: String,
    /// Where its text is in the page.
    pub at: Range<usize>,
    /// Whether only blank lines part it from the block before.
    follows: bool,
    /// Why it is not run.
    not_run: Option<String>,
}

/// Why the block after this line is not run.
fn reason(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- not run: ")?.strip_suffix(" -->")
}

/// The fenced blocks of a page.
pub fn blocks(page: &str) -> Vec<Block> {
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
    fn new(program: &Program) -> Self {
        let (work, programs) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let demo = work.path().join("testdata/demo");
        std::fs::create_dir_all(&demo).unwrap();
        for entry in std::fs::read_dir(repository().join("testdata/demo")).unwrap() {
            let path = entry.unwrap().path();
            std::fs::copy(&path, demo.join(path.file_name().unwrap())).unwrap();
        }
        let named = programs.path().join(program.name);
        // A hard link where both are on one file system; the program is large.
        if std::fs::hard_link(program.path, &named).is_err() {
            std::fs::copy(program.path, &named).unwrap();
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

impl Program {
    /// A line without its remark, as the sandbox runs it, and its exit code; `None` if it does not run the program.
    pub fn command(&self, line: &str) -> Option<(String, i32)> {
        let (line, remark) = line.split_once(" # ").unwrap_or((line, ""));
        let code = remark.strip_prefix("exit code ").map_or(0, |code| code.trim().parse().unwrap());
        let rest = self.starts.iter().find_map(|program| line.strip_prefix(program))?;
        Some((format!("{} {}", self.name, rest.trim()), code))
    }

    /// Whether a line runs another program of the repository.
    pub fn is_of_others(&self, line: &str) -> bool {
        self.others.iter().any(|start| line.starts_with(start))
    }
}

/// Whether a line of a block that is not run is one that may stand there.
pub fn is_set_up(line: &str) -> bool {
    let word = |prefix: &str| line.strip_prefix(prefix).and_then(|rest: &str| rest.split_whitespace().next());
    let there = |path: String| repository().join(path).exists();
    SET_UP.iter().any(|start| line.starts_with(start))
        && word("./").is_none_or(|script| there(script.to_owned()))
        && word("cargo run --release --example ").is_none_or(|name| there(format!("examples/{name}.rs")))
}

/// How many commands were run, only parsed, and compared in what they print.
#[derive(Debug, Default)]
pub struct Counts {
    /// Run.
    pub run: usize,
    /// Parsed.
    pub parsed: usize,
    /// Compared.
    pub compared: usize,
}

/// Runs a page; the page with the blocks of output that were printed.
pub fn run_page(program: &Program, name: &str, page: &str, bless: bool, counts: &mut Counts) -> String {
    let mut blessed = page.to_owned();
    let sandbox = Sandbox::new(program);
    // What the block before printed: nothing if it was skipped.
    let mut printed = None;
    let mut new_texts = Vec::new();
    for block in blocks(page) {
        let text = &page[block.at.clone()];
        match (block.language.as_str(), &block.not_run) {
            ("sh", Some(_)) => {
                for line in lines(text) {
                    if program.is_of_others(&line) {
                        continue;
                    }
                    let Some((command, _)) = program.command(&line) else {
                        assert!(is_set_up(&line), "{name}: neither ours nor known: {line}");
                        continue;
                    };
                    if (program.draws)(&command) && !program.renders {
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
                    if program.is_of_others(&line) {
                        printed = Some((line, None));
                        continue;
                    }
                    let (command, code) =
                        program.command(&line).unwrap_or_else(|| panic!("{name}: not a command of ours: {line}"));
                    if (program.draws)(&command) && !program.can_draw {
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

/// Runs the commands of all pages, or writes what they print where `BRDFC_BLESS` is set.
pub fn run_pages(program: &Program) -> Counts {
    let bless = std::env::var_os("BRDFC_BLESS").is_some();
    let pages = Mutex::new(pages_with_commands());
    let run_some = || {
        let mut counts = Counts::default();
        loop {
            let Some(name) = pages.lock().unwrap().pop() else { return counts };
            let page = read(&name);
            let blessed = run_page(program, &name, &page, bless, &mut counts);
            if bless && blessed != page {
                std::fs::write(repository().join(&name), blessed).unwrap();
            }
        }
    };
    // Each page has a folder of its own.
    let counts = std::thread::scope(|scope| {
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let started: Vec<_> = (0..threads).map(|_| scope.spawn(run_some)).collect();
        let ended = started.into_iter().map(|thread| thread.join().unwrap_or_else(|panic| resume_unwind(panic)));
        ended.fold(Counts::default(), |sum, counts| Counts {
            run: sum.run + counts.run,
            parsed: sum.parsed + counts.parsed,
            compared: sum.compared + counts.compared,
        })
    });
    println!("{counts:?}");
    counts
}

/// What a command printed, with `[..]` for times and adapters, and the adapter.
pub fn masked(printed: &str) -> (String, Option<String>) {
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

/// Equal words, or numbers that differ in the last digits.
pub fn same_word(a: &str, b: &str) -> bool {
    a.split(',').count() == b.split(',').count()
        && a.split(',').zip(b.split(',')).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()),
            _ => a == b,
        })
}
