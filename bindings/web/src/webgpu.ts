import type { Pack } from './pack.js';
import { gpuResource } from './upload_webgpu.js';

/** A pack on a WebGPU device. */
export interface WebGpuPack {
    /** For a bind group: group 1 of `pack.shader.wgsl`. */
    entries: GPUBindGroupEntry[];
    /** Frees what it holds. */
    dispose(): void;
}

/**
 * Uploads a pack. With the layout 'auto' a pipeline has what it uses alone: `used` picks those, by name.
 *
 * Wavelet packs of more than 8 bits hold floats of 32 bits here: a device needs the feature `float32-filterable` for them.
 */
export function uploadWebGpu(device: GPUDevice, pack: Pack, used: (name: string) => boolean = () => true): WebGpuPack {
    const bound = pack.resources.filter(({ name }) => used(name));
    const uploaded = bound.map((contents) => ({ binding: contents.binding, ...gpuResource(device, contents) }));
    return {
        entries: uploaded.map(({ binding, resource }) => ({ binding, resource })),
        dispose() {
            uploaded.forEach(({ held }) => held?.destroy());
        },
    };
}
