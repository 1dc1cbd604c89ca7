use super::*;
use crate::meso::testing::{meshes, mutate};
use proptest::prelude::*;

const HEADER: &str = "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
const BODY: &str = "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n4 0 1 2 3\n";

fn message(text: &str) -> String {
    from_bytes(text.as_bytes()).unwrap_err().to_string()
}

fn square() -> String {
    format!("{HEADER}{BODY}")
}

#[test]
fn a_polygon_becomes_a_fan() {
    for text in [
        square(),
        square().replace('\n', "\r\n"),
        square().replace("vertex_indices", "vertex_index"),
        square().replace("float", "float64").replace("uchar int", "uint8 uint16"),
        format!("{HEADER}{}", BODY.replace('\n', " ")),
    ] {
        let mesh = from_bytes(text.as_bytes()).unwrap();
        assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]]);
        assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
        assert!(mesh.materials.is_empty() && mesh.colours.is_empty());
    }
}

#[test]
fn other_elements_and_properties_are_skipped() {
    let text = "ply\nformat ascii 1.0\nelement nothing 18446744073709551615\nelement camera 1\n\
        property float view\nproperty list int float k\nelement face 1\nproperty uchar flags\n\
        property list uchar float texcoord\nproperty list uchar uint vertex_index\nelement vertex 3\nproperty short z\n\
        property list uchar int more\nproperty double y\nproperty uchar red\nproperty uchar green\n\
        property uchar blue\n\
        property uchar alpha\nproperty int x\nend_header\n\
        nan 2 0.5 0.5\n7 2 0 0 3 2 0 1\n-1 0 2.5 0 255 128 255 3\n-2 1 9 2.5 0 255 128 255 4\n\
        -3 0 3e0 0 255 128 255 5\n";
    let mesh = from_bytes(text.as_bytes()).unwrap();
    assert_eq!(mesh.positions, [[3.0, 2.5, -1.0], [4.0, 2.5, -2.0], [5.0, 3.0, -3.0]]);
    assert_eq!(mesh.triangles, [[2, 0, 1]]);
    assert_eq!((mesh.colours[0][0], mesh.colours[0][1]), (0.0, 1.0));
    assert!((mesh.colours[0][2] - 0.215_861).abs() < 1e-6, "128 of sRGB");
}

/// Programs name the properties of a colour differently.
#[test]
fn colours_have_several_names() {
    let file = |[r, g, b]: [&str; 3]| {
        let text = format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             property uchar {r}\nproperty uchar {g}\nproperty uchar {b}\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n"
        );
        from_bytes(text.as_bytes())
    };
    let expected = file(["red", "green", "blue"]).unwrap().colours;
    assert_eq!(expected[1], [0.0, 1.0, 0.0]);
    for names in [["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]] {
        assert_eq!(file(names).unwrap().colours, expected, "{names:?}");
    }
    assert_eq!(file(["nx", "ny", "nz"]).unwrap().colours, Vec::<[f32; 3]>::new());
    let some = file(["diffuse_red", "diffuse_green", "depth"]).unwrap_err().to_string();
    assert!(some.contains("only some of diffuse_red, diffuse_green and diffuse_blue"), "{some}");
}

/// A file with every type, in the byte order of `bytes`.
fn binary(order: &str, bytes: fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut file = format!(
        "ply\nformat binary_{order}_endian 1.0\nelement vertex 3\nproperty float x\nproperty double y\n\
        property short z\n\
        property float red\nproperty float green\nproperty double blue\nelement face 1\nproperty ushort a\n\
        property list int uint vertex_indices\nproperty char b\nend_header\n"
    )
    .into_bytes();
    for k in 0..3i16 {
        let number = f32::from(k);
        file.extend(bytes(&(number + 0.5).to_le_bytes()));
        file.extend(bytes(&f64::from(-number).to_le_bytes()));
        file.extend(bytes(&(300 * k).to_le_bytes()));
        file.extend(bytes(&0.25f32.to_le_bytes()));
        file.extend(bytes(&0.5f32.to_le_bytes()));
        file.extend(bytes(&1.0f64.to_le_bytes()));
    }
    file.extend(bytes(&513u16.to_le_bytes()));
    file.extend(bytes(&3i32.to_le_bytes()));
    (0..3u32).for_each(|k| file.extend(bytes(&k.to_le_bytes())));
    file.push(0xff);
    file
}

fn little() -> Vec<u8> {
    binary("little", <[u8]>::to_vec)
}

fn big() -> Vec<u8> {
    binary("big", |bytes| bytes.iter().rev().copied().collect())
}

#[test]
fn both_byte_orders_hold_the_same() {
    let mesh = from_bytes(&little()).unwrap();
    assert_eq!(mesh.positions, [[0.5, 0.0, 0.0], [1.5, -1.0, 300.0], [2.5, -2.0, 600.0]]);
    assert_eq!((mesh.triangles.as_slice(), mesh.colours[2]), ([[0, 1, 2]].as_slice(), [0.25, 0.5, 1.0]));
    assert_eq!(from_bytes(&big()).unwrap(), mesh);
    let swapped = String::from_utf8_lossy(&big()).contains("big");
    assert!(swapped && little() != big());
}

#[test]
fn errors_say_where() {
    assert_eq!(message(""), "header: end of data after 0 bytes; expected end_header");
    assert_eq!(message("plx\n"), "line 1, first line: found \"plx\", expected ply");
    assert!(message("ply\nformat ascii 2.0\n").starts_with("line 2, format: found \"ascii 2.0\", expected ascii,"));
    assert!(message("ply\nend_header\n").contains("line 2, header: found \"end_header\", expected a line format"));
    assert!(message("ply\nelement vertex -1\n").contains("line 2, element count: found \"-1\""));
    assert!(
        message("ply\nelement a 1\nelement a 1\n").contains("line 3, element: found \"a\", expected each name once")
    );
    assert!(message("ply\nproperty int a\n").contains("expected an element before it"));
    assert!(message("ply\nelement a 1\nproperty half a\n").contains("expected char, uchar"));
    assert!(message("ply\nelement a 1\nproperty list int a\n").contains("line 3, header"));
    assert!(message("ply\nelement a 1\nproperty int a\nproperty int a\n").contains("line 4, property: found \"a\""));
    let expected = "line 2, header: found \"rubbish\", expected format ENCODING 1.0, comment, obj_info";
    assert!(message("ply\nrubbish\n").contains(expected));
    assert!(message("ply\nformat ascii 1.0").contains("a line feed after it"));
    let changed = |from: &str, to: &str| message(&square().replace(from, to));
    assert!(
        changed("element vertex", "element point")
            .contains("elements: found \"point face\", expected an element vertex")
    );
    assert!(changed("float z", "float w").contains("line 4, vertex: found \"x y w\", expected scalar properties x, y"));
    assert!(
        changed("list uchar int vertex_indices", "int vertex_indices")
            .contains("line 9, face: vertex indices have another type")
    );
    assert!(changed("uchar int vertex_indices", "uchar float vertex_indices").contains("have another type"));
    assert!(changed("vertex_indices", "v").contains("line 8, face: no list"));
    assert!(changed("float z\n", "float z\nproperty uchar red\n").contains("only some of red, green and blue"));
    assert!(
        changed("float z\n", "float z\nproperty int red\nproperty int green\nproperty int blue\n")
            .contains("line 8, colour: red, green and blue have other types")
    );
    assert!(changed("1 1 0\n", "1 nan 0\n").contains("line 13, coordinate: found NaN, expected -1e12 to 1e12"));
    assert!(changed("1 1 0\n", "1 1e13 0\n").contains("coordinate: found 10000000000000"));
    assert!(changed("1 1 0\n", "1 x 0\n").contains("line 13, vertex: found \"x\", expected a number"));
    assert!(changed("4 0 1 2 3", "4 0 1 2 4").contains("line 15, vertex index: found 4, expected 0 or more, below 4"));
    assert!(changed("4 0 1 2 3", "4 0 1 2 -1").contains("vertex index: found -1"));
    assert!(changed("4 0 1 2 3", "4 0 1 2 1.5").contains("found \"1.5\", expected an integer"));
    assert!(changed("4 0 1 2 3", "2 0 1").contains("line 15, face: found 2 corners, expected 3 or more"));
    assert!(changed("4 0 1 2 3", "256 0 1").contains("found \"256\", expected an integer, 0 to 255"));
    assert!(changed("4 0 1 2 3", "4 0 1 2").contains("line 15, vertex index: end of data"));
    assert!(changed("4 0 1 2 3", "3 0 1 2 3").contains("end of data: found \"3\", expected nothing after"));
    assert!(changed("vertex 4", "vertex 999999999999").contains("element count: found 999999999999 rows of vertex"));
    let empty = square().replace("face 1", "face 0").replace("4 0 1 2 3\n", "");
    assert_eq!(message(&empty), "faces: no faces, and 4 vertices; expected at least one face");
    let not_text = [HEADER.as_bytes(), b"0 0 0\n\xff"].concat();
    assert!(from_bytes(&not_text).unwrap_err().to_string().starts_with("line 12, text: found byte 0xff"));
}

#[test]
fn errors_of_binary_files_name_the_byte() {
    let good = little();
    for length in 0..good.len() {
        assert!(from_bytes(&good[..length]).is_err(), "{length}");
    }
    let start = good.len() - (1 + 12 + 4 + 2) - 3 * 30;
    let error = |at: usize, bytes: &[u8]| {
        let mut file = good.clone();
        file[at..at + bytes.len()].copy_from_slice(bytes);
        from_bytes(&file).unwrap_err().to_string()
    };
    let place = |offset: usize| format!("byte {}, ", start + offset);
    assert!(error(start, &f32::NAN.to_le_bytes()).starts_with(&format!("{}coordinate: found NaN", place(30))));
    assert!(error(start + 14, &2.0f32.to_le_bytes()).starts_with(&format!("{}colour: found 2,", place(30))));
    let faces = start + 90;
    let length = error(faces + 2, &i32::MAX.to_le_bytes());
    assert_eq!(
        length,
        format!("{}list length: found 2147483647, expected 0 to 3, limited by the remaining data", place(96))
    );
    assert!(error(faces + 2, &(-1i32).to_le_bytes()).contains("list length: found -1"));
    assert!(error(faces + 6, &7u32.to_le_bytes()).contains("vertex index: found 7"));
    let longer = [good.as_slice(), &[0]].concat();
    assert!(from_bytes(&longer).unwrap_err().to_string().contains("end of data: found 1 bytes"));
}

#[test]
fn no_change_of_bytes_panics() {
    for bytes in [square().into_bytes(), little(), big()] {
        mutate(&bytes, from_bytes);
    }
}

proptest! {
    #[test]
    fn meshes_round_trip(mesh in meshes()) {
        let mut bytes = Vec::new();
        write(&mut bytes, &mesh).unwrap();
        prop_assert_eq!(from_bytes(&bytes).unwrap(), mesh);
    }
}

#[test]
fn headers_have_an_end() {
    let message = |bytes: &[u8]| from_bytes(bytes).unwrap_err().to_string();
    let start = "ply\nformat ascii 1.0\nelement vertex 1\n";
    let properties: String = (0..1025).map(|k| format!("property float p{k}\n")).collect();
    let expected = "line 1028, property: found \"p1024\", expected at most 1024 properties of an element";
    assert_eq!(message(format!("{start}{properties}").as_bytes()), expected);
    let expected = "line 1, header: no end_header in 1048576 bytes; expected a shorter header";
    assert_eq!(message(&vec![0; 2 << 20]), expected);
    let many = format!(
        "{}element face 0\nproperty list uchar int vertex_indices\nend_header\n",
        start.replace("vertex 1", "vertex 9000000")
    );
    let many = many.replace("element face", "property uchar x\nproperty uchar y\nproperty uchar z\nelement face");
    let bytes = [many.replace("ascii", "binary_little_endian").as_bytes(), &vec![1; 27_000_000]].concat();
    assert_eq!(message(&bytes), "line 3, vertices: found 9000000, expected at most 8388608");
}
