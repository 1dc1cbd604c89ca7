// Decodes the data in the page.

import { levelSize } from '../shared/levels.js';

/**
 * Decodes Base64 and decompresses with zlib.
 *
 * @param {string} text
 * @returns {Promise<Uint8Array<ArrayBuffer>>}
 */
export async function unpacked(text) {
    const letters = atob(text);
    const bytes = new Uint8Array(letters.length);
    for (let k = 0; k < letters.length; k += 1) {
        bytes[k] = letters.charCodeAt(k);
    }
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
    return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Returns what is known by a key, or makes it. */
export function once(known, key, make) {
    if (!known.has(key)) {
        known.set(key, make());
    }
    return known.get(key);
}

/** Numbers of the attributes of a corner: position, normal, tangent, uv, height above its surface, distance from its border. */
export const ATTRIBUTES = [3, 3, 3, 2, 1, 1];
/** Numbers of a corner. */
export const CORNER = 13;
/** Streams of a corner: position, uv, height, distance, and two octahedral coordinates of normal and tangent each. */
const [NORMAL, TANGENT, STREAMS] = [7, 9, 11];

/**
 * Decodes a mesh from its streams of numbers, each stored as the residual of a linear prediction from the two before it.
 *
 * @param {{ vertices: number, triangles: number, low: number[], span: number[], largest: number[], corners: string, indices: string }} mesh
 * @returns {Promise<{ corners: Float32Array<ArrayBuffer>, indices: Uint32Array<ArrayBuffer> }>}
 */
export async function meshOf({ vertices, triangles, low, span, largest, corners, indices }) {
    const [bytes, steps] = await Promise.all([unpacked(corners), unpacked(indices)]);
    const whole = new Float32Array(CORNER * vertices);
    const numbers = Array.from({ length: STREAMS }, (_, stream) => {
        const [from, found] = [2 * vertices * stream, new Uint16Array(vertices)];
        for (let k = 0, [before, last] = [0, 0]; k < vertices; k += 1) {
            const residual = bytes[from + k] | (bytes[from + vertices + k] << 8);
            const guess = k > 1 ? 2 * last - before : last;
            found[k] = guess + ((residual >> 1) ^ -(residual & 1));
            [before, last] = [last, found[k]];
        }
        return found;
    });
    const vector = (first, k) => octahedral(...[first, first + 1].map((stream) => (2 * numbers[stream][k]) / largest[stream] - 1));
    for (let k = 0; k < vertices; k += 1) {
        const place = [0, 1, 2, 3, 4, 5, 6].map((axis) => low[axis] + (span[axis] * numbers[axis][k]) / largest[axis]);
        whole.set([...place.slice(0, 3), ...vector(NORMAL, k), ...vector(TANGENT, k), ...place.slice(3)], CORNER * k);
    }
    const found = new Uint32Array(3 * triangles);
    const view = new DataView(steps.buffer);
    for (let k = 0; k < found.length; k += 1) {
        found[k] = (k > 2 ? found[k - 3] : 0) + view.getInt32(4 * k, true);
    }
    return { corners: whole, indices: found };
}

/** Decodes a unit vector from its octahedral coordinates. */
function octahedral(x, y) {
    const z = 1 - Math.abs(x) - Math.abs(y);
    const fold = Math.max(-z, 0);
    const v = [x + (x >= 0 ? -fold : fold), y + (y >= 0 ? -fold : fold), z];
    const length = Math.hypot(...v);
    return v.map((c) => c / length);
}

/** Decodes the contents of a resource, in the form of the web package: a uniform block, a texture or a sampler. */
export async function contentsOf(resource) {
    const { kind } = resource;
    if (kind === 'sampler') {
        return { kind, repeats: resource.repeats };
    }
    const bytes = await unpacked(resource.data);
    if (kind === 'uniform') {
        return { kind, bytes };
    }
    const { format, dimension, size, texelBytes, levels } = resource;
    const all = [];
    for (let level = 0, at = 0; level < levels; level += 1) {
        const length = levelSize({ dimension, size }, level).reduce((product, side) => product * side, texelBytes);
        all.push(bytes.slice(at, at + length));
        at += length;
    }
    return { kind, texture: { format, dimension, size, texelBytes, levels: all } };
}
