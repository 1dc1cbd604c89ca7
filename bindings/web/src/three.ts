import * as THREE from 'three';
import type { TextureData } from './container.js';
import type { Pack, Resource } from './pack.js';
import { GL_FORMATS, typed, uploadTexture } from './upload_webgl.js';

/** A light at a point: radiance falls with the square of the distance. */
export interface PointLight {
    position: THREE.Vector3;
    /** Radiant intensity, linear RGB. */
    intensity: THREE.Color;
}

/** Most lights of a material. */
export const MAX_LIGHTS = 8;

/**
 * What the shader reads of a pack's textures and blocks, as uniforms of three.js. Arrays with mipmaps, which three.js does not
 * upload, are uploaded to the renderer's context here.
 */
export function packUniforms(pack: Pack, renderer: THREE.WebGLRenderer): Record<string, THREE.IUniform> {
    const gl = renderer.getContext() as WebGL2RenderingContext;
    const uniforms: Record<string, THREE.IUniform> = {};
    for (const resource of pack.resources) {
        if (resource.kind === 'uniform') {
            uniforms[resource.name] = { value: fields(pack, resource) };
        } else if (resource.kind === 'texture') {
            const { texture, filtered, repeats } = resource;
            const value = texture.dimension === '2d-array'
                ? new THREE.ExternalTexture(uploadTexture(gl, texture, filtered, repeats).texture)
                : threeTexture(texture, filtered, repeats);
            uniforms[resource.name] = { value };
        }
    }
    // What it believes to be bound is no longer.
    renderer.resetState();
    return uniforms;
}

/** The decoder for a `ShaderMaterial` of GLSL 3, with structs as plain uniforms in place of blocks. */
export function packGlsl(pack: Pack): string {
    const block = /layout\(std140\) uniform \w+ \{ (\w+ \w+); \};/g;
    return pack.shader.essl300.replace(block, 'uniform $1;');
}

/**
 * A material that draws a BRDF pack (table or wavelet) or a flat BTF under up to eight point lights. Geometries need tangents where
 * the material is anisotropic, and uv where it is a flat BTF; `computeTangents` makes them.
 *
 * Radiance is linear: set `renderer.outputColorSpace` and tone mapping as for any other material.
 */
export function packMaterial(pack: Pack, renderer: THREE.WebGLRenderer, lights: PointLight[]): THREE.ShaderMaterial {
    const value = VALUES[pack.decoder];
    if (value === undefined) {
        throw new Error(`found ${pack.decoder}; allowed a table, a wavelet pack or a flat BTF`);
    }
    return new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        uniforms: {
            ...packUniforms(pack, renderer),
            lightCount: { value: Math.min(lights.length, MAX_LIGHTS) },
            lightPositions: { value: padded(lights, ({ position }) => position, () => new THREE.Vector3()) },
            lightIntensities: { value: padded(lights, ({ intensity }) => intensity, () => new THREE.Color(0)) },
        },
        vertexShader: VERTEX,
        fragmentShader: packGlsl(pack) + value + FRAGMENT,
    });
}

function padded<T>(lights: PointLight[], of: (light: PointLight) => T, none: () => T): T[] {
    return Array.from({ length: MAX_LIGHTS }, (_, k) => (lights[k] ? of(lights[k]) : none()));
}

/** Reflected radiance over irradiance from one direction, with the cosine. */
const VALUES: Partial<Record<Pack['decoder'], string>> = {
    table: `
vec3 reflected(vec3 wi, vec3 wo, vec2 uv, float level) {
    return table_brdf(wi, wo) * wi.z;
}
`,
    wavelet: `
vec3 reflected(vec3 wi, vec3 wo, vec2 uv, float level) {
    return wavelet_brdf(wi, wo, float(wavelet_brdf_parameters.levels)) * wi.z;
}
`,
    'flat-btf': `
vec3 reflected(vec3 wi, vec3 wo, vec2 uv, float level) {
    return flat_btf_value(uv, level, wo, wi) * 0.318309886;
}
#define LEVEL(uv) factored_mipmap_level(dFdx(uv), dFdy(uv))
`,
};

const VERTEX = `
in vec4 tangent;
out vec3 worldPosition;
out vec3 worldNormal;
out vec4 worldTangent;
out vec2 surfaceUv;
void main() {
    vec4 world = modelMatrix * vec4(position, 1.0);
    worldPosition = world.xyz;
    worldNormal = mat3(modelMatrix) * normal;
    worldTangent = vec4(mat3(modelMatrix) * tangent.xyz, tangent.w);
    surfaceUv = uv;
    gl_Position = projectionMatrix * viewMatrix * world;
}
`;

const FRAGMENT = `
#ifndef LEVEL
#define LEVEL(uv) 0.0
#endif
uniform int lightCount;
uniform vec3 lightPositions[${MAX_LIGHTS}];
uniform vec3 lightIntensities[${MAX_LIGHTS}];
in vec3 worldPosition;
in vec3 worldNormal;
in vec4 worldTangent;
in vec2 surfaceUv;
out vec4 colour;
void main() {
    float level = LEVEL(surfaceUv);
    vec3 toEye = normalize(cameraPosition - worldPosition);
    vec3 n = normalize(worldNormal);
    // Normals of smooth meshes turn away from the viewer at outlines, where nothing has a value.
    float facing = dot(n, toEye);
    n = facing < 0.02 ? normalize(n + toEye * (0.02 - facing)) : n;
    vec3 t = worldTangent.xyz - n * dot(n, worldTangent.xyz);
    t = dot(t, t) > 1e-12 ? normalize(t) : normalize(abs(n.z) < 0.9 ? cross(vec3(0.0, 0.0, 1.0), n) : vec3(1.0, 0.0, 0.0));
    vec3 b = cross(n, t) * (worldTangent.w < 0.0 ? -1.0 : 1.0);
    vec3 wo = vec3(dot(toEye, t), dot(toEye, b), dot(toEye, n));
    vec3 radiance = vec3(0.0);
    for (int k = 0; k < lightCount; k++) {
        vec3 toLight = lightPositions[k] - worldPosition;
        float squared = dot(toLight, toLight);
        vec3 l = toLight * inversesqrt(squared);
        vec3 wi = vec3(dot(l, t), dot(l, b), dot(l, n));
        if (wi.z > 0.0 && wo.z > 0.0) {
            radiance += reflected(wi, wo, surfaceUv, level) * lightIntensities[k] / squared;
        }
    }
#ifdef TONE_MAPPING
    radiance = toneMapping(radiance);
#endif
    colour = linearToOutputTexel(vec4(radiance, 1.0));
}
`;

/** A uniform block as an object of its fields. */
function fields(pack: Pack, resource: Resource & { kind: 'uniform' }): Record<string, unknown> {
    const { bytes } = resource;
    const view = new DataView(bytes.buffer);
    const declared = pack.shader.bindings.find(({ binding }) => binding === resource.binding)?.fields ?? [];
    const vectors = (offset: number, count: number) =>
        Array.from({ length: count }, (_, k) => new THREE.Vector4().fromArray(new Float32Array(bytes.buffer, offset + 16 * k, 4)));
    const value = (type: string, offset: number): unknown => {
        const list = /^array<vec4<f32>, (\d+)>$/.exec(type);
        if (list) {
            return vectors(offset, Number(list[1]));
        }
        switch (type) {
            case 'u32': return view.getUint32(offset, true);
            case 'f32': return view.getFloat32(offset, true);
            case 'vec2<f32>': return new THREE.Vector2().fromArray(new Float32Array(bytes.buffer, offset, 2));
            case 'vec3<f32>': return new THREE.Vector3().fromArray(new Float32Array(bytes.buffer, offset, 3));
            case 'vec4<u32>': return new Uint32Array(bytes.buffer, offset, 4);
            default: throw new Error(`found a field of ${type}; allowed numbers, vectors and arrays of four floats`);
        }
    };
    return Object.fromEntries(declared.map(({ name, type, offset }) => [name, value(type, offset)]));
}

function threeTexture(data: TextureData, filtered: boolean, repeats: boolean): THREE.Texture {
    const names = GL_FORMATS[data.format];
    if (names === undefined) {
        throw new Error(`found texels of ${data.format}; allowed what WebGL 2 has`);
    }
    const [width, height, depth] = data.size;
    const [internal, format, type] = names;
    const texels = typed(data, 0) as BufferSource;
    const texture: THREE.Texture = data.dimension === '3d'
        ? new THREE.Data3DTexture(texels as never, width, height, depth)
        : new THREE.DataTexture(texels as never, width, height);
    // Names that three.js does not know are looked up in the context.
    texture.internalFormat = internal as THREE.PixelFormatGPU;
    texture.format = (FORMATS[format] ?? format) as THREE.PixelFormat;
    texture.type = (TYPES[type] ?? type) as THREE.TextureDataType;
    const linear = filtered && data.format !== 'rgba32float';
    texture.magFilter = linear ? THREE.LinearFilter : THREE.NearestFilter;
    texture.minFilter = linear ? THREE.LinearFilter : THREE.NearestFilter;
    texture.wrapS = repeats ? THREE.RepeatWrapping : THREE.ClampToEdgeWrapping;
    texture.wrapT = texture.wrapS;
    texture.generateMipmaps = false;
    texture.unpackAlignment = 1;
    texture.needsUpdate = true;
    return texture;
}

const FORMATS: Record<string, THREE.PixelFormat> = {
    RED: THREE.RedFormat,
    RG: THREE.RGFormat,
    RGB: THREE.RGBFormat,
    RGBA: THREE.RGBAFormat,
    RED_INTEGER: THREE.RedIntegerFormat,
    RGBA_INTEGER: THREE.RGBAIntegerFormat,
};

const TYPES: Record<string, THREE.TextureDataType> = {
    UNSIGNED_BYTE: THREE.UnsignedByteType,
    HALF_FLOAT: THREE.HalfFloatType,
    FLOAT: THREE.FloatType,
    UNSIGNED_INT: THREE.UnsignedIntType,
    UNSIGNED_INT_5_9_9_9_REV: THREE.UnsignedInt5999Type,
};
