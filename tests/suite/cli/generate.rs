//! Shell completions and man pages.

use crate::common::cli::Folder;
use std::process::Command;

/// The commands of the program, by the list in its help.
fn commands(folder: &Folder) -> Vec<String> {
    let help = folder.run(&["--help"]).succeeded().stdout;
    let list = help.split("\nCommands:\n").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.map(|line| line.split_whitespace().next().unwrap().to_owned()).filter(|name| name != "help").collect()
}

/// Runs a tool on a file, if the tool exists: whether it accepts the file, and what it prints.
fn asked(tool: &str, arguments: &[&str], folder: &Folder) -> Option<(bool, String)> {
    match Command::new(tool).args(arguments).current_dir(folder.path()).output() {
        Ok(output) => {
            let text = [output.stdout, output.stderr].concat();
            Some((output.status.success(), String::from_utf8_lossy(&text).into_owned()))
        }
        Err(error) => {
            println!("skipped: {tool}: {error}");
            None
        }
    }
}

#[test]
fn there_is_a_completion_script_for_every_shell() {
    let folder = Folder::new();
    let message = folder.run(&["generate", "completions", "--out", "completions"]).succeeded().stdout;
    let files = folder.files("completions");
    let names: Vec<&str> = files.keys().map(String::as_str).collect();
    assert_eq!(names, ["_brdfc", "_brdfc.ps1", "brdfc.bash", "brdfc.elv", "brdfc.fish"]);
    assert_eq!(message.lines().count(), 5);
    let commands = commands(&folder);
    assert!(commands.len() > 11, "{commands:?}");
    for (name, script) in &files {
        let script = String::from_utf8(script.clone()).unwrap();
        assert!(message.contains(name.as_str()), "{name}");
        for command in &commands {
            assert!(script.contains(command.as_str()), "{name}: no {command}");
        }
        for flag in ["max-delta-e", "json"] {
            assert!(script.contains(flag), "{name}: no --{flag}");
        }
    }
}

#[test]
fn shells_accept_their_scripts() {
    let folder = Folder::new();
    folder.run(&["generate", "completions", "--out", "."]).succeeded();
    for (shell, file) in [("bash", "brdfc.bash"), ("zsh", "_brdfc"), ("fish", "brdfc.fish")] {
        if let Some((taken, text)) = asked(shell, &["-n", file], &folder) {
            assert!(taken, "{shell}: {text}");
        }
    }
    // An input that a shell would reject is detected.
    folder.write("broken.bash", [&folder.read("brdfc.bash")[..], b"\nif true\n"].concat());
    if let Some((taken, _)) = asked("bash", &["-n", "broken.bash"], &folder) {
        assert!(!taken);
    }
    let complete =
        "source brdfc.bash; COMP_WORDS=(brdfc enc); COMP_CWORD=1; _brdfc brdfc enc brdfc; echo ${COMPREPLY[@]}";
    if let Some((_, text)) = asked("bash", &["-c", complete], &folder) {
        assert_eq!(text, "encode\n");
    }
}

#[test]
fn every_command_has_a_man_page() {
    let folder = Folder::new();
    folder.run(&["generate", "man", "--out", "man/man1"]).succeeded();
    let pages = folder.files("man/man1");
    let commands = commands(&folder);
    let mut expected: Vec<String> = commands.iter().map(|name| format!("brdfc-{name}.1")).collect();
    expected.push("brdfc.1".to_owned());
    expected.sort();
    let mut names: Vec<&String> = pages.keys().collect();
    names.sort();
    assert_eq!(names, expected.iter().collect::<Vec<_>>());
    for (name, page) in &pages {
        let page = String::from_utf8(page.clone()).unwrap();
        for heading in [".TH ", ".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS"] {
            assert!(page.contains(heading), "{name}: no {heading}");
        }
    }
    let again = folder.run(&["generate", "man", "--out", "again"]).succeeded();
    assert_eq!(again.stderr, "");
    assert!(folder.files("again") == pages, "the same bytes");
}

#[test]
fn man_pages_are_rendered() {
    let folder = Folder::new();
    folder.run(&["generate", "man", "--out", "."]).succeeded();
    let rendered = ["brdfc.1", "brdfc-encode.1"].map(|page| {
        let groff = asked("groff", &["-man", "-Tutf8", "-ww", "-P-cbou", page], &folder);
        groff.or_else(|| asked("mandoc", &["-Tutf8", page], &folder))
    });
    let [Some((true, program)), Some((true, encode))] = rendered else {
        assert!(rendered.iter().all(Option::is_none), "{rendered:?}");
        return;
    };
    assert!(program.contains("brdfc-encode(1)") && program.contains("Exit codes"), "{program}");
    let example = "brdfc encode red-plastic.binary -o red.ktx2         the smallest pack without visible error\n";
    assert!(program.contains(example), "{program}");
    assert!(
        encode.contains("--max-delta-e")
            && encode.contains("mean ΔE")
            && encode.contains("brdfc encode red-plastic.binary"),
        "{encode}"
    );
    assert!(!encode.contains("warning"), "{encode}");
}

#[test]
fn the_command_stays_out_of_the_list() {
    let folder = Folder::new();
    assert!(!commands(&folder).contains(&"generate".to_owned()));
    folder.run(&["generate", "--help"]).succeeded();
    let ran = folder.run(&["generate", "man", "--out", "-"]);
    assert!(ran.code == 2 && ran.stderr.contains("-: not a folder; for a folder of this name"), "{}", ran.stderr);
}
