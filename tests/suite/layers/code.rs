//! Rust text, as far as the layers need it: files as modules, imports, and named paths.

use std::path::{Path, PathBuf};

/// A name that a file brings into scope.
#[derive(Debug, Clone, PartialEq)]
pub struct Import {
    /// The full path; ends in `*` if it is everything of a module.
    pub path: Vec<String>,
    /// The name in this file.
    pub name: String,
    /// True if other files may import it from this file.
    pub public: bool,
}

/// Removes comments, contents of string literals, and code that only tests compile.
pub fn code_of(text: &str) -> String {
    without_tests(&without_literals(text))
}

fn without_literals(text: &str) -> String {
    let mut code = String::new();
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '/' if chars.peek() == Some(&'/') => {
                while chars.peek().is_some_and(|c| *c != '\n') {
                    chars.next();
                }
            }
            '"' => {
                while let Some(inside) = chars.next() {
                    match inside {
                        '\\' => drop(chars.next()),
                        '"' => break,
                        _ => {}
                    }
                }
                code += "\"\"";
            }
            '\'' => {
                // A character literal; a lifetime has no quote two characters on.
                code.push(c);
                let mut ahead = chars.clone();
                let first = ahead.next();
                if first == Some('\\') {
                    chars.nth(1);
                    while chars.next().is_some_and(|inside| inside != '\'') {}
                    code.push(c);
                } else if ahead.next() == Some('\'') {
                    chars.nth(1);
                    code.push(c);
                }
            }
            _ => code.push(c),
        }
    }
    code
}

/// Removes every item after `#[cfg(test)]`, up to its semicolon or to the end of its braces.
fn without_tests(code: &str) -> String {
    let mut parts = code.split("#[cfg(test)]");
    let mut retained = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let mut depth = 0;
        let end = part.find(|c| {
            depth += match c {
                '{' => 1,
                '}' => -1,
                _ => 0,
            };
            depth == 0 && (c == ';' || c == '}')
        });
        retained += end.map_or("", |end| &part[end + 1..]);
    }
    retained
}

fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}

/// Words, `::`, and every other character that is not blank.
fn tokens(code: &str) -> Vec<&str> {
    let bytes = code.as_bytes();
    let mut found = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let start = at;
        if is_word(bytes[at]) {
            while at < bytes.len() && is_word(bytes[at]) {
                at += 1;
            }
        } else if code[at..].starts_with("::") {
            at += 2;
        } else {
            at += code[at..].chars().next().map_or(1, char::len_utf8);
        }
        if !code[start..at].trim().is_empty() {
            found.push(&code[start..at]);
        }
    }
    found
}

/// The imports of a file, and every path of two or more names, or single name, in the rest of its code.
pub fn imports_and_paths(code: &str) -> (Vec<Import>, Vec<Vec<String>>) {
    let tokens = tokens(code);
    let word = |at: usize| tokens.get(at).is_some_and(|token| is_word(token.as_bytes()[0]));
    let (mut imports, mut paths) = (Vec::new(), Vec::new());
    let mut at = 0;
    while at < tokens.len() {
        if tokens[at] == "use" && word(at + 1) {
            let public = at > 0 && (tokens[at - 1] == "pub" || tokens[at - 1] == ")");
            at = tree(&tokens, at + 1, &[], public, &mut imports);
        } else if tokens[at] == "mod" {
            at += 2;
        } else if word(at) {
            let mut path = vec![tokens[at].to_owned()];
            while tokens.get(at + 1) == Some(&"::") && word(at + 2) {
                path.push(tokens[at + 2].to_owned());
                at += 2;
            }
            paths.push(path);
            at += 1;
        } else {
            at += 1;
        }
    }
    (imports, paths)
}

/// Reads the tree of imports that starts at `at` after `prefix`, and returns where it ends.
fn tree(tokens: &[&str], mut at: usize, prefix: &[String], public: bool, found: &mut Vec<Import>) -> usize {
    let mut path = prefix.to_vec();
    loop {
        match tokens.get(at).copied() {
            Some("{") => {
                at += 1;
                while at < tokens.len() && tokens[at] != "}" {
                    at = tree(tokens, at, &path, public, found);
                    at += usize::from(tokens.get(at) == Some(&","));
                }
                return at + 1;
            }
            Some("::") => at += 1,
            // The `self` of `{self, ..}` is the path before the braces.
            Some("self") if !prefix.is_empty() => at += 1,
            Some("as") => {
                found.push(Import { path, name: tokens[at + 1].to_owned(), public });
                return at + 2;
            }
            Some(name) if name == "*" || is_word(name.as_bytes()[0]) => {
                path.push(name.to_owned());
                at += 1;
            }
            _ => {
                let name = path.last().cloned().unwrap_or_default();
                found.push(Import { path, name, public });
                return at;
            }
        }
    }
}

/// Every Rust file under `folder`, in the order of their names.
pub fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut entries: Vec<_> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            files.extend(rust_files(&path));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            files.push(path);
        }
    }
    files
}

/// The module that a file of `src/` is: `["haar"]` for `haar.rs`, `["fill"]` for `fill/mod.rs`, none for the root.
pub fn module_of(relative: &Path) -> Vec<String> {
    let stem = relative.with_extension("");
    let mut names: Vec<String> = stem.iter().map(|part| part.to_str().unwrap().to_owned()).collect();
    if names.last().is_some_and(|name| name == "mod") || ["lib", "main"].contains(&names.join("/").as_str()) {
        names.pop();
    }
    names
}

/// Returns true if the code of a file declares `name` itself.
pub fn declares(code: &str, name: &str) -> bool {
    const KEYWORDS: [&str; 9] = ["fn", "struct", "enum", "trait", "const", "static", "type", "union", "mod"];
    let tokens = tokens(code);
    tokens.iter().enumerate().any(|(at, token)| {
        *token == name
            && at > 0
            && KEYWORDS.contains(&tokens[at - 1])
            && !(tokens[at - 1] == "mod" && tokens.get(at + 1) == Some(&";"))
    })
}
