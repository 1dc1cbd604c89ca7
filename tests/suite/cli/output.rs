//! Streams: pipes that close, devices that are full.

use crate::common::cli::Folder;
use std::process::{Command, Stdio};

/// A shell line with `brdfc` for the program: its standard output, standard error and exit code.
fn shell(folder: &Folder, line: &str) -> (String, String, i32) {
    let program = format!("'{}'", env!("CARGO_BIN_EXE_brdfc"));
    let output = Command::new("sh")
        .args(["-c", &line.replace("brdfc", &program)])
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (text(output.stdout), text(output.stderr), output.status.code().unwrap())
}

#[test]
#[cfg(unix)]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::new();
    for line in [
        "{ brdfc schema build; echo code $? >&2; } | head -1",
        "{ brdfc --help; echo code $? >&2; } | head -1",
        "{ brdfc info synth:lewis --json; echo code $? >&2; } | true",
        "{ sleep 0.2; brdfc compare synth:lewis synth:ward --directions 10; echo code $? >&2; } | true",
    ] {
        let (_, stderr, _) = shell(&folder, line);
        assert_eq!(stderr, "code 0\n", "{line}");
    }
}

/// A closed reader of the report does not turn a failure into a success.
#[test]
#[cfg(unix)]
fn a_closed_pipe_hides_no_failure() {
    let folder = Folder::new();
    for (line, code) in [
        ("compare synth:lewis synth:ward --directions 10 --max-error 0.0001", 1),
        ("encode synth:ggx -o x.ktx2 --max-delta-e 0.0001 --max-bytes 1024", 1),
        ("build broken.brdf --out packs -q", 3),
    ] {
        folder.write("broken.brdf", "no scan");
        let (_, stderr, _) = shell(&folder, &format!("{{ sleep 0.2; brdfc {line}; echo code $? >&2; }} | true"));
        assert!(stderr.ends_with(&format!("code {code}\n")), "{line}: {stderr}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_device_exits_with_4() {
    let folder = Folder::new();
    folder.write("pairs.csv", "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n");
    for line in [
        "brdfc --help > /dev/full",
        "brdfc encode --help > /dev/full",
        "brdfc info synth:lewis > /dev/full",
        "brdfc info synth:lewis --json > /dev/full",
        "brdfc schema info > /dev/full",
        "brdfc compare synth:lewis synth:ward --directions 10 > /dev/full",
        "brdfc eval synth:lewis --directions pairs.csv > /dev/full",
        "brdfc eval synth:lewis --directions pairs.csv -o /dev/full",
        "brdfc encode synth:lambert --grid 2 -o /dev/full",
        "brdfc synth lambert -o /dev/full/a.binary",
    ] {
        let (stdout, stderr, code) = shell(&folder, line);
        assert_eq!((code, stdout.as_str()), (4, ""), "{line}: {stderr}");
        assert!(stderr.contains(": cannot write: ") && !stderr.contains("panicked"), "{line}: {stderr}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_or_closed_stderr_does_not_panic() {
    let folder = Folder::new();
    folder.write("scene.toml", "[materials.a]\nsource = 'synth:lambert'\ngrid = 2\n[[uses]]\nmaterial = 'a'\n");
    folder.write("bad.toml", "[materials.a]\nsource = 'gone.binary'\n[[uses]]\nmaterial = 'a'\n");
    for (line, expected) in [
        ("brdfc build scene.toml 2> /dev/full", 0),
        ("brdfc build bad.toml --out bad 2> /dev/full", 4),
        ("brdfc info gone.binary 2> /dev/full", 4),
        ("brdfc info gone.binary 2>&-", 4),
    ] {
        let (_, _, code) = shell(&folder, line);
        assert_eq!(code, expected, "{line}");
    }
}

#[test]
#[cfg(unix)]
fn packs_may_go_to_stdout() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:lewis", "--grid", "4", "-o", "p.ktx2"]).succeeded();
    let pack = folder.read("p.ktx2");
    // Standard output as a pipe, as a file, and as a file that has contents already.
    for (line, before) in [
        ("brdfc encode synth:lewis --grid 4 -o /dev/stdout | cat > got", ""),
        ("brdfc encode synth:lewis --grid 4 -o /dev/stdout > got", ""),
        ("{ echo before; brdfc encode synth:lewis --grid 4 -o /dev/stdout --json; } > got", "before\n"),
    ] {
        let (_, stderr, code) = shell(&folder, line);
        assert_eq!(code, 0, "{line}: {stderr}");
        assert!(folder.read("got") == [before.as_bytes(), &pack].concat(), "{line}: the pack and nothing else");
        assert!(
            stderr.contains("/dev/stdout") || stderr.contains("slices_retained"),
            "the report is printed: {stderr}"
        );
    }
    let (_, stderr, _) = shell(&folder, "brdfc encode synth:lewis --grid 4 -o /dev/stdout --quiet > got");
    assert_eq!(stderr, "");
    #[cfg(target_os = "linux")]
    assert!(std::path::Path::new("/dev/stdout").is_symlink(), "the system's link was not replaced");
}

#[test]
#[cfg(unix)]
fn a_closed_pipe_is_no_error_for_packs_either() {
    let folder = Folder::new();
    let line = "{ sleep 0.2; brdfc encode synth:lewis --grid 4 --quiet -o /dev/stdout; echo code $? >&2; } | true";
    assert_eq!(shell(&folder, line).1, "code 0\n");
}
