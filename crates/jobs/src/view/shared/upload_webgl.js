// Textures of packs in WebGL 2, for the web package and the pages of 'brdfc view'.

import { levelSize } from './levels.js';

/** @typedef {import('./container.js').TextureData} TextureData */

/**
 * Internal format, format and type of texels, as names of WebGL constants.
 *
 * @type {Partial<Record<TextureData['format'], readonly [string, string, string]>>}
 */
export const GL_FORMATS = {
    r8unorm: ['R8', 'RED', 'UNSIGNED_BYTE'],
    rg8unorm: ['RG8', 'RG', 'UNSIGNED_BYTE'],
    rgba8unorm: ['RGBA8', 'RGBA', 'UNSIGNED_BYTE'],
    rgb10a2unorm: ['RGB10_A2', 'RGBA', 'UNSIGNED_INT_2_10_10_10_REV'],
    r16float: ['R16F', 'RED', 'HALF_FLOAT'],
    rgba16float: ['RGBA16F', 'RGBA', 'HALF_FLOAT'],
    r32uint: ['R32UI', 'RED_INTEGER', 'UNSIGNED_INT'],
    rg16float: ['RG16F', 'RG', 'HALF_FLOAT'],
    rgba32uint: ['RGBA32UI', 'RGBA_INTEGER', 'UNSIGNED_INT'],
    rgba32float: ['RGBA32F', 'RGBA', 'FLOAT'],
    rgb9e5ufloat: ['RGB9_E5', 'RGB', 'UNSIGNED_INT_5_9_9_9_REV'],
};

/**
 * Views texels as the typed array that WebGL expects for their type.
 *
 * @param {TextureData} data
 * @param {number} level
 * @returns {Uint8Array<ArrayBuffer> | Uint16Array<ArrayBuffer> | Uint32Array<ArrayBuffer> | Float32Array<ArrayBuffer>}
 */
export function typed(data, level) {
    const bytes = data.levels[level].buffer;
    switch (GL_FORMATS[data.format]?.[2]) {
        case 'UNSIGNED_BYTE': return new Uint8Array(bytes);
        case 'HALF_FLOAT': return new Uint16Array(bytes);
        case 'FLOAT': return new Float32Array(bytes);
        default: return new Uint32Array(bytes);
    }
}

/** Pixel storage parameters and their values for these textures. WebGL does not allow flipping for arrays. */
const UNPACKING = /** @type {const} */ ([
    ['UNPACK_FLIP_Y_WEBGL', false],
    ['UNPACK_PREMULTIPLY_ALPHA_WEBGL', false],
    ['UNPACK_ALIGNMENT', 1],
    ['UNPACK_ROW_LENGTH', 0],
    ['UNPACK_IMAGE_HEIGHT', 0],
    ['UNPACK_SKIP_PIXELS', 0],
    ['UNPACK_SKIP_ROWS', 0],
    ['UNPACK_SKIP_IMAGES', 0],
]);
const BOUND = {
    '2d': 'TEXTURE_BINDING_2D',
    '2d-array': 'TEXTURE_BINDING_2D_ARRAY',
    '3d': 'TEXTURE_BINDING_3D',
    cube: 'TEXTURE_BINDING_CUBE_MAP',
};

/**
 * Uploads one texture with its mipmap levels. Restores the state of the context, which other code uses, too.
 *
 * @param {WebGL2RenderingContext} gl
 * @param {TextureData} data
 * @param {boolean} filtered true if a sampler filters it
 * @param {boolean} repeats true if its coordinates repeat, false if they are clamped to the edge
 * @returns {{ target: number, texture: WebGLTexture }}
 */
export function uploadTexture(gl, data, filtered, repeats) {
    const names = GL_FORMATS[data.format];
    if (names === undefined) {
        throw new Error(`found texel format ${data.format}, expected one that WebGL 2 supports`);
    }
    const constants = /** @type {Record<string, number>} */ (/** @type {unknown} */ (gl));
    const [internal, format, type] = names.map((name) => constants[name]);
    const targets = { '2d': gl.TEXTURE_2D, '2d-array': gl.TEXTURE_2D_ARRAY, '3d': gl.TEXTURE_3D, cube: gl.TEXTURE_CUBE_MAP };
    const target = targets[data.dimension];
    const isFlat = data.dimension === '2d' || data.dimension === 'cube';
    const firstFace = data.dimension === 'cube' ? gl.TEXTURE_CUBE_MAP_POSITIVE_X : target;
    const texture = gl.createTexture();
    const before = {
        texture: gl.getParameter(constants[BOUND[data.dimension]]),
        buffer: gl.getParameter(gl.PIXEL_UNPACK_BUFFER_BINDING),
        unpacking: UNPACKING.map(([name]) => gl.getParameter(constants[name])),
    };
    gl.bindTexture(target, texture);
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, null);
    UNPACKING.forEach(([name, value]) => gl.pixelStorei(constants[name], value));
    const [columns, rows] = data.size;
    if (isFlat) {
        gl.texStorage2D(target, data.levels.length, internal, columns, rows);
    } else {
        gl.texStorage3D(target, data.levels.length, internal, ...data.size);
    }
    data.levels.forEach((_, level) => {
        const [width, height, depth] = levelSize(data, level);
        const numbers = typed(data, level);
        if (!isFlat) {
            gl.texSubImage3D(target, level, 0, 0, 0, width, height, depth, format, type, numbers);
            return;
        }
        for (let face = 0; face < depth; face += 1) {
            const first = (face * numbers.length) / depth;
            gl.texSubImage2D(firstFace + face, level, 0, 0, width, height, format, type, numbers, first);
        }
    });
    // Samplers filter neither integers nor, without an extension, 32-bit floats; shaders do not rely on it.
    const linear = filtered && !data.format.endsWith('32float');
    const mipmaps = data.levels.length > 1;
    const small = linear ? (mipmaps ? gl.LINEAR_MIPMAP_LINEAR : gl.LINEAR) : mipmaps ? gl.NEAREST_MIPMAP_NEAREST : gl.NEAREST;
    gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, small);
    gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, linear ? gl.LINEAR : gl.NEAREST);
    for (const axis of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T, gl.TEXTURE_WRAP_R]) {
        gl.texParameteri(target, axis, repeats ? gl.REPEAT : gl.CLAMP_TO_EDGE);
    }
    UNPACKING.forEach(([name], k) => gl.pixelStorei(constants[name], before.unpacking[k]));
    gl.bindBuffer(gl.PIXEL_UNPACK_BUFFER, before.buffer);
    gl.bindTexture(target, before.texture);
    return { target, texture };
}
