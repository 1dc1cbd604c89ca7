// The list of bindings of a pack, one per line: the metadata `brdfc.bindings`. Layout: formats/src/bindings/spec.md.

import { levelBytes, type Shape, TEXEL_FORMATS } from './container.js';
import { refuse, refuseProblem } from './refuse.js';

/** The key whose value makes a texture a pack. */
export const ENTRY = 'brdfc.bindings';

const [MAX_BINDINGS, MAX_SLOTS, MAX_UNIFORM_BYTES, MAX_TEXEL_BYTES] = [32, 1000, 16384, 2 ** 30];
/** Maximum number of textures, samplers and uniform blocks of a pack. */
const MAX_OF = { texture: 16, sampler: 16, uniform: 12 };
/** Maximum number of columns, rows, and slices, layers or faces. */
const MAX_SIZES = { '2d': [8192, 8192, 1], '2d-array': [8192, 8192, 2048], '3d': [2048, 2048, 2048], cube: [2048, 2048, 6] };
const DIMENSIONS = Object.keys(MAX_SIZES) as (keyof typeof MAX_SIZES)[];
const NAME = /^[a-z0-9_-]{1,64}$/;

/** A line: a binding without its bytes. */
export type Line = { place: string; slot: number; name: string } & (
    | { kind: 'frame' }
    | { kind: 'uniform'; length: number }
    | { kind: 'texture'; stored: 'file' | 'entry' | 'empty'; shape: Shape; sampler?: string }
    | { kind: 'sampler'; repeats: boolean }
);

/** Parses the list. Errors state the line, its contents and the expected contents. */
export function parseBindings(value: Uint8Array): { decoder: string; version: number; lines: Line[] } {
    const text = new TextDecoder('utf-8', { ignoreBOM: true }).decode(value);
    if (!text.endsWith('\n\0')) {
        refuseProblem(ENTRY, `${value.length} bytes that are not valid text`, 'lines of UTF-8 text that end with a zero byte');
    }
    const [first, ...rest] = text.slice(0, -2).split('\n');
    const [word, decoder, version, ...more] = first.split(' ');
    if (word !== 'decoder' || !NAME.test(decoder ?? '') || version === undefined || more.length > 0) {
        refuse(`${ENTRY} line 1`, first, "'decoder', its name and its version");
    }
    if (rest.length === 0 || rest.length > MAX_BINDINGS) {
        refuse(`${ENTRY} bindings`, rest.length, `1 to ${MAX_BINDINGS}`);
    }
    const lines = rest.map((line, k) => parseLine(`${ENTRY} line ${k + 2}`, line));
    checkTogether(lines);
    return { decoder, version: whole(`${ENTRY} line 1`, version, 1, 2 ** 32 - 1), lines };
}

function parseLine(place: string, line: string): Line {
    const [slotWord, name, kind, ...words] = line.split(' ');
    if (kind === undefined) {
        refuse(place, line, 'a slot, a name and a resource');
    }
    const slot = whole(place, slotWord, 0, MAX_SLOTS - 1);
    if (!NAME.test(name)) {
        refuse(place, name, 'a name of a to z, 0 to 9, - and _');
    }
    const begun = { place, slot, name };
    switch (`${kind} ${words.length}`) {
        case 'frame 0':
            return slot === 0 ? { ...begun, kind: 'frame' } : refuse(place, slot, 'slot 0 for a frame');
        case 'uniform 1': {
            const length = whole(place, words[0], 16, MAX_UNIFORM_BYTES);
            return length % 16 === 0 ? { ...begun, kind: 'uniform', length } : refuse(place, length, 'a multiple of 16');
        }
        case 'sampler 1':
            return { ...begun, kind: 'sampler', repeats: oneOf(place, words[0], ['clamp', 'repeat']) === 'repeat' };
        case 'texture 8': {
            const [stored, dimension] = [oneOf(place, words[0], ['file', 'entry', 'empty']), oneOf(place, words[1], DIMENSIONS)];
            const format = oneOf(place, words[2], TEXEL_FORMATS);
            const size = MAX_SIZES[dimension].map((most, axis) => whole(place, words[3 + axis], 1, most)) as Shape['size'];
            const [width, height, depth] = size;
            if (dimension === 'cube' && (width !== height || depth !== 6)) {
                refuse(place, `cube of [${size.join(', ')}]`, '2d, 2d-array, 3d or cube, of a size that packs support');
            }
            const longest = Math.max(...(dimension === '3d' ? size : size.slice(0, 2)));
            const levelCount = whole(place, words[6], 1, 1 + Math.floor(Math.log2(longest)));
            // All faces of a cube map have their texel.
            if (stored === 'empty' && width * height * depth !== (dimension === 'cube' ? 6 : 1)) {
                refuse(place, size.join(' x '), 'one texel for an empty texture');
            }
            const sampler = words[7] === '-' ? undefined : words[7];
            return { ...begun, kind: 'texture', stored, shape: { format, dimension, size, levelCount }, sampler };
        }
        default:
            return refuse(place, line, 'frame, uniform, texture or sampler with its fields');
    }
}

function checkTogether(lines: Line[]): void {
    let bytes = 0;
    lines.forEach((line, k) => {
        if (k > 0 && line.slot <= lines[k - 1].slot) {
            refuse(line.place, `slot ${line.slot}`, 'slots in ascending order, each once');
        }
        if (lines.findIndex(({ name }) => name === line.name) < k) {
            refuse(line.place, line.name, 'a unique name');
        }
        if (line.kind !== 'texture') {
            return;
        }
        if (line.sampler !== undefined && !lines.some(({ kind, name }) => kind === 'sampler' && name === line.sampler)) {
            refuse(line.place, line.sampler, 'the name of a sampler in the list, or -');
        }
        if (line.sampler !== undefined && line.shape.format.endsWith('uint')) {
            refuse(line.place, line.sampler, '-, because integers are not filtered');
        }
        bytes += levelBytes(line.shape).reduce((sum, length) => sum + length);
        if (bytes > MAX_TEXEL_BYTES) {
            refuse(line.place, `${bytes} bytes of texels so far`, `at most ${MAX_TEXEL_BYTES} for all images`);
        }
    });
    for (const [what, most] of Object.entries(MAX_OF)) {
        const { length } = lines.filter(({ kind }) => (kind === 'frame' ? 'uniform' : kind) === what);
        if (length > most) {
            refuse(`${ENTRY} ${what}s`, length, `at most ${most}`);
        }
    }
    const { length } = lines.filter((line) => line.kind === 'texture' && line.stored === 'file');
    if (length !== 1) {
        refuse(ENTRY, `${length} bindings of the file's own texture`, 'one');
    }
}

/** A number without leading zeros. */
function whole(place: string, word: string, least: number, most: number): number {
    const found = Number(word);
    return String(found) === word && Number.isInteger(found) && found >= least && found <= most
        ? found
        : refuse(place, word, `${least} to ${most}`);
}

function oneOf<T extends string>(place: string, word: string, words: T[]): T {
    return words.find((known) => known === word) ?? refuse(place, word, words.join(' or '));
}
