import type { Pack, Resource } from './pack.js';
import { gpuResource } from './upload_webgpu.js';
import { isWide, widened } from './widened.js';

/** A pack on a WebGPU device: group 1 of `pack.shader.wgsl`. */
export interface WebGpuPack {
    /** Layout of the group for `createPipelineLayout`, including bindings that a pipeline does not use. */
    layout: GPUBindGroupLayout;
    group: GPUBindGroup;
    /** Frees its textures and buffers. */
    dispose(): void;
}

/**
 * Uploads a pack.
 *
 * @throws Error if the device lacks `float32-filterable` and the sampler of the pack filters 32-bit floats, or 16-bit integers,
 * which become such floats without `texture-formats-tier1`.
 */
export function uploadWebGpu(device: GPUDevice, pack: Pack): WebGpuPack {
    const widens = !device.features.has('texture-formats-tier1');
    if (isWide(pack, widens) && !device.features.has('float32-filterable')) {
        throw new Error('device: the pack needs the feature float32-filterable; request it with requiredFeatures, or encode the pack with --bits 8');
    }
    const uploaded = pack.resources.map((resource) => {
        const isWidened = widens && resource.kind === 'texture';
        const contents = isWidened ? { ...resource, texture: widened(resource.texture) } : resource;
        return { binding: resource.slot, ...gpuResource(device, contents) };
    });
    const layout = device.createBindGroupLayout({ entries: pack.resources.map(layoutEntry) });
    const entries = uploaded.map(({ binding, resource }) => ({ binding, resource }));
    return {
        layout,
        group: device.createBindGroup({ layout, entries }),
        dispose() {
            uploaded.forEach(({ held }) => held?.destroy());
        },
    };
}

function layoutEntry(resource: Resource): GPUBindGroupLayoutEntry {
    const entry = { binding: resource.slot, visibility: GPUShaderStage.VERTEX | GPUShaderStage.FRAGMENT | GPUShaderStage.COMPUTE };
    switch (resource.kind) {
        case 'uniform': return { ...entry, buffer: {} };
        case 'sampler': return { ...entry, sampler: {} };
        case 'texture': {
            const { texture: { format, dimension }, filtered } = resource;
            const float = filtered ? 'float' : 'unfilterable-float';
            return { ...entry, texture: { sampleType: format.endsWith('uint') ? 'uint' : float, viewDimension: dimension } };
        }
    }
}
