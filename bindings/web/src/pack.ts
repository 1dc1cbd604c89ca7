import { type Container, readContainer, type TextureData } from './container.js';
import { flatBtfResources } from './flat_btf.js';
import { pwtResources } from './pwt.js';
import { type DecoderName, type DecoderShader, SHADERS } from './shaders.js';
import { tableResources } from './table.js';
import { waveletResources } from './wavelet.js';

/** What is bound: a uniform block, a texture, or a sampler. */
export type Contents =
    | { kind: 'uniform'; bytes: Uint8Array<ArrayBuffer> }
    | { kind: 'texture'; texture: TextureData; filtered: boolean; repeats: boolean }
    | { kind: 'sampler'; repeats: boolean };

/** A binding of group 1 of the WGSL, and the name that it has in every language. */
export type Resource = { binding: number; name: string } & Contents;

/** A pack, ready to be bound. */
export interface Pack {
    /** Which decoder it has. */
    decoder: DecoderName;
    /** The decoder in GLSL ES 3.00 and in WGSL, with what it declares. */
    shader: DecoderShader;
    /** What to bind, in the order of the bindings. */
    resources: Resource[];
}

/** How a pack is looked up. */
export interface Options {
    /**
     * Who filters: the sampler (default), or the shader with exact weights, which is slower. BRDF packs have a function for
     * each, whatever stands here.
     */
    filter?: 'sampler' | 'shader';
    /** Of wavelet packs: between which cells values are blended (default: `bilinear`). */
    wavelet?: 'nearest' | 'slices' | 'bilinear';
    /** α of the level of detail: from the distance 1 / α on, packs that have levels are drawn coarser (default: 0.15). */
    distanceScale?: number;
}

/** Options with what stands in place of those that are left out: α is that of `brdfc render` and of manifests. */
function chosen({ filter = 'sampler', wavelet = 'bilinear', distanceScale = 0.15 }: Options): Required<Options> {
    if (!(distanceScale > 0)) {
        throw new Error(`distanceScale: found ${distanceScale}; allowed a number above 0`);
    }
    return { filter, wavelet, distanceScale };
}

/** Whether a sampler would have to filter 32-bit floats, which WebGL 2 and WebGPU promise of none: wavelet packs of more than 8 bits. */
export function isWide({ resources }: Pack): boolean {
    return resources.some((resource) => resource.kind === 'texture' && resource.filtered && resource.texture.format === 'rgba32float');
}

async function bytesOf(source: string | URL | ArrayBuffer | Uint8Array): Promise<Uint8Array> {
    if (source instanceof Uint8Array) {
        return source;
    }
    if (source instanceof ArrayBuffer) {
        return new Uint8Array(source);
    }
    const answer = await fetch(source);
    if (!answer.ok) {
        throw new Error(`${source}: ${answer.status} ${answer.statusText}`);
    }
    return new Uint8Array(await answer.arrayBuffer());
}

function named(decoder: DecoderName, contents: Map<number, Contents>): Pack {
    const shader = SHADERS[decoder];
    const resources = shader.bindings.map(({ binding, name }) => {
        const found = contents.get(binding);
        if (found === undefined) {
            throw new Error(`${decoder}: nothing for binding ${binding}, ${name}`);
        }
        return { binding, name, ...found };
    });
    return { decoder, shader, resources };
}

/**
 * Loads a pack of one file: a table or wavelet pack of a BRDF, or a polynomial wavelet tree.
 *
 * @param source an address, or the bytes of the file.
 * @throws Error for what is no such pack.
 */
export async function loadPack(source: string | URL | ArrayBuffer | Uint8Array, options: Options = {}): Promise<Pack> {
    const bytes = await bytesOf(source);
    const isAddress = typeof source === 'string' || source instanceof URL;
    return ofFile(isAddress ? `${source}` : undefined, () => packOf(bytes, chosen(options)));
}

/** Does what a file is for; errors begin with its name, where it has one. */
async function ofFile<T>(name: string | undefined, work: () => T | Promise<T>): Promise<T> {
    try {
        return await work();
    } catch (error) {
        const text = error instanceof Error ? error.message : String(error);
        throw new Error(name === undefined ? text : `${name}: ${text}`, { cause: error });
    }
}

async function packOf(bytes: Uint8Array, options: Required<Options>): Promise<Pack> {
    const container = await readContainer(bytes);
    const { entries } = container;
    if (entries.has('brdfc.table')) {
        return named('table', tableResources(container, options));
    }
    if (entries.has('brdfc.wavelet')) {
        return named('wavelet', waveletResources(container, options));
    }
    if (entries.has('brdfc.pwt')) {
        return named('pwt', await pwtResources(container, options));
    }
    const found = [...entries.keys()].join(', ') || 'none';
    throw new Error(`brdfc entries: found ${found}; allowed those of a table, a wavelet pack or a polynomial wavelet tree`);
}

/**
 * Loads a flat BTF: factored, or without views.
 *
 * @param source the address of its `NAME.json`, or a function that gives the bytes of a file of its folder.
 * @param name NAME, where `source` is a function.
 * @throws Error for what is no flat BTF, and for one of all views, which would not fit a browser.
 */
export async function loadFlatBtf(
    source: string | URL | ((file: string) => Promise<Uint8Array>),
    options: Options = {},
    name = '',
): Promise<Pack> {
    const address = typeof source === 'function' ? undefined : new URL(source, globalThis.document?.baseURI ?? location.href);
    const from = typeof source === 'function' ? source : (file: string) => bytesOf(new URL(file, address));
    const list = address?.href ?? `${name}.json`;
    const bytes = await from(list);
    const parts = await ofFile(list, () => partsOf(bytes));
    const drawn = parts.filter(([part]) => part !== 'position' && part !== 'mask');
    const read = async ([part, { file }]: Listed) => {
        const stored = await from(file);
        return [part, await ofFile(file, () => readContainer(stored))] as const;
    };
    const containers = new Map<string, Container>(await Promise.all(drawn.map(read)));
    return ofFile(list, () => named('flat-btf', flatBtfResources(containers, chosen(options))));
}

/** A part, and the file that has it. */
type Listed = [string, { file: string }];

function partsOf(bytes: Uint8Array): Listed[] {
    const allowed = "allowed the .json that 'brdfc flatten' wrote";
    let list: { parts?: Record<string, { file?: unknown }> } | null;
    try {
        list = JSON.parse(new TextDecoder().decode(bytes));
    } catch (error) {
        throw new Error(`list of parts: found no JSON; ${allowed}`, { cause: error });
    }
    const parts = Object.entries(list?.parts ?? {});
    if (parts.length === 0 || parts.some(([, part]) => typeof part?.file !== 'string')) {
        throw new Error(`list of parts: found none; ${allowed}`);
    }
    if (parts.some(([part]) => part.startsWith('flat.'))) {
        throw new Error('found all views; allowed a factored flat BTF: leave out --uncompressed');
    }
    return parts as Listed[];
}
