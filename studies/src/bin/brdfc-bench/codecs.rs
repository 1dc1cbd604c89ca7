//! The study of codecs: zfp and SZ3 run in Python, everything else here.

use super::arguments::Arguments;
use super::on_adapter::{VELVET, adapter, opened_adapter};
use brdfc_source::open::open;
use brdfc_studies::StudyResult;
use brdfc_studies::codecs::{
    CodecMaterial, CodecRow, CodecStudy, CodecStudyError, Compress, Compressed, DenseTable, codec_study, drawing,
};
use brdfc_terminal::output::{make_folder, remark, write_file};
use brdfc_terminal::table::{bytes, percent, plain};
use brdfc_terminal::{Common, Error};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Runs zfp and SZ3.
const SCRIPT: &str = include_str!("../../../../tests/peers/compress.py");
/// Maximum differences of logarithms allowed to zfp and SZ3.
const TOLERANCES: [f64; 9] = [0.8, 0.4, 0.2, 0.1, 0.05, 0.025, 0.0125, 0.006, 0.003];
const LEFT_OUT: &str = "--peers PYTHON with the packages of tests/peers/requirements.txt is missing";

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
    let started = Instant::now();
    let mut materials = Vec::new();
    for (number, input) in inputs.iter().enumerate() {
        let opened = open(input, None)?;
        let name = input.short_name();
        materials.push(codec_study(&gpu, &name, opened.source.as_ref(), compress).map_err(error)?);
        let seconds = started.elapsed().as_secs_f64();
        let left = seconds / (number + 1) as f64 * (inputs.len() - number - 1) as f64;
        remark(common, &format!("{} of {}: {name}, {seconds:.1} s, about {left:.0} s left", number + 1, inputs.len()));
    }
    let peers_left_out = compress.is_none().then(|| LEFT_OUT.to_owned());
    let study = CodecStudy { adapter: gpu.description().clone(), peers_left_out, materials };
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

/// Returns an error if Python lacks the packages of the script, before anything is measured.
fn check(python: &Path) -> Result<(), String> {
    let name = python.display();
    let ran = Command::new(python).args(["-c", "import numpy, pysz, zfpy"]).output();
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
    if let Some(why) = &study.peers_left_out {
        text += &format!("zfp and SZ3 are left out: {why}.\n");
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
