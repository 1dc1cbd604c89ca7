// The page: what is chosen, and when it is drawn.

import { viewBlock, raised } from './camera.js';
import { autoExposure, differences } from './colour.js';
import { contentsOf, meshOf, unpacked } from './data.js';
import { BYTES, FLOATS, WebGl } from './webgl.js';
import { featuresOf, WebGpu } from './webgpu.js';

/** Most pixels along a side of the picture. */
const MOST_PIXELS = 1024;
/** Samples along a pixel's side where nothing moves, and where something does. */
const FINE = 2;
const COARSE = 1;
/** Milliseconds without a movement, after which a picture is drawn finely. */
const REST = 150;
/** Radians for each pixel that a pointer is dragged, and for each press of a key. */
const DRAG = 0.008;
const PRESS = 0.08;
/** How often a page is drawn anew, or tries to, that a graphics driver gave up. */
const MOST_LOSSES = 6;

const page = JSON.parse(document.getElementById('data').textContent);
const find = (id) => document.getElementById(id);
const [stage, here, whole, wrong] = ['stage', 'here', 'whole', 'wrong'].map(find);
let canvas = find('canvas');
const controls = document.querySelector('form');
const given = new URLSearchParams(location.hash.slice(1));

const still = () => ({ yaw: 0, pitch: 0 });
const state = {
    scene: page.items[0].scenes[0],
    left: 0,
    right: page.items.length > 1 ? 1 : -1,
    mode: 'split',
    split: 0.5,
    /** By how many levels it is coarser than the finest; null: as the distance, or the size of a pixel, says. */
    coarser: null,
    stops: 0,
    turn: still(),
    light: still(),
    zoom: 1,
};

let backend;
/** Of the page: what draws each kind of pack, and what shows what was drawn. */
let programs;
let show;
/** What was uploaded: programs, meshes and materials by their name or number. */
const made = new Map();
/** Of the materials and the surface that are chosen: the factor to the display's range, once it is known, and if a fine picture says it. */
let exposed = {};
let asked = false;
let moved = -Infinity;
let resting;
/** Whether the difference of what is shown was measured, and can be read under the pointer. */
let isMeasured = false;
let pointer;
let isPointed = false;
/** How often that was. */
let losses = 0;

function fail(error) {
    wrong.textContent = `This page cannot be shown here: ${error?.message ?? error}`;
    wrong.hidden = false;
    throw error;
}

const scene = () => page.scenes.find(({ name }) => name === state.scene);
const isPair = () => state.right >= 0;
/** Scenes that a material goes onto. */
const scenesOf = (item) => page.scenes.filter(({ name }) => item.scenes.includes(name));

function uploaded(key, make) {
    if (!made.has(key)) {
        made.set(key, make());
    }
    return made.get(key);
}

const program = (name) => uploaded(`program ${name}`, async () => backend.program(programs.of[name], false));
const material = (number) => uploaded(`material ${number}`, async () => {
    const item = page.items[number];
    const bound = item.resources.map(async (resource) => ({ binding: resource.binding, contents: await contentsOf(resource) }));
    return backend.material(await program(item.decoder), await Promise.all(bound));
});
const mesh = ({ name, mesh }) => uploaded(`mesh ${name}`, async () => backend.mesh(await meshOf(mesh)));

/** What is shown: its layout and its numbers are those of `Show` in show.wgsl. */
const [PICTURES, COLOURS, DELTA_E, RADIANCE] = [0, 1, 2, 3];
function showBlock(samples, what) {
    const block = new ArrayBuffer(32);
    const split = !isPair() || state.mode === 'one' ? MOST_PIXELS : state.split * canvas.width;
    new Float32Array(block).set([...scene().background, exposure(), split], 0);
    new Uint32Array(block).set([what, samples, isPair() ? 1 : 0], 5);
    return new Uint8Array(block);
}

const exposure = () => (exposed.factor ?? 1) * 2 ** state.stops;
const mode = () => (isPair() && state.mode === 'difference' ? COLOURS : PICTURES);
const everything = () => [0, 0, canvas.width, canvas.height];

/** Draws both pictures; nothing is shown yet. */
async function draw(samples) {
    // The state may be another one after the wait.
    const [view, surface, drawn] = [{ ...state, samples }, scene(), isPair() ? [state.left, state.right] : [state.left]];
    const [shape, ...materials] = await Promise.all([mesh(surface), ...drawn.map(material)]);
    drawn.forEach((number, which) => {
        const item = page.items[number];
        const samplerFilters = !item.wide || backend.filtersFloats;
        const block = viewBlock(surface, item, { ...view, samplerFilters }, canvas.width / canvas.height);
        backend.draw(which, materials[which], shape, block, samples);
    });
}

async function frame() {
    asked = false;
    resize();
    // What is new is seen at once, and finely after that.
    const moving = exposed.factor === undefined || performance.now() - moved < REST;
    const samples = moving ? COARSE : FINE;
    await draw(samples);
    await expose(samples);
    if (exposed.factor === undefined) {
        // Something else was chosen meanwhile, and asked for.
        return;
    }
    backend.show(show, showBlock(samples, mode()));
    clearTimeout(resting);
    if (moving) {
        resting = setTimeout(ask, Math.max(moved + REST - performance.now(), 0));
    } else {
        await measure();
    }
}

/** Finds the exposure of what was drawn, unless it is known. */
async function expose(samples) {
    const mine = exposed;
    if (mine.factor === undefined || (!mine.isExact && samples === FINE)) {
        // That of what is nearer to the truth: the right one is what the left one is held against.
        backend.show(show, showBlock(samples, RADIANCE), FLOATS);
        mine.factor = autoExposure(await backend.read(FLOATS, everything()));
        mine.isExact = samples === FINE;
    }
}

/** One thing at a time is drawn or read, in turn. */
let drawing = Promise.resolve();
function inTurn(work) {
    const done = drawing.then(work);
    drawing = done.catch(() => undefined);
    return done;
}

/** Asks for a frame, however often. */
function ask() {
    isMeasured = false;
    if (!asked) {
        asked = true;
        requestAnimationFrame(() => inTurn(frame).catch(fail));
    }
}

function move() {
    moved = performance.now();
    ask();
}

/** What both fine pictures differ by. */
async function measure() {
    whole.textContent = '';
    if (!isPair()) {
        here.textContent = '';
        return undefined;
    }
    backend.show(show, showBlock(FINE, DELTA_E), FLOATS);
    const found = differences(await backend.read(FLOATS, everything()));
    whole.textContent = found.pixels > 0
        ? `ΔE of this view: ${found.mean.toFixed(2)} in the mean, ${found.p95.toFixed(2)} at 95 %`
        : 'Nothing here is shown by both.';
    isMeasured = true;
    await underPointer();
    return found;
}

async function underPointer() {
    isPointed = false;
    if (!isPair() || !pointer || !isMeasured) {
        here.textContent = isPair() ? 'Point at the picture for the ΔE there.' : '';
        return;
    }
    const [apart, , isSurface, isBoth] = await backend.read(FLOATS, [...pointer, 1, 1]);
    const without = isSurface > 0 ? 'one of both is not made for these directions' : 'no surface';
    here.textContent = `ΔE here: ${isBoth > 0 ? apart.toFixed(2) : without}`;
}

/** As many pixels as the canvas shows. */
function resize() {
    const { clientWidth, clientHeight } = stage;
    const scale = Math.min(devicePixelRatio, MOST_PIXELS / Math.max(clientWidth, clientHeight));
    const [width, height] = [clientWidth, clientHeight].map((side) => Math.max(Math.round(side * scale), 1));
    if (canvas.width !== width || canvas.height !== height || !backend.targets) {
        [canvas.width, canvas.height] = [width, height];
        backend.resize(width, height, FINE);
    }
}

/** The picture as it is shown, finely, as a PNG. */
async function picture() {
    await draw(FINE);
    await expose(FINE);
    backend.show(show, showBlock(FINE, mode()), BYTES);
    const shown = await backend.read(BYTES, everything());
    const flat = new OffscreenCanvas(canvas.width, canvas.height);
    flat.getContext('2d').putImageData(new ImageData(shown, canvas.width, canvas.height), 0, 0);
    return flat.convertToBlob({ type: 'image/png' });
}

/** Takes some of the state over, and draws it. */
function set(changes) {
    const before = [state.scene, state.left, state.right].join();
    Object.assign(state, changes);
    const item = page.items[state.left];
    if (isPair() && !scenesOf(page.items[state.right]).some(({ name }) => item.scenes.includes(name))) {
        state.right = -1;
    }
    const allowed = scenesOf(item).filter(({ name }) => !isPair() || page.items[state.right].scenes.includes(name));
    if (!allowed.includes(scene())) {
        state.scene = allowed[0].name;
    }
    if ([state.scene, state.left, state.right].join() !== before) {
        exposed = {};
        if (!before.startsWith(`${state.scene},`)) {
            Object.assign(state, { turn: still(), light: still(), zoom: 1 });
        }
    }
    tell();
    ask();
}

/** Puts the state into the controls. */
function tell() {
    const { scene: shown, left, right, mode, split, coarser, stops } = controls.elements;
    const items = [page.items[state.left], page.items[state.right]];
    [...shown.options].forEach((option) => {
        option.disabled = items.some((item) => item && !item.scenes.includes(option.value));
    });
    // A picture does not stand beside a ball.
    [...right.options].forEach((option) => {
        const scenes = page.items[Number(option.value)]?.scenes ?? items[0].scenes;
        option.disabled = !scenes.some((name) => items[0].scenes.includes(name));
    });
    [shown.value, left.value, right.value, mode.value] = [state.scene, state.left, state.right, state.mode];
    const most = Math.max(...items.map((item) => item?.levels ?? 0));
    find('levels').hidden = most === 0;
    coarser.max = most;
    coarser.value = state.coarser ?? 0;
    coarser.disabled = state.coarser === null;
    find('coarser-shown').textContent = state.coarser === null ? '' : `${state.coarser.toFixed(1)} levels coarser than the finest`;
    controls.elements.follows.checked = state.coarser === null;
    split.value = state.split;
    split.hidden = !isPair() || state.mode !== 'split';
    find('border').hidden = split.hidden;
    stage.style.setProperty('--split', `${100 * state.split}%`);
    find('modes').hidden = !isPair();
    find('scale').hidden = !isPair() || state.mode !== 'difference';
    stops.value = state.stops;
    find('facts').replaceChildren(...items.filter(Boolean).map(({ name, facts }) => {
        const [head, text] = [document.createElement('strong'), document.createElement('p')];
        head.textContent = name;
        text.append(head, ` ${facts}`);
        return text;
    }));
}

function listen() {
    // The slider over the picture belongs to the controls, but does not stand in them.
    document.addEventListener('input', ({ target }) => {
        if (target.form !== controls) {
            return;
        }
        const { name, value, type } = target;
        const number = Number(value);
        moved = type === 'range' ? performance.now() : moved;
        switch (name) {
            case 'scene': case 'mode': set({ [name]: value }); break;
            case 'left': case 'right': case 'stops': case 'split': set({ [name]: number }); break;
            case 'coarser': set({ coarser: number }); break;
            case 'follows': set({ coarser: target.checked ? null : Number(controls.elements.coarser.value) }); break;
        }
    });
    controls.addEventListener('submit', (event) => event.preventDefault());
    find('again').addEventListener('click', () => {
        exposed = {};
        set({ turn: still(), light: still(), zoom: 1, coarser: null, stops: 0 });
    });
    find('save').addEventListener('click', () => inTurn(picture).then((png) => {
        const link = document.createElement('a');
        link.href = URL.createObjectURL(png);
        link.download = `${page.items[state.left].name}.png`;
        link.click();
        setTimeout(() => URL.revokeObjectURL(link.href), 10000);
    }).catch(fail));
    const turn = (which, yaw, pitch) => {
        const before = state[which];
        const wanted = before.pitch + pitch;
        state[which] = { yaw: before.yaw + yaw, pitch: which === 'turn' ? raised(scene().camera, wanted) : wanted };
        move();
    };
    const zoom = (factor) => {
        state.zoom = Math.max(0.25, Math.min(8, state.zoom * factor));
        move();
    };
    // On the stage, as the canvas may be another one later; what lies on it besides has its own ways.
    const onCanvas = (name, heard, options) => stage.addEventListener(name, (event) => {
        if (event.target === canvas) {
            heard(event);
        }
    }, options);
    onCanvas('contextmenu', (event) => event.preventDefault());
    const point = () => {
        if (!isPointed) {
            isPointed = true;
            inTurn(underPointer).catch(fail);
        }
    };
    let before;
    onCanvas('pointerdown', (event) => {
        canvas.setPointerCapture(event.pointerId);
        before = [event.clientX, event.clientY];
    });
    onCanvas('pointermove', (event) => {
        const box = canvas.getBoundingClientRect();
        const pixel = (share, count) => Math.max(Math.min(Math.floor(share * count), count - 1), 0);
        pointer = [
            pixel((event.clientX - box.left) / box.width, canvas.width),
            pixel((event.clientY - box.top) / box.height, canvas.height),
        ];
        if (event.buttons === 0) {
            point();
            return;
        }
        const [x, y] = [event.clientX - before[0], event.clientY - before[1]];
        before = [event.clientX, event.clientY];
        const isLight = event.shiftKey || event.buttons === 2 || controls.elements.drags.value === 'light';
        // The surface follows the hand, and so does the light.
        turn(isLight ? 'light' : 'turn', (isLight ? 1 : -1) * DRAG * x, (isLight ? -1 : 1) * DRAG * y);
    });
    stage.addEventListener('pointerleave', () => {
        pointer = undefined;
        point();
    });
    onCanvas('wheel', (event) => {
        event.preventDefault();
        zoom(Math.exp(-0.001 * event.deltaY));
    }, { passive: false });
    onCanvas('keydown', (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        const which = event.shiftKey ? 'light' : 'turn';
        const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
        if (steps) {
            event.preventDefault();
            const way = which === 'turn' ? -PRESS : PRESS;
            turn(which, way * steps[0], way * steps[1]);
        } else if (event.key === '+' || event.key === '-') {
            zoom(event.key === '+' ? 1.1 : 1 / 1.1);
        }
    });
    addEventListener('hashchange', () => set(fromAddress()));
    new ResizeObserver(ask).observe(stage);
}

/** What an address asks for behind its #: scene, left and right by name, mode, coarser, api, embed. */
function fromAddress() {
    const number = (name) => page.items.findIndex((item) => item.name === name);
    let changes = {};
    for (const [key, value] of new URLSearchParams(location.hash.slice(1))) {
        if (key === 'scene' && page.scenes.some(({ name }) => name === value)) {
            changes.scene = value;
        } else if (key === 'left' && number(value) >= 0) {
            // Beside its source, unless something else is asked for.
            changes = { left: number(value), right: number(`${value}, source`), ...changes };
        } else if (key === 'right') {
            changes.right = number(value);
        } else if (key === 'mode' && ['one', 'split', 'difference'].includes(value)) {
            changes.mode = value;
        } else if (key === 'coarser' && Number(value) >= 0) {
            changes.coarser = Math.min(Number(value), Math.max(...page.items.map(({ levels }) => levels)));
        }
    }
    return changes;
}

/** Opens what draws: WebGPU where there is, else WebGL 2; `wanted`, if there is one, alone. */
async function open(wanted) {
    const lost = () => again().catch(fail);
    const wide = featuresOf(page.items);
    let found = wanted === 'webgl2' ? undefined : await WebGpu.open(canvas, wide, lost, fail).catch(() => undefined);
    found ??= wanted === 'webgpu' ? undefined : await WebGl.open(canvas, lost);
    if (!found) {
        throw new Error('there is neither WebGPU nor WebGL 2 with pictures of floats (EXT_color_buffer_float)');
    }
    backend = found;
    find('api').textContent = backend.name;
    made.clear();
    show = backend.program(programs.show, true);
}

/** Where a driver took everything away, the same by WebGL 2. A graphics process that ended is not there again at once. */
async function again() {
    for (; losses < MOST_LOSSES; losses += 1) {
        await new Promise((resolve) => setTimeout(resolve, 500));
        // A canvas keeps to the first context that it gave.
        const fresh = canvas.cloneNode();
        canvas.replaceWith(fresh);
        canvas = fresh;
        if (await open('webgl2').then(() => true, () => false)) {
            losses += 1;
            // What was asked of the lost one does not end, or ends badly.
            drawing = Promise.resolve();
            asked = false;
            wrong.hidden = true;
            ask();
            return;
        }
    }
    throw new Error(`the graphics driver gave up ${losses} times`);
}

async function start() {
    document.body.classList.toggle('embedded', given.has('embed'));
    programs = JSON.parse(new TextDecoder().decode(await unpacked(page.programs)));
    await open(given.get('api'));
    listen();
    set(fromAddress());
    await program(page.items[state.left].decoder);
    await new Promise(requestAnimationFrame);
    await drawing;
    return performance.now();
}

/** For scripts: when the first picture stood, in milliseconds from the start; changes; exposure; pictures; differences. */
globalThis.brdfcView = {
    first: start().catch(fail),
    state,
    set: async (changes) => {
        set(changes);
        await new Promise(requestAnimationFrame);
        await drawing;
    },
    exposure,
    picture: () => inTurn(picture),
    measure: () => inTurn(async () => {
        await draw(FINE);
        await expose(FINE);
        return measure();
    }),
    /** Pictures a second, each drawn as while something moves, and waited for. */
    speed: (count = 30) => inTurn(async () => {
        const [started, { turn }] = [performance.now(), state];
        for (let k = 0; k < count; k += 1) {
            state.turn = { yaw: 0.02 * k, pitch: 0 };
            await draw(COARSE);
            backend.show(show, showBlock(COARSE, mode()), BYTES);
            await backend.read(BYTES, [0, 0, 1, 1]);
        }
        state.turn = turn;
        return (1000 * count) / (performance.now() - started);
    }),
};
