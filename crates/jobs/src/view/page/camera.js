// Cameras and lights.

const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const unit = (v) => v.map((c) => c / Math.hypot(...v));
const minus = (a, b) => a.map((c, k) => c - b[k]);
const plus = (a, b) => a.map((c, k) => c + b[k]);

/** Turns a vector about a unit axis (Rodrigues). */
function turned(v, axis, angle) {
    const [c, s] = [Math.cos(angle), Math.sin(angle)];
    const [across, along] = [cross(axis, v), dot(axis, v) * (1 - c)];
    return v.map((x, k) => x * c + across[k] * s + axis[k] * along);
}

const UP = [0, 1, 0];
const RIGHT_ANGLE = Math.PI / 2;
/** Largest elevation of the viewer, which keeps it off the poles. */
const MAX_ELEVATION = RIGHT_ANGLE - 0.01;

/** Unit vectors right, up and forward of a scene's camera. */
function basis({ eye, target, up }) {
    const forward = unit(minus(target, eye));
    const right = unit(cross(forward, up));
    return { right, up: cross(right, forward), forward };
}

/** Limits an angle by which the camera is raised, so that it does not pass the poles. */
export function raised(camera, pitch) {
    const elevation = Math.asin(Math.max(-1, Math.min(1, -basis(camera).forward[1])));
    const most = Math.max(MAX_ELEVATION, elevation);
    return Math.max(-most, Math.min(most, elevation + pitch)) - elevation;
}

/** Turns a vector from the target about the camera's right axis (pitch) and the vertical (yaw). */
function around(camera, v, { yaw, pitch }) {
    return turned(turned(v, basis(camera).right, -pitch), UP, yaw);
}

/** Share of the view that an image fills along one of its sides. */
const FILLED = 0.98;

/** Half the height of the view of an image, in scene units. `aspect` is width over height. */
export function halfHeight({ halfSides: [width, height] }, zoom, aspect) {
    return Math.max(height, width / aspect) / (FILLED * zoom);
}

/** A point light as far away and, at brightness 1, as bright as the light of the scene of an image. */
function distantLight({ lights: [far] }, { direction: [x, y, z], brightness }) {
    const distance = Math.hypot(...far.position);
    return { position: [x, z, -y].map((c) => c * distance), intensity: far.intensity.map((c) => c * brightness) };
}

/** The camera of an image, moved so that the image fills the view. */
function imageCamera(scene, { pan, zoom }, aspect) {
    const { camera } = scene;
    const tangent = Math.tan((camera.fieldOfView * Math.PI) / 360) / Math.min(aspect, 1);
    const target = [pan[0], 0, pan[1]];
    return { ...camera, target, eye: [pan[0], halfHeight(scene, zoom, aspect) / tangent, pan[1]] };
}

/** Lights of a material. An image without a light is as bright under any. */
function lightsOf(scene, item, view) {
    if (item.needsEnvironment) {
        return [];
    }
    const isUnlit = item.photographs?.[0]?.light === null;
    const distant = isUnlit ? [{ direction: [0, 0, 1], brightness: 1 }] : view.lights;
    return scene.halfSides ? distant.map((light) => distantLight(scene, light)) : scene.lights;
}

/**
 * Writes the uniform block of a rendering, with the layout of `View` in view.wgsl.
 *
 * @param scene the page's scene
 * @param item the page's material
 * @param view `turn`, `light`: { yaw, pitch }, `lights` and `pan` of images, `zoom`, `coarser`, `samples`
 * @param {number} aspect width over height
 */
export function viewBlock(scene, item, view, aspect) {
    const isImage = scene.halfSides !== null;
    const camera = isImage ? imageCamera(scene, view, aspect) : scene.camera;
    const lights = lightsOf(scene, item, view);
    const place = (point, turn, scale) =>
        plus(camera.target, around(camera, minus(point, camera.target), turn).map((c) => c * scale));
    const eye = place(camera.eye, view.turn, isImage ? 1 : 1 / view.zoom);
    const { right, up, forward } = basis({ ...camera, eye, up: around(camera, camera.up, view.turn) });
    // Tall, narrow views show the same width as square ones.
    const half = Math.tan((camera.fieldOfView * Math.PI) / 360) / Math.min(aspect, 1);
    const block = new ArrayBuffer(112 + 32 * 8);
    const floats = new Float32Array(block);
    const words = new Uint32Array(block);
    floats.set(eye, 0);
    floats.set(right.map((c) => c / (half * aspect)), 4);
    floats.set(up.map((c) => c / half), 8);
    floats.set(forward, 12);
    floats.set(item.sines, 16);
    // The finest level of BRDFs is the last, that of textures the first.
    const level = item.finest > 0 ? Math.max(item.finest - view.coarser, 0) : view.coarser;
    // Lights turn about two axes, the environment only about the vertical, so that its horizon stays level.
    floats.set([Math.cos(view.light.yaw), Math.sin(view.light.yaw)], 20);
    floats.set([view.coarser === null ? -1 : level, Math.log2(view.samples), item.repeats[scene.name] ?? 1], 22);
    words.set([lights.length], 25);
    lights.forEach(({ position, intensity }, k) => {
        floats.set(isImage ? position : place(position, view.light, 1), 28 + 8 * k);
        floats.set(intensity, 32 + 8 * k);
    });
    return new Uint8Array(block);
}
