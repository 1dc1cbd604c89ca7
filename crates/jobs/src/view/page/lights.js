// Lights of images: a disc with a handle for each light, and the photographs that are nearest to them.

import { freshLights, imageLight, page, state } from './state.js';

const SVG = 'http://www.w3.org/2000/svg';
const MAX_LIGHTS = 3;
/** Largest distance from the middle of the disc: a light 5° above the surface. */
const MAX_RADIUS = Math.cos((5 * Math.PI) / 180);
/** Distance on the disc within which a click selects the light of a photograph, or a handle. */
const NEAR = 0.07;

const disc = /** @type {SVGSVGElement} */ (/** @type {unknown} */ (document.getElementById('disc')));
const cosine = (a, b) => a.reduce((sum, c, k) => sum + c * b[k], 0);
const degrees = (cosine) => (Math.acos(Math.max(-1, Math.min(1, cosine))) * 180) / Math.PI;

/** Numbers of the photographs that are nearest to these lights; the first image if none depends on the light. */
export function nearest({ photographs }, lights) {
    if (photographs[0].light === null) {
        return [0];
    }
    const best = (direction) => photographs.reduce((best, { light }, number) => (
        cosine(light, direction) > cosine(photographs[best].light, direction) ? number : best
    ), 0);
    return lights.map(({ direction }) => best(direction));
}

/** The selected material with photographs under known lights, or else any on the page. */
function photographed() {
    const isOne = (item) => item?.photographs[0]?.light;
    return [page.items[state.right], page.items[state.left], ...page.items].find(isOne);
}

/** Moves the selected light to a place on the disc: x and y of its direction. */
export function placeLight(x, y) {
    const scale = Math.min(1, MAX_RADIUS / Math.max(Math.hypot(x, y), 1e-9));
    const lights = [...state.lights];
    lights[state.chosen] = { ...lights[state.chosen], ...imageLight(x * scale, y * scale) };
    state.lights = lights;
    updateLights();
}

/** Selects a light by its number, if there is one. */
export function chooseLight(number) {
    if (number < state.lights.length) {
        state.chosen = number;
        updateLights();
    }
}

/** Moves the selected light by steps on the disc. */
export function moveLight(x, y) {
    const [before, after] = state.lights[state.chosen].direction;
    placeLight(before + x, after + y);
}

/** Describes the selected light, and the nearest photograph. */
function described(item) {
    const { direction } = state.lights[state.chosen];
    const of = ([x, y, z]) => {
        const azimuth = Math.round((Math.atan2(y, x) * 180) / Math.PI + 360) % 360;
        return `${Math.round(degrees(z))}° from the vertical, azimuth ${azimuth}°`;
    };
    const light = `Light ${state.chosen + 1}: ${of(direction)}.`;
    if (!item) {
        return light;
    }
    const { name, light: its } = item.photographs[nearest(item, [state.lights[state.chosen]])[0]];
    return `${light} Nearest photograph: ${name}, ${of(its)}, ${degrees(cosine(its, direction)).toFixed(1)}° from the light.`;
}

/** Updates the disc and its texts from the state. */
export function updateLights() {
    const item = photographed();
    const circle = ([x, y], radius, name) => {
        const found = document.createElementNS(SVG, 'circle');
        Object.entries({ cx: x, cy: -y, r: radius, class: name }).forEach(([key, value]) => found.setAttribute(key, value));
        return found;
    };
    const dots = item?.photographs.map(({ light }) => circle(light, 0.025, 'dot')) ?? [];
    const used = item ? nearest(item, state.lights) : [];
    used.forEach((number) => dots[number].classList.add('used'));
    const handles = state.lights.map(({ direction }, number) => circle(direction, 0.06, number === state.chosen ? 'handle chosen' : 'handle'));
    disc.replaceChildren(circle([0, 0], 1, 'rim'), ...dots, ...handles);
    document.getElementById('light').textContent = described(item);
    const [add, remove, brightness] = ['add', 'remove', 'brightness'].map((id) => document.getElementById(id));
    add.disabled = state.lights.length === MAX_LIGHTS;
    remove.disabled = state.lights.length === 1;
    brightness.value = state.lights[state.chosen].brightness;
}

/** Listens to the disc and its buttons. `move` is called after changes. */
export function listenToLights(move) {
    const at = ({ clientX, clientY }) => {
        const { left, top, width, height } = disc.getBoundingClientRect();
        return [((clientX - left) / width - 0.5) * 2.2, (0.5 - (clientY - top) / height) * 2.2];
    };
    const within = ([x, y], [a, b], limit = NEAR) => Math.hypot(x - a, y - b) < limit;
    const change = (changes) => {
        Object.assign(state, changes);
        updateLights();
        move();
    };
    disc.addEventListener('pointerdown', (event) => {
        event.preventDefault();
        document.getElementById('canvas').focus();
        disc.setPointerCapture(event.pointerId);
        const place = at(event);
        const handle = state.lights.findIndex(({ direction }) => within(direction, place));
        if (handle >= 0) {
            change({ chosen: handle });
            return;
        }
        const away = ({ light }) => Math.hypot(light[0] - place[0], light[1] - place[1]);
        const dot = photographed()?.photographs.reduce((best, other) => (away(other) < away(best) ? other : best));
        placeLight(...(dot && away(dot) < NEAR ? dot.light : place));
        move();
    });
    disc.addEventListener('pointermove', (event) => {
        // Ignores small movements during a click.
        if (event.buttons !== 0 && !within(at(event), state.lights[state.chosen].direction, 0.02)) {
            placeLight(...at(event));
            move();
        }
    });
    document.getElementById('add').addEventListener('click', () => {
        const [x, y] = state.lights.at(-1).direction;
        // Opposite, so that it is visible at once.
        change({ lights: [...state.lights, { ...imageLight(-x, state.lights.length === 1 ? y : -y), brightness: 0.5 }], chosen: state.lights.length });
    });
    document.getElementById('remove').addEventListener('click', () => {
        change({ lights: state.lights.filter((_, number) => number !== state.chosen), chosen: 0 });
    });
    document.getElementById('brightness').addEventListener('input', ({ target }) => {
        const lights = [...state.lights];
        lights[state.chosen] = { ...lights[state.chosen], brightness: Number(target.value) };
        change({ lights });
    });
}
