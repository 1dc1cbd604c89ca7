import { checkSize, type Container, storedWindow, versioned, view } from './container.js';
import type { Contents, Options } from './pack.js';
import { image, texture, widened } from './textures.js';
import { Words } from './words.js';

const FILTERS = ['nearest', 'slices', 'bilinear'] as const;

/** What a wavelet pack binds; its layout: formats/src/wavelet/spec.md. */
export function waveletResources(
    { texture: texels, entries }: Container,
    { wavelet, distanceScale }: Required<Options>,
): Map<number, Contents> {
    const header = versioned(entries, 'brdfc.wavelet');
    const word = (k: number) => header.getUint32(4 * k, true);
    const [parameterisation, levels, channels, slices, lifted] = [1, 2, 4, 6, 9].map(word);
    const grid = 2 ** levels;
    const { first, size } = storedWindow(entries, [grid, grid]);
    checkSize(texels, [...size, slices]);
    const scales = view(entries, 'brdfc.wavelet.scales');
    const scale = (slice: number) => [scales.getFloat32(8 * slice, true), scales.getFloat32(8 * slice + 4, true)] as const;
    const block = new Words(48)
        .uint(levels, parameterisation, FILTERS.indexOf(wavelet), channels)
        .float(header.getFloat32(28, true), header.getFloat32(32, true), ...scale(1), slices, distanceScale)
        .uint(lifted, first[0] + first[1] * 256 + size[0] * 65536 + size[1] * 16777216);
    const indices = view(entries, 'brdfc.wavelet.index');
    const index = new Float32Array(4 * grid * grid);
    for (let k = 0; k < grid * grid; k += 1) {
        const slice = indices.getUint16(2 * k, true);
        index.set([slice, ...scale(slice), lifted ? lowerShare(k) : 0], 4 * k);
    }
    return new Map<number, Contents>([
        [0, { kind: 'uniform', bytes: block.done() }],
        [1, texture(widened(texels), true)],
        [2, texture(image('rgba32float', 16, [grid, grid], new Uint8Array(index.buffer)), false)],
        [3, { kind: 'sampler', repeats: false }],
    ]);
}

/** Of lifted packs: what the lower half of a coefficient's pair counts of both. */
function lowerShare(coefficient: number): number {
    if (coefficient === 0) {
        return 0;
    }
    const j = Math.floor(Math.log2(coefficient) / 2);
    const side = 2 ** j;
    const width = Math.PI / side;
    if (coefficient < 2 * side * side) {
        const middle = (Math.floor(coefficient / side) - side + 0.5) * width;
        const half = 0.5 * width;
        return 0.5 - (0.5 * Math.sin(2 * middle) * Math.sin(half) ** 2) / (half - 0.5 * Math.cos(2 * middle) * Math.sin(2 * half));
    }
    const middle = ((coefficient % side) + 0.5) * width;
    return 0.5 - (0.5 * Math.tan(0.25 * width)) / Math.tan(middle);
}
