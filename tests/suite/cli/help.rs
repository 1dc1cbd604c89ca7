//! Help, versions, wrong usage.

use crate::common::cli::Folder;
use std::collections::BTreeSet;

/// The commands that the help lists, except clap's own and optional ones.
fn commands(folder: &Folder) -> Vec<String> {
    let help = folder.run(&["--help"]).succeeded().stdout;
    let list = help.split("\nCommands:\n").nth(1).unwrap().split("\n\n").next().unwrap().to_owned();
    // The description of a command may continue below it, with more indentation.
    let names = list.lines().filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    let names: Vec<String> = names.map(|line| line.split_whitespace().next().unwrap().to_owned()).collect();
    assert!(names.len() > 11, "{names:?}");
    names.into_iter().filter(|name| !["help", "render"].contains(&name.as_str())).collect()
}

#[test]
fn every_command_has_help_with_an_example() {
    let folder = Folder::new();
    let top = folder.run(&["--help"]).succeeded().stdout;
    assert!(top.contains("Examples:\n  brdfc build ") && top.contains("Exit codes:\n  0    done\n  1    "), "{top}");
    let mut commands = commands(&folder);
    if cfg!(feature = "render") {
        commands.push("render".to_owned());
    }
    for command in &commands {
        let ran = folder.run(&[command, "--help"]).succeeded();
        assert_eq!(ran.stderr, "");
        assert!(ran.stdout.contains(&format!("\n  brdfc {command} ")), "{command}: {}", ran.stdout);
        for line in ran.stdout.lines() {
            assert!(line.chars().count() <= 120, "{command}: {line}");
        }
        // Defaults are part of the descriptions.
        assert!(!ran.stdout.contains("[default:"), "{command}: {}", ran.stdout);
        let (own, common) = ran.stdout.split_once("\nCommon options:\n").unwrap();
        for flag in ["  -q, --quiet\n", "  -j, --jobs <N>\n", "      --json\n"] {
            assert!(!own.contains(flag) && common.contains(flag), "{command}: {flag}");
        }
        // Examples are not wrapped.
        let examples = common.split("\nExamples:\n").nth(1).unwrap().split("\n\n").next().unwrap();
        assert!(examples.lines().all(|line| line.starts_with("  brdfc ")), "{command}: {examples}");
    }
    let sets = folder.run(&["flatten", "--help"]).stdout;
    let sets = sets.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(sets.contains("grid:2x6@50 has 1 + 6 = 7 directions"), "{sets}");
    assert!(folder.run(&["info", "--help"]).stdout.contains("info-surface"), "all schemas of info");
    for model in ["lambert", "lewis", "ward", "poulin", "ggx", "velvet"] {
        assert!(folder.run(&["synth", "--help"]).stdout.contains(&format!("\n{model} ")), "{model}");
    }
}

#[test]
fn the_examples_in_the_help_parse() {
    let folder = Folder::new();
    // These take seconds or minutes, and have tests of their own.
    for command in commands(&folder).iter().filter(|command| *command != "flatten") {
        let help = folder.run(&[command, "--help"]).stdout;
        for line in help.lines().filter(|line| line.trim_start().starts_with("brdfc ")) {
            let words = line.split(['<', '>']).next().unwrap().split_whitespace().skip(1);
            let arguments: Vec<&str> = words.map(|word| word.trim_matches('\'')).collect();
            // The files of the examples do not exist, so the worst allowed result is code 3 or 4.
            let ran = folder.run(&arguments);
            assert_ne!(ran.code, 2, "{line}: {}", ran.stderr);
        }
    }
}

#[test]
fn the_version_is_that_of_the_package() {
    let ran = Folder::new().run(&["--version"]).succeeded();
    assert_eq!(ran.stdout, format!("brdfc {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn wrong_usage_exits_with_2_and_says_what_is_allowed() {
    let folder = Folder::new();
    for (arguments, expected) in [
        (&[][..], "Usage:"),
        (&["frobnicate"], "unrecognized subcommand 'frobnicate'"),
        (&["encod", "a", "-o", "b"], "'encode'"),
        (&["encode", "synth:lewis"], "--output"),
        (
            &["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "12"],
            "--grid: found 12, expected 2, 4, 8, 16, 32 or 64",
        ),
        (
            &["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "-1"],
            "--grid: found -1, expected 2, 4, 8, 16, 32 or 64",
        ),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--bits", "9"], "--bits: found 9, expected 8, or 10 to 16"),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--ratio", "0.5"], "--ratio: found 0.5, expected 1 to 4096"),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--ratio", "NaN"], "--ratio: found NaN, expected 1 to 4096"),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--max-error", "0"], "--max-error: found 0, expected a positive"),
        (
            &["encode", "synth:lewis", "-o", "p.ktx2", "--max-error", "3"],
            "--max-error: found 3, expected a fraction or a percentage; write 0.03 or 3%",
        ),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--max-error", "inf"], "--max-error: found inf, expected"),
        (&["encode", "synth:lewis", "-o", "p.ktx2", "--ratio", "4", "--max-error", "0.1"], "cannot be used with"),
        (
            &["encode", "synth:lewis", "-o", "p.ktx2", "--parameterisation", "half-difference"],
            "--parameterisation: found \"half-difference\", expected tangent-pole; use the codec table for",
        ),
        (
            &["encode", "synth:lambert", "-o", "p.ktx2", "--grid", "64", "--ratio", "1"],
            "--ratio: found 1, which needs 5462 slices, expected at most 2048 slices",
        ),
        (&["compare", "synth:lewis", "synth:lewis", "--directions", "0"], "--directions: found 0, expected 1 to"),
        (&["compare", "synth:lewis", "synth:lewis", "--max-error=-1"], "--max-error: found -1, expected"),
        (&["info", "synth:lewis", "--jobs", "2000"], "--jobs: found 2000, expected 0 to 1024"),
        (&["synth", "lewis", "-o", "file.png"], "--output: found file.png, expected a name that ends in .binary"),
        (&["synth", "lewis", "-o", "a.binary", "--dimensions", "0x1x1"], "--dimensions: found 0x1x1, expected three"),
        (&["synth", "lewis", "-o", "a.brdf", "--rows", "0"], "--rows: found 0, expected 1 to"),
        (&["synth", "lewis", "-o", "a.brdf", "--gaps", "2"], "--gaps: found 2, expected 0 to 0.9"),
        (&["synth", "lewis", "-o", "a.brdf", "--noise", "NaN"], "--noise: found NaN, expected 0 to 2"),
        (&["synth", "lewis", "-o", "a.brdf", "--noise", "300%"], "--noise: found 300%, expected 0 to 2"),
        (&["synth", "lewis", "-o", "a.brdf", "--rows", "many"], "--rows: found \"many\", expected "),
        (&["schema", "nothing"], "possible values: build, material"),
    ] {
        let ran = folder.run(arguments);
        assert_eq!(ran.code, 2, "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected) && ran.stdout.is_empty(), "{arguments:?}: {}", ran.stderr);
    }
    assert!(folder.files(".").is_empty());
}

/// Numeric flags of a command from its help: long names with their value names.
fn numbers(folder: &Folder, command: &str) -> Vec<String> {
    const VALUES: [&str; 17] = [
        "<N>",
        "<E>",
        "<B>",
        "<R>",
        "<L>",
        "<M>",
        "<P>",
        "<A>",
        "<S>",
        "<SHARE>",
        "<X>",
        "<TILES>",
        "<SIZE>",
        "<WxH>",
        "<HxDxP>",
        "<N|auto>",
        "<N|FILE.csv>",
    ];
    let help = folder.run(&[command, "--help"]).succeeded().stdout;
    let mut found = Vec::new();
    for line in help.lines().filter(|line| line.trim_start().starts_with('-')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some(at) = words.iter().position(|word| word.starts_with("--")) else { continue };
        let value = words.get(at + 1).copied().unwrap_or_default();
        if VALUES.contains(&value) {
            found.push(words[at].to_owned());
        }
    }
    found
}

/// A negative number is a value wherever a number is expected, and is rejected with the allowed range.
#[test]
fn negative_numbers_are_values() {
    let folder = Folder::new();
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    folder.write("h.png", "no image");
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "2"]).succeeded();
    let before = folder.files(".");
    let mut tried = 0;
    for (command, arguments) in [
        ("encode", &["synth:lewis", "-o", "x.ktx2"][..]),
        ("eval", &["p.ktx2", "--directions", "pairs.csv"]),
        ("compare", &["p.ktx2", "p.ktx2"]),
        ("synth", &["lewis", "-o", "x.brdf"]),
        ("bandwidth", &["synth:lewis", "-o", "x.ktx2"]),
        ("samples", &["synth:lewis", "-o", "x.ktx2"]),
        ("flatten", &["h.png", "-o", "x"]),
        ("watch", &["p.ktx2"]),
        #[cfg(feature = "render")]
        ("render", &["p.ktx2"]),
    ] {
        for flag in numbers(&folder, command) {
            // These may be negative, or are not numbers.
            if ["--min-psnr", "--height-scale", "--height-offset", "--parameterisation"].contains(&flag.as_str()) {
                continue;
            }
            // Some require other flags.
            let more: &[&str] = match (command, flag.as_str()) {
                ("bandwidth", "--size") => &["--kind", "texture"],
                (
                    "render",
                    "--budget" | "--caution" | "--bandwidth-directions" | "--antialias" | "--forward" | "--truth",
                ) => &["--adaptive"],
                ("render", "--texture-size") => &["--adaptive", "--texture", "h.png"],
                _ => &[],
            };
            for value in ["-1", "-.5", "-1e3", "-5%", "-1x2"] {
                let ran = folder.run(&[&[command], arguments, more, &[&flag, value]].concat());
                assert_eq!((ran.code, ran.stdout.as_str()), (2, ""), "{command} {flag} {value}: {}", ran.stderr);
                assert!(ran.stderr.starts_with("brdfc: "), "{command} {flag} {value}: {}", ran.stderr);
                assert!(
                    ran.stderr.contains("does not apply to")
                        || ran.stderr.contains(": found ") && ran.stderr.contains(", expected "),
                    "{flag}: {}",
                    ran.stderr
                );
                tried += 1;
            }
        }
    }
    assert!(tried > 200, "{tried}");
    assert!(folder.files(".") == before);
}

#[test]
fn json_is_a_flag_of_the_program() {
    let folder = Folder::new();
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    folder.write("s.toml", "[materials.a]\nsource = 'synth:lambert'\n[[uses]]\nmaterial = 'a'\n");
    for arguments in [
        &["info", "synth:lewis"][..],
        &["compare", "synth:lewis", "synth:ward", "--directions", "10"],
        &["build", "s.toml", "--dry-run"],
        &["schema", "info"],
    ] {
        let before = folder.run(&[&["--json"], arguments].concat()).succeeded();
        let behind = folder.run(&[arguments, &["--json"]].concat()).succeeded();
        assert!(before.json().is_object() && before.stdout == behind.stdout, "{arguments:?}");
    }
    for arguments in [
        &["eval", "synth:lewis", "--directions", "pairs.csv"][..],
        &["synth", "lewis", "-o", "a.binary"],
        &["generate", "man", "--out", "man"],
    ] {
        let name = arguments[0];
        let allowed = "bandwidth, build, compare, convert, encode, environment, flatten, info, plan, pwt, render, report, samples, shader, verify, view and watch";
        for ran in [folder.run(&[&["--json"], arguments].concat()), folder.run(&[arguments, &["--json"]].concat())] {
            assert_eq!((ran.code, ran.stdout.as_str()), (2, ""), "{arguments:?}");
            assert_eq!(ran.stderr, format!("brdfc: --json does not apply to {name}, only to {allowed}\n"));
        }
    }
    assert_eq!(folder.files(".").len(), 2);
}

/// Every command, with those of its options that determine the output: the commands that reject `--json` are those on the page.
#[test]
fn what_refuses_json_is_what_the_page_says() {
    let folder = Folder::new();
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/command-line.md")).unwrap();
    let list = page.split("report and reject it with exit code 2: ").nth(1).unwrap().split(".\n").next().unwrap();
    let listed: BTreeSet<String> = list.split('`').skip(1).step_by(2).map(str::to_owned).collect();
    let mut tried = BTreeSet::new();
    let mut refusing = BTreeSet::new();
    for (name, arguments) in [
        ("build", &["build", "gone"][..]),
        ("build --shard", &["build", "synth:lambert", "--shard", "1/2"]),
        ("build --only", &["build", "synth:lambert", "--only", "lambert.brdf"]),
        ("build --dry-run", &["build", "gone", "--dry-run", "--explain"]),
        ("watch", &["watch", "gone"]),
        ("encode", &["encode", "gone.binary", "-o", "x.ktx2"]),
        ("encode --codec lobes", &["encode", "gone.binary", "--codec", "lobes", "-o", "x.ktx2"]),
        ("encode to stdout", &["encode", "gone.binary", "-o", "-"]),
        ("eval", &["eval", "gone.binary", "--directions", "pairs.csv"]),
        ("compare", &["compare", "gone.binary", "synth:lambert"]),
        ("convert", &["convert", "gone.brdf", "-o", "x.binary"]),
        ("info", &["info", "gone.binary"]),
        ("synth", &["synth", "lewis", "-o", "a.binary"]),
        ("synth of a structure", &["synth", "button", "-o", "a.obj"]),
        ("bandwidth", &["bandwidth", "gone.binary", "-o", "x.ktx2"]),
        ("pwt", &["pwt", "gone", "-o", "x.ktx2"]),
        ("samples", &["samples", "gone.binary", "-o", "x.ktx2"]),
        ("environment", &["environment", "gone.exr", "-o", "x.ktx2"]),
        ("shader", &["shader", "gone.ktx2", "--language", "glsl"]),
        ("flatten", &["flatten", "gone.obj", "-o", "flat"]),
        ("view", &["view", "gone.ktx2", "-o", "page.html"]),
        ("report", &["report", "gone", "-o", "page.html"]),
        ("verify", &["verify", "gone"]),
        ("plan --format ninja", &["plan", "synth:lambert", "--format", "ninja"]),
        ("plan --format json", &["plan", "synth:lambert", "--format", "json"]),
        ("schema", &["schema", "info"]),
        ("generate", &["generate", "man", "--out", "man"]),
        ("render", &["render", "gone.binary", "-o", "x.png"]),
        ("render --adaptive", &["render", "gone.binary", "--adaptive", "-o", "x.png"]),
        ("render --contact", &["render", "gone.toml", "--contact", "x.png"]),
    ] {
        let ran = folder.run(&[arguments, &["--json"]].concat());
        tried.insert(arguments[0].to_owned());
        if ran.stderr.starts_with("brdfc: --json does not apply to ") {
            assert_eq!(ran.code, 2, "{name}: {}", ran.stderr);
            // In any form, it rejects the flag alone.
            refusing.insert(name.split(" of ").next().unwrap().to_owned());
        } else {
            assert!(!ran.stderr.contains("--json"), "{name}: {}", ran.stderr);
        }
    }
    assert_eq!(refusing, listed);
    for command in commands(&folder) {
        assert!(tried.contains(&command), "{command} is not tried");
    }
}
