//! Every check with every kind of empty input: a check that has nothing to measure fails. The rows are generated from the checks and
//! their inputs.

use crate::common::cli::{Folder, with_checksum};
use brdfc_jobs::btf_stack::StackFormat;
use brdfc_jobs::rti_capture::write_rti_capture;
use brdfc_pwt::ptm::spread_lights;
use std::fmt::Write as _;

/// A command with its checks, and inputs of which nothing can be measured.
struct Checked {
    command: &'static [&'static str],
    checks: &'static [&'static [&'static str]],
    /// Name, arguments, exit code and message.
    nothings: &'static [(&'static str, &'static [&'static str], i32, &'static str)],
}

const TABLE: &[Checked] = &[
    Checked {
        command: &["encode", "-o", "out.ktx2"],
        checks: &[
            &["--max-delta-e", "100"],
            &["--max-error", "1000%"],
            &["--min-highlight", "0.1"],
            &["--max-delta-e", "100", "--min-highlight", "0"],
        ],
        nothings: &[
            ("black", &["synth:lambert?kd=0"], 1, "black"),
            ("black scan", &["black.csv"], 1, "black"),
            ("negative scan", &["negative.csv"], 1, "black"),
            ("tiny scan", &["tiny.csv"], 1, "black"),
        ],
    },
    Checked {
        command: &["encode", "-o", "out.ktx2", "--max-bytes", "4KiB"],
        checks: &[&["--max-fit-error", "100000%"]],
        nothings: &[
            ("black scan", &["black.csv"], 1, "black"),
            ("negative scan", &["negative.csv"], 1, "black"),
            ("tiny scan", &["tiny.csv"], 1, "black"),
            ("as many rows as a fit takes", &["few.csv"], 1, "no samples can be held out"),
        ],
    },
    Checked {
        command: &["build", "--out", "packs", "--max-bytes", "4KiB"],
        checks: &[&["delta_e.toml"], &["error.toml"]],
        nothings: &[("black", &[], 1, "does not meet its requirements")],
    },
    Checked {
        command: &["build", "--out", "packs"],
        checks: &[&["--max-delta-e", "100"], &["--max-error", "1000%"], &[]],
        nothings: &[
            ("empty folder", &["empty"], 1, "no asset, only one other file"),
            ("no use", &["unused.toml"], 1, "nothing to build"),
        ],
    },
    Checked {
        command: &["compare"],
        checks: &[&["--max-error", "1000%"]],
        nothings: &[
            ("black", &["synth:lambert?kd=0", "synth:lambert?kd=0"], 1, "no sample above"),
            ("black for another", &["synth:lambert?kd=0", "synth:lambert"], 1, "no sample above"),
            ("empty list", &["synth:lambert", "synth:lambert", "--directions", "none.csv"], 3, "no direction pairs"),
            (
                "below the horizon",
                &["synth:lambert", "synth:lambert", "--directions", "below.csv"],
                1,
                "no sample above",
            ),
        ],
    },
    Checked {
        command: &["pwt", "-o", "out.ktx2"],
        checks: &[&["--max-delta-e", "100"], &["--quality", "1"], &["--quality", "1", "--hold-out", "2"]],
        nothings: &[
            ("black photographs", &["dark"], 1, "neither black nor white"),
            ("white photographs", &["white"], 1, "neither black nor white"),
            ("grey photographs", &["grey"], 1, "no contrast"),
        ],
    },
    Checked {
        command: &["compare"],
        checks: &[&["--max-delta-e", "100"]],
        nothings: &[
            ("black photographs", &["dark", "dark"], 1, "neither black nor white"),
            ("white photographs", &["white", "white"], 1, "neither black nor white"),
            ("grey photographs", &["grey", "grey"], 1, "no contrast"),
        ],
    },
    Checked {
        command: &["report", "made", "-o", "page.html"],
        checks: &[&["--tolerance", "5000%"], &[]],
        nothings: &[
            ("missing baseline", &["--against", "gone.json"], 4, "gone.json: cannot read"),
            ("folder without a report", &["--against", "empty"], 4, "empty/report.json: cannot read"),
            ("empty baseline", &["--against", "empty.json"], 3, "missing field `version`"),
        ],
    },
    Checked {
        command: &["verify"],
        checks: &[&[]],
        nothings: &[
            ("empty folder", &["empty"], 1, "nothing to verify"),
            ("empty report", &["empty.json"], 1, "missing field `version`"),
            ("report of nothing", &["nothing.json"], 1, "no files: the build made no material"),
        ],
    },
];

#[cfg(feature = "render")]
const RENDERED: &[Checked] = &[
    Checked {
        command: &["render", "-o", "out.png", "--size", "48x48", "--samples", "1"],
        checks: &[&["--max-delta-e", "100"], &["--max-delta-e-p95", "100"], &["--max-flip", "1"]],
        nothings: &[
            ("black", &["synth:lambert?kd=0"], 1, "black"),
            ("no light", &["synth:lambert", "--exposure", "1e-9"], 1, "neither black nor white"),
            ("white", &["synth:lambert", "--exposure", "1e9"], 1, "neither black nor white"),
            ("one pixel", &["synth:lambert", "--size", "1x1"], 1, "neither black nor white"),
        ],
    },
    Checked {
        command: &["render", "--adaptive", "-o", "out.png", "--size", "48x48", "--scene", "bumpy-ball"],
        checks: &[&["--min-psnr", "1"]],
        nothings: &[
            ("black", &["synth:lambert?kd=0"], 1, "black"),
            ("no light", &["synth:lambert", "--environment", "dark.hdr"], 1, "no light"),
        ],
    },
];

fn scan(value: impl Fn(usize) -> f64, lights: usize, viewers: usize) -> String {
    let mut text = "theta_i,phi_i,theta_o,phi_o,r,g,b\n".to_owned();
    for k in 0..lights * viewers {
        let ([theta_i, theta_o], f) = ([k / viewers, k % viewers].map(|k| 0.1 + 0.12 * k as f64), value(k));
        writeln!(text, "{theta_i},0,{theta_o},{},{f:e},{f:e},{f:e}", 0.4 * (k % 7) as f64).expect("memory");
    }
    text
}

fn inputs() -> Folder {
    let folder = Folder::new();
    folder.write("black.csv", scan(|_| 0.0, 8, 10));
    folder.write("negative.csv", scan(|k| -0.1 - 0.01 * k as f64, 8, 10));
    folder.write("tiny.csv", scan(|_| 1e-310, 8, 10));
    folder.write("few.csv", scan(|k| 0.1 + 0.01 * k as f64, 1, 8));
    let black = "[materials.black]\nsource = \"synth:lambert?kd=0\"\n";
    let used = "[[uses]]\nmaterial = \"black\"\n";
    folder.write("delta_e.toml", format!("{black}require.max_delta_e = 100\n{used}"));
    folder.write("error.toml", format!("{black}require.max_error = \"1000%\"\n{used}"));
    folder.write("unused.toml", black);
    folder.write("empty/notes.txt", "");
    folder.write("empty.json", "{}");
    for (name, value) in [("dark", 1e-4), ("white", 50.0), ("grey", 0.5)] {
        let at = folder.path().join(name);
        write_rti_capture(&at, &spread_lights(12), [8, 8], StackFormat::Exr, |_| vec![[value; 3]; 64]).unwrap();
    }
    let nothing = "{\n  \"version\": 6, \"scene\": \"s\", \"materials\": [], \"skipped\": []\n}";
    folder.write("nothing.json", with_checksum(nothing));
    folder.write("none.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n");
    folder.write("below.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,-1,0,0,1\n");
    let mut dark = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n".to_vec();
    dark.extend([0u8; 8 * 16 * 4]);
    folder.write("dark.hdr", dark);
    folder.run(&["build", "synth:lambert", "--out", "made", "--quiet"]).succeeded();
    folder
}

fn hold(table: &[Checked]) {
    let folder = inputs();
    let (mut rows, mut wrong) = (String::new(), 0);
    for Checked { command, checks, nothings } in table {
        for check in *checks {
            for (nothing, given, code, says) in *nothings {
                // A later flag replaces an earlier one of the same name.
                let replaced = |flag: &&str| given.contains(flag);
                let mut arguments: Vec<&str> = Vec::new();
                let mut own = command.iter();
                while let Some(argument) = own.next() {
                    if argument.starts_with("--") && replaced(argument) {
                        own.next();
                    } else {
                        arguments.push(argument);
                    }
                }
                let ran = folder.run(&[&arguments, *given, *check].concat());
                let last = ran.stderr.lines().last().unwrap_or_default();
                writeln!(rows, "{} {}: {nothing}: {} {last}", command[0], check.join(" "), ran.code).expect("memory");
                if ran.code != *code || !(ran.stderr.contains(says) || ran.stdout.contains(says)) {
                    rows += "  ^ wrong\n";
                    wrong += 1;
                }
            }
        }
    }
    println!("{rows}");
    assert_eq!(wrong, 0, "\n{rows}");
}

#[test]
fn no_check_passes_with_nothing_to_measure() {
    hold(TABLE);
}

#[cfg(feature = "render")]
#[test]
fn no_check_of_renderings_passes_with_nothing_to_see() {
    if crate::common::has_adapter() {
        hold(RENDERED);
    }
}
