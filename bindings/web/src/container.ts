import { read } from 'ktx-parse';
import { ZSTDDecoder } from 'zstddec';

/** The formats that packs use, by their number in Vulkan: name, bytes of a texel. */
const FORMATS: Record<number, readonly [TexelFormat, number]> = {
    9: ['r8unorm', 1],
    16: ['rg8unorm', 2],
    37: ['rgba8unorm', 4],
    64: ['rgb10a2unorm', 4],
    70: ['r16unorm', 2],
    76: ['r16float', 2],
    91: ['rgba16unorm', 8],
    97: ['rgba16float', 8],
    98: ['r32uint', 4],
    103: ['rg32float', 8],
    107: ['rgba32uint', 16],
    109: ['rgba32float', 16],
    123: ['rgb9e5ufloat', 4],
};

/** A texel format, by its name in WebGPU. */
export type TexelFormat =
    | 'r8unorm' | 'rg8unorm' | 'rgba8unorm' | 'rgb10a2unorm' | 'r16unorm' | 'r16float' | 'rgba16unorm' | 'rgba16float'
    | 'r32uint' | 'rg32float' | 'rgba32uint' | 'rgba32float' | 'rgb9e5ufloat';

/** A texture as a GPU takes it. */
export interface TextureData {
    format: TexelFormat;
    /** `2d`, `2d-array` or `3d`. */
    dimension: '2d' | '2d-array' | '3d';
    /** Columns, rows, and slices or layers. */
    size: [number, number, number];
    texelBytes: number;
    /** Texels of each mipmap level, the finest first: x fastest, then y, then slices or layers. */
    levels: Uint8Array<ArrayBuffer>[];
}

/** A KTX2 file: its texture, and its entries named `brdfc.*`. */
export interface Container {
    texture: TextureData;
    entries: Map<string, Uint8Array>;
}

let zstandard: Promise<ZSTDDecoder> | undefined;

async function decoder(): Promise<ZSTDDecoder> {
    zstandard ??= (async () => {
        const made = new ZSTDDecoder();
        await made.init();
        return made;
    })();
    return zstandard;
}

function opened(bytes: Uint8Array): ReturnType<typeof read> {
    try {
        return read(bytes);
    } catch (error) {
        const what = error instanceof Error ? error.message : error;
        throw new Error(`file: found ${bytes.length} bytes (${what}); allowed a whole KTX2 file`, { cause: error });
    }
}

/**
 * Reads a KTX2 file.
 *
 * @throws Error for what is no KTX2 file, or has a format that no pack has.
 */
export async function readContainer(bytes: Uint8Array): Promise<Container> {
    const file = opened(bytes);
    const known = FORMATS[file.vkFormat];
    if (known === undefined) {
        throw new Error(`found vkFormat ${file.vkFormat}; allowed ${Object.keys(FORMATS).join(', ')}`);
    }
    const [format, texelBytes] = known;
    const dimension = file.pixelDepth > 0 ? '3d' : file.layerCount > 0 ? '2d-array' : '2d';
    const depth = Math.max(file.pixelDepth, file.layerCount, 1);
    const levels: Uint8Array<ArrayBuffer>[] = [];
    for (const [level, { levelData, uncompressedByteLength }] of file.levels.entries()) {
        const [width, height] = [file.pixelWidth, file.pixelHeight].map((side) => Math.max(side >> level, 1));
        const expected = width * height * depth * texelBytes;
        const data = file.supercompressionScheme === 2
            ? (await decoder()).decode(levelData, uncompressedByteLength)
            : levelData;
        if (data.length !== expected) {
            throw new Error(`level ${level}: found ${data.length} bytes; allowed ${expected}`);
        }
        // A copy: views into the decoder's memory do not last, and typed arrays want aligned bytes.
        levels.push(new Uint8Array(data));
    }
    const entries = new Map<string, Uint8Array>();
    for (const [key, value] of Object.entries(file.keyValue)) {
        if (key.startsWith('brdfc.') && value instanceof Uint8Array) {
            entries.set(key, value);
        }
    }
    const size: [number, number, number] = [file.pixelWidth, file.pixelHeight, depth];
    return { texture: { format, dimension, size, texelBytes, levels }, entries };
}

/** The numbers of an entry, which may begin at any byte of the file. */
export function view(entries: Map<string, Uint8Array>, key: string): DataView {
    const value = entries.get(key);
    if (value === undefined) {
        throw new Error(`${key}: found no such entry`);
    }
    return new DataView(value.buffer, value.byteOffset, value.byteLength);
}

/** The numbers of an entry that begins with a version. */
export function versioned(entries: Map<string, Uint8Array>, key: string): DataView {
    const found = view(entries, key);
    if (found.byteLength < 4 || found.getUint32(0, true) !== 1) {
        throw new Error(`${key}, version: found ${found.byteLength < 4 ? 'none' : found.getUint32(0, true)}; allowed 1`);
    }
    return found;
}

/** Refuses a texture of another size than a header says. */
export function checkSize({ size }: TextureData, expected: number[]): void {
    if (size.some((side, k) => side !== expected[k])) {
        throw new Error(`texture: found ${size.join(' x ')} texels; allowed ${expected.join(' x ')}, as the header says`);
    }
}

/** Columns and rows that a pack stores, of `[columns, rows]` that it has. */
export function storedWindow(entries: Map<string, Uint8Array>, whole: [number, number]): { first: number[]; size: number[] } {
    if (!entries.has('brdfc.crop')) {
        return { first: [0, 0], size: whole };
    }
    const crop = view(entries, 'brdfc.crop');
    const word = (k: number) => crop.getUint32(4 * k, true);
    return { first: [word(0), word(1)], size: [word(2), word(3)] };
}
