// Draws with WebGL 2.

import { uploadTexture } from '../shared/upload_webgl.js';
import { ATTRIBUTES, CORNER, once } from './data.js';

/** Binding points of uniform blocks. */
const VIEW_POINT = 0;
const PACK_POINT = 1;
/** Number of the rendering that is behind the others. */
export const BEHIND = 2;
/** Numbers of the render targets of the displayed view, as bytes and as floats. */
export const BYTES = 3;
export const FLOATS = 4;

export class WebGl {
    name = 'WebGL 2';
    /** 32-bit floats are filtered by the shader. */
    filtersFloats = false;

    /** Returns undefined if WebGL 2 with float render targets is not available. `lost` is called if the context is lost. */
    static async open(canvas, lost) {
        const gl = canvas.getContext('webgl2', { antialias: false, depth: false });
        if (!gl?.getExtension('EXT_color_buffer_float')) {
            return undefined;
        }
        canvas.addEventListener('webglcontextlost', lost, { once: true });
        return new WebGl(gl);
    }

    /** @param {WebGL2RenderingContext} gl */
    constructor(gl) {
        this.gl = gl;
        this.block = gl.createBuffer();
        this.empty = gl.createVertexArray();
        this.targets = new Map();
        /** Uploaded textures by their contents, which several materials may share. */
        this.textures = new WeakMap();
    }

    /** Starts compiling a program of the page; `check` waits for the driver and throws errors. */
    program({ vertex, fragment, blocks, textures }) {
        const { gl } = this;
        const program = gl.createProgram();
        for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
            const shader = gl.createShader(type);
            gl.shaderSource(shader, source);
            gl.compileShader(shader);
            gl.attachShader(program, shader);
        }
        gl.linkProgram(program);
        // Binding points are few on some devices, so they do not follow slots, which have gaps.
        const packed = blocks.filter(({ group }) => group > 0);
        const points = new Map(packed.map(({ binding }, k) => [binding, PACK_POINT + k]));
        let checked = false;
        const check = () => {
            if (checked) {
                return;
            }
            checked = true;
            if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
                const logs = gl.getAttachedShaders(program).map((shader) => gl.getShaderInfoLog(shader));
                throw new Error(`${gl.getProgramInfoLog(program)} ${logs.join(' ')}`);
            }
            gl.useProgram(program);
            for (const { group, binding, name } of blocks) {
                const index = gl.getUniformBlockIndex(program, name);
                if (index !== gl.INVALID_INDEX) {
                    gl.uniformBlockBinding(program, index, group === 0 ? VIEW_POINT : points.get(binding));
                }
            }
            textures.forEach(({ name }, unit) => gl.uniform1i(gl.getUniformLocation(program, name), unit));
        };
        return { program, check, points, textures };
    }

    /** The program that shows both renderings. */
    showing(program) {
        return this.program(program);
    }

    mesh({ corners, indices }) {
        const { gl } = this;
        const array = gl.createVertexArray();
        gl.bindVertexArray(array);
        gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ARRAY_BUFFER, corners, gl.STATIC_DRAW);
        ATTRIBUTES.reduce((at, size, location) => {
            gl.enableVertexAttribArray(location);
            gl.vertexAttribPointer(location, size, gl.FLOAT, false, 4 * CORNER, 4 * at);
            return at + size;
        }, 0);
        gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
        gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
        gl.bindVertexArray(null);
        return { array, count: indices.length };
    }

    /** Throws an error for textures that the device does not support; they would be black. */
    refuseTooLarge({ dimension, size }) {
        const { gl } = this;
        const sides = dimension === '3d' ? size : size.slice(0, 2);
        const limits = { '3d': gl.MAX_3D_TEXTURE_SIZE, cube: gl.MAX_CUBE_MAP_TEXTURE_SIZE };
        const most = gl.getParameter(limits[dimension] ?? gl.MAX_TEXTURE_SIZE);
        const mostLayers = gl.getParameter(gl.MAX_ARRAY_TEXTURE_LAYERS);
        if (sides.some((side) => side > most) || (dimension === '2d-array' && size[2] > mostLayers)) {
            throw new Error(`found a texture of ${size.join(' x ')} texels, expected at most ${most} along a side and ${mostLayers} layers`);
        }
    }

    /** Uploads the resources of a material. */
    material(program, resources) {
        const { gl } = this;
        const bound = { program, blocks: [], textures: new Map() };
        const contentsOf = new Map(resources.map(({ binding, contents }) => [binding, contents]));
        for (const [binding, { kind, bytes }] of contentsOf) {
            if (kind === 'uniform' && program.points.has(binding)) {
                const buffer = gl.createBuffer();
                gl.bindBuffer(gl.UNIFORM_BUFFER, buffer);
                gl.bufferData(gl.UNIFORM_BUFFER, bytes, gl.STATIC_DRAW);
                bound.blocks.push({ binding, buffer });
            }
        }
        for (const { binding, sampler } of program.textures) {
            const contents = contentsOf.get(binding);
            this.refuseTooLarge(contents.texture);
            const repeats = contentsOf.get(sampler)?.repeats ?? false;
            const upload = () => uploadTexture(gl, contents.texture, sampler !== undefined, repeats);
            bound.textures.set(binding, once(this.textures, contents, upload));
        }
        program.check();
        return bound;
    }

    /** Sets the size of renderings. */
    resize(width, height) {
        const { gl } = this;
        for (const { texture, depth, frame } of this.targets.values()) {
            gl.deleteTexture(texture);
            gl.deleteRenderbuffer(depth);
            gl.deleteFramebuffer(frame);
        }
        this.targets.clear();
        this.drawn = [];
        this.size = [width, height];
    }

    /** Returns a render target, and creates it at first use. */
    target(key, format, samples, withDepth) {
        const { gl } = this;
        if (!this.targets.has(key)) {
            const size = this.size.map((side) => side * samples);
            const texture = gl.createTexture();
            gl.bindTexture(gl.TEXTURE_2D, texture);
            gl.texStorage2D(gl.TEXTURE_2D, 1, format, ...size);
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
            gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
            const frame = gl.createFramebuffer();
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
            const depth = withDepth ? gl.createRenderbuffer() : null;
            if (depth) {
                gl.bindRenderbuffer(gl.RENDERBUFFER, depth);
                gl.renderbufferStorage(gl.RENDERBUFFER, gl.DEPTH_COMPONENT32F, ...size);
                gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
            }
            this.targets.set(key, { texture, depth, frame });
        }
        return this.targets.get(key);
    }

    shown(which) {
        const { gl } = this;
        return this.target(which, which === BYTES ? gl.RGBA8 : gl.RGBA32F, 1, false).frame;
    }

    bindBlock(bytes) {
        const { gl } = this;
        gl.bindBuffer(gl.UNIFORM_BUFFER, this.block);
        gl.bufferData(gl.UNIFORM_BUFFER, bytes, gl.DYNAMIC_DRAW);
        gl.bindBufferBase(gl.UNIFORM_BUFFER, VIEW_POINT, this.block);
    }

    /** Draws a material on a mesh into a render target. */
    draw(which, material, mesh, block, samples) {
        const { gl } = this;
        this.drawn[which] = this.target(`rendering ${which} of ${samples}`, gl.RGBA32F, samples, true);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.drawn[which].frame);
        gl.viewport(0, 0, this.size[0] * samples, this.size[1] * samples);
        gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, 0]);
        gl.clearBufferfv(gl.DEPTH, 0, [0]);
        gl.enable(gl.DEPTH_TEST);
        gl.depthFunc(gl.GREATER);
        gl.useProgram(material.program.program);
        this.bindBlock(block);
        for (const { binding, buffer } of material.blocks) {
            gl.bindBufferBase(gl.UNIFORM_BUFFER, material.program.points.get(binding), buffer);
        }
        material.program.textures.forEach(({ binding }, unit) => {
            const { target, texture } = material.textures.get(binding);
            gl.activeTexture(gl.TEXTURE0 + unit);
            gl.bindTexture(target, texture);
        });
        gl.bindVertexArray(mesh.array);
        gl.drawElements(gl.TRIANGLES, mesh.count, gl.UNSIGNED_INT, 0);
        gl.bindVertexArray(null);
    }

    /** Shows the renderings on the canvas, or in render target `which`, on `size` pixels of it. */
    show(program, block, which, size = this.size) {
        const { gl } = this;
        gl.bindFramebuffer(gl.FRAMEBUFFER, which === undefined ? null : this.shown(which));
        gl.viewport(0, 0, ...size);
        gl.disable(gl.DEPTH_TEST);
        program.check();
        gl.useProgram(program.program);
        this.bindBlock(block);
        program.textures.forEach(({ binding }, unit) => {
            gl.activeTexture(gl.TEXTURE0 + unit);
            gl.bindTexture(gl.TEXTURE_2D, (this.drawn[binding - 1] ?? this.drawn[0]).texture);
        });
        gl.bindVertexArray(this.empty);
        gl.drawArrays(gl.TRIANGLES, 0, 3);
    }

    async finished() {
        const { gl } = this;
        gl.bindFramebuffer(gl.FRAMEBUFFER, null);
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    }

    /** Reads a rectangle of the displayed view, rows from the top. */
    async read(which, [x, y, width, height], [, rows] = this.size) {
        const { gl } = this;
        const bytes = which === BYTES;
        const found = bytes ? new Uint8ClampedArray(4 * width * height) : new Float32Array(4 * width * height);
        gl.bindFramebuffer(gl.FRAMEBUFFER, this.shown(which));
        gl.readPixels(x, rows - y - height, width, height, gl.RGBA, bytes ? gl.UNSIGNED_BYTE : gl.FLOAT, found);
        const turned = found.slice();
        for (let row = 0; row < height; row += 1) {
            turned.set(found.subarray(4 * width * row, 4 * width * (row + 1)), 4 * width * (height - 1 - row));
        }
        return turned;
    }
}
