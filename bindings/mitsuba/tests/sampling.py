"""The plugin's sampling: chi-square tests, white furnace, variance compared with plain cosine sampling."""

import os
import time

import drjit as dr
import mitsuba as mi
import numpy as np

from common import GOLDEN, pack

# Polar angles of incoming directions, degrees; azimuth 30 degrees.
ANGLES = (0.0, 30.0, 60.0, 80.0, 87.0)
AZIMUTH = np.radians(30.0)
# Packs of each form; the last one covers only some directions, and its texels are arbitrary.
CROPPED = os.path.join(GOLDEN, "table/golden/any-texels-symmetry-13-layers-3-cropped.ktx2")
TESTED = ("plastic", "brushed", "factored", "satin", "cropped")
# Probability that a correct density fails one of the tests.
SIGNIFICANCE = 0.01
SAMPLES = 1_000_000


def direction(angle):
    theta = np.radians(angle)
    return mi.Vector3f(np.array([np.sin(theta) * np.cos(AZIMUTH), np.sin(theta) * np.sin(AZIMUTH), np.cos(theta)]))


def chi_square(file, angle, wrong=False):
    """Tests whether samples follow `pdf`; returns the result and the p-value. `wrong`: the density of another direction."""
    parameter = f'<string name="filename" value="{file}"/>'
    sample, _ = mi.chi2.BSDFAdapter("brdfc", parameter, wi=direction(angle))
    _, pdf = mi.chi2.BSDFAdapter("brdfc", parameter, wi=direction(angle + 1.5 if wrong else angle))
    test = mi.chi2.ChiSquareTest(
        domain=mi.chi2.SphericalDomain(),
        sample_func=sample,
        pdf_func=pdf,
        sample_dim=3,
        sample_count=SAMPLES,
        res=151,
        # Narrow lobes occupy a few cells at the pole: with 16 steps per cell their integrals are inaccurate.
        ires=64,
    )
    # As many tests as there are angles and packs.
    passed = test.run(SIGNIFICANCE, test_count=len(TESTED) * len(ANGLES), quiet=True)
    return passed, test.p_value


def check_densities(results, folder):
    for name in TESTED:
        file = CROPPED if name == "cropped" else pack(name, folder)
        found = [chi_square(file, angle) for angle in ANGLES]
        values = ", ".join(f"{p:.2f}" for _, p in found)
        angles = ", ".join(f"{angle:g}" for angle in ANGLES)
        results.add(f"chi-square, {name} at {angles}°", all(passed for passed, _ in found), f"p = {values}")
    passed, p = chi_square(pack("brushed", folder), 60.0, wrong=True)
    results.add("chi-square: the density of 61.5° is detected at 60°", not passed, f"p = {p:.1e}")


def furnace(file, seed):
    """Mean radiance of a sphere under uniform light of radiance 1, and its standard error."""
    scene = mi.load_dict({
        "type": "scene",
        "integrator": {"type": "path", "max_depth": 2},
        "sensor": {
            "type": "orthographic",
            "to_world": mi.ScalarTransform4f().look_at([0, 0, 4], [0, 0, 0], [0, 1, 0]),
            "film": {"type": "hdrfilm", "width": 64, "height": 64, "rfilter": {"type": "box"}},
        },
        "sphere": {"type": "sphere", "radius": 1.0, "bsdf": {"type": "brdfc", "filename": file}},
        "light": {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}},
    })
    image = np.array(mi.render(scene, spp=256, seed=seed))[..., :3]
    x = (np.arange(64) + 0.5) / 32.0 - 1.0
    inside = np.hypot(*np.meshgrid(x, x)) < 0.95
    pixels = image[inside].mean(axis=1)
    return pixels.mean(), pixels.std() / np.sqrt(len(pixels))


def check_furnace(results, folder):
    """A white matte surface reflects all light; one with an albedo of 95 % does not."""
    for name, white in (("white", True), ("grey", False)):
        mean, error = furnace(pack(name, folder), seed=3)
        # A thousandth, for the rounding of texels and of directions in single precision.
        is_white = abs(mean - 1.0) < 4.0 * error + 1e-3
        what = "white furnace, albedo 1" if white else "white furnace: albedo 0.95 is detected"
        results.add(what, is_white == white, f"radiance {mean:.5f}, standard error {error:.1e}")


def estimates(bsdf, angle, count, seed):
    """Radiance of each sample towards a viewer at `angle` under radiance 1, averaged over the channels."""
    interaction = dr.zeros(mi.SurfaceInteraction3f, count)
    interaction.wi = direction(angle)
    sampler = mi.PCG32(size=count, initstate=seed)
    numbers = mi.Point2f(sampler.next_float32(), sampler.next_float32())
    _, value = bsdf.sample(mi.BSDFContext(), interaction, sampler.next_float32(), numbers)
    return np.array(value).mean(axis=0).astype(np.float64)


def check_variance(results, folder):
    """Compares the plugin's samples with cosine samples: equal means, and the ratio of the variances."""
    from brdfc_mitsuba.bsdf import pack_bsdf

    class CosineBSDF(pack_bsdf()):
        cosine_share = 1.0

    mi.register_bsdf("brdfc_cosine", CosineBSDF)
    for name in ("plastic", "brushed", "factored", "satin"):
        ratios, distances = [], []
        for angle in ANGLES[:4]:
            found = [
                estimates(mi.load_dict({"type": kind, "filename": pack(name, folder)}), angle, SAMPLES, seed)
                for seed, kind in enumerate(("brdfc", "brdfc_cosine"))
            ]
            variances = [values.var() for values in found]
            distances.append(abs(found[0].mean() - found[1].mean()) / np.sqrt(sum(variances) / SAMPLES))
            ratios.append(variances[1] / variances[0])
        figure = f"{' '.join(f'{ratio:.3g}' for ratio in ratios)} times; means within {max(distances):.1f} standard errors"
        passed = max(distances) < 4.5 and min(ratios) > 1.0
        results.add(f"variance of cosine samples, {name} at 0, 30, 60, 80°", passed, figure)


def check_speed(results, folder):
    """Time for values and densities of many pairs, in one compiled kernel."""
    for name in ("plastic", "brushed", "satin"):
        bsdf = mi.load_dict({"type": "brdfc", "filename": pack(name, folder)})
        fastest = 0.0
        for seed in range(3):
            interaction = dr.zeros(mi.SurfaceInteraction3f, SAMPLES)
            sampler = mi.PCG32(size=SAMPLES, initstate=seed)
            drawn = [mi.Point2f(sampler.next_float32(), sampler.next_float32()) for _ in range(2)]
            interaction.wi, wo = (mi.warp.square_to_uniform_hemisphere(point) for point in drawn)
            dr.eval(interaction, wo)
            dr.sync_thread()
            start = time.perf_counter()
            dr.eval(*bsdf.eval_pdf(mi.BSDFContext(), interaction, wo))
            dr.sync_thread()
            fastest = max(fastest, SAMPLES / (time.perf_counter() - start))
        results.add(f"speed of {name}, {os.cpu_count()} threads", True, f"{fastest / 1e6:.1f} million values and densities/s")


def check(results, folder):
    """Adds all lines."""
    check_densities(results, folder)
    check_furnace(results, folder)
    check_variance(results, folder)
    check_speed(results, folder)
