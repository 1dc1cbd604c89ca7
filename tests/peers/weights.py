"""Prints the weights of a Neural BRDF (Sztrajman et al. 2021) as little-endian 32-bit floats, for 'brdfc-bench --study codecs'.

usage: weights.py FILE.h5

The file has a Keras network of three dense layers. For each layer in order: its matrix, a row for each input, then its biases.
"""

import sys

import h5py
import numpy

SHAPES = [(6, 21), (21, 21), (21, 3)]


def number(layer):
    """Number of a layer that Keras named dense_N."""
    return int(layer.removeprefix("dense").lstrip("_") or 0)


with h5py.File(sys.argv[1], "r") as network:
    layers = sorted((name for name in network if name.startswith("dense")), key=number)
    shapes = [network[f"{layer}/{layer}/kernel:0"].shape for layer in layers]
    if shapes != SHAPES:
        sys.exit(f"found layers of {shapes}, expected {SHAPES}")
    for layer in layers:
        for part in ("kernel", "bias"):
            weights = network[f"{layer}/{layer}/{part}:0"][:]
            sys.stdout.buffer.write(numpy.ascontiguousarray(weights, dtype="<f4").tobytes())
