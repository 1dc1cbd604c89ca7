// The page: when what is drawn, measured and told.

import { find, FRESH, listen, stage, tell } from './controls.js';
import { COARSE, Drawing, FINE } from './drawing.js';
import { fromAddress, isPair, page, state, take } from './state.js';

/** Milliseconds without a movement, after which a rendering is drawn finely. */
const REST = 150;
/** Milliseconds after an error, in which its cause is heard of. */
const LATE = 300;
/** How often a page is drawn again, or tries to, that a graphics driver gave up. */
const MAX_LOSSES = 6;

const [here, whole, wrong] = ['here', 'whole', 'wrong'].map(find);
const drawing = new Drawing();
let canvas = find('canvas');
/** How often something was asked for, and how often what draws was opened: what is late is not of what is shown now. */
let asks = 0;
let opened = 0;
let asked = false;
let moved = -Infinity;
let resting;
/** Whether the difference of what is shown was measured, and can be read under the pointer: its share of width and height. */
let isMeasured = false;
let pointer;
let isPointed = false;
/** How often a driver gave up. */
let losses = 0;

function fail(error) {
    wrong.textContent = `This page cannot be shown here: ${error?.message ?? error}`;
    wrong.hidden = false;
    throw error;
}

/** One thing at a time is drawn or read, in turn. What was asked of a driver that gave up ends without a word. */
let lastInTurn = Promise.resolve();
function inTurn(work) {
    const by = opened;
    const done = lastInTurn.then(work).catch(async (error) => {
        // That it gave up is said after what this led to.
        await new Promise((resolve) => setTimeout(resolve, LATE));
        if (by === opened) {
            throw error;
        }
    });
    lastInTurn = done.catch(() => undefined);
    return done;
}

async function frame() {
    asked = false;
    drawing.resize(stage.clientWidth, stage.clientHeight);
    // What is new is seen at once, and finely after that.
    const moving = !drawing.isExposed || performance.now() - moved < REST;
    const samples = moving ? COARSE : FINE;
    await drawing.draw(samples);
    await drawing.expose(samples);
    if (!drawing.isExposed) {
        // Something else was chosen meanwhile, and asked for.
        return;
    }
    await drawing.show(samples);
    clearTimeout(resting);
    if (moving) {
        resting = setTimeout(ask, Math.max(moved + REST - performance.now(), 0));
    } else {
        await measure();
    }
}

/** Asks for a frame, however often. */
function ask() {
    isMeasured = false;
    asks += 1;
    if (!asked) {
        asked = true;
        requestAnimationFrame(() => inTurn(frame).catch(fail));
    }
}

function move() {
    moved = performance.now();
    ask();
}

/** Takes some of the state over, and draws it; `moves`: more of the same is to come. */
function set(changes, moves = false) {
    if (take(changes)) {
        drawing.forgetExposure();
    }
    tell();
    moved = moves ? performance.now() : moved;
    ask();
}

/** What both fine renderings differ by. */
async function measure() {
    whole.textContent = '';
    if (!isPair()) {
        here.textContent = '';
        return undefined;
    }
    const before = asks;
    const found = await drawing.measure();
    whole.textContent = found.pixels > 0
        ? `ΔE of this view: ${found.mean.toFixed(2)} in the mean, ${found.p95.toFixed(2)} at 95 %`
        : 'Nothing here is shown by both.';
    isMeasured = before === asks;
    await underPointer();
    return found;
}

async function underPointer() {
    isPointed = false;
    if (!isPair() || !pointer || !isMeasured) {
        here.textContent = isPair() ? 'Point at the rendering for the ΔE there.' : '';
        return;
    }
    const pixel = [canvas.width, canvas.height].map((count, k) => Math.max(Math.min(Math.floor(pointer[k] * count), count - 1), 0));
    const { apart, isSurface, isBoth } = await drawing.differenceAt(pixel);
    const without = isSurface ? 'one of the two was not made for these directions' : 'no surface';
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

async function open(wanted) {
    opened += 1;
    const mine = opened;
    const ifMine = (work) => (word) => (mine === opened ? work(word) : undefined);
    await drawing.open(canvas, wanted, ifMine(() => reopen().catch(fail)), ifMine(fail));
    find('api').textContent = drawing.api;
}

/** Where a driver took everything away, the same by WebGL 2. A graphics process that ended is not there again at once. */
async function reopen() {
    // From now on, what the lost one still says is of no interest.
    opened += 1;
    for (; losses < MAX_LOSSES; losses += 1) {
        await new Promise((resolve) => setTimeout(resolve, 500));
        // A canvas keeps to the first context that it gave.
        const fresh = canvas.cloneNode();
        canvas.replaceWith(fresh);
        canvas = fresh;
        if (await open('webgl2').then(() => true, () => false)) {
            losses += 1;
            // What was asked of the lost one does not end, or ends badly.
            lastInTurn = Promise.resolve();
            asked = false;
            wrong.hidden = true;
            ask();
            return;
        }
    }
    throw new Error(`the graphics driver gave up ${losses} times`);
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

/** For scripts: when the first rendering stood, in milliseconds from the start; changes; exposure; renderings; differences. */
globalThis.brdfcView = {
    first: start().catch(fail),
    state,
    set: async (changes) => {
        set(changes);
        await new Promise(requestAnimationFrame);
        await lastInTurn;
    },
    exposure: () => drawing.exposure(),
    /** `isFirst`: as coarse as the first rendering, with its exposure. */
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
