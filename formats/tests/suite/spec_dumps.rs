//! The dumps on the pages of the layouts are the bytes of files that these tests make.

use brdfc_formats::container::Texture;
use brdfc_formats::direction::DirectionPair;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::flat_btf::{
    DiffuseMap, FlatBtfDecoder, FlatBtfParts, FlatValues, FlatView, IndirectionMap, NormalMap, ReferenceMap,
};
use brdfc_formats::measured::merl::{self, Merl};
use brdfc_formats::measured::scan::Scan;
use brdfc_formats::measured::{btf_stack, scan_csv};
use brdfc_formats::meso::{obj, ply};
use brdfc_formats::pwt::shader::PwtParameters;
use brdfc_formats::pwt::{PwtDecoder, PwtPack};
use brdfc_formats::wavelet::{Filter, RowScratch, WaveletDecoder, WaveletPack};
use brdfc_testing::packs::check_dump;

#[test]
fn containers() {
    let page = include_str!("../../src/container/spec.md");
    let bytes = brdfc_testing::packs::example().to_bytes(false);
    assert!(Texture::from_bytes(&bytes).is_ok());
    print(&bytes);
    // The entries between stand on the page of wavelet packs.
    assert_eq!(check_dump(page, &bytes), 15);
}

#[test]
fn wavelet_packs() {
    let page = include_str!("../../src/wavelet/spec.md");
    let bytes = brdfc_testing::packs::example().to_bytes(false);
    assert_eq!(WaveletPack::from_bytes(&bytes).unwrap(), brdfc_testing::packs::example());
    assert_eq!(check_dump(page, &bytes), 17);
}

/// Two files stand on the page, one after the other.
#[test]
fn flat_btfs() {
    let page = include_str!("../../src/flat_btf/spec.md");
    let (first, second) = page.split_once("### A view").unwrap();
    let bytes = brdfc_testing::flat_btf::example_indirection().to_bytes(false);
    print(&bytes);
    assert_eq!(IndirectionMap::from_bytes(&bytes).unwrap(), brdfc_testing::flat_btf::example_indirection());
    assert_eq!(check_dump(first, &bytes), 22);
    let bytes = brdfc_testing::flat_btf::example_view().to_bytes(false);
    print(&bytes);
    assert_eq!(FlatView::from_bytes(&bytes).unwrap(), brdfc_testing::flat_btf::example_view());
    assert_eq!(check_dump(second, &bytes), 25);
}

/// The value below the first dump.
#[test]
fn the_worked_value_of_the_flat_btf_page() {
    let decoder = FlatBtfDecoder::new(FlatBtfParts {
        reference: ReferenceMap::new(1, vec![[0.9, 0.5]]).unwrap(),
        indirection: brdfc_testing::flat_btf::example_indirection().into(),
        normal: NormalMap::new(1, vec![[0.0, 0.0, 1.0]]).unwrap(),
        diffuse: DiffuseMap::new(1, vec![0]).unwrap(),
        values: FlatValues::None,
    });
    let [u, v, z] = decoder.unwrap().indirection([0.2, 0.7], [0.5f32.sin(), 0.0, 0.5f32.cos()]);
    assert!((u - 0.025).abs() < 1e-6 && v == 0.5 && (z - 0.25).abs() < 1e-6, "{u} {v} {z}");
}

/// The values at the foot of the page.
#[test]
fn the_worked_values_of_the_wavelet_page() {
    let page = include_str!("../../src/wavelet/spec.md");
    let (_, foot) = page.split_once("For `wi = (0, 0.6, 0.8)` and `wo = (0.6, 0, 0.8)`").expect("the pair");
    let decoder = WaveletDecoder::new(&brdfc_testing::packs::example());
    let pair = DirectionPair::new([0.0, 0.6, 0.8], [0.6, 0.0, 0.8]);
    for (filter, level, v, f) in [
        (Filter::Nearest, 1.0, "-0.676777", "0.249126"),
        (Filter::Nearest, 0.0, "-1 / 2", "0.298265"),
        (Filter::Bilinear, 1.0, "-0.241379", "0.387772"),
        (Filter::Bilinear, 0.0, "-0.219447", "0.396481"),
    ] {
        assert!(foot.contains(v) && foot.contains(f), "{v} {f}");
        let [found, ..] = decoder.log_value(pair, level, filter);
        let expected = v.parse().unwrap_or(-0.5f32);
        assert!((found - expected).abs() < 1e-6, "{found} {v}");
        let [found, ..] = decoder.eval(pair, level, filter);
        assert!((found - f.parse::<f32>().unwrap()).abs() < 1e-6, "{found} {f}");
    }
    // The same cells by themselves.
    let mut row = [0.0; 4];
    decoder.decode_row(0, 0, &mut row, &mut RowScratch::default());
    let f = decoder.from_log(row[1]);
    assert!((row[1] + 0.676_777).abs() < 1e-6 && (f - 0.249_126).abs() < 1e-6, "{} {f}", row[1]);
}

#[test]
fn polynomial_wavelet_trees() {
    let page = include_str!("../../src/pwt/spec.md");
    let example = brdfc_testing::pwt::example();
    let bytes = example.to_bytes(false);
    print(&bytes);
    assert_eq!(PwtPack::from_bytes(&bytes).unwrap(), example);
    assert_eq!(check_dump(page, &bytes), bytes.len().div_ceil(16));
    assert!(page.contains(&format!("a uniform block of {} bytes", PwtParameters::SIZE)));
    // The values at the foot of the page.
    let decoder = PwtDecoder::new(example);
    for (uv, expected) in [([0.25, 0.25], 0.09), ([0.5, 0.5], 0.49)] {
        let [value, ..] = decoder.value(uv, 0.0, [0.6, 0.0, 0.8]);
        assert!((value - expected).abs() < 1e-6 && page.contains(&format!("= {expected}`")), "{uv:?} {value}");
    }
}

#[test]
fn merl_tables() {
    let page = include_str!("../../src/measured/merl.md");
    let dimensions = merl::Dimensions { theta_half: 1, theta_difference: 1, phi_difference: 2 };
    let mut bytes = Vec::new();
    let value = |[.., phi]: [f64; 3]| (phi == 0.0).then_some(merl::SCALES.map(|scale| 750.0 * scale));
    merl::write(&mut bytes, dimensions, value).unwrap();
    print(&bytes);
    assert_eq!(Merl::from_bytes(&bytes).unwrap().valid_cells, 1);
    assert_eq!(check_dump(page, &bytes), 4);
}

/// The text files stand on their pages as they are, between fences; the dump shows their first bytes.
#[test]
fn scans() {
    let page = include_str!("../../src/measured/scan.md");
    let text = fenced(page);
    print(text.as_bytes());
    let scan = Scan::from_bytes(text.as_bytes()).unwrap();
    assert_eq!((scan.wavelengths.as_slice(), scan.rows.len()), ([450.0, 650.0].as_slice(), 2));
    assert_eq!(check_dump(page, text.as_bytes()), 5);
}

#[test]
fn scans_as_csv() {
    let page = include_str!("../../src/measured/scan_csv.md");
    let text = fenced(page);
    print(text.as_bytes());
    let scan = scan_csv::from_bytes(text.as_bytes()).unwrap();
    assert_eq!((scan.rows.len(), scan.rows[1].value), (2, [0.25, 0.125, -0.001]));
    assert_eq!(check_dump(page, text.as_bytes()), 7);
}

#[test]
fn meshes() {
    let page = include_str!("../../src/meso/spec.md");
    let mesh = obj::from_bytes(fenced(page).as_bytes()).unwrap();
    assert_eq!((mesh.positions[2], mesh.triangles.as_slice()), ([2.0, 2.0, 0.0], [[0, 1, 2], [0, 2, 3]].as_slice()));
    let mut bytes = Vec::new();
    ply::write(&mut bytes, &mesh).unwrap();
    print(&bytes);
    assert_eq!(ply::from_bytes(&bytes).unwrap(), mesh);
    assert_eq!(check_dump(page, &bytes), 19);
}

#[test]
fn what_the_pages_of_scans_say_about_text() {
    let scan = |text: &str| Scan::from_bytes(text.as_bytes());
    for good in [
        "2 450 650\n0 0 0 0 1 1\n",
        "2 450\r\n\r\n650 # nm\r\n0 0 0 0\t1 1",
        "1 380\n0 0 0 0 1",
        "1\n780\n1.57085 6.28320 0 -6.28320 -1",
        "2 100 3000\n0 0 0 0 1 1",
    ] {
        assert!(scan(good).is_ok(), "{good:?}: {:?}", scan(good));
    }
    assert_eq!(scan("1\n780\n1.57085 0 0 0 1").unwrap().rows[0].theta_i, std::f64::consts::FRAC_PI_2);
    for bad in [
        "2 450 650 0 0 0 0 1 1\n",
        "1 450\n0 0 0 0 1 0 0 0 0 1\n",
        "1 379\n0 0 0 0 1\n",
        "1 781\n0 0 0 0 1\n",
        "2 99 500\n0 0 0 0 1 1\n",
        "2 500 3001\n0 0 0 0 1 1\n",
        "2 500 500\n0 0 0 0 1 1\n",
        "1 500\n1.571 0 0 0 1\n",
        "1 500\n-1e-5 0 0 0 1\n",
        "1 500\n0 6.2834 0 0 1\n",
        "1 500\n0 0 0 0 1.1e12\n",
    ] {
        assert!(scan(bad).is_err(), "{bad:?}");
    }
    let red = |text: &str| scan_csv::from_bytes(text.as_bytes()).map(|scan| scan.rows[0].value[0]);
    let (head, row) = ("theta_i,phi_i,theta_o,phi_o,r,g,b", "0,0,0,0,0.5,0,0");
    for good in [
        format!("\u{feff}{head}\n{row}\n"),
        format!("# first\n{head}\n\n#x\n{row}"),
        " theta_i ,phi_i,note,theta_o,phi_o,\"r\",g,b,r\n0,0,any thing,0,0,\"0.5\",0,0,7\n".to_owned(),
        "b,g,r,phi_o,theta_o,phi_i,theta_i\n0,0, 5e-1 ,0,0,0,0\r\n".to_owned(),
        "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,1.009,0,0,0.991,0.5,0,0\n".to_owned(),
    ] {
        assert_eq!(red(&good), Ok(0.5), "{good:?}");
    }
    for bad in [
        format!("{}\n{row}", head.to_uppercase()),
        format!("{head}\n{row},1\n"),
        "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,1,0,0,-1,0.5,0,0\n".to_owned(),
        "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,1,0,0,1.02,0.5,0,0\n".to_owned(),
    ] {
        assert!(red(&bad).is_err(), "{bad:?}");
    }
    assert_eq!(scan_csv::directions_from_bytes(b"wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n"), Ok(Vec::new()));
}

/// The name and the list of directions on the page of image stacks.
#[test]
fn image_stacks() {
    let page = include_str!("../../src/measured/btf_stack.md");
    let name = fenced(page).trim();
    let angles = btf_stack::parse_name(name).unwrap();
    assert_eq!((angles.view, angles.light), ([30.0, 30.0], [0.0, 0.0]));
    assert_eq!(btf_stack::image_name(8, angles, "png"), name);
    let list = fenced(page.split_once("## Direction lists").unwrap().1);
    let set = DirectionSet::from_csv(list.as_bytes()).unwrap();
    assert_eq!((set.angles[2], set.to_csv().as_str()), ([37.5, 180.0], list));
}

/// Contents of the first fence of a page.
fn fenced(page: &str) -> &str {
    page.split_once("```text\n").unwrap().1.split_once("```").unwrap().0
}

/// Shown when a test fails, to be put on the page.
fn print(bytes: &[u8]) {
    for (line, chunk) in bytes.chunks(16).enumerate() {
        let hex: Vec<String> = chunk.iter().map(|byte| format!("{byte:02x}")).collect();
        let text: String = chunk.iter().map(|b| if (0x20..0x7f).contains(b) { char::from(*b) } else { '.' }).collect();
        println!("{:08x}  {:47}  {text}", 16 * line, hex.join(" "));
    }
}
