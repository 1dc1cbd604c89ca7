import { refuse } from './refuse.js';

const FILTERS = ['shader', 'sampler'] as const;
const BLENDS = ['nearest', 'slices', 'bilinear'] as const;

/** Settings of a frame, independent of the pack. */
export interface FrameOptions {
    /**
     * Filtering by the sampler (default), or by the shader with exact weights, which is slower. The decoders of BRDF packs
     * have a function for each and ignore this setting.
     */
    filter?: (typeof FILTERS)[number];
    /** Interpolation between cells of wavelet packs (default: `bilinear`). */
    wavelet?: (typeof BLENDS)[number];
    /** α of the level of detail: packs with levels are drawn coarser from the distance 1 / α (default: 0.15). */
    distanceScale?: number;
}

/** The block `BrdfcFrame` of all decoders. */
export function frameBlock({ filter = 'sampler', wavelet = 'bilinear', distanceScale = 0.15 }: FrameOptions): Uint8Array<ArrayBuffer> {
    if (!(distanceScale > 0 && distanceScale < Infinity)) {
        refuse('distanceScale', distanceScale, 'a number above 0');
    }
    const block = new DataView(new ArrayBuffer(16));
    block.setFloat32(0, distanceScale, true);
    block.setUint32(4, indexOf('filter', FILTERS, filter), true);
    block.setUint32(8, indexOf('wavelet', BLENDS, wavelet), true);
    return new Uint8Array(block.buffer);
}

function indexOf(option: string, words: readonly string[], word: string): number {
    return words.includes(word) ? words.indexOf(word) : refuse(option, word, words.join(' or '));
}
