import type { Pack } from './pack.js';
import { uploadTexture } from './upload_webgl.js';

/** A pack in a WebGL 2 context. */
export interface WebGlPack {
    /** Binds its textures from this unit on and its blocks from this point on, for a program in use; says how many it took. */
    bind(program: WebGLProgram, firstUnit?: number, firstBlock?: number): { units: number; blocks: number };
    /** Frees what it holds. */
    dispose(): void;
}

/** Uploads a pack. Its shader, `pack.shader.essl300`, is to be pasted behind `#version 300 es`. */
export function uploadWebGl(gl: WebGL2RenderingContext, pack: Pack): WebGlPack {
    const blocks: { block: string; buffer: WebGLBuffer }[] = [];
    const textures: { name: string; target: number; texture: WebGLTexture }[] = [];
    for (const resource of pack.resources) {
        if (resource.kind === 'uniform') {
            const buffer = gl.createBuffer();
            gl.bindBuffer(gl.UNIFORM_BUFFER, buffer);
            gl.bufferData(gl.UNIFORM_BUFFER, resource.bytes, gl.STATIC_DRAW);
            const declared = pack.shader.bindings.find(({ binding }) => binding === resource.binding);
            blocks.push({ block: `${declared?.block}Block`, buffer });
        } else if (resource.kind === 'texture') {
            const { texture: data, filtered, repeats } = resource;
            textures.push({ name: resource.name, ...uploadTexture(gl, data, filtered, repeats) });
        }
    }
    return {
        bind(program, firstUnit = 0, firstBlock = 0) {
            blocks.forEach(({ block, buffer }, k) => {
                const index = gl.getUniformBlockIndex(program, block);
                if (index !== gl.INVALID_INDEX) {
                    gl.uniformBlockBinding(program, index, firstBlock + k);
                    gl.bindBufferBase(gl.UNIFORM_BUFFER, firstBlock + k, buffer);
                }
            });
            textures.forEach(({ name, target, texture }, k) => {
                gl.activeTexture(gl.TEXTURE0 + firstUnit + k);
                gl.bindTexture(target, texture);
                gl.uniform1i(gl.getUniformLocation(program, name), firstUnit + k);
            });
            return { units: textures.length, blocks: blocks.length };
        },
        dispose() {
            blocks.forEach(({ buffer }) => gl.deleteBuffer(buffer));
            textures.forEach(({ texture }) => gl.deleteTexture(texture));
        },
    };
}
