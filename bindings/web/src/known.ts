import { ENTRY } from './bindings.js';
import type { Resource } from './pack.js';
import { refuse } from './refuse.js';
import { type DecoderShader, SHADERS } from './shaders.js';

/** The decoder of this package that a pack names, if there is one; the pack has to bind everything that it declares. */
export function known(decoder: string, version: number, resources: Resource[]): DecoderShader | undefined {
    const shader = Object.hasOwn(SHADERS, decoder) ? (SHADERS as Record<string, DecoderShader>)[decoder] : undefined;
    if (shader !== undefined && version !== shader.version) {
        refuse(`${ENTRY}, version of ${decoder}`, version, shader.version);
    }
    for (const { slot, name, kind, dimension, bytes } of shader?.bindings ?? []) {
        const allowed = `${kind} ${name}${dimension ? `, ${dimension}` : ''}${bytes ? ` of ${bytes} bytes` : ''}`;
        const found = resources.find((resource) => resource.slot === slot) ?? refuse(`slot ${slot}`, 'nothing', allowed);
        const isIt = found.name === name && found.kind === kind
            && (found.kind !== 'uniform' || found.bytes.length === bytes)
            && (found.kind !== 'texture' || found.texture.dimension === dimension);
        if (!isIt) {
            refuse(`slot ${slot}`, `${found.kind} ${found.name}`, `${allowed}, as the decoder ${decoder} has`);
        }
    }
    return shader;
}
