//! The study of codecs: zfp and SZ3 run in Python, which also reads networks; everything else runs here.

use super::arguments::Arguments;
use super::on_adapter::{VELVET, adapter, opened_adapter};
use brdfc_source::Input;
use brdfc_source::open::open;
use brdfc_studies::StudyResult;
use brdfc_studies::codecs::{
    CodecMaterial, CodecRow, CodecStudy, CodecStudyError, Compress, Compressed, DenseTable, NETWORK_WEIGHTS,
    NeuralBrdf, Peers, codec_study, drawing,
};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Runs zfp and SZ3.
const SCRIPT: &str = include_str!("../../../../tests/peers/compress.py");
/// Reads the weights of a network.
const NETWORK_SCRIPT: &str = include_str!("../../../../tests/peers/weights.py");
/// Maximum differences of logarithms allowed to zfp and SZ3.
const TOLERANCES: [f64; 9] = [0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125, 0.006, 0.003];
const WITHOUT_PEERS: &str = "zfp and SZ3 need --peers PYTHON with the packages of tests/peers/requirements.txt";
const WITHOUT_NETWORKS: &str = "Neural BRDFs need --networks DIR and --peers PYTHON";

pub(super) fn run(arguments: &Arguments, common: Common) -> Result<StudyResult, Error> {
    let gpu = opened_adapter(arguments)?;
    let velvet = [VELVET.into()];
    let inputs = if arguments.inputs.is_empty() { &velvet[..] } else { &arguments.inputs };
    if let Some(folder) = &arguments.out {
        make_folder(folder)?;
    }
    if let Some(python) = &arguments.peers {
        check(python).map_err(Error::usage)?;
    }
    let with_python = arguments.peers.as_ref().map(|python| move |table: &DenseTable| compress(python, table));
    let compress = with_python.as_ref().map(|compress| compress as &Compress<'_>);
    // Read all networks before the work, so that a missing one is reported immediately.
    let networks = networks(arguments, inputs)?;
    let started = Instant::now();
    let mut materials = Vec::new();
    for (number, (input, network)) in inputs.iter().zip(networks).enumerate() {
        let opened = open(input, None)?;
        let name = input.short_name();
        let peers = Peers { compress, network };
        materials.push(codec_study(&gpu, &name, opened.source.as_ref(), &peers).map_err(error)?);
        let seconds = started.elapsed().as_secs_f64();
        let left = seconds / (number + 1) as f64 * (inputs.len() - number - 1) as f64;
        remark(common, &format!("{} of {}: {name}, {seconds:.1} s, about {left:.0} s left", number + 1, inputs.len()));
    }
    let missing = [(arguments.peers.is_none(), WITHOUT_PEERS), (arguments.networks.is_none(), WITHOUT_NETWORKS)];
    let mut left_out: Vec<_> =
        missing.into_iter().filter(|(is_missing, _)| *is_missing).map(|(_, why)| why.to_owned()).collect();
    if let Some(folder) = &arguments.networks {
        let without = inputs.iter().map(network_name).filter(|name| !folder.join(name).is_file());
        left_out.extend(without.map(|name| format!("no network {name} in {}", folder.display())));
    }
    let study = CodecStudy { adapter: gpu.description().clone(), left_out, materials };
    if let Some(folder) = &arguments.out {
        let drawn = drawing(&study).map_err(Error::internal)?;
        write_file(&folder.join("codecs.svg"), drawn.as_bytes())?;
    }
    Ok(StudyResult::Codecs(study))
}

fn error(error: CodecStudyError) -> Error {
    match error {
        CodecStudyError::Gpu(error) => error.into(),
        CodecStudyError::Pack(error) => error.into(),
        CodecStudyError::Peer(text) => Error::input(text),
    }
}

/// The network of each input that has one in the folder of networks.
fn networks(arguments: &Arguments, inputs: &[Input]) -> Result<Vec<Option<NeuralBrdf>>, Error> {
    let Some(folder) = &arguments.networks else {
        return Ok(inputs.iter().map(|_| None).collect());
    };
    let python = arguments.peers.as_ref().ok_or_else(|| Error::usage("--networks needs --peers, which reads them"))?;
    let files = inputs.iter().map(|input| Some(folder.join(network_name(input))).filter(|file| file.is_file()));
    let read = |file: Option<PathBuf>| file.map(|file| network(python, &file)).transpose().map_err(Error::input);
    let networks = files.map(read).collect::<Result<Vec<_>, _>>()?;
    if networks.iter().all(Option::is_none) {
        let name = inputs.first().map(network_name).unwrap_or_default();
        return Err(Error::input(format!(
            "--networks {}: no network of any material, such as {name}",
            folder.display()
        )));
    }
    Ok(networks)
}

/// Name of the file with the network of a material.
fn network_name(input: &Input) -> String {
    let stem = input.path().and_then(Path::file_stem).map(|stem| stem.to_string_lossy().into_owned());
    format!("{}.h5", stem.unwrap_or_else(|| input.to_string()))
}

/// Reads a network.
fn network(python: &Path, file: &Path) -> Result<NeuralBrdf, String> {
    let wrong = |text: String| format!("{}: {text}", file.display());
    let ran = Command::new(python).args(["-c", NETWORK_SCRIPT]).arg(file).output();
    let ran = ran.map_err(|error| format!("--peers {}: {error}", python.display()))?;
    if !ran.status.success() {
        return Err(wrong(last_line(&ran.stderr)));
    }
    let weights: Vec<f32> = ran.stdout.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let count = weights.len();
    NeuralBrdf::new(&weights)
        .ok_or_else(|| wrong(format!("found {count} weights, expected {NETWORK_WEIGHTS} finite numbers")))
}

/// Returns an error if Python lacks the packages of the scripts, before anything is measured.
fn check(python: &Path) -> Result<(), String> {
    let name = python.display();
    let ran = Command::new(python).args(["-c", "import h5py, numpy, pysz, zfpy"]).output();
    let ran = ran.map_err(|error| format!("--peers {name}: {error}"))?;
    if ran.status.success() {
        return Ok(());
    }
    let allowed = "expected a Python with the packages of tests/peers/requirements.txt";
    Err(format!("--peers {name}: found {}, {allowed}", last_line(&ran.stderr)))
}

/// The last line that a program printed.
fn last_line(text: &[u8]) -> String {
    let text = String::from_utf8_lossy(text);
    text.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("a failure without a message").to_owned()
}

/// Runs the script once, in a folder of its own.
fn compress(python: &Path, table: &DenseTable) -> Result<Vec<Compressed>, String> {
    let wrong = |text: String| format!("--peers {}: {text}", python.display());
    let folder = tempfile::tempdir().map_err(|error| wrong(error.to_string()))?;
    let path = |name: &str| folder.path().join(name);
    let numbers: Vec<u8> = table.channels.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
    for (name, contents) in [("compress.py", SCRIPT.as_bytes()), ("table.f32", &numbers[..])] {
        std::fs::write(path(name), contents).map_err(|error| wrong(error.to_string()))?;
    }
    let texts = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>();
    let ran = Command::new(python)
        .args([path("compress.py"), path("table.f32"), folder.path().to_owned()])
        .arg(table.channels.len().to_string())
        .args(table.shape.iter().map(usize::to_string))
        .arg("--")
        .args(texts(&TOLERANCES))
        .output()
        .map_err(|error| wrong(error.to_string()))?;
    if !ran.status.success() {
        return Err(wrong(last_line(&ran.stderr)));
    }
    let length = table.shape.iter().product();
    let printed = String::from_utf8_lossy(&ran.stdout);
    let parsed = printed.lines().map(|line| parse(line, [table.channels.len(), length], folder.path()));
    parsed.collect::<Option<Vec<_>>>().ok_or_else(|| wrong(format!("found {printed:?}, expected lines of its script")))
}

/// Parses a line "codec tolerance bytes seconds file".
fn parse(line: &str, [count, length]: [usize; 2], folder: &Path) -> Option<Compressed> {
    let [codec, tolerance, bytes, seconds, file] = line.split(' ').collect::<Vec<_>>().try_into().ok()?;
    let numbers = std::fs::read(folder.join(file)).ok()?;
    let numbers: Vec<f32> = numbers.as_chunks::<4>().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
    let channels: Vec<Vec<f32>> = numbers.chunks(length).map(<[f32]>::to_vec).collect();
    let whole = channels.len() == count && channels.iter().all(|channel| channel.len() == length);
    if !whole {
        return None;
    }
    let (tolerance, bytes, seconds) = (tolerance.parse().ok()?, bytes.parse().ok()?, seconds.parse().ok()?);
    Some(Compressed { codec: codec.to_owned(), tolerance, bytes, seconds, channels })
}

pub(super) fn text(study: &CodecStudy) -> String {
    let mut text: String = study.materials.iter().map(material_text).collect();
    let header = ["material", "codec", "ΔE", "on GPU", "on disk", "zfp", "zfp, nodes", "SZ3", "SZ3, nodes", "GGX ΔE"];
    let rows: Vec<Vec<String>> = study.materials.iter().filter_map(comparison).collect();
    text += &plain(&header, &rows);
    text += &format!(
        "\nThe table or factored pack of 16 KiB with the smaller ΔE; compressed bytes of zfp and SZ3 with the same ΔE, for \
         a dense table and for the nodes of a pack; the ΔE of a fitted GGX.\nMillions of evaluations per second: one CPU thread, and the shader on {}.\n\
         A GPU cannot sample zfp and SZ3; on GPU: decompressed to halves.\n",
        adapter(&study.adapter)
    );
    let header = ["material", "network", "its ΔE", "95 %", "codec", "on GPU", "on disk", "ΔE", "95 %", "ratio"];
    let rows: Vec<Vec<String>> = study.materials.iter().filter_map(network_comparison).collect();
    if !rows.is_empty() {
        text += &format!(
            "\n{}\nThe network of each material, and the closer of the packs with at most half of its bytes on a GPU; ratio: \
             their mean ΔE.\n",
            plain(&header, &rows)
        );
    }
    for why in &study.left_out {
        text += &format!("Not measured: {why}.\n");
    }
    text
}

fn material_text(material: &CodecMaterial) -> String {
    let header = [
        &material.material,
        "size",
        "sampled",
        "on GPU",
        "on disk",
        "fetches",
        "encode",
        "CPU",
        "shader",
        "ε_r",
        "ΔE",
        "95 %",
    ];
    let mega = |rate: Option<f64>| rate.map_or("-".to_owned(), |rate| format!("{:.2}", rate / 1e6));
    // Only the front of zfp and SZ3; the JSON has all rows.
    let worth = |row: &&CodecRow| {
        let alike = |other: &CodecRow| other.codec == row.codec && other.dense == row.dense;
        let smaller = |other: &CodecRow| alike(other) && other.bytes_on_disk < row.bytes_on_disk;
        row.sampled || !material.rows.iter().any(|other| smaller(other) && other.delta_e <= row.delta_e)
    };
    let rows: Vec<Vec<String>> = material
        .rows
        .iter()
        .filter(worth)
        .map(|row| {
            vec![
                row.codec.clone(),
                row.setting.clone(),
                if row.sampled { "yes" } else { "no" }.to_owned(),
                bytes(row.bytes_on_gpu),
                bytes(row.bytes_on_disk),
                row.fetches.map_or("-".to_owned(), |fetches| fetches.to_string()),
                format!("{:.2} s", row.encode_seconds),
                mega(row.cpu),
                mega(row.shader),
                percent(row.relative_error),
                format!("{:.2}", row.delta_e),
                format!("{:.2}", row.delta_e_p95),
            ]
        })
        .collect();
    plain(&header, &rows) + "\n"
}

/// Comparison of the better pack of 16 KiB with the others.
fn comparison(material: &CodecMaterial) -> Option<Vec<String>> {
    let of_16_kib = |row: &&CodecRow| {
        matches!(row.codec.as_str(), "table" | "factored") && (12 << 10..=16 << 10).contains(&row.bytes_on_gpu)
    };
    let pack = material.rows.iter().filter(of_16_kib).min_by(|a, b| a.delta_e.total_cmp(&b.delta_e))?;
    let at = |codec: &str, dense: bool| {
        material.bytes_at(codec, dense, pack.delta_e).map_or("-".to_owned(), |found| bytes(found.round() as u64))
    };
    let ggx = material.rows.iter().find(|row| row.codec == "ggx")?;
    Some(vec![
        material.material.clone(),
        pack.codec.clone(),
        format!("{:.2}", pack.delta_e),
        bytes(pack.bytes_on_gpu),
        bytes(pack.bytes_on_disk),
        at("zfp", true),
        at("zfp", false),
        at("sz3", true),
        at("sz3", false),
        format!("{:.2}", ggx.delta_e),
    ])
}

/// Comparison of a network with the closest pack of half its bytes.
fn network_comparison(material: &CodecMaterial) -> Option<Vec<String>> {
    let network = material.rows.iter().find(|row| row.codec == "neural")?;
    let is_half = |row: &&CodecRow| {
        matches!(row.codec.as_str(), "table" | "factored") && 2 * row.bytes_on_gpu <= network.bytes_on_gpu
    };
    let pack = material.rows.iter().filter(is_half).min_by(|a, b| a.delta_e.total_cmp(&b.delta_e))?;
    Some(vec![
        material.material.clone(),
        bytes(network.bytes_on_gpu),
        format!("{:.2}", network.delta_e),
        format!("{:.2}", network.delta_e_p95),
        pack.codec.clone(),
        bytes(pack.bytes_on_gpu),
        bytes(pack.bytes_on_disk),
        format!("{:.2}", pack.delta_e),
        format!("{:.2}", pack.delta_e_p95),
        format!("{:.2}", pack.delta_e / network.delta_e),
    ])
}
