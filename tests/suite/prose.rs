//! How pages, help, messages and comments are written: no word that has a plainer one, main clauses first.

use std::path::{Path, PathBuf};

/// Banned words with what to write instead. Words of identifiers count, too.
const WORDS: &[(&str, &str)] = &[
    ("told", "reported, printed, logged"),
    ("mend", "repair"),
    ("mends", "repairs"),
    ("mended", "repaired"),
    ("anew", "again"),
    ("beside", "next to, compared with, as well as"),
    ("nobody", "no one; name who"),
    ("somebody", "someone; name who"),
    ("hear", "observe"),
    ("hears", "observes"),
    ("heard", "observed"),
    ("shelf", "cached material"),
    ("workshop", "context"),
    ("wanted", "target, requested, required"),
    ("whatever", "name what"),
    ("picture", "rendering, image"),
    ("pictures", "renderings, images"),
];

/// Banned phrases with what to write instead.
const PHRASES: &[(&str, &str)] = &[
    ("is had", "is available"),
    ("are had", "are available"),
    ("what is seen", "visible"),
    ("off the grid", "at independent test directions"),
    ("off any grid", "at independent test directions"),
    ("codes of 255", "8-bit levels"),
    ("saw nothing", "had nothing to measure"),
    ("stays closed", "fails"),
    ("has to offer", "required features"),
    ("steps of two", "doublings"),
    ("both ways", "symmetrised"),
    ("is said", "is reported"),
    ("; allowed", ", expected"),
    ("light stack", "RTI capture"),
];

/// Words that no first line of a doc comment begins with: a noun phrase or a verb in the third person does.
const OPENINGS: &[&str] = &["What", "Whether", "Which", "Where", "How", "Those", "That", "Of", "Who", "Whose"];

const FOLDERS: &[&str] = &["src", "crates", "formats", "studies", "tests", "bindings", "examples", "docs", "scripts"];
const EXTENSIONS: &[&str] = &["rs", "md", "ts", "js", "mjs", "py", "pyi", "wgsl", "html", "toml", "sh"];
/// Folders of data, of other people's work and of what is built.
const SKIPPED: &[&str] = &["target", "node_modules", "golden", "dist", ".venv", "build"];

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let name = entry.file_name().unwrap().to_string_lossy().into_owned();
        if entry.is_dir() {
            if !SKIPPED.contains(&name.as_str()) && !name.starts_with('.') {
                files(&entry, found);
            }
        } else if entry.extension().is_some_and(|e| EXTENSIONS.contains(&e.to_string_lossy().as_ref())) {
            found.push(entry);
        }
    }
}

/// Lower-case words of a line; `snake_case` and `CamelCase` are taken apart.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut was_lower = false;
    for letter in line.chars() {
        if !letter.is_alphabetic() || (letter.is_uppercase() && was_lower) {
            words.push(String::new());
        }
        if letter.is_alphabetic() {
            words.last_mut().unwrap().extend(letter.to_lowercase());
        }
        was_lower = letter.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Faults of a text, as lines with their numbers.
fn faults(text: &str, is_page: bool) -> Vec<(usize, String)> {
    let mut found = Vec::new();
    let (mut in_comment, mut in_block) = (false, false);
    for (number, line) in text.lines().enumerate() {
        let mut fault = |what: String| found.push((number + 1, what));
        for word in words(line) {
            if let Some((_, better)) = WORDS.iter().find(|(banned, _)| *banned == word) {
                fault(format!("{word} ({better})"));
            }
        }
        let lower = line.to_lowercase();
        for (phrase, better) in PHRASES.iter().filter(|(phrase, _)| lower.contains(phrase)) {
            fault(format!("{phrase} ({better})"));
        }
        let comment = ["///", "//!"].iter().find_map(|start| line.trim_start().strip_prefix(start)).map(str::trim);
        let is_first = !in_comment;
        in_comment = comment.is_some_and(|comment| !comment.is_empty());
        in_block ^= is_page && line.trim_start().starts_with("```");
        let first = comment.and_then(|comment| comment.split(|c: char| !c.is_alphabetic()).next());
        if let Some(word) = first.filter(|word| is_first && OPENINGS.contains(word)) {
            fault(format!("{word} at the beginning of a doc comment (a noun phrase, or a verb in the third person)"));
        }
        let prose = if is_page && !in_block { Some(line) } else { comment };
        let opens = |sentence: &str| sentence.starts_with("Of ") && sentence.contains(',');
        if prose.is_some_and(|prose| prose.split(". ").any(opens)) {
            fault("a sentence that begins with Of (main clause first)".to_owned());
        }
    }
    found
}

#[test]
fn pages_messages_and_comments_use_plain_words() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths = vec![root.join("README.md"), root.join("CHANGELOG.md")];
    FOLDERS.iter().for_each(|folder| files(&root.join(folder), &mut paths));
    // What is compiled from TypeScript is not written by hand.
    let is_compiled = |path: &Path| path.extension().unwrap() == "js" && path.with_extension("ts").exists();
    paths.retain(|path| !path.ends_with(file!()) && !is_compiled(path));
    paths.sort();
    assert!(paths.len() > 500, "{} files", paths.len());
    let mut lines = Vec::new();
    for path in paths {
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let name = path.strip_prefix(root).unwrap().display().to_string();
        let is_page = name.ends_with(".md");
        lines.extend(faults(&text, is_page).into_iter().map(|(line, what)| format!("{name}:{line}: {what}")));
    }
    assert!(lines.is_empty(), "{}\n{} in all", lines.join("\n"), lines.len());
}

#[test]
fn faults_are_found() {
    let faulty = [
        ("/// Whether it is so.", "Whether"),
        ("//! Of maps, three are read.", "Of"),
        ("let wanted_size = 3;", "wanted"),
        ("struct KeptHeard;", "heard"),
        ("\"--size: found 3; allowed 4\"", "; allowed"),
    ];
    for (line, what) in faulty {
        let found = faults(line, false);
        assert!(found.iter().any(|(_, fault)| fault.starts_with(what) || fault.contains(what)), "{line}: {found:?}");
    }
    assert_eq!(faults("/// Number of texels.\n/// That is all.\nfn count() {}", false), []);
    assert_eq!(faults("Of course.", true), []);
}
