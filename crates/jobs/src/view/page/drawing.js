// Draws what is chosen, finds its exposure, and reads renderings back.

import { viewBlock } from './camera.js';
import { autoExposure, differences } from './colour.js';
import { contentsOf, meshOf, unpacked } from './data.js';
import { isPair, page, scene, state } from './state.js';
import { BYTES, FLOATS, WebGl } from './webgl.js';
import { featuresOf, WebGpu } from './webgpu.js';

/** Most pixels along a side of the rendering. */
const MAX_PIXELS = 1024;
/** Samples along a pixel's side where nothing moves, and where something does. */
export const FINE = 2;
export const COARSE = 1;
/** What is shown: its layout and its numbers are those of `Show` in show.wgsl. */
const [PICTURES, COLOURS, DELTA_E, RADIANCE] = [0, 1, 2, 3];
/** So many pixels, at least, say the exposure of a coarse rendering, which is drawn finely soon. */
const ENOUGH = 50_000;

export class Drawing {
    /** What was unpacked, but not uploaded yet; what was uploaded: programs, meshes and materials by their name or number. */
    #waiting = new Map();
    #made = new Map();
    /** Of the materials and the surface that are chosen: the factor to the display's range, once it is known, and if a fine rendering says it. */
    #exposed = {};
    /** That of what was drawn last. */
    #drawnExposed = this.#exposed;

    constructor() {
        this.programs = unpacked(page.programs).then((bytes) => JSON.parse(new TextDecoder().decode(bytes)));
    }

    /** Unpacks what a rendering takes, while a driver starts. */
    prepare() {
        const begun = [this.#shape(scene()), ...this.#drawn().map((number) => this.#contents(number))];
        begun.forEach(quietly);
    }

    /** Opens what draws: WebGPU where there is, else WebGL 2; `wanted`, if there is one, alone. */
    async open(canvas, wanted, lost, wrong) {
        const features = featuresOf(page.items);
        let found = wanted === 'webgl2' ? undefined : await WebGpu.open(canvas, features, lost, wrong).catch(() => undefined);
        found ??= wanted === 'webgpu' ? undefined : await WebGl.open(canvas, lost);
        if (!found) {
            throw new Error('there is neither WebGPU nor WebGL 2 with renderings of floats (EXT_color_buffer_float)');
        }
        [this.backend, this.canvas] = [found, canvas];
        this.#made.clear();
        quietly(this.#uploaded('show', async () => found.showing((await this.programs).show)));
        quietly(this.#program(page.items[state.left]));
    }

    get api() {
        return this.backend.name;
    }

    /** As many pixels as an element of this size shows. */
    resize(clientWidth, clientHeight) {
        const scale = Math.min(devicePixelRatio, MAX_PIXELS / Math.max(clientWidth, clientHeight));
        const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(Math.round(side * scale), 1));
        if (this.canvas.width !== width || this.canvas.height !== height || !this.backend.size) {
            [this.canvas.width, this.canvas.height] = [width, height];
            this.backend.resize(width, height);
        }
    }

    /** Something else is drawn from now on. */
    forgetExposure() {
        this.#exposed = {};
    }

    get isExposed() {
        return this.#exposed.factor !== undefined;
    }

    exposure() {
        return (this.#exposed.factor ?? 1) * 2 ** state.stops;
    }

    /** Draws both renderings; nothing is shown yet. */
    async draw(samples) {
        // The state may be another one after the wait.
        const [view, surface, drawn, exposed] = [{ ...state, samples }, scene(), this.#drawn(), this.#exposed];
        const [shape, ...materials] = await Promise.all([this.#mesh(surface), ...drawn.map((number) => this.#material(number))]);
        drawn.forEach((number, which) => {
            const block = viewBlock(surface, page.items[number], view, this.canvas.width / this.canvas.height);
            this.backend.draw(which, materials[which], shape, block, samples);
        });
        this.#drawnExposed = exposed;
    }

    /** Finds the exposure of what was drawn, unless it is known. */
    async expose(samples) {
        const mine = this.#drawnExposed;
        if (mine.factor === undefined || (!mine.isExact && samples === FINE)) {
            // That of what is nearer to the truth: the right one is what the left one is held against.
            const { width, height } = this.canvas;
            const step = samples === FINE ? 1 : Math.max(Math.floor(Math.sqrt((width * height) / ENOUGH)), 1);
            mine.factor = autoExposure(await this.#read(samples, RADIANCE, FLOATS, step));
            mine.isExact = samples === FINE;
        }
    }

    /** Shows what was drawn. */
    async show(samples) {
        const program = await this.#made.get('show');
        this.backend.show(program, this.#showBlock(samples, this.#mode()));
    }

    /** Waits until all of it is drawn. */
    finished() {
        return this.backend.finished();
    }

    /** What both renderings differ by, drawn finely. */
    async measure() {
        return differences(await this.#read(FINE, DELTA_E, FLOATS));
    }

    /** ΔE of a pixel, after `measure`; whether one shows a surface there, and whether both do. */
    async differenceAt(pixel) {
        const [apart, , isSurface, isBoth] = await this.backend.read(FLOATS, [...pixel, 1, 1]);
        return { apart, isSurface: isSurface > 0, isBoth: isBoth > 0 };
    }

    /** What is shown, as a PNG: finely, or as coarsely as the first rendering. */
    async rendering(samples = FINE) {
        await this.draw(samples);
        await this.expose(samples);
        const shown = await this.#read(samples, this.#mode(), BYTES);
        const { width, height } = this.canvas;
        const flat = new OffscreenCanvas(width, height);
        flat.getContext('2d').putImageData(new ImageData(shown, width, height), 0, 0);
        return flat.convertToBlob({ type: 'image/png' });
    }

    /** Renderings a second, each drawn as while something moves, and waited for. */
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

    #mode() {
        return isPair() && state.mode === 'difference' ? COLOURS : PICTURES;
    }

    #showBlock(samples, what, step = 1) {
        const block = new ArrayBuffer(48);
        const split = !isPair() || state.mode === 'one' ? MAX_PIXELS : state.split * this.canvas.width;
        new Float32Array(block).set([...scene().background, this.exposure(), split], 0);
        new Uint32Array(block).set([what, samples, isPair() ? 1 : 0, step], 5);
        return new Uint8Array(block);
    }

    /** What is shown, of each pixel or of one in `step` along each side. */
    async #read(samples, what, which, step = 1) {
        const program = await this.#made.get('show');
        const size = [this.canvas.width, this.canvas.height].map((side) => Math.ceil(side / step));
        this.backend.show(program, this.#showBlock(samples, what, step), which, size);
        return this.backend.read(which, [0, 0, ...size], size);
    }

    /** What draws a kind of pack; where samplers do not filter floats, a shader does that has no other way in it. */
    #program({ decoder, wide }) {
        const name = wide && !this.backend.filtersFloats ? `${decoder}, exact` : decoder;
        return this.#uploaded(`program ${name}`, async () => this.backend.program((await this.programs).of[name]));
    }

    #material(number) {
        return this.#uploaded(`material ${number}`, async () => {
            const [program, bound] = await Promise.all([this.#program(page.items[number]), this.#contents(number)]);
            this.#waiting.delete(`material ${number}`);
            return this.backend.material(program, bound);
        });
    }

    #mesh({ name, mesh }) {
        return this.#uploaded(`mesh ${name}`, async () => {
            const shape = await this.#shape({ name, mesh });
            this.#waiting.delete(`mesh ${name}`);
            return this.backend.mesh(shape);
        });
    }

    #shape({ name, mesh }) {
        return this.#unpacked(`mesh ${name}`, () => meshOf(mesh));
    }

    #contents(number) {
        const each = async (resource) => ({ binding: resource.binding, contents: await contentsOf(resource) });
        return this.#unpacked(`material ${number}`, () => Promise.all(page.items[number].resources.map(each)));
    }

    #unpacked(key, make) {
        return once(this.#waiting, key, make);
    }

    #uploaded(key, make) {
        return once(this.#made, key, make);
    }
}

/** Whoever takes the result hears of an error. */
function quietly(work) {
    work.catch(() => undefined);
}

function once(known, key, make) {
    if (!known.has(key)) {
        known.set(key, make());
    }
    return known.get(key);
}
