import { type Container, readContainer, versioned, view } from './container.js';
import type { Contents, Options } from './pack.js';
import { noTexture, texture } from './textures.js';
import { Words } from './words.js';

const TRIANGLE = 4 * 167;
const COMPONENTS = 128;

/** What a polynomial wavelet tree binds; its layout: formats/src/pwt/spec.md. */
export async function pwtResources({ texture: first, entries }: Container, { filter }: Required<Options>): Promise<Map<number, Contents>> {
    const header = versioned(entries, 'brdfc.pwt');
    const word = (at: number) => header.getUint32(at, true);
    const float = (at: number) => header.getFloat32(at, true);
    const [width, height, columns, rows, repeats, levels, coordinates, degree, domain, count] =
        [4, 8, 12, 16, 20, 24, 28, 32, 36, 40].map(word);
    const terms = coordinates === 2 ? (degree + 1) ** 2 : ((degree + 1) * (degree + 2)) / 2;
    const triangle = Array.from({ length: (terms * (terms + 1)) / 2 }, (_, k) => float(100 + 4 * k));
    let at = 100 + 4 * triangle.length;
    const parts: { level: number; channels: number; layers: number; first: number; components: number }[] = [];
    for (let k = 0; k < count; k += 1) {
        const [level, channels, components] = [word(at), word(at + 4), word(at + 8)];
        at += 12;
        parts.push({ level, channels, layers: components / channels, first: at, components });
        at += 16 * components;
    }
    const each = (number: (part: (typeof parts)[0]) => number) => [0, 1, 2, 3].map((k) => (parts[k] ? number(parts[k]) : 0));
    const block = new Words(16 * (6 + 3) + 4 * TRIANGLE + 16 * COMPONENTS)
        .float(width, height, columns, rows)
        .uint(repeats, coordinates, degree, domain)
        .float(float(44))
        .uint(count, levels, filter === 'sampler' ? 1 : 0)
        .uint(...each((part) => part.level), ...each((part) => part.layers), ...each((part) => part.channels));
    for (let channel = 0; channel < 3; channel += 1) {
        block.float(...[0, 1, 2].map((k) => float(48 + 12 * channel + 4 * k)), 0);
    }
    block.float(...triangle).from(16 * 9 + 4 * TRIANGLE);
    for (const part of parts) {
        for (let k = 0; k < part.components; k += 1) {
            const from = part.first + 16 * k;
            block.float(word(from), word(from + 4), float(from + 8), float(from + 12));
        }
    }
    const contents = new Map<number, Contents>([
        [0, { kind: 'uniform', bytes: block.done() }],
        [5, { kind: 'sampler', repeats: repeats === 1 }],
    ]);
    for (let k = 0; k < 4; k += 1) {
        if (k >= count) {
            contents.set(1 + k, noTexture('2d-array'));
            continue;
        }
        const file = k === 0 ? undefined : view(entries, `brdfc.pwt.texture${k}`);
        const texels = file === undefined
            ? first
            : (await readContainer(new Uint8Array(file.buffer, file.byteOffset, file.byteLength))).texture;
        contents.set(1 + k, texture(texels, true, repeats === 1));
    }
    return contents;
}
