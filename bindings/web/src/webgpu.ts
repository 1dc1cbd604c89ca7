import type { Pack } from './pack.js';
import { gpuResource } from './upload_webgpu.js';
import { isWide, widened } from './widened.js';

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
 * @throws Error where a device lacks `float32-filterable` for a pack whose sampler filters floats of 32 bits, or integers of 16 bits,
 * which become such floats where it lacks `texture-formats-tier1`, too.
 */
export function uploadWebGpu(device: GPUDevice, pack: Pack, used: (name: string) => boolean = () => true): WebGpuPack {
    const widens = !device.features.has('texture-formats-tier1');
    if (isWide(pack, widens) && !device.features.has('float32-filterable')) {
        throw new Error('device: found none of the feature float32-filterable; allowed one that was asked for it, or a pack of 8 bits');
    }
    const uploaded = pack.resources.filter(({ name }) => used(name)).map((resource) => {
        const isWidened = widens && resource.kind === 'texture';
        const contents = isWidened ? { ...resource, texture: widened(resource.texture) } : resource;
        return { binding: resource.slot, ...gpuResource(device, contents) };
    });
    return {
        entries: uploaded.map(({ binding, resource }) => ({ binding, resource })),
        dispose() {
            uploaded.forEach(({ held }) => held?.destroy());
        },
    };
}
