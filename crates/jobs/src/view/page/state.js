// State of the page, from controls and addresses.

export const page = JSON.parse(document.getElementById('data').textContent);

export const still = () => ({ yaw: 0, pitch: 0 });
export const radians = (degrees) => (degrees * Math.PI) / 180;

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
};

export const scene = () => page.scenes.find(({ name }) => name === state.scene);
export const isPair = () => state.right >= 0;

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
        Object.assign(state, { turn: still(), light: changes.light ?? still(), zoom: 1 });
    }
    return ['scene', 'left', 'right'].some((key) => state[key] !== before[key]);
}

/** Reads changes from the fragment of the address: scene, left and right by name, mode, coarser, light. */
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
        }
    }
    return changes;
}
