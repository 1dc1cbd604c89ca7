// Writes src/shaders.ts: the decoders as 'brdfc shader' says them, without comments. BRDFC names the program.
import { execFileSync } from 'node:child_process';
import { writeFileSync } from 'node:fs';

const program = process.env.BRDFC ?? '../../target/release/brdfc';
const run = (...words) => execFileSync(program, ['shader', ...words], { encoding: 'utf8', maxBuffer: 1 << 24 });

/** Without comments, indentation and empty lines. */
const bare = (text) => text
    .split('\n')
    .map((line) => line.replace(/\/\/.*$/, '').trim())
    .filter((line) => line !== '')
    .join('\n');

/** Of the bindings that the decoders have. */
const version = 1;
const decoders = ['table', 'wavelet', 'flat-btf', 'pwt'];
const shaders = Object.fromEntries(decoders.map((decoder) => {
    const { bindings, functions } = JSON.parse(run(decoder, '--language', 'wgsl', '--json'));
    return [decoder, {
        essl300: bare(run(decoder, '--language', 'essl300')),
        wgsl: bare(run(decoder, '--language', 'wgsl')),
        version,
        bindings: bindings.map(({ binding, name, kind, dimension, bytes, fields }) => ({
            slot: binding,
            name,
            kind,
            dimension,
            bytes,
            offsets: fields && Object.fromEntries(fields.map(({ name, offset }) => [name, offset])),
        })),
        functions: functions.map(({ name, signature }) => ({ name, signature })),
    }];
}));

writeFileSync('src/shaders.ts', `// Made by shaders.mjs.

/** A kind of pack. */
export type DecoderName = ${decoders.map((decoder) => `'${decoder}'`).join(' | ')};

/** A decoder, and what it declares. */
export interface DecoderShader {
    /** GLSL ES 3.00: declarations and functions. */
    essl300: string;
    /** WGSL, likewise. */
    wgsl: string;
    /** Version of the bindings. */
    version: number;
    /** Bindings of group 1; of uniform blocks their bytes and where each field begins, of textures their dimension. */
    bindings: {
        slot: number;
        name: string;
        kind: string;
        dimension?: string;
        bytes?: number;
        offsets?: Record<string, number>;
    }[];
    /** What to call. */
    functions: { name: string; signature: string }[];
}

/** The decoders. */
export const SHADERS: Record<DecoderName, DecoderShader> = ${JSON.stringify(shaders)};
`);
