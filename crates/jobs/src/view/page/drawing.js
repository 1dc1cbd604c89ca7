// Draws the selected materials, finds the exposure, and reads renderings back.

import { viewBlock } from './camera.js';
import { autoExposure, differences } from './colour.js';
import { contentsOf, CORNER, meshOf, once, unpacked } from './data.js';
import { nearest } from './lights.js';
import { photographContents } from './photographs.js';
import { isImage, isPair, page, scene, state } from './state.js';
import { BEHIND, BYTES, FLOATS, WebGl } from './webgl.js';
import { featuresOf, WebGpu } from './webgpu.js';

/** Maximum pixels along a side of the rendering. */
const MAX_PIXELS = 1024;
/** Samples along a pixel's side at rest, and while something moves. */
export const FINE = 2;
export const COARSE = 1;
/** Modes of `Show` in show.wgsl. */
const [RENDERINGS, COLOURS, DELTA_E, RADIANCE] = [0, 1, 2, 3];
/** Minimum pixels that determine the exposure of a coarse rendering; a fine one follows. */
const ENOUGH = 50_000;
/** Maximum number of decoded photographs. */
const MAX_DECODED = 12;

export class Drawing {
    /** Unpacked data that is not uploaded yet, and uploaded programs, meshes and materials, by name or number. */
    #waiting = new Map();
    #made = new Map();
    /** Contents of decoded photographs by item and number, the latest last. */
    #decoded = new Map();
    /** Exposure of the selected materials and surface: `factor` to the display's range, once known, and `isExact` if from a fine rendering. */
    #exposed = {};
    /** Exposure of the last rendering. */
    #drawnExposed = this.#exposed;

    constructor() {
        this.programs = unpacked(page.programs).then((bytes) => JSON.parse(new TextDecoder().decode(bytes)));
    }

    /** Unpacks the data of the first rendering while the driver starts. */
    prepare() {
        const surface = scene();
        this.#drawn().forEach((number) => {
            quietly(this.#contents(page.items[number]));
            quietly(this.#shape(surface, page.items[number]).unpacked());
        });
    }

    /** Opens WebGPU if available, else WebGL 2; only `api` if given. */
    async open(canvas, api, lost, wrong) {
        const features = featuresOf(page.items);
        let found = api === 'webgl2' ? undefined : await WebGpu.open(canvas, features, lost, wrong).catch(() => undefined);
        found ??= api === 'webgpu' ? undefined : await WebGl.open(canvas, lost);
        if (!found) {
            throw new Error('neither WebGPU nor WebGL 2 with float render targets (EXT_color_buffer_float) is available');
        }
        [this.backend, this.canvas] = [found, canvas];
        this.#made.clear();
        quietly(this.#uploaded('show', async () => found.showing((await this.programs).show)));
        quietly(this.#program(page.items[state.left]));
    }

    get api() {
        return this.backend.name;
    }

    /** Fits the resolution to an element of this size. */
    resize(clientWidth, clientHeight) {
        const scale = Math.min(devicePixelRatio, MAX_PIXELS / Math.max(clientWidth, clientHeight));
        const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(Math.round(side * scale), 1));
        if (this.canvas.width !== width || this.canvas.height !== height || !this.backend.size) {
            [this.canvas.width, this.canvas.height] = [width, height];
            this.backend.resize(width, height);
        }
    }

    /** Resets the exposure for another selection. */
    forgetExposure() {
        this.#exposed = {};
    }

    get isExposed() {
        return this.#exposed.factor !== undefined;
    }

    exposure() {
        return (this.#exposed.factor ?? 1) * 2 ** state.stops;
    }

    /** Draws both renderings without showing them. */
    async draw(samples) {
        // The state may change while this waits.
        const [view, surface, drawn, exposed] = [{ ...state, samples }, scene(), this.#drawn(), this.#exposed];
        const items = drawn.map((number) => page.items[number]);
        const both = items.map((item) => Promise.all([this.#material(item, view.lights), this.#mesh(surface, item)]));
        const behind = this.#environments() === 0 ? [] : await Promise.all([this.#material(page.environment), this.#triangle()]);
        const block = (item) => viewBlock(surface, item, view, this.canvas.width / this.canvas.height);
        (await Promise.all(both)).forEach(([material, shape], which) => {
            this.backend.draw(which, material, shape, block(items[which]), samples);
        });
        if (behind.length > 0) {
            const lit = items.find((item) => item.needsEnvironment);
            this.backend.draw(BEHIND, ...behind, block(lit), 1);
        }
        this.#drawnExposed = exposed;
    }

    /** Finds the exposure of the last rendering, unless it is known. */
    async expose(samples) {
        const mine = this.#drawnExposed;
        if (isImage()) {
            // The display's white is that of the photographs.
            Object.assign(mine, { factor: 1, isExact: true });
        } else if (mine.factor === undefined || (!mine.isExact && samples === FINE)) {
            // From the right rendering, which is the reference of the left one.
            const { width, height } = this.canvas;
            const step = samples === FINE ? 1 : Math.max(Math.floor(Math.sqrt((width * height) / ENOUGH)), 1);
            mine.factor = autoExposure(await this.#read(samples, RADIANCE, FLOATS, step));
            mine.isExact = samples === FINE;
        }
    }

    /** Shows the last renderings. */
    async show(samples) {
        const program = await this.#made.get('show');
        this.backend.show(program, this.#showBlock(samples, this.#mode()));
    }

    /** Waits until the GPU is done. */
    finished() {
        return this.backend.finished();
    }

    /** Measures the difference of the fine renderings. */
    async measure() {
        return differences(await this.#read(FINE, DELTA_E, FLOATS));
    }

    /** Returns ΔE of a pixel, after `measure`, and if one or both renderings show a surface there. */
    async differenceAt(pixel) {
        const [apart, , isSurface, isBoth] = await this.backend.read(FLOATS, [...pixel, 1, 1]);
        return { apart, isSurface: isSurface > 0, isBoth: isBoth > 0 };
    }

    /** Returns the displayed view as a PNG. */
    async rendering(samples = FINE) {
        await this.draw(samples);
        await this.expose(samples);
        const shown = await this.#read(samples, this.#mode(), BYTES);
        const { width, height } = this.canvas;
        const flat = new OffscreenCanvas(width, height);
        flat.getContext('2d').putImageData(new ImageData(shown, width, height), 0, 0);
        return flat.convertToBlob({ type: 'image/png' });
    }

    /** Measures coarse renderings per second, waiting for each. */
    async speed(count) {
        const [started, { turn }] = [performance.now(), state];
        const program = await this.#made.get('show');
        for (let k = 0; k < count; k += 1) {
            state.turn = { yaw: 0.02 * k, pitch: 0 };
            await this.draw(COARSE);
            this.backend.show(program, this.#showBlock(COARSE, this.#mode()), BYTES);
            await this.backend.read(BYTES, [0, 0, 1, 1]);
        }
        state.turn = turn;
        return (1000 * count) / (performance.now() - started);
    }

    #drawn() {
        return isPair() ? [state.left, state.right] : [state.left];
    }

    /** Renderings that show the environment behind their surface: 1 the first, 2 the second, or their sum. */
    #environments() {
        const bit = (number, which) => (state.behind && page.items[number].needsEnvironment ? 1 << which : 0);
        return this.#drawn().map(bit).reduce((sum, bit) => sum + bit);
    }

    #mode() {
        return isPair() && state.mode === 'difference' ? COLOURS : RENDERINGS;
    }

    #showBlock(samples, what, step = 1) {
        const block = new ArrayBuffer(48);
        const split = !isPair() || state.mode === 'one' ? MAX_PIXELS : state.split * this.canvas.width;
        new Float32Array(block).set([...scene().background, this.exposure(), split], 0);
        new Uint32Array(block).set([what, samples, isPair() ? 1 : 0, step, this.#environments()], 5);
        return new Uint8Array(block);
    }

    /** Reads back every pixel, or one in `step` along each side. */
    async #read(samples, what, which, step = 1) {
        const program = await this.#made.get('show');
        const size = [this.canvas.width, this.canvas.height].map((side) => Math.ceil(side / step));
        this.backend.show(program, this.#showBlock(samples, what, step), which, size);
        return this.backend.read(which, [0, 0, ...size], size);
    }

    /** The program of a material; it filters in the shader if samplers cannot filter its floats. */
    #program({ decoder, wide }) {
        const name = wide && !this.backend.filtersFloats ? `${decoder}, exact` : decoder;
        return this.#uploaded(`program ${name}`, async () => this.backend.program((await this.programs).of[name]));
    }

    /** The contents of a photograph; the latest stay decoded. */
    #photograph(item, number) {
        const key = `${keyOf(item)} ${number}`;
        const found = this.#decoded.get(key) ?? photographContents(item.photographs[number]);
        this.#decoded.delete(key);
        this.#decoded.set(key, found);
        if (this.#decoded.size > MAX_DECODED) {
            this.#decoded.delete(this.#decoded.keys().next().value);
        }
        return found;
    }

    /** The photographs that are nearest to these lights, as a material with three textures. */
    async #photographed(item, lights) {
        const numbers = nearest(item, lights);
        const [program, ...all] = await Promise.all([this.#program(item), ...numbers.map((number) => this.#photograph(item, number))]);
        return this.backend.material(program, [0, 1, 2].map((binding) => ({ binding, contents: all[binding] ?? all[0] })));
    }

    /** An uploaded material of the page, or its environment. */
    #material(item, lights) {
        if (item.photographs?.length > 0) {
            return this.#photographed(item, lights);
        }
        return this.#uploaded(keyOf(item), async () => {
            const [program, bound] = await Promise.all([this.#program(item), this.#contents(item)]);
            // Other materials need the contents of the environment.
            if (item !== page.environment) {
                this.#waiting.delete(keyOf(item));
            }
            return this.backend.material(program, bound);
        });
    }

    /** A triangle for programs that place its corners themselves. */
    #triangle() {
        return this.#uploaded('triangle', async () => this.backend.mesh({
            corners: new Float32Array(3 * CORNER),
            indices: new Uint32Array([0, 1, 2]),
        }));
    }

    #mesh(surface, item) {
        const { key, unpacked } = this.#shape(surface, item);
        return this.#uploaded(key, async () => {
            const shape = await unpacked();
            this.#waiting.delete(key);
            return this.backend.mesh(shape);
        });
    }

    /** The mesh of a scene, as the relief of a flat BTF covers it: its name, and a function that unpacks it. */
    #shape({ name, mesh }, { name: item, reliefs }) {
        const covered = reliefs[name];
        const key = covered === undefined ? `mesh ${name}` : `mesh ${name} of ${item}`;
        return { key, unpacked: () => this.#unpacked(key, () => meshOf(covered ?? mesh)) };
    }

    /** The unpacked resources of a material, with those of the environment that lights it. */
    async #contents(item) {
        if (item.photographs?.length > 0) {
            return nearest(item, state.lights).map((number) => this.#photograph(item, number));
        }
        const each = async (resource) => ({ binding: resource.binding, contents: await contentsOf(resource) });
        const own = this.#unpacked(keyOf(item), () => Promise.all(item.resources.map(each)));
        return item.needsEnvironment ? [...await this.#contents(page.environment), ...await own] : own;
    }

    #unpacked(key, make) {
        return once(this.#waiting, key, make);
    }

    #uploaded(key, make) {
        return once(this.#made, key, make);
    }
}

/** Key of a material, or of the environment, whose name may be that of a material. */
function keyOf({ decoder, name }) {
    return `${decoder} ${name}`;
}

/** Ignores errors here; they reach the code that awaits the result. */
function quietly(work) {
    work.catch(() => undefined);
}
