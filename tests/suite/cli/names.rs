//! Names of files: `-`, names that are not UTF-8, wrong extensions.

use crate::common::cli::{Folder, Ran, inputs, states_what_is_expected};

/// A run with standard input.
fn with_stdin(folder: &Folder, arguments: &[&str], stdin: &[u8]) -> Ran {
    let output = folder.command(arguments).write_stdin(stdin).output().unwrap();
    let text = |bytes| String::from_utf8_lossy(bytes).into_owned();
    Ran { code: output.status.code().unwrap(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
}

const PAIRS: &str = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n0.6,0,0.8,0,0.6,0.8\n";

#[test]
fn a_dash_reads_what_the_file_holds() {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "4"]).succeeded();
    let files = inputs(&folder).into_iter().filter(|input| !input.starts_with("synth:")).chain(["p.ktx2"]);
    for file in files {
        let bytes = folder.read(file);
        for arguments in [
            &["info", "INPUT", "--json"][..],
            &["eval", "INPUT", "--directions", "pairs.csv"],
            &["compare", "INPUT", "synth:lewis", "--directions", "100"],
            &["compare", "synth:lewis", "INPUT", "--directions", "100"],
        ] {
            // The answer does not depend on the kind of file.
            if arguments[2] == "INPUT" && file != "p.ktx2" {
                continue;
            }
            let named = |name: &'static str| -> Vec<&str> {
                arguments.iter().map(|word| if *word == "INPUT" { name } else { word }).collect()
            };
            let expected = folder.run(&named(file)).succeeded();
            let ran = with_stdin(&folder, &named("-"), &bytes).succeeded();
            assert_eq!(ran.stdout, expected.stdout, "{file}: {arguments:?}");
            assert_eq!(ran.stderr, expected.stderr.replace(file, "stdin"), "{file}: {arguments:?}");
        }
        let encode = |input, output| ["encode", input, "-o", output, "--grid", "2"];
        folder.run(&encode(file, "named.ktx2")).succeeded();
        with_stdin(&folder, &encode("-", "piped.ktx2"), &bytes).succeeded();
        assert!(folder.read("named.ktx2") == folder.read("piped.ktx2"), "{file}");
    }
}

#[test]
fn a_dash_reads_lists_of_directions_images_and_meshes_too() {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    let expected = folder.run(&["eval", "synth:ward", "--directions", "pairs.csv"]).succeeded().stdout;
    let ran = with_stdin(&folder, &["eval", "synth:ward", "--directions", "-"], PAIRS.as_bytes()).succeeded();
    assert_eq!(ran.stdout, expected);
    let ran =
        with_stdin(&folder, &["compare", "synth:ward", "synth:ggx", "--directions", "-", "--json"], PAIRS.as_bytes());
    assert_eq!(ran.succeeded().json()["pairs"], 2);

    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::from_fn(16, 16, |x, y| image::Luma([(x * y) as u8]))
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    folder.write("cloth.png", png.get_ref());
    let map = |input, output| ["bandwidth", input, "-o", output, "--size", "1x1"];
    folder.run(&map("cloth.png", "named.ktx2")).succeeded();
    with_stdin(&folder, &map("-", "piped.ktx2"), png.get_ref()).succeeded();
    assert!(folder.read("named.ktx2") == folder.read("piped.ktx2"));

    for file in ["folds.obj", "folds.ply"] {
        folder.run(&["synth", "folds?resolution=16", "-o", file]).succeeded();
        let expected = folder.run(&["info", file]).succeeded().stdout;
        assert_eq!(with_stdin(&folder, &["info", "-"], &folder.read(file)).succeeded().stdout, expected);
    }
    let flat = ["flatten", "-", "-o", "flat", "--texels", "8", "--views", "grid:2x3@40"];
    with_stdin(&folder, &flat, &folder.read("folds.ply")).succeeded();
    let asset = folder.run(&["info", "flat", "--json"]).succeeded().json();
    assert_eq!(asset["source"], "stdin");
}

#[test]
fn what_a_dash_cannot_be_is_refused() {
    let folder = Folder::new();
    for (arguments, stdin, code, expected) in [
        (&["compare", "-", "-"][..], &b""[..], 2, "brdfc: A and B: both are -; only one can be stdin\n"),
        (&["eval", "-", "--directions", "-"], b"", 2, "INPUT and --directions: both are -; only one"),
        (&["info", "-"], b"", 3, "brdfc: stdin: contents: empty file; expected .binary (MERL), "),
        (&["info", "-"], b"\0\0\0\0\0", 3, "stdin: contents: unknown layout; expected .binary (MERL), "),
        (
            &["encode", "-", "-o", "p.ktx2"],
            b"\x1f\x8b\x08\0",
            3,
            "; it looks like a file compressed by gzip, to be unpacked",
        ),
        (&["encode", "-", "-o", "p.ktx2"], b"some words", 3, "brdfc: stdin: "),
        (
            &["eval", "synth:lewis", "--directions", "-"],
            b"wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,\0\xff",
            3,
            "brdfc: stdin: line 2, text: NUL byte at ",
        ),
        (&["flatten", "synth:knit?resolution=16", "-o", "-"], b"", 2, "-: not a folder; for a folder of this name"),
        (&["build", "synth:lewis", "--out", "-", "--dry-run"], b"", 2, "-: not a folder; for"),
        (&["build", "synth:lewis", "--out", "-"], b"", 2, "-: not a folder; for a folder of this name"),
        (&["build", "synth:lewis", "--from", "-"], b"", 2, "-: not a folder; for a folder of this name"),
        (
            &["plan", "synth:lewis", "--format", "json", "--out", "-"],
            b"",
            2,
            "-: not a folder; for a folder of this name, write ./-",
        ),
        (&["report", "-", "-o", "page.html"], b"", 2, "-: not a folder; for a folder of this name"),
        (&["flatten", "m.obj", "-o", "x", "--views", "-", "--colour", "-"], b"", 2, "--views and --colour: both are -"),
        (
            &["synth", "lewis", "-o", "-"],
            b"",
            2,
            "--kind: required without an extension; expected binary, brdf or csv (models), obj or ply",
        ),
        (
            &["synth", "lewis", "-o", "-", "--kind", "ply"],
            b"",
            2,
            "--kind: found ply, expected binary, brdf or csv, for",
        ),
        (
            &["synth", "lewis", "-o", "a.brdf", "--kind", "csv"],
            b"",
            2,
            "--kind does not apply to a.brdf, only to - for",
        ),
    ] {
        let ran = with_stdin(&folder, arguments, stdin);
        assert_eq!((ran.code, ran.stdout.as_str()), (code, ""), "{arguments:?}: {}", ran.stderr);
        assert!(ran.stderr.contains(expected), "{arguments:?}: {}", ran.stderr);
    }
    assert!(folder.files(".").is_empty());
}

#[test]
fn a_dash_writes_what_the_file_would_hold() {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    for (arguments, file) in [
        (&["encode", "synth:lewis", "--grid", "4"][..], "p.ktx2"),
        (&["samples", "synth:lewis", "--count", "4", "--polar", "4"], "s.ktx2"),
        (&["bandwidth", "synth:lewis", "--resolution", "32"], "b.ktx2"),
        (&["eval", "synth:lewis", "--directions", "pairs.csv"], "v.csv"),
        (&["synth", "lewis", "--rows", "20"], "a.brdf"),
        (&["synth", "folds?resolution=16"], "a.ply"),
    ] {
        folder.run(&[arguments, &["-o", file]].concat()).succeeded();
        let kind: &[&str] = if arguments[0] == "synth" { &["--kind", &file[2..]] } else { &[] };
        let output = folder.command(&[arguments, &["-o", "-"], kind].concat()).output().unwrap();
        assert!(output.status.success() && output.stdout == folder.read(file), "{arguments:?}");
        assert!(!folder.path().join("-").exists());
    }
    // The report does not go to the same place as the pack.
    let ran =
        with_stdin(&folder, &["samples", "synth:lewis", "--count", "4", "--polar", "4", "-o", "-", "--json"], b"");
    assert!(ran.stderr.contains("\"kind\": \"importance-pack\""), "{}", ran.stderr);
}

#[test]
#[cfg(target_os = "linux")]
fn names_need_not_be_utf_8() {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let folder = Folder::new();
    let named = |extension: &str| OsString::from_vec([b"m\xe9tal.", extension.as_bytes()].concat());
    let [table, scan, ..] = inputs(&folder);
    for (file, extension) in [(table, "binary"), (scan, "brdf")] {
        folder.write("pairs.csv", PAIRS);
        std::fs::rename(folder.path().join(file), folder.path().join(named(extension))).unwrap();
        std::fs::rename(folder.path().join("pairs.csv"), folder.path().join(named("csv"))).unwrap();
        let run = |arguments: &[&str], paths: &[(usize, &str)]| {
            let mut words: Vec<OsString> = arguments.iter().map(OsString::from).collect();
            paths.iter().for_each(|(at, extension)| words[*at] = named(extension));
            let output = folder.command(&[]).args(words).output().unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.success(), "{arguments:?}: {stderr}");
            (String::from_utf8_lossy(&output.stdout).into_owned(), stderr)
        };
        assert!(run(&["info", "INPUT"], &[(1, extension)]).0.contains("kind"));
        let encode = ["encode", "INPUT", "--codec", "table", "--max-bytes", "500", "-o", "OUTPUT"];
        let (message, notes) = run(&encode, &[(1, extension), (7, "ktx2")]);
        assert!(message.contains("m\u{fffd}tal.ktx2"), "{message}");
        let start = format!("note: m\u{fffd}tal.{extension}: ");
        assert!(notes.lines().all(|line| line.starts_with(&start)) && !notes.is_empty(), "{notes}");
        run(&["compare", "A", "B", "--directions", "100"], &[(1, extension), (2, "ktx2")]);
        let (values, _) = run(&["eval", "INPUT", "--directions", "PAIRS"], &[(1, extension), (3, "csv")]);
        assert_eq!(values.lines().count(), 3);
        let (map, _) =
            run(&["bandwidth", "INPUT", "--resolution", "32", "-o", "OUTPUT"], &[(1, extension), (5, "ktx2")]);
        assert!(map.contains("bandwidth map"), "{map}");
    }
    let gone = folder.command(&["info"]).arg(named("gone")).output().unwrap();
    let message = String::from_utf8(gone.stderr).unwrap();
    assert!(
        gone.status.code() == Some(4) && message.starts_with("brdfc: m\u{fffd}tal.gone: cannot read: "),
        "{message}"
    );
}

/// Folders, manifests in them, files and outputs; `_` in names of materials stands for characters that they cannot have.
#[test]
#[cfg(target_os = "linux")]
fn builds_read_and_write_where_names_are_not_utf_8() {
    use std::ffi::OsString;
    use std::os::unix::ffi::OsStringExt;
    let folder = Folder::new();
    let odd = |text: &[u8]| OsString::from_vec(text.to_owned());
    let [table, ..] = inputs(&folder);
    let scans = folder.path().join(odd(b"sc\xe4ns"));
    for place in [&scans, &folder.path().join("scans")] {
        std::fs::create_dir(place).unwrap();
        std::fs::copy(folder.path().join(table), place.join("a.binary")).unwrap();
        std::fs::copy(folder.path().join(table), place.join(odd(b"m\xe9tal.binary"))).unwrap();
        let scene = "[materials.a]\nsource = 'a.binary'\n[[uses]]\nmaterial = 'a'\n";
        std::fs::write(place.join("scene.toml"), scene).unwrap();
        std::fs::write(place.join("all.toml"), scene.replace("a.binary", "*.binary")).unwrap();
    }
    let run = |words: &[&[u8]]| {
        let words = words.iter().map(|word| odd(word));
        let output = folder.command(&["build"]).args(words).args(["--codec", "table", "--max-bytes", "1KiB"]).output();
        let output = output.unwrap();
        (output.status.code().unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    let succeeded = |words: &[&[u8]]| {
        let (code, message) = run(words);
        assert_eq!(code, 0, "{message}");
        message
    };
    let file = |out: &[u8], name: &str| std::fs::read(folder.path().join(odd(out)).join(name)).unwrap();
    let message = succeeded(&[b"sc\xe4ns", b"--out", b"p\xe4cks", b"--depfile", b"rule.d"]);
    assert!(message.contains("skipped: sc\u{fffd}ns/all.toml, "), "{message}");
    let rule = folder.read("rule.d");
    assert!(rule.starts_with(b"p\xe4cks/report.json:") && rule.ends_with(b" sc\xe4ns/m\xe9tal.binary\n"));
    let report = String::from_utf8(file(b"p\xe4cks", "report.json")).unwrap();
    assert!(
        report.contains("\"material\": \"m_tal\"") && report.contains("sc\u{fffd}ns/m\u{fffd}tal.binary"),
        "{report}"
    );
    // The second time nothing is read again, and names do not affect the bytes.
    succeeded(&[b"sc\xe4ns", b"--out", b"p\xe4cks"]);
    succeeded(&[b"scans", b"--out", b"packs"]);
    for name in ["a.brdf.ktx2", "m_tal.brdf.ktx2"] {
        assert!(file(b"p\xe4cks", name) == file(b"packs", name), "{name}");
    }
    for out in [&b"x\xe4"[..], b"x"] {
        let scene = if out == b"x" { &b"scans/scene.toml"[..] } else { b"sc\xe4ns/scene.toml" };
        succeeded(&[scene, b"--out", out]);
    }
    assert!(file(b"x\xe4", "report.json") == file(b"x", "report.json"));
    succeeded(&[b"scans/m\xe9tal.binary", b"--out", b"one"]);
    assert!(file(b"one", "m_tal.brdf.ktx2") == file(b"packs", "m_tal.brdf.ktx2"));
    for (input, out) in [(&b"sc\xe4ns/*.binary"[..], &b"matched"[..]), (b"sc\xe4ns/all.toml", b"all")] {
        succeeded(&[input, b"--out", out]);
        assert!(file(out, "m_tal.brdf.ktx2") == file(b"packs", "m_tal.brdf.ktx2"));
    }
    let (code, message) = run(&[b"scans/m\xe9*.binary"]);
    assert!(code == 2 && message.contains("scans/m\u{fffd}*.binary: the pattern is not UTF-8"), "{message}");
    let plan =
        folder.command(&["plan", "synth:ward", "--format", "json", "--out"]).arg(odd(b"p\xe4")).output().unwrap();
    let message = String::from_utf8(plan.stderr).unwrap();
    assert!(plan.status.code() == Some(2) && message.contains("--out: found p\u{fffd}, expected UTF-8"), "{message}");
    // Arguments that become part of commands must be text.
    for (place, arguments) in [
        ("inputs", [&b"sc\xe4ns"[..], b"--format", b"ninja"]),
        ("--program", [b"synth:ward", b"--format=json", b"--program=sc\xe4ns"]),
    ] {
        let output = folder.command(&["plan"]).args(arguments.map(odd)).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        let words = format!("brdfc: {place}: found {}, expected UTF-8, because the name", "sc\u{fffd}ns");
        assert!(message.starts_with(&words), "{message}");
    }
    let output =
        folder.command(&["encode", "synth:ward", "-o", "x.ktx2", "--codec"]).arg(odd(b"t\xe4")).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        (output.status.code(), message.as_str()),
        (Some(2), "brdfc: arguments: found t\u{fffd}, expected UTF-8\n")
    );
}

/// An empty stream is reported wherever a stream is allowed.
#[test]
fn an_empty_stream_is_reported() {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    for arguments in [
        &["encode", "-", "-o", "x.ktx2"][..],
        &["eval", "-", "--directions", "pairs.csv"],
        &["eval", "synth:ward", "--directions", "-"],
        &["info", "-"],
        &["bandwidth", "-", "-o", "x.ktx2"],
        &["samples", "-", "-o", "x.ktx2"],
        &["compare", "-", "synth:ward"],
        &["compare", "synth:ward", "-"],
        &["flatten", "-", "-o", "flat"],
        &["flatten", "synth:button", "-o", "flat", "--views", "-"],
        #[cfg(feature = "render")]
        &["render", "-", "-o", "x.png"],
    ] {
        let ran = with_stdin(&folder, arguments, b"");
        let is_reported = ran.stderr.starts_with("brdfc: stdin: contents: empty file; expected .")
            || ran.stderr.starts_with("brdfc: stdin: header: empty file; expected a line of column names");
        assert!(ran.code == 3 && is_reported, "{arguments:?}: {} {}", ran.code, ran.stderr);
    }
    assert_eq!(folder.files(".").len(), 1);
}

/// A stream cannot be several files or a manifest.
#[test]
fn a_dash_is_no_list_of_materials() {
    let folder = Folder::new();
    let words = "brdfc: inputs: builds do not read stdin, only commands with one input do, such as \
                 'brdfc encode -'; for a file of this name, write ./-\n";
    for arguments in
        [&["build", "-"][..], &["build", "synth:ward", "-"], &["watch", "-"], &["plan", "-", "--format", "json"]]
    {
        let ran = with_stdin(&folder, arguments, b"");
        assert_eq!((ran.code, ran.stderr.as_str()), (2, words), "{arguments:?}");
    }
    folder.write("-", "");
    assert_eq!(folder.run(&["build", "./-"]).code, 1, "an empty manifest");
}

#[test]
fn a_wrong_extension_is_reported() {
    let folder = Folder::new();
    let [table, scan, list, material, _] = inputs(&folder);
    let mut png = std::io::Cursor::new(Vec::new());
    image::GrayImage::new(8, 8).write_to(&mut png, image::ImageFormat::Png).unwrap();
    folder.write("rendering.png", png.get_ref());
    folder.write("page.html", "<!DOCTYPE html>\n<title>404</title>\n");
    folder.run(&["encode", "synth:lewis", "-o", "pack.ktx2", "--grid", "2"]).succeeded();
    for (file, name, expected) in [
        ("rendering.png", "a.binary", "a PNG image (.png)"),
        (scan, "a.binary", "a scan as text (.brdf)"),
        ("page.html", "a.binary", "a web page, perhaps an error message of a server"),
        (table, "a.brdf", "a MERL table (.binary)"),
        (table, "a.obj", "a MERL table (.binary)"),
        (list, "a.brdf", "a scan or a list of directions (.csv)"),
        (material, "a.ktx2", "an RGL material (.bsdf)"),
        ("pack.ktx2", "a.bsdf", "a KTX2 texture (.ktx2)"),
        (scan, "a.txt", "a scan as text (.brdf)"),
        (table, "a", "a MERL table (.binary)"),
        ("pack.ktx2", "a.png", "a KTX2 texture (.ktx2)"),
    ] {
        folder.write(name, folder.read(file));
        let ran = folder.run(&["info", name]);
        let message = &ran.stderr;
        assert_eq!(ran.code, 3, "{name}: {message}");
        assert!(states_what_is_expected(message), "{message}");
        assert!(message.starts_with(&format!("brdfc: {name}: ")), "{message}");
        assert!(message.ends_with(&format!("; it looks like {expected}\n")), "{message}");
    }
    // No hint if the name is right and something else is wrong.
    folder.write("cut.binary", &folder.read(table)[..100]);
    assert!(!folder.run(&["info", "cut.binary"]).stderr.contains("looks like"));
    folder.write("cut.ktx2", &folder.read("pack.ktx2")[..100]);
    assert!(!folder.run(&["info", "cut.ktx2"]).stderr.contains("looks like"));
}

#[test]
fn outputs_that_would_be_taken_for_another_kind_are_refused_before_the_work() {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    for (arguments, extension) in [
        (&["encode", "gone.binary"][..], "ktx2"),
        (&["bandwidth", "gone.binary"], "ktx2"),
        (&["samples", "gone.binary"], "ktx2"),
        (&["eval", "gone.binary", "--directions", "pairs.csv"], "csv"),
    ] {
        for name in ["x.png", "x", "x.ktx2.gz"] {
            let ran = folder.run(&[arguments, &["-o", name]].concat());
            let allowed = format!("expected a name that ends in .{extension}, or - for stdout\n");
            assert_eq!(
                (ran.code, ran.stderr),
                (2, format!("brdfc: --output: found {name}, {allowed}")),
                "{arguments:?}"
            );
        }
        let ran = folder.run(&[arguments, &["-o", &format!("no/x.{extension}")]].concat());
        assert!(ran.code == 4 && ran.stderr.contains("there is no folder no"), "{}", ran.stderr);
    }
    assert_eq!(folder.files(".").len(), 1);
}

/// A pipe has no length and does not go back, whichever kind of file comes through it.
#[test]
#[cfg(unix)]
fn named_pipes_are_read_as_files_are() {
    let folder = Folder::new();
    let files = inputs(&folder).into_iter().filter(|input| !input.starts_with("synth:"));
    for file in files {
        let extension = file.rsplit('.').next().unwrap();
        let (pipe, out) = (format!("pipe.{extension}"), format!("{extension}.ktx2"));
        assert!(std::process::Command::new("mkfifo").arg(folder.path().join(&pipe)).status().unwrap().success());
        folder.run(&["encode", file, "-o", "named.ktx2", "--grid", "2"]).succeeded();
        for arguments in [
            &["encode", pipe.as_str(), "-o", &out, "--grid", "2"][..],
            &["build", &pipe, "--out", "built", "--grid", "2"],
        ] {
            std::thread::scope(|scope| {
                // Opening it waits for the reader.
                scope.spawn(|| std::fs::write(folder.path().join(&pipe), folder.read(file)));
                folder.run(arguments).succeeded();
            });
        }
        assert!(folder.read("named.ktx2") == folder.read(&out), "{file}");
        assert!(folder.read("named.ktx2") == folder.read("built/pipe.brdf.ktx2"), "{file}");
    }
}

/// Files of a build are never pipes: reading one would wait for a writer.
#[test]
#[cfg(unix)]
fn pipes_in_place_of_files_of_a_build_do_not_hang() {
    let folder = Folder::new();
    folder.run(&["build", "synth:lambert", "--out", "packs", "--max-bytes", "1KiB"]).succeeded();
    for file in ["lambert.brdf.ktx2", "lambert.json", "report.json"] {
        let path = folder.path().join("packs").join(file);
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        let ran = folder.run(&["verify", "packs"]);
        let expected = format!("packs/{file}: file: found a pipe or a device, expected a file");
        assert!(ran.code == 1 && ran.stdout.contains(&expected), "{file}: {ran:?}");
        let ran = folder.run(&["report", "packs", "-o", "page.html"]);
        assert!(ran.code == 0 || ran.stderr.contains(&expected), "{file}: {ran:?}");
        // The build makes the file again.
        folder.run(&["build", "synth:lambert", "--out", "packs", "--max-bytes", "1KiB"]).succeeded();
        folder.run(&["verify", "packs"]).succeeded();
        assert!(std::fs::read(&path).unwrap() == bytes, "{file}");
    }
}
