import type { Pack } from './pack.js';
import { uploadTexture } from './upload_webgl.js';
import { widened } from './widened.js';

/** A pack in a WebGL 2 context. */
export interface WebGlPack {
    /** Binds its textures from this unit on and its blocks from this point on, for a program in use; says how many it took. */
    bind(program: WebGLProgram, firstUnit?: number, firstBlock?: number): { units: number; blocks: number };
    /** Frees what it holds. */
    dispose(): void;
}

/** Uploads a pack. Its shader, `pack.shader.essl300`, is to be pasted behind `#version 300 es`. */
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

/** Of each uniform block of a program, the name of the struct that it holds: that of a binding. */
function blockNames(gl: WebGL2RenderingContext, program: WebGLProgram): string[] {
    return Array.from({ length: gl.getProgramParameter(program, gl.ACTIVE_UNIFORM_BLOCKS) }, (_, index) => {
        const [member] = gl.getActiveUniformBlockParameter(program, index, gl.UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES);
        return gl.getActiveUniform(program, member)?.name.split('.')[0] ?? '';
    });
}
