//! The commands of the program in README.md and on the pages under docs/ work, and print what the pages show (by the rules of
//! `brdfc_testing::pages`); links resolve; manifests on the pages parse.
//!
//!     ./scripts/bless readme
//!
//! writes the output of commands to the pages instead of comparing it.

use brdfc_jobs::scene::manifest::Manifest;
use brdfc_testing::pages::{
    Counts, Program, blocks, is_set_up, masked, pages_below, pages_with_commands, read, run_page, run_pages, same_word,
};
use brdfc_testing::repository;

/// Maximum lines of the README, and maximum characters of a line of prose.
const MAX_LINES: usize = 150;
const MAX_CHARACTERS: usize = 120;

const BRDFC: Program = Program {
    name: "brdfc",
    path: env!("CARGO_BIN_EXE_brdfc"),
    starts: &["cargo run --release --features render -- ", "cargo run --release -- ", "brdfc "],
    others: &["cargo run --release -p brdfc-studies ", "brdfc-bench "],
    draws: |command| command.starts_with("brdfc render ") || command.starts_with("brdfc schema render"),
    renders: cfg!(feature = "render"),
    can_draw: false,
};

/// True if commands that draw work here.
fn can_draw() -> bool {
    #[cfg(feature = "render")]
    let found = crate::common::has_adapter();
    #[cfg(not(feature = "render"))]
    let found = false;
    found
}

#[test]
#[cfg(unix)]
fn every_command_of_the_readme_and_the_docs_works() {
    let counts = run_pages(&Program { can_draw: can_draw(), ..BRDFC });
    let bless = std::env::var_os("BRDFC_BLESS").is_some();
    let understood = counts.run >= 25 && counts.parsed >= 5 && (bless || counts.compared >= 3);
    assert!(understood, "the pages were not understood: {counts:?}");
}

#[test]
#[cfg(unix)]
fn pages_that_are_wrong_are_refused() {
    let mut counts = Counts::default();
    let mut refused = |page: &str| {
        let run = std::panic::AssertUnwindSafe(|| run_page(&BRDFC, "page", page, false, &mut counts));
        std::panic::catch_unwind(run).is_err()
    };
    assert!(!refused("```sh\nbrdfc schema info\n```\n"));
    assert!(!refused(
        "<!-- not run: slow -->\n```sh\nbrdfc flatten synth:button -o x\nbrdfc-bench --study rays\n./scripts/test\n```\n"
    ));
    assert!(!refused(
        "<!-- file: a.toml -->\n```toml\n[materials]\n```\n```sh\nbrdfc build a.toml # exit code 1\n```\n"
    ));
    assert!(refused("```sh\nrm -r packs\n```\n"), "a command of others");
    assert!(refused("```sh\nbrdfc schema nothing\n```\n"), "a command that fails");
    assert!(refused("```sh\nbrdfc --version\n```\n\n```text\nbrdfc 77\n```\n"), "another output");
    assert!(refused("```text\nby hand\n```\n"), "an output of nothing");
    assert!(refused("<!-- not run: slow -->\n```sh\nbrdfc --version\n```\n```text\nby hand\n```\n"), "not run");
    assert!(refused("<!-- not run: slow -->\n```sh\nbrdfc flatten --frobnicate\n```\n"), "a flag that is not there");
}

#[test]
#[cfg(unix)]
fn outputs_are_written_in_place() {
    let page = "```sh\nbrdfc --version\n```\n\n```text\nold\n```\n\nold\n";
    let blessed = run_page(&BRDFC, "page", page, true, &mut Counts::default());
    let version = concat!("brdfc ", env!("CARGO_PKG_VERSION"));
    assert_eq!(blessed, format!("```sh\nbrdfc --version\n```\n\n```text\n{version}\n```\n\nold\n"));
}

#[test]
fn the_comparison_of_outputs_can_fail() {
    assert!(same_word("1.000,2", "1.005,2") && same_word("a:1", "a:1"));
    assert!(!same_word("1.00", "1.05") && !same_word("1,2", "1") && !same_word("4:1", "5:1"));
    assert_eq!(BRDFC.command("cargo run --release -- info x # exit code 3"), Some(("brdfc info x".to_owned(), 3)));
    assert_eq!(BRDFC.command("brdfc eval a b   # figure 12"), Some(("brdfc eval a b".to_owned(), 0)));
    assert!(BRDFC.is_of_others("brdfc-bench --json") && BRDFC.command("brdfc-bench --json").is_none());
    assert!(BRDFC.command("rm -r packs").is_none() && !is_set_up("rm -r packs") && !is_set_up("./scripts/nothing"));
    assert!(is_set_up("./scripts/test") && !is_set_up("cargo run --release --example nothing"));
}

#[test]
fn times_and_adapters_are_masked() {
    let (text, adapter) =
        masked("a  1.02 MiB   12.34 s\ndrawn by llvmpipe (LLVM 15), a software driver\n(1.5 s, 3 left)\n");
    assert_eq!(text, "a  1.02 MiB    [..] s\ndrawn by [..]\n([..] s, 3 left)\n");
    assert_eq!(adapter.as_deref(), Some("llvmpipe (LLVM 15), a software driver"));
}

/// Makes the anchor of a heading, as repository hosts do.
fn anchor(heading: &str) -> String {
    let retained = heading.trim().chars().filter(|c| c.is_alphanumeric() || [' ', '-', '_'].contains(c));
    retained.map(|c| if c == ' ' { '-' } else { c }).collect::<String>().to_lowercase()
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
        let folder = repository().join(&page).parent().unwrap().to_owned();
        let targets = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
        for target in targets.filter(|target| !target.starts_with("http")) {
            let (path, heading) = target.split_once('#').unwrap_or((target, ""));
            let file = if path.is_empty() { repository().join(&page) } else { folder.join(path) };
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
    assert!(lines <= MAX_LINES, "README.md: {lines} lines, expected {MAX_LINES}");
    for line in prose(&page).lines().filter(|line| !line.contains("](") && !line.starts_with('|')) {
        assert!(line.chars().count() <= MAX_CHARACTERS, "README.md: {line}");
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
            // Other assets replace materials.
            let asset = manifest.render.asset.is_some() || !manifest.assets.is_empty();
            assert!(asset || !manifest.materials.is_empty() && !manifest.uses.is_empty());
            examples += 1;
        }
    }
    assert!(examples > 0);
}

/// The message about an unknown key lists all known keys.
#[test]
fn every_key_of_the_manifest_is_described() {
    let page = read("docs/manifest.md");
    let of_scene = ["[scene]", "[defaults]", "[materials.a]", "[[uses]]"];
    let of_assets = ["[captures.a]", "[btfs.a]", "[environments.a]", "[captures.a.require]"];
    let of_renderings = ["[render]", "[render.camera]", "[[render.lights]]"];
    for table in of_scene.into_iter().chain(of_assets).chain(of_renderings) {
        let error = Manifest::parse(&format!("{table}\nno_such_key = 1\n")).unwrap_err();
        for key in error.allowed.replace(" or ", ", ").split(", ") {
            assert!(page.contains(&format!("\n| `{key}` |")), "docs/manifest.md does not describe {key} of {table}");
        }
    }
}
