// Controls: they display the state, and change it with the pointer and the keyboard.

import { halfHeight, raised } from './camera.js';
import { chooseLight, listenToLights, moveLight, updateLights } from './lights.js';
import { comparable, freshLights, isImage, page, radians, scene, state, still } from './state.js';

/** Radians per dragged pixel, and per key press. */
const DRAG = 0.008;
const PRESS = 0.08;
/** Distances on the disc of lights per dragged pixel, and per key press. */
const LIGHT_DRAG = 0.005;
const LIGHT_PRESS = 0.04;
/** Pixels by which a key press moves an image. */
const PAN_PRESS = 20;

export const find = (id) => document.getElementById(id);
export const stage = find('stage');
const controls = document.querySelector('form');

/** Updates the controls from the state. */
export function updateControls() {
    const { scene: scenes, left, right, mode, split, coarser, stops } = controls.elements;
    const items = [page.items[state.left], page.items[state.right]];
    const isPair = items[1] !== undefined;
    [...scenes.options].forEach((option) => {
        option.disabled = items.some((item) => item && !item.scenes.includes(option.value));
    });
    [...right.options].forEach((option) => {
        option.disabled = !comparable(items[0], page.items[Number(option.value)] ?? items[0]);
    });
    [scenes.value, left.value, right.value, mode.value] = [state.scene, state.left, state.right, state.mode];
    const most = Math.max(...items.map((item) => item?.levels ?? 0));
    find('levels').hidden = most === 0;
    coarser.max = most;
    coarser.value = state.coarser ?? 0;
    coarser.disabled = state.coarser === null;
    find('coarser-shown').textContent = state.coarser === null ? '' : `${state.coarser.toFixed(1)} levels coarser than the finest`;
    controls.elements.follows.checked = state.coarser === null;
    split.value = state.split;
    split.hidden = !isPair || state.mode !== 'split';
    find('border').hidden = split.hidden;
    stage.style.setProperty('--split', `${100 * state.split}%`);
    find('modes').hidden = !isPair;
    find('scale').hidden = !isPair || state.mode !== 'difference';
    stops.value = state.stops;
    const isLit = items.some((item) => item?.needsEnvironment);
    find('environment').hidden = !isLit;
    controls.elements.behind.checked = state.behind;
    updateRotation();
    const isFlat = isImage();
    find('lights').hidden = !isFlat;
    ['surfaces', 'drags', 'turning'].forEach((id) => { find(id).hidden = isFlat; });
    find('images').hidden = !isFlat;
    if (isFlat) {
        updateLights();
    }
    const described = [...items, isLit ? page.environment : undefined].filter(Boolean);
    find('facts').replaceChildren(...described.map(({ name, facts }) => {
        const [head, text] = [document.createElement('strong'), document.createElement('p')];
        head.textContent = name;
        text.append(head, ` ${facts}`);
        return text;
    }));
}

/** Updates the slider that turns the environment. */
function updateRotation() {
    const degrees = (state.light.yaw * 180) / Math.PI;
    controls.elements.rotation.value = degrees - 360 * Math.round(degrees / 360);
}

/**
 * Listens to the controls and the canvas. `set` receives changes of the state and true if more of them will follow. `move` is called
 * when the view or the light moved. `point` receives the pointer's position as shares of the width and height, or undefined, and true
 * if no button is pressed.
 */
export function listen({ set, move, point, again, save }) {
    // The divider belongs to the form, but is not inside it.
    document.addEventListener('input', ({ target }) => {
        if (target.form !== controls) {
            return;
        }
        const { name, value, type } = target;
        const number = Number(value);
        const changes = {
            scene: () => ({ scene: value }),
            mode: () => ({ mode: value }),
            left: () => ({ left: number }),
            right: () => ({ right: number }),
            stops: () => ({ stops: number }),
            split: () => ({ split: number }),
            coarser: () => ({ coarser: number }),
            rotation: () => ({ light: { ...state.light, yaw: radians(number) } }),
            behind: () => ({ behind: target.checked }),
            follows: () => ({ coarser: target.checked ? null : Number(controls.elements.coarser.value) }),
        }[name]?.();
        if (changes) {
            set(changes, type === 'range');
        }
    });
    controls.addEventListener('submit', (event) => event.preventDefault());
    find('again').addEventListener('click', again);
    find('save').addEventListener('click', save);
    listenToLights(move);
    onPointer(point, move);
    onKeys(move);
}

function turn(which, yaw, pitch) {
    const before = state[which];
    const target = before.pitch + pitch;
    state[which] = { yaw: before.yaw + yaw, pitch: which === 'turn' ? raised(scene().camera, target) : target };
    updateRotation();
}

/** Moves an image with the pointer, by pixels. */
function pan(x, y) {
    const { clientWidth, clientHeight } = stage;
    const pixel = (2 * halfHeight(scene(), state.zoom, clientWidth / clientHeight)) / clientHeight;
    const limit = (k, by) => Math.max(-1, Math.min(1, state.pan[k] - by * pixel));
    state.pan = [limit(0, x), limit(1, y)];
}

function zoom(factor) {
    state.zoom = Math.max(0.25, Math.min(isImage() ? 64 : 8, state.zoom * factor));
}

/** Listens on the stage, because the canvas may be replaced, and ignores events of other elements on it. */
function onCanvas(name, handle, options) {
    stage.addEventListener(name, (event) => {
        if (event.target instanceof HTMLCanvasElement) {
            handle(event);
        }
    }, options);
}

function onPointer(point, move) {
    onCanvas('contextmenu', (event) => event.preventDefault());
    /** Positions of pressed pointers by id: one drags, two zoom. */
    const down = new Map();
    const spread = () => {
        const [a, b] = [...down.values()];
        return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    onCanvas('pointerdown', (event) => {
        event.target.setPointerCapture(event.pointerId);
        down.set(event.pointerId, [event.clientX, event.clientY]);
    });
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
        onCanvas(end, ({ pointerId }) => down.delete(pointerId));
    }
    onCanvas('pointermove', (event) => {
        const box = event.target.getBoundingClientRect();
        point([(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height], event.buttons === 0);
        const before = down.get(event.pointerId);
        if (event.buttons === 0 || !before) {
            // Another element received its end.
            down.delete(event.pointerId);
            return;
        }
        const apart = down.size === 2 ? spread() : 0;
        down.set(event.pointerId, [event.clientX, event.clientY]);
        if (apart > 0) {
            zoom(spread() / apart);
        } else {
            const [x, y] = [event.clientX - before[0], event.clientY - before[1]];
            const isOther = event.shiftKey || event.buttons === 2;
            if (isImage()) {
                if (isOther) {
                    pan(x, y);
                } else {
                    moveLight(LIGHT_DRAG * x, -LIGHT_DRAG * y);
                }
            } else {
                const isLight = isOther || controls.elements.drags.value === 'light';
                // The surface and the light follow the pointer.
                turn(isLight ? 'light' : 'turn', (isLight ? 1 : -1) * DRAG * x, (isLight ? -1 : 1) * DRAG * y);
            }
        }
        move();
    });
    stage.addEventListener('pointerleave', () => point(undefined, true));
    onCanvas('wheel', (event) => {
        event.preventDefault();
        zoom(Math.exp(-0.001 * event.deltaY));
        move();
    }, { passive: false });
}

function onKeys(move) {
    onCanvas('keydown', (event) => {
        if (event.ctrlKey || event.metaKey || event.altKey) {
            return;
        }
        const which = event.shiftKey ? 'light' : 'turn';
        const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
        if (steps) {
            event.preventDefault();
            if (isImage()) {
                const [x, y] = steps;
                if (event.shiftKey) {
                    pan(-PAN_PRESS * x, PAN_PRESS * y);
                } else {
                    moveLight(LIGHT_PRESS * x, LIGHT_PRESS * y);
                }
            } else {
                const way = which === 'turn' ? -PRESS : PRESS;
                turn(which, way * steps[0], way * steps[1]);
            }
            move();
        } else if (event.key === '+' || event.key === '-') {
            zoom(event.key === '+' ? 1.1 : 1 / 1.1);
            move();
        } else if (isImage() && ['1', '2', '3'].includes(event.key)) {
            chooseLight(Number(event.key) - 1);
        }
    });
}

/** State that "Reset" sets. */
export const FRESH = () => ({
    turn: still(),
    light: still(),
    behind: true,
    zoom: 1,
    coarser: null,
    stops: 0,
    lights: freshLights(),
    chosen: 0,
    pan: [0, 0],
});
