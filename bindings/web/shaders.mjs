// Writes src/shaders.ts: the decoders as 'brdfc shader' prints them, without comments, and the version that packs of 'brdfc' have. BRDFC
// names the program.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

const named = process.env.BRDFC ?? '../../target/release/brdfc';
// Packs are made in another folder; a name alone is looked for on the path.
const program = named.includes('/') ? resolve(named) : named;
const run = (words, cwd = '.') => execFileSync(program, [...words, '--quiet'], { cwd, encoding: 'utf8', maxBuffer: 1 << 24 });

/** Without comments, indentation and empty lines. */
const bare = (text) => text
    .split('\n')
    .map((line) => line.replace(/\/\/.*$/, '').trim())
    .filter((line) => line !== '')
    .join('\n');

/** How a small pack of each decoder is made, in this order: that of `pwt` is a view of the flat BTF. */
const packs = {
    table: ['encode', 'synth:lambert', '--codec', 'table', '-o', 'table.ktx2'],
    wavelet: ['encode', 'synth:lambert', '--codec', 'wavelet', '--grid', '8', '-o', 'wavelet.ktx2'],
    'flat-btf': [
        'flatten', 'synth:button?resolution=16', '--texels', '8', '--views', 'grid:2x4@60', '--lights', 'grid:2x4@60',
        '-o', '.', '--name', 'flat-btf',
    ],
    pwt: ['pwt', '.', '-o', 'pwt.ktx2'],
};
const decoders = Object.keys(packs);

/** Version of the bindings of each decoder, from the list of a pack. */
function versions() {
    const folder = mkdtempSync(join(tmpdir(), 'brdfc-web-'));
    try {
        return Object.fromEntries(Object.entries(packs).map(([decoder, words]) => {
            run(words, folder);
            const pack = readFileSync(join(folder, `${decoder}.ktx2`), 'latin1');
            const [, found, version] = pack.match(/brdfc\.bindings\0decoder (\S+) (\d+)\n/) ?? [];
            if (found !== decoder) {
                throw new Error(`${words.join(' ')}: found a pack for the decoder ${found}; allowed ${decoder}`);
            }
            return [decoder, Number(version)];
        }));
    } finally {
        rmSync(folder, { recursive: true });
    }
}

/** Names of the textures that a shader filters. It samples them by their global names. */
function filteredBy(wgsl, bindings) {
    const names = new Set([...wgsl.matchAll(/\btextureSample\w*\(\s*(\w+)/g)].map(([, name]) => name));
    const textures = bindings.filter(({ kind }) => kind === 'texture').map(({ name }) => name);
    const unknown = [...names].find((name) => !textures.includes(name));
    if (unknown !== undefined) {
        throw new Error(`textureSample: found ${unknown}; allowed ${textures.join(', ')}`);
    }
    return names;
}

const versionOf = versions();
const shaders = Object.fromEntries(decoders.map((decoder) => {
    const { bindings, functions } = JSON.parse(run(['shader', decoder, '--language', 'wgsl', '--json']));
    const [essl300, wgsl] = ['essl300', 'wgsl'].map((language) => bare(run(['shader', decoder, '--language', language])));
    const filtered = filteredBy(wgsl, bindings);
    return [decoder, {
        essl300,
        wgsl,
        version: versionOf[decoder],
        bindings: bindings.map(({ binding, name, kind, dimension, samples, bytes, fields }) => ({
            slot: binding,
            name,
            kind,
            dimension,
            samples,
            filtered: kind === 'texture' ? filtered.has(name) : undefined,
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
    /**
     * Bindings of group 1. Uniform blocks have their bytes and the offset of each field; textures their dimension, what samples are
     * (\`float\`, also of normalised integers, or \`uint\`), and whether the shader filters them.
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
    /** What to call. */
    functions: { name: string; signature: string }[];
}

/** The decoders. */
export const SHADERS: Record<DecoderName, DecoderShader> = ${JSON.stringify(shaders)};
`);
