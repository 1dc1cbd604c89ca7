// Mipmap levels of textures, for the web package and the pages of 'brdfc view'.

/**
 * Columns, rows, and slices, layers or faces of a level, 0 the finest. All levels have the same number of layers or faces.
 *
 * @param {Pick<import('./container.js').TextureData, 'dimension' | 'size'>} texture
 * @param {number} level
 * @returns {[number, number, number]}
 */
export function levelSize({ dimension, size: [width, height, depth] }, level) {
    const side = (/** @type {number} */ finest) => Math.max(finest >> level, 1);
    return [side(width), side(height), dimension === '3d' ? side(depth) : depth];
}
