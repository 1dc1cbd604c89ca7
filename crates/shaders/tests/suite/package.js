// Loads every case with the package, evaluates it, and posts the answers: bytes of f32, case by case.
import { loadPack, uploadWebGl, uploadWebGpu } from './dist/index.js';

const side = 64;
const count = side * side;

async function bytes(path) {
    return new Uint8Array(await (await fetch(path)).arrayBuffer());
}

function load(k, { options, shader }) {
    return loadPack(`/${k}/x.ktx2`, { ...options, shader });
}

function program(gl, fragment) {
    const made = gl.createProgram();
    const corner = 'vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0)';
    const vertex = `#version 300 es\nvoid main() { gl_Position = vec4(${corner}, 0.0, 1.0); }`;
    for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
        const shader = gl.createShader(kind);
        gl.shaderSource(shader, source);
        gl.compileShader(shader);
        gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) {
        throw new Error(gl.getProgramInfoLog(made) + gl.getAttachedShaders(made).map((shader) => gl.getShaderInfoLog(shader)));
    }
    return made;
}

async function withWebGl(cases, macros) {
    const gl = new OffscreenCanvas(side, side).getContext('webgl2');
    gl.getExtension('EXT_color_buffer_float');
    gl.viewport(0, 0, side, side);
    const floats = (numbers) => {
        const texture = gl.createTexture();
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, side, side);
        if (numbers) {
            gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, side, side, gl.RGBA, gl.FLOAT, numbers);
        }
        return texture;
    };
    gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, floats(null), 0);
    // Shared by several cases, since compilation takes longer than everything else.
    const programs = new Map();
    const found = [];
    for (const [k, item] of cases.entries()) {
        const pack = await load(k, item);
        const text = `#version 300 es
${pack.shader.essl300}
${macros}
uniform highp sampler2D query_a;
uniform highp sampler2D query_b;
uniform highp sampler2D query_c;
out highp vec4 answer;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(query_a, at, 0);
    vec4 b = texelFetch(query_b, at, 0);
    vec4 c = texelFetch(query_c, at, 0);
    answer = ${item.glsl};
}`;
        if (!programs.has(text)) {
            programs.set(text, program(gl, text));
        }
        const made = programs.get(text);
        gl.useProgram(made);
        const uploaded = uploadWebGl(gl, pack);
        const queries = new Float32Array((await bytes(`/${k}/queries`)).buffer);
        const textures = [0, 1, 2].map((g) => floats(queries.subarray(4 * count * g, 4 * count * (g + 1))));
        const { units } = uploaded.bind(made);
        ['query_a', 'query_b', 'query_c'].forEach((name, g) => {
            gl.activeTexture(gl.TEXTURE0 + units + g);
            gl.bindTexture(gl.TEXTURE_2D, textures[g]);
            // Samplers do not filter floats of 32 bits.
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
            gl.uniform1i(gl.getUniformLocation(made, name), units + g);
        });
        gl.drawArrays(gl.TRIANGLES, 0, 3);
        const answers = new Float32Array(4 * count);
        gl.readPixels(0, 0, side, side, gl.RGBA, gl.FLOAT, answers);
        uploaded.dispose();
        if (gl.getError() !== gl.NO_ERROR) {
            throw new Error(`${item.name}: a WebGL error`);
        }
        found.push(answers);
    }
    return found;
}

async function withWebGpu(cases) {
    const adapter = await navigator.gpu.requestAdapter();
    const device = await adapter.requestDevice({ requiredFeatures: ['float32-filterable'] });
    const pipelines = new Map();
    const found = [];
    for (const [k, item] of cases.entries()) {
        const pack = await load(k, item);
        device.pushErrorScope('validation');
        const code = `${pack.shader.wgsl}
@group(0) @binding(0) var<storage, read> queries: array<vec4<f32>>;
@group(0) @binding(1) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64) fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < ${count}u {
        let a = queries[id.x];
        let b = queries[${count}u + id.x];
        let c = queries[${2 * count}u + id.x];
        answers[id.x] = ${item.wgsl};
    }
}`;
        const uploaded = uploadWebGpu(device, pack);
        const buffer = (binding, type) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } });
        const asking = device.createBindGroupLayout({ entries: [buffer(0, 'read-only-storage'), buffer(1, 'storage')] });
        if (!pipelines.has(code)) {
            const module = device.createShaderModule({ code });
            const layout = device.createPipelineLayout({ bindGroupLayouts: [asking, uploaded.layout] });
            pipelines.set(code, await device.createComputePipelineAsync({ layout, compute: { module, entryPoint: 'main' } }));
        }
        const pipeline = pipelines.get(code);
        const { STORAGE, COPY_DST, COPY_SRC, MAP_READ } = GPUBufferUsage;
        const queries = await bytes(`/${k}/queries`);
        const asked = device.createBuffer({ size: queries.length, usage: STORAGE | COPY_DST });
        device.queue.writeBuffer(asked, 0, queries);
        const answers = device.createBuffer({ size: 16 * count, usage: STORAGE | COPY_SRC });
        const copy = device.createBuffer({ size: 16 * count, usage: MAP_READ | COPY_DST });
        const entries = [{ binding: 0, resource: { buffer: asked } }, { binding: 1, resource: { buffer: answers } }];
        const encoder = device.createCommandEncoder();
        const pass = encoder.beginComputePass();
        pass.setPipeline(pipeline);
        pass.setBindGroup(0, device.createBindGroup({ layout: asking, entries }));
        pass.setBindGroup(1, uploaded.group);
        pass.dispatchWorkgroups(Math.ceil(count / 64));
        pass.end();
        encoder.copyBufferToBuffer(answers, 0, copy, 0, 16 * count);
        device.queue.submit([encoder.finish()]);
        const error = await device.popErrorScope();
        if (error) {
            throw new Error(`${item.name}: ${error.message}`);
        }
        await copy.mapAsync(GPUMapMode.READ);
        found.push(new Float32Array(copy.getMappedRange().slice(0)));
        uploaded.dispose();
    }
    return found;
}

/** As users of three.js do: its textures, its uniforms. */
async function withThree(cases, macros) {
    const THREE = await import('three');
    const { packBindings } = await import('./dist/three.js');
    const renderer = new THREE.WebGLRenderer({ canvas: new OffscreenCanvas(side, side) });
    renderer.debug.onShaderError = (gl, made, vertex, fragment) => {
        throw new Error(gl.getShaderInfoLog(fragment) || gl.getProgramInfoLog(made));
    };
    const target = new THREE.WebGLRenderTarget(side, side, { type: THREE.FloatType, depthBuffer: false });
    const found = [];
    for (const [k, item] of cases.entries()) {
        const pack = await load(k, item);
        const queries = new Float32Array((await bytes(`/${k}/queries`)).buffer);
        const query = (g) => {
            const numbers = queries.subarray(4 * count * g, 4 * count * (g + 1));
            const texture = new THREE.DataTexture(numbers, side, side, THREE.RGBAFormat, THREE.FloatType);
            texture.needsUpdate = true;
            return { value: texture };
        };
        const { uniforms, uniformsGroups } = packBindings(pack, renderer);
        const material = new THREE.ShaderMaterial({
            glslVersion: THREE.GLSL3,
            uniformsGroups,
            uniforms: { ...uniforms, query_a: query(0), query_b: query(1), query_c: query(2) },
            vertexShader: 'void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
            fragmentShader: `${pack.shader.essl300}
${macros}
uniform highp sampler2D query_a;
uniform highp sampler2D query_b;
uniform highp sampler2D query_c;
out highp vec4 answer;
void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(query_a, at, 0);
    vec4 b = texelFetch(query_b, at, 0);
    vec4 c = texelFetch(query_c, at, 0);
    answer = ${item.glsl};
}`,
        });
        const scene = new THREE.Scene().add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
        renderer.setRenderTarget(target);
        renderer.render(scene, new THREE.Camera());
        const answers = new Float32Array(4 * count);
        renderer.readRenderTargetPixels(target, 0, 0, side, side, answers);
        found.push(answers);
    }
    return found;
}

try {
    const { api, macros, cases } = JSON.parse(new TextDecoder().decode(await bytes('/cases.json')));
    const found = await { webgl2: withWebGl, webgpu: withWebGpu, three: withThree }[api](cases, macros);
    await fetch('/result', { method: 'POST', body: new Blob(found) });
} catch (error) {
    await fetch('/result', { method: 'POST', body: `error: ${error.stack ?? error}` });
}
