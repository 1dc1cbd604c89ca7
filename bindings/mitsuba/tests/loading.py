"""Accepted and rejected parameters, and a rendering in the current variant."""

import os

import mitsuba as mi
import numpy as np

import brdfc_mitsuba
from common import RED, pack


def refusal(parameters):
    """Returns the error of invalid parameters."""
    try:
        mi.load_dict({"type": "brdfc", **parameters})
    except (RuntimeError, ValueError, OSError) as error:
        return str(error)
    return ""


def check(results, folder):
    """Adds all lines."""
    file, missing = pack("plastic", folder), os.path.join(folder, "nothing.ktx2")
    cases = {
        "a file that is missing": ({"filename": missing}, f"{missing}: cannot read: No such file or directory"),
        "a file that is no pack": ({"filename": RED}, "a merl, expected a pack of a BRDF"),
        "a level that there is not": ({"filename": file, "lod": 3.0}, "lod: found 3, expected 0 to 0, the pack's levels"),
        "a level that is a text": ({"filename": file, "lod": "fine"}, "lod: found fine, expected 0 to 0, the pack's levels"),
        "a text for a truth": ({"filename": file, "exchanged": "yes"}, "exchanged: found yes, expected true or false"),
        "no file": ({}, "filename"),
        "an unknown parameter": ({"filename": file, "level": 1.0}, "level"),
    }
    for what, (parameters, expected) in cases.items():
        text = refusal(parameters)
        results.add(f"rejected: {what}", expected in text, expected if expected in text else text)
    bsdf = mi.load_dict({"type": "brdfc", "filename": file})
    results.add("flags: isotropic", not mi.has_flag(bsdf.flags(), mi.BSDFFlags.Anisotropic), str(bsdf).split("[")[0])
    bsdf = mi.load_dict({"type": "twosided", "bsdf": {"type": "brdfc", "filename": pack("brushed", folder)}})
    results.add("flags: anisotropic, in twosided", mi.has_flag(bsdf.flags(), mi.BSDFFlags.Anisotropic), "")
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]).scale(0.5),
            "film": {"type": "hdrfilm", "width": 8, "height": 8, "rfilter": {"type": "box"}},
        },
        "sphere": {"type": "sphere", "bsdf": {"type": "brdfc", "filename": pack("white", folder)}},
        "light": {"type": "constant"},
    })
    mean = np.array(mi.render(scene, spp=64, seed=1))[..., :3].mean()
    results.add(f"white furnace ({mi.variant()})", abs(mean - 1.0) < 0.02, f"radiance {mean:.4f}, 64 pixels of 64 samples")
    mi.set_variant("scalar_spectral")
    try:
        brdfc_mitsuba.register()
        text = ""
    except ValueError as error:
        text = str(error)
    mi.set_variant("scalar_rgb")
    results.add("rejected: a spectral variant", "found the variant scalar_spectral" in text, text)
