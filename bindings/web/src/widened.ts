import type { TextureData } from './container.js';
import type { Pack } from './pack.js';

/** Returns true if a sampler would have to filter 32-bit floats, which WebGL 2 and WebGPU do not guarantee. */
export function isWide({ resources }: Pack, isWidened: boolean): boolean {
    const wide = isWidened ? /32float|16unorm/ : /32float/;
    return resources.some((resource) => resource.kind === 'texture' && resource.filtered && wide.test(resource.texture.format));
}

/** Converts texels of 16-bit integers to 32-bit floats of four components: such integers do not exist in WebGL 2 and are a feature in WebGPU. */
export function widened(data: TextureData): TextureData {
    if (data.format !== 'r16unorm' && data.format !== 'rgba16unorm') {
        return data;
    }
    const channels = data.format === 'r16unorm' ? 1 : 4;
    const levels = data.levels.map((level) => {
        const integers = new Uint16Array(level.buffer, level.byteOffset, level.length / 2);
        const floats = new Float32Array((4 * integers.length) / channels);
        for (let k = 0; k < floats.length; k += 1) {
            const texel = Math.floor(k / 4);
            floats[k] = Math.fround(integers[channels * texel + Math.min(k % 4, channels - 1)] * Math.fround(1 / 65535));
        }
        return new Uint8Array(floats.buffer);
    });
    return { ...data, format: 'rgba32float', texelBytes: 16, levels };
}
