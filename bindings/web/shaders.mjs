// Writes src/shaders.ts: the decoders of the pages of 'brdfc view', as printed by 'brdfc shader', without comments. BRDFC is the
// path of the program. Also copies the modules that are shared with these pages.
import { execFileSync } from 'node:child_process';
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';

const program = process.env.BRDFC ?? '../../target/release/brdfc';
const run = (words) => execFileSync(program, [...words, '--quiet'], { encoding: 'utf8', maxBuffer: 1 << 24 });

const view = '../../crates/jobs/src/view';

for (const name of ['levels.js', 'upload_webgl.js', 'upload_webgpu.js']) {
    copyFileSync(`${view}/shared/${name}`, `src/${name}`);
}

/** Removes comments, indentation and empty lines. */
const bare = (text) => text
    .split('\n')
    .map((line) => line.replace(/\/\/.*$/, '').trim())
    .filter((line) => line !== '')
    .join('\n');

const namesIn = (file) => Object.keys(JSON.parse(readFileSync(file, 'utf8')));
const drawn = namesIn(`${view}/programs.json`);
const decoders = namesIn('../../crates/shaders/src/generated.json').filter((name) => drawn.includes(name));

const shaders = Object.fromEntries(decoders.map((decoder) => {
    const said = JSON.parse(run(['shader', decoder, '--language', 'wgsl', '--json']));
    const [essl300, wgsl] = ['essl300', 'wgsl'].map((language) => bare(run(['shader', decoder, '--language', language])));
    return [decoder, {
        essl300,
        wgsl,
        version: said.bindings_version,
        brdf: said.brdf,
        bindings: said.bindings.map(({ binding, name, kind, dimension, samples, filtered, bytes, fields }) => ({
            slot: binding,
            name,
            kind,
            dimension,
            samples,
            filtered,
            bytes,
            offsets: fields && Object.fromEntries(fields.map(({ name, offset }) => [name, offset])),
        })),
        functions: said.functions.map(({ name, signature }) => ({ name, signature })),
    }];
}));

writeFileSync('src/shaders.ts', `// Made by shaders.mjs.

/** A kind of pack. */
export type DecoderName = ${decoders.map((decoder) => `'${decoder}'`).join(' | ')};

/** A decoder, and its declarations. */
export interface DecoderShader {
    /** GLSL ES 3.00: declarations and functions. */
    essl300: string;
    /** WGSL: declarations and functions. */
    wgsl: string;
    /** Version of the bindings. */
    version: number;
    /** Expressions of \`wi\`, \`wo\` and \`level\`, and of \`distance\`; only for packs of BRDFs. */
    brdf?: { filtered: string; exact: string; level_of_detail: string };
    /**
     * Bindings of group 1. Uniform blocks have their bytes and the offset of each field; textures their dimension, sample type
     * (\`float\`, also for normalised integers, or \`uint\`), and whether the shader filters them.
     */
    bindings: {
        slot: number;
        name: string;
        kind: string;
        dimension?: string;
        samples?: string;
        filtered?: boolean;
        bytes?: number;
        offsets?: Record<string, number>;
    }[];
    /** Functions to call. */
    functions: { name: string; signature: string }[];
}

/** The decoders. */
export const SHADERS: Record<DecoderName, DecoderShader> = ${JSON.stringify(shaders)};
`);
