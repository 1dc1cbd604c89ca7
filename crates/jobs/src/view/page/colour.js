// Differences of colours, as 'brdfc' measures them.

/** CIE L*a*b* (D65) of linear RGB, clipped to 0 to 1; the twin is `lab` of the crate `brdfc-metrics`. */
export function lab(colour) {
    const [r, g, b] = colour.map((c) => Math.min(Math.max(c, 0), 1));
    const x = 0.433953 * r + 0.3762194 * g + 0.1898276 * b;
    const y = 0.2126729 * r + 0.7151522 * g + 0.072175 * b;
    const z = 0.0177566 * r + 0.10946796 * g + 0.8727754 * b;
    const [fx, fy, fz] = [x, y, z].map((t) => (t > 0.008856452 ? Math.cbrt(t) : t * 7.787037 + 16 / 116));
    return [116 * fy - 16, 500 * (fx - fy), 200 * (fy - fz)];
}

/** ΔE (CIE76) of two pixels at an exposure. */
export function deltaE(a, b, exposure) {
    const [p, q] = [a, b].map((pixel) => lab(pixel.slice(0, 3).map((c) => c * exposure)));
    return Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
}

/**
 * The value that a share of the others are not above; 0 of none.
 *
 * @param {Float32Array} values which are sorted
 */
export function percentile(values, share) {
    values.sort();
    return values.length > 0 ? values[Math.round((values.length - 1) * share)] : 0;
}

/** The factor that takes the 99th percentile of luminance over surfaces to 1. `pixels`: red, green, blue, coverage. */
export function autoExposure(pixels) {
    const luminances = new Float32Array(pixels.length / 4);
    let count = 0;
    for (let k = 0; k < pixels.length; k += 4) {
        const y = 0.2126 * pixels[k] + 0.7152 * pixels[k + 1] + 0.0722 * pixels[k + 2];
        if (pixels[k + 3] > 0 && Number.isFinite(y)) {
            luminances[count] = y;
            count += 1;
        }
    }
    const bright = percentile(luminances.subarray(0, count), 0.99);
    return bright > 0 ? 1 / bright : 1;
}

/** Mean and 95th percentile of ΔE over the pixels that show a surface in either picture. */
export function differences(a, b, exposure) {
    const found = new Float32Array(a.length / 4);
    let [count, sum] = [0, 0];
    for (let k = 0; k < a.length; k += 4) {
        if (a[k + 3] > 0 || b[k + 3] > 0) {
            found[count] = deltaE([a[k], a[k + 1], a[k + 2]], [b[k], b[k + 1], b[k + 2]], exposure);
            sum += found[count];
            count += 1;
        }
    }
    return { pixels: count, mean: sum / Math.max(count, 1), p95: percentile(found.subarray(0, count), 0.95) };
}
