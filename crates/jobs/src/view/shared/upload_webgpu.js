// Resources of packs in WebGPU, for the web package and the pages of 'brdfc view'.

import { levelSize } from './levels.js';

/** @typedef {import('./container.js').TextureData} TextureData */

/**
 * Uploads one texture with its mipmap levels.
 *
 * @param {GPUDevice} device
 * @param {TextureData} data
 * @returns {GPUTexture}
 */
export function gpuTexture(device, data) {
    const texture = device.createTexture({
        size: data.size,
        dimension: data.dimension === '3d' ? '3d' : '2d',
        mipLevelCount: data.levels.length,
        format: /** @type {GPUTextureFormat} */ (data.format),
        usage: GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_DST,
    });
    data.levels.forEach((bytes, mipLevel) => {
        const size = levelSize(data, mipLevel);
        const layout = { bytesPerRow: size[0] * data.texelBytes, rowsPerImage: size[1] };
        device.queue.writeTexture({ texture, mipLevel }, bytes, layout, size);
    });
    return texture;
}

/**
 * Creates the binding of a resource, and the object `held` that owns its memory; samplers have none.
 *
 * @param {GPUDevice} device
 * @param {import('./pack.js').Contents} contents
 * @returns {{ resource: GPUBindingResource, held?: GPUTexture | GPUBuffer }}
 */
export function gpuResource(device, contents) {
    if (contents.kind === 'sampler') {
        const mode = contents.repeats ? 'repeat' : 'clamp-to-edge';
        const resource = device.createSampler({
            addressModeU: mode,
            addressModeV: mode,
            addressModeW: mode,
            magFilter: 'linear',
            minFilter: 'linear',
            mipmapFilter: 'linear',
        });
        return { resource };
    }
    if (contents.kind === 'uniform') {
        const { bytes } = contents;
        const buffer = device.createBuffer({ size: bytes.length, usage: GPUBufferUsage.UNIFORM | GPUBufferUsage.COPY_DST });
        device.queue.writeBuffer(buffer, 0, bytes);
        return { resource: { buffer }, held: buffer };
    }
    const held = gpuTexture(device, contents.texture);
    return { resource: held.createView({ dimension: contents.texture.dimension }), held };
}
