/**
 * Packs of measured appearance in a browser.
 *
 * `loadPack` reads packs of `brdfc`. A pack lists its own bindings, and this package contains the decoders in GLSL ES 3.00 and
 * in WGSL. `uploadWebGl` and `uploadWebGpu` upload and bind it; `brdfc/three` makes materials for three.js.
 */
export { type Container, readContainer, type Shape, type TexelFormat, type TextureData } from './container.js';
export type { FrameOptions } from './frame.js';
export { type Contents, loadPack, type Options, type Pack, type Resource, type Shader } from './pack.js';
export { type DecoderName, type DecoderShader, SHADERS } from './shaders.js';
export { uploadWebGl, type WebGlPack } from './webgl.js';
export { uploadWebGpu, type WebGpuPack } from './webgpu.js';
