"""A ball of a source, by Mitsuba's own `measured`, compared with a ball of its pack, by the plugin: ΔE between the renderings."""

import json
import os
from typing import NamedTuple

import mitsuba as mi
import numpy as np

from common import RED, pack, run

SIZE = 64
# Samples per pixel, square numbers: under the synthetic environment, and under the photographed one, which is noisier.
SAMPLES, MANY_SAMPLES = 1024, 4096
# Samples per pixel of the saved rendering.
LARGE_SIZE, FEW_SAMPLES = 128, 256
# Maximum mean ΔE: half of a just visible difference, plus the loss of the converted file.
MAX_DELTA_E = 1.0
# Maximum error of albedos: a converted file with a larger error no longer represents its source.
MAX_LOST = 0.05

# XYZ of linear sRGB, D65.
TO_XYZ = np.array([
    [0.4123908, 0.3575843, 0.1804808],
    [0.2126390, 0.7151687, 0.0721923],
    [0.0193308, 0.1191948, 0.9505322],
])


def lab(image):
    """L*a*b* of linear sRGB, without a transfer curve."""
    relative = image @ TO_XYZ.T / TO_XYZ.sum(axis=1)
    cut = 6.0 / 29.0
    f = np.where(relative > cut**3, np.cbrt(relative), relative / (3.0 * cut * cut) + 4.0 / 29.0)
    return np.stack([116.0 * f[..., 1] - 16.0, 500.0 * (f[..., 0] - f[..., 1]), 200.0 * (f[..., 1] - f[..., 2])], axis=-1)


def differences(image, reference, exposure):
    """ΔE (CIE76) of each pixel of two renderings, with the same exposure and clipping."""
    a, b = (lab(np.clip(rendering * exposure, 0.0, 1.0)) for rendering in (image, reference))
    return np.linalg.norm(a - b, axis=-1)


def sky():
    """A synthetic environment, 64 x 128: blue above, brown below, a window and a small lamp."""
    y, x = np.mgrid[0:64, 0:128]
    up = np.cos(np.pi * (y + 0.5) / 64)[..., None]
    image = np.where(up > 0.0, 0.3 + up * [0.1, 0.3, 0.7], 0.2 + up * [0.05, 0.1, 0.15])
    image[14:30, 20:32] = [6.0, 5.5, 5.0]
    image[10:14, 86:90] = [60.0, 50.0, 35.0]
    return mi.Bitmap(np.ascontiguousarray(image, dtype=np.float32))


def ball(bsdf, light, seed, samples, size=SIZE):
    """Renders a ball in linear RGB; returns the image and a mask of the ball."""
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2, "hide_emitters": True},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
            "sampler": {"type": "multijitter", "sample_count": samples},
            "film": {"type": "hdrfilm", "width": size, "height": size, "rfilter": {"type": "box"}},
        },
        # Poles at top and bottom, so that tangents follow circles of latitude.
        "ball": {
            "type": "sphere",
            "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
            "bsdf": bsdf,
        },
        "light": {"type": "envmap", **light},
    })
    image = np.array(mi.render(scene, spp=samples, seed=seed))[..., :3].astype(np.float64)
    x = (np.arange(size) + 0.5) / (size / 2) - 1.0
    return image, np.hypot(*np.meshgrid(x, x)) < 0.98


class Comparison(NamedTuple):
    """Two renderings, their exposure, the mask of the ball, the mean ΔE, and a text with ΔE and noise."""

    reference: np.ndarray
    image: np.ndarray
    exposure: float
    inside: np.ndarray
    error: float
    figure: str


def compare(own, ours, light, samples):
    """Renders a ball with Mitsuba's own plugin, and one of a pack, the latter twice to measure its noise."""
    reference, inside = ball(own, light, 1, samples)
    image, _ = ball(ours, light, 2, samples)
    again, _ = ball(ours, light, 3, samples)
    exposure = 1.0 / np.percentile(reference[inside].max(axis=-1), 98.0)
    error = differences(image, reference, exposure)[inside]
    noise = differences(image, again, exposure)[inside]
    figure = f"ΔE {error.mean():.2f}, 95 %: {np.percentile(error, 95):.2f}; two renderings: {noise.mean():.2f}"
    return Comparison(reference, image, exposure, inside, error.mean(), figure)


def converted(name, source, folder):
    """Converts a source to a file of Mitsuba's `measured`; returns it and the largest error of its albedos."""
    path = os.path.join(folder, f"{name}.bsdf")
    report = json.loads(run("convert", source, "-o", path, "--quiet", "--json"))
    albedos = [np.subtract(angle["reference"], angle["approximation"]) for angle in report["albedo"]]
    return {"type": "measured", "filename": path}, np.abs(albedos).max()


def check_demo(results, folder, rendering):
    """Demo materials under the synthetic environment, as files of `brdfc convert`; the sheet is saved if requested."""
    light = {"bitmap": sky()}
    columns = []
    for name, source in (("plastic", RED), ("brushed", "synth:ward?kd=0.2&ax=0.1&ay=0.4"), ("satin", "synth:ggx?alpha=0.4")):
        own, _ = converted(name, source, folder)
        ours = {"type": "brdfc", "filename": pack(name, folder)}
        found = compare(own, ours, light, SAMPLES)
        if rendering:
            both = [ball(bsdf, light, 1, FEW_SAMPLES, LARGE_SIZE)[0] for bsdf in (own, ours)]
            columns.append(np.concatenate(both, axis=0) * found.exposure)
        results.add(f"ball of {name}: measured (converted), brdfc", found.error < MAX_DELTA_E, found.figure)
    if rendering:
        sheet = np.concatenate(columns, axis=1).astype(np.float32)
        bitmap = mi.Bitmap(np.clip(sheet, 0.0, 1.0))
        bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True).write(rendering)
    # Another material must be detected.
    own, _ = converted("plastic", RED, folder)
    found = compare(own, {"type": "brdfc", "filename": pack("brushed", folder)}, light, SAMPLES)
    results.add("ball of plastic: another pack is detected", found.error > MAX_DELTA_E, found.figure)


def check_data(results, folder, data):
    """Measured materials under a photographed environment; both are not part of the repository."""
    museum = os.path.join(data, "env/museum.exr")
    materials = {}
    for name in ("cc_ibiza_sunset", "colodur_napoli_4f", "paper_white", "vch_golden_yellow"):
        materials[name] = os.path.join(data, "rgl", f"{name}_rgb.bsdf")
    for name in ("chrome", "red-plastic"):
        materials[name] = os.path.join(data, "merl", f"{name}.binary")
    for name, source in materials.items():
        missing = [path for path in (museum, source) if not os.path.isfile(path)]
        if missing:
            results.skip(f"ball of {name}", f"no {os.path.basename(missing[0])} in the folder of measured data")
            continue
        is_rgl = source.endswith(".bsdf")
        own, lost = ({"type": "measured", "filename": source}, 0.0) if is_rgl else converted(name, source, folder)
        file = os.path.join(folder, f"{name}.ktx2")
        run("encode", source, "-o", file, "--quiet")
        light = {"filename": museum}
        # `measured` exchanges viewer and light of its files, which changes renderings of materials that are not reciprocal.
        ours = {"type": "brdfc", "filename": file, "exchanged": True}
        found = compare(own, ours, light, MANY_SAMPLES)
        plain, _ = ball({**ours, "exchanged": False}, light, 2, MANY_SAMPLES)
        plain = differences(plain, found.reference, found.exposure)[found.inside].mean()
        how = "measured" if is_rgl else "measured (converted)"
        if lost > MAX_LOST:
            figure = f"{found.figure}, but `brdfc convert` changed its albedo by up to {lost:.3f}"
            results.skip(f"ball of {name}: {how}, brdfc", figure)
            continue
        results.add(f"ball of {name}: {how}, brdfc", found.error < MAX_DELTA_E, f"{found.figure}; not exchanged: {plain:.2f}")


def check(results, folder, data, rendering):
    """Adds all lines; `rendering` is the path for the sheet of demo materials, or None."""
    check_demo(results, folder, rendering)
    check_data(results, folder, data)
