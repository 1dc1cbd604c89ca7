//! Commands on the pages of the repository. Each line of a fenced `sh` block is run, in the order of the page, in a
//! folder of the page with a copy of the demo scene. A line may end in `# exit code N`. A `text` block right after a
//! `sh` block must be the output of the block's last line, and is not allowed anywhere else. In it `[..]` marks parts
//! that differ from run to run: times and adapters.
//!
//! A `sh` block after the comment `<!-- not run: WHY -->` is not run. The flags of its commands are still checked, and
//! no `text` block may follow. Commands of another program of the repository are left to its own tests.
//!
//! A block after the comment `<!-- file: NAME -->` is written to that file in the folder of the page.

use crate::repository;
use std::ops::Range;
use std::panic::resume_unwind;
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;

/// Starts of other lines that are allowed in blocks that are not run.
const SET_UP: [&str; 19] = [
    "pip install ",
    "python3 tests/",
    "./scripts/",
    "./bindings/",
    "./examples/",
    "BRDFC=$(command -v brdfc) ./bindings/web/build",
    "npm install ",
    "mkdir ../",
    "cp red.ktx2 ../",
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
/// Maximum relative difference between a printed number and the number on the page: the last digit of mathematical functions
/// depends on the machine.
const TOLERANCE: f64 = 0.01;
/// The program whose commands are run.
#[derive(Debug)]
pub struct Program {
    /// Name of the program on the pages.
    pub name: &'static str,
    /// Path of the program.
    pub path: &'static str,
    /// Prefixes with which the pages run it.
    pub starts: &'static [&'static str],
    /// Prefixes with which the pages run the other programs of the repository.
    pub others: &'static [&'static str],
    /// Returns true if a command draws.
    pub draws: fn(&str) -> bool,
    /// True if the program was built with the renderer.
    pub renders: bool,
    /// True if commands that draw work on this machine.
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
    /// Language of the block.
    pub language: String,
    /// Range of its text in the page.
    pub at: Range<usize>,
    /// True if only blank lines separate it from the block before.
    follows: bool,
    /// Reason not to run it.
    not_run: Option<String>,
    /// Name of the file with its text.
    file: Option<String>,
}

/// Reason not to run the block after this line.
fn reason(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- not run: ")?.strip_suffix(" -->")
}

/// Name of the file with the text of the block after this line.
fn file_name(line: &str) -> Option<&str> {
    line.strip_prefix("<!-- file: ")?.strip_suffix(" -->")
}

/// The fenced blocks of a page.
pub fn blocks(page: &str) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    let (mut inside, mut follows, mut at) = (false, false, 0);
    let (mut not_run, mut file) = (None, None);
    for line in page.split_inclusive('\n') {
        let end = at + line.len();
        match (line.trim_end().strip_prefix("```"), inside) {
            (Some(language), false) => {
                let (not_run, file) = (not_run.take(), file.take());
                blocks.push(Block { language: language.to_owned(), at: end..end, follows, not_run, file });
                inside = true;
            }
            (Some(_), true) => (inside, follows) = (false, true),
            (None, true) => blocks.last_mut().unwrap().at.end = end,
            (None, false) if line.trim().is_empty() => {}
            (None, false) => {
                not_run = reason(line.trim_end()).map(str::to_owned);
                file = file_name(line.trim_end()).map(str::to_owned);
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
        // A hard link if both are on one file system, since the program is large.
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

/// The lines of a block, with those that end in a backslash joined.
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

    /// Returns true if a line runs another program of the repository.
    pub fn is_of_others(&self, line: &str) -> bool {
        self.others.iter().any(|start| line.starts_with(start))
    }
}

/// Returns true if a line is allowed in a block that is not run.
pub fn is_set_up(line: &str) -> bool {
    let word = |prefix: &str| line.strip_prefix(prefix).and_then(|rest: &str| rest.split_whitespace().next());
    let there = |path: String| repository().join(path).exists();
    SET_UP.iter().any(|start| line.starts_with(start))
        && word("./").is_none_or(|script| there(script.to_owned()))
        && word("cargo run --release --example ").is_none_or(|name| there(format!("examples/{name}.rs")))
}

/// Numbers of commands that were run, only parsed, and compared in their output.
#[derive(Debug, Default)]
pub struct Counts {
    /// Run.
    pub run: usize,
    /// Parsed.
    pub parsed: usize,
    /// Compared.
    pub compared: usize,
}

/// Runs a page. Returns the page with the blocks of output replaced by the printed ones.
pub fn run_page(program: &Program, name: &str, page: &str, bless: bool, counts: &mut Counts) -> String {
    let mut blessed = page.to_owned();
    let sandbox = Sandbox::new(program);
    // Output of the block before; `None` if it was skipped.
    let mut printed = None;
    let mut new_texts = Vec::new();
    for block in blocks(page) {
        let text = &page[block.at.clone()];
        if let Some(file) = &block.file {
            std::fs::write(sandbox.work.path().join(file), text).unwrap();
        }
        match (block.language.as_str(), &block.not_run) {
            ("sh", Some(_)) => {
                for line in lines(text) {
                    if program.is_of_others(&line) {
                        continue;
                    }
                    let Some((command, _)) = program.command(&line) else {
                        let allowed = "a command of the repository or an allowed set-up line";
                        assert!(is_set_up(&line), "{name}: found {line}, expected {allowed}");
                        continue;
                    };
                    if (program.draws)(&command) && !program.renders {
                        println!("skipped: {name}: {line}");
                        continue;
                    }
                    // Wrong flags are reported before the help.
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
                    let (command, code) = program
                        .command(&line)
                        .unwrap_or_else(|| panic!("{name}: found {line}, expected a command of this program"));
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
                // Other drivers round differently.
                if !adapter.is_none_or(|adapter| adapter.starts_with("llvmpipe")) {
                    println!("skipped: {name}: output of '{command}', since it differs with this driver");
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

/// Runs the commands of all pages, or writes their output to the pages if `BRDFC_BLESS` is set.
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

/// Output of a command with `[..]` for times and adapters, and the adapter.
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
    let message = format!(
        "{command}\n{page} has:\n{expected}\nthe command prints:\n{found}\n\
         If the change is intended, run ./scripts/bless readme"
    );
    let (a, b): (Vec<_>, Vec<_>) = (expected.split_whitespace().collect(), found.split_whitespace().collect());
    assert_eq!(a.len(), b.len(), "{message}");
    for (a, b) in a.into_iter().zip(b) {
        assert!(same_word(a, b), "{a} is not {b}\n{message}");
    }
}

/// Equal words, or numbers that differ in the last digits.
pub fn same_word(a: &str, b: &str) -> bool {
    a.split(',').count() == b.split(',').count()
        && a.split(',').zip(b.split(',')).all(|(a, b)| {
            let numbers = a.parse::<f64>().ok().zip(b.parse::<f64>().ok());
            // NaN is not equal to itself.
            a == b || numbers.is_some_and(|(a, b)| (a - b).abs() <= TOLERANCE * a.abs().max(b.abs()))
        })
}
