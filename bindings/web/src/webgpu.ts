import type { Pack } from './pack.js';
import { gpuResource } from './upload_webgpu.js';

/**
 * Uploads a pack, as entries for a bind group: group 1 of `pack.shader.wgsl`. With the layout 'auto' a pipeline has what it uses
 * alone: `used` picks those, by name.
 *
 * Wavelet packs of more than 8 bits hold floats of 32 bits here: a device needs the feature `float32-filterable` for them.
 */
export function uploadWebGpu(device: GPUDevice, pack: Pack, used: (name: string) => boolean = () => true): GPUBindGroupEntry[] {
    const bound = pack.resources.filter(({ name }) => used(name));
    return bound.map((resource) => ({ binding: resource.binding, resource: gpuResource(device, resource) }));
}
