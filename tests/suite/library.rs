//! The library, as programs use it.

use brdfc::{Budget, Build, Cancelled, EncodeOptions, ErrorKind, Progress, Reading, Stage};
use brdfc_testing::program::Folder;
use std::sync::Mutex;

const MODEL: &str = "synth:ggx?alpha=0.3";

fn folder() -> Folder {
    Folder::of(env!("CARGO_BIN_EXE_brdfc"))
}

#[test]
fn a_pack_is_that_of_the_program() {
    let folder = folder();
    folder.run(&["encode", MODEL, "-o", "theirs.ktx2", "--max-delta-e", "1", "--max-bytes", "16KiB"]).succeeded();
    let pack = brdfc::open(MODEL).unwrap().encode(Budget::NONE.delta_e(1.0).bytes(16 << 10)).unwrap();
    assert!(pack.errors().delta_e <= 1.0 && pack.errors().delta_e_p95 <= 4.0 && pack.errors().relative > 0.0);
    assert!(pack.gpu_bytes() <= 16 << 10 && pack.fetches() == 1 && pack.missed().is_none());
    let ours = folder.path().join("ours.ktx2");
    pack.write(&ours).unwrap();
    let theirs = std::fs::read(folder.path().join("theirs.ktx2")).unwrap();
    assert!(std::fs::read(&ours).unwrap() == theirs && pack.bytes() == theirs);
}

#[test]
fn errors_have_the_kinds_of_exit_codes() {
    let model = brdfc::open(MODEL).unwrap();
    let narrow = Budget::NONE.delta_e(1e-4).bytes(1024);
    let kind = |result: Result<_, brdfc::Error>| result.map(drop).unwrap_err().kind();
    assert_eq!(kind(model.encode(narrow)), ErrorKind::Check);
    let closest = model.encode_closest(narrow, &()).unwrap();
    assert!(closest.missed().is_some() && closest.errors().delta_e > 1e-4 && closest.gpu_bytes() <= 1024);
    assert_eq!(kind(model.encode(Budget::NONE.delta_e(1000.0))), ErrorKind::Usage);
    assert_eq!(kind(model.encode(Budget::NONE.error(-1.0))), ErrorKind::Usage);
    let codec = EncodeOptions { codec: Some("jpeg".to_owned()), ..EncodeOptions::default() };
    let error = model.encode(codec).unwrap_err();
    assert!(error.kind() == ErrorKind::Usage && error.message().contains("jpeg"), "{error}");
    let kind = |input: &str| brdfc::open(input).map(drop).unwrap_err().kind();
    assert_eq!(kind("/nonexistent.brdf"), ErrorKind::Io);
    assert_eq!(kind("synth:ggx?alpha=-1"), ErrorKind::Input);
    let codes = [ErrorKind::Check, ErrorKind::Usage, ErrorKind::Input, ErrorKind::Io, ErrorKind::NoAdapter];
    assert_eq!(codes.map(ErrorKind::exit_code), [1, 2, 3, 4, 5]);
}

const SCENE: &str = "\
[materials.plastic]
source = 'synth:ggx?alpha=0.3'
max_bytes = 4096
require = { max_delta_e = DELTA_E }

[materials.unused]
source = 'nowhere.binary'

[[uses]]
material = 'plastic'
";

#[test]
fn a_scene_is_built_and_fails_on_what_is_required() {
    let folder = folder();
    let (manifest, pack) = (folder.path().join("scene.toml"), folder.path().join("packs/plastic.brdf.ktx2"));
    let build = |delta_e: &str| {
        std::fs::write(&manifest, SCENE.replace("DELTA_E", delta_e)).unwrap();
        Build::from_manifest(&manifest).unwrap().out(folder.path().join("packs"))
    };
    let good = build("5");
    assert_eq!(good.files().unwrap(), [manifest.as_path()]);
    assert_eq!(good.run().unwrap().materials.len(), 1);
    assert!(pack.exists());
    let error = build("0.0001").run().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Check);
    let text = error.message();
    assert!(text.starts_with("1 material does not meet") && text.contains("\nplastic: require.max_delta_e"), "{text}");
    let error = Build::from_materials(["synth:nothing"]).unwrap().run().unwrap_err();
    assert_eq!(error.kind(), ErrorKind::Input, "{error}");
    assert_eq!(Build::from_manifest(folder.path().join("no.toml")).unwrap_err().kind(), ErrorKind::Io);
}

#[test]
fn materials_are_built_cached_and_reused_from_elsewhere() {
    let folder = folder();
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("scans")).unwrap();
    for (name, model) in [("a", "lambert?kd=0.5"), ("b", "ggx?alpha=0.4")] {
        folder.run(&["synth", model, "-o", &format!("scans/{name}.brdf")]).succeeded();
    }
    let options = EncodeOptions { max_bytes: Some(1024), ..EncodeOptions::default() };
    let build = |out: &str| Build::from_materials([at("scans")]).unwrap().options(options.clone()).out(at(out));
    let first = build("first");
    // A new file in the folder would be a material.
    assert_eq!(first.files().unwrap(), [at("scans/a.brdf"), at("scans/b.brdf"), at("scans")]);
    let made = |report: brdfc::BuildReport| report.materials.iter().map(|entry| entry.cached).collect::<Vec<_>>();
    assert_eq!(made(first.run().unwrap()), [Some(false); 2]);
    assert_eq!(made(first.run().unwrap()), [Some(true); 2]);
    assert_eq!(made(first.clone().cache(false).run().unwrap()), [Some(false); 2]);
    assert_eq!(made(build("second").reuse([at("first")]).run().unwrap()), [Some(true); 2]);
    let packs = ["first", "second"].map(|out| std::fs::read(at(out).join("b.brdf.ktx2")).unwrap());
    assert!(packs[0] == packs[1]);
    // A build neither replaces nor removes its inputs.
    let error = Build::from_materials([at("first/b.brdf.ktx2")]).unwrap().out(at("first")).run().unwrap_err();
    assert!(error.kind() == ErrorKind::Usage && error.message().contains("would remove this input"), "{error}");
    assert!(std::fs::read(at("first/b.brdf.ktx2")).unwrap() == packs[0], "{error}");
    // A build that is cancelled in a stage changes nothing, even if 'check' succeeds afterwards.
    let before = std::fs::read(at("first/report.json")).unwrap();
    let again = build("first").cache(false);
    let stopped = again.run_with(&again.plan().unwrap(), &InStage).unwrap_err();
    assert_eq!(stopped.kind(), ErrorKind::Cancelled);
    assert!(at("first/a.brdf.ktx2").exists() && std::fs::read(at("first/report.json")).unwrap() == before);
}

/// Cancels at the start of each stage, and only there.
struct InStage;

impl Progress for InStage {
    fn stage(&self, _: Stage, _: usize) -> Result<(), Cancelled> {
        Err(Cancelled)
    }

    fn part<'a>(&'a self, _: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(self)
    }
}

/// Records stages, and cancels at one.
struct Recorder(Mutex<Vec<Stage>>, Option<Stage>);

impl Progress for Recorder {
    fn check(&self) -> Result<(), Cancelled> {
        let stops = self.1.is_some() && self.0.lock().unwrap().last() == self.1.as_ref();
        if stops { Err(Cancelled) } else { Ok(()) }
    }

    fn stage(&self, stage: Stage, _: usize) -> Result<(), Cancelled> {
        self.0.lock().unwrap().push(stage);
        self.check()
    }

    fn part<'a>(&'a self, _name: &'a str) -> Box<dyn Progress + 'a> {
        Box::new(self)
    }
}

#[test]
fn long_work_is_observed_and_cancelled() {
    let model = brdfc::open(MODEL).unwrap();
    let all = Recorder(Mutex::default(), None);
    model.encode_closest(Budget::default(), &all).unwrap();
    let last = *all.0.lock().unwrap().last().unwrap();
    let stopped = Recorder(Mutex::default(), Some(last));
    assert_eq!(model.encode_closest(Budget::default(), &stopped).unwrap_err().kind(), ErrorKind::Cancelled);
}

#[test]
fn modules_make_the_files_of_the_verbs() {
    use brdfc::bandwidth::{DEFAULT_EPSILON, Kind, Resolution, Subject};
    use brdfc::samples::{HalfGrid, ImportanceRecipe, draw};
    use brdfc::synth::{ScanPlan, Target, file};

    let folder = folder();
    let written = |name: &str, arguments: &[&str]| {
        folder.run(&[arguments, &["-o", name]].concat()).succeeded();
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let plan = ScanPlan { rows: 60, incidences: 8, azimuths: None, noise: 0.1, gaps: 0.0, duplicates: 0.0, seed: 1 };
    let theirs = written("scan.brdf", &["synth", MODEL, "--rows", "60", "--noise", "0.1"]);
    assert!(file(MODEL, Target::Scan(plan)).unwrap() == theirs);
    for wrong in
        [ScanPlan { incidences: 0, ..plan }, ScanPlan { gaps: 4.0, ..plan }, ScanPlan { duplicates: 2.0, ..plan }]
    {
        assert_eq!(file(MODEL, Target::Csv(wrong)).unwrap_err().kind(), ErrorKind::Usage, "{wrong:?}");
    }
    assert_eq!(file("synth:nothing", Target::Ply).unwrap_err().kind(), ErrorKind::Input);

    let theirs = written("map.ktx2", &["bandwidth", MODEL, "--resolution", "32"]);
    let kind = Kind::Material(Resolution::parse("32").unwrap(), Reading::default());
    let subject = Subject::open(&MODEL.into(), kind).unwrap();
    assert!(subject.map(DEFAULT_EPSILON).unwrap().0.to_bytes(true) == theirs);
    assert_eq!(subject.map(2.0).unwrap_err().kind(), ErrorKind::Usage);

    let sizes = ["--polar", "4", "--count", "16", "--rings", "16", "--cells", "16"];
    let theirs = written("samples.ktx2", &[&["samples", MODEL], &sizes[..]].concat());
    let grid = HalfGrid { polar: 16, azimuths: 16 };
    let recipe = ImportanceRecipe { isotropic_polar: 4, samples: 16, grid, ..ImportanceRecipe::default() };
    let model = brdfc::open(MODEL).unwrap();
    assert!(draw(&model, &recipe).unwrap().0.to_bytes(true) == theirs);
    let none = ImportanceRecipe { samples: 0, ..recipe };
    assert_eq!(draw(&model, &none).unwrap_err().kind(), ErrorKind::Usage);
}

#[test]
fn materials_are_compared_and_evaluated() {
    use brdfc::compare::{Pairs, reflectances};
    use brdfc::evaluate::{open_level, pairs_from_csv, values_at};
    use brdfc::inspect::Kind;

    let (a, b) = (brdfc::open(MODEL).unwrap(), brdfc::open("synth:ggx?alpha=0.32").unwrap());
    let of = |pairs| reflectances(&a, &b, pairs).unwrap();
    let random = of(Pairs::Random(1000));
    assert_eq!(random.pairs, 1000);
    assert!(random.comparison.norms.relative_mean > 0.0);
    assert_eq!(reflectances(&a, &a, Pairs::default()).unwrap().comparison.norms.relative_mean, 0.0);
    let list = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0,0,1\n0.6,0,0.8,0,0.6,0.8\n";
    let pairs = pairs_from_csv(&"list.csv".into(), list.as_bytes()).unwrap();
    let (values, repairs) = values_at(a.source(), &pairs);
    assert_eq!(repairs, brdfc::Tally { evaluations: 2, ..brdfc::Tally::default() });
    assert!(values[0][0] > values[1][0]);
    assert_eq!(of(Pairs::Given(pairs)).pairs, 2);
    for none in [Pairs::Given(Vec::new()), Pairs::Random(0)] {
        assert_eq!(reflectances(&a, &b, none).unwrap_err().kind(), ErrorKind::Check);
    }
    assert_eq!(open_level(MODEL, Some(1.0)).err().map(|error| error.kind()), Some(ErrorKind::Usage));
    let error = pairs_from_csv(&"list.csv".into(), b"wi_x\n1\n").unwrap_err();
    assert!(error.kind() == ErrorKind::Input && error.message().starts_with("list.csv: "), "{error}");
    assert_eq!(Kind::of(&MODEL.into()).unwrap(), Kind::Model);
}
