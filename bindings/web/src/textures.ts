import type { TexelFormat, TextureData } from './container.js';
import type { Contents } from './pack.js';

/** A texture that the shader or a sampler filters. */
export function texture(data: TextureData, filtered: boolean, repeats = false): Contents {
    return { kind: 'texture', texture: data, filtered, repeats };
}

/** A 2D texture of one level. */
export function image(format: TexelFormat, texelBytes: number, size: [number, number], texels: Uint8Array): TextureData {
    return { format, dimension: '2d', size: [...size, 1], texelBytes, levels: [new Uint8Array(texels)] };
}

/** One empty texel, where there is nothing to be bound. */
export function noTexture(dimension: TextureData['dimension'], format: TexelFormat = 'r8unorm', texelBytes = 1): Contents {
    const levels = [new Uint8Array(texelBytes)];
    return texture({ format, dimension, size: [1, 1, 1], texelBytes, levels }, false);
}

/** Texels of 16-bit integers as 32-bit floats: WebGL 2 has no such integers, WebGPU has them as a feature. */
export function widened(data: TextureData): TextureData {
    if (data.format !== 'r16unorm' && data.format !== 'rgba16unorm') {
        return data;
    }
    const channels = data.format === 'r16unorm' ? 1 : 4;
    const levels = data.levels.map((level) => {
        const integers = new Uint16Array(level.buffer, 0, level.length / 2);
        const floats = new Float32Array((4 * integers.length) / channels);
        for (let k = 0; k < floats.length; k += 1) {
            const texel = Math.floor(k / 4);
            floats[k] = Math.fround(integers[channels * texel + Math.min(k % 4, channels - 1)] * Math.fround(1 / 65535));
        }
        return new Uint8Array(floats.buffer);
    });
    return { ...data, format: 'rgba32float', texelBytes: 16, levels };
}
