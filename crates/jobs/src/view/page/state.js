// State of the page, from controls and addresses.

export const page = JSON.parse(document.getElementById('data').textContent);

export const still = () => ({ yaw: 0, pitch: 0 });
export const radians = (degrees) => (degrees * Math.PI) / 180;

/** A distant light of an image: its unit vector, from x to the right and y up. */
export const imageLight = (x, y) => ({ direction: [x, y, Math.sqrt(Math.max(1 - x * x - y * y, 0))] });
/** Light of images at first, that of their scene, turned by an angle about the vertical. */
export function freshLights(yaw = 0) {
    const { position } = page.scenes.find(({ halfSides }) => halfSides)?.lights[0] ?? { position: [0, 1, 0] };
    const distance = Math.hypot(...position);
    const [x, y] = [position[0] / distance, -position[2] / distance];
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    return [{ ...imageLight(x * c - y * s, y * c + x * s), brightness: 1 }];
}

export const state = {
    scene: page.items[0].scenes[0],
    left: 0,
    right: page.items.length > 1 ? 1 : -1,
    mode: 'split',
    split: 0.5,
    /** Levels coarser than the finest; null: from the distance, or from the size of a pixel. */
    coarser: null,
    stops: 0,
    turn: still(),
    /** Rotation of the lights; `yaw` is also that of the environment. */
    light: still(),
    /** True to show the environment behind materials that it lights. */
    behind: true,
    zoom: 1,
    /** Lights of images, the number of the one that controls move, and the middle of the view on the image. */
    lights: freshLights(),
    chosen: 0,
    pan: [0, 0],
};

export const scene = () => page.scenes.find(({ name }) => name === state.scene);
/** True if the surface is a flat image under distant lights. */
export const isImage = () => scene().halfSides !== null;
export const isPair = () => state.right >= 0;

/** True if the difference of the selected pair is that of colours; normals have none. */
export const isCompared = () => isPair() && [state.left, state.right].every((number) => page.items[number].photographs[0]?.light !== null);

/** True if two materials can be compared: on a common surface, under the same kind of light. */
export function comparable(a, b) {
    return a.needsEnvironment === b.needsEnvironment && a.scenes.some((name) => b.scenes.includes(name));
}

/** Applies changes and their consequences. Returns true if the surface or a material changed. */
export function take(changes) {
    const before = { ...state };
    Object.assign(state, changes);
    const item = page.items[state.left];
    if (isPair() && !comparable(item, page.items[state.right])) {
        state.right = -1;
    }
    const isOnBoth = (name) => item.scenes.includes(name) && (!isPair() || page.items[state.right].scenes.includes(name));
    if (!isOnBoth(state.scene)) {
        state.scene = page.scenes.find(({ name }) => isOnBoth(name)).name;
    }
    if (state.scene !== before.scene) {
        Object.assign(state, { turn: still(), light: changes.light ?? still(), zoom: 1, pan: [0, 0] });
    }
    return ['scene', 'left', 'right'].some((key) => state[key] !== before[key]);
}

/** Reads changes from the fragment of the address: scene, left and right by name, mode, coarser, light (degrees, or x,y;x,y). */
export function fromAddress() {
    const number = (name) => page.items.findIndex((item) => item.name === name);
    let changes = {};
    for (const [key, value] of new URLSearchParams(location.hash.slice(1))) {
        if (key === 'scene' && page.scenes.some(({ name }) => name === value)) {
            changes.scene = value;
        } else if (key === 'left' && number(value) >= 0) {
            // Next to its source, unless the address names another material.
            changes = { left: number(value), right: number(`${value}, source`), ...changes };
        } else if (key === 'right') {
            changes.right = number(value);
        } else if (key === 'mode' && ['one', 'split', 'difference'].includes(value)) {
            changes.mode = value;
        } else if (key === 'coarser' && Number(value) >= 0) {
            changes.coarser = Math.min(Number(value), Math.max(...page.items.map(({ levels }) => levels)));
        } else if (key === 'light' && Number.isFinite(Number(value))) {
            changes.light = { yaw: radians(Number(value)), pitch: 0 };
            changes.lights = freshLights(changes.light.yaw);
        } else if (key === 'light') {
            const places = value.split(';').slice(0, 3).map((text) => text.split(',').map(Number));
            if (places.every((place) => place.length === 2 && Math.hypot(...place) < 1)) {
                changes.lights = places.map(([x, y]) => ({ ...imageLight(x, y), brightness: 1 }));
                changes.chosen = 0;
            }
        }
    }
    return changes;
}
