// Statistics of renderings that were read back.

/**
 * The percentile at `share`, 0 to 1; 0 if there are no values.
 *
 * @param {Float32Array} values sorted in place
 */
function percentile(values, share) {
    values.sort();
    return values.length > 0 ? values[Math.round((values.length - 1) * share)] : 0;
}

/** Collects one finite number of each pixel whose alpha is above 0. */
function counted(pixels, number) {
    const found = new Float32Array(pixels.length / 4);
    let count = 0;
    for (let k = 0; k < pixels.length; k += 4) {
        const value = pixels[k + 3] > 0 ? number(pixels, k) : NaN;
        if (Number.isFinite(value)) {
            found[count] = value;
            count += 1;
        }
    }
    return found.subarray(0, count);
}

/** Exposure that maps the 99th percentile of luminance over surfaces to 1. `pixels`: red, green, blue, coverage. */
export function autoExposure(pixels) {
    const luminance = (rgba, k) => 0.2126 * rgba[k] + 0.7152 * rgba[k + 1] + 0.0722 * rgba[k + 2];
    const bright = percentile(counted(pixels, luminance), 0.99);
    return bright > 0 ? 1 / bright : 1;
}

/** Mean and 95th percentile of ΔE. `pixels`: ΔE, two unused channels, and 1 where ΔE is valid. */
export function differences(pixels) {
    const found = counted(pixels, (rgba, k) => rgba[k]);
    const sum = found.reduce((sum, e) => sum + e, 0);
    return { pixels: found.length, mean: sum / Math.max(found.length, 1), p95: percentile(found, 0.95) };
}
