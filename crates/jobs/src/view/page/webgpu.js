// Draws with WebGPU.

import { gpuResource } from '../shared/upload_webgpu.js';
import { ATTRIBUTES, CORNER, once } from './data.js';
import { BYTES, FLOATS } from './webgl.js';

/** Feature for float textures that samplers filter: wavelet packs of more than 8 bits. */
const FILTERS_FLOATS = 'float32-filterable';
/** Rows of a copied texture begin at multiples of this. */
const ROW_BYTES = 256;

export class WebGpu {
    name = 'WebGPU';
    /** 32-bit floats are filtered by samplers; `open` requires this if a material has them. */
    filtersFloats = true;

    /**
     * Returns undefined if no device has the required features. `lost` is called if the device is lost, `wrong` with errors that
     * no other code handles.
     */
    static async open(canvas, features, lost, wrong) {
        const adapter = await navigator.gpu?.requestAdapter();
        if (!adapter || features.some((feature) => !adapter.features.has(feature))) {
            return undefined;
        }
        const { limits } = adapter;
        const device = await adapter.requestDevice({
            requiredFeatures: features,
            requiredLimits: {
                maxTextureArrayLayers: limits.maxTextureArrayLayers,
                maxTextureDimension2D: limits.maxTextureDimension2D,
                maxTextureDimension3D: limits.maxTextureDimension3D,
            },
        });
        device.lost.then(lost);
        device.addEventListener('uncapturederror', ({ error }) => wrong(error));
        return new WebGpu(device, canvas);
    }

    /** @param {GPUDevice} device */
    constructor(device, canvas) {
        this.device = device;
        this.blocks = {};
        this.targets = new Map();
        /** Uploaded resources by their contents, which several materials may share. */
        this.resources = new WeakMap();
        this.format = navigator.gpu.getPreferredCanvasFormat();
        this.context = canvas.getContext('webgpu');
        this.context.configure({ device, format: this.format });
    }

    buffer(bytes, usage) {
        const size = Math.ceil(bytes.byteLength / 4) * 4;
        const buffer = this.device.createBuffer({ size, usage: usage | GPUBufferUsage.COPY_DST });
        this.device.queue.writeBuffer(buffer, 0, bytes);
        return buffer;
    }

    /** Compiles the program of a kind of pack. Drivers compile several at a time. */
    async program({ wgsl, blocks, textures }) {
        const module = this.device.createShaderModule({ code: wgsl });
        let at = 0;
        const attributes = ATTRIBUTES.map((size, shaderLocation) => {
            const offset = 4 * at;
            at += size;
            return { shaderLocation, offset, format: /** @type {GPUVertexFormat} */ (size > 1 ? `float32x${size}` : 'float32') };
        });
        const pipeline = await this.device.createRenderPipelineAsync({
            layout: 'auto',
            vertex: { module, buffers: [{ arrayStride: 4 * CORNER, attributes }] },
            fragment: { module, targets: [{ format: 'rgba32float' }] },
            depthStencil: { format: 'depth32float', depthWriteEnabled: true, depthCompare: 'greater' },
        });
        // The layout of the pipeline has only what the shader uses.
        const blocksOfPacks = blocks.filter(({ group }) => group > 0).map(({ binding }) => binding);
        const bindings = new Set([...blocksOfPacks, ...textures.flatMap(({ binding, sampler }) => [binding, sampler])]);
        return { pipeline, bindings };
    }

    /** The programs that show both renderings: on the canvas, as floats, and as bytes for saved images. */
    async showing({ wgsl }) {
        const { device } = this;
        const module = device.createShaderModule({ code: wgsl });
        const into = (format) => ({ layout: /** @type {const} */ ('auto'), vertex: { module }, fragment: { module, targets: [{ format }] } });
        const [canvas, floats] = await Promise.all(
            [this.format, 'rgba32float'].map((format) => device.createRenderPipelineAsync(into(format))),
        );
        let bytes;
        return {
            canvas,
            [FLOATS]: floats,
            get [BYTES]() {
                bytes ??= device.createRenderPipeline(into('rgba8unorm'));
                return bytes;
            },
        };
    }

    mesh({ corners, indices }) {
        return {
            corners: this.buffer(corners, GPUBufferUsage.VERTEX),
            indices: this.buffer(indices, GPUBufferUsage.INDEX),
            count: indices.length,
        };
    }

    material({ pipeline, bindings }, resources) {
        const resource = (contents) => once(this.resources, contents, () => gpuResource(this.device, contents).resource);
        const used = resources.filter(({ binding }) => bindings.has(binding));
        const entries = used.map(({ binding, contents }) => ({ binding, resource: resource(contents) }));
        return { pipeline, group: this.device.createBindGroup({ layout: pipeline.getBindGroupLayout(1), entries }) };
    }

    /** Sets the size of renderings. */
    resize(width, height) {
        for (const { texture, depth } of this.targets.values()) {
            texture.destroy();
            depth?.destroy();
        }
        this.targets.clear();
        this.drawn = [];
        this.size = [width, height];
    }

    /** Returns a render target, and creates it at first use. */
    target(key, format, samples, withDepth) {
        if (!this.targets.has(key)) {
            const size = this.size.map((side) => side * samples);
            const usage = GPUTextureUsage.RENDER_ATTACHMENT | GPUTextureUsage.TEXTURE_BINDING | GPUTextureUsage.COPY_SRC;
            const texture = this.device.createTexture({ size, format, usage });
            const depth = withDepth
                ? this.device.createTexture({ size, format: 'depth32float', usage: GPUTextureUsage.RENDER_ATTACHMENT })
                : undefined;
            this.targets.set(key, { texture, depth });
        }
        return this.targets.get(key);
    }

    /** Draws a material on a mesh into a render target. */
    draw(which, { pipeline, group }, mesh, block, samples) {
        this.drawn[which] = this.target(`rendering ${which} of ${samples}`, 'rgba32float', samples, true);
        const { texture, depth } = this.drawn[which];
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginRenderPass({
            colorAttachments: [{ view: texture.createView(), loadOp: 'clear', storeOp: 'store', clearValue: [0, 0, 0, 0] }],
            depthStencilAttachment: { view: depth.createView(), depthLoadOp: 'clear', depthStoreOp: 'discard', depthClearValue: 0 },
        });
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, this.blockGroup(which, pipeline, block, []));
        pass.setBindGroup(1, group);
        pass.setVertexBuffer(0, mesh.corners);
        pass.setIndexBuffer(mesh.indices, 'uint32');
        pass.drawIndexed(mesh.count);
        pass.end();
        this.device.queue.submit([encoder.finish()]);
    }

    /** Bind group of the uniform block and textures of a draw call. */
    blockGroup(key, pipeline, block, textures) {
        this.blocks[key] ??= this.buffer(block, GPUBufferUsage.UNIFORM);
        this.device.queue.writeBuffer(this.blocks[key], 0, block);
        const resources = [{ buffer: this.blocks[key] }, ...textures.map(({ texture }) => texture.createView())];
        const entries = resources.map((resource, binding) => ({ binding, resource }));
        return this.device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries });
    }

    /** Shows the renderings on the canvas, or in render target `which`, on `size` pixels of it. */
    show(program, block, which, size = this.size) {
        const pipeline = program[which] ?? program.canvas;
        const texture = which === undefined ? this.context.getCurrentTexture() : this.shown(which);
        const encoder = this.device.createCommandEncoder();
        const pass = encoder.beginRenderPass({
            colorAttachments: [{ view: texture.createView(), loadOp: 'clear', storeOp: 'store' }],
        });
        pass.setViewport(0, 0, ...size, 0, 1);
        pass.setPipeline(pipeline);
        const [first, second = first, behind = first] = this.drawn;
        pass.setBindGroup(0, this.blockGroup('show', pipeline, block, [first, second, behind]));
        pass.draw(3);
        pass.end();
        this.device.queue.submit([encoder.finish()]);
    }

    shown(which) {
        return this.target(which, which === BYTES ? 'rgba8unorm' : 'rgba32float', 1, false).texture;
    }

    finished() {
        return this.device.queue.onSubmittedWorkDone();
    }

    async read(which, [x, y, width, height]) {
        const texelBytes = which === BYTES ? 4 : 16;
        const bytesPerRow = Math.ceil((width * texelBytes) / ROW_BYTES) * ROW_BYTES;
        const buffer = this.device.createBuffer({
            size: bytesPerRow * height,
            usage: GPUBufferUsage.COPY_DST | GPUBufferUsage.MAP_READ,
        });
        const encoder = this.device.createCommandEncoder();
        encoder.copyTextureToBuffer({ texture: this.shown(which), origin: [x, y, 0] }, { buffer, bytesPerRow }, [width, height, 1]);
        this.device.queue.submit([encoder.finish()]);
        await buffer.mapAsync(GPUMapMode.READ);
        const mapped = buffer.getMappedRange();
        const found = which === BYTES ? new Uint8ClampedArray(4 * width * height) : new Float32Array(4 * width * height);
        for (let row = 0; row < height; row += 1) {
            const [from, count] = [mapped.slice(row * bytesPerRow, row * bytesPerRow + width * texelBytes), 4 * width * row];
            found.set(which === BYTES ? new Uint8Array(from) : new Float32Array(from), count);
        }
        buffer.destroy();
        return found;
    }
}

/** Features that the texel formats of the materials require. */
export function featuresOf(items) {
    return items.some((item) => item.wide) ? [FILTERS_FLOATS] : [];
}
