/**
 * Packs of measured appearance in a browser.
 *
 * `loadPack` and `loadFlatBtf` read what `brdfc` writes; a pack says what to bind and brings its decoder in GLSL ES 3.00 and in
 * WGSL. `uploadWebGl` and `uploadWebGpu` bind it; `brdfc/three` makes materials for three.js.
 */
export { type Container, readContainer, type TexelFormat, type TextureData } from './container.js';
export { type Contents, loadFlatBtf, loadPack, type Options, type Pack, type Resource } from './pack.js';
export { type DecoderName, type DecoderShader, SHADERS } from './shaders.js';
export { uploadWebGl, type WebGlPack } from './webgl.js';
export { uploadWebGpu, type WebGpuPack } from './webgpu.js';
