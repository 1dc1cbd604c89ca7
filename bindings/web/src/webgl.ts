import type { Pack } from './pack.js';
import { uploadTexture } from './upload_webgl.js';
import { widened } from './widened.js';

/** A pack in a WebGL 2 context. */
export interface WebGlPack {
    /** Binds textures and blocks from these units on, for the program in use; returns the number of units used. */
    bind(program: WebGLProgram, firstUnit?: number, firstBlock?: number): { units: number; blocks: number };
    /** Frees its textures and buffers. */
    dispose(): void;
}

/** Uploads a pack. Paste its shader, `pack.shader.essl300`, after `#version 300 es`. */
export function uploadWebGl(gl: WebGL2RenderingContext, pack: Pack): WebGlPack {
    const buffers = new Map<string, WebGLBuffer>();
    const textures: { name: string; target: number; texture: WebGLTexture }[] = [];
    for (const resource of pack.resources) {
        if (resource.kind === 'uniform') {
            const buffer = gl.createBuffer();
            gl.bindBuffer(gl.UNIFORM_BUFFER, buffer);
            gl.bufferData(gl.UNIFORM_BUFFER, resource.bytes, gl.STATIC_DRAW);
            buffers.set(resource.name, buffer);
        } else if (resource.kind === 'texture') {
            const { name, texture, filtered, repeats } = resource;
            textures.push({ name, ...uploadTexture(gl, widened(texture), filtered, repeats) });
        }
    }
    const blocksOf = new WeakMap<WebGLProgram, { index: number; buffer: WebGLBuffer }[]>();
    return {
        bind(program, firstUnit = 0, firstBlock = 0) {
            const blocks = blocksOf.get(program) ?? blockNames(gl, program).flatMap((name, index) => {
                const buffer = buffers.get(name);
                return buffer ? [{ index, buffer }] : [];
            });
            blocksOf.set(program, blocks);
            blocks.forEach(({ index, buffer }, k) => {
                gl.uniformBlockBinding(program, index, firstBlock + k);
                gl.bindBufferBase(gl.UNIFORM_BUFFER, firstBlock + k, buffer);
            });
            textures.forEach(({ name, target, texture }, k) => {
                gl.activeTexture(gl.TEXTURE0 + firstUnit + k);
                gl.bindTexture(target, texture);
                gl.uniform1i(gl.getUniformLocation(program, name), firstUnit + k);
            });
            return { units: textures.length, blocks: blocks.length };
        },
        dispose() {
            buffers.forEach((buffer) => gl.deleteBuffer(buffer));
            textures.forEach(({ texture }) => gl.deleteTexture(texture));
        },
    };
}

/** Names of the structs in the uniform blocks of a program, which are those of the bindings. */
function blockNames(gl: WebGL2RenderingContext, program: WebGLProgram): string[] {
    return Array.from({ length: gl.getProgramParameter(program, gl.ACTIVE_UNIFORM_BLOCKS) }, (_, index) => {
        const [member] = gl.getActiveUniformBlockParameter(program, index, gl.UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES);
        return gl.getActiveUniform(program, member)?.name.split('.')[0] ?? '';
    });
}
