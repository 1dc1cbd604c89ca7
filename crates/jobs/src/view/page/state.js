// What is shown, as controls and addresses say it.

export const page = JSON.parse(document.getElementById('data').textContent);

export const still = () => ({ yaw: 0, pitch: 0 });

export const state = {
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

export const scene = () => page.scenes.find(({ name }) => name === state.scene);
export const isPair = () => state.right >= 0;

/** Takes changes over, and what follows from them. Says whether another surface or another material is shown. */
export function take(changes) {
    const before = { ...state };
    Object.assign(state, changes);
    const item = page.items[state.left];
    const isOnBoth = (name) => item.scenes.includes(name) && (!isPair() || page.items[state.right].scenes.includes(name));
    if (!page.scenes.some(({ name }) => isOnBoth(name))) {
        state.right = -1;
    }
    if (!isOnBoth(state.scene)) {
        state.scene = page.scenes.find(({ name }) => isOnBoth(name)).name;
    }
    if (state.scene !== before.scene) {
        Object.assign(state, { turn: still(), light: still(), zoom: 1 });
    }
    return ['scene', 'left', 'right'].some((key) => state[key] !== before[key]);
}

/** What an address asks for behind its #: scene, left and right by name, mode, coarser, api, embed. */
export function fromAddress() {
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
