import * as THREE from 'three';
import type { TextureData } from './container.js';
import { isWide, type Pack, type Resource } from './pack.js';
import { fragmentShader, MAX_LIGHTS, VERTEX } from './three_shader.js';
import { GL_FORMATS, typed, uploadTexture } from './upload_webgl.js';

export { MAX_LIGHTS };

/** A light at a point: radiance falls with the square of the distance. */
export interface PointLight {
    position: THREE.Vector3;
    /** Radiant intensity, linear RGB. */
    intensity: THREE.Color;
}

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
                ? uploaded(gl, texture, filtered, repeats)
                : threeTexture(texture, filtered, repeats);
            uniforms[resource.name] = { value };
        }
    }
    return uniforms;
}

/** The decoder for a `ShaderMaterial` of GLSL 3, with structs as plain uniforms in place of blocks. */
export function packGlsl(pack: Pack): string {
    const block = /layout\(std140\) uniform \w+ \{ (\w+ \w+); \};/g;
    return pack.shader.essl300.replace(block, 'uniform $1;');
}

/**
 * A material that draws a pack under up to eight point lights: a BRDF (table or wavelet), a flat BTF, or a polynomial wavelet tree.
 * Geometries need tangents where the material is anisotropic, and uv where it is a flat BTF or a tree; `computeTangents` makes them.
 * Instances, batches, bones and morph targets are placed as by three.js' own materials.
 *
 * Radiance is linear: set `renderer.outputColorSpace` and tone mapping as for any other material. `dispose()` frees the pack's
 * textures, too.
 */
export function packMaterial(pack: Pack, renderer: THREE.WebGLRenderer, lights: PointLight[]): THREE.ShaderMaterial {
    checkLights(lights);
    const uniforms = packUniforms(pack, renderer);
    const material = new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        defines: { USE_TANGENT: '' },
        uniforms: {
            ...uniforms,
            lightCount: { value: lights.length },
            lightPositions: { value: padded(lights, ({ position }) => position, () => new THREE.Vector3()) },
            lightIntensities: { value: padded(lights, ({ intensity }) => intensity, () => new THREE.Color(0)) },
        },
        vertexShader: VERTEX,
        fragmentShader: fragmentShader(pack.decoder, packGlsl(pack), isWide(pack)),
    });
    let isFreed = false;
    let isTold = false;
    const needsTangents = pack.decoder === 'flat-btf' || (uniforms.table_brdf_parameters?.value.layers ?? 1) > 1;
    material.addEventListener('dispose', () => {
        isFreed = true;
        for (const { value } of Object.values(uniforms)) {
            if (value instanceof THREE.Texture) {
                value.dispose();
            }
        }
    });
    // As other materials, it is uploaded again where it is drawn after that.
    material.onBeforeRender = (_renderer, _scene, _camera, geometry) => {
        if (needsTangents && !isTold && !geometry.getAttribute('tangent')) {
            isTold = true;
            console.warn('brdfc: an anisotropic pack on a geometry without tangents: geometry.computeTangents()');
        }
        if (isFreed) {
            isFreed = false;
            for (const [name, { value }] of Object.entries(packUniforms(pack, renderer))) {
                uniforms[name].value = value;
            }
        }
    };
    return material;
}

function checkLights(lights: PointLight[]): void {
    if (!Array.isArray(lights) || lights.length > MAX_LIGHTS) {
        throw new Error(`lights: found ${Array.isArray(lights) ? lights.length : typeof lights}; allowed an array of up to ${MAX_LIGHTS}`);
    }
    lights.forEach(({ position, intensity }, k) => {
        if (!position?.isVector3 || !intensity?.isColor) {
            const wrong = position?.isVector3 ? `intensity: found a ${typeof intensity}; allowed a Color` : 'position: found none; allowed a Vector3';
            throw new Error(`lights[${k}].${wrong}`);
        }
    });
}

function padded<T>(lights: PointLight[], of: (light: PointLight) => T, none: () => T): T[] {
    return Array.from({ length: MAX_LIGHTS }, (_, k) => (lights[k] ? of(lights[k]) : none()));
}

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

/** An array with mipmaps, which three.js does not upload itself. */
function uploaded(gl: WebGL2RenderingContext, data: TextureData, filtered: boolean, repeats: boolean): THREE.Texture {
    const { texture } = uploadTexture(gl, data, filtered, repeats);
    const external = new THREE.ExternalTexture(texture);
    external.addEventListener('dispose', () => gl.deleteTexture(texture));
    return external;
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
