//! Files of viewers for reflectance transformation imaging that we read and do not write.

use std::fmt::Write;

/// An `.rti` file of hemispherical harmonics. Each of `scale` and `bias` has one number per term; `bytes` has the terms
/// of red, green and blue of each pixel, row by row from the top.
pub fn rti(size: [u32; 2], scale: &[f32], bias: &[f32], bytes: &[u8]) -> Vec<u8> {
    let header = format!("#HSH1.2\r\n3\r\n{} {} 3\r\n{} 2 1\r\n", size[0], size[1], scale.len());
    let numbers = scale.iter().chain(bias).flat_map(|number| number.to_le_bytes());
    header.bytes().chain(numbers).chain(bytes.iter().copied()).collect()
}

/// A compressed `.ptm` file: its format, scales, biases, and the grey JPEGs of its planes, whose rows run from the
/// bottom. The last plane is a difference from the first one.
pub fn compressed_ptm(format: &str, size: [u32; 2], scale: [f32; 6], bias: [i32; 6], jpegs: &[Vec<u8>]) -> Vec<u8> {
    let mut header = format!("PTM_1.2\n{format}\n{}\n{}\n", size[0], size[1]);
    let mut line = |numbers: Vec<String>| writeln!(header, "{}", numbers.join(" ")).unwrap();
    line(scale.map(|number| number.to_string()).to_vec());
    line(bias.map(|number| number.to_string()).to_vec());
    line(vec!["90".to_owned()]);
    let count = jpegs.len();
    let words = |of: &dyn Fn(usize) -> i64| (0..count).map(|plane| of(plane).to_string()).collect();
    let last = |plane: usize| plane + 1 == count;
    for of in [
        &|_| 0,
        &|_| 0,
        &|_| 0,
        &|plane| plane as i64,
        &|plane| if last(plane) { 0 } else { -1 },
        &|plane| jpegs[plane].len() as i64,
        &|_| 0,
    ] as [&dyn Fn(usize) -> i64; 7]
    {
        line(words(of));
    }
    [header.into_bytes(), jpegs.concat()].concat()
}
