//! Arctangent for shaders. Each decoder has a copy under its own name, so that one module can contain several decoders.

/// WGSL of an `atan2` whose name starts with the function and constant prefixes of a decoder, appended to the decoder's
/// source. It computes the same as [`polynomial_atan2`](crate::direction::polynomial_atan2).
macro_rules! arc_tangent_wgsl {
    ($function:literal, $constants:literal) => {
        concat!(
            "
// atan2(y, x) for y >= 0, in [0, π], within 3e-7 of the exact angle: an odd minimax polynomial on [0, 1]. The
// built-in function of a GPU may be off by 1e-5 and more, which moves filter weights.
fn ",
            $function,
            "_atan2(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let steep = y > ax;
    let small = select(y, ax, steep);
    let large = select(ax, y, steep);
    let t = select(0.0, small / large, large > 0.0);
    let t2 = t * t;
    var p = -4.0545664e-3;
    p = p * t2 + 2.1862958e-2;
    p = p * t2 - 5.5912327e-2;
    p = p * t2 + 9.642198e-2;
    p = p * t2 - 0.1390863;
    p = p * t2 + 0.19946566;
    p = p * t2 - 0.3332986;
    p = p * t2 + 0.99999934;
    var angle = p * t;
    if steep {
        angle = ",
            $constants,
            "_HALF_PI - angle;
    }
    if x < 0.0 {
        angle = ",
            $constants,
            "_PI - angle;
    }
    return angle;
}
",
        )
    };
}

pub(crate) use arc_tangent_wgsl;
