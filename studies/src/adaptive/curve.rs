//! Error as a function of cost of a renderer.

/// One rendering of a renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Requested cost: samples per pixel, or [`brdfc_render::adaptive::Settings::samples`].
    pub asked: f64,
    /// Samples per surface pixel.
    pub samples: f64,
    /// PSNR, dB.
    pub psnr: f64,
    /// Time to shade.
    pub seconds: f64,
}

/// Cost of a renderer for a PSNR, interpolated between two of its renderings by the logarithm of cost. `None` if no
/// rendering reaches the PSNR, or if all exceed it.
pub fn needed(curve: &[Point], psnr: f64) -> Option<Point> {
    let [a, b] = curve.windows(2).map(|pair| [pair[0], pair[1]]).find(|[a, b]| a.psnr <= psnr && psnr <= b.psnr)?;
    let t = if b.psnr > a.psnr { (psnr - a.psnr) / (b.psnr - a.psnr) } else { 0.0 };
    let between = |x: f64, y: f64| (x.ln() + t * (y / x).ln()).exp();
    Some(Point {
        asked: between(a.asked, b.asked),
        samples: between(a.samples, b.samples),
        psnr,
        seconds: between(a.seconds, b.seconds),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_are_interpolated() {
        let point = |n: f64| Point { asked: n, samples: 2.0 * n, psnr: 10.0 * n.log10(), seconds: 0.1 * n };
        let curve: Vec<Point> = [1.0, 10.0, 100.0].map(point).to_vec();
        let found = needed(&curve, 15.0).unwrap();
        assert!((found.samples / (2.0 * 10f64.powf(1.5)) - 1.0).abs() < 1e-12);
        assert!((found.seconds / found.asked - 0.1).abs() < 1e-12);
        assert_eq!(needed(&curve, 20.5), None);
        assert_eq!(needed(&curve, -0.5), None);
    }
}
