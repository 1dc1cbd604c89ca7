import { read } from 'ktx-parse';
import { ZSTDDecoder } from 'zstddec';
import { levelSize } from './levels.js';
import { refuse } from './refuse.js';

/** Texel formats by their names in WebGPU: number in Vulkan and bytes per texel. */
const FORMATS = {
    r8unorm: [9, 1],
    rg8unorm: [16, 2],
    rgba8unorm: [37, 4],
    rgb10a2unorm: [64, 4],
    r16unorm: [70, 2],
    r16float: [76, 2],
    rgba16unorm: [91, 8],
    rgba16float: [97, 8],
    r32uint: [98, 4],
    rg16float: [83, 4],
    rgba32uint: [107, 16],
    rgba32float: [109, 16],
    rgb9e5ufloat: [123, 4],
} as const;

/** A texel format, by its name in WebGPU. */
export type TexelFormat = keyof typeof FORMATS;

/** All texel formats. */
export const TEXEL_FORMATS = Object.keys(FORMATS) as TexelFormat[];

/** Kind and size of a texture. */
export interface Shape {
    format: TexelFormat;
    dimension: '2d' | '2d-array' | '3d' | 'cube';
    /** Columns, rows, and slices, layers or faces. */
    size: [number, number, number];
    levelCount: number;
}

/** A texture, ready to upload to a GPU. */
export interface TextureData extends Omit<Shape, 'levelCount'> {
    texelBytes: number;
    /** Texels of each mipmap level, the finest first: x fastest, then y, then slices, layers or faces. */
    levels: Uint8Array<ArrayBuffer>[];
}

/** A KTX2 file: its texture, and its metadata with keys `brdfc.*`. */
export interface Container {
    shape: Shape;
    entries: Map<string, Uint8Array>;
    /** Unpacks the texels. */
    unpack(): Promise<TextureData>;
}

/** Bytes of each level, the finest first. */
export function levelBytes(shape: Shape): number[] {
    const bytes = (level: number) => levelSize(shape, level).reduce((product, side) => product * side, FORMATS[shape.format][1]);
    return Array.from({ length: shape.levelCount }, (_, level) => bytes(level));
}

/** A texture of these levels. */
export function textureOf({ levelCount: _, ...rest }: Shape, levels: Uint8Array<ArrayBuffer>[]): TextureData {
    return { ...rest, texelBytes: FORMATS[rest.format][1], levels };
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
        throw new Error(`file: ${what}, in ${bytes.length} bytes; expected a complete KTX2 file`, { cause: error });
    }
}

/**
 * Reads everything of a KTX2 file except its texels.
 *
 * @throws Error if the file is not a KTX2 file or has a format that packs do not use.
 */
export function readContainer(bytes: Uint8Array): Container {
    const file = opened(bytes);
    const format = TEXEL_FORMATS.find((name) => FORMATS[name][0] === file.vkFormat)
        ?? refuse('vkFormat', file.vkFormat, Object.values(FORMATS).map(([number]) => number).join(', '));
    const isCube = file.faceCount === 6;
    if (!isCube && file.faceCount !== 1) {
        refuse('faceCount', file.faceCount, '1, or 6 for a cube map');
    }
    for (const field of ['pixelDepth', 'layerCount'] as const) {
        if (isCube && file[field] !== 0) {
            refuse(field, file[field], '0 for a cube map');
        }
    }
    if (file.supercompressionScheme !== 0 && file.supercompressionScheme !== 2) {
        refuse('supercompressionScheme', file.supercompressionScheme, '0 (none) or 2 (Zstandard)');
    }
    const shape: Shape = {
        format,
        dimension: isCube ? 'cube' : file.pixelDepth > 0 ? '3d' : file.layerCount > 0 ? '2d-array' : '2d',
        size: [file.pixelWidth, file.pixelHeight, Math.max(file.pixelDepth, file.layerCount, file.faceCount)],
        levelCount: file.levelCount,
    };
    const named = Object.entries(file.keyValue).filter(([key]) => key.startsWith('brdfc.'));
    const unpack = async () => {
        const levels: Uint8Array<ArrayBuffer>[] = [];
        for (const [level, expected] of levelBytes(shape).entries()) {
            const { levelData, uncompressedByteLength } = file.levels[level];
            const isPacked = file.supercompressionScheme === 2;
            // Checked before memory is allocated.
            const length = isPacked ? uncompressedByteLength : levelData.length;
            const data = length === expected && isPacked ? (await decoder()).decode(levelData, expected) : levelData;
            if (length !== expected || data.length !== expected) {
                refuse(`level ${level}`, `${length === expected ? data.length : length} bytes`, `${expected} bytes`);
            }
            // Copy the view into the file, because typed arrays need aligned bytes.
            levels.push(isPacked ? (data as Uint8Array<ArrayBuffer>) : new Uint8Array(data));
        }
        return textureOf(shape, levels);
    };
    return { shape, entries: new Map(named as [string, Uint8Array][]), unpack };
}
