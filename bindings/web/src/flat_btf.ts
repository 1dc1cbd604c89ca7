import { type Container, versioned, view } from './container.js';
import type { Contents, Options } from './pack.js';
import { image, noTexture, texture } from './textures.js';
import { Words } from './words.js';

const MAX_GROUPS = 16;
const BASE_LAYERS = 2;

/** What a flat BTF binds, from its parts; their layout: formats/src/flat_btf/spec.md. */
export function flatBtfResources(parts: Map<string, Container>, { filter }: Required<Options>): Map<number, Contents> {
    const part = (name: string): Container => {
        const found = parts.get(name);
        if (found === undefined) {
            throw new Error(`flat BTF: found no part ${name}`);
        }
        return found;
    };
    const hardware = filter === 'sampler' ? 1 : 0;
    const [reference, normal, diffuse] = ['reference', 'normal', 'diffuse'].map((name) => part(name).texture);
    const compact = parts.has('displacement');
    const packed = part(compact ? 'displacement' : 'indirection');
    const header = versioned(packed.entries, compact ? 'brdfc.displacement' : 'brdfc.indirection');
    const [size, zenith, azimuth] = [4, 8, 12].map((at) => header.getUint32(at, true));
    const ranges = compact ? packed.entries.get('brdfc.displacement.ranges') : undefined;
    const basis = parts.get('basis');
    const lights = basis ? view(basis.entries, 'brdfc.flat-btf.factored').getUint32(28, true) : 0;
    const block = new Words(48)
        .uint(diffuse.size[0], reference.size[0], zenith, azimuth)
        .float(header.getFloat32(16, true))
        .uint(Math.ceil(Math.sqrt(lights)), hardware, compact ? size : 0)
        .float(compact ? header.getFloat32(20, true) : 0)
        .uint(basis ? 2 : 0);
    return new Map<number, Contents>([
        [0, { kind: 'uniform', bytes: block.done() }],
        [1, texture(reference, false)],
        [2, texture(packed.texture, true)],
        [3, { kind: 'sampler', repeats: false }],
        [4, texture(normal, false)],
        [5, texture(diffuse, false)],
        [6, noTexture('2d-array')],
        [7, ranges ? texture(image('rgba16float', 8, [size, size], ranges), false) : noTexture('2d')],
        [12, { kind: 'sampler', repeats: true }],
        [13, basis ? texture(part('directions').texture, false) : noTexture('2d', 'r32uint', 4)],
        ...(basis ? factored(basis, part('weights'), parts.get('shadow'), hardware) : notFactored()),
    ]);
}

function notFactored(): [number, Contents][] {
    return [
        [8, { kind: 'uniform', bytes: new Words(1376).done() }],
        [9, noTexture('2d-array')],
        [10, noTexture('2d-array')],
        [11, noTexture('2d', 'rgba32uint', 16)],
    ];
}

/** Bindings 8 to 11; their layout: formats/src/flat_btf/factored/spec.md. */
function factored(basis: Container, weights: Container, shadow: Container | undefined, hardware: number): [number, Contents][] {
    const header = versioned(basis.entries, 'brdfc.flat-btf.factored');
    const [size, levels, groups, wideGroups, , views, lights] = [4, 8, 12, 16, 20, 24, 28].map((at) => header.getUint32(at, true));
    const angles = view(basis.entries, 'brdfc.lights');
    let lowest = 1;
    for (let k = 0; k < lights; k += 1) {
        lowest = Math.min(lowest, Math.fround(Math.cos(angles.getFloat32(8 * k, true))));
    }
    const block = new Words(1376)
        .uint(size, levels, groups, wideGroups, shadow ? 1 : 0, hardware, views)
        .float(lowest);
    const components = 4 * groups;
    for (let colour = 0; colour < 3; colour += 1) {
        block.from(32 + 16 * MAX_GROUPS * colour);
        block.float(...Array.from({ length: components }, (_, k) => header.getFloat32(60 + 4 * (components * colour + k), true)));
    }
    const ranges = versioned(weights.entries, 'brdfc.flat-btf.weights');
    const numbers = ranges.getUint32(4, true);
    const first = 32 + 3 * 16 * MAX_GROUPS;
    for (const [which, at] of [[0, first], [4, first + 16 * (BASE_LAYERS + MAX_GROUPS)]]) {
        block.from(at).float(...Array.from({ length: numbers }, (_, k) => ranges.getFloat32(8 + 8 * k + which, true)));
    }
    return [
        [8, { kind: 'uniform', bytes: block.done() }],
        [9, texture(weights.texture, true, true)],
        [10, shadow ? texture(shadow.texture, true, true) : noTexture('2d-array')],
        [11, texture(basis.texture, false)],
    ];
}
