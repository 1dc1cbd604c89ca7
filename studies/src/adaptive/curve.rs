//! Error against cost: what a renderer gives for what it is allowed to spend.

/// One rendering of a renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// What the renderer was asked to spend: samples per pixel, or [`brdfc_render::adaptive::Settings::samples`].
    pub asked: f64,
    /// Samples per pixel that shows a surface.
    pub samples: f64,
    /// dB.
    pub psnr: f64,
    /// Time to shade.
    pub seconds: f64,
}

/// What a renderer needs for a PSNR, between two of its renderings: logarithms of cost are interpolated. `None` if none of
/// the renderings is as good, or all of them are better.
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
