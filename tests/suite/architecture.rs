//! Checks that everything that `docs/ARCHITECTURE.md` names exists.
//!
//! Backticks contain paths of files and folders, items as `brdfc_crate::module::item` or `brdfc_crate::module::Type::item`, and
//! functions of shaders as `file.wgsl::function`. `NAME` and similar words in a path are placeholders.

use crate::layers::code::{code_of, declares};
use std::path::{Path, PathBuf};

/// Files with shader functions.
const SHADER: &str = ".wgsl::";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Texts in backticks, line by line, without code blocks.
fn quoted(text: &str) -> Vec<Vec<&str>> {
    let mut in_block = false;
    let of_line = |line| -> Vec<&str> { str::split(line, '`').skip(1).step_by(2).collect() };
    text.lines()
        .map(|line| {
            let fence = line.trim_start().starts_with("```");
            in_block ^= fence;
            if in_block || fence { Vec::new() } else { of_line(line) }
        })
        .collect()
}

/// Finds the folder of a crate by its name in code.
fn folder_of(name: &str) -> Option<PathBuf> {
    let short = name.strip_prefix("brdfc_")?;
    let folders = [short.to_owned(), format!("crates/{short}"), format!("crates/codecs/{short}")];
    folders.into_iter().map(|folder| root().join(folder)).find(|folder| folder.join("Cargo.toml").is_file())
}

/// Finds the file of the module that a path leads to, from the root of the repository, and the remaining names.
fn module_file<'a>(path: &[&'a str]) -> Option<(PathBuf, Vec<&'a str>)> {
    let src = folder_of(path.first()?)?.join("src");
    let (mut file, mut folder, mut used) = (src.join("lib.rs"), src, 1);
    for name in &path[1..] {
        let (flat, nested) = (folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs"));
        let Some(next) = [flat, nested].into_iter().find(|file| file.is_file()) else { break };
        (file, folder, used) = (next, folder.join(name), used + 1);
    }
    Some((file.strip_prefix(root()).unwrap().to_owned(), path[used..].to_vec()))
}

/// Returns true for placeholders such as `NAME`.
fn is_place_to_fill_in(text: &str) -> bool {
    let is_capital = |part: &str| ["NAME", "VERB", "STUDY"].contains(&part);
    text.split(['/', '.', '_']).any(is_capital)
}

/// Describes the error of one quotation, and returns the file that it leads to.
fn checked(text: &str) -> Result<Option<PathBuf>, String> {
    if let Some((file, function)) = text.split_once(SHADER) {
        let file = format!("{file}.wgsl");
        let shader = std::fs::read_to_string(root().join(&file)).map_err(|error| format!("{file}: {error}"))?;
        let found = shader.contains(&format!("fn {function}("));
        return if found { Ok(Some(file.into())) } else { Err(format!("{file} has no fn {function}")) };
    }
    if text.starts_with("brdfc_") && text.contains("::") {
        let path: Vec<&str> = text.split("::").collect();
        let (file, items) = module_file(&path).ok_or_else(|| format!("{text}: no such crate"))?;
        if items.is_empty() || items.len() > 2 {
            return Err(format!("{text}: {} is a module, or has no module of that name", file.display()));
        }
        let code = code_of(&std::fs::read_to_string(root().join(&file)).unwrap());
        let missing = items.iter().find(|item| !declares(&code, item) && !code.contains(&format!("impl {item} ")));
        return missing.map_or(Ok(Some(file.clone())), |item| Err(format!("{text}: {} has no {item}", file.display())));
    }
    let is_path = text.contains('/') && !text.contains([' ', ':', '(', '=', '²']) && !text.starts_with(['/', '.']);
    if is_path && !is_place_to_fill_in(text) && !root().join(text).exists() {
        return Err(format!("{text}: no such file"));
    }
    Ok(if is_path { Some(text.into()) } else { None })
}

#[test]
fn what_the_architecture_page_names_is_there() {
    let text = std::fs::read_to_string(root().join("docs/ARCHITECTURE.md")).unwrap();
    let (mut wrong, mut items, mut shaders) = (Vec::new(), 0, 0);
    for line in quoted(&text) {
        let files: Vec<_> = line.iter().filter_map(|text| checked(text).ok().flatten()).collect();
        for text in line {
            match checked(text) {
                Err(problem) => wrong.push(problem),
                // The file of a function is next to it.
                Ok(Some(file)) if text.starts_with("brdfc_") => {
                    items += 1;
                    if files.iter().filter(|other| **other == file).count() < 2 {
                        wrong.push(format!("{text} is in {}, which its line does not say", file.display()));
                    }
                }
                Ok(_) => shaders += usize::from(text.contains(SHADER)),
            }
        }
    }
    assert!(items > 60 && shaders > 20, "{items} items, {shaders} functions of shaders");
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// Functions of shaders without a twin of the same name.
const NAMED_OTHERWISE: [&str; 7] = [
    // Loops and closures on the CPU.
    "decide",
    "merged",
    "shade",
    // `Angles::of`.
    "table_brdf_angles",
    "wavelet_brdf_tap",
    // Ahead of time on the CPU: the mean of light around a direction.
    "joined",
    // The caller names it.
    "DIRECTION_MESH_FUNCTION",
];

/// The last names of the functions of a row, and of its shaders' functions.
fn names_of_row(line: &[&str]) -> [Vec<String>; 2] {
    let last = |text: &str| text.rsplit("::").next().unwrap().to_owned();
    let items = line.iter().filter(|text| text.starts_with("brdfc_")).map(|text| last(text));
    [items.collect(), line.iter().filter(|text| text.contains(SHADER)).map(|text| last(text)).collect()]
}

/// The functions of shaders that have the name of no function on the CPU in their row.
fn without_twins(text: &str) -> Vec<String> {
    let rows = quoted(text).into_iter().map(|line| names_of_row(&line));
    let unlike = rows.flat_map(|[items, shaders]| {
        let has_twin =
            move |shader: &String| items.iter().any(|item| shader == item || shader.ends_with(&format!("_{item}")));
        shaders.into_iter().filter(move |shader| !has_twin(shader))
    });
    unlike.collect()
}

#[test]
fn shaders_and_their_twins_have_one_name() {
    let text = std::fs::read_to_string(root().join("docs/ARCHITECTURE.md")).unwrap();
    let mut found = without_twins(&text);
    found.sort();
    found.dedup();
    found.retain(|shader| !NAMED_OTHERWISE.contains(&shader.as_str()));
    assert!(found.is_empty(), "{found:#?}");
    let control = "| eq. 1 | `brdfc_render::shade::from_light` | `x/y.wgsl::reflect` |\n\
                   | eq. 2 | `brdfc_formats::a::B::flight` | `x/y.wgsl::bandwidth_flight` |";
    assert_eq!(without_twins(control), ["reflect"]);
}

/// Text files of the repository by their paths, without those that only describe earlier versions.
fn texts() -> Vec<(PathBuf, String)> {
    let mut folders = ["crates", "docs", "examples", "formats", "src", "studies", "tests"].map(PathBuf::from).to_vec();
    let mut texts = vec![];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(root().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = folder.join(entry.file_name());
            let is_text =
                path.extension().is_some_and(|extension| ["rs", "wgsl", "md", "toml"].iter().any(|e| extension == *e));
            if entry.file_type().unwrap().is_dir() {
                if !["target", "node_modules", "corpus"].iter().any(|name| path.ends_with(name)) {
                    folders.push(path);
                }
            } else if is_text {
                texts.push((path.clone(), std::fs::read_to_string(root().join(&path)).unwrap()));
            }
        }
    }
    texts
}

/// Paths from the root of the repository that a text has in backticks.
fn quoted_paths(text: &str) -> impl Iterator<Item = &str> {
    let quotations = text.lines().flat_map(|line| line.split('`').skip(1).step_by(2));
    quotations.filter(|text| {
        let is_ours = ["crates/", "docs/", "formats/", "src/", "studies/", "tests/"]
            .iter()
            .any(|folder| text.starts_with(folder));
        let is_file = [".rs", ".wgsl", ".md"].iter().any(|extension| text.ends_with(extension));
        is_ours && is_file && !is_place_to_fill_in(text) && !text.contains(['*', ' ', 'C'])
    })
}

#[test]
fn files_that_comments_and_pages_name_are_there() {
    let (mut wrong, mut count) = (Vec::new(), 0);
    for (path, text) in texts() {
        for quoted in quoted_paths(&text) {
            count += 1;
            if !root().join(quoted).is_file() && !path.ends_with("architecture.rs") {
                wrong.push(format!("{}: {quoted}", path.display()));
            }
        }
    }
    assert!(count > 100, "{count} paths");
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(quoted_paths("see `src/nowhere.rs`, `src/NAME.rs` and `a.rs`").collect::<Vec<_>>(), ["src/nowhere.rs"]);
}

#[test]
fn what_is_not_there_is_seen() {
    for text in [
        "brdfc_wavelet::haar::transform",
        "brdfc_metrics::image::flip::flip",
        "brdfc_formats::bandwidth::propagation::Bandwidth::flight",
        "formats/src/wavelet/decode.wgsl::wavelet_brdf_level_of_detail",
        "tests/suite/architecture.rs",
        "formats/src/NAME/spec.md",
        "cargo test --test suite",
    ] {
        assert!(checked(text).is_ok(), "{text}: {:?}", checked(text));
    }
    for text in [
        "brdfc_wavelet::haar::transformed",
        "brdfc_wavelets::haar::transform",
        "brdfc_wavelet::hare::transform",
        "brdfc_formats::bandwidth::propagation::Bandwidth::flown",
        "formats/src/wavelet/decode.wgsl::wavelet_brdf_levels",
        "formats/src/wavelet/decoder.wgsl::wavelet_brdf_level_of_detail",
        "tests/suite/architect.rs",
    ] {
        assert!(checked(text).is_err(), "{text}");
    }
    assert_eq!(quoted("a `b` c `d/e`\n```\n`f`\n```\n`g`"), [vec!["b", "d/e"], vec![], vec![], vec![], vec!["g"]]);
}
