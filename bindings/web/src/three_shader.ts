// Shaders of the material for three.js: chunks of three.js place the vertices, and the decoder of the pack computes reflection.

import type { Pack } from './pack.js';
import { refuse } from './refuse.js';
import type { DecoderShader } from './shaders.js';

type Brdf = NonNullable<DecoderShader['brdf']>;

/** Maximum number of lights of a material. */
export const MAX_LIGHTS = 8;

/** `reflected` (radiance over irradiance from one direction, with the cosine) and the level of detail, for decoders of surfaces. */
const SURFACES: Record<string, string> = {
    // On the back v is negated, so that it follows the bitangent there, too.
    'flat-btf': `
float levelAt(float distance) {
    return factored_mipmap_level(dFdx(surfaceUv), dFdy(surfaceUv));
}
vec3 reflected(vec3 wi, vec3 wo, float level) {
    return flat_btf_value(vec2(surfaceUv.x, gl_FrontFacing ? surfaceUv.y : -surfaceUv.y), level, wo, wi) * 0.318309886;
}
`,
    'flat-btf-trees': `
float levelAt(float distance) {
    return flat_trees_mipmap_level(dFdx(surfaceUv), dFdy(surfaceUv));
}
vec3 reflected(vec3 wi, vec3 wo, float level) {
    return flat_trees_value(vec2(surfaceUv.x, gl_FrontFacing ? surfaceUv.y : -surfaceUv.y), level, wo, wi) * 0.318309886;
}
`,
    // Rows of a rendering go down, v goes up.
    pwt: `
float levelAt(float distance) {
    return pwt_mipmap_level(dFdx(surfaceUv), dFdy(surfaceUv));
}
vec3 reflected(vec3 wi, vec3 wo, float level) {
    return pwt_value(vec2(surfaceUv.x, gl_FrontFacing ? 1.0 - surfaceUv.y : surfaceUv.y), level, wo, wi) * 0.318309886;
}
`,
};

/** Inputs from the vertex shader, before the decoder. */
const VARYINGS = `
in vec3 worldPosition;
in vec3 worldNormal;
in vec4 worldTangent;
in vec2 surfaceUv;
`;

// USE_TANGENT is defined: three.js declares and moves them.
export const VERTEX = `
#include <common>
#include <batching_pars_vertex>
#include <morphtarget_pars_vertex>
#include <skinning_pars_vertex>
#include <logdepthbuf_pars_vertex>
out vec3 worldPosition;
out vec3 worldNormal;
out vec4 worldTangent;
out vec2 surfaceUv;
void main() {
    #include <morphinstance_vertex>
    #include <morphcolor_vertex>
    #include <batching_vertex>
    #include <beginnormal_vertex>
    #include <morphnormal_vertex>
    #include <skinbase_vertex>
    #include <skinnormal_vertex>
    #include <begin_vertex>
    #include <morphtarget_vertex>
    #include <skinning_vertex>
    mat4 model = modelMatrix;
    #ifdef USE_BATCHING
        model = model * batchingMatrix;
    #endif
    #ifdef USE_INSTANCING
        model = model * instanceMatrix;
    #endif
    vec4 world = model * vec4(transformed, 1.0);
    worldPosition = world.xyz;
    // Normals stay perpendicular where axes are scaled differently; a mirrored frame has its bitangent the other way round.
    mat3 turn = mat3(model);
    worldNormal = transpose(inverse(turn)) * objectNormal;
    worldTangent = vec4(turn * objectTangent, tangent.w * sign(determinant(turn)));
    surfaceUv = uv;
    vec4 mvPosition = viewMatrix * world;
    gl_Position = projectionMatrix * mvPosition;
    #include <logdepthbuf_vertex>
}
`;

const FRAGMENT = `
#include <logdepthbuf_pars_fragment>
uniform int lightCount;
uniform vec3 lightPositions[${MAX_LIGHTS}];
uniform vec3 lightIntensities[${MAX_LIGHTS}];
out vec4 colour;
void main() {
    #include <logdepthbuf_fragment>
    // An orthographic camera has no distance.
    vec3 axis = vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]);
    vec3 toEye = normalize(isOrthographic ? axis : cameraPosition - worldPosition);
    float level = levelAt(isOrthographic ? 1e-6 : length(cameraPosition - worldPosition));
    // The back has its normal on that side.
    vec3 n = normalize(worldNormal) * (gl_FrontFacing ? 1.0 : -1.0);
    // Interpolated normals face away from the viewer at outlines, where values would be 0.
    float facing = dot(n, toEye);
    n = facing < 0.02 ? normalize(n + toEye * (0.02 - facing)) : n;
    vec3 t = worldTangent.xyz - n * dot(n, worldTangent.xyz);
    // Without tangents, any vector perpendicular to the normal.
    t = normalize(dot(t, t) > 1e-12 ? t : cross(abs(n.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0), n));
    vec3 b = cross(n, t) * (worldTangent.w < 0.0 ? -1.0 : 1.0);
    vec3 wo = vec3(dot(toEye, t), dot(toEye, b), dot(toEye, n));
    vec3 radiance = litByEnvironment(mat3(t, b, n), wo);
    for (int k = 0; k < lightCount; k++) {
        vec3 toLight = lightPositions[k] - worldPosition;
        float squared = dot(toLight, toLight);
        vec3 l = toLight * inversesqrt(squared);
        vec3 wi = vec3(dot(l, t), dot(l, b), dot(l, n));
        if (wi.z > 0.0 && wo.z > 0.0) {
            radiance += reflected(wi, wo, level) * lightIntensities[k] / squared;
        }
    }
#ifdef TONE_MAPPING
    radiance = toneMapping(radiance);
#endif
    colour = linearToOutputTexel(vec4(radiance, 1.0));
}
`;

/** Without a pack for point lights. */
const UNLIT = `
float levelAt(float distance) {
    return 0.0;
}
vec3 reflected(vec3 wi, vec3 wo, float level) {
    return vec3(0.0);
}
`;

/** Radiance that lobes reflect from a prefiltered environment. */
const LOBES = `
uniform mat3 environmentTurn;
uniform float environmentIntensity;
vec3 litByEnvironment(mat3 frame, vec3 wo) {
    vec3 radiance = vec3(0.0);
    for (uint k = 0u; k < lobes_count(); k++) {
        LobeLookup lobe = lobes_lookup(wo, k);
        radiance += lobe.weight * environment_radiance(environmentTurn * (frame * lobe.direction), lobe.sharpness);
    }
    return environmentIntensity * radiance;
}
`;

const NO_ENVIRONMENT = `
vec3 litByEnvironment(mat3 frame, vec3 wo) {
    return vec3(0.0);
}
`;

/** The same for BRDFs, with any decoder. */
function ofBrdf({ filtered, exact, level_of_detail: level }: Brdf, isWide: boolean): string {
    return `
float levelAt(float distance) {
    return ${level};
}
vec3 reflected(vec3 wi, vec3 wo, float level) {
    return ${isWide ? exact : filtered} * wi.z;
}
`;
}

/** Packs of a material by their use. */
export interface Parts {
    /** A BRDF, a flat BTF or a polynomial wavelet tree, for point lights. */
    surface?: Pack;
    /** Lobes, for the environment. */
    lobes?: Pack;
    environment?: Pack;
}

const ALLOWED = 'a BRDF, a flat BTF or a polynomial wavelet tree, lobes with an environment, or both';

/** Sorts the packs of a material. */
export function parts(packs: Pack[]): Parts {
    const found: Parts = {};
    for (const pack of packs) {
        const { decoder } = pack;
        const part = decoder === 'lobes' || decoder === 'environment' ? decoder : 'surface';
        if (found[part] !== undefined) {
            refuse('material', `packs of the decoders ${found[part]?.decoder} and ${decoder}`, ALLOWED);
        }
        found[part] = pack;
    }
    if ((found.lobes === undefined) !== (found.environment === undefined) || packs.length === 0) {
        refuse('material', packs.length === 0 ? 'no pack' : `${found.lobes ? 'lobes' : 'an environment'} alone`, ALLOWED);
    }
    return found;
}

/** Fragment shader of packs, with the GLSL of their decoders; `isWide`: filter texels in the shader, because samplers do not filter 32-bit floats. */
export function fragmentShader({ surface, lobes }: Parts, decoders: string, isWide: boolean): string {
    return VARYINGS + decoders + (surface === undefined ? UNLIT : ofSurface(surface, isWide)) + (lobes === undefined ? NO_ENVIRONMENT : LOBES) + FRAGMENT;
}

function ofSurface({ decoder: name, shader }: Pack, isWide: boolean): string {
    const { brdf } = (shader ?? {}) as Partial<DecoderShader>;
    const surface = Object.hasOwn(SURFACES, name) ? SURFACES[name] : undefined;
    return (brdf === undefined ? surface : ofBrdf(brdf, isWide))
        ?? refuse('material', `a pack of the decoder ${name}`, `${ALLOWED}; use packBindings and a ShaderMaterial for other packs`);
}

/** Numbers of layers of a table, and of azimuths of lobes: more than one if the material is anisotropic. */
const COUNTS: Record<string, string> = { table: 'layers', lobes: 'azimuths' };

/** Returns true if the pack is anisotropic, or a flat BTF. */
export function needsTangents({ decoder, shader, resources }: Pack): boolean {
    const { bindings = [] } = (shader ?? {}) as Partial<DecoderShader>;
    return ['flat-btf', 'flat-btf-trees'].includes(decoder) || resources.some((resource) => {
        const count = bindings.find(({ slot }) => slot === resource.slot)?.offsets?.[COUNTS[decoder]];
        return resource.kind === 'uniform' && count !== undefined && new DataView(resource.bytes.buffer).getUint32(count, true) > 1;
    });
}
