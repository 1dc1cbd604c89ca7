//! Recognition of files by their first bytes, independent of their names.

use crate::file_kind::{Begins, FileKind, begins_with, first_line};
use crate::meso::{obj, ply};
use crate::{alta, merl, ptm, rgl, rti, rti_capture, scan, scan_csv, ubo_btf};

/// Number of bytes from the start of a file that are enough to recognise it.
pub const START_BYTES: usize = 4096;

/// All recognised kinds of files. The first match counts.
static KINDS: [&FileKind; 30] = [
    &merl::KIND,
    &rgl::KIND,
    &ubo_btf::KIND,
    &ptm::KIND,
    &rti::KIND,
    &ply::KIND,
    &KTX2,
    &PNG,
    &JPEG,
    &EXR,
    &HDR,
    &TIFF,
    &ZIP,
    &GZIP,
    &ZSTANDARD,
    &PDF,
    &LFS_POINTER,
    &JSON,
    &HTML,
    &SPEOS,
    &WINDOW,
    &FRED,
    &ZEMAX,
    &alta::KIND,
    &MANIFEST,
    &scan_csv::KIND,
    &obj::KIND,
    &rti_capture::KIND,
    &scan::KIND,
    &TEXT,
];

/// KTX2, the container of packs.
pub static KTX2: FileKind = FileKind {
    description: "a KTX2 texture (.ktx2)",
    extensions: &["ktx2"],
    begins: Begins::With(&[b"\xabKTX 20\xbb\r\n\x1a\n", b"\xabKTX 20\xbb\r\n\x1a\n\0"]),
};
/// Portable Network Graphics.
pub static PNG: FileKind =
    FileKind { description: "a PNG image (.png)", extensions: &["png"], begins: Begins::With(&[b"\x89PNG\r\n\x1a\n"]) };
/// JPEG.
pub static JPEG: FileKind = FileKind {
    description: "a JPEG image (.jpg)",
    extensions: &["jpg", "jpeg"],
    begins: Begins::With(&[b"\xff\xd8\xff", b"\xff\xd8\xff\xe0\0\x10JFIF"]),
};
/// OpenEXR.
pub static EXR: FileKind = FileKind {
    description: "an OpenEXR image (.exr)",
    extensions: &["exr"],
    begins: Begins::With(&[b"\x76\x2f\x31\x01", b"\x76\x2f\x31\x01\x02\0\0\0"]),
};
/// Radiance HDR.
pub static HDR: FileKind = FileKind {
    description: "a Radiance image (.hdr)",
    extensions: &["hdr"],
    begins: Begins::With(&[b"#?RADIANCE", b"#?RGBE", b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n"]),
};
/// TIFF.
pub static TIFF: FileKind = FileKind {
    description: "a TIFF image (.tif)",
    extensions: &["tif", "tiff"],
    begins: Begins::With(&[b"II*\0", b"MM\0*", b"II*\0\x08\0\0\0"]),
};
/// A ZIP archive.
static ZIP: FileKind = FileKind {
    description: "a ZIP archive, to be unpacked first",
    extensions: &[],
    begins: Begins::With(&[b"PK\x03\x04", b"PK\x05\x06", b"PK\x03\x04\x14\0"]),
};
/// gzip-compressed data.
static GZIP: FileKind = FileKind {
    description: "a file compressed by gzip, to be unpacked first",
    extensions: &[],
    begins: Begins::With(&[b"\x1f\x8b", b"\x1f\x8b\x08\0"]),
};
/// Zstandard-compressed data.
static ZSTANDARD: FileKind = FileKind {
    description: "a file compressed by Zstandard, to be unpacked first",
    extensions: &[],
    begins: Begins::With(&[b"\x28\xb5\x2f\xfd", b"\x28\xb5\x2f\xfd\0"]),
};
/// A PDF.
static PDF: FileKind =
    FileKind { description: "a PDF", extensions: &[], begins: Begins::With(&[b"%PDF-", b"%PDF-1.7\n"]) };
/// Placeholder of Git LFS for a file that was not fetched.
static LFS_POINTER: FileKind = FileKind {
    description: "a Git LFS pointer; 'git lfs pull' fetches the file",
    extensions: &[],
    begins: Begins::With(&[b"version https://git-lfs", b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n"]),
};
/// A report, or the list of a flat BTF's parts.
static JSON: FileKind =
    FileKind { description: "JSON", extensions: &["json"], begins: Begins::With(&[b"{", b"{\"version\": 1}"]) };
/// A web page.
static HTML: FileKind = FileKind {
    description: "a web page, perhaps an error message of a server",
    extensions: &[],
    begins: Begins::Text(is_page),
};
/// Scatter files of Ansys Speos (formerly OPTIS), text or binary.
static SPEOS: FileKind = FileKind {
    description: "a BSDF file of Ansys Speos; brdfc does not read these yet",
    extensions: &[],
    begins: Begins::With(&[b"OPTIS - "]),
};
/// BSDF files of Radiance and LBNL Window.
static WINDOW: FileKind = FileKind {
    description: "a BSDF file of Radiance or Window (XML); brdfc does not read these yet",
    extensions: &[],
    begins: Begins::Text(|text| text.contains("<WindowElement")),
};
/// Scatter files of FRED.
static FRED: FileKind = FileKind {
    description: "a scatter file of FRED; brdfc does not read these yet",
    extensions: &[],
    begins: Begins::Text(|text| begins_with(first_line(text), &["type bsdf_data"])),
};
/// BSDF files of Zemax OpticStudio.
static ZEMAX: FileKind = FileKind {
    description: "a Zemax BSDF file; brdfc does not read these yet",
    extensions: &[],
    begins: Begins::Text(|text| {
        let has = |words: &[&str]| text.lines().any(|line| begins_with(line, words));
        has(&["Source"]) && has(&["Symmetry"]) && has(&["SpectralContent", "ScatterType"])
    }),
};
/// A scene manifest.
pub static MANIFEST: FileKind = FileKind {
    description: "a scene manifest (.toml)",
    extensions: &["toml"],
    begins: Begins::Text(|text| text.lines().any(|line| begins_with(line, &["[materials.", "[[uses]]", "[scene]"]))),
};
/// Any other text.
static TEXT: FileKind = FileKind {
    description: "text",
    extensions: &["brdf", "csv", "dat", "lp", "obj", "toml", "json", "ply"],
    begins: Begins::Text(|_| true),
};

fn is_page(text: &str) -> bool {
    let first = text.trim_start().get(..14).unwrap_or(text.trim_start()).to_ascii_lowercase();
    begins_with(&first, &["<!doctype html", "<html"])
}

/// Finds the kind of a file of `length` bytes that begins with `start`; `None` for unknown kinds.
pub fn recognise(start: &[u8], length: u64) -> Option<&'static FileKind> {
    let text = text(&start[..start.len().min(START_BYTES)]);
    KINDS.into_iter().find(|kind| kind.is_of(start, length, text))
}

/// Decodes bytes as text, without a truncated character at the end; `None` if they are not text.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn kind(bytes: &[u8]) -> Option<&'static str> {
        recognise(bytes, bytes.len() as u64).map(|kind| kind.description)
    }

    #[test]
    fn files_are_recognised_by_their_first_bytes() {
        let merl: Vec<u8> = [2i32, 3, 4].into_iter().flat_map(i32::to_le_bytes).chain([0; 24 * 24]).collect();
        assert_eq!(kind(&merl), Some(merl::KIND.description));
        assert_eq!(kind(&merl[..merl.len() - 1]), None, "the length of a table must match its header");
        for (bytes, expected) in [
            (&b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR"[..], &PNG),
            (b"\xff\xd8\xff\xe0\0\x10JFIF", &JPEG),
            (b"\x76\x2f\x31\x01\x02\0\0\0", &EXR),
            (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", &HDR),
            (b"II*\0\x08\0\0\0", &TIFF),
            (b"\xabKTX 20\xbb\r\n\x1a\n\0", &KTX2),
            (b"tensor_file\0\x01\0", &rgl::KIND),
            (b"!DFMF08FCR\x23\x01\0\0", &ubo_btf::KIND),
            (b"PK\x03\x04\x14\0", &ZIP),
            (b"\x1f\x8b\x08\0", &GZIP),
            (b"\x28\xb5\x2f\xfd\0", &ZSTANDARD),
            (b"%PDF-1.7\n", &PDF),
            (b"\n <!DOCTYPE html>\n<html>", &HTML),
            (b"<HTML><head>", &HTML),
            (b"version https://git-lfs.github.com/spec/v1\noid sha256:0\n", &LFS_POINTER),
            (b"ply\nformat binary_little_endian 1.0\n", &ply::KIND),
            (b"# made by hand\nv 0 0 0\n", &obj::KIND),
            (b"# made by hand\r\n2\r\n450 650\r\n0.3 0 0.5 1.5 0.02 0.04\r\n", &scan::KIND),
            (b"\xef\xbb\xbf2 450 650\n", &scan::KIND),
            (b"# pairs\nname,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n", &scan_csv::KIND),
            (b"theta_i,phi_i,theta_o,phi_o,r,g,b\n", &scan_csv::KIND),
            (b"#DIM 3 1\n#PARAM_IN RUSIN_TH_TD_PD\n0 0 0 1\n", &alta::KIND),
            (b"#HSH1.2\r\n3\r\n320 470 3\r\n9 2 1\r\n\xff", &rti::KIND),
            (b"PTM_1.2\nPTM_FORMAT_RGB\n\xff", &ptm::KIND),
            (b"\n2\r\nphoto 1.jpg 0 0.5 1\r\n", &rti_capture::KIND),
            (b"2\nphoto.jpg 0,1 0,5 1\n", &rti_capture::KIND),
            (b"2\n1 0 0.5 1\n", &scan::KIND),
            (b"2\n0,1 0,2 0,5 1\n", &scan::KIND),
            (b"OPTIS - brdf surface file v8.0\n0\n", &SPEOS),
            (b"OPTIS - Anisotropic BSDF surface file v9.0\n1\x03\0", &SPEOS),
            (b"<?xml version=\"1.0\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\">\n", &WINDOW),
            (b"type bsdf_data\nformat angles=deg bsdf=value scale=1\n10\t0\n", &FRED),
            (b"# measured\nSource  Measured\nSymmetry  PlaneSymmetrical\nSpectralContent  Monochrome\n", &ZEMAX),
            (b"[materials.a]\nsource = 'a.binary'\n", &MANIFEST),
            (b"{\"version\": 1}", &JSON),
            ("Füße\n".as_bytes(), &TEXT),
            ("Fü".as_bytes().split_at(2).0, &TEXT),
        ] {
            assert_eq!(kind(bytes), Some(expected.description), "{:?}", String::from_utf8_lossy(bytes));
        }
        for bytes in [&b""[..], b" \n", b"\0\0\0\0", b"text\0", b"\xfftext", b"\x89PN"] {
            assert_eq!(kind(bytes), None, "{bytes:?}");
        }
    }
}
