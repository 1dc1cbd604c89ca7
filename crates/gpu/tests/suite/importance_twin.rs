//! The shader of importance samples, compared with the CPU look-up on any adapter.

use brdfc_formats::bindings::FrameBlock;
use brdfc_formats::importance::{IMPORTANCE_WGSL, ImportanceHeader, ImportancePack};
use brdfc_gpu::Gpu;
use brdfc_probe::Compute;
use brdfc_testing::packs::{Numbers, unit_vector};

const ENTRY: &str = "
fn compute(at: u32) {
    let outgoing = vec3<f32>(input[4u * at], input[4u * at + 1u], input[4u * at + 2u]);
    let drawn = importance_sample(outgoing, bitcast<u32>(input[4u * at + 3u]));
    output[4u * at] = drawn.incoming.x;
    output[4u * at + 1u] = drawn.incoming.y;
    output[4u * at + 2u] = drawn.incoming.z;
    output[4u * at + 3u] = drawn.inverse_density;
}
";

const HEADERS: [ImportanceHeader; 3] = [
    ImportanceHeader { polar: 64, azimuths: 1, samples: 50 },
    ImportanceHeader { polar: 7, azimuths: 12, samples: 64 },
    ImportanceHeader { polar: 32, azimuths: 16, samples: 33 },
];

/// A pack of random half vectors.
fn pack(header: ImportanceHeader, seed: u64) -> ImportancePack {
    let mut numbers = Numbers::new(seed);
    let texels = (0..header.rows() * header.samples)
        .map(|_| {
            let [x, y, z] = unit_vector(&mut numbers);
            [x, y, z.abs(), numbers.between(-6.0, 6.0).exp2() as f32]
        })
        .collect();
    ImportancePack::new(header, texels).unwrap()
}

/// Random directions, and directions on the axes and diagonals, at the pole, and below the horizon; indices beyond the
/// samples.
fn inputs(count: usize, seed: u64) -> Vec<f32> {
    let mut numbers = Numbers::new(seed);
    let fixed = [
        [0.0, 0.0, 1.0],
        [1e-20, -1e-20, 1.0],
        [0.6, 0.0, 0.8],
        [-0.6, 0.0, 0.8],
        [0.0, 0.6, 0.8],
        [0.0, -0.6, 0.8],
        [0.48, 0.48, 0.734_302_4],
        [-0.48, 0.48, 0.734_302_4],
        [-0.48, -0.48, 0.734_302_4],
        [0.48, -0.48, 0.734_302_4],
        [0.8, -1e-9, 0.6],
        [1.0, 0.0, 0.0],
        [0.8, 0.0, -0.6],
    ];
    let mut all = Vec::with_capacity(4 * count);
    for k in 0..count {
        let outgoing = if k < fixed.len() { fixed[k] } else { unit_vector(&mut numbers) };
        all.extend(outgoing);
        // The bits of small integers are subnormal floats, which a device may flush to zero; avoid them.
        all.push(f32::from_bits(0x0100_0000 + numbers.bits() % 0x100_0000));
    }
    all
}

/// Number of values whose bits differ: directions and inverse densities.
fn differences(gpu: &Gpu, source: &str, pack: &ImportancePack, inputs: &[f32]) -> [usize; 2] {
    let compute =
        Compute::new(gpu, &format!("{source}\n{ENTRY}"), &pack.bindings().all, FrameBlock::default()).unwrap();
    let found = compute.run(inputs, 4, 4).unwrap();
    let mut counts = [0; 2];
    for (words, found) in inputs.chunks_exact(4).zip(found.chunks_exact(4)) {
        let (incoming, inverse) = pack.sample([words[0], words[1], words[2]], words[3].to_bits());
        counts[0] += (0..3).filter(|k| incoming[*k].to_bits() != found[*k].to_bits()).count();
        counts[1] += usize::from(inverse.to_bits() != found[3].to_bits());
    }
    counts
}

#[test]
fn the_shader_gives_the_bits_of_the_cpu() {
    let Some(gpu) = crate::common::gpu() else { return };
    for (k, header) in HEADERS.into_iter().enumerate() {
        let (pack, inputs) = (pack(header, k as u64), inputs(20_000, 7 + k as u64));
        assert_eq!(differences(gpu, IMPORTANCE_WGSL, &pack, &inputs), [0; 2], "{header:?}");
        let drawn = |w: &[f32]| pack.sample([w[0], w[1], w[2]], w[3].to_bits()).1 > 0.0;
        let used = inputs.chunks_exact(4).filter(|words| drawn(words)).count();
        assert!((2000..19_000).contains(&used), "{used} above the horizon");
    }
}

/// Lines of the shader and small changes of them, each of which must be detected.
const CHANGES: [(&str, &str); 21] = [
    ("index % importance_parameters.samples", "min(index, importance_parameters.samples - 1u)"),
    ("importance_row(outgoing));", "0u);"),
    ("half_vector = importance_turned(texel.xyz, outgoing)", "half_vector = texel.xyz"),
    (
        "outgoing.x * half_vector.x + outgoing.y * half_vector.y",
        "outgoing.x * half_vector.x - outgoing.y * half_vector.y",
    ),
    ("2.0 * projection * half_vector - outgoing", "projection * half_vector - outgoing"),
    ("incoming.z <= 0.0", "incoming.z <= -2.0"),
    ("outgoing.z <= 0.0", "outgoing.z <= -2.0"),
    ("4.0 * projection / texel.w", "1.0 / texel.w"),
    ("outgoing.x * outgoing.x + outgoing.y * outgoing.y", "abs(outgoing.x) + abs(outgoing.y)"),
    ("let cosine = outgoing.x / length", "let cosine = outgoing.y / length"),
    ("let sine = outgoing.y / length", "let sine = -outgoing.y / length"),
    ("cosine * half_vector.x - sine * half_vector.y", "cosine * half_vector.x + sine * half_vector.y"),
    ("sine * half_vector.x + cosine * half_vector.y", "sine * half_vector.x - cosine * half_vector.y"),
    ("sqrt(max(1.0 - outgoing.z, 0.0))", "max(1.0 - outgoing.z, 0.0)"),
    ("importance_parameters.polar - 1u", "importance_parameters.polar - 2u"),
    ("abs(outgoing.x) + abs(outgoing.y);", "sqrt(outgoing.x * outgoing.x + outgoing.y * outgoing.y);"),
    ("turn = abs(outgoing.y) / length", "turn = abs(outgoing.x) / length"),
    ("turn = 2.0 - turn", "turn = 1.0 + turn"),
    ("turn = 4.0 - turn", "turn = 2.0 + turn"),
    ("0.25 * turn", "0.26 * turn"),
    ("polar * importance_parameters.azimuths + azimuth", "azimuth * importance_parameters.polar + polar"),
];

/// The negative control: every change above is detected.
#[test]
fn a_changed_line_is_detected() {
    let Some(gpu) = crate::common::gpu() else { return };
    let packs: Vec<_> = HEADERS.into_iter().map(|header| pack(header, 3)).collect();
    let inputs = inputs(3000, 4);
    for (from, to) in CHANGES {
        assert_eq!(IMPORTANCE_WGSL.matches(from).count(), 1, "{from}");
        let changed = IMPORTANCE_WGSL.replace(from, to);
        let noticed = packs.iter().any(|pack| differences(gpu, &changed, pack, &inputs) != [0; 2]);
        assert!(noticed, "{from} -> {to}");
    }
}
