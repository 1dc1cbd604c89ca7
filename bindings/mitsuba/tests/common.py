"""Helpers of the checks: the program, packs, directions, a table of results."""

import os
import subprocess
import time

import numpy as np

PROGRAM = os.environ.get("BRDFC", "brdfc")
ROOT = os.environ["ROOT"]
GOLDEN = os.path.join(ROOT, "formats/src")
RED = os.path.join(ROOT, "testdata/demo/red_plastic.binary")

# Name of a pack, its source, options.
PACKS = {
    "plastic": (RED, []),
    "brushed": ("synth:ward?kd=0.2&ax=0.1&ay=0.4", ["--codec", "table"]),
    "factored": ("synth:ggx?kd=0.1&alpha=0.05", ["--codec", "factored", "--levels", "2"]),
    "satin": ("synth:ggx?alpha=0.4", ["--codec", "wavelet", "--ratio", "16", "--bits", "12"]),
    "white": ("synth:lambert?kd=1", []),
    "grey": ("synth:lambert?kd=0.95", []),
}


class Results:
    """Table of results."""

    def __init__(self):
        self.failed, self.skipped, self.passed = [], [], 0
        self.start = time.perf_counter()

    def add(self, what, passed, figure):
        print(f"{'ok' if passed else 'FAILED':7} {what:58} {figure}", flush=True)
        if passed:
            self.passed += 1
        else:
            self.failed.append(what)

    def skip(self, what, why):
        print(f"skipped {what}: {why}", flush=True)
        self.skipped.append(what)

    def finish(self):
        seconds = time.perf_counter() - self.start
        print(f"{self.passed} passed, {len(self.failed)} failed, {len(self.skipped)} skipped, in {seconds:.0f} s")
        return 1 if self.failed else 0


def run(*arguments):
    """Runs the program, and returns its output."""
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"brdfc {' '.join(arguments)}: {done.stderr}")
    return done.stdout


def pack(name, folder):
    """Returns the file of one of PACKS, which is made if it does not exist."""
    source, options = PACKS[name]
    path = os.path.join(folder, f"{name}.ktx2")
    if not os.path.exists(path):
        run("encode", source, "-o", path, "--quiet", *options)
    return path


def directions(random, count):
    """Unit vectors above the horizon and a few below, a third of them within 6 degrees of it; float32."""
    z = np.where(random.random(count) < 0.33, random.uniform(-0.01, 0.1, count), random.random(count))
    phi = random.uniform(-np.pi, np.pi, count)
    sine = np.sqrt(1.0 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1).astype(np.float32)


def pairs(random, count, mirror):
    """Directions to light and viewer; if `mirror`, a quarter are close to mirror directions, a few exactly."""
    wi, wo = directions(random, count), directions(random, count)
    quarter = count // 4 if mirror else 0
    spread = np.geomspace(1e-6, 0.2, quarter)[:, None] * random.normal(size=(quarter, 3))
    wo[:quarter] = wi[:quarter] * [-1.0, -1.0, 1.0] + spread
    wo[:quarter] /= np.linalg.norm(wo[:quarter], axis=1, keepdims=True)
    exact = quarter // 10
    wo[:exact] = wi[:exact] * np.float32([-1.0, -1.0, 1.0])
    wo[exact : 2 * exact] = wi[exact : 2 * exact]
    return as_read(wi), as_read(wo)


def as_read(v):
    """Directions that reading does not change, although it normalises them in double precision."""
    for _ in range(8):
        double = v.astype(np.float64)
        v = (double / np.linalg.norm(double, axis=1, keepdims=True)).astype(np.float32)
    return v
