//! `brdfc eval`.

use crate::common::cli::{Folder, inputs};

const PAIRS: &str = "\
name,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,weight
\"up, and up\",0,0,1,0,0,1,0.5
# a remark
tilted,0.6,0,0.8,-0.6,0,0.8,1
below,0,0,1,0.6,0,-0.8,2
";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("pairs.csv", PAIRS);
    folder
}

#[test]
fn columns_are_appended_and_others_retained() {
    let folder = folder();
    let ran = folder.run(&["eval", "synth:lambert?kd=0.5,0.25,1", "--directions", "pairs.csv"]).succeeded();
    let lines: Vec<&str> = ran.stdout.lines().collect();
    assert_eq!(lines[0], "name,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,weight,f_r,f_g,f_b");
    assert_eq!(lines.len(), 4);
    let (head, values) = lines[1].split_at("\"up, and up\",0,0,1,0,0,1,0.5,".len());
    assert_eq!(head, "\"up, and up\",0,0,1,0,0,1,0.5,");
    let values: Vec<f64> = values.split(',').map(|v| v.parse().unwrap()).collect();
    for (found, kd) in values.into_iter().zip([0.5, 0.25, 1.0]) {
        assert!((found * std::f64::consts::PI - kd).abs() < 1e-12, "{found}");
    }
    assert_eq!(lines[3], "below,0,0,1,0.6,0,-0.8,2,0,0,0");
    assert_eq!(ran.stderr, "");
}

/// Semicolons between columns remain, so that the output is read like the input.
#[test]
fn delimiters_are_retained() {
    let folder = Folder::new();
    folder.write("pairs.csv", "wi_x;wi_y;wi_z;wo_x;wo_y;wo_z\n0,6;0;0,8;-0,6;0;0,8\n");
    let eval = |list: &str| folder.run(&["eval", "synth:lambert?kd=1", "--directions", list]).succeeded().stdout;
    let first = eval("pairs.csv");
    let lines: Vec<&str> = first.lines().collect();
    assert_eq!(lines[0], "wi_x;wi_y;wi_z;wo_x;wo_y;wo_z;f_r;f_g;f_b");
    assert!(lines[1].starts_with("0,6;0;0,8;-0,6;0;0,8;0.318"), "{first}");
    folder.write("again.csv", &first);
    assert_eq!(eval("again.csv"), first);
}

#[test]
fn the_output_file_holds_what_stdout_would() {
    let folder = folder();
    let arguments = ["eval", "synth:ward", "--directions", "pairs.csv"];
    let printed = folder.run(&arguments).succeeded().stdout;
    let ran = folder.run(&[&arguments[..], &["-o", "values.csv"]].concat()).succeeded();
    assert_eq!((ran.stdout.as_str(), folder.text("values.csv")), ("", printed.clone()));
    let piped = folder.run(&[&arguments[..], &["-o", "/dev/stdout"]].concat()).succeeded();
    assert_eq!(piped.stdout, printed);
}

#[test]
fn its_output_is_a_scan_again() {
    let folder = Folder::new();
    let mut text = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n".to_owned();
    for k in 0..40 {
        let (s, c) = (f64::from(k) * 0.035).sin_cos();
        text += &format!("0.6,0,0.8,{},0,{}\n", if k % 2 == 0 { s } else { -s }, c);
    }
    folder.write("line.csv", text);
    folder.run(&["eval", "synth:lewis", "--directions", "line.csv", "-o", "scan.csv"]).succeeded();
    let info = folder.run(&["info", "scan.csv", "--json"]).succeeded().json();
    assert_eq!((&info["kind"], &info["rows"]), (&"scan".into(), &40.into()));
}

#[test]
fn every_kind_of_input_is_evaluated() {
    let folder = folder();
    for input in inputs(&folder) {
        let ran = folder.run(&["eval", input, "--directions", "pairs.csv"]).succeeded();
        let line = ran.stdout.lines().nth(1).unwrap();
        let values: Vec<f64> = line.rsplit(',').take(3).map(|v| v.parse().unwrap()).collect();
        assert!(values.iter().all(|v| *v > 0.0 && *v < 10.0), "{input}: {line}");
        assert!(ran.stdout.lines().nth(3).unwrap().ends_with(",0,0,0"), "{input}");
    }
}

#[test]
fn levels_of_detail_belong_to_packs() {
    let folder = folder();
    folder.run(&["encode", "synth:lewis", "-o", "p.ktx2", "--grid", "8", "--ratio", "1"]).succeeded();
    let at = |lod: &str| folder.run(&["eval", "p.ktx2", "--directions", "pairs.csv", "--lod", lod]);
    let values = |lod: &str| at(lod).succeeded().stdout;
    assert_eq!(values("3"), folder.run(&["eval", "p.ktx2", "--directions", "pairs.csv"]).succeeded().stdout);
    assert!(values("0") != values("3") && values("2.5") != values("3") && values("2.5") != values("2"));
    for lod in ["3.5", "-1", "NaN", "1000"] {
        let ran = folder.run(&["eval", "p.ktx2", "--directions", "pairs.csv", &format!("--lod={lod}")]);
        assert!(ran.code == 2 && ran.stderr.contains("--lod: found "), "{lod}: {}", ran.stderr);
    }
    let ran = folder.run(&["eval", "synth:lewis", "--directions", "pairs.csv", "--lod", "1"]);
    assert!(ran.code == 2 && ran.stderr.contains("--lod does not apply to this input"), "{}", ran.stderr);
    // For tables, the requested ones.
    folder.run(&["encode", "synth:lewis", "-o", "t.ktx2", "--codec", "factored", "--levels", "3"]).succeeded();
    let at = |lod: &str| folder.run(&["eval", "t.ktx2", "--directions", "pairs.csv", "--lod", lod]);
    let values = |lod: &str| at(lod).succeeded().stdout;
    assert_eq!(values("3"), folder.run(&["eval", "t.ktx2", "--directions", "pairs.csv"]).succeeded().stdout);
    assert!(values("0") != values("3") && values("2.5") != values("3"));
    assert!(at("3.5").stderr.contains("--lod: found 3.5, expected 0 to 3, the pack's levels"));
    folder.run(&["encode", "synth:lewis", "-o", "one.ktx2", "--codec", "table"]).succeeded();
    let ran = folder.run(&["eval", "one.ktx2", "--directions", "pairs.csv", "--lod", "1"]);
    assert!(ran.code == 2 && ran.stderr.contains("--lod: the pack has one level; omit the option"), "{ran:?}");
}

#[test]
fn broken_direction_lists_name_the_line() {
    let folder = Folder::new();
    let header = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    for (text, expected) in [
        (String::new(), "header"),
        ("a,b\n1,2\n".to_owned(), "line 1, column wi_x: missing in \"a,b\"; expected a header with wi_x,"),
        (format!("{header}0,0,1,0,0\n"), "line 2, record: found 5 fields, expected 6"),
        (format!("{header}0,0,1,0,0,1\n0,0,x,0,0,1\n"), "line 3, wi_z: found \"x\", expected a finite number"),
        (format!("{header}0,0,1,0,0,NaN\n"), "line 2, wo_z: found \"NaN\", expected a finite number"),
        (format!("{header}0,0,1,0,0,2\n"), "line 2, wo: found a vector of length 2"),
        (format!("{header}0,0,0,0,0,1\n"), "line 2, wi: found a vector of length 0"),
    ] {
        folder.write("in.csv", &text);
        let ran = folder.run(&["eval", "synth:lewis", "--directions", "in.csv", "-o", "out.csv"]);
        assert_eq!((ran.code, ran.stdout.as_str()), (3, ""), "{text}: {}", ran.stderr);
        assert!(ran.stderr.starts_with("brdfc: in.csv: ") && ran.stderr.contains(expected), "{}", ran.stderr);
    }
    folder.write("in.csv", header);
    let ran = folder.run(&["eval", "synth:lewis", "--directions", "in.csv"]).succeeded();
    assert_eq!(ran.stdout, "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n", "no pairs, no values");
    assert_eq!(folder.files(".").len(), 1);
}

#[test]
fn values_that_are_there_already_are_replaced() {
    let folder = folder();
    let arguments = |input, output| ["eval", input, "--directions", "pairs.csv", "-o", output];
    folder.run(&arguments("synth:lambert?kd=0.5", "once.csv")).succeeded();
    folder.write("pairs.csv", folder.read("once.csv"));
    folder.run(&arguments("synth:lambert?kd=1", "twice.csv")).succeeded();
    folder.write("pairs.csv", PAIRS);
    folder.run(&arguments("synth:lambert?kd=1", "new.csv")).succeeded();
    assert_eq!(folder.text("twice.csv"), folder.text("new.csv"));
}
