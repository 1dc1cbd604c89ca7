"""Output of 'brdfc convert' for Mitsuba 3, evaluated by Mitsuba's own 'measured' and by this program.

Prints a line for each material, and exits with 1 where both readers differ by more than 1e-4 of a value, or a material by more
than its bound from its source. Needs the packages 'mitsuba' and 'numpy'; BRDFC names the program.
"""

import csv
import io
import os
import subprocess
import sys
import tempfile

import mitsuba as mi
import numpy as np

PROGRAM = os.environ.get("BRDFC", "target/release/brdfc")
PAIRS = 2000
# Maximum mean error relative to the value plus 0.001 1/sr, up to 85 degrees.
MATERIALS = {
    "synth:lambert?kd=0.5": 0.02,
    "synth:ggx?kd=0.2&alpha=0.3": 0.02,
    "synth:ward?kd=0.2&ax=0.1&ay=0.4": 0.1,
    "testdata/demo/red_plastic.binary": 0.02,
}

mi.set_variant("scalar_rgb")


def directions(random, count):
    theta = np.radians(85.0) * np.sqrt(random.random(count))
    phi = 2.0 * np.pi * random.random(count)
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], axis=1)


def evaluated(source, pairs):
    run = subprocess.run([PROGRAM, "eval", source, "--directions", pairs], check=True, capture_output=True, text=True)
    rows = list(csv.reader(io.StringIO(run.stdout)))[1:]
    return np.array([[float(number) for number in row[-3:]] for row in rows])


def by_mitsuba(file, incoming, outgoing):
    bsdf, context = mi.load_dict({"type": "measured", "filename": file}), mi.BSDFContext()
    values = []
    for wi, wo in zip(incoming, outgoing):
        interaction = mi.SurfaceInteraction3f()
        interaction.wi = mi.Vector3f(*wi)
        value = bsdf.eval(context, interaction, mi.Vector3f(*wo))
        # Its values include the cosine.
        values.append([value[k] / wo[2] for k in range(3)])
    return np.array(values)


def main():
    random = np.random.default_rng(3)
    incoming, outgoing = directions(random, PAIRS), directions(random, PAIRS)
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        pairs, file = os.path.join(folder, "pairs.csv"), os.path.join(folder, "material.bsdf")
        header = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z"
        np.savetxt(pairs, np.hstack([incoming, outgoing]), fmt="%.9f", delimiter=",", header=header, comments="")
        for material, bound in MATERIALS.items():
            subprocess.run([PROGRAM, "convert", material, "-o", file], check=True, stdout=subprocess.DEVNULL)
            found, ours, source = by_mitsuba(file, incoming, outgoing), evaluated(file, pairs), evaluated(material, pairs)
            readers = (np.abs(found - ours) / (np.abs(ours) + 1e-3)).max()
            error = (np.abs(found - source) / (np.abs(source) + 1e-3)).mean()
            print(f"{material}: readers differ by {readers:.1e} at most, Mitsuba and the source by {error:.2%} in the mean")
            failed |= readers > 1e-4 or error > bound
    sys.exit(1 if failed else 0)


main()
