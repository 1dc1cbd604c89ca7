//! Files that exceed limits of size or would need too much memory. They are sparse and take no room on the disk.

use brdfc_formats::FormatError;
use brdfc_readers::scan::MAX_ROWS;
use brdfc_source::open::open_file_observed;
use brdfc_source::read::{MAX_FILE_BYTES, ReadListener};
use std::fs::File;
use std::io::Write;

/// Counts the bytes that are read.
#[derive(Default)]
struct Count(u64);

impl ReadListener for Count {
    fn bytes(&mut self, bytes: &[u8]) {
        self.0 += bytes.len() as u64;
    }
}

/// Error of a file with this start and length, and the number of bytes that were read.
fn refused(name: &str, start: &[u8], length: u64) -> (String, u64) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mut file = File::create(&path).unwrap();
    file.write_all(start).unwrap();
    file.set_len(length).unwrap();
    let mut count = Count::default();
    let error = open_file_observed(&path, None, &mut count).err().unwrap().to_string();
    (error.split_once(&format!("{name}: ")).unwrap().1.to_owned(), count.0)
}

#[test]
fn the_largest_merl_header_is_refused_by_its_length() {
    let header = [4096i32; 3].map(i32::to_le_bytes).concat();
    let (error, read) = refused("a.binary", &header, 12 + 24 * (1 << 36));
    assert_eq!((&*error, read), ("file length: found 1.50 TiB, expected at most 2.00 GiB", 0));
}

#[test]
fn every_kind_has_a_largest_length() {
    for name in ["a.binary", "a.brdf", "a.csv", "a.dat", "a.bsdf", "a.ktx2"] {
        let (error, read) = refused(name, b"", MAX_FILE_BYTES + 1);
        assert_eq!((&*error, read), ("file length: found 2.00 GiB, expected at most 2.00 GiB", 0), "{name}");
    }
}

#[test]
fn text_ends_at_its_first_nul_byte() {
    for name in ["a.csv", "a.brdf", "a.dat"] {
        for (start, expected) in [(&b""[..], "line 1, text: NUL byte at byte 0 "), (b"# a\n#\n#", "line 3, text: ")] {
            let (error, read) = refused(name, start, MAX_FILE_BYTES);
            assert!(
                error.starts_with(expected) && error.ends_with("of the file; expected text without NUL bytes"),
                "{error}"
            );
            assert!(read < 1 << 20, "{name}: {read} bytes were read");
        }
    }
}

/// An unclosed quote turns the rest of a table into one field.
#[test]
fn records_have_a_largest_length() {
    let quoted = [&b"theta_i,phi_i,theta_o,phi_o,r,g,b\n\""[..], &b"a\n".repeat(9 << 20)].concat();
    let (error, _) = refused("a.csv", &quoted, quoted.len() as u64);
    assert_eq!(error, "line 2, record: record of more than 16.00 MiB; expected at most 16777216 bytes");
}

#[test]
fn scans_have_a_largest_number_of_rows() {
    let rows = [&b"theta_i,phi_i,theta_o,phi_o,r,g,b\n"[..], &b"0,0,0,0,1,1,1\n".repeat(MAX_ROWS + 1)].concat();
    let error: FormatError = brdfc_readers::scan_csv::from_bytes(&rows).unwrap_err();
    assert_eq!(error.to_string(), format!("rows: found more than {MAX_ROWS}, expected at most {MAX_ROWS}"));
}
