import type { Pack } from './pack.js';

/**
 * Uploads a pack, as entries for a bind group: group 1 of `pack.shader.wgsl`. With the layout 'auto' a pipeline has what it uses
 * alone: `used` picks those, by name.
 *
 * Wavelet packs of more than 8 bits hold floats of 32 bits here: a device needs the feature `float32-filterable` for them.
 */
export function uploadWebGpu(device: GPUDevice, pack: Pack, used: (name: string) => boolean = () => true): GPUBindGroupEntry[] {
    return pack.resources.filter(({ name }) => used(name)).map((resource): GPUBindGroupEntry => {
        const { binding } = resource;
        if (resource.kind === 'sampler') {
            const mode = resource.repeats ? 'repeat' : 'clamp-to-edge';
            return {
                binding,
                resource: device.createSampler({
                    addressModeU: mode,
                    addressModeV: mode,
                    addressModeW: mode,
                    magFilter: 'linear',
                    minFilter: 'linear',
                    mipmapFilter: 'linear',
                }),
            };
        }
        if (resource.kind === 'uniform') {
            const { bytes } = resource;
            const buffer = device.createBuffer({ size: bytes.length, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
            device.queue.writeBuffer(buffer, 0, bytes);
            return { binding, resource: { buffer } };
        }
        const { texture: data } = resource;
        const [width, height, depth] = data.size;
        const texture = device.createTexture({
            size: [width, height, depth],
            dimension: data.dimension === '3d' ? '3d' : '2d',
            mipLevelCount: data.levels.length,
            format: data.format as GPUTextureFormat,
            usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
        });
        data.levels.forEach((bytes, mipLevel) => {
            const [w, h] = [width, height].map((side) => Math.max(side >> mipLevel, 1));
            const layout = { bytesPerRow: w * data.texelBytes, rowsPerImage: h };
            device.queue.writeTexture({ texture, mipLevel }, bytes, layout, [w, h, depth]);
        });
        return { binding, resource: texture.createView({ dimension: data.dimension }) };
    });
}
