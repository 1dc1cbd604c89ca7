// The page: schedules drawing, measuring and updates of the controls.

import { find, FRESH, listen, stage, updateControls } from './controls.js';
import { COARSE, Drawing, FINE } from './drawing.js';
import { fromAddress, isCompared, page, state, take } from './state.js';

/** Milliseconds at rest after which a fine rendering is drawn. */
const REST = 150;
/** Milliseconds after an error within which the loss of the device that caused it is reported. */
const LATE = 300;
/** Maximum attempts to restore a page after a graphics driver failed. */
const MAX_LOSSES = 6;

const [here, whole, wrong] = ['here', 'whole', 'wrong'].map(find);
const drawing = new Drawing();
let canvas = find('canvas');
/** Counts of requested frames and of opened devices, to discard late results. */
let requests = 0;
let opened = 0;
let isRequested = false;
let moved = -Infinity;
let resting;
/** True if the difference of the displayed view was measured. `pointer` is the pointer's position in shares of width and height. */
let isMeasured = false;
let pointer;
let isPointed = false;
/** Number of driver failures. */
let losses = 0;

function fail(error) {
    wrong.textContent = `This page cannot be shown here: ${error?.message ?? error}`;
    wrong.hidden = false;
    throw error;
}

/** Runs tasks one after another. Errors of tasks on a lost device are ignored. */
let lastInTurn = Promise.resolve();
function inTurn(work) {
    const by = opened;
    const done = lastInTurn.then(work).catch(async (error) => {
        // The loss of the device is reported after the errors that it causes.
        await new Promise((resolve) => setTimeout(resolve, LATE));
        if (by === opened) {
            throw error;
        }
    });
    lastInTurn = done.catch(() => undefined);
    return done;
}

async function frame() {
    isRequested = false;
    drawing.resize(stage.clientWidth, stage.clientHeight);
    // A new view is drawn coarsely at first, then finely.
    const moving = !drawing.isExposed || performance.now() - moved < REST;
    const samples = moving ? COARSE : FINE;
    await drawing.draw(samples);
    await drawing.expose(samples);
    if (!drawing.isExposed) {
        // The selection changed meanwhile, and another frame is requested.
        return;
    }
    await drawing.show(samples);
    clearTimeout(resting);
    if (moving) {
        resting = setTimeout(requestFrame, Math.max(moved + REST - performance.now(), 0));
    } else {
        await measure();
    }
}

/** Requests a frame; several requests give one frame. */
function requestFrame() {
    isMeasured = false;
    requests += 1;
    if (!isRequested) {
        isRequested = true;
        requestAnimationFrame(() => inTurn(frame).catch(fail));
    }
}

function move() {
    moved = performance.now();
    requestFrame();
}

/** Applies changes to the state and draws it. `moves` is true if more changes will follow. */
function set(changes, moves = false) {
    if (take(changes)) {
        drawing.forgetExposure();
    }
    updateControls();
    moved = moves ? performance.now() : moved;
    requestFrame();
}

/** Measures and displays the difference of both fine renderings. */
async function measure() {
    whole.textContent = '';
    if (!isCompared()) {
        here.textContent = '';
        return undefined;
    }
    const before = requests;
    const found = await drawing.measure();
    whole.textContent = found.pixels > 0
        ? `ΔE of this view: mean ${found.mean.toFixed(2)}, 95th percentile ${found.p95.toFixed(2)}`
        : 'No overlap to compare.';
    isMeasured = before === requests;
    await underPointer();
    return found;
}

async function underPointer() {
    isPointed = false;
    if (!isCompared() || !pointer || !isMeasured) {
        here.textContent = isCompared() ? 'Point at the rendering to read ΔE there.' : '';
        return;
    }
    const pixel = [canvas.width, canvas.height].map((count, k) => Math.max(Math.min(Math.floor(pointer[k] * count), count - 1), 0));
    const { apart, isSurface, isBoth } = await drawing.differenceAt(pixel);
    const without = isSurface ? 'one of the two does not cover these directions' : 'no surface';
    here.textContent = `ΔE here: ${isBoth ? apart.toFixed(2) : without}`;
}

function point(at, isAlone) {
    pointer = at;
    if (isAlone && !isPointed) {
        isPointed = true;
        inTurn(underPointer).catch(fail);
    }
}

function save() {
    inTurn(() => drawing.rendering()).then((png) => {
        if (!png) {
            return;
        }
        const link = document.createElement('a');
        link.href = URL.createObjectURL(png);
        link.download = `${page.items[state.left].name}.png`;
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    }).catch(fail);
}

function startAgain() {
    drawing.forgetExposure();
    set(FRESH());
}

async function open(api) {
    opened += 1;
    const mine = opened;
    const ifMine = (work) => (value) => (mine === opened ? work(value) : undefined);
    await drawing.open(canvas, api, ifMine(() => reopen().catch(fail)), ifMine(fail));
    find('api').textContent = drawing.api;
}

/** Restores a lost page with WebGL 2. It retries, because a graphics process needs time to restart. */
async function reopen() {
    // Ignores further messages of the lost device.
    opened += 1;
    for (; losses < MAX_LOSSES; losses += 1) {
        await new Promise((resolve) => setTimeout(resolve, 500));
        // A canvas cannot change the kind of its context.
        const fresh = canvas.cloneNode();
        canvas.replaceWith(fresh);
        canvas = fresh;
        if (await open('webgl2').then(() => true, () => false)) {
            losses += 1;
            // Tasks of the lost device never end, or fail.
            lastInTurn = Promise.resolve();
            isRequested = false;
            wrong.hidden = true;
            requestFrame();
            return;
        }
    }
    throw new Error(`the graphics driver failed ${losses} times`);
}

async function start() {
    const given = new URLSearchParams(location.hash.slice(1));
    document.body.classList.toggle('embedded', given.has('embed'));
    take(fromAddress());
    drawing.prepare();
    await open(given.get('api'));
    listen({ set, move, point, again: startAgain, save });
    addEventListener('hashchange', () => set(fromAddress()));
    new ResizeObserver(move).observe(stage);
    set({});
    await new Promise(requestAnimationFrame);
    await inTurn(() => drawing.finished());
    return performance.now();
}

/** Interface for scripts. `first` resolves to the time of the first rendering, in milliseconds from the start. */
globalThis.brdfcView = {
    first: start().catch(fail),
    state,
    set: async (changes) => {
        set(changes);
        await new Promise(requestAnimationFrame);
        await lastInTurn;
    },
    exposure: () => drawing.exposure(),
    /** Renders a PNG; with `isFirst`, as coarsely as the first rendering, with its exposure. */
    rendering: (isFirst = false) => inTurn(() => {
        if (!isFirst) {
            return drawing.rendering(FINE);
        }
        drawing.forgetExposure();
        return drawing.rendering(COARSE);
    }),
    measure: () => inTurn(async () => {
        await drawing.draw(FINE);
        await drawing.expose(FINE);
        return measure();
    }),
    speed: (count = 30) => inTurn(() => drawing.speed(count)),
};
