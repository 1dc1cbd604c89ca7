// Evaluates every case with WebGL 2 and with WebGPU, and posts the answers: bytes of f32, case by case, in the order of the list.

const side = 64;

async function post(body) {
    await fetch('/result', { method: 'POST', body });
}

/** What is posted where a device cannot filter a texture: no numbers. */
function noAnswers() {
    return new Float32Array(4 * side * side).fill(NaN);
}

// WebGL 2 ---------------------------------------------------------------------------------------------------------------------

/** Internal format, format, type, and the array that uploads take. */
function glFormat(gl, name) {
    return {
        R8Unorm: [gl.R8, gl.RED, gl.UNSIGNED_BYTE, Uint8Array],
        Rg8Unorm: [gl.RG8, gl.RG, gl.UNSIGNED_BYTE, Uint8Array],
        Rgba8Unorm: [gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, Uint8Array],
        R16Float: [gl.R16F, gl.RED, gl.HALF_FLOAT, Uint16Array],
        Rgba16Float: [gl.RGBA16F, gl.RGBA, gl.HALF_FLOAT, Uint16Array],
        Rg16Float: [gl.RG16F, gl.RG, gl.HALF_FLOAT, Uint16Array],
        Rgba32Float: [gl.RGBA32F, gl.RGBA, gl.FLOAT, Float32Array],
        R32Uint: [gl.R32UI, gl.RED_INTEGER, gl.UNSIGNED_INT, Uint32Array],
        Rgba32Uint: [gl.RGBA32UI, gl.RGBA_INTEGER, gl.UNSIGNED_INT, Uint32Array],
        Rgb9E5: [gl.RGB9_E5, gl.RGB, gl.UNSIGNED_INT_5_9_9_9_REV, Uint32Array],
        Rgb10A2Unorm: [gl.RGB10_A2, gl.RGBA, gl.UNSIGNED_INT_2_10_10_10_REV, Uint32Array],
    }[name];
}

function glTexture(gl, texture, bytes) {
    const [internal, format, type, Numbers] = glFormat(gl, texture.format);
    const targets = { '2d': gl.TEXTURE_2D, '2d-array': gl.TEXTURE_2D_ARRAY, '3d': gl.TEXTURE_3D, cube: gl.TEXTURE_CUBE_MAP };
    const target = targets[texture.dimension];
    const isFlat = texture.dimension === '2d' || texture.dimension === 'cube';
    const firstFace = texture.dimension === 'cube' ? gl.TEXTURE_CUBE_MAP_POSITIVE_X : target;
    const [width, height, depth] = texture.size;
    gl.bindTexture(target, gl.createTexture());
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (isFlat) {
        gl.texStorage2D(target, texture.levels, internal, width, height);
    } else {
        gl.texStorage3D(target, texture.levels, internal, width, height, depth);
    }
    let at = 0;
    for (let level = 0; level < texture.levels; level += 1) {
        const [w, h] = [width, height].map((n) => Math.max(n >> level, 1));
        const length = w * h * depth * texture.texelBytes;
        const numbers = new Numbers(bytes.slice(at, at + length).buffer);
        at += length;
        if (!isFlat) {
            gl.texSubImage3D(target, level, 0, 0, 0, w, h, depth, format, type, numbers);
            continue;
        }
        for (let face = 0; face < depth; face += 1) {
            gl.texSubImage2D(firstFace + face, level, 0, 0, w, h, format, type, numbers, (face * numbers.length) / depth);
        }
    }
    const filters = texture.filtered;
    const [small, large] = filters
        ? [texture.levels > 1 ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR, gl.LINEAR]
        : [texture.levels > 1 ? gl.NEAREST_MIPMAP_NEAREST : gl.NEAREST, gl.NEAREST];
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, small);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, large);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) {
        gl.texParameteri(target, axis, texture.repeats ? gl.REPEAT : gl.CLAMP_TO_EDGE);
    }
}

function glProgram(gl, fragment) {
    const program = gl.createProgram();
    const corner = 'vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0)';
    const vertex = `#version 300 es\nvoid main() { gl_Position = vec4(${corner}, 0.0, 1.0); }`;
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
            throw new Error(gl.getShaderInfoLog(shader));
        }
        gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
        throw new Error(gl.getProgramInfoLog(program));
    }
    return program;
}

function withWebGl(cases, blobs) {
    const gl = new OffscreenCanvas(side, side).getContext('webgl2');
    if (!gl?.getExtension('EXT_color_buffer_float')) {
        throw new Error('no WebGL 2 with targets of floats');
    }
    const hasWideFilters = gl.getExtension('OES_texture_float_linear') !== null;
    gl.viewport(0, 0, side, side);
    const target = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, target);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, side, side);
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
    // Shared by several cases, since compilation takes longer than everything else.
    const programs = new Map();
    return cases.map(({ glsl, resources, queries, feature, sampled }) => {
        if (sampled && feature && !hasWideFilters) {
            return noAnswers();
        }
        if (!programs.has(glsl)) {
            programs.set(glsl, glProgram(gl, glsl));
        }
        const program = programs.get(glsl);
        gl.useProgram(program);
        let [units, blocks] = [0, 0];
        const bind = (name, texture, bytes) => {
            const place = gl.getUniformLocation(program, name);
            if (place === null) {
                return;
            }
            gl.activeTexture(gl.TEXTURE0 + units);
            glTexture(gl, texture, bytes);
            gl.uniform1i(place, units);
            units += 1;
        };
        for (const resource of resources) {
            if (resource.kind === 'uniform') {
                const buffer = gl.createBuffer();
                gl.bindBufferBase(gl.UNIFORM_BUFFER, blocks, buffer);
                gl.bufferData(gl.UNIFORM_BUFFER, blobs(resource), gl.STATIC_DRAW);
                const block = gl.getUniformBlockIndex(program, resource.block);
                if (block !== gl.INVALID_INDEX) {
                    gl.uniformBlockBinding(program, block, blocks);
                }
                blocks += 1;
            } else if (resource.kind === 'texture') {
                bind(resource.name, resource, blobs(resource));
            }
        }
        const bytes = blobs(queries);
        const part = bytes.length / 3;
        const plain = { format: 'Rgba32Float', dimension: '2d', size: [side, side, 1], levels: 1, texelBytes: 16 };
        ['query_a', 'query_b', 'query_c'].forEach((name, k) => bind(name, plain, bytes.slice(k * part, (k + 1) * part)));
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const answers = new Float32Array(4 * side * side);
        gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, answers);
        const error = gl.getError();
        if (error !== gl.NO_ERROR) {
            throw new Error(`WebGL error ${error}`);
        }
        return answers;
    });
}

// WebGPU ----------------------------------------------------------------------------------------------------------------------

const gpuFormat = {
    R8Unorm: 'r8unorm', Rg8Unorm: 'rg8unorm', Rgba8Unorm: 'rgba8unorm', R16Float: 'r16float', Rgba16Float: 'rgba16float',
    Rg16Float: 'rg16float', Rgba32Float: 'rgba32float', R32Uint: 'r32uint', Rgba32Uint: 'rgba32uint',
    Rgb9E5: 'rgb9e5ufloat', Rgb10A2Unorm: 'rgb10a2unorm',
};

async function withWebGpu(cases, blobs) {
    const adapter = await navigator.gpu?.requestAdapter();
    if (!adapter) {
        throw new Error('no WebGPU');
    }
    // Devices without features, and with one for floats that replace integers of 16 bits; for each, shaders that
    // several cases share.
    const devices = new Map();
    const opened = async (feature) => {
        const requiredFeatures = feature ? [feature] : [];
        const device = await (await navigator.gpu.requestAdapter()).requestDevice({ requiredFeatures });
        return { device, pipelines: new Map() };
    };
    const found = [];
    for (const { name, wgsl, resources, queries, feature, sampled } of cases) {
        if (sampled && feature && !adapter.features.has(feature)) {
            found.push(noAnswers());
            continue;
        }
        if (!devices.has(feature)) {
            devices.set(feature, await opened(feature));
        }
        const { device, pipelines } = devices.get(feature);
        device.pushErrorScope('validation');
        if (!pipelines.has(wgsl)) {
            const module = device.createShaderModule({ code: wgsl });
            const { messages } = await module.getCompilationInfo();
            for (const { type, lineNum, message } of messages) {
                if (type === 'error') throw new Error(`${name}, line ${lineNum}: ${message}`);
            }
            const [vertex, fragment] = ['corner', 'main'].map((entryPoint) => ({ module, entryPoint }));
            fragment.targets = [{ format: 'rgba32float' }];
            pipelines.set(wgsl, await device.createRenderPipelineAsync({ layout: 'auto', vertex, fragment }));
        }
        const pipeline = pipelines.get(wgsl);
        const { TEXTURE_BINDING, COPY_DST } = GPUTextureUsage;
        const buffer = (bytes, usage) => {
            const made = device.createBuffer({ size: bytes.length, usage: usage | GPUBufferUsage.COPY_DST });
            device.queue.writeBuffer(made, 0, bytes);
            return made;
        };
        const entries = resources.map((resource) => {
            const { binding } = resource;
            if (resource.kind === 'uniform') {
                return { binding, resource: { buffer: buffer(blobs(resource), GPUBufferUsage.UNIFORM) } };
            }
            if (resource.kind === 'sampler') {
                const mode = resource.repeats ? 'repeat' : 'clamp-to-edge';
                const sampler = { addressModeU: mode, addressModeV: mode, magFilter: 'linear', minFilter: 'linear', mipmapFilter: 'linear' };
                return { binding, resource: device.createSampler(sampler) };
            }
            const [width, height, depth] = resource.size;
            const texture = device.createTexture({
                size: [width, height, depth],
                dimension: resource.dimension === '3d' ? '3d' : '2d',
                mipLevelCount: resource.levels,
                format: gpuFormat[resource.format],
                usage: TEXTURE_BINDING | COPY_DST,
            });
            const bytes = blobs(resource);
            let at = 0;
            for (let mipLevel = 0; mipLevel < resource.levels; mipLevel += 1) {
                const [w, h] = [width, height].map((n) => Math.max(n >> mipLevel, 1));
                const length = w * h * depth * resource.texelBytes;
                const layout = { bytesPerRow: w * resource.texelBytes, rowsPerImage: h };
                device.queue.writeTexture({ texture, mipLevel }, bytes.slice(at, at + length), layout, [w, h, depth]);
                at += length;
            }
            return { binding, resource: texture.createView({ dimension: resource.dimension }) };
        });
        const asked = buffer(blobs(queries), GPUBufferUsage.STORAGE);
        const { RENDER_ATTACHMENT, COPY_SRC } = GPUTextureUsage;
        const answers = device.createTexture({ size: [side, side], format: 'rgba32float', usage: RENDER_ATTACHMENT | COPY_SRC });
        const size = 16 * side * side;
        const copy = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
        const encoder = device.createCommandEncoder();
        const target = { view: answers.createView(), loadOp: 'clear', storeOp: 'store' };
        const pass = encoder.beginRenderPass({ colorAttachments: [target] });
        pass.setPipeline(pipeline);
        const items = [{ binding: 0, resource: { buffer: asked } }];
        pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries: items }));
        pass.setBindGroup(1, device.createBindGroup({ layout: pipeline.getBindGroupLayout(1), entries }));
        pass.draw(3);
        pass.end();
        encoder.copyTextureToBuffer({ texture: answers }, { buffer: copy, bytesPerRow: 16 * side }, [side, side]);
        device.queue.submit([encoder.finish()]);
        const error = await device.popErrorScope();
        if (error) {
            throw new Error(`${name}: ${error.message}`);
        }
        await copy.mapAsync(GPUMapMode.READ);
        found.push(new Float32Array(copy.getMappedRange().slice(0)));
    }
    return found;
}

try {
    const [list, data] = await Promise.all([
        fetch('/cases.json').then((answer) => answer.json()),
        fetch('/data.bin').then((answer) => answer.arrayBuffer()),
    ]);
    const blobs = ({ at, length }) => new Uint8Array(data, at, length);
    const found = list.api === 'webgl2' ? withWebGl(list.cases, blobs) : await withWebGpu(list.cases, blobs);
    await post(new Blob(found));
} catch (error) {
    await post(`error: ${error.stack ?? error}`);
}
