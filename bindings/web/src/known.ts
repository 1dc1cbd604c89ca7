import { ENTRY } from './bindings.js';
import type { Resource } from './pack.js';
import { refuse, refuseProblem } from './refuse.js';
import { type DecoderShader, SHADERS } from './shaders.js';

type Binding = Omit<DecoderShader['bindings'][number], 'offsets'>;

/** Returns the decoder that a pack names, if this package has it; the pack must bind everything as declared. */
export function known(decoder: string, version: number, resources: Resource[]): DecoderShader | undefined {
    const shader = Object.hasOwn(SHADERS, decoder) ? (SHADERS as Record<string, DecoderShader>)[decoder] : undefined;
    if (shader !== undefined && version !== shader.version) {
        refuse(`${ENTRY}, version of ${decoder}`, version, shader.version);
    }
    for (const binding of shader?.bindings ?? []) {
        const resource = resources.find(({ slot }) => slot === binding.slot);
        const [place, allowed] = [`slot ${binding.slot}`, summary(binding)];
        if (resource === undefined) {
            refuseProblem(place, 'no binding', `${allowed}, as the decoder ${decoder} declares`);
        }
        const found = summary(bindingOf(resource));
        if (found !== allowed) {
            refuse(place, found, `${allowed}, as the decoder ${decoder} declares`);
        }
    }
    return shader;
}

/** A resource of a pack, as its shader declares it. */
function bindingOf(resource: Resource): Binding {
    const { slot, name, kind } = resource;
    switch (kind) {
        case 'uniform': return { slot, name, kind, bytes: resource.bytes.length };
        case 'sampler': return { slot, name, kind };
        case 'texture': {
            const { texture: { dimension, format }, filtered } = resource;
            return { slot, name, kind, dimension, samples: format.endsWith('uint') ? 'uint' : 'float', filtered };
        }
    }
}

function summary({ name, kind, dimension, samples, filtered, bytes }: Binding): string {
    const what = kind === 'texture' ? `, ${dimension} of ${samples}, ${filtered ? 'filtered' : 'not filtered'}` : '';
    return `${kind} ${name}${what}${bytes === undefined ? '' : ` of ${bytes} bytes`}`;
}
