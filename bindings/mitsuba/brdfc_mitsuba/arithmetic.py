"""Arithmetic of the decoders: on Dr.Jit arrays in the variants that have them, otherwise on single numbers."""

import drjit as dr
import mitsuba as mi
import numpy as np

PI = np.float32(np.pi).item()
HALF_PI = np.float32(0.5 * np.pi).item()
TAU = np.float32(2.0 * np.pi).item()
MAX_FLOAT = np.finfo(np.float32).max.item()

# Coefficients of an odd polynomial, minimax on [0, 1], the highest power first, from `formats/src/direction.rs`.
ATAN = (
    -4.0545664e-3,
    2.1862958e-2,
    -5.5912327e-2,
    9.642198e-2,
    -0.1390863,
    0.19946566,
    -0.3332986,
    0.99999934,
)


def is_jit():
    """True if numbers of the current variant are arrays of Dr.Jit."""
    return dr.is_jit_v(mi.Float)


class Buffer:
    """Rows of one or three numbers, or of one integer, accessed by index.

    `rows`: a NumPy array of shape (N,) or (N, 3).
    """

    def __init__(self, rows):
        rows = np.asarray(rows)
        self.colours = rows.ndim == 2
        self.integers = rows.dtype.kind == "u"
        if is_jit():
            self.data = (mi.UInt32 if self.integers else mi.Float)(rows.ravel())
        else:
            self.data = rows.tolist()

    def __getitem__(self, index):
        """Returns a number or a colour; `index` must be within the rows."""
        if not is_jit():
            return mi.Color3f(self.data[index]) if self.colours else self.data[index]
        dtype = mi.Color3f if self.colours else mi.UInt32 if self.integers else mi.Float
        return dr.gather(dtype, self.data, index)


def lower_and_weight(at, count):
    """Node below a position along an axis of `count` nodes, and the weight of the next node; clamped to the edge."""
    at = dr.clip(at, 0.0, float(count - 1))
    lower = dr.minimum(mi.UInt32(at), max(count - 2, 0))
    return lower, at - mi.Float(lower)


def between(a, b, weight):
    """Linear interpolation."""
    return a + weight * (b - a)


def polynomial_atan2(y, x):
    """atan2(y, x) for y >= 0, radians, 0 to π: the polynomial of the decoders, within 3e-7."""
    ax = dr.abs(x)
    steep = y > ax
    small, large = dr.select(steep, ax, y), dr.select(steep, y, ax)
    t = small / dr.select(large > 0.0, large, 1.0)
    t2 = t * t
    p = ATAN[0]
    for c in ATAN[1:]:
        p = p * t2 + c
    angle = p * t
    angle = dr.select(steep, HALF_PI - angle, angle)
    return dr.select(x < 0.0, PI - angle, angle)


def from_log(value, mean, bias):
    """f = μ (exp(v) - ε), from 0 to the largest number."""
    f = mean * (dr.exp(value) - bias)
    return dr.select(f > 0.0, dr.minimum(f, MAX_FLOAT), 0.0)


def safe_direction(v, active):
    """The direction, or the normal where it is inactive, to avoid divisions by 0."""
    return mi.Vector3f(dr.select(active, v.x, 0.0), dr.select(active, v.y, 0.0), dr.select(active, v.z, 1.0))
