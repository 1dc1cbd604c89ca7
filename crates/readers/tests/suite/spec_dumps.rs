//! The dumps and texts on the pages of measured files match files that these tests create.

use brdfc_readers::merl::{self, Merl};
use brdfc_readers::meso::{obj, ply};
use brdfc_readers::scan::Scan;
use brdfc_readers::{btf_stack, direction_list, scan_csv};
use brdfc_testing::packs::check_dump;

#[test]
fn merl_tables() {
    let page = include_str!("../../src/merl.md");
    let dimensions = merl::Dimensions { theta_half: 1, theta_difference: 1, phi_difference: 2 };
    let mut bytes = Vec::new();
    let value = |[.., phi]: [f64; 3]| (phi == 0.0).then_some(merl::SCALES.map(|scale| 750.0 * scale));
    merl::write(&mut bytes, dimensions, value).unwrap();
    assert_eq!(Merl::from_bytes(&bytes).unwrap().valid_cells, 1);
    assert_eq!(check_dump(page, &bytes), 4);
}

/// The pages contain the text files verbatim between fences; the dump shows their first bytes.
#[test]
fn scans() {
    let page = include_str!("../../src/scan.md");
    let text = fenced(page);
    let scan = Scan::from_bytes(text.as_bytes()).unwrap();
    assert_eq!((scan.wavelengths.as_slice(), scan.rows.len()), ([450.0, 650.0].as_slice(), 2));
    assert_eq!(check_dump(page, text.as_bytes()), 5);
}

#[test]
fn scans_as_csv() {
    let page = include_str!("../../src/scan_csv.md");
    let text = fenced(page);
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
    assert_eq!(ply::from_bytes(&bytes).unwrap(), mesh);
    assert_eq!(check_dump(page, &bytes), 19);
}

#[test]
fn the_text_rules_on_the_pages_of_scans_hold() {
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
        format!("{}\n{row}", head.to_uppercase()),
        " theta_i ,phi_i,note,theta_o,phi_o,\"r\",g,b,r\n0,0,any thing,0,0,\"0.5\",0,0,7\n".to_owned(),
        "b,g,r,phi_o,theta_o,phi_i,theta_i\n0,0, 5e-1 ,0,0,0,0\r\n".to_owned(),
        "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,f_r,f_g,f_b\n0,0,1.009,0,0,0.991,0.5,0,0\n".to_owned(),
    ] {
        assert_eq!(red(&good), Ok(0.5), "{good:?}");
    }
    for bad in [
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
    let page = include_str!("../../src/btf_stack.md");
    let name = fenced(page).trim();
    let angles = btf_stack::parse_name(name).unwrap();
    assert_eq!((angles.view, angles.light), ([30.0, 30.0], [0.0, 0.0]));
    assert_eq!(btf_stack::image_name(8, angles, "png"), name);
    let list = fenced(page.split_once("## Direction lists").unwrap().1);
    let set = direction_list::from_csv(list.as_bytes()).unwrap();
    assert_eq!((set.angles[2], direction_list::to_csv(&set).as_str()), ([37.5, 180.0], list));
}

/// Contents of the first fence of a page.
fn fenced(page: &str) -> &str {
    page.split_once("```text\n").unwrap().1.split_once("```").unwrap().0
}
