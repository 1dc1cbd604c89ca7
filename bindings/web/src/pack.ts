import { ENTRY, type Line, parseBindings } from './bindings.js';
import { checkSum } from './checksum.js';
import { type Container, levelBytes, readContainer, type Shape, type TextureData, textureOf } from './container.js';
import { type FrameOptions, frameBlock } from './frame.js';
import { known } from './known.js';
import { refuse, refuseProblem } from './refuse.js';

/** A bound resource: a uniform block, a texture, or a sampler. */
export type Contents =
    | { kind: 'uniform'; bytes: Uint8Array<ArrayBuffer> }
    | { kind: 'texture'; texture: TextureData; filtered: boolean; repeats: boolean }
    | { kind: 'sampler'; repeats: boolean };

/** A binding of group 1 of the WGSL, with its name in every language. */
export type Resource = { slot: number; name: string } & Contents;

/** A decoder of packs. */
export interface Shader {
    /** GLSL ES 3.00: declarations and functions. Each uniform block contains one struct with the name of the binding. */
    essl300: string;
    /** WGSL: declarations and functions. */
    wgsl: string;
}

/** A pack, ready to bind. */
export interface Pack {
    /** Name of its decoder. */
    decoder: string;
    /** Version of the decoder's bindings. */
    version: number;
    /** Decoder, from `SHADERS` or from the options. */
    shader?: Shader;
    /** Bindings, by ascending slots. */
    resources: Resource[];
}

/** Options of loading. */
export interface Options extends FrameOptions {
    /** Verifies the checksum of the file. */
    verify?: boolean;
    /** Decoder for packs whose decoder is not in `SHADERS`, or to replace that one. */
    shader?: Shader;
}

/**
 * Loads a pack of any codec.
 *
 * @param source URL, or the bytes of the file.
 * @throws Error if the file is not a pack, or if its images do not match its bindings. The message states the place, the found
 * and the expected value.
 */
export async function loadPack(source: string | URL | ArrayBuffer | Uint8Array, options: Options = {}): Promise<Pack> {
    if (!(typeof source === 'string' || source instanceof URL)) {
        return read(source instanceof Uint8Array ? source : new Uint8Array(source), options);
    }
    const answer = await fetch(source);
    if (!answer.ok) {
        throw new Error(`${source}: ${answer.status} ${answer.statusText}`);
    }
    const bytes = new Uint8Array(await answer.arrayBuffer());
    return within(`${source}: `, () => read(bytes, options));
}

/** Calls a function for a file; errors begin with the name of the file. */
async function within<T>(prefix: string, work: () => T | Promise<T>): Promise<T> {
    try {
        return await work();
    } catch (error) {
        throw new Error(prefix + (error instanceof Error ? error.message : error), { cause: error });
    }
}

/** Returns the metadata of the file that a line names. */
type Take = (key: string, line: Line) => Uint8Array<ArrayBuffer>;

async function read(bytes: Uint8Array, options: Options): Promise<Pack> {
    const frame = frameBlock(options);
    const file = readContainer(bytes);
    const left = new Map(file.entries);
    const missing = left.size ? `not among the keys ${[...left.keys()].join(', ')}` : 'no brdfc keys';
    const list = left.get(ENTRY) ?? refuseProblem(ENTRY, missing, 'the keys of a pack');
    if (options.verify) {
        checkSum(bytes, file.entries);
    }
    const { decoder, version, lines } = parseBindings(list);
    const take: Take = (key, { place }) => {
        const value = left.get(key) ?? refuseProblem(key, 'missing', `a key of this name, as ${place} says`);
        left.delete(key);
        return value.slice();
    };
    const contents = async (line: Line): Promise<Contents> => {
        switch (line.kind) {
            case 'frame': return { kind: 'uniform', bytes: frame };
            case 'sampler': return { kind: 'sampler', repeats: line.repeats };
            case 'uniform': {
                const key = `brdfc.uniform.${line.name}`;
                const block = take(key, line);
                return block.length === line.length
                    ? { kind: 'uniform', bytes: block }
                    : refuse(key, `${block.length} bytes`, `${line.length}, as ${line.place} says`);
            }
            case 'texture': {
                const sampler = lines.find(({ name }) => name === line.sampler);
                const repeats = sampler?.kind === 'sampler' && sampler.repeats;
                return { kind: 'texture', texture: await texels(line, file, take), filtered: sampler !== undefined, repeats };
            }
        }
    };
    const resources: Resource[] = [];
    for (const line of lines) {
        resources.push({ slot: line.slot, name: line.name, ...(await contents(line)) });
    }
    const unnamed = [...left.keys()].find((key) => /^brdfc\.(image|uniform)\./.test(key));
    if (unnamed !== undefined) {
        refuseProblem(unnamed, 'no binding names this key', `keys that ${ENTRY} names`);
    }
    return { decoder, version, shader: options.shader ?? known(decoder, version, resources), resources };
}

/** Returns the texels of an image, which must match its line. */
async function texels(line: Line & { kind: 'texture' }, file: Container, take: Take): Promise<TextureData> {
    const { place, shape, stored, name } = line;
    if (stored === 'empty') {
        return textureOf(shape, levelBytes(shape).map((length) => new Uint8Array(length)));
    }
    const key = stored === 'file' ? 'texture' : `brdfc.image.${name}`;
    const value = stored === 'file' ? undefined : take(key, line);
    const image = value === undefined ? file : await within(`${key}, `, () => readContainer(value));
    const [found, expected] = [image.shape, shape].map(summary);
    if (found !== expected) {
        refuse(key, found, `${expected}, as ${place} says`);
    }
    const [entry] = stored === 'file' ? [] : image.entries.keys();
    if (entry !== undefined) {
        refuse(`${key}, keys`, entry, 'no brdfc keys');
    }
    return within(`${key}, `, () => image.unpack());
}

function summary({ levelCount, dimension, size, format }: Shape): string {
    return `${levelCount} levels of ${dimension}, ${size.join(' x ')} texels of ${format}`;
}
