"""The plugin's decoders compared with those of the program (by the wheel), for packs of all forms."""

import glob
import os

import brdfc
import drjit as dr
import mitsuba as mi
import numpy as np

from common import GOLDEN, PACKS, pack, pairs

# Maximum error relative to the value plus με.
BOUND = 1e-4
COUNT = 10_000


def values(bsdf, wi, wo):
    """Values of f cos θ_i of the plugin for light at wi and viewer at wo: arrays of shape (N, 3)."""
    context = mi.BSDFContext()
    if dr.is_jit_v(mi.Float):
        interaction = dr.zeros(mi.SurfaceInteraction3f, len(wi))
        interaction.wi = mi.Vector3f(wo.T)
        return np.array(bsdf.eval(context, interaction, mi.Vector3f(wi.T))).T
    found = []
    for i, o in zip(wi.tolist(), wo.tolist()):
        interaction = mi.SurfaceInteraction3f()
        interaction.wi = mi.Vector3f(o)
        found.append(list(bsdf.eval(context, interaction, mi.Vector3f(i))))
    return np.array(found)


def largest_error(file, lod, wi, wo):
    """The largest error, the largest error for other pairs, and the number of nonzero values."""
    material = brdfc.open(file)
    level = {} if lod is None else {"lod": lod}
    found = values(mi.load_dict({"type": "brdfc", "filename": file, **level}), wi, wo).astype(np.float64)
    # Directions without normalisation: their lengths are not exactly 1 in single precision.
    expected = material.eval(wi, wo, lod).astype(np.float64)
    cosine = np.maximum(wi[:, 2:].astype(np.float64), 0.0)
    floor = material.facts["mean"] * material.facts["bias"]
    allowed = cosine * (expected + floor)
    lit = (wi[:, 2] > 0.0) & (wo[:, 2] > 0.0)
    if found[~lit].any():
        return np.inf, 1.0, 0
    error = np.abs(found - cosine * expected)
    shifted = np.abs(np.roll(found, 1, axis=0) - cosine * expected)
    return (error[lit] / allowed[lit]).max(), (shifted[lit] / allowed[lit]).max(), np.count_nonzero(expected.any(axis=1))


def files(folder):
    """Packs by kind: those of the corpus, and some that are made here."""
    made = [pack(name, folder) for name in PACKS if name not in ("white", "grey")]
    golden = {
        kind: sorted(glob.glob(os.path.join(GOLDEN, kind, "golden", "*.ktx2"))) for kind in ("table", "wavelet")
    }
    for file in made:
        golden["wavelet" if brdfc.open(file).kind == "wavelet-pack" else "table"].append(file)
    return golden


def check(results, folder, count, most=None):
    """Adds a line for each kind: `count` pairs for each of at most `most` packs."""
    random = np.random.default_rng(5)
    for kind, all_files in files(folder).items():
        worst, unnoticed, cases = (0.0, ""), [], 0
        step = 1 if most is None else max(len(all_files) // most, 1)
        for file in all_files[::step]:
            finest = brdfc.open(file).levels
            for lod in [None] if finest == 0 else [None, 0.0, 0.6 * finest]:
                # Half vectors at the normal have no azimuth. With arbitrary texels the value depends on its rounding; scalar
                # variants compute in double precision.
                mirror = "any-texels" not in file and dr.is_jit_v(mi.Float)
                wi, wo = pairs(random, count, mirror)
                error, other, lit = largest_error(file, lod, wi, wo)
                name = f"{os.path.basename(file)}{'' if lod is None else f', level {lod:g}'}"
                worst = max(worst, (error, name))
                cases += 1
                if lit < count // 4 or other <= BOUND:
                    unnoticed.append(name)
        what = f"{kind} packs, {cases} cases of {count} pairs ({mi.variant()})"
        results.add(what, worst[0] < BOUND, f"largest error {worst[0]:.1e} of f + με: {worst[1]}")
        results.add(f"{kind} packs: answers of other pairs are detected", not unnoticed, ", ".join(unnoticed) or "all")
