// Controls: what they say of the state, and what hands do to them and to the rendering.

import { raised } from './camera.js';
import { page, scene, state, still } from './state.js';

/** Radians for each pixel that a pointer is dragged, and for each press of a key. */
const DRAG = 0.008;
const PRESS = 0.08;

export const find = (id) => document.getElementById(id);
export const stage = find('stage');
const controls = document.querySelector('form');

/** Puts the state into the controls. */
export function tell() {
    const { scene: shown, left, right, mode, split, coarser, stops } = controls.elements;
    const items = [page.items[state.left], page.items[state.right]];
    const isPair = items[1] !== undefined;
    [...shown.options].forEach((option) => {
        option.disabled = items.some((item) => item && !item.scenes.includes(option.value));
    });
    // A rendering does not stand beside a ball.
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
    split.hidden = !isPair || state.mode !== 'split';
    find('border').hidden = split.hidden;
    stage.style.setProperty('--split', `${100 * state.split}%`);
    find('modes').hidden = !isPair;
    find('scale').hidden = !isPair || state.mode !== 'difference';
    stops.value = state.stops;
    find('facts').replaceChildren(...items.filter(Boolean).map(({ name, facts }) => {
        const [head, text] = [document.createElement('strong'), document.createElement('p')];
        head.textContent = name;
        text.append(head, ` ${facts}`);
        return text;
    }));
}

/**
 * Listens to the controls and to the rendering. `set` hears changes of the state, and whether more of the same is to come; `move`
 * that a hand moved something; `point` the share of the rendering's width and height that the pointer is at, or nothing, and whether
 * it does no more than point.
 */
export function listen({ set, move, point, again, save }) {
    // The slider over the rendering belongs to the controls, but does not stand in them.
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
            follows: () => ({ coarser: target.checked ? null : Number(controls.elements.coarser.value) }),
        }[name]?.();
        if (changes) {
            set(changes, type === 'range');
        }
    });
    controls.addEventListener('submit', (event) => event.preventDefault());
    find('again').addEventListener('click', again);
    find('save').addEventListener('click', save);
    onRendering(point, move);
    onKeys(move);
}

function turn(which, yaw, pitch) {
    const before = state[which];
    const wanted = before.pitch + pitch;
    state[which] = { yaw: before.yaw + yaw, pitch: which === 'turn' ? raised(scene().camera, wanted) : wanted };
}

function zoom(factor) {
    state.zoom = Math.max(0.25, Math.min(8, state.zoom * factor));
}

/** On the stage, as the canvas may be another one later; what lies on it besides has its own ways. */
function onCanvas(name, heard, options) {
    stage.addEventListener(name, (event) => {
        if (event.target instanceof HTMLCanvasElement) {
            heard(event);
        }
    }, options);
}

function onRendering(point, move) {
    onCanvas('contextmenu', (event) => event.preventDefault());
    /** Pointers that are down, by their number: one drags, two go nearer and farther. */
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
            // Its end was heard by somebody else.
            down.delete(event.pointerId);
            return;
        }
        const apart = down.size === 2 ? spread() : 0;
        down.set(event.pointerId, [event.clientX, event.clientY]);
        if (apart > 0) {
            zoom(spread() / apart);
        } else {
            const [x, y] = [event.clientX - before[0], event.clientY - before[1]];
            const isLight = event.shiftKey || event.buttons === 2 || controls.elements.drags.value === 'light';
            // The surface follows the hand, and so does the light.
            turn(isLight ? 'light' : 'turn', (isLight ? 1 : -1) * DRAG * x, (isLight ? -1 : 1) * DRAG * y);
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
            const way = which === 'turn' ? -PRESS : PRESS;
            turn(which, way * steps[0], way * steps[1]);
            move();
        } else if (event.key === '+' || event.key === '-') {
            zoom(event.key === '+' ? 1.1 : 1 / 1.1);
            move();
        }
    });
}

/** What "Start again" sets. */
export const FRESH = () => ({ turn: still(), light: still(), zoom: 1, coarser: null, stops: 0 });
