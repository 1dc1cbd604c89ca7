//! What a file is by its first bytes, whatever its name says.

use super::error::InputError;
use super::read::extension_of;
use brdfc_formats::FormatError;
use brdfc_readers::{merl, ubo_btf};
use std::path::Path;

/// How many bytes from the start of a file are enough to recognise it.
pub const START_BYTES: usize = 4096;

/// A kind of file that its bytes tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// A MERL table: its header fits its length.
    Merl,
    /// A material of the RGL database.
    Rgl,
    /// A BTF of the Bonn database of 2014.
    UboBtf,
    /// KTX2.
    Ktx2,
    /// Portable Network Graphics.
    Png,
    /// JPEG.
    Jpeg,
    /// OpenEXR.
    Exr,
    /// Radiance HDR.
    Hdr,
    /// TIFF.
    Tiff,
    /// A mesh.
    Ply,
    /// A mesh.
    Obj,
    /// A scan as text: numbers.
    Scan,
    /// A scan, or a list of directions.
    Csv,
    /// A table of ALTA.
    Alta,
    /// The lights of a light stack.
    Lights,
    /// A polynomial texture map.
    Ptm,
    /// A scene manifest.
    Manifest,
    /// A report, or the list of a flat BTF's parts.
    Json,
    /// A web page.
    Html,
    /// What Git LFS leaves in the place of a file that was not fetched.
    LfsPointer,
    /// A ZIP archive.
    Zip,
    /// Compressed by gzip.
    Gzip,
    /// Compressed by Zstandard.
    Zstandard,
    /// A PDF.
    Pdf,
    /// Any other text.
    Text,
}

/// What files of one kind begin with.
const SIGNATURES: [(&[u8], FileKind); 20] = [
    (b"\xabKTX 20\xbb\r\n\x1a\n", FileKind::Ktx2),
    (b"tensor_file\0", FileKind::Rgl),
    (ubo_btf::SIGNATURE, FileKind::UboBtf),
    (b"\x89PNG\r\n\x1a\n", FileKind::Png),
    (b"\xff\xd8\xff", FileKind::Jpeg),
    (b"\x76\x2f\x31\x01", FileKind::Exr),
    (b"#?RADIANCE", FileKind::Hdr),
    (b"#?RGBE", FileKind::Hdr),
    (b"II*\0", FileKind::Tiff),
    (b"MM\0*", FileKind::Tiff),
    (b"ply\n", FileKind::Ply),
    (b"ply\r", FileKind::Ply),
    (b"PK\x03\x04", FileKind::Zip),
    (b"PK\x05\x06", FileKind::Zip),
    (b"\x1f\x8b", FileKind::Gzip),
    (b"\x28\xb5\x2f\xfd", FileKind::Zstandard),
    (b"%PDF-", FileKind::Pdf),
    (b"version https://git-lfs", FileKind::LfsPointer),
    (b"PTM_1.", FileKind::Ptm),
    (b"{", FileKind::Json),
];

impl FileKind {
    /// What it is, with an article, and what to do with it.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Merl => "a MERL table (.binary)",
            Self::Rgl => "an RGL material (.bsdf)",
            Self::UboBtf => "a BTF of the Bonn database of 2014 (.btf), for 'brdfc flatten'",
            Self::Ktx2 => "a KTX2 texture (.ktx2)",
            Self::Png => "a PNG image (.png)",
            Self::Jpeg => "a JPEG image (.jpg)",
            Self::Exr => "an OpenEXR image (.exr)",
            Self::Hdr => "a Radiance image (.hdr)",
            Self::Tiff => "a TIFF image",
            Self::Ply => "a mesh (.ply)",
            Self::Obj => "a mesh (.obj)",
            Self::Scan => "a scan as text (.brdf)",
            Self::Csv => "a scan or a list of directions (.csv)",
            Self::Alta => "a table of ALTA (.dat)",
            Self::Lights => "the lights of a light stack (.lp)",
            Self::Ptm => "a polynomial texture map (.ptm)",
            Self::Manifest => "a scene manifest (.toml)",
            Self::Json => "JSON",
            Self::Html => "a web page, perhaps what a server said in the place of the file",
            Self::LfsPointer => "what Git LFS leaves in the place of a file: 'git lfs pull' fetches it",
            Self::Zip => "a ZIP archive, to be unpacked first",
            Self::Gzip => "a file compressed by gzip, to be unpacked first",
            Self::Zstandard => "a file compressed by Zstandard, to be unpacked first",
            Self::Pdf => "a PDF",
            Self::Text => "text",
        }
    }

    /// Extensions of such files that are read, in lower case; the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Merl => &["binary"],
            Self::Rgl => &["bsdf"],
            Self::UboBtf => &["btf"],
            Self::Ktx2 => &["ktx2"],
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::Exr => &["exr"],
            Self::Hdr => &["hdr"],
            Self::Ply => &["ply"],
            Self::Obj => &["obj"],
            Self::Scan => &["brdf"],
            Self::Csv => &["csv"],
            Self::Alta => &["dat"],
            Self::Lights => &["lp"],
            Self::Ptm => &["ptm"],
            Self::Manifest => &["toml"],
            Self::Json => &["json"],
            Self::Text => &["brdf", "csv", "dat", "lp", "obj", "toml", "json", "ply"],
            Self::Tiff | Self::Html | Self::LfsPointer | Self::Zip | Self::Gzip | Self::Zstandard | Self::Pdf => &[],
        }
    }
}

/// The kind of a file of `length` bytes that begins with `start`; nothing where no known one begins so.
pub fn recognise(start: &[u8], length: u64) -> Option<FileKind> {
    if merl::Dimensions::from_header(start, length).is_ok() {
        return Some(FileKind::Merl);
    }
    let signed = SIGNATURES.iter().find(|(signature, _)| start.starts_with(signature)).map(|(_, kind)| *kind);
    signed.or_else(|| text(&start[..start.len().min(START_BYTES)]).map(of_text))
}

/// The text that bytes are, if they are; a character that is cut at the end is left out.
fn text(start: &[u8]) -> Option<&str> {
    let text = match std::str::from_utf8(start) {
        Ok(text) => text,
        Err(error) if error.error_len().is_none() => std::str::from_utf8(&start[..error.valid_up_to()]).ok()?,
        Err(_) => return None,
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let binary = |c: char| c.is_control() && !matches!(c, '\t' | '\n' | '\r' | '\x0c');
    (!text.trim().is_empty() && !text.contains(binary)).then_some(text)
}

fn of_text(text: &str) -> FileKind {
    let begins = |line: &str, words: &[&str]| words.iter().any(|word| line.starts_with(word));
    let first = text.trim_start().get(..14).unwrap_or(text.trim_start()).to_ascii_lowercase();
    if begins(&first, &["<!doctype html", "<html"]) {
        return FileKind::Html;
    }
    if text.lines().any(|line| begins(line, &["#PARAM_IN", "#DIM "])) {
        return FileKind::Alta;
    }
    if text.lines().any(|line| begins(line, &["[materials.", "[[uses]]", "[scene]"])) {
        return FileKind::Manifest;
    }
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#')).unwrap_or("");
    if first.contains("wi_x") || first.contains("theta_i") {
        FileKind::Csv
    } else if begins(first, &["v ", "vn ", "vt ", "o ", "g ", "mtllib ", "usemtl "]) {
        FileKind::Obj
    } else if is_light_list(text) {
        FileKind::Lights
    } else if is_scan(first) {
        FileKind::Scan
    } else {
        FileKind::Text
    }
}

/// Whether text begins as a list of lights does: a number alone, then a name and three numbers.
fn is_light_list(text: &str) -> bool {
    let mut lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    let (first, second) = (lines.next().unwrap_or(""), lines.next().unwrap_or(""));
    let words: Vec<bool> = second.split_whitespace().map(|word| word.parse::<f64>().is_ok()).collect();
    first.parse::<u32>().is_ok() && words.len() > 3 && !words[0] && words.ends_with(&[true; 3])
}

/// Whether a line can be the first of a scan: how many wavelengths, and perhaps the first of them.
fn is_scan(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let counts = words.next().is_some_and(|word| word.parse::<u32>().is_ok_and(|count| count > 0));
    counts && words.all(|word| word.parse::<f64>().is_ok())
}

/// The error of a file that breaks the layout that its name promises, with a hint where its bytes are of another one.
pub(crate) fn wrong_contents(path: &Path, start: &[u8], length: u64, error: FormatError) -> InputError {
    match recognise(start, length) {
        Some(kind) if !kind.extensions().contains(&extension_of(path).as_str()) => InputError::Misnamed {
            name: path.display().to_string(),
            error: Box::new(error),
            looks_like: kind.in_words(),
        },
        _ => InputError::format(path, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(bytes: &[u8]) -> Option<FileKind> {
        recognise(bytes, bytes.len() as u64)
    }

    #[test]
    fn files_are_recognised_by_their_first_bytes() {
        let merl: Vec<u8> = [2i32, 3, 4].into_iter().flat_map(i32::to_le_bytes).chain([0; 24 * 24]).collect();
        assert_eq!(kind(&merl), Some(FileKind::Merl));
        assert_eq!(kind(&merl[..merl.len() - 1]), None, "a table is as long as its header says");
        for (bytes, expected) in [
            (&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], FileKind::Png),
            (b"\xff\xd8\xff\xe0\0\x10JFIF", FileKind::Jpeg),
            (b"\x76\x2f\x31\x01\x02\0\0\0", FileKind::Exr),
            (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", FileKind::Hdr),
            (b"II*\0\x08\0\0\0", FileKind::Tiff),
            (b"\xabKTX 20\xbb\r\n\x1a\n\0", FileKind::Ktx2),
            (b"tensor_file\0\x01\0", FileKind::Rgl),
            (b"!DFMF08FCR\x23\x01\0\0", FileKind::UboBtf),
            (b"PK\x03\x04\x14\0", FileKind::Zip),
            (b"\x1f\x8b\x08\0", FileKind::Gzip),
            (b"\x28\xb5\x2f\xfd\0", FileKind::Zstandard),
            (b"%PDF-1.7\n", FileKind::Pdf),
            (b"\n <!DOCTYPE html>\n<html>", FileKind::Html),
            (b"<HTML><head>", FileKind::Html),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", FileKind::LfsPointer),
            (b"ply\nformat binary_little_endian 1.0\n", FileKind::Ply),
            (b"# made by hand\nv 0 0 0\n", FileKind::Obj),
            (b"# made by hand\r\n2\r\n450 650\r\n0.3 0 0.5 1.5 0.02 0.04\r\n", FileKind::Scan),
            (b"\xef\xbb\xbf2 450 650\n", FileKind::Scan),
            (b"# pairs\nname,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n", FileKind::Csv),
            (b"theta_i,phi_i,theta_o,phi_o,r,g,b\n", FileKind::Csv),
            (b"#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n0 0 0 1\n", FileKind::Alta),
            (b"PTM_1.2\nPTM_FORMAT_RGB\n\xff", FileKind::Ptm),
            (b"\n2\r\nphoto 1.jpg 0 0.5 1\r\n", FileKind::Lights),
            (b"2\n1 0 0.5 1\n", FileKind::Scan),
            (b"[materials.a]\nsource = 'a.binary'\n", FileKind::Manifest),
            (b"{\"version\": 1}", FileKind::Json),
            ("Füße\n".as_bytes(), FileKind::Text),
            ("Fü".as_bytes().split_at(2).0, FileKind::Text),
        ] {
            assert_eq!(kind(bytes), Some(expected), "{:?}", String::from_utf8_lossy(bytes));
        }
        for bytes in [&b""[..], b" \n", b"\0\0\0\0", b"text\0", b"\xfftext", b"\x89PN"] {
            assert_eq!(kind(bytes), None, "{bytes:?}");
        }
    }

    #[test]
    fn hints_are_for_names_that_lie() {
        let told = |name: &str, bytes: &[u8]| {
            let error = FormatError::whole("magic", "x", "y");
            wrong_contents(Path::new(name), bytes, bytes.len() as u64, error).to_string()
        };
        let png = b"\x89PNG\r\n\x1a\n";
        assert_eq!(told("a.binary", png), "a.binary: magic: found x; allowed y; it looks like a PNG image (.png)");
        assert_eq!(told("a.PNG", png), "a.PNG: magic: found x; allowed y");
        assert!(told("a.brdf", b"theta_i,r\n").ends_with("; it looks like a scan or a list of directions (.csv)"));
        assert!(told("a.binary", b"2\n450 650\n").ends_with("; it looks like a scan as text (.brdf)"));
        // Any text may have been meant for any layout of text.
        assert_eq!(told("a.csv", b"what is this?\n"), "a.csv: magic: found x; allowed y");
        assert!(told("a.ktx2", b"what is this?\n").ends_with("; it looks like text"));
        assert_eq!(told("a.ktx2", b"\0\0\0\0"), "a.ktx2: magic: found x; allowed y");
    }
}
