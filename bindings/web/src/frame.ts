import { refuse } from './refuse.js';

const FILTERS = ['shader', 'sampler'] as const;
const BLENDS = ['nearest', 'slices', 'bilinear'] as const;

/** What changes with the frame rather than with the pack. */
export interface FrameOptions {
    /**
     * Who filters: the sampler (default), or the shader with exact weights, which is slower. BRDF packs have a function for
     * each, whatever stands here.
     */
    filter?: (typeof FILTERS)[number];
    /** Of wavelet packs: between which cells values are blended (default: `bilinear`). */
    wavelet?: (typeof BLENDS)[number];
    /** α of the level of detail: from the distance 1 / α on, packs that have levels are drawn coarser (default: 0.15). */
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
