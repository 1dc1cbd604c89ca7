import { checkSize, type Container, storedWindow, versioned, view } from './container.js';
import type { Contents, Options } from './pack.js';
import { image, noTexture, texture } from './textures.js';
import { Words } from './words.js';

/** What a table pack binds; its layout: formats/src/table/spec.md. */
export function tableResources({ texture: texels, entries }: Container, { distanceScale }: Required<Options>): Map<number, Contents> {
    const header = versioned(entries, 'brdfc.table');
    const word = (k: number) => header.getUint32(4 * k, true);
    const number = (k: number) => header.getFloat32(4 * k, true);
    const [channels, symmetry, half, difference, azimuth, layers] = [1, 2, 3, 4, 5, 6].map(word);
    const { first, size } = storedWindow(entries, [half, difference]);
    // Folded slices do not start again.
    const slices = azimuth + (symmetry & 2 ? 0 : 1);
    checkSize(texels, [...size, layers * slices]);
    const axis = (nodes: number, k: number) => nodes + first[k] * 1024 + size[k] * 1048576;
    let curve: Contents = noTexture('2d');
    let curveWord = 0;
    if (entries.has('brdfc.table.curve')) {
        const value = view(entries, 'brdfc.table.curve');
        const [nodes, levels] = [value.getUint32(0, true), value.getUint32(4, true)];
        const [format, bytes] = channels === 1 ? (['r16float', 2] as const) : (['rgba16float', 8] as const);
        const rows = new Uint8Array(value.buffer, value.byteOffset + 8, value.byteLength - 8);
        curve = texture(image(format, bytes, [nodes, levels + 1], rows), true);
        curveWord = nodes + levels * 65536;
    }
    const block = new Words(144)
        .uint(axis(half, 0), axis(difference, 1), azimuth, layers, symmetry + (channels === 1 ? 16 : 0), curveWord)
        // Mean and bias; lows and the slope; spans and the level of detail; knots.
        .float(number(7), number(8), number(9), number(10), number(11), number(15))
        .float(number(12), number(13), number(14), distanceScale)
        .float(...Array.from({ length: 17 }, (_, k) => number(16 + k)));
    return new Map<number, Contents>([
        [0, { kind: 'uniform', bytes: block.done() }],
        [1, texture(texels, true)],
        [2, { kind: 'sampler', repeats: false }],
        [3, curve],
    ]);
}
