// Decodes photographs of the page: JPEG files to sRGB levels with mipmaps, averaged in linear light.

const LINEAR = Float32Array.from({ length: 256 }, (_, code) => {
    const c = code / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
});

const levelOf = (c) => Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));

/** Halves each side of linear RGBA, weighting pixels by the area of them that a new pixel covers. */
function halvedImage({ size, values }) {
    const next = size.map((side) => Math.max(side >> 1, 1));
    const taps = next.map((count, axis) => Array.from({ length: count }, (_, k) => {
        const [from, to] = [k, k + 1].map((edge) => (edge * size[axis]) / count);
        const range = Array.from({ length: Math.ceil(to) - Math.floor(from) }, (_, n) => Math.floor(from) + n);
        return range.map((at) => [at, (Math.min(at + 1, to) - Math.max(at, from)) / (to - from)]);
    }));
    const found = new Float32Array(4 * next[0] * next[1]);
    taps[1].forEach((rows, y) => taps[0].forEach((columns, x) => {
        const to = 4 * (y * next[0] + x);
        for (const [row, high] of rows) {
            for (const [column, wide] of columns) {
                const from = 4 * (row * size[0] + column);
                for (let k = 0; k < 3; k += 1) {
                    found[to + k] += high * wide * values[from + k];
                }
            }
        }
    }));
    return { size: next, values: found };
}

/**
 * Decodes a photograph.
 *
 * @param {{ data: string }} photograph a JPEG file as Base64
 */
export async function photographContents({ data }) {
    const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
    const bitmap = await createImageBitmap(new Blob([bytes], { type: 'image/jpeg' }));
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext('2d');
    context.drawImage(bitmap, 0, 0);
    bitmap.close();
    const levels = [new Uint8Array(context.getImageData(0, 0, width, height).data.buffer)];
    let image = { size: [width, height], values: Float32Array.from(levels[0], (code) => LINEAR[code]) };
    while (Math.max(...image.size) > 1) {
        image = halvedImage(image);
        levels.push(Uint8Array.from(image.values, levelOf));
    }
    return { kind: 'texture', texture: { format: 'rgba8unorm', dimension: '2d', size: [width, height, 1], texelBytes: 4, levels } };
}
