import * as THREE from 'three';
import type { Pack, Resource } from './pack.js';
import { refuse, refuseProblem } from './refuse.js';
import { fragmentShader, MAX_LIGHTS, needsTangents, parts, VERTEX } from './three_shader.js';
import { uploadTexture } from './upload_webgl.js';
import { isWide, widened } from './widened.js';

export { MAX_LIGHTS };

/** A point light: irradiance falls with the square of the distance. */
export interface PointLight {
    position: THREE.Vector3;
    /** Radiant intensity, linear RGB. */
    intensity: THREE.Color;
}

/** Bindings of a pack for the constructor of a `ShaderMaterial` of GLSL 3 whose shader contains the decoder. */
export interface PackBindings {
    /** Textures. */
    uniforms: Record<string, THREE.IUniform<THREE.ExternalTexture>>;
    /** Uniform blocks. */
    uniformsGroups: THREE.UniformsGroup[];
}

/** Uploads the textures of a pack to the renderer's context, and makes groups of its uniform blocks. */
export function packBindings(pack: Pack, renderer: THREE.WebGLRenderer): PackBindings {
    const uniforms: PackBindings['uniforms'] = {};
    const uniformsGroups: THREE.UniformsGroup[] = [];
    const blocks = new Map([...glsl(pack).matchAll(/uniform (\w+) \{ \w+ (\w+); \}/g)].map(([, block, name]) => [name, block]));
    for (const resource of pack.resources) {
        const block = blocks.get(resource.name);
        if (resource.kind === 'texture') {
            uniforms[resource.name] = { value: uploaded(renderer, resource) };
        } else if (resource.kind === 'uniform' && block !== undefined) {
            // As integers, because three.js preserves their bits.
            const words = Object.assign(new THREE.Uniform(new Uint32Array(resource.bytes.buffer)), { type: 'uint' });
            uniformsGroups.push(new THREE.UniformsGroup().setName(block).add(words));
        }
    }
    return { uniforms, uniformsGroups };
}

function glsl({ decoder, shader }: Pack): string {
    return shader?.essl300 ?? refuseProblem('pack', `no shader for the decoder ${decoder}`, 'a decoder of this package, or a shader in the options of loadPack');
}

/** A texture of the renderer's context, which three.js uses unchanged. */
function uploaded(renderer: THREE.WebGLRenderer, { texture: data, filtered, repeats }: Resource & { kind: 'texture' }): THREE.ExternalTexture {
    const gl = renderer.getContext() as WebGL2RenderingContext;
    const { texture } = uploadTexture(gl, widened(data), filtered, repeats);
    const external = new THREE.ExternalTexture(texture);
    // three.js ignores the source of 3D textures and cube maps.
    held(renderer, external).__webglTexture = texture;
    external.addEventListener('dispose', () => {
        renderer.properties.remove(external);
        gl.deleteTexture(texture);
    });
    return external;
}

/** Properties that three.js stores for a texture; empty after it was freed or the context was lost. */
function held(renderer: THREE.WebGLRenderer, texture: THREE.Texture): { __webglTexture?: WebGLTexture } {
    return renderer.properties.get(texture) as { __webglTexture?: WebGLTexture };
}

/**
 * A material that draws packs: a BRDF (table or wavelet), a flat BTF or a polynomial wavelet tree under up to eight point lights, lobes
 * and a prefiltered environment, or both. `scene.environmentRotation` turns the environment, and `scene.environmentIntensity` scales it.
 * Geometries need tangents for anisotropic materials, and uv for flat BTFs and trees; `computeTangents` makes tangents.
 * Instances, batches, bones and morph targets are supported as by three.js' own materials.
 *
 * Radiance is linear: set `renderer.outputColorSpace` and tone mapping as for any other material. `dispose()` also frees the
 * packs' textures.
 */
export function packMaterial(packs: Pack | Pack[], renderer: THREE.WebGLRenderer, lights: PointLight[] = []): THREE.ShaderMaterial {
    checkLights(lights);
    const all = [packs].flat();
    const found = parts(all);
    if (found.surface === undefined && lights.length > 0) {
        refuse('material', 'point lights without a pack for them', 'a BRDF, a flat BTF or a polynomial wavelet tree besides lobes');
    }
    const fragment = fragmentShader(found, all.map(glsl).join('\n'), found.surface !== undefined && isWide(found.surface, true));
    const bindings = () => all.map((pack) => packBindings(pack, renderer));
    const made = bindings();
    const uniforms: PackBindings['uniforms'] = Object.assign({}, ...made.map(({ uniforms }) => uniforms));
    const uniformsGroups = made.flatMap(({ uniformsGroups }) => uniformsGroups);
    const turn = { value: new THREE.Matrix3() };
    const intensity = { value: 1 };
    const material = new THREE.ShaderMaterial({
        glslVersion: THREE.GLSL3,
        defines: { USE_TANGENT: '' },
        uniforms: {
            ...uniforms,
            lightCount: { value: lights.length },
            lightPositions: { value: padded(lights, ({ position }) => position, () => new THREE.Vector3()) },
            lightIntensities: { value: padded(lights, ({ intensity }) => intensity, () => new THREE.Color(0)) },
            environmentTurn: turn,
            environmentIntensity: intensity,
        },
        uniformsGroups,
        vertexShader: VERTEX,
        fragmentShader: fragment,
    });
    let hasWarned = false;
    const isAnisotropic = all.some(needsTangents);
    const rotation = new THREE.Matrix4();
    material.addEventListener('dispose', () => {
        Object.values(uniforms).forEach(({ value }) => value.dispose());
        uniformsGroups.forEach((group) => group.dispose());
    });
    // Like other materials, it is uploaded again if it is drawn after that, or after its context was lost.
    material.onBeforeRender = (_renderer, scene, _camera, geometry) => {
        if (isAnisotropic && !hasWarned && !geometry.getAttribute('tangent')) {
            hasWarned = true;
            console.warn('brdfc: an anisotropic pack on a geometry without tangents: geometry.computeTangents()');
        }
        if (found.environment !== undefined && scene instanceof THREE.Scene) {
            // From the world to the environment. The middle of an image is at +x for three.js, and at -x for brdfc.
            turn.value.setFromMatrix4(rotation.makeRotationFromEuler(scene.environmentRotation)).transpose().premultiply(HALF_TURN);
            intensity.value = scene.environmentIntensity;
            material.uniformsNeedUpdate = true;
        }
        if (Object.values(uniforms).some(({ value }) => held(renderer, value).__webglTexture === undefined)) {
            for (const [name, { value }] of bindings().flatMap(({ uniforms }) => Object.entries(uniforms))) {
                uniforms[name].value = value;
            }
        }
    };
    return material;
}

/** Half a turn about y. */
const HALF_TURN = new THREE.Matrix3(-1, 0, 0, 0, 1, 0, 0, 0, -1);

function checkLights(lights: PointLight[]): void {
    if (!Array.isArray(lights) || lights.length > MAX_LIGHTS) {
        throw new Error(`lights: found ${Array.isArray(lights) ? lights.length : typeof lights}, expected an array of up to ${MAX_LIGHTS}`);
    }
    lights.forEach(({ position, intensity }, k) => {
        if (!position?.isVector3 || !intensity?.isColor) {
            const wrong = position?.isVector3 ? 'intensity: not a Color' : 'position: not a Vector3';
            throw new Error(`lights[${k}].${wrong}`);
        }
    });
}

function padded<T>(lights: PointLight[], of: (light: PointLight) => T, none: () => T): T[] {
    return Array.from({ length: MAX_LIGHTS }, (_, k) => (lights[k] ? of(lights[k]) : none()));
}
