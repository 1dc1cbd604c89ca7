//! Scattered scans, as text and as CSV.

use super::{accepted, bad_file};

const HEADER: &str = "# two bands\n2\n450 650\n";

/// A row of the text layout, and a few good ones.
fn rows(count: usize) -> String {
    (0..count)
        .map(|k| {
            format!("{} 0.0 {} {} 0.2 0.{}\n", 0.2 + 0.1 * (k % 4) as f64, 0.05 * k as f64, 0.5 * k as f64, 2 + k % 7)
        })
        .collect()
}

fn text(more: &str) -> Vec<u8> {
    format!("{HEADER}{}{more}", rows(12)).into_bytes()
}

/// The line of `more` in [`text`].
const NEXT: usize = 3 + 12 + 1;

const COLUMNS: &str = "theta_i,phi_i,theta_o,phi_o,r,g,b\n";

fn csv(more: &str) -> Vec<u8> {
    let rows: String = (0..12)
        .map(|k| format!("{},0,{},{},0.1,0.2,0.3\n", 0.2 + 0.1 * f64::from(k % 4), 0.05 * f64::from(k), k % 6))
        .collect();
    format!("{COLUMNS}{rows}{more}").into_bytes()
}

#[test]
fn the_valid_scans_of_these_tests_are_valid() {
    assert_eq!(accepted("a.brdf", &text(""))["rows"], 12);
    assert_eq!(accepted("a.csv", &csv(""))["rows"], 12);
}

#[test]
fn text_cut_at_every_token() {
    let whole = text("");
    let body = HEADER.len() + rows(12).len();
    assert_eq!(whole.len(), body);
    for (start, expected) in [
        (0, "wavelength count: end of data"),
        ("# two bands\n".len(), "wavelength count: end of data"),
        ("# two bands\n2".len(), "wavelengths: end of data after 0; expected 2 wavelengths"),
        ("# two bands\n2\n450".len(), "wavelengths: end of data after 1; expected 2 wavelengths"),
        (HEADER.len(), "rows: no measurements; expected at least one row"),
    ] {
        bad_file("a.brdf", &whole[..start], &["line ", expected]);
    }
    let row = "0.3 0.0 0.2 1.5 0.2 0.4";
    for tokens in 1..6 {
        let cut = row.split(' ').take(tokens).collect::<Vec<_>>().join(" ");
        let expected = format!("line {NEXT}, row: found {tokens} numbers up to line {NEXT}, expected 6 numbers");
        bad_file("a.brdf", &text(&cut), &[expected.as_str()]);
    }
    assert_eq!(accepted("a.brdf", &text(row))["rows"], 13, "a last line without its end is whole");
}

#[test]
fn spectra_of_the_wrong_length() {
    let line = format!("line {NEXT}, row: found 7 numbers");
    bad_file(
        "a.brdf",
        &text("0.3 0.0 0.2 1.5 0.2 0.4 0.5\n"),
        &[line.as_str(), "expected 6 numbers: 4 angles and a spectrum of 2"],
    );
    bad_file("a.brdf", b"3\n450 650\n0.1 0 0.1 0 0.2 0.2 0.2\n", &["line 3, wavelengths: found 9 numbers, expected 3"]);
    for count in ["0", "-2", "2.5", "99999999999", "x"] {
        let expected = format!("line 1, wavelength count: found \"{count}\", expected 1 to ");
        bad_file("a.brdf", format!("{count}\n450 650\n").as_bytes(), &[expected.as_str()]);
    }
    for (wavelengths, expected) in [
        ("650 450", "expected more than the 650 nm before"),
        ("450 450", "expected more than the 450 nm before"),
        ("450 NaN", "wavelength: found \"NaN\""),
        ("0.45 0.65", "expected 100 to 3000 nm"),
        ("900 1000", "expected an overlap with 380 to 780 nm"),
    ] {
        bad_file("a.brdf", format!("2\n{wavelengths}\n{}", rows(12)).as_bytes(), &["line 2, ", expected]);
    }
}

#[test]
fn numbers_that_are_none() {
    for bad in ["NaN", "inf", "-inf", "1e999", "0,5", "abc", "\u{1b}[2J"] {
        let expected = format!("line {NEXT}, value: found ");
        bad_file(
            "a.brdf",
            &text(&format!("0.3 0.0 0.2 1.5 {bad} 0.4\n")),
            &[expected.as_str(), "expected a finite number"],
        );
    }
    for bad in ["NaN", "inf", "x", ""] {
        bad_file("a.csv", &csv(&format!("0.3,0,0.2,1,0.1,{bad},0.3\n")), &["line 14, g: found ", "a finite number"]);
    }
    bad_file("a.brdf", &text("0.3 0.0 0.2 1.5 1e200 0.4\n"), &["value: found 1"]);
    bad_file("a.csv", &csv("0.3,0,0.2,1,1e200,0,0\n"), &["line 14, value: found "]);
}

#[test]
fn angles_below_the_horizon_and_in_degrees() {
    for (row, field, hint) in [
        ("1.6 0 0.2 0", "theta_i: found 1.6,", "; the direction is below the horizon"),
        ("0.3 0 3.1 0", "theta_o: found 3.1,", "; the direction is below the horizon"),
        ("-0.1 0 0.2 0", "theta_i: found -0.1,", "expected 0 to 1.5708 radians"),
        ("45 0 30 180", "theta_i: found 45,", "radians; this looks like degrees"),
        ("0.3 0 0.2 180", "phi_o: found 180,", "radians; this looks like degrees"),
    ] {
        let line = format!("line {NEXT}, {field}");
        bad_file("a.brdf", &text(&format!("{row} 0.2 0.4\n")), &[line.as_str(), hint]);
        let line = format!("line 14, {field}");
        bad_file("a.csv", &csv(&format!("{},0.1,0.2,0.3\n", row.replace(' ', ","))), &[line.as_str(), hint]);
    }
    accepted("a.brdf", &text("1.5708 -6.2831 1.5708 6.2831 0.2 0.4\n"));
}

#[test]
fn too_few_different_rows() {
    let one = "0.3 0.0 0.2 1.5 0.2 0.4\n";
    bad_file(
        "a.brdf",
        format!("{HEADER}{one}").as_bytes(),
        &["rows: found 1 distinct direction pair in 1 row, expected at least 8"],
    );
    bad_file(
        "a.brdf",
        format!("{HEADER}{}", one.repeat(40)).as_bytes(),
        &["rows: found 1 distinct direction pair in 40 rows"],
    );
    bad_file("a.csv", COLUMNS.as_bytes(), &["rows: no measurements"]);
}

#[test]
fn rows_that_disagree_are_accepted_and_reported() {
    let folder = crate::common::cli::Folder::new();
    folder.write("a.brdf", text("0.3 0.0 0.2 1.5 0.4 0.4\n0.3 0.0 0.2 1.5 0.1 0.1\n"));
    let info = folder.run(&["info", "a.brdf", "--json"]).succeeded().json();
    assert_eq!((&info["rows"], &info["distinct"]), (&14.into(), &13.into()));
    assert!((info["largest_disagreement"].as_f64().unwrap() - 0.75).abs() < 1e-9, "{info}");
    let words = folder.run(&["info", "a.brdf"]).succeeded().stdout;
    assert!(words.contains("75.000 %"), "{words}");
}

#[test]
fn rows_of_another_azimuth_are_reported() {
    let folder = crate::common::cli::Folder::new();
    let scan = |count: usize| {
        let strays = "0.3 0.2 0.25 1.5 0.2 0.3\n".repeat(count);
        format!("{HEADER}{}{strays}{}", rows(12), rows(12).repeat(4)).into_bytes()
    };
    folder.write("a.brdf", scan(2));
    let info = folder.run(&["info", "a.brdf", "--json"]).succeeded().json();
    assert_eq!((&info["isotropic"], &info["symmetry"]["isotropic"]), (&true.into(), &true.into()), "{info}");
    let strays = &info["strays"];
    assert_eq!((&strays["rows"], &strays["of"], &strays["line"]), (&2.into(), &62.into(), &16.into()), "{info}");
    let message = format!("2 of 62 rows have another azimuth of incidence (the first on line {NEXT}, 11.5°)");
    assert!(folder.run(&["info", "a.brdf"]).succeeded().stdout.contains(&message));
    let encoded = folder.run(&["encode", "a.brdf", "-o", "a.ktx2", "--grid", "2"]).succeeded();
    assert!(
        encoded.stderr.contains(&message) && encoded.stderr.contains("these rows differ from the others by "),
        "{encoded:?}"
    );
    // If they are a part of the measurement they count as one, and nothing is reported.
    folder.write("a.brdf", scan(12));
    let info = folder.run(&["info", "a.brdf", "--json"]).succeeded().json();
    assert_eq!((&info["isotropic"], info.get("strays")), (&false.into(), None), "{info}");
}

#[test]
fn negative_and_black_rows_are_accepted_and_counted() {
    let info = accepted("a.brdf", &text("0.3 0.0 0.2 1.5 -0.4 -0.4\n0.3 0.0 0.25 1.5 0 0\n"));
    assert_eq!((&info["negative"], &info["darkest"]["samples"]), (&1.into(), &2.into()));
    let black: String =
        rows(12).lines().map(|l| l.split(' ').take(4).collect::<Vec<_>>().join(" ") + " 0 0\n").collect();
    assert_eq!(accepted("a.brdf", format!("{HEADER}{black}").as_bytes())["darkest"]["samples"], 12);
}

#[test]
fn text_that_is_not_utf_8() {
    let broken = |bytes: Vec<u8>| [&bytes[..], b"0.3 0.0 \xff"].concat();
    let line = format!("line {NEXT}, text: found byte 0xff, expected UTF-8");
    bad_file("a.brdf", &broken(text("")), &[line.as_str()]);
    bad_file("a.csv", &broken(csv("")), &["line 14, text: found byte 0xff, expected UTF-8"]);
    bad_file(
        "a.csv",
        "theta_i".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>().as_slice(),
        &["line 1, "],
    );
}

#[test]
fn csv_columns_and_records() {
    bad_file("a.csv", b"a,b,c\n1,2,3\n", &["line 1, column wi_x: missing in \"a,b,c\"; expected a header with wi_x,"]);
    bad_file("a.csv", b"theta_i,phi_i,theta_o,phi_o,r,g\n", &["line 1, column b: missing in "]);
    bad_file("a.csv", &csv("0.3,0,0.2\n"), &["line 14, record: found 3 fields, expected 7"]);
    bad_file(
        "a.csv",
        b"wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,2,0,0,1,1,1,1\n",
        &["line 2, wi: found a vector of length 2"],
    );
    bad_file(
        "a.csv",
        b"wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,-1,0,0,1,1,1,1\n",
        &["line 2, theta_i: found 3.14"],
    );
}

fn alta(header: &str, row: &str) -> Vec<u8> {
    let rows: String = (0..12).map(|k| format!("0.{} 0.{} 0.0 0.{}\n", 1 + k % 4, 5 + k / 4, 1 + k % 3)).collect();
    format!("{header}#DIM 3 1\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n#PARAM_OUT INV_STERADIAN\n{rows}{row}").into_bytes()
}

#[test]
fn tables_of_alta() {
    let info = accepted("a.dat", &alta("", ""));
    assert_eq!((&info["rows"], &info["alta"]["directions"]), (&12.into(), &"ISOTROPIC_TL_TV_PROJ_DPHI".into()));
    assert_eq!((&info["alta"]["values"], &info["alta"]["channels"]), (&"INV_STERADIAN".into(), &1.into()));
    // A byte-order mark of an editor, and a comment that begins like a key.
    assert_eq!(accepted("a.dat", &alta("\u{feff}", ""))["rows"], 12);
    assert_eq!(accepted("a.dat", &alta("# DIM of this table: below\n#DIMENSIONS\n", ""))["rows"], 12);
    bad_file("a.dat", &alta("", "15 30 0 0.5\n"), &["line 16, angle: found 15, expected -6.2832 to 6.2832"]);
    bad_file(
        "a.dat",
        &alta("", "0.1,0.2,0,0.5\n"),
        &["line 16, value: found \"0.1,0.2,0,0.5\", expected a finite number"],
    );
    bad_file("a.dat", &alta("#DIM 900000000 1\n", ""), &["line 1, #DIM: found \"900000000 1\", expected 3 1 or 3 3"]);
}

#[test]
fn a_byte_order_mark_is_no_part_of_a_scan() {
    let mut marked = b"\xef\xbb\xbf".to_vec();
    marked.extend(text(""));
    assert_eq!(accepted("a.brdf", &marked)["rows"], 12);
}
