#[path = "../tests/common/flat.rs"]
#[allow(dead_code)]
mod made;
use brdfc::metrics::image::{auto_exposure, compare_images};
use brdfc::render::flat::*;
use brdfc::render::gpu::*;
use brdfc::render::picture::to_png;
use brdfc::render::scene::Frame;
use brdfc::render::scenes::Builtin;
use brdfc::source::flat_btf::open_flat_btf;
use brdfc_formats::direction_set::DirectionSet;
use brdfc_formats::pack::flat_btf::*;
fn main() {
    let out = std::path::Path::new("/tmp/o/render");
    let gpu = Gpu::open(&AdapterChoice::Best).unwrap();
    let args: Vec<String> = std::env::args().skip(1).collect();
    let scenes: Vec<&str> = args[1].split(',').collect();
    for name in args[0].split(',') {
        let t = std::time::Instant::now();
        let (model, appearance) = made::structure(&format!("{name}?resolution=128"), None);
        let folder = out.join("assets").join(name);
        if !folder.exists() {
            std::fs::create_dir_all(&folder).unwrap();
            let header = IndirectionHeader {
                size: 64,
                zenith_samples: 16,
                azimuth_samples: 16,
                largest_angle: std::f32::consts::FRAC_PI_2,
            };
            let parts = made::parts(&model, &appearance, 128, header, [&DirectionSet::ubo2003(); 2]);
            let write =
                |part: &str, bytes: Vec<u8>| std::fs::write(folder.join(format!("{name}.{part}.ktx2")), bytes).unwrap();
            write("reference", parts.reference.to_bytes(true));
            write("indirection", parts.indirection.to_bytes(true));
            write("normal", parts.normal.to_bytes(true));
            write("diffuse", parts.diffuse.to_bytes(true));
            for (k, v) in parts.views.iter().enumerate() {
                write(&view_part(k as u32, 81), v.to_bytes(false));
            }
            println!("{name} made {:?}", t.elapsed());
        }
        let parts = open_flat_btf(&folder, true).unwrap();
        println!("{name} read {:?}", t.elapsed());
        let repeat: u32 = args[2].parse().unwrap();
        let material = FlatMaterial::new(FlatBtfDecoder::new(parts).unwrap(), repeat).unwrap();
        let frame = Frame { width: 512, height: 512, samples: 2 };
        for scene_name in &scenes {
            let scene = Builtin::NAMES.iter().find(|(n, _)| n == scene_name).unwrap().1.scene();
            for form in [FlatForm::Full, FlatForm::Light] {
                let t = std::time::Instant::now();
                let image = draw(&gpu, &scene, frame, &material, form).unwrap();
                let e = auto_exposure(&image);
                std::fs::write(out.join(format!("{name}-{scene_name}-{form:?}.png")), to_png(&image, e)).unwrap();
                println!("{name} {scene_name} {form:?} {:?} exposure {e}", t.elapsed());
                if *scene_name == "plane" {
                    let reference = reference_plane(&scene, frame, &model, &appearance, repeat);
                    let d = compare_images(&image, &reference, auto_exposure(&reference));
                    println!("  against reference mean dE {}", d.delta_e.mean);
                    std::fs::write(out.join(format!("{name}-plane-reference.png")), to_png(&reference, e)).unwrap();
                }
            }
        }
    }
}
