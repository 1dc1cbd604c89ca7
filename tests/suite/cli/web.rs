//! The package for the web: its examples draw the same as `brdfc render` or the decoder. `bindings/web/build` makes the package.

use super::environment::room;
use crate::common::cli::Folder;
use brdfc_formats::direction::{DirectionPair, cross, dot, normalize};
use brdfc_formats::table::{TableDecoder, TablePack};
use brdfc_formats::wavelet::{Filter, WaveletDecoder, WaveletPack};
use brdfc_readers::colour::{decode_srgb, encode_srgb_byte};
use brdfc_testing::browser::{File, renderings_of_pages};
use std::path::Path;

const SIDE: u32 = 256;
/// Folder in which pages are compared with one another.
const SMALL: u32 = 96;

/// Files of the package and of a folder of packs, under the paths that the examples ask for.
pub(super) fn files(packs: &Folder) -> Option<Vec<(String, &'static str, Vec<u8>)>> {
    let web = brdfc_testing::repository().join("bindings/web");
    if !web.join("dist/index.js").is_file() {
        println!("skipped: no example for the web is drawn: ./bindings/web/build makes the package");
        return None;
    }
    let mut all = Vec::new();
    let mut add = |folder: &Path, name: &str| {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let media = match path.extension().and_then(|extension| extension.to_str()) {
                Some("js") => "text/javascript",
                Some("html") => "text/html",
                Some("json") => "application/json",
                Some("ktx2") => "image/ktx2",
                _ => continue,
            };
            let file = path.file_name().unwrap().to_str().unwrap();
            all.push((format!("{name}/{file}"), media, std::fs::read(&path).unwrap()));
        }
    };
    add(&web.join("dist"), "dist");
    add(&web.join("examples"), "examples");
    add(&web.join("node_modules/three/build"), "node_modules/three/build");
    add(packs.path(), "packs");
    for entry in std::fs::read_dir(packs.path()).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            add(&path, &format!("packs/{}", path.file_name().unwrap().to_str().unwrap()));
        }
    }
    Some(all)
}

/// Renderings of examples; `None` without a browser.
fn drawn<const N: usize>(
    examples: [String; N],
    side: u32,
    files: &[(String, &'static str, Vec<u8>)],
) -> Option<[image::RgbImage; N]> {
    let served: Vec<File<'_>> =
        files.iter().map(|(name, media, bytes)| (name.as_str(), *media, bytes.as_slice())).collect();
    let pngs = renderings_of_pages(&examples, [side; 2], &served)?;
    if let Some(folder) = std::env::var_os("BRDFC_IMAGES") {
        for (example, png) in examples.iter().zip(&pngs) {
            let name: String = example.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
            std::fs::write(Path::new(&folder).join(name + ".png"), png).unwrap();
        }
    }
    Some(std::array::from_fn(|k| image::load_from_memory(&pngs[k]).unwrap().to_rgb8()))
}

/// Mean and 95th percentile of the differences of display codes, over pixels where the first rendering is not black (its background).
fn differences(a: &image::RgbImage, b: &image::RgbImage) -> (f64, f64) {
    assert_eq!(a.dimensions(), b.dimensions());
    let pair = |(a, b): (&image::Rgb<u8>, &image::Rgb<u8>)| {
        let largest = (0..3).map(|k| f64::from(a[k].abs_diff(b[k]))).fold(0.0, f64::max);
        a.0.iter().any(|code| *code > 0).then_some(largest)
    };
    let mut all: Vec<f64> = a.pixels().zip(b.pixels()).filter_map(pair).collect();
    assert!(all.len() as u32 > a.width() * a.height() / 8, "{} pixels are lit", all.len());
    all.sort_by(f64::total_cmp);
    (all.iter().sum::<f64>() / all.len() as f64, all[all.len() * 95 / 100])
}

fn rendered(folder: &Folder, manifest: &str, more: &[&str]) -> image::RgbImage {
    folder.write("scene.toml", manifest.as_bytes());
    let size = format!("{SIDE}x{SIDE}");
    let run = ["render", "scene.toml", "--size", &size, "--exposure", "1", "--samples", "4", "-o", "expected.png"];
    folder.run(&[&run[..], more].concat()).succeeded();
    image::load_from_memory(&folder.read("expected.png")).unwrap().to_rgb8()
}

/// Encodes a manifest's material, and draws a ball of it with `brdfc render`. The folder NAME gets the pack, `it.brdf.ktx2`.
fn built(folder: &Folder, name: &str, keys: &str, eye: &str, field_of_view: f64) -> image::RgbImage {
    let manifest = format!(
        "[materials.it]\n{keys}\n[[uses]]\nmaterial = \"it\"\n[render]\nscene = \"sphere\"\n[render.camera]\n\
         eye = {eye}\ntarget = [0.0, 0.0, 0.0]\nfield_of_view = {field_of_view}\n[[render.lights]]\n\
         position = [-3.0, 3.0, 4.0]\nintensity = 60.0\n"
    );
    folder.write("scene.toml", manifest.as_bytes());
    folder.run(&["build", "scene.toml", "--out", name]).succeeded();
    rendered(folder, &manifest, &["--packs", name])
}

#[test]
fn a_ball_by_three_js_is_that_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let red = format!("source = {:?}", brdfc_testing::testdata("demo/red_plastic.binary"));
    let wavelet = "source = \"synth:ggx?alpha=0.3\"\ncodec = \"wavelet\"\nratio = 4".to_owned();
    let materials = [("red", red), ("ggx", wavelet.clone()), ("fine", wavelet + "\nbits = 12")];
    let expected = materials.map(|(name, keys)| (name, built(&folder, name, &keys, "[0.0, 0.6, 4.4]", 30.0)));
    let Some(files) = files(&folder) else { return };
    let examples =
        expected.each_ref().map(|(pack, _)| format!("examples/three.html?pack=../packs/{pack}/it.brdf.ktx2"));
    let Some(renderings) = drawn(examples, SIDE, &files) else { return };
    for ((pack, expected), found) in expected.iter().zip(&renderings) {
        let (mean, p95) = differences(found, expected);
        println!("three.js, {pack}: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
        assert!(mean < 1.0 && p95 <= 3.0, "{pack}: {mean} {p95}");
    }
    // Another material is detected.
    assert!(differences(&renderings[0], &renderings[1]).0 > 10.0);
}

/// Lobes in an environment that turns are those of `brdfc render`, and point lights add to it.
#[test]
fn lobes_by_three_js_are_those_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let materials = ["synth:ggx?kd=0.1,0.2,0.4&alpha=0.2", "synth:ward?kd=0.1&ks=0.4&ax=0.1&ay=0.4"];
    for (name, material) in ["round", "brushed"].into_iter().zip(materials) {
        folder
            .run(&["encode", material, "--codec", "lobes", "--max-fetches", "4", "-o", &format!("{name}.ktx2")])
            .succeeded();
    }
    folder.run(&["encode", materials[0], "-o", "table.ktx2"]).succeeded();
    for quarters in [0, 1] {
        room(&folder, &format!("room{quarters}.exr"), quarters);
    }
    folder.run(&["environment", "room0.exr", "-o", "sky.ktx2"]).succeeded();
    let cases = [("round", 0), ("round", 1), ("brushed", 1)];
    let expected = cases.map(|(name, quarters)| {
        let (pack, environment) = (format!("{name}.ktx2"), format!("room{quarters}.exr"));
        let size = format!("{SIDE}x{SIDE}");
        let run =
            ["render", &pack, "--environment", &environment, "--size", &size, "--exposure", "1", "--samples", "4"];
        folder.run(&[&run[..], &["-o", "expected.png"]].concat()).succeeded();
        image::load_from_memory(&folder.read("expected.png")).unwrap().to_rgb8()
    });
    let Some(mut files) = files(&folder) else { return };
    let points = page_of_three(
        "const pack = await loadPack('../packs/table.ktx2');
const camera = new THREE.PerspectiveCamera(31, 1, 0.1, 100);
camera.position.z = 4.6;
const light = { position: new THREE.Vector3(-3, 3, 4), intensity: new THREE.Color(60, 60, 60) };
scene.add(new THREE.Mesh(new THREE.SphereGeometry(1, 128, 64), packMaterial(pack, renderer, [light])));",
    );
    files.push(("examples/points.html".to_owned(), "text/html", points.into_bytes()));
    // three.js has the middle of an image at +x, `render` its border.
    let page = |(name, quarters): (&str, u32)| {
        format!(
            "examples/environment.html?environment=../packs/sky.ktx2&lobes=../packs/{name}.ktx2&turn={}",
            90 * (quarters + 2)
        )
    };
    let pages = cases.map(page);
    let both = format!("{}&pack=../packs/table.ktx2", pages[0]);
    let Some(drawn) =
        drawn([&pages[0], &pages[1], &pages[2], &both, "examples/points.html"].map(String::from), SIDE, &files)
    else {
        return;
    };
    for ((case, expected), found) in cases.iter().zip(&expected).zip(&drawn) {
        let (mean, p95) = differences(found, expected);
        println!("three.js, {case:?}: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
        assert!(mean < 1.0 && p95 <= 3.0, "{case:?}: {mean} {p95}");
    }
    // Another rotation is detected.
    assert!(differences(&drawn[0], &expected[1]).0 > 10.0);
    let [alone, _, _, both, points] = &drawn;
    let sum = image::RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let linear = |image: &image::RgbImage, k: usize| decode_srgb(f64::from(image.get_pixel(x, y)[k]) / 255.0);
        image::Rgb([0, 1, 2].map(|k| encode_srgb_byte((linear(alone, k) + linear(points, k)).min(1.0))))
    });
    let (mean, p95) = differences(both, &sum);
    println!("three.js, point lights and environment: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
    assert!(mean < 1.0 && p95 <= 3.0 && differences(both, alone).0 > 10.0, "{mean} {p95}");
}

/// Flattens buttons; the folder gets `brdf.ktx2` and `factors.ktx2`.
fn flatten_buttons(folder: &Folder) {
    let small = ["--texels", "32", "--views", "grid:3x8@60", "--lights", "grid:3x8@60"];
    for form in ["brdf", "factors"] {
        let flat = ["flatten", "synth:button?resolution=48", "-o", ".", "--name", form, "--reflectance", form];
        folder.run(&[&flat[..], &small].concat()).succeeded();
    }
}

#[test]
fn a_flat_btf_by_three_js_is_that_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    flatten_buttons(&folder);
    let Some(files) = files(&folder) else { return };
    let forms = ["brdf", "factors"];
    let examples = forms.map(|form| format!("examples/flat-btf.html?pack=../packs/{form}.ktx2"));
    let Some(renderings) = drawn(examples, SIDE, &files) else { return };
    for (form, found) in forms.iter().zip(&renderings) {
        let manifest = format!(
            "[render]\nscene = \"plane\"\nasset = \"{form}.ktx2\"\n[render.camera]\n\
             eye = [0.3, 2.5, 2.0]\ntarget = [0.0, 0.0, 0.0]\nfield_of_view = 30\n[[render.lights]]\n\
             position = [-3.0, 2.0, 1.0]\nintensity = 45.0\n"
        );
        let expected = rendered(&folder, &manifest, &["--repeat", "2"]);
        let (mean, p95) = differences(found, &expected);
        println!("three.js, flat BTF, {form}: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
        // Shadows have hard edges, and samples of a pixel are at other places.
        assert!(mean < 3.0 && p95 <= 16.0, "{form}: {mean} {p95}");
        // Light from the other side is detected.
        let turned = rendered(&folder, &manifest.replace("[-3.0, 2.0, 1.0]", "[3.0, 2.0, 1.0]"), &["--repeat", "2"]);
        assert!(differences(found, &turned).0 > 5.0 * mean, "{form}");
    }
}

/// A page that draws `script` with three.js. The script can use `THREE`, `pack`, `renderer`, `asked` (parameters of the address) and
/// `packMaterial`, and makes `scene` and `camera`.
fn page_of_three(script: &str) -> String {
    let example =
        std::fs::read_to_string(brdfc_testing::repository().join("bindings/web/examples/three.html")).unwrap();
    let (head, _) = example.split_once("<script type=\"module\">").unwrap();
    format!(
        "{head}<script type=\"module\">
import * as THREE from 'three';
import {{ loadPack }} from 'brdfc';
import {{ packMaterial }} from 'brdfc/three';
const asked = new URLSearchParams(location.search);
const renderer = new THREE.WebGLRenderer({{ antialias: true }});
renderer.setSize(innerWidth, innerHeight);
document.body.append(renderer.domElement);
const scene = new THREE.Scene();
{script}
renderer.setAnimationLoop(() => renderer.render(scene, camera));
</script>"
    )
}

/// Meshes that are placed by matrices, as instances and in batches, look like those with transformed vertices.
#[test]
fn three_js_places_meshes_as_its_own_materials_do() {
    let folder = Folder::new();
    folder.run(&["encode", "synth:ward?kd=0.1&ks=0.25&ax=0.1&ay=0.4", "-o", "metal.ktx2"]).succeeded();
    let Some(mut files) = files(&folder) else { return };
    let page = page_of_three(
        "const pack = await loadPack('../packs/metal.ktx2');
const camera = new THREE.PerspectiveCamera(30, 1, 0.1, 100);
camera.position.set(0, 0.6, 4.4);
camera.lookAt(0, 0, 0);
const light = { position: new THREE.Vector3(-3, 3, 4), intensity: new THREE.Color(60, 60, 60) };
const material = packMaterial(pack, renderer, [light]);
const geometry = new THREE.SphereGeometry(1, 128, 64);
geometry.computeTangents();
const turn = new THREE.Quaternion().setFromEuler(new THREE.Euler(0.4, 0.7, 0.2));
// three.js transforms normals with the matrices of bones themselves: they stay perpendicular if all axes are scaled alike.
const scale = asked.has('even') ? new THREE.Vector3(0.8, 0.8, 0.8) : new THREE.Vector3(1, 0.5, 0.8);
const place = new THREE.Matrix4().compose(new THREE.Vector3(0.1, 0.2, 0), turn, scale);
const mesh = new THREE.Mesh(geometry, material);
const ways = {
    corners: () => { geometry.applyMatrix4(place); return mesh; },
    matrix: () => { mesh.applyMatrix4(place); return mesh; },
    instance: () => { const all = new THREE.InstancedMesh(geometry, material, 1); all.setMatrixAt(0, place); return all; },
    batch: () => {
        const all = new THREE.BatchedMesh(1, 10000, 60000, material);
        all.setMatrixAt(all.addInstance(all.addGeometry(geometry)), place);
        return all;
    },
    bones: () => {
        const { count } = geometry.attributes.position;
        const weights = Float32Array.from({ length: 4 * count }, (_, k) => (k % 4 === 0 ? 1 : 0));
        geometry.setAttribute('skinIndex', new THREE.Uint16BufferAttribute(new Uint16Array(4 * count), 4));
        geometry.setAttribute('skinWeight', new THREE.Float32BufferAttribute(weights, 4));
        const [skinned, bone] = [new THREE.SkinnedMesh(geometry, material), new THREE.Bone()];
        skinned.add(bone);
        skinned.bind(new THREE.Skeleton([bone]));
        bone.applyMatrix4(place);
        return skinned;
    },
    // Freed textures are uploaded again.
    disposed: () => { geometry.applyMatrix4(place); renderer.render(new THREE.Scene().add(mesh), camera); material.dispose(); return mesh; },
    none: () => mesh,
};
scene.add(ways[asked.get('way')]());",
    );
    files.push(("examples/placed.html".to_owned(), "text/html", page.into_bytes()));
    let ways = ["matrix", "instance", "batch", "disposed", "corners", "none", "bones&even", "corners&even"];
    let Some(renderings) = drawn(ways.map(|way| format!("examples/placed.html?way={way}")), SMALL, &files) else {
        return;
    };
    let [.., expected, none, bones, corners] = &renderings;
    for (way, found) in ways.iter().zip(&renderings[..4]) {
        let (mean, p95) = differences(found, expected);
        println!("three.js, {way}: mean difference {mean:.3} 8-bit levels, {p95} at 95 %");
        assert!(mean < 0.1 && p95 <= 1.0, "{way}: {mean} {p95}");
    }
    assert!(differences(none, expected).0 > 10.0);
    let (mean, p95) = differences(bones, corners);
    println!("three.js, bones: mean difference {mean:.3} 8-bit levels, {p95} at 95 %");
    assert!(mean < 0.1 && p95 <= 1.0, "bones: {mean} {p95}");
}

/// A flat BTF is uploaded correctly among textures that are flipped, and again after it was freed or its context was lost.
#[test]
fn three_js_uploads_arrays_among_other_textures() {
    let folder = Folder::new();
    flatten_buttons(&folder);
    let Some(mut files) = files(&folder) else { return };
    let page = page_of_three(
        "const pack = await loadPack('../packs/brdf.ktx2');
const camera = new THREE.PerspectiveCamera(30, 1, 0.1, 100);
camera.position.set(0, 0.6, 4.4);
camera.lookAt(0, 0, 0);
const light = { position: new THREE.Vector3(-3, 3, 4), intensity: new THREE.Color(60, 60, 60) };
const geometry = new THREE.SphereGeometry(1, 128, 64);
geometry.computeTangents();
if (asked.has('texture')) {
    const flat = new THREE.CanvasTexture(new OffscreenCanvas(4, 4));
    flat.image.getContext('2d').fillRect(0, 0, 4, 4);
    renderer.render(new THREE.Scene().add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ map: flat }))), camera);
}
const material = packMaterial(pack, renderer, [light]);
const mesh = new THREE.Mesh(geometry, material);
scene.add(mesh);
if (asked.has('freed')) {
    renderer.render(scene, camera);
    material.dispose();
}
if (asked.has('lost')) {
    renderer.render(scene, camera);
    const restored = new Promise((done) => renderer.domElement.addEventListener('webglcontextrestored', done));
    renderer.forceContextLoss();
    await new Promise((done) => setTimeout(done, 100));
    renderer.forceContextRestore();
    await restored;
}",
    );
    files.push(("examples/among.html".to_owned(), "text/html", page.into_bytes()));
    let ways = ["alone", "texture", "freed", "lost"];
    let Some(renderings) = drawn(ways.map(|way| format!("examples/among.html?{way}")), SMALL, &files) else { return };
    for (way, found) in ways.iter().zip(&renderings).skip(1) {
        let (mean, p95) = differences(&renderings[0], found);
        assert!(mean == 0.0 && p95 == 0.0, "{way}: {mean} {p95}");
    }
}

/// From far away, levels of detail are those of `brdfc render`.
#[test]
fn a_distant_ball_by_three_js_is_that_of_render() {
    if !crate::common::has_adapter() {
        return;
    }
    let folder = Folder::new();
    let keys = "source = \"synth:ggx?kd=0.05&alpha=0.05\"\ncodec = \"factored\"\nlevels = 4";
    let expected = built(&folder, "far", keys, "[0.0, 6.0, 44.0]", 3.0);
    let Some(mut files) = files(&folder) else { return };
    // Without tangents, which isotropic materials do not need.
    let page = page_of_three(
        "const pack = await loadPack('../packs/far/it.brdf.ktx2', asked.has('finest') ? { distanceScale: 1e-6 } : {});
const camera = new THREE.PerspectiveCamera(3, 1, 0.1, 100);
camera.position.set(0, 6, 44);
camera.lookAt(0, 0, 0);
const light = { position: new THREE.Vector3(-3, 3, 4), intensity: new THREE.Color(60, 60, 60) };
scene.add(new THREE.Mesh(new THREE.SphereGeometry(1, 256, 128), packMaterial(pack, renderer, [light])));",
    );
    files.push(("examples/far.html".to_owned(), "text/html", page.into_bytes()));
    let examples = ["examples/far.html", "examples/far.html?finest"].map(str::to_owned);
    let Some([found, finest]) = drawn(examples, SIDE, &files) else { return };
    let (mean, p95) = differences(&found, &expected);
    println!("three.js, from far away: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
    assert!(mean < 1.0 && p95 <= 3.0, "{mean} {p95}");
    // The finest level is a different rendering.
    assert!(differences(&finest, &expected).0 > 2.0 * mean + 1.0);
}

/// A polynomial wavelet tree on a square that fills the rendering, compared with values of the CPU's decoder.
#[test]
fn a_rendering_by_three_js_is_that_of_the_decoder() {
    let folder = Folder::new();
    let small = ["--texels", "32", "--views", "grid:2x6@50", "--lights", "grid:5x12@75", "--reflectance", "factors"];
    folder.run(&[&["flatten", "synth:button?resolution=48", "-o", "button"][..], &small].concat()).succeeded();
    folder.run(&["pwt", "button", "-o", "it.ktx2"]).succeeded();
    let Some(mut files) = files(&folder) else { return };
    let page = page_of_three(
        "const pack = await loadPack('../packs/it.ktx2');
const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 10);
camera.position.z = 5;
const far = 1e4;
const light = {
    position: new THREE.Vector3(-0.48, 0.64, 0.6).multiplyScalar(far),
    intensity: new THREE.Color(1, 1, 1).multiplyScalar(Math.PI * far * far),
};
const geometry = new THREE.PlaneGeometry(2, 2);
geometry.computeTangents();
scene.add(new THREE.Mesh(geometry, packMaterial(pack, renderer, [light])));",
    );
    files.push(("examples/rendering.html".to_owned(), "text/html", page.into_bytes()));
    let mut places = String::from("u,v,wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n");
    for k in 0..SIDE * SIDE {
        let [u, v] = [k % SIDE, k / SIDE].map(|at| (f64::from(at) + 0.5) / f64::from(SIDE));
        places += &format!("{u},{v},-0.48,0.64,0.6,0,0,1\n");
    }
    folder.write("places.csv", places.as_bytes());
    let values = folder.run(&["eval", "it.ktx2", "--directions", "places.csv"]).succeeded().stdout;
    let of_row = |row: &str| {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        image::Rgb(std::array::from_fn(|k| encode_srgb_byte(numbers[numbers.len() - 3 + k])))
    };
    let pixels: Vec<image::Rgb<u8>> = values.lines().skip(1).map(of_row).collect();
    let expected = image::RgbImage::from_fn(SIDE, SIDE, |x, y| pixels[(SIDE * y + x) as usize]);
    let Some([found]) = drawn(["examples/rendering.html".to_owned()], SIDE, &files) else { return };
    let (mean, p95) = differences(&found, &expected);
    println!("three.js, pwt: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
    assert!(mean < 1.0 && p95 <= 2.0, "{mean} {p95}");
    // Upside down it is a different rendering.
    assert!(differences(&image::imageops::flip_vertical(&found), &expected).0 > 5.0 * mean + 1.0);
}

/// The rendering of the WebGPU example by the CPU's decoder: an orthographic ball under a distant light, `2 f_r cos` with a
/// gamma of 2.2.
fn ball(f_r: impl Fn(DirectionPair) -> [f32; 3]) -> image::RgbImage {
    image::RgbImage::from_fn(SIDE, SIDE, |x, y| {
        let [x, y] = [x, y].map(|at| ((f64::from(at) + 0.5) / f64::from(SIDE / 2) - 1.0) * 1.1);
        let (x, y) = (x, -y);
        let square = x * x + y * y;
        if square >= 1.0 {
            return image::Rgb([0; 3]);
        }
        let normal = [x, y, (1.0 - square).sqrt()];
        let tangent = normalize([normal[2], 0.0, -normal[0]]);
        let bitangent = cross(normal, tangent);
        let local = |v| [tangent, bitangent, normal].map(|axis| dot(v, axis));
        let pair = DirectionPair::new(local(normalize([-3.0, 3.0, 4.0])), local([0.0, 0.0, 1.0]));
        let code = |value: f32| {
            let radiance = f64::from(value) * pair.incoming[2].max(0.0) * 2.0;
            (radiance.min(1.0).powf(1.0 / 2.2) * 255.0).round() as u8
        };
        image::Rgb(f_r(pair).map(code))
    })
}

#[test]
fn a_ball_by_webgpu_is_that_of_the_decoder() {
    let folder = Folder::new();
    let red = brdfc_testing::testdata("demo/red_plastic.binary");
    folder.run(&["encode", &red, "-o", "red.ktx2"]).succeeded();
    folder.run(&["encode", "synth:ggx?alpha=0.3", "--codec", "wavelet", "-o", "ggx.ktx2"]).succeeded();
    let Some(files) = files(&folder) else { return };
    let table = TableDecoder::new(&TablePack::from_bytes(&folder.read("red.ktx2")).unwrap());
    let wavelet = WaveletDecoder::new(&WaveletPack::from_bytes(&folder.read("ggx.ktx2")).unwrap());
    let expected = [
        ("red", ball(|pair| table.eval(pair))),
        // The example requests level 6, which is the finest of any pack.
        ("ggx", ball(|pair| wavelet.eval(pair, 6.0, Filter::Bilinear))),
    ];
    let examples = expected.each_ref().map(|(pack, _)| format!("examples/webgpu.html?pack=../packs/{pack}.ktx2"));
    let Some(renderings) = drawn(examples, SIDE, &files) else { return };
    for ((pack, expected), found) in expected.iter().zip(&renderings) {
        let (mean, p95) = differences(found, expected);
        println!("WebGPU, {pack}: mean difference {mean:.2} 8-bit levels, {p95} at 95 %");
        assert!(mean < 1.0 && p95 <= 2.0, "{pack}: {mean} {p95}");
    }
    // Another material is detected.
    assert!(differences(&expected[0].1, &expected[1].1).0 > 10.0);
}
