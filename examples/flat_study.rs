use brdfc::report::study::flat_btf::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n = |k: usize, d: usize| a.get(k).map_or(d, |s| s.parse().unwrap());
    let settings = StudySettings {
        texels: n(2, 64),
        flat_texels: n(3, 128),
        oversampling: n(4, 1),
        rounds: n(5, 0),
        directions: "ubo2003".into(),
    };
    let directions = brdfc_formats::direction_set::DirectionSet::ubo2003().directions();
    for m in a[1].split(',') {
        let t = std::time::Instant::now();
        let r = study_model(m, &settings, &directions, &|| ()).unwrap();
        let c = r.coherency;
        println!(
            "{m} {:.1}s  rec mean {:.2} (pp {:.2}) img max {:.2} var {:.3} texel max {:.1} | var btf {:.2} pp {:.2} (/{:.2}) poisson {:.2} (/{:.2}) vis {:.2} (/{:.2}) | seen {:.3} stretch {:.3}->{:.3} share {:.3} tilt {:.2e}| png {:.0}<{:.0} zstd {:.0}<{:.0}",
            t.elapsed().as_secs_f64(),
            r.reconstruction.mean,
            r.reconstruction.mean_push_pull,
            r.reconstruction.largest_image,
            r.reconstruction.image_variance,
            r.reconstruction.largest_texel,
            c.btf.mean,
            c.push_pull.mean,
            c.btf.mean / c.push_pull.mean,
            c.poisson.mean,
            c.btf.mean / c.poisson.mean,
            c.visible.mean,
            c.btf.mean / c.visible.mean,
            r.seen,
            r.parameterisation.before.l2,
            r.parameterisation.after.l2,
            r.parameterisation.after.smallest_share,
            r.parameterisation.tilt,
            r.apparent.mean.flat_png,
            r.apparent.mean.btf_png,
            r.apparent.mean.flat_zstd,
            r.apparent.mean.btf_zstd
        );
    }
}
